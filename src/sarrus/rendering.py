"""How models and results are shown: one line in a console, a table with a picture in a notebook."""

from __future__ import annotations

from typing import Any

from .console import printable
from .deferred import renderer


class Display:
    """Base class of objects with a line in a console and a table with a picture in a notebook."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if cls.__repr__ is Display.__repr__:
            cls.__repr__ = Display.__repr__  # type: ignore[method-assign]  # dataclasses would write all fields

    def headline(self) -> str:
        """A description in one line without the kind."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return printable(f"<{type(self).__name__} {self.headline()}>")

    def _repr_html_(self) -> str:
        return str(renderer().notebook_html(self))
