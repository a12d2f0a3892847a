"""Rendering of models and results: they can draw themselves, but do not import what draws them.

The package registers its views when it is imported; they are loaded when the first figure, page or table is made.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_loaders: list[Callable[[], Any]] = []


def register(load: Callable[[], Any]) -> None:
    """Let a module draw from now on; it has the functions of `sarrus.views`."""
    _loaders.append(load)


def renderer() -> Any:
    """The module that was registered last, loaded."""
    return _loaders[-1]()
