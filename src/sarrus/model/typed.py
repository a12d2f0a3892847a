"""A field's type, taken apart into what may stand there and what it measures."""

from __future__ import annotations

from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin, get_type_hints

from .measure import In


class Typed(NamedTuple):
    """A field's type, taken apart: the members of its union without None, and what it measures."""

    members: frozenset[Any]
    measure: In


def typed(annotation: Any) -> Typed:
    """Return the members of a field's type and its declared unit."""
    if get_origin(annotation) is Annotated:
        base, *marks = get_args(annotation)
        return Typed(typed(base).members, next((mark for mark in marks if isinstance(mark, In)), In("")))
    if get_origin(annotation) not in (Union, UnionType):
        return Typed(frozenset({annotation}) - {NoneType}, In(""))
    parts = [typed(part) for part in get_args(annotation)]
    measure = next((part.measure for part in parts if part.measure.unit), In(""))
    return Typed(frozenset().union(*(part.members for part in parts)), measure)


@cache
def measures(kind: type) -> dict[str, In]:
    """Return what each field of a dataclass measures."""
    hints = get_type_hints(kind, include_extras=True)
    return {name: typed(hint).measure for name, hint in hints.items()}
