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

from .lanes import FUSED, RegisterType, arithmetic, emitted, minus, plus
from .vector import INT, Vector

VECTOR = Vector(4)
KIND = RegisterType("pair", VECTOR)
SIGNS = ir.Constant(VECTOR.kind, [0.0, -1.0, 1.0, 0.0])


def _at(context: Any, builder: Any, signature: Any, args: Any, size: int) -> Any:
    """Pointer to the entry, of some numbers, of an array that the first two arguments name."""
    data = context.make_array(signature.args[0])(context, builder, args[0]).data
    return VECTOR.pointer(builder, builder.gep(data, [builder.mul(args[1], INT(size))]))


def _loading(size: int) -> Any:
    """Code for the entry, of some numbers, of an array."""
    return lambda target, builder, kinds, args: VECTOR.load(builder, _at(target, builder, kinds, args, size))


def _exchanged(builder: Any, x: Any) -> Any:
    """Real and imaginary part of the complex number exchanged."""
    return VECTOR.shuffle(builder, x, x, [0, 2, 1, 3])


@emitted
def load_pair(typingctx: Any, array: Any, k: Any) -> Any:
    """Entry k of an array."""
    return KIND(array, k), _loading(4)


@emitted
def load_triple(typingctx: Any, array: Any, k: Any) -> Any:
    """Entry k of an array of three numbers each, with the number behind it in place of the zero."""
    return KIND(array, k), _loading(3)


@emitted
def store_pair(typingctx: Any, array: Any, k: Any, x: Any) -> Any:
    """Write entry k of an array."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        VECTOR.store(builder, args[2], _at(context, builder, signature, args, 4))
        return context.get_dummy_value()

    return types.void(array, k, x), codegen


@emitted
def pair(typingctx: Any, real: Any, re: Any, im: Any) -> Any:
    """A real number, and a complex one by its parts."""

    def codegen(builder: Any, *parts: Any) -> Any:
        made = VECTOR.constant(0.0)
        for place, value in enumerate(parts):
            made = builder.insert_element(made, value, INT(place))
        return made

    return KIND(types.float64, types.float64, types.float64), arithmetic(codegen)


@emitted
def straight(typingctx: Any, u: Any) -> Any:
    """The real number, and twice the real part."""
    return KIND(u), arithmetic(lambda builder, u: VECTOR.shuffle(builder, u, u, [0, 1, 1, 3]))


@emitted
def crossed(typingctx: Any, u: Any) -> Any:
    """Zero, and the imaginary part with both signs."""
    return KIND(u), arithmetic(lambda builder, u: builder.fmul(VECTOR.shuffle(builder, u, u, 4 * [2]), SIGNS))


@emitted
def exchanged(typingctx: Any, x: Any) -> Any:
    """Real and imaginary part of the complex number exchanged."""
    return KIND(x), arithmetic(_exchanged)


@emitted
def minus_parts(typingctx: Any, x: Any, a: Any, b: Any) -> Any:
    """x minus the products of numbers in the same places."""
    return KIND(x, a, b), arithmetic(minus)


@emitted
def plus_parts(typingctx: Any, x: Any, equal: Any, unequal: Any) -> Any:
    """x plus a product of pairs, by the products of equal parts, and of the real with the imaginary one."""

    def codegen(builder: Any, x: Any, equal: Any, unequal: Any) -> Any:
        first, second = (VECTOR.shuffle(builder, equal, unequal, n) for n in ([0, 1, 5, 3], [3, 2, 6, 3]))
        return builder.fadd(x, builder.fadd(first, builder.fmul(second, SIGNS)))

    return KIND(x, equal, unequal), arithmetic(codegen)


@emitted
def minus_pair(typingctx: Any, x: Any, a: Any, along: Any, across: Any) -> Any:
    """x - a u, with the two parts of u."""

    return KIND(x, a, along, across), arithmetic(
        lambda builder, x, a, u, v: minus(builder, minus(builder, x, a, u), _exchanged(builder, a), v)
    )


@emitted
def pair_product(typingctx: Any, a: Any, along: Any, across: Any) -> Any:
    """a u, with the two parts of u."""

    return KIND(a, along, across), arithmetic(
        lambda builder, a, u, v: plus(builder, builder.fmul(a, u, flags=FUSED), _exchanged(builder, a), v)
    )


@emitted
def plus_multiple(typingctx: Any, x: Any, weight: Any, number: Any) -> Any:
    """x plus a pair times a number."""
    return KIND(x, weight, types.float64), arithmetic(
        lambda builder, x, weight, number: plus(builder, x, weight, VECTOR.fill(builder, number))
    )
