"""Joints that follow another joint: where they start, and what is done about them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...model.errors import ModelError
from ...model.quantity import Array
from ...model.show import quote
from .description import Description
from .robot import Mimic


def followers(told: Description, values: Mapping[str, Array]) -> dict[str, Array]:
    """Return where the following joints start, unless a value is given for them."""
    found = dict(values)
    for name in told.mimics:
        _follow(name, told.mimics, found)
    return found


def refuse_mimics(told: Description, locked: set[str]) -> None:
    """Raise a ModelError for the first following joint that can still move.

    A coordinate coupler is the place to fill: one for each entry of ``told.mimics``, between the two joints it names.
    """
    lines = {motion.name: edge.line for edge in told.edges for motion in edge.motions}
    for name, mimic in told.mimics.items():
        if name not in locked:
            sentence = f"follows joint {quote(mimic.joint)}, which is not coupled here yet"
            remedy = 'import it with mimic="free" as a joint of its own, or with mimic="lock" as a fixed one'
            where = told.where(lines.get(name, 0))
            raise ModelError(f"{sentence}; {remedy}", part=f"joint {quote(name)}", where=where)


def freed(told: Description, locked: set[str]) -> list[str]:
    """Return the sentence that says how many following joints move on their own."""
    n = len(set(told.mimics) - locked)
    return [f"{n} joints that follow another move freely"] if n else []


def _follow(name: str, mimics: Mapping[str, Mimic], found: dict[str, Array]) -> Array:
    if name not in found:
        found[name] = np.zeros(1)
        if name in mimics:
            leader, multiplier, offset = mimics[name]
            found[name] = multiplier * _follow(leader, mimics, found) + offset
    return found[name]
