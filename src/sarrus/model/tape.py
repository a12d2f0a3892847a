"""Numbers that remember how they were computed, with their values: formulas and model construction differentiated.

A `Tracer` number is a scalar, or one scalar for each of many times. Arithmetic, NumPy's functions (also on arrays of
traced numbers) and `sarrus.functions` write on its tape; comparisons compare values. The tape then gives derivatives
along a direction, gradients, and their change along a direction, all exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, reduce
from operator import add
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from .._jit.formulas.differentiate import jacobian
from .._jit.formulas.expression import Graph
from .._jit.formulas.replay import ARRAYS, function_of
from .._jit.formulas.replay import OPERATIONS as KERNELS
from .arithmetic import Numeric


class Entry(NamedTuple):
    """One operation on the tape, and the indices of its arguments."""

    op: str | Operation
    args: tuple[int, ...]


class Tape:
    """The operations so far, with their values, in the order of their creation.

    Parameters
    ----------
    sides : for each kink the sign (nt,) that its argument has on the side from which it is looked at; by default that
        of its value

    Attributes
    ----------
    kinks : places of what absolute values were taken of, where it changes over time
    """

    def __init__(self, sides: Sequence[Any] = ()) -> None:
        self.entries: list[Entry] = []
        self.values: list[Any] = []
        self._moving: list[bool] = []
        self.kinks: list[int] = []
        self._sides = sides

    def variable(self, value: Any) -> Tracer:
        """A number that derivatives can be taken by."""
        return self.add("variable", (), value)

    def add(self, op: str | Operation, args: tuple[int, ...], value: Any) -> Tracer:
        """Write one operation."""
        self.entries.append(Entry(op, args))
        self.values.append(value)
        self._moving.append(op == "variable" or any(map(self._moving.__getitem__, args)))
        return Tracer(self, len(self.entries) - 1)

    def absolute(self, x: Tracer) -> Tracer:
        """Write an absolute value, and note its kink."""
        return self._kinked(x, "absolute", _one_side, (x.at,))

    def larger(self, a: Any, b: Any, difference: Tracer) -> Tracer:
        """Write the larger of two numbers, and note the kink where their difference a - b is zero."""
        places = tuple(x.at if isinstance(x, Tracer) else self.add("constant", (), x).at for x in (a, b))
        return self._kinked(difference, "maximum", _one_of_two, places)

    def _kinked(self, x: Tracer, name: str, with_sides: Callable[[Any], Operation], args: Any) -> Tracer:
        """Write an operation with a kink where x is zero, or that of given signs of x; infinite bounds have none."""
        operation = OPERATIONS[name]
        if np.ndim(x.value) and self._moving[x.at] and np.all(np.isfinite(x.value)):
            self.kinks.append(x.at)
            if len(self._sides) >= len(self.kinks):
                operation = with_sides(self._sides[len(self.kinks) - 1])
        known = name if operation is OPERATIONS[name] else operation
        return self.add(known, args, operation.value(*[self.values[at] for at in args]))

    def along(self, changes: Mapping[int, Any]) -> list[Any]:
        """The change of every entry, for changes of variables given by their places."""
        dots: list[Any] = [0.0] * len(self.entries)
        for n, (_, args) in enumerate(self.entries):
            if n in changes:
                dots[n] = changes[n]
            elif any(_moves(dots[arg]) for arg in args):
                for slope, arg in zip(self._slopes(n), args, strict=True):
                    dots[n] = _sum(dots[n], _product(slope, dots[arg]))
        return dots

    def recorded_along(self, of: Tracer, rates: Mapping[int, Tracer]) -> Any:
        """The change of an entry for changes of variables, written on the tape: it can be differentiated as well.

        Raises
        ------
        TypeError
            Where an operation jumps, or is not recorded.
        """
        dots: dict[int, Any] = dict(rates)
        for n in self.origins(of.at):
            op, args = self.entries[n]
            if n not in dots and any(arg in dots for arg in args):
                if isinstance(op, Operation):
                    raise TypeError(
                        "a function that is not recorded has no third derivatives. Write it with NumPy."
                    )
                still = op in ("absolute", "maximum")  # their slopes change at kinks only
                own = [
                    self.values[k] if still or not self._moving[k] else Tracer(self, k) for k in (n, *args)
                ]
                pairs = zip(operation(op).slopes(*own), args, strict=True)
                dots[n] = reduce(add, (slope * dots[arg] for slope, arg in pairs if arg in dots))
        return dots.get(of.at, 0.0)

    def origins(self, at: int) -> list[int]:
        """The places of an entry and of all entries of which it is made, in order."""
        needed, waiting = {at}, [at]
        while waiting:
            new = [arg for arg in self.entries[waiting.pop()].args if arg not in needed]
            needed.update(new)
            waiting += new
        return sorted(needed)

    def gradient(self, bars: Mapping[int, Any], without: Any = None) -> list[Any]:
        """The gradient by every entry of a sum of entries that are weighted with `bars`, given by their places.

        By what depends on no variable it is left zero. Slopes at times (nt,) `without` weight, which may be infinite,
        are left out.
        """
        found: list[Any] = [bars.get(n, 0.0) for n in range(len(self.entries))]
        for n in range(len(self.entries) - 1, -1, -1):
            bar = found[n]
            if self._moving[n] and self.entries[n].args and _moves(bar):
                for arg, slope in self._moving_slopes(n, without):
                    found[arg] = _sum(found[arg], _collected(bar, slope, self.values[arg]))
        return found

    def gradient_along(
        self, bars: Mapping[int, Any], bar_dots: Mapping[int, Any], dots: Sequence[Any], without: Any = None
    ) -> tuple[list[Any], list[Any]]:
        """The gradient, and its change when entries change by `dots` and the weights by `bar_dots`."""
        found: list[Any] = [bars.get(n, 0.0) for n in range(len(self.entries))]
        change: list[Any] = [bar_dots.get(n, 0.0) for n in range(len(self.entries))]
        for n in range(len(self.entries) - 1, -1, -1):
            bar, bar_dot = found[n], change[n]
            if not (self._moving[n] and self.entries[n].args and (_moves(bar) or _moves(bar_dot))):
                continue
            bends = self._bends(n, dots)
            for place, (arg, slope) in enumerate(self._moving_slopes(n, without)):
                like, bend = self.values[arg], _needed(bends[place], without)
                found[arg] = _sum(found[arg], _collected(bar, slope, like))
                moved = _sum(_collected(bar_dot, slope, like), _collected(bar, bend, like))
                change[arg] = _sum(change[arg], moved)
        return found, change

    def _slopes(self, n: int) -> tuple[Any, ...]:
        op, args = self.entries[n]
        return operation(op).slopes(self.values[n], *[self.values[arg] for arg in args])

    def _moving_slopes(self, n: int, without: Any = None) -> list[tuple[int, Any]]:
        """The arguments of an entry that depend on variables, and its slopes by them."""
        pairs = zip(self.entries[n].args, self._slopes(n), strict=True)
        return [(arg, _needed(slope, without)) for arg, slope in pairs if self._moving[arg]]

    def _bends(self, n: int, dots: Sequence[Any]) -> list[Any]:
        """The changes of the slopes by the arguments that depend on variables."""
        op, args = self.entries[n]
        moved = [dots[arg] for arg in args]
        own = [place for place, arg in enumerate(args) if self._moving[arg]]
        if op in LINEAR or not any(map(_moves, moved)):
            return [0.0] * len(own)
        rule = operation(op)
        if rule.turned is not None:
            whole = rule.turned(moved)
            return [whole[place] for place in own]
        bends = rule.bends(self.values[n], *[self.values[arg] for arg in args])
        return [_total(_product(b, dot) for b, dot in zip(bends[place], moved, strict=True)) for place in own]


def _moves(dot: Any) -> bool:
    return not (isinstance(dot, float) and dot == 0.0)


def _product(slope: Any, moved: Any) -> Any:
    """Their product; without a multiplication where one of them is a plain 0 or 1."""
    for one, other in ((slope, moved), (moved, slope)):
        if isinstance(one, float) and one in (0.0, 1.0, -1.0):
            return 0.0 if one == 0.0 else other if one == 1.0 else -other
    return slope * moved


def _sum(total: Any, term: Any) -> Any:
    """Their sum, of which one may be a plain zero. Neither is written to: others may hold it."""
    if not _moves(term):
        return total
    return total + term if _moves(total) else term


def _total(terms: Iterable[Any]) -> Any:
    return reduce(_sum, terms, 0.0)


def _collected(bar: Any, slope: Any, like: Any) -> Any:
    """A gradient's share by an argument; by a scalar that was used at many times the sum over them."""
    if _over_time(like) or not (_over_time(bar) or _over_time(slope)):
        return _product(slope, bar)
    if _over_time(bar) and _over_time(slope):
        return float(np.dot(bar, slope))
    return float(np.sum(_product(slope, bar)))


def _needed(slope: Any, without: Any) -> Any:
    """A slope, zero at times without weight."""
    return np.where(without, 0.0, slope) if without is not None and _over_time(slope) else slope


def _over_time(number: Any) -> bool:
    return isinstance(number, np.ndarray) and number.ndim > 0


class Operation(NamedTuple):
    """A function with its first and second partial derivatives.

    `turned`, in place of `bends` where it is given: the changes of the partial derivatives along a direction.
    """

    value: Callable[..., Numeric]
    slopes: Callable[..., tuple[Numeric, ...]]
    bends: Callable[..., tuple[tuple[Numeric, ...], ...]]
    turned: Callable[[Sequence[Numeric]], Sequence[Numeric]] | None = None


def whole(value: Any, slopes: Any, turned: Callable[[Any], Any]) -> Operation:
    """An operation on many numbers whose value and slopes are known, and how the slopes change along a direction."""

    def bends(*args: Any) -> tuple[tuple[Any, ...], ...]:
        return tuple(tuple(turned(row)) for row in np.eye(len(slopes)))

    return Operation(lambda *_: value, lambda *_: tuple(slopes), bends, turned)


def operation(op: str | Operation) -> Operation:
    """An operation by its name, or as it is."""
    return op if isinstance(op, Operation) else OPERATIONS.get(op) or _recorded(op)


def _one_side(side: Any) -> Operation:
    """The absolute value with given signs of its argument."""
    return Operation(lambda a: side * a, lambda f, a: (side,), lambda f, a: ((0.0,),))


def _one_of_two(side: Any) -> Operation:
    """The larger of two numbers with given signs of their difference."""
    first = np.greater(side, 0)

    def larger(a: Any, b: Any) -> np.ndarray[Any, Any]:
        return np.asarray(np.where(first, a, b))

    return Operation(
        larger,
        lambda f, a, b: (np.where(first, 1.0, 0.0), np.where(first, 0.0, 1.0)),
        lambda f, a, b: ((0.0, 0.0), (0.0, 0.0)),
    )


def _shares(a: Any, b: Any) -> tuple[Any, Any]:
    """The derivatives of the larger of two numbers: 1 and 0, one half each where they are equal."""
    first = 0.5 * (1 + np.sign(a - b))
    return first, 1 - first


def _power_bend(a: Any, n: Any) -> Any:
    """The second derivative of aⁿ, also at 0 of a itself."""
    bent = np.not_equal(n, 1)
    return np.where(bent, n * (n - 1) * np.where(bent, a, 1.0) ** (n - 2), 0.0)


NAMES = ("sqrt", "sin", "cos", "tan", "exp", "log", "tanh", "asin", "acos", "atan")
OF_TWO = ("add", "sub", "mul", "div", "atan2")


@cache
def _recorded(name: str) -> Operation:
    """A function with the derivatives that it has in kernels, in which its value is known."""
    graph, names = Graph(), ("a", "b")[: 1 + (name in OF_TWO)]
    args = [graph.input(one) for one in names]
    f = KERNELS[name](*args)
    known = {f.id: "f"} | {arg.id: one for arg, one in zip(args, names, strict=True)}
    slopes = jacobian(graph, [f], args)[0]
    first, *second = (function_of(graph, row, known) for row in (slopes, *jacobian(graph, slopes, args)))
    return Operation(ARRAYS[name], first, lambda *numbers: tuple(row(*numbers) for row in second))


OPERATIONS: dict[str, Operation] = {
    "power": Operation(
        lambda a, n: a**n,
        lambda f, a, n: (n * a ** (n - 1), 0.0),
        lambda f, a, n: ((_power_bend(a, n), 0.0), (0.0, 0.0)),
    ),
    "maximum": Operation(np.maximum, lambda f, a, b: _shares(a, b), lambda f, a, b: ((0.0, 0.0), (0.0, 0.0))),
    "absolute": Operation(np.abs, lambda f, a: (np.sign(a),), lambda f, a: ((0.0,),)),
}  # that kernels make of others
LINEAR = ("add", "sub", "neg")
BINARY = {"add": "add", "subtract": "sub", "multiply": "mul", "divide": "truediv", "power": "pow"}
KINKED: dict[str, Callable[..., Any]] = {
    "absolute": abs,
    "fabs": abs,
    "maximum": lambda a, b: _larger(a, b),
    "fmax": lambda a, b: _larger(a, b),
    "minimum": lambda a, b: _smaller(a, b),
    "fmin": lambda a, b: _smaller(a, b),
}  # continuous functions with a kink
JUMPS = (
    "sign",
    "floor",
    "ceil",
    "rint",
    "trunc",
    "heaviside",
    "copysign",
    "floor_divide",
    "remainder",
    "fmod",
)
COMPARISONS = ("less", "less_equal", "greater", "greater_equal", "equal", "not_equal")


class Tracer:
    """A scalar with a value, or one for each of many times, on a tape."""

    __slots__ = ("at", "tape")

    def __init__(self, tape: Tape, at: int) -> None:
        self.tape, self.at = tape, at

    @property
    def value(self) -> Any:
        """The value: a float, or an array over times."""
        return self.tape.values[self.at]

    def call(self, op: str, *others: Any) -> Tracer:
        """An operation on this and other numbers."""
        return apply(op, self, *others)

    def __add__(self, other: Any) -> Any:
        return self if _is(other, 0) else _between("add", self, other)

    def __radd__(self, other: Any) -> Any:
        return self if _is(other, 0) else _between("add", other, self)

    def __sub__(self, other: Any) -> Any:
        return self if _is(other, 0) else _between("sub", self, other)

    def __rsub__(self, other: Any) -> Any:
        return -self if _is(other, 0) else _between("sub", other, self)

    def __mul__(self, other: Any) -> Any:
        if _is(other, 0):
            return 0.0
        return self if _is(other, 1) else _between("mul", self, other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self if _is(other, 1) else _between("div", self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return 0.0 if _is(other, 0) else _between("div", other, self)

    def __pow__(self, other: Any) -> Any:
        if isinstance(other, Tracer):
            return apply("exp", other * apply("log", self))
        return self if _is(other, 1) else self.call("power", other)

    def __rpow__(self, other: Any) -> Any:
        return apply("exp", self * float(np.log(other)))

    def __neg__(self) -> Tracer:
        return self.call("neg")

    def __pos__(self) -> Tracer:
        return self

    def __abs__(self) -> Tracer:
        return self.tape.absolute(self)

    def clip(self, low: Any = None, high: Any = None, **options: Any) -> Any:
        """Between two bounds; what `numpy.clip` calls."""
        above = self if low is None else _larger(self, low)
        return above if high is None else _smaller(above, high)

    def arctan2(self, other: Any) -> Tracer:
        """Angle of the point (other, self)."""
        return self.call("atan2", other)

    def hypot(self, other: Any) -> Any:
        """Length of the vector (self, other)."""
        return (self * self + other * other).sqrt()

    @property
    def context(self) -> Any:
        """The functions of `sarrus.functions` for this kind of number."""
        return FUNCTIONS

    def __float__(self) -> float:
        raise TypeError(
            "a number that is differentiated cannot become a plain one: take NumPy's functions, such as np.sin, in the "
            "place of math.sin, and return one number, no vector."
        )

    def __bool__(self) -> bool:
        return bool(_compared(self, 0.0, np.not_equal))

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or options:
            return NotImplemented
        if any(isinstance(x, np.ndarray) for x in inputs):
            return ufunc(*(_boxed(x) if isinstance(x, Tracer) else x for x in inputs))
        return _scalar(ufunc.__name__, ufunc, inputs)


def _method(op: str) -> Callable[[Tracer], Tracer]:
    def function(self: Tracer) -> Tracer:
        return self.call(op)

    function.__name__, function.__doc__ = op, f"{op} of this number."
    return function


def _comparison(ufunc: Any) -> Callable[[Any, Any], Any]:
    return lambda self, other: _compared(self, other, ufunc)


OF_NUMPY = {ARRAYS[name].__name__: name for name in (*NAMES, "atan2")} | {"negative": "neg"}
for _op in NAMES:
    setattr(Tracer, ARRAYS[_op].__name__, _method(_op))
for _name, _ufunc in (("lt", np.less), ("le", np.less_equal), ("gt", np.greater), ("ge", np.greater_equal)):
    setattr(Tracer, f"__{_name}__", _comparison(_ufunc))
FUNCTIONS = SimpleNamespace(
    **{name: (lambda x, op=name: x.call(op)) for name in NAMES},
    atan2=lambda y, x: apply("atan2", y, x),
    absolute=abs,
    ramp=lambda x: 0.5 * (x + abs(x)),
    minimum=lambda a, b: _smaller(a, b),
    maximum=lambda a, b: _larger(a, b),
)


PLAIN = (int, float, np.number)
NUMBERS = (Tracer, *PLAIN)


def value_of(number: Any) -> Any:
    """The value of a traced number; any other number as it is."""
    return number.value if isinstance(number, Tracer) else number


def values_of(array: Any) -> np.ndarray[Any, Any]:
    """An array of numbers of any kind as an array of floats, for checks."""
    if isinstance(array, np.ndarray) and array.dtype == float:
        return array
    entries = np.asarray(array, dtype=object)
    return np.array([float(value_of(entry)) for entry in entries.flat]).reshape(entries.shape)


def apply(op: str, *args: Any) -> Tracer:
    """An operation on numbers of which one at least is traced."""
    tape = next(arg.tape for arg in args if isinstance(arg, Tracer))
    places = [arg.at if isinstance(arg, Tracer) else tape.add("constant", (), arg).at for arg in args]
    return tape.add(op, tuple(places), operation(op).value(*[tape.values[at] for at in places]))


def own(
    tape: Tape,
    value: Callable[..., Any],
    slopes: Callable[..., Sequence[Any]],
    bends: Callable[..., Sequence[Sequence[Any]]] | None,
    args: Sequence[Any],
) -> Tracer:
    """A function that is not recorded: its value, first and, if they are given, second derivatives by its arguments."""

    def second(f: Any, *numbers: Any) -> tuple[tuple[Any, ...], ...]:
        if bends is None:
            raise ValueError("second derivatives need those of your own function: o.own(..., bends=...).")
        return tuple(tuple(row) for row in bends(*numbers))

    places = tuple(arg.at if isinstance(arg, Tracer) else tape.add("constant", (), arg).at for arg in args)
    operation = Operation(value, lambda f, *numbers: tuple(slopes(*numbers)), second)
    return tape.add(operation, places, value(*(value_of(arg) for arg in args)))


def _larger(a: Any, b: Any) -> Any:
    """The larger of two numbers, with a kink where they are equal."""
    difference = a - b
    return difference.tape.larger(a, b, difference) if isinstance(difference, Tracer) else np.maximum(a, b)


def _smaller(a: Any, b: Any) -> Any:
    """The smaller of two numbers."""
    return -_larger(-a, -b)


def _is(other: Any, number: int) -> bool:
    return isinstance(other, PLAIN) and other == number


def _between(op: str, a: Any, b: Any) -> Any:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return NotImplemented
    if not (isinstance(a, NUMBERS) and isinstance(b, NUMBERS)):
        return NotImplemented
    return apply(op, a, b)


def _boxed(x: Tracer) -> np.ndarray[Any, Any]:
    box = np.empty((), dtype=object)
    box[()] = x
    return box


def _scalar(name: str, ufunc: Any, inputs: tuple[Any, ...]) -> Any:
    """A NumPy function of scalars."""
    if name in COMPARISONS:
        return _compared(inputs[0], inputs[1], ufunc)
    if name in BINARY:
        first, second = inputs
        if isinstance(first, Tracer):
            return getattr(first, f"__{BINARY[name]}__")(second)
        return getattr(second, f"__r{BINARY[name]}__")(first)
    if name in KINKED:
        return KINKED[name](*inputs)
    if name == "hypot":
        return (inputs[0] * inputs[0] + inputs[1] * inputs[1]).sqrt()
    if name in OF_NUMPY:
        return apply(OF_NUMPY[name], *inputs)
    if name == "isfinite":
        return bool(np.all(np.isfinite(inputs[0].value)))
    if name in JUMPS:
        raise TypeError(
            f"numpy.{name} jumps and has no derivative. Use a smooth function, or np.abs, np.maximum, np.minimum, "
            "np.clip."
        )
    raise TypeError(f"numpy.{name} has no derivative here. Use arithmetic or another function.")


def _compared(a: Any, b: Any, ufunc: Any) -> Any:
    found = ufunc(value_of(a), value_of(b))
    if np.ndim(found):
        raise TypeError(
            "a formula must not branch on what changes in time. Use a smooth one, or np.maximum, np.minimum, np.abs, "
            "np.clip in the place of if, max, min, np.where."
        )
    return bool(found)
