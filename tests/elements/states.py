"""Random states of an element: its numbers, its bodies' coordinates and the operands of its operators.

`WHOLE` and `FRACTIONS` are exact: `difference` of a polynomial kernel has no error at all. `DIGITS` is 70-digit
arithmetic for elements with roots and angles, `COMPLEX` the same derivatives by a complex step, fast.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from typing import Any

import mpmath
import numpy as np
from tests.paper.paper import unit

from sarrus import functions
from sarrus._jit.formulas.expression import Graph
from sarrus._jit.formulas.program import program
from sarrus.elements import OPERATORS
from sarrus.elements.derived import derived
from sarrus.elements.evaluation import dense, element_from, grid
from sarrus.elements.operators import DERIVATIVES, Axis

from_numpy = mpmath.mp.npconvert


def from_scalar(x: Any) -> Any:
    """A number of NumPy. Of an array, which it multiplies entry by entry, mpmath's error would print all digits."""
    if isinstance(x, np.ndarray) and x.ndim:
        raise TypeError
    return from_numpy(x)


mpmath.mp.npconvert = from_scalar

WHOLE, FRACTIONS, DIGITS, COMPLEX = "whole numbers", "fractions", "70 digits", "complex step"
TOLERANCE = {
    DIGITS: mpmath.mpf(10) ** -36,
    COMPLEX: 1e-9,
}  # a difference with a step of 1e-12 keeps 48 of 70 digits
STEP = {WHOLE: 1, FRACTIONS: 1, DIGITS: mpmath.mpf(10) ** -12, COMPLEX: 1e-200}
HIGH_DEGREE = ("DisplacementInertia",)  # polynomials above the fourth degree: differences are not exact
POLYNOMIAL = {"constant", "input", "add", "sub", "mul", "neg"}
BODY = ("q", "xi", "eta", "v", "a")
POSITIVE = ("width", "creep", "stribeck")  # fields that a model holds positive
FIXED = ("Curve", "Surface", "Memory")  # fields that no operator differentiates by
# Three curves of two cubics: count, knots, coefficients. The pieces need not even meet.
CURVES = (
    2,
    -1,
    1,
    3,
    1,
    -2,
    4,
    3,
    2,
    1,
    -3,
    5,
    2,
    -1,
    1,
    3,
    2,
    3,
    -1,
    4,
    1,
    5,
    2,
    1,
    2,
    -1,
    1,
    3,
    3,
    1,
    5,
    2,
    4,
    1,
    6,
    7,
)


def _law(x):
    return (
        functions.exp(functions.sin(x))
        + x * x / (2 + functions.cos(x))
        - functions.sqrt(3 + functions.tanh(x))
    )


FORMULA = program(_law)  # stored behind the curves, for fields of the name "formula"
# A surface of 2 x 2 cells, stored behind the formula: counts, knots, which are off all places of states and exact in
# floats, and numbers of nodes
SURFACE = (3, 3, -1.25, 0.125, 1.875, -1.375, 0.25, 1.625, *((7 * n % 11) - 5 for n in range(36)))


@dataclass(frozen=True)
class State:
    """A state of one element; `store` holds its curves and surfaces."""

    kind: Any
    arithmetic: str
    operands: dict[str, Any]
    numbers: Any
    store: Any

    @property
    def element(self):
        return element_from(self.kind, self.numbers, self.store, self.operands["t"])

    def moved(self, by, step):
        """The state with the operand `by` (or the numbers, "b") moved."""
        if by == "b":
            numbers = np.array(self.numbers + step, dtype=object if self.arithmetic == COMPLEX else None)
            numbers[fixed(self.kind)] = self.numbers[fixed(self.kind)]
            return replace(self, numbers=numbers)
        return replace(self, operands={**self.operands, by: self.operands[by] + step})

    def __call__(self, name):
        """The dense value of an operator."""
        return dense(self.element, OPERATORS[name], self.operands)

    def direction(self, by, seed=0):
        """A random direction in which `by` may move."""
        random = np.random.default_rng(900 + seed)
        if by == "t":
            return _convert(random, 1, self.arithmetic)[0]
        result = _convert(random, len(self.numbers if by == "b" else self.operands[by]), self.arithmetic)
        if by == "b":
            result[fixed(self.kind)] = 0
        return result

    def difference(self, f, by, direction):
        """Derivative of f(state) along a direction. Exact in exact numbers, for degrees up to four."""
        h = STEP[self.arithmetic]
        if self.arithmetic == COMPLEX:
            there = f(self.moved(by, direction * (1j * h)))
            return np.array([complex(x).imag for x in np.ravel(there)]).reshape(np.shape(there)) / h
        steps = (-2, -1, 1, 2)
        at = {k: np.asarray(f(self.moved(by, k * h * direction)), dtype=object) for k in steps}
        change = 8 * (at[1] - at[-1]) - (at[2] - at[-2])
        if self.arithmetic == DIGITS:
            return change / (12 * h)
        return change * Fraction(1, 12)

    def same(self, first, second):
        """Where two results agree: exactly, or to the tolerance of the arithmetic."""
        first, second = np.asarray(first, dtype=object), np.asarray(second, dtype=object)
        if self.arithmetic not in TOLERANCE:
            return first == second
        size = 1 + max(np.max(abs(first), initial=0), np.max(abs(second), initial=0))
        return abs(first - second) <= TOLERANCE[self.arithmetic] * size


def _convert(random, count, arithmetic):
    whole = random.integers(1, 10, count) * random.choice([-1, 1], count)
    if arithmetic == FRACTIONS:
        return np.array([Fraction(int(n), 7) for n in whole], dtype=object)
    if arithmetic == DIGITS:
        return np.array([mpmath.mpf(int(n)) / 7 for n in whole], dtype=object)
    return whole if arithmetic == WHOLE else whole / 7.0


@cache
def is_polynomial(kind):
    """Whether an element's first operators only add, subtract and multiply, to a low degree; then all others do."""
    return computes_polynomials(kind, [one for one in kind.family if one.name not in DERIVATIVES])


def written(kind):
    """The operators whose kernels are written by hand; the others are generated from these."""
    return [one for one in kind.family if getattr(kind, one.name).__module__ != derived.__module__]


def computes_polynomials(kind, operators):
    """Whether kernels of an element only add, subtract and multiply, as seen in recordings, to a low degree."""
    graph = Graph()
    operands = {name: graph.inputs(name, 7 * kind.bodies) for name in BODY}
    operands |= {"lam": graph.inputs("lam", kind.rows), "t": graph.input("t")}
    element = element_from(kind, graph.inputs("numbers", kind.size()), t=operands["t"])
    for operator in operators:
        grid(element, operator, operands)
    return {node.op for node in graph.nodes} <= POLYNOMIAL and kind.__name__ not in HIGH_DEGREE


@cache
def names(kind):
    """For every number of an element: the name of its field."""
    return [n for n, w in zip(kind.fields, kind.widths(), strict=True) for _ in range(w)]


@cache
def fields(kind):
    """For every number of an element: what kind of field it belongs to."""
    pairs = zip(kind.fields.values(), kind.widths(), strict=True)
    return np.array([field for field, width in pairs for _ in range(width)], dtype=object)


def fixed(kind):
    """Places of the numbers that no operator differentiates by."""
    return np.flatnonzero(np.isin(fields(kind), FIXED))


def state(kind, arithmetic, seed=0):
    """A random state, off |p| = 1."""
    random = np.random.default_rng(seed)
    operands = {name: _convert(random, 7 * kind.bodies, arithmetic) for name in BODY}
    operands["lam"], operands["t"] = (_convert(random, n, arithmetic) for n in (kind.rows, 1))
    operands["t"] = operands["t"][0]
    if arithmetic in (DIGITS, COMPLEX):
        operands["t"] = operands["t"] * 11 / 10  # on no knot of a curve, whose pieces need not meet
    numbers = _convert(random, kind.size(), arithmetic)
    curves = np.flatnonzero(fields(kind) == "Curve")
    curved = [name for name, field in kind.fields.items() if field == "Curve"]
    for n, (place, name) in enumerate(zip(curves, curved, strict=True)):
        numbers[place] = len(CURVES) if name == "formula" else len(CURVES) // 3 * n
    numbers[fields(kind) == "Surface"] = len(CURVES) + len(FORMULA)
    for n, field in enumerate(names(kind)):
        if field in POSITIVE:
            numbers[n] = abs(numbers[n])
        if field == "exponent":
            numbers[n] = 1 + abs(numbers[n])
    return State(kind, arithmetic, operands, numbers, (*CURVES, *FORMULA, *SURFACE))


def on_sphere(of):
    """The state with unit Euler parameters and tangent velocities (in fractions or 70 digits)."""
    q, v = of.operands["q"].copy(), of.operands["v"].copy()
    for body in range(of.kind.bodies):
        at = slice(7 * body + 3, 7 * body + 7)
        q[at] = p = converted(unit(40 + body), of.arithmetic)
        v[at] = v[at] - (v[at] @ p) * p
    return replace(of, operands={**of.operands, "q": q, "v": v})


def converted(exact, arithmetic):
    """An array of fractions in the arithmetic of a state."""
    if arithmetic == FRACTIONS:
        return exact
    return np.array([mpmath.mpf(x.numerator) / x.denominator for x in exact], dtype=object)


def name_entry(kind, operator, place):
    """The entry of an operator's result at a place, in words."""
    labels = {Axis.ROWS: [f"row {n}" for n in range(kind.rows)]}
    suffixes = {1: ("",), 2: ("_i", "_j")}.get(kind.bodies, [f"_{n + 1}" for n in range(kind.bodies)])
    parts = [block + suffix for suffix in suffixes for block in "rrrpppp"]
    labels[Axis.COORDINATES] = parts
    labels[Axis.PARAMETERS] = names(kind)
    return ", ".join(labels[axis][k] for axis, k in zip(operator.axes, place, strict=True))
