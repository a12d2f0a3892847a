"""Integration methods by name, as the command line and files of studies call them. Those of users register themselves.

Those of Sarrus are imported when they are first used: the help of the command line is quick.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, TypeVar

Make = TypeVar("Make", bound=Callable[..., Any])

METHODS: dict[
    str, str | Callable[..., Any]
] = {  # the default one first; texts are names in `sarrus.analyses`
    "radau": "Radau",
    "hht": "HHT",
    "generalizedalpha": "GeneralizedAlpha",
    "ode": "ODE",
}
STORING_STEPS = ["radau", "hht", "generalizedalpha"]  # those with derivatives


def method_named(name: str) -> Callable[..., Any]:
    """The class of a method, or the function that returns its `Description`."""
    make = METHODS[name]
    return getattr(import_module(__package__), make) if isinstance(make, str) else make


def method_of(method: Any) -> Any:
    """The method of a name, with its options at their defaults; anything else remains."""
    known = isinstance(method, str) and method.lower() in METHODS
    return method_named(method.lower())() if known else method


def integration_method(make: Make) -> Make:
    """Register a class of methods, or a function that returns a `Description`: by its name in lower case.

    Its arguments are options of the method in files of studies; all have defaults.
    """
    METHODS[make.__name__.lower()] = make
    STORING_STEPS.append(make.__name__.lower())
    return make
