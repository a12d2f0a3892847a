"""Deprecated spellings of public names: accepted for one release, with a DeprecationWarning. All are listed here."""

from __future__ import annotations

import warnings
from typing import Any, TypeVar

C = TypeVar("C", bound=type)

ATTRIBUTES = {"StudyTable": {"to_pandas": "to_frame"}}  # by class


def accepts_deprecated_attributes(kind: C) -> C:
    """Decorate a class whose attributes also have the old names of `ATTRIBUTES`."""
    for old, new in ATTRIBUTES[kind.__name__].items():
        setattr(kind, old, _deprecated_attribute(kind.__name__, old, new))
    return kind


def _deprecated_attribute(kind: str, old: str, new: str) -> property:
    def get(self: Any) -> Any:
        warnings.warn(f"{kind}.{old} is deprecated. Use {new}.", DeprecationWarning, stacklevel=2)
        return getattr(self, new)

    return property(get, doc=f"The deprecated name of `{new}`.")
