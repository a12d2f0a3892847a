"""A curve through a table of points: the nonlinear law of a spring, a damper or an actuator."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from inspect import signature
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np

from ..._jit.formulas.program import program
from ..arithmetic import Numeric
from ..checks.arguments import checked
from ..errors import ModelError, restated
from ..expression import Expression, Name, Number
from ..quantity import ROUND_OFF, is_list, numbers
from ..show import show
from ..tape import Tracer, value_of

Cubic: TypeAlias = tuple[float, float, float, float]
NATURAL_BELOW = 4  # points; from here on the spline is "not-a-knot"
_PAIRS = "Give a table of at least two pairs [x, y] with rising x."


@dataclass(frozen=True)
class Curve:
    """A piecewise cubic y(x), twice continuously differentiable inside its table.

    Parameters
    ----------
    knots
        x_0 < … < x_n.
    cubics
        For each segment k the four coefficients (c3, c2, c1, c0) of
        y = c3 u³ + c2 u² + c1 u + c0 with u = x − x_k.
    pairs
        The table of the curve, if it was created from one.
    periodic
        Whether the curve repeats with the period x_n − x_0. If not, the first and the last cubic also hold before x_0
        and after x_n. `Curve.table` makes them straight, so that a table is continued by its tangents at both ends.
    passed
        Whether steps pass the knots: what the curve is a term of is smooth there.
    """

    knots: tuple[float, ...]
    cubics: tuple[Cubic, ...]
    pairs: tuple[tuple[float, float], ...] = ()
    periodic: bool = False
    passed: bool = False

    def __post_init__(self) -> None:
        given: tuple[Any, Any] = self.knots, self.cubics
        whole = all(map(is_list, given)) and len(self.knots) == len(self.cubics) + 1 > 1
        if not whole or not all(is_list(cubic) and len(cubic) == 4 for cubic in self.cubics):
            message = "a curve has one knot more than cubics of four coefficients"
            raise ModelError(f"{message}. Make one of a table with Curve.table([[x, y], ...]).", part="curve")

    @classmethod
    def constant(cls, value: float) -> Curve:
        """Return the curve y(x) = ``value``: one segment."""
        return cls((0.0, 1.0), ((0.0, 0.0, 0.0, float(value)),))

    @classmethod
    @checked
    def table(
        cls, pairs: Iterable[Sequence[float]], field: str = "table", *, periodic: bool = False
    ) -> Curve:
        """Return the cubic spline through (x, y) pairs, continued by straight lines at both ends, or periodic.

        Not-a-knot, or natural with fewer than four pairs. The straight ends are segments of their
        own, as wide as their neighbours. A periodic spline repeats with the range of x as its period,
        with continuous slope and curvature; its last value must be the first.

        Raises
        ------
        ModelError
            If there are fewer than two pairs, x does not rise, or a number is not finite; if the ends of a periodic
            table differ by more than 1e-9 of its largest value.
        """
        with restated(part="curve"):
            xs, ys = _columns(pairs, field)
            if periodic:
                ys = [*ys[:-1], _closed(ys, field)]
            knots, cubics = _spline(xs, ys, field, periodic)
            found = cls(knots, cubics, periodic=True) if periodic else _continued(knots, cubics)
            return replace(found, pairs=tuple(zip(xs, ys, strict=True)))

    def numbers(self) -> tuple[float, ...]:
        """Return (n segments, x_0 … x_n, then c3, c2, c1, c0 of each segment); n + 1/2 of a periodic curve."""
        return (
            len(self.cubics) + 0.5 * self.periodic,
            *self.knots,
            *(c for cubic in self.cubics for c in cubic),
        )

    def __call__(self, x: float) -> float:
        """Return y(x)."""
        x = float(self.in_period(x))
        k = min(max(bisect_right(self.knots, x) - 1, 0), len(self.cubics) - 1)
        c3, c2, c1, c0 = self.cubics[k]
        u = x - self.knots[k]
        return ((c3 * u + c2) * u + c1) * u + c0

    def in_period(self, x: Any) -> Any:
        """Return x, of a periodic curve within its first period; of numbers or arrays."""
        return in_period(self.knots, x) if self.periodic else x

    def knots_within(self, low: float, high: float) -> np.ndarray[Any, Any]:
        """Return the knots, of a periodic curve all between two values and those next to them."""
        return repeated(self.knots, low, high) if self.periodic else np.array(self.knots)


def in_period(knots: Any, x: Any) -> Any:
    """Numbers within the period from the first knot to the last that they correspond to."""
    period = knots[-1] - knots[0]
    return x - period * np.floor((x - knots[0]) / period)


def repeated(knots: Any, low: float, high: float) -> np.ndarray[Any, Any]:
    """The knots of all periods that contain numbers between two values."""
    period = knots[-1] - knots[0]
    periods = np.arange(np.floor((low - knots[0]) / period), np.floor((high - knots[0]) / period) + 1)
    return np.unique(np.add.outer(periods * period, knots))


@dataclass(frozen=True, eq=False)
class Tree:
    """A written formula as a function of its variable; a class, so that models can be pickled."""

    tree: Expression
    variable: str

    def __call__(self, x: Any) -> Any:
        """Return the value for a number of any kind."""
        return self.tree.value({self.variable: x})

    def slopes(self) -> list[Tree]:
        """Return the derivative with respect to each of the formula's numbers, in their order."""
        tree, values = self._open()
        return [Tree(tree.derivative(name).replaced(values), self.variable) for name in values]

    def bends(self) -> list[list[Tree]]:
        """Return the second derivatives with respect to the formula's numbers, a row for each."""
        tree, values = self._open()
        slopes = [tree.derivative(name) for name in values]
        return [
            [Tree(one.derivative(name).replaced(values), self.variable) for name in values] for one in slopes
        ]

    def _open(self) -> tuple[Expression, dict[str, Number]]:
        """Return the formula with names in place of its numbers, and their values."""
        marked: list[str] = []

        def mark(n: int, number: Number) -> Any:
            marked.append(f"#{n}")
            return Name(marked[-1])

        return self.tree.exchanged(mark), dict(zip(marked, self.numbers(), strict=True))

    def numbers(self) -> list[Number]:
        """Return the formula's numbers in their order."""
        found: list[Number] = []

        def note(n: int, number: Number) -> Number:
            found.append(number)
            return number

        self.tree.exchanged(note)
        return found


@dataclass(frozen=True)
class Formula:
    """A function y(x) given by a formula: a Python function made of arithmetic and of `sarrus.functions`.

    It is called once with a recorded argument and stored as the list of operations that it does, so that it is
    evaluated by compiled code, with exact first and second derivatives. It must not branch on x.
    """

    function: Callable[[Numeric], Numeric]

    def __post_init__(self) -> None:
        given: Any = self.function
        if not callable(given):
            message = f"formula: it must be a function of one number, got {show(given)}"
            raise TypeError(f"{message}. Give a function, as in Formula(lambda x: 3 * x), or a number alone.")

    def numbers(self, field: str = "formula") -> tuple[float, ...]:
        """Return the stored steps.

        Raises
        ------
        ModelError
            If the function branches on its argument, uses what cannot be recorded, or is too long; if it holds what is
            no finite number, or does something else when it is called again, as one with random numbers does.
        """
        try:
            found, again = program(self._value), program(self._value)
        except (TypeError, ValueError, AttributeError, ArithmeticError) as error:
            _refuse_arguments(self.function, field)
            raise ModelError(
                f"{field} cannot be used as a formula: {str(error).rstrip('.')}. Use functions of sarrus.functions "
                "or NumPy, or give a table.",
                field=field,
            ) from None
        if not np.all(np.isfinite(found)):
            raise ModelError(f"{field} holds a number that is not finite. Remove it.", field=field)
        if found != again:
            message = f"{field} is another function each time it is called, as with random numbers"
            raise ModelError(f"{message}. Draw the numbers first, and give a table of them.", field=field)
        return found

    def _value(self, x: Any) -> Any:
        """The function's value, which must be one.

        Raises
        ------
        TypeError
        """
        value = self.function(x)
        if value is None:
            raise TypeError("it returns nothing.")
        return value

    def __call__(self, x: float) -> float:
        """Return y(x)."""
        return float(value_of(self.function(x)))

    def exchanged(self, change: Callable[[int, Number], Number]) -> Formula:
        """Return the formula with other numbers, see `Expression.exchanged`; a Python function as it is."""
        if not isinstance(self.function, Tree):
            return self
        return Formula(replace(self.function, tree=self.function.tree.exchanged(change)))

    @property
    def written(self) -> Tree | None:
        """The tree of the text; None for a Python function."""
        return self.function if isinstance(self.function, Tree) else None


def _refuse_arguments(function: Callable[..., Any], field: str) -> None:
    """Refuse a function that cannot be called with one number."""
    try:
        accepted = signature(function)
    except (TypeError, ValueError):  # some functions that are compiled
        return
    try:
        accepted.bind(0.0)
    except TypeError:
        message = f"{field} must be a function of one number, but is one of {accepted}"
        raise ModelError(f"{message}. Write it as in lambda x: 3*x.", field=field) from None


def curve_of(value: Any, field: str) -> Curve | Formula:
    """A curve of what a user gives for one: a number, a table of pairs, a Python function, or a curve.

    Raises
    ------
    ModelError
        If it is none of these.
    """
    if isinstance(value, Curve | Formula):
        return value
    if callable(value):
        return Formula(value)
    if isinstance(value, int | float):
        return Curve.constant(value)
    return Curve.table(value, field)


def _columns(pairs: Any, field: str) -> tuple[list[float], list[float]]:
    single = np.ndim(pairs) == 0 if isinstance(pairs, np.ndarray) else not isinstance(pairs, Iterable)
    if isinstance(pairs, (str, Mapping)) or single:
        raise ModelError(f"{field} must be a list of pairs, but is {show(pairs)}. {_PAIRS}", field=field)
    rows = [numbers(pair, 2, field, _PAIRS) for pair in pairs]
    xs, ys = [row[0] for row in rows], [row[1] for row in rows]
    if len(rows) < 2:
        raise ModelError(f"{field} must have at least two points, but has {len(rows)}. {_PAIRS}", field=field)
    for before, after in pairwise(xs):
        if after <= before:
            message = f"{field} must have rising x, but {show(after)} follows {show(before)}"
            raise ModelError(f"{message}. Sort the pairs and remove repeated x.", field=field)
    return xs, ys


def _closed(ys: Sequence[Any], field: str) -> Any:
    """The last value of a periodic table, which is the first."""
    first, last = float(value_of(ys[0])), float(value_of(ys[-1]))
    if abs(first - last) > ROUND_OFF * max(abs(float(value_of(y))) for y in ys):
        message = f"{field} is periodic, but begins with {show(first)} and ends with {show(last)}"
        raise ModelError(f"{message}. Give the same value at both ends.", field=field)
    return ys[0]


def spline_ends(points: int) -> str:
    """The end conditions of a spline through a number of points, as `CubicSpline` names them."""
    return "natural" if points < NATURAL_BELOW else "not-a-knot"


def _spline(
    xs: list[float], ys: list[float], field: str, periodic: bool = False
) -> tuple[tuple[float, ...], tuple[Cubic, ...]]:
    from scipy.interpolate import CubicSpline  # 1 s to import: only models with tables pay

    ends = "periodic" if periodic else spline_ends(len(xs))
    if any(isinstance(y, Tracer) for y in ys):  # the coefficients are linear in y
        unit = np.eye(len(ys))
        unit[-1] = unit[0] if periodic else unit[-1]
        basis = np.asarray(CubicSpline(xs, unit, bc_type=ends).c)
        return tuple(xs), tuple(_combined(basis[:, k], ys) for k in range(basis.shape[1]))
    try:
        with np.errstate(over="raise"):
            columns = np.asarray(CubicSpline(xs, ys, bc_type=ends).c).T
    except (FloatingPointError, ValueError):
        raise ModelError(f"{field} has values of x too near to each other. {_PAIRS}", field=field) from None
    return tuple(xs), tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in columns)


def _combined(basis: np.ndarray[Any, Any], ys: Sequence[float]) -> Cubic:
    """The coefficients of one piece, of those for each value 1."""
    a, b, c, d = (sum(float(weight) * y for weight, y in zip(row, ys, strict=True)) for row in basis)
    return a, b, c, d


def _continued(knots: tuple[float, ...], cubics: tuple[Cubic, ...]) -> Curve:
    first, last = knots[1] - knots[0], knots[-1] - knots[-2]
    before = _straight(cubics[0], 0.0, -first)
    after = _straight(cubics[-1], last, 0.0)
    return Curve((knots[0] - first, *knots, knots[-1] + last), (before, *cubics, after))


def _straight(cubic: Cubic, at: float, shift: float) -> Cubic:
    """Return the tangent of a cubic at u = ``at``, as a function of u − ``at`` − ``shift``."""
    c3, c2, c1, c0 = cubic
    slope = (3 * c3 * at + 2 * c2) * at + c1
    value = ((c3 * at + c2) * at + c1) * at + c0
    return (0.0, 0.0, slope, value + slope * shift)
