"""Joints of another kind than in the URDF: what it gives for their coordinates is left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ...model.show import quote
from ..robot import Description, Edge


def retyped(description: Description, edges: Sequence[Edge]) -> Description:
    """Return the description with other motions of its edges, and notes on what refers to motions of another kind.

    Damping remains where a rotation becomes a ball of the same name.
    """
    before, after = (
        {motion.name: type(motion) for edge in given for motion in edge.motions}
        for given in (description.edges, edges)
    )
    changed = {name for name in {*before, *after} if before.get(name) is not after.get(name)}
    lost = {
        "dynamics": changed - after.keys(),
        "limits": changed,
        "mimics": {name for name, mimic in description.mimics.items() if {name, mimic.joint} & changed},
        "actuators": {name for name, one in description.actuators.items() if {*one.motions()} & changed},
    }
    rest, notes = dict[str, Any](), [*description.notes]
    for section, names in lost.items():
        given = getattr(description, section)
        rest[section] = {name: value for name, value in given.items() if name not in names}
        out = ", ".join(quote(name) for name in given if name in names)
        notes += [f"{section} of {out}: left out, as `joint_type` has another kind of joint"] if out else []
    return replace(description, edges=edges, notes=notes, **rest)
