"""Warnings of analyses: collected while an analysis runs, issued once at its end, and stored in its result."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from functools import wraps
from inspect import signature
from typing import Any, NamedTuple, ParamSpec, TypeVar, cast

from .checks.arguments import CHECKS, checker
from .errors import SarrusWarning, StrictError
from .read_only import read_only

P = ParamSpec("P")
R = TypeVar("R")
# Packages whose lines are not the user's
INNER = (__name__.partition(".")[0], "dataclasses", "copy", "pickle")


class Call(NamedTuple):
    """The call of an analysis that returned a result, by which the analysis can be repeated; see `sarrus.verify`.

    Attributes
    ----------
    analysis : the public function
    args, kwargs : its arguments; results among them without their own calls
    """

    analysis: Callable[..., Any]
    args: tuple[Any, ...]
    kwargs: Mapping[str, Any]

    @classmethod
    def of(cls, analysis: Callable[..., Any], args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> Call:
        """The call; a chain of results, each the start of the next, is not stored with it."""
        own = {name: _without_call(value) for name, value in kwargs.items()}
        return cls(analysis, tuple(map(_without_call, args)), own)

    @property
    def arguments(self) -> dict[str, Any]:
        """All arguments by name, with the defaults."""
        bound = signature(self.analysis).bind(*self.args, **self.kwargs)
        bound.apply_defaults()
        return bound.arguments


def _without_call(value: Any) -> Any:
    is_result = hasattr(type(value), "call")  # asked of the class: a system looks for similar names first
    return value.changed(call=None) if is_result and value.call is not None else value


class Collection:
    """The messages of one analysis, and of those that it calls.

    Parameters
    ----------
    strict : whether a message is raised instead
    """

    def __init__(self, strict: bool) -> None:
        self.strict = strict
        self.messages: tuple[str, ...] = ()
        self.carried: tuple[str, ...] = ()  # issued before, when the system was made

    def add(self, messages: Iterable[str]) -> None:
        """Append those that are new."""
        self.messages = tuple(dict.fromkeys((*self.messages, *messages)))


_collection: ContextVar[Collection | None] = ContextVar("collection", default=None)
_strict: ContextVar[bool] = ContextVar("strict", default=False)


@contextmanager
def strict(on: bool = True) -> Iterator[None]:
    """Raise the first warning of models, systems and analyses in this block as a `StrictError`, where it arises.

    Parameters
    ----------
    on : false: warnings are issued, as outside of such blocks

    Examples
    --------
    >>> with sr.strict():  # doctest: +SKIP
    ...     run = sr.simulate(sr.System(model), until=1.0)
    """
    CHECKS["strict"]("strict", on)
    token = _strict.set(bool(on))
    try:
        yield
    finally:
        _strict.reset(token)


@contextmanager
def collecting(strict: bool = False) -> Iterator[Collection]:
    """Collect what is announced in this block; nothing of it leaves the block by itself."""
    collection = Collection(strict)
    token = _collection.set(collection)
    try:
        yield collection
    finally:
        _collection.reset(token)


def collected() -> tuple[str, ...]:
    """The messages so far of the analysis that is running."""
    collection = _collection.get()
    return tuple(dict.fromkeys((*collection.carried, *collection.messages))) if collection else ()


def carry(messages: tuple[str, ...]) -> None:
    """Store warnings of a system, which were issued when it was made, in the result of the analysis that is running.

    Raises
    ------
    StrictError
        With the first message, in a block `strict`.
    """
    collection = _collection.get()
    if collection is not None and messages:
        if collection.strict:
            raise StrictError(messages[0])
        collection.carried = messages


def announce(messages: Iterable[str]) -> tuple[str, ...]:
    """Issue each message once as a `SarrusWarning` at the user's line; return them for the result's ``warnings``.

    Inside an analysis they are handed to it, and it issues them at its end.

    Parameters
    ----------
    messages : in order; repeated ones are dropped

    Raises
    ------
    StrictError
        With the first message, in a block `strict`.
    """
    unique, outer = tuple(dict.fromkeys(messages)), _collection.get()
    if unique and is_strict():
        raise StrictError(unique[0])
    if outer is not None:
        outer.add(unique)
        return unique
    warn_now(unique)
    return unique


def is_strict() -> bool:
    """Whether the first message is raised."""
    collection = _collection.get()
    return _strict.get() if collection is None else collection.strict


def warn_now(messages: Iterable[str], category: type[Warning] = SarrusWarning) -> None:
    """Issue messages about a result that exists, at the user's line; they are no matter of an analysis that uses it."""
    frame, level = sys._getframe(1), 2
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] in INNER:
        frame, level = frame.f_back, level + 1
    for message in messages:
        warnings.warn(message, category, stacklevel=level)


def former_strict(kwargs: dict[str, Any]) -> AbstractContextManager[None]:
    """The block of the deprecated keyword ``strict``, which is removed from the keywords."""
    if "strict" not in kwargs:
        return nullcontext()
    warn_now(["strict= is deprecated. Use a block `with sr.strict():`."], DeprecationWarning)
    return strict(kwargs.pop("strict"))


def accepts_strict(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a public function that is no analysis, such as `System`: the deprecated keyword is accepted."""

    @wraps(function)
    def accepting(*args: P.args, **kwargs: P.kwargs) -> R:
        with former_strict(kwargs):
            return function(*args, **kwargs)

    return accepting


def reports_warnings(analysis: Callable[P, R]) -> Callable[P, R]:
    """Decorate a public analysis: what is announced in it is issued at its end and stored in its result.

    The result has its `Call`, too. In a block `strict` the first message is raised where it arises, that of an analysis
    within another one at its end. Its arguments are checked before it runs, see `arguments`.
    """
    check = checker(analysis)

    @wraps(analysis)
    def reporting(*args: P.args, **kwargs: P.kwargs) -> R:
        with former_strict(kwargs):
            args, kwargs = check(args, kwargs)  # type: ignore[assignment]
            return reported(*args, **kwargs)

    def reported(*args: P.args, **kwargs: P.kwargs) -> R:
        with collecting(_strict.get() and _collection.get() is None) as found:
            result = analysis(*args, **kwargs)
        if getattr(result, "call", found) is None:  # a frozen result, which is new
            object.__setattr__(result, "call", Call.of(reporting, args, kwargs))
        if _collection.get() is None:  # the user's own call: inner ones may go on with their arrays
            result = cast(R, read_only(result))
        return with_warnings(result, tuple(dict.fromkeys((*found.carried, *announce(found.messages)))))

    return reporting


def with_warnings(result: R, messages: tuple[str, ...]) -> R:
    """A result with further messages; plain numbers have no field for them."""
    if not messages or not hasattr(result, "warnings"):
        return result
    found: Any = result
    both = tuple(dict.fromkeys((*found.warnings, *messages)))
    if hasattr(found, "with_warnings"):
        return cast(R, found.with_warnings(both))
    change = found._replace if hasattr(found, "_replace") else found.changed
    return cast(R, change(warnings=both))
