"""Type checks of the bodies, points and frames of joints and forces, before they are used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from functools import cache
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints

from ..errors import ModelError
from ..geometry.frame import Frame
from ..geometry.point import Point
from ..geometry.solid import Solid
from ..show import show

WANTED: dict[type, tuple[str, str]] = {
    Solid: ("a body", "the Body object (or sarrus.ground)"),
    Point: ("a point of a body", "body.point(x, y, z)"),
    Frame: ("a frame of a body", "body.frame(point, z=...)"),
}


def check_connections(part: Any) -> None:
    """Raise a ModelError for the first field of a part that should hold a body, point or frame, but does not."""
    for field, kinds in _connections(part.__class__).items():
        value = getattr(part, field)
        if not isinstance(value, kinds):
            wanted = [WANTED[kind] for kind in kinds if kind in WANTED]
            message = " or ".join(words for words, _ in wanted)
            remedy = " or ".join(words for _, words in wanted)
            by_keyword = next(
                (name for name, own in _connections(part.__class__).items() if type(value) in own), ""
            )
            remedy = f"it as {by_keyword}=" if by_keyword else remedy
            raise ModelError(
                f"{field} must be {message}, but is {kind_of(value)}. Give {remedy}.", field=field
            )


@cache
def _connections(kind: Any) -> dict[str, tuple[type, ...]]:
    """The fields that hold bodies, points or frames, and what may stand there, as annotated."""
    try:
        hints = get_type_hints(kind)
    except (NameError, TypeError):  # the annotations of a user's class cannot be read
        return {}
    found = {field.name: _members(hints.get(field.name)) for field in fields(kind)}
    return {name: members for name, members in found.items() if set(members) & set(WANTED)}


def _members(hint: Any) -> tuple[type, ...]:
    members = () if get_origin(hint) is Sequence else get_args(hint) or (hint,)
    plain = all(isinstance(one, type) for one in members)
    return (
        tuple(one for one in members if one is not NoneType) + (NoneType,) * (NoneType in members)
        if plain
        else ()
    )


def kind_of(value: Any) -> str:
    """A value for a message: plain values as they are, anything else by its class."""
    if value is None or isinstance(value, str | bool | int | float | list | tuple | dict):
        return show(value)
    article = "an" if type(value).__name__[0] in "AEIOU" else "a"
    return f"{article} {type(value).__name__}"
