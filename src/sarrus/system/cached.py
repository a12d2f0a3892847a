"""Cache of derived data of a system, or of all systems of the same structure, for as long as these exist."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

from .system import System

P = ParamSpec("P")
T = TypeVar("T")
MOST = 32  # cached values of one function for one system: the oldest are dropped

Made = Callable[Concatenate[System, P], T]


def once(make: Made[P, T]) -> Made[P, T]:
    """Cache a function of a system and of hashable arguments: it is called once for each combination.

    The result must not be modified, and must not refer to the system.
    """
    return _cached(make, lambda system: system)


def once_alike(make: Made[P, T]) -> Made[P, T]:
    """As `once`, for all systems of one structure: the function must not use parameter values, names, or curves."""
    return _cached(make, lambda system: system.structure)


def _cached(make: Made[P, T], owner_of: Callable[[System], Any]) -> Made[P, T]:
    cache: WeakKeyDictionary[Any, dict[Any, T]] = WeakKeyDictionary()

    @wraps(make)
    def found(system: System, /, *args: P.args, **kwargs: P.kwargs) -> T:
        owner, key = owner_of(system), (args, *sorted(kwargs.items())) if kwargs else args
        made = cache.get(owner)  # cheaper than `setdefault`, which makes a new reference in each call
        if made is None:
            made = cache.setdefault(owner, {})
        value = made.get(key)
        if value is None:
            value = make(system, *args, **kwargs)
            while len(made) >= MOST:
                made.pop(next(iter(made)), None)
            made[key] = value
        return value

    return found
