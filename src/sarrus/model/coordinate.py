"""Coordinates of joints: angles and displacements that can be output, driven and coupled."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

import numpy as np

from .. import elements
from .._jit.formulas.functions import atan2
from ..elements import Element
from .checks.names import find
from .errors import ModelError
from .geometry.points import LocalFrame, LocalPoint
from .geometry.pose import Poses
from .primitive import Primitive
from .quantity import Array, Vec3, plain
from .show import quote, show, suggest

ANGLE, DISPLACEMENT = elements.Angle, elements.Displacement
WORDS: dict[type[Element], str] = {ANGLE: "angle", DISPLACEMENT: "displacement"}


class Coordinate(NamedTuple):
    """An angle or displacement of a joint: the element that measures it, its value in the design position, its name."""

    measure: Primitive
    start: float

    @property
    def name(self) -> str:
        """Its name among the coordinates of the joint: ``angle``, ``displacement``, ``angle_i``."""
        return self.measure.label


def is_angle(measure: Primitive) -> bool:
    """Whether a coordinate is an angle, which has revolutions."""
    return "Memory" in measure.element.fields.values()


Known: TypeAlias = Mapping[str, tuple[Coordinate, ...]]  # by the joint's name


def angle(
    i: LocalFrame, j: LocalFrame, poses: Poses, *, f_j: Vec3 | None = None, name: str = "angle"
) -> Coordinate:
    """The angle from f_i to f_j (or another vector of body j) about h_i. [rad]"""
    across = j.f if f_j is None else f_j
    start = angle_between((i.body, i.f), (i.body, i.g), (j.body, across), poses)
    return Coordinate(Primitive(ANGLE, (i.body, j.body), (i.f, i.g, across, 0.0, start), name), start)


def displacement(
    i: LocalFrame,
    j: LocalFrame | LocalPoint,
    poses: Poses,
    *,
    axis: Vec3 | None = None,
    name: str = "displacement",
) -> Coordinate:
    """Return the displacement of P_j from P_i along h_i, or along another vector of body i. [m]"""
    along = i.h if axis is None else axis
    apart = poses[j.body].global_point(np.array(j.s)) - poses[i.body].global_point(np.array(i.s))
    start = plain(turned(along, i.body, poses) @ apart)
    return Coordinate(Primitive(DISPLACEMENT, (i.body, j.body), (along, i.s, j.s, 0.0), name), start)


def heading(
    i: LocalFrame, j: LocalFrame, poses: Poses, *, from_start: bool, name: str = "angle"
) -> Coordinate:
    """The angle from f_i, or from where it is at the start, to the line from P_i to P_j, about h_i. [rad]"""
    apart = poses[j.body].global_point(np.array(j.s)) - poses[i.body].global_point(np.array(i.s))
    f, g = (plain(turned(vector, i.body, poses) @ apart) for vector in (i.f, i.g))
    start: float = atan2(g, f)
    zero = start if from_start else 0.0
    measure = Primitive(elements.Heading, (i.body, j.body), (i.f, i.g, i.s, j.s, zero, start), name)
    return Coordinate(measure, start - zero)


def angle_between(f: tuple[str, Vec3], g: tuple[str, Vec3], a: tuple[str, Vec3], poses: Poses) -> float:
    """The angle of a in the plane of f and g in the design position, each given with its body. [rad]"""
    f_, g_, a_ = (turned(vector, body, poses) for body, vector in (f, g, a))
    value: float = atan2(plain(g_ @ a_), plain(f_ @ a_))
    return value


def turned(local: Vec3, body: str, poses: Poses) -> Array:
    """A vector of a body in global axes, in the design position."""
    return np.asarray(find(body, poses, "body").A @ np.array(local))


def chosen(reference: str, kind: type[Element] | None, known: Known, field: str) -> Coordinate:
    """Return the coordinate that ``pin`` or ``pin.angle`` names, of a kind if one is wanted.

    Raises
    ------
    ModelError
        If there is no such joint, or none or several of its coordinates are meant.
    """
    given: object = reference
    if not isinstance(given, str):
        named = quote(getattr(given, "name", "pin"))
        message = f"{field} must be a joint's name, but is {show(given)}. Give {named}."
        raise ModelError(message, field=field)
    joint, _, name = reference.partition(".")
    if joint not in known:
        raise ModelError(f"there is no joint {quote(joint)}. {suggest(joint, known)}", field=field)
    word = "coordinate" if kind is None else WORDS[kind]
    fit = [c for c in known[joint] if c.measure.element in WORDS and kind in (None, c.measure.element)]
    matching = [c for c in fit if name in ("", c.name)]
    if len(matching) == 1:
        return matching[0]
    if not fit:
        own = ", ".join(f"{joint}.{c.name}" for c in known[joint]) or "none"
        raise ModelError(f"joint {quote(joint)} has no {word}. Its coordinates: {own}.", field=field)
    names = ", ".join(f"{joint}.{c.name}" for c in fit)
    which = f"no {word} {quote(name)}" if name else f"more than one {word}"
    raise ModelError(f"joint {quote(joint)} has {which}. Name one it has: {names}", field=field)
