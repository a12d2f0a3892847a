"""What do analyses make of a system only once: tables and patterns, kept as long as the system lives."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

from ..system import System

P = ParamSpec("P")
T = TypeVar("T")


def once(make: Callable[Concatenate[System, P], T]) -> Callable[Concatenate[System, P], T]:
    """A function of a system, and of things that can be looked up, that is called once for each of them.

    What it makes must not be written to, and must not hold the system.
    """
    kept: WeakKeyDictionary[System, dict[Any, T]] = WeakKeyDictionary()

    @wraps(make)
    def found(system: System, /, *args: P.args, **kwargs: P.kwargs) -> T:
        made, key = kept.setdefault(system, {}), (args, *sorted(kwargs.items()))
        if key not in made:
            made[key] = make(system, *args, **kwargs)
        return made[key]

    return found
