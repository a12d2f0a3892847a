"""The coefficients of a method for one step size, and its affine maps: see `methods.program`."""

from __future__ import annotations

import math

from ...._jit.formulas.curves import (
    ACOS,
    ADD,
    ASIN,
    ATAN,
    CONSTANT,
    COS,
    DIV,
    EXP,
    INPUT,
    LOG,
    MUL,
    NEG,
    POSITIVE,
    SIN,
    SQRT,
    SUB,
    TAN,
)
from ...._jit.linking.link import compiled
from ....algebra import Array
from ..methods.program import Program
from .records import State


@compiled
def formula(code: int, x: float, y: float) -> float:
    """One operation of a formula."""
    if code == ADD:
        return x + y
    if code == SUB:
        return x - y
    if code == MUL:
        return x * y
    if code == DIV:
        return x / y
    if code == NEG:
        return -x
    if code == POSITIVE:
        return 1.0 if x > 0.0 else 0.0
    return elementary(code, x)


@compiled
def elementary(code: int, x: float) -> float:
    """A function of one number."""
    if code == SQRT:
        return math.sqrt(x)
    if code == SIN:
        return math.sin(x)
    if code == COS:
        return math.cos(x)
    if code == TAN:
        return math.tan(x)
    if code == ASIN:
        return math.asin(x)
    if code == ACOS:
        return math.acos(x)
    if code == ATAN:
        return math.atan(x)
    if code == EXP:
        return math.exp(x)
    if code == LOG:
        return math.log(x)
    return math.tanh(x)


@compiled
def coefficients(program: Program, h: float, ratio: float, r: Array) -> None:
    """All coefficients for a step size and its ratio to the one before."""
    for n in range(len(program.tape)):
        code, i, j = program.tape[n, 0], program.tape[n, 1], program.tape[n, 2]
        if code == CONSTANT:
            r[n] = program.constants[n]
        elif code == INPUT:
            r[n] = ratio if i == 1 else h
        else:
            r[n] = formula(code, r[i], r[j])


@compiled
def apply(program: Program, which: int, state: State) -> None:
    """One of the affine maps."""
    x, terms = state.x, program.terms
    for n in range(program.bounds[which], program.bounds[which + 1]):
        to, of, count, base, factor = terms[n, 0], terms[n, 1], terms[n, 2], terms[n, 4], state.r[terms[n, 3]]
        target, source, first = x[to : to + count], x[of : of + count], x[base : base + count]
        for k in range(len(target)):
            target[k] = first[k] + factor * source[k]
