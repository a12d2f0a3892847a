"""The formulas of a validated model file, by the place of the number that they give."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..expression import Expression
from ..origin import Path
from .entry import Entry
from .numbers import Computed


def formulas(entry: Any, path: Path = ()) -> Iterator[tuple[Path, Expression]]:
    """Yield path and formula of every number that a formula gave."""
    if isinstance(entry, Computed):
        yield path, entry.expression
    for step, value in _entries(entry):
        yield from formulas(value, (*path, step))


def _entries(entry: Any) -> Iterator[tuple[str | int, Any]]:
    if isinstance(entry, Entry):
        for name, field in type(entry).model_fields.items():
            yield field.alias or name, getattr(entry, name)
    elif isinstance(entry, Mapping):
        yield from entry.items()
    elif isinstance(entry, list | tuple):
        yield from enumerate(entry)
