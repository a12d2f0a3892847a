"""Outputs and coordinates of joints that have the same value in the mirror image about the plane y = 0."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import fields
from typing import Any

from .bodies.body import Body
from .errors import ModelError
from .expression import Expression, parse
from .geometry.points import Frame, Point, Solid
from .laws.curve import Curve, Formula, Tree
from .quantity import direction, is_list

OF_BODIES = (
    "x",
    "z",
    "velocity.x",
    "velocity.z",
    "acceleration.x",
    "acceleration.z",
)  # outputs that do not change


class EvenOutputs:
    """Which outputs do not change in the mirror image.

    Parameters
    ----------
    parts : the known parts by name
    own : the names of those that have an image; others are in the middle, such as a rack
    sided : all names of parts on a side
    """

    def __init__(self, parts: Mapping[str, Any], own: Collection[str], sided: Collection[str]) -> None:
        self.parts, self.own, self.sided = parts, own, sided

    def __call__(self, name: str) -> bool:
        """Return whether an output, or a coordinate of a joint, is known to have the same value."""
        return self._even(name, frozenset())

    def _even(self, name: str, read: frozenset[str]) -> bool:
        first, _, rest = name.partition(".")
        part = self.parts[first]
        if isinstance(part, Body):
            return rest in OF_BODIES
        if rest.endswith((".x", ".y", ".z")):
            return False
        if first in self.own:
            return _on_a_side(part, rest)
        if getattr(part, "free", ()):
            return self._central(part, rest)
        return first in read or self._signal(part, read | {first})

    def _central(self, joint: Any, rest: str) -> bool:
        """A displacement in the plane of symmetry is even, and an angle about its normal."""
        bodies = [getattr(joint, one, None) for one in ("body_i", "body_j")]
        axis = getattr(joint, "axis", None)
        if axis is None or any(body is None or body.name in self.sided for body in bodies):
            return False
        x, y, z = direction(axis, "axis")
        even = {"angle": x == 0.0 == z, "displacement": y == 0.0}
        return all(even.get(one, False) for one in _named(joint, rest))

    def _signal(self, part: Any, read: frozenset[str]) -> bool:
        """The value of a part without a place is even if all is that it reads."""
        values = [getattr(part, one.name) for one in fields(part) if one.init and one.name != "name"]
        for name in (name for value in values for name in _read(value)):
            first = name.partition(".")[0]
            known = first in self.parts and first not in self.sided
            if not name or first in self.sided or (known and not self._even(name, read)):
                return False
        return True


def _on_a_side(part: Any, rest: str) -> bool:
    """An axis is polar if displacements along it do not change, and axial if angles about it do not."""
    axial = part.parity.get("axis", part.parity.get("axis_i", "axial")) == "axial"
    return all(
        axial if one.startswith("angle") else not axial and one == "displacement"
        for one in _named(part, rest)
    )


def _named(part: Any, rest: str) -> list[str]:
    known = getattr(part, "free", ())
    return [one for one in known if rest.startswith(one)] or [*known]


def _read(value: Any) -> Iterator[str]:
    """The names that a field reads; an empty one for a place or a function."""
    if isinstance(value, Formula) and isinstance(value.function, Tree):
        value = value.function.tree
    if isinstance(value, str):
        try:
            value = parse(value)
        except ModelError:
            return
    if isinstance(value, Expression):
        yield from value.names()
    elif isinstance(value, Solid | Point | Frame) or (callable(value) and not isinstance(value, Curve)):
        yield ""
    elif isinstance(value, Mapping):
        for entry in (*value, *value.values()):
            yield from _read(entry)
    elif is_list(value):
        for entry in value:
            yield from _read(entry)
