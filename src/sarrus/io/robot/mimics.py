"""Joints that follow another joint: where they start, which stand still, and what couples the others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ...model import Coupler
from ...model.errors import ModelError
from ...model.quantity import Array
from ...model.show import quote
from .description import Description, Edge, Mimic, legal
from .joints import coordinate_of
from .merge import Merged


def followers(description: Description, values: Mapping[str, Array]) -> dict[str, Array]:
    """Return where the following joints start, unless a value is given for them."""
    found = dict(values)
    for name in description.mimics:
        _follow(name, description.mimics, found)
    return found


def standing(mimics: Mapping[str, Mimic], locked: set[str]) -> set[str]:
    """Return the joints that follow one that does not move, or follow by nothing."""
    still = set(locked)
    for _ in mimics:
        still |= {name for name, mimic in mimics.items() if mimic.joint in still or not mimic.multiplier}
    return still


def couplers(
    description: Description, merged: Merged, joints: Mapping[str, str], taken: set[str]
) -> Iterator[Coupler]:
    """Yield a coupler for each following joint that moves; ``joints`` are the joints' names by edge.

    Raises
    ------
    ModelError
        If the value of a joint cannot be computed because it is part of a combined joint.
    """
    edges = {motion.name: edge for edge in merged.edges for motion in edge.motions}
    moving = {name: mimic for name, mimic in description.mimics.items() if name in edges}
    names = legal([f"{name}_mimic" for name in moving], taken, "_coupler")
    for (name, mimic), made in zip(moving.items(), names.values(), strict=True):
        (leader, one), (follower, other) = (
            _place(description, name, motion, edges[motion], joints) for motion in (mimic.joint, name)
        )
        yield Coupler(made, leader, follower, mimic.multiplier * one * other, mimic.offset * other)


def freed(description: Description, locked: set[str]) -> list[str]:
    """Return the message on how many following joints move independently."""
    n = len(set(description.mimics) - locked)
    return [f"{n} joints that follow another move freely"] if n else []


def _place(
    description: Description, name: str, motion: str, edge: Edge, joints: Mapping[str, str]
) -> tuple[str, float]:
    """Return the coordinate of a motion, such as ``hook.angle``, and its sign."""
    found = coordinate_of(edge.motions, motion)
    if found is None:
        message = f"cannot follow: {quote(motion)} neither rotates about one axis nor slides along one"
        remedy = 'Let it follow another joint, or import it with mimic="free" or mimic="lock".'
        raise ModelError(
            f"{message}. {remedy}", part=f"joint {quote(name)}", where=description.where(edge.line)
        )
    return f"{joints[edge.name]}.{found[0]}", found[1]


def _follow(name: str, mimics: Mapping[str, Mimic], found: dict[str, Array]) -> Array:
    if name not in found:
        found[name] = np.zeros(1)
        if name in mimics:
            leader, multiplier, offset = mimics[name]
            found[name] = multiplier * _follow(leader, mimics, found) + offset
    return found[name]
