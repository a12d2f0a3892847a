"""Arithmetic on numbers side by side, for compiled loops: arrays hold, for every entry, one number for each lane.

``load(array, k)`` is entry k of all lanes, ``store(array, k, x)`` writes it; products are fused with their sum where
the processor can.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import types
from numba.extending import intrinsic, models, register_model

from .vector import INT, LANES, Vector

VECTOR = Vector(LANES)
FUSED = ("contract",)


def emitted(function: Callable[..., Any]) -> Any:
    """A compiled function whose code `function` emits; its arguments are those without the typing context."""
    return intrinsic(function)


class RegisterType(types.Type):
    """Numbers of one register."""

    def __init__(self, name: str, vector: Vector) -> None:
        super().__init__(name=name)
        self.vector = vector


@register_model(RegisterType)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, kind.vector.kind)  # type: ignore[no-untyped-call]


KIND = RegisterType(f"lanes{LANES}", VECTOR)


def _at(context: Any, builder: Any, signature: Any, args: Any, n: int, k: Any) -> Any:
    """Pointer to entry k of argument n."""
    data = context.make_array(signature.args[n])(context, builder, args[n]).data
    return builder.gep(VECTOR.pointer(builder, data), [k])


def arithmetic(emit: Callable[..., Any]) -> Callable[..., Any]:
    """Code for a function of registers that gives one."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return emit(builder, *args)

    return codegen


def plus(builder: Any, x: Any, a: Any, b: Any) -> Any:
    """x plus the products of numbers in the same places."""
    return builder.fadd(x, builder.fmul(a, b, flags=FUSED), flags=FUSED)


def minus(builder: Any, x: Any, a: Any, b: Any) -> Any:
    """x minus the products of numbers in the same places."""
    return builder.fsub(x, builder.fmul(a, b, flags=FUSED), flags=FUSED)


@emitted
def load(typingctx: Any, array: Any, k: Any) -> Any:
    """Entry k of an array."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return VECTOR.load(builder, _at(context, builder, signature, args, 0, args[1]))

    return KIND(array, k), codegen


@emitted
def store(typingctx: Any, array: Any, k: Any, x: Any) -> Any:
    """Write entry k of an array."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        VECTOR.store(builder, args[2], _at(context, builder, signature, args, 0, args[1]))
        return context.get_dummy_value()

    return types.void(array, k, x), codegen


@emitted
def fill(typingctx: Any, x: Any) -> Any:
    """A number in all lanes."""
    return KIND(types.float64), arithmetic(VECTOR.fill)


@emitted
def plus_product(typingctx: Any, x: Any, a: Any, b: Any) -> Any:
    """x + a b."""
    return KIND(x, a, b), arithmetic(plus)


@emitted
def minus_product(typingctx: Any, x: Any, a: Any, b: Any) -> Any:
    """x - a b."""
    return KIND(x, a, b), arithmetic(minus)


@emitted
def product(typingctx: Any, a: Any, b: Any) -> Any:
    """a b."""
    return KIND(a, b), arithmetic(lambda builder, a, b: builder.fmul(a, b))


@emitted
def ratio(typingctx: Any, a: Any, b: Any) -> Any:
    """a / b."""
    return KIND(a, b), arithmetic(lambda builder, a, b: builder.fdiv(a, b))


@emitted
def turn(typingctx: Any, source: Any, k: Any, target: Any, stride: Any) -> Any:
    """Write one vector of entries per lane, from k on, to ``target[lane * stride + k]``."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        first = _at(context, builder, signature, args, 0, args[1])
        rows = [VECTOR.load(builder, builder.gep(first, [INT(n)])) for n in range(LANES)]
        data = context.make_array(signature.args[2])(context, builder, args[2]).data
        for lane, row in enumerate(VECTOR.transposed(builder, rows)):
            at = builder.gep(data, [builder.add(args[1], builder.mul(args[3], INT(lane)))])
            VECTOR.store(builder, row, VECTOR.pointer(builder, at))
        return context.get_dummy_value()

    return types.void(source, k, target, stride), codegen
