"""The values of one parameter of a study: listed values, a range, or a distribution of SciPy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, isfinite, log
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np

from ..model import Model, ModelError, SarrusError, parse_expression
from ..model.expression.units import fits, unit_of, unit_text
from ..model.show import show, suggest
from ..outputs.units import unit_of_parameter

Array: TypeAlias = np.ndarray[Any, np.dtype[np.float64]]


@runtime_checkable
class Parameter(Protocol):
    """Values of one number: those of a grid, and those that belong to places between 0 and 1."""

    def grid(self) -> Array:
        """The values that a grid takes."""
        ...

    def at(self, u: Array) -> Array:
        """The values at places u between 0 and 1; equidistant places are equally probable values."""
        ...


@dataclass(frozen=True)
class Values:
    """Listed values, all equally probable."""

    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.values or not all(isfinite(value) for value in self.values):
            raise SarrusError(
                f"listed values must be finite numbers, one at least, but are {self.values}. Give such a list."
            )

    def grid(self) -> Array:
        return np.array(self.values, dtype=float)

    def at(self, u: Array) -> Array:
        """Return the values for given probabilities, each value over an equal part of (0, 1)."""
        places = np.minimum((np.asarray(u) * len(self.values)).astype(int), len(self.values) - 1)
        return np.asarray(self.grid()[places])


@dataclass(frozen=True)
class Range:
    """Interval of equally probable values from `low` to `high`; on a grid, `count` values.

    Parameters
    ----------
    low, high : in SI units, or texts with units, ``"60 mm"``
    count : on a grid
    log : equidistant, and equally probable, in the logarithm
    """

    low: float
    high: float
    count: int = 5
    log: bool = False
    # whose units are checked
    texts: tuple[str, ...] = field(default=(), init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "texts", tuple(texts_of([self.low, self.high])))
        for end in ("low", "high"):
            object.__setattr__(self, end, number(getattr(self, end)))
        if not (isfinite(self.low) and isfinite(self.high) and self.low < self.high):
            raise SarrusError(
                f"a range must rise from a low to a high number, but is {self.low} to {self.high}. "
                "Exchange its ends, or give others."
            )
        if self.log and self.low <= 0:
            raise SarrusError(
                f"a range in the logarithm must be positive, but begins at {self.low}. "
                "Leave `log` out, or give positive ends."
            )
        if self.count < 2:
            raise SarrusError(
                f"a range has two values at least on a grid, but count is {self.count}. Give a larger count."
            )

    def grid(self) -> Array:
        """Return `count` equidistant values, including both ends."""
        return self.at(np.linspace(0.0, 1.0, self.count))

    def at(self, u: Array) -> Array:
        """Return the values for given probabilities."""
        if self.log:
            return np.array([exp(log(self.low) * (1 - x) + log(self.high) * x) for x in np.asarray(u)])
        return np.asarray(self.low * (1 - np.asarray(u)) + self.high * np.asarray(u))


# Hardly a sample of the largest study is beyond these quantiles
PROBABILITIES = np.array([1e-12, 0.5, 1 - 1e-12])


@dataclass(frozen=True)
class Distribution:
    """A distribution of ``scipy.stats`` by its name there, with its arguments.

    Parameters
    ----------
    name : ``"norm"``, ``"lognorm"``, ``"triang"``, ``"truncnorm"``, ``"weibull_min"`` ...
    arguments : with SciPy's names: ``{"loc": 10, "scale": 0.5}``, in SI units or as texts with units
    count : number of grid points: quantiles in the middle of equally probable parts
    """

    name: str
    arguments: Mapping[str, float] = field(default_factory=dict)
    count: int = 5
    # whose units are checked
    texts: tuple[str, ...] = field(default=(), init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "texts", tuple(texts_of(self.arguments)))
        object.__setattr__(self, "arguments", {key: number(value) for key, value in self.arguments.items()})
        if not np.all(np.isfinite(self.at(PROBABILITIES))):
            wrong = "has no values, or some that are not finite"
            raise SarrusError(f"the distribution {self.name} with {dict(self.arguments)} {wrong}. {_SCIPY}")

    def grid(self) -> Array:
        return self.at((np.arange(self.count) + 0.5) / self.count)

    def at(self, u: Array) -> Array:
        with np.errstate(over="ignore"):  # what is not finite is refused
            return np.asarray(self.frozen().ppf(np.asarray(u)), dtype=float)

    def frozen(self) -> Any:
        """SciPy's distribution.

        Raises
        ------
        SarrusError
            If SciPy has none of this name, or not with these arguments.
        """
        from scipy import stats

        known = [name for name in dir(stats) if hasattr(getattr(stats, name), "ppf")]
        if self.name not in known:
            raise SarrusError(f"there is no distribution {self.name!r}. {suggest(self.name, known)}")
        try:
            return getattr(stats, self.name)(**self.arguments)
        except TypeError as wrong:
            raise SarrusError(
                f"the distribution {self.name}: {str(wrong).split(') ')[-1]}. {_SCIPY}"
            ) from None


LARGEST = 2**31 - 1  # of a seed, and of what is counted
_SCIPY = "See scipy.stats for its arguments."


def parameter_of(given: Any) -> Parameter:
    """A parameter of what a user writes for one.

    A list is `Values`; a mapping with ``from`` and ``to`` a `Range`, one with ``distribution`` a `Distribution`, its
    other entries SciPy's arguments. Texts are formulas of numbers with units, ``"5 kN/m"``.

    Raises
    ------
    SarrusError
        For anything else.
    """
    if isinstance(given, Parameter):
        return given
    if isinstance(given, Mapping):
        return _of_mapping(dict(given))
    if isinstance(given, Sequence | np.ndarray) and not isinstance(given, str):
        return Values(tuple(number(value) for value in given))
    return Values((number(given),))


def _of_mapping(entries: dict[str, Any]) -> Parameter:
    count = {"count": whole(entries.pop("count"), "count")} if "count" in entries else {}
    if "distribution" in entries:
        name = str(entries.pop("distribution"))
        return Distribution(name, entries, **count)
    if not {"from", "to"} <= entries.keys() or entries.keys() - {"from", "to", "log"}:
        message = f"its keys are {', '.join(entries) or 'none'}"
        raise SarrusError(f"{message}. Give from and to (and count, log), or distribution and its arguments.")
    log = entries.get("log", False)
    if not isinstance(log, bool):
        raise SarrusError(f"log must be true or false, but is {show(log)}. Write one of both.")
    return Range(entries["from"], entries["to"], log=log, **count)


def refuse_other_units(model: Model, name: str, values: Any) -> None:
    """Raise a SarrusError for a text among the values of a parameter, ``5 kN/m``, that is in another unit than it."""
    unit = unit_of_parameter(model, name)
    for text in texts_of(values) if unit else ():
        powers = unit_of(parse_expression(text), {})
        if not fits(powers, unit):
            expected = "a plain number" if unit == "1" else unit
            message = f"{name} expects {expected}, but {text!r} is in {unit_text(powers or {})}"
            raise SarrusError(f"{message}. Give it in {expected}, or omit the unit.")


def texts_of(values: Any) -> Iterator[str]:
    """The texts of a value, a list of values, or the limits of a range; not the name of a distribution."""
    if isinstance(values, str):
        yield values
    elif isinstance(values, Mapping):
        yield from texts_of([value for key, value in values.items() if key != "distribution"])
    elif isinstance(values, list | tuple):
        yield from (value for value in values if isinstance(value, str))
    else:
        yield from getattr(values, "texts", ())


def number(value: Any) -> float:
    """A number, or a text such as ``20 mm``, in SI units."""
    try:
        result = parse_expression(value).value() if isinstance(value, str) else value
    except ModelError as wrong:
        raise SarrusError(f"{value!r} {wrong.message}") from None
    if isinstance(result, bool) or not isinstance(result, int | float | np.number):
        raise SarrusError(
            f"a number is expected, but {show(value)} is given. Write it as in 1.5e-3 or 20 mm."
        )
    try:
        return float(result)
    except OverflowError:
        raise SarrusError(f"a finite number is expected, but {show(value)} is given.") from None


def seconds(value: Any) -> float:
    """A time that is greater than 0, in s."""
    time = number(value)
    if not time > 0:
        raise SarrusError(f"a time greater than 0 s is expected, but {show(value)} is given.")
    return time


def whole(value: Any, name: str, least: int = 1) -> int:
    """A whole number, by default of at least 1."""
    is_number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not is_number or not isfinite(value) or int(value) != value or value < least:
        raise SarrusError(
            f"{name} must be a whole number of at least {least}, but is {show(value)}. Give one."
        )
    if value > LARGEST:
        raise SarrusError(f"{name} must be at most {LARGEST:,}, but is {show(value)}. Give fewer.")
    return int(value)
