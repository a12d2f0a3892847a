"""Deprecated spellings of public names: accepted for one release, with a DeprecationWarning. All are listed here."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C", bound=type)

ATTRIBUTES = {"StudyTable": {"to_pandas": "to_frame"}}  # by class


def accepts_deprecated_attributes(kind: C) -> C:
    """Decorate a class whose attributes also have the old names of `ATTRIBUTES`."""
    for old, new in ATTRIBUTES[kind.__name__].items():
        setattr(kind, old, _deprecated_attribute(kind.__name__, old, new))
    return kind


def deprecated_function(old: str, new: str, function: Callable[P, R]) -> Callable[P, R]:
    """A function under its old name, at whose use the new one is named."""

    @wraps(function)
    def renamed(*args: P.args, **kwargs: P.kwargs) -> R:
        warnings.warn(f"{old} is deprecated. Use {new}.", DeprecationWarning, stacklevel=2)
        return function(*args, **kwargs)

    renamed.__name__ = renamed.__qualname__ = old
    return renamed


def _deprecated_attribute(kind: str, old: str, new: str) -> property:
    def get(self: Any) -> Any:
        warnings.warn(f"{kind}.{old} is deprecated. Use {new}.", DeprecationWarning, stacklevel=2)
        return getattr(self, new)

    return property(get, doc=f"The deprecated name of `{new}`.")
