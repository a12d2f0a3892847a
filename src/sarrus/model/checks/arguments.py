"""Arguments of public functions, checked by their names: one name means one thing everywhere."""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import wraps
from math import isnan
from typing import Any, ParamSpec, TypeAlias, TypeVar

import numpy as np

from ...algebra import Array
from ..errors import ModelError
from ..expression.quantity import quantity
from ..show import show
from .calls import wrong_call

P = ParamSpec("P")
R = TypeVar("R")
Check: TypeAlias = Callable[[str, Any], None]


BYTES = {"B": 1.0, "kB": 1e3, "MB": 1e6, "GB": 1e9}


class PlaceError(ModelError, IndexError):
    """A place in a list that there is not."""


@dataclass(frozen=True)
class Number:
    """A number between limits; infinite ones only where an end is open."""

    least: float = -np.inf
    positive: bool = False
    infinite: bool = False
    most: float = np.inf

    def __call__(self, name: str, value: Any) -> None:
        """Raise a TypeError for another kind, and a ModelError for a number outside."""
        found = real(name, value)
        wanted = "a positive number" if self.positive else "a finite number"
        outside = not self.least <= found <= self.most or (self.positive and not found > 0)
        if isnan(found) or outside or (np.isinf(found) and not self.infinite):
            more = f" of at least {self.least:g}" if np.isfinite(self.least) else ""
            more += f" of at most {self.most:g}" if np.isfinite(self.most) else ""
            raise ModelError(f"{name} must be {wanted}{more}, but is {found:g}. Give another one.")


@dataclass(frozen=True)
class WholeNumber:
    """A whole number of at least so many."""

    least: int = 0

    def __call__(self, name: str, value: Any) -> None:
        """Raise a TypeError for another kind, and a ModelError for one that is too small."""
        if isinstance(value, bool) or not isinstance(value, int | np.integer):
            raise TypeError(f"{name} must be a whole number, got {_kind(value)}. Give one.")
        if value < self.least:
            raise ModelError(f"{name} must be {self.least} at least, but is {value}. Give a larger one.")


def real(name: str, value: Any) -> float:
    """The value as a float; a TypeError that names the argument for anything but a real number."""
    many = isinstance(value, np.ndarray) and value.ndim > 0
    other = isinstance(value, bool | np.bool_ | complex | np.complexfloating)
    if not many and not other and hasattr(value, "__float__"):
        try:
            return float(value)
        except OverflowError:
            raise ModelError(f"{name} must be a finite number, but is too large for one.") from None
        except (TypeError, ValueError):
            pass
    raise TypeError(f"{name} must be a number, got {_kind(value)}. Give one number in SI units.")


def as_numbers(value: Any, message: Callable[[], str]) -> Array:
    """The value as an array of its own; a TypeError with the message for anything but numbers."""
    try:
        return np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(message()) from None


def refuse_place(name: str, value: Any, count: int) -> None:
    """A TypeError for anything but a whole number, a `PlaceError` for one that is no place in a list of so many."""
    WholeNumber(-count)(name, value)
    if value >= count:
        last = f"Choose 0{f' to {count - 1}' * (count > 1)}" if count else "There is none"
        raise PlaceError(f"{name} must be less than {count}, but is {value}. {last}.")


def _numbers(name: str, value: Any) -> None:
    found = as_numbers(value, lambda: f"{name} must be numbers, got {_kind(value)}. Give a list of them.")
    if not np.isfinite(found).all():
        raise ModelError(f"{name} must be finite numbers, but one of them is not. Remove it.")


def _executor(name: str, value: Any) -> None:
    if not callable(getattr(value, "submit", None)):
        raise TypeError(f"{name} must be an executor of concurrent.futures, got {_kind(value)}. Give one.")


def _noise(name: str, value: Any) -> None:
    if value not in ("given", "estimated"):
        raise ModelError(f'{name} must be "given" or "estimated", but is {show(value)}. Give one of them.')


@dataclass(frozen=True)
class Numbers:
    """A list of two or three finite numbers."""

    count: int

    def __call__(self, name: str, value: Any) -> None:
        """Raise a TypeError for another kind, and a ModelError for another count or numbers that are not finite."""
        _numbers(name, value)
        if np.shape(value) != (self.count,):
            count, example = {2: ("two", "(1, 2)"), 3: ("three", "(0, 0, 1)")}[self.count]
            raise ModelError(
                f"{name} must be {count} numbers, got the shape {np.shape(value)}. Give {count}, as in {example}."
            )


def _text(name: str, value: Any) -> None:
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a text, got {_kind(value)}. Give one in quotes.")


def _flag(name: str, value: Any) -> None:
    if not isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be True or False, got {_kind(value)}. Give one of them.")


def _path(name: str, value: Any) -> None:
    if not isinstance(value, str | os.PathLike) or not str(value):
        raise TypeError(f"{name} must be the path of a file or folder, got {_kind(value)}. Give its name.")
    if "\0" in str(value):
        raise ModelError(f"{name} contains a NUL character, which no file name can have. Remove it.")


def _is_list(value: Any) -> bool:
    """Whether a value is no text and can be read one by one; arrays of several axes hold no names."""
    if isinstance(value, np.ndarray):
        return value.ndim == 1
    return isinstance(value, Iterable) and not isinstance(value, str | os.PathLike)


def _names(name: str, value: Any) -> None:
    if not _is_list(value) or (isinstance(value, Collection) and any(map(_is_list, value))):
        example = f'["{value}"]' if isinstance(value, str) else '["crank", "rod.mass"]'
        raise TypeError(f"{name} must be a list of names, got {_kind(value)}. Give {name}={example}.")


def _paths(name: str, value: Any) -> None:
    if not _is_list(value):
        raise TypeError(f'{name} must be a list of folders, got {_kind(value)}. Give ["meshes"].')
    for one in value:
        _path(f"each of {name}", one)


def _mapping(name: str, value: Any) -> None:
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise TypeError(f"{name} must be a mapping of names to values, got {_kind(value)}. Give a dict.")


def _progress(name: str, value: Any) -> None:
    if not (isinstance(value, bool) or callable(value)):
        raise TypeError(f"{name} must be True, False or a function, got {_kind(value)}. Give one of them.")


def _all(check: Check, names: str) -> dict[str, Check]:
    return dict.fromkeys(names.split(), check)


CHECKS: dict[str, Check] = {
    **_all(Number(), "t until"),
    **_all(Number(positive=True), "tolerance first_step memory"),
    **_all(Number(positive=True, infinite=True), "max_step time_limit total_time_limit longest"),
    **_all(WholeNumber(1), "iterations max_steps steps workers starts samples rays repeats cells most"),
    **_all(WholeNumber(0), "seed restarts"),
    **_all(
        _flag,
        "strict overwrite stable verify retry_failed second_order keep_fixed periodic",
    ),
    **_all(_path, "path folder loops"),
    **_all(_names, "fixed lock variables ignore"),
    **_all(_paths, "search"),
    **_all(_mapping, "rates parameters q0 controls inputs"),
    **_all(_numbers, "times t_eval"),
    **_all(Numbers(3), "turning"),
    **_all(_noise, "noise"),
    **_all(_executor, "executor"),
    **_all(_progress, "progress"),
    **_all(_text, "text name"),
}


Arguments: TypeAlias = tuple[tuple[Any, ...], Mapping[str, Any]]


@dataclass(frozen=True)
class NumberIn:
    """A number in a unit, which may be a text such as "80 km/h", between limits."""

    unit: str
    limits: Number = Number()

    def __call__(self, name: str, value: Any) -> None:
        """Raise a TypeError for another kind, and a ModelError for a number outside."""
        self.limits(name, value)

    def number(self, name: str, value: Any) -> Any:
        """The number of a text; anything else as it is."""
        return in_si(name, value, self.unit)


def _check_of(parameter: inspect.Parameter) -> Check:
    """The check of a parameter; `inputs` are values by name in some analyses, and a list in others."""
    values = parameter.name != "inputs" or "Mapping" in str(parameter.annotation)
    return CHECKS[parameter.name] if values else _names


def checker(
    function: Callable[..., Any], own: Mapping[str, Check] | None = None
) -> Callable[[tuple[Any, ...], Mapping[str, Any]], Arguments]:
    """Return what checks the arguments of a call; those that are left out, or as good as left out, pass.

    It returns the arguments, with numbers in place of texts with units, such as "20 ms". The function's own checks come
    before those of `CHECKS`.
    """
    own = own or {}
    signature = inspect.signature(function)
    name = function.__qualname__.removesuffix(".__init__").rpartition(".")[2]
    known = {
        key: (own[key] if key in own else _check_of(one), one.default)
        for key, one in signature.parameters.items()
        if key in own or key in CHECKS
    }
    numbers = {**TEXTS, **{key: one.number for key, one in own.items() if isinstance(one, NumberIn)}}

    def check(args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> Arguments:
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError as error:
            raise TypeError(wrong_call(name, signature, args, kwargs) or str(error)) from None
        given, texts = bound.arguments, False
        for key in known.keys() & given.keys():
            if key in numbers and isinstance(given[key], str):
                given[key], texts = numbers[key](key, given[key]), True
            test, default = known[key]
            if given[key] is not default:
                test(key, given[key])
        return (bound.args, bound.kwargs) if texts else (args, kwargs)

    return check


def in_si(name: str, given: Any, unit: str | None) -> Any:
    """The number of a text such as "30 deg", in an SI unit, None for any; anything else as it is.

    Raises
    ------
    ModelError
        For a text in another unit, or that is no number.
    """
    try:
        return quantity(given, unit) if isinstance(given, str) else given
    except ModelError as wrong:
        raise ModelError(f"{name} {wrong.message}") from None


def in_seconds(name: str, given: Any) -> Any:
    """The number of a text such as "20 ms"; anything else as it is."""
    try:
        return quantity(given, "s") if isinstance(given, str) else given
    except ModelError as wrong:
        message = f'must be a time in s, got {show(given)}. Give a number, or a text such as "20 ms".'
        raise ModelError(
            f"{name} {wrong.message if wrong.message.startswith('must be in') else message}"
        ) from None


def in_bytes(name: str, given: Any) -> Any:
    """The number of bytes of a text such as "500 MB"; anything else as it is."""
    if not isinstance(given, str):
        return given
    parts = re.fullmatch(r"\s*(\d+\.?\d*)\s*([kMG]?B)\s*", given)
    if parts is None:
        raise ModelError(
            f'{name} must be a number of bytes, got {show(given)}. Give one, or a text such as "500 MB".'
        )
    return float(parts[1]) * BYTES[parts[2]]


TEXTS = {  # arguments that may be texts with units
    **dict.fromkeys(("t", "until", "first_step", "max_step", "time_limit", "total_time_limit"), in_seconds),
    "memory": in_bytes,
}


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a public function whose arguments are checked before it runs."""
    return checked_by()(function)


def checked_by(**checks: Check) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorate a public function with the checks of its arguments, by name."""

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        check = checker(function, checks)

        @wraps(function)
        def checking(*args: P.args, **kwargs: P.kwargs) -> R:
            args, kwargs = check(args, kwargs)  # type: ignore[assignment]
            return function(*args, **kwargs)

        return checking

    return decorated


def _kind(value: Any) -> str:
    return f"the text {value!r:.40}" if isinstance(value, str) else f"{type(value).__name__} {value!r:.40}"
