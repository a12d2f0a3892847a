"""What do analyses make only once: of one system, or of all that have the same structure; kept while those live."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

from .system import System

P = ParamSpec("P")
T = TypeVar("T")
MOST = 32  # things of one kind that are kept of one system: those that were asked for first are dropped

Made = Callable[Concatenate[System, P], T]


def once(make: Made[P, T]) -> Made[P, T]:
    """A function of a system, and of things that can be looked up, that is called once for each of them.

    What it makes must not be written to, and must not hold the system.
    """
    return _kept(make, lambda system: system)


def once_alike(make: Made[P, T]) -> Made[P, T]:
    """As `once`, called once for all systems of the same structure: it must not look at numbers, names, or curves."""
    return _kept(make, lambda system: system.structure)


def _kept(make: Made[P, T], owner_of: Callable[[System], Any]) -> Made[P, T]:
    kept: WeakKeyDictionary[Any, dict[Any, T]] = WeakKeyDictionary()

    @wraps(make)
    def found(system: System, /, *args: P.args, **kwargs: P.kwargs) -> T:
        made, key = kept.setdefault(owner_of(system), {}), (args, *sorted(kwargs.items()))
        value = made.get(key)
        if value is None:
            value = make(system, *args, **kwargs)
            while len(made) >= MOST:
                made.pop(next(iter(made)), None)
            made[key] = value
        return value

    return found
