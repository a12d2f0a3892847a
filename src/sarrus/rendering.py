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


class Shown:
    """What is one line in a console, and a table with a picture in a notebook."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if cls.__repr__ is Shown.__repr__:
            cls.__repr__ = Shown.__repr__  # type: ignore[method-assign]  # dataclasses would write all fields

    def headline(self) -> str:
        """What it is, in one line without the kind."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.headline()}>"

    def _repr_html_(self) -> str:
        return str(renderer().notebook_html(self))
