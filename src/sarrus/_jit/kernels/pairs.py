"""Arithmetic on a real number and a complex one side by side, for compiled loops.

Every entry of an array is four numbers: the real one, the parts of the complex one, and a zero that completes the
register. A product with ``u`` takes two products of registers: ``straight(u)`` has the numbers that act on their own
places, ``crossed(u)`` the imaginary part, which acts on exchanged ones. They are fused with their sum where the
processor can.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import models, register_model

from .lanes import FUSED, emitted
from .vector import INT, Vector

VECTOR = Vector(4)


class PairType(types.Type):
    """A real number and a complex one."""

    def __init__(self) -> None:
        super().__init__(name="pair")


KIND = PairType()


@register_model(PairType)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, VECTOR.kind)  # type: ignore[no-untyped-call]


def _at(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """Pointer to the entry of an array that the first two arguments name."""
    data = context.make_array(signature.args[0])(context, builder, args[0]).data
    return builder.gep(VECTOR.pointer(builder, data), [args[1]])


def _exchanged(builder: Any, x: Any) -> Any:
    """Real and imaginary part of the complex number exchanged."""
    return VECTOR.shuffle(builder, x, x, [0, 2, 1, 3])


@emitted
def load_pair(typingctx: Any, array: Any, k: Any) -> Any:
    """Entry k of an array."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return VECTOR.load(builder, _at(context, builder, signature, args))

    return KIND(array, k), codegen


@emitted
def store_pair(typingctx: Any, array: Any, k: Any, x: Any) -> Any:
    """Write entry k of an array."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        VECTOR.store(builder, args[2], _at(context, builder, signature, args))
        return context.get_dummy_value()

    return types.void(array, k, x), codegen


@emitted
def pair(typingctx: Any, real: Any, re: Any, im: Any) -> Any:
    """A real number, and a complex one by its parts."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        made = VECTOR.constant(0.0)
        for place, value in enumerate(args):
            made = builder.insert_element(made, value, INT(place))
        return made

    return KIND(types.float64, types.float64, types.float64), codegen


@emitted
def straight(typingctx: Any, u: Any) -> Any:
    """The real number, and twice the real part."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return VECTOR.shuffle(builder, args[0], args[0], [0, 1, 1, 3])

    return KIND(u), codegen


@emitted
def crossed(typingctx: Any, u: Any) -> Any:
    """Zero, and the imaginary part with both signs."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        imaginary = VECTOR.shuffle(builder, args[0], args[0], [2, 2, 2, 2])
        return builder.fmul(imaginary, ir.Constant(VECTOR.kind, [0.0, -1.0, 1.0, 0.0]))

    return KIND(u), codegen


@emitted
def minus_pair(typingctx: Any, x: Any, a: Any, along: Any, across: Any) -> Any:
    """x - a u, with the two parts of u."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        x, a, along, across = args
        x = builder.fsub(x, builder.fmul(a, along, flags=FUSED), flags=FUSED)
        return builder.fsub(x, builder.fmul(_exchanged(builder, a), across, flags=FUSED), flags=FUSED)

    return KIND(x, a, along, across), codegen


@emitted
def pair_product(typingctx: Any, a: Any, along: Any, across: Any) -> Any:
    """a u, with the two parts of u."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        a, along, across = args
        crosswise = builder.fmul(_exchanged(builder, a), across, flags=FUSED)
        return builder.fadd(builder.fmul(a, along, flags=FUSED), crosswise, flags=FUSED)

    return KIND(a, along, across), codegen


@emitted
def plus_multiple(typingctx: Any, x: Any, weight: Any, number: Any) -> Any:
    """x plus a pair times a number."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        x, weight, number = args
        multiple = builder.fmul(weight, VECTOR.fill(builder, number), flags=FUSED)
        return builder.fadd(x, multiple, flags=FUSED)

    return KIND(x, weight, types.float64), codegen
