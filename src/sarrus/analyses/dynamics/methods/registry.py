"""Integration methods by name, as the command line and files of studies call them. Each registers itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

Make = TypeVar("Make", bound=Callable[..., Any])

METHODS: dict[str, Callable[..., Any]] = {}  # the default one first
STORING_STEPS: list[str] = []  # those with derivatives


def integration_method(make: Make) -> Make:
    """Register a class of methods, or a function that returns a `Description`: by its name in lower case.

    Its arguments are options of the method in files of studies; all have defaults.
    """
    return _registered(make, stores_steps=True)


def solver(make: Make) -> Make:
    """Register the class of a solver of another library, whose steps cannot be stored."""
    return _registered(make, stores_steps=False)


def _registered(make: Make, *, stores_steps: bool) -> Make:
    METHODS[make.__name__.lower()] = make
    if stores_steps:
        STORING_STEPS.append(make.__name__.lower())
    return make
