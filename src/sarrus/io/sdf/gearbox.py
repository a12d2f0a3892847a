"""Gearboxes: the angles of two hinges on a common link are in proportion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...model.geometry.motion import Turn
from ...model.quantity import Array
from ...model.show import quote
from ..robot import Edge, Mimic
from ..robot.description import WORLD
from . import frames
from .frames import Name
from .joint import AXES, axis_of, link_of
from .models import Models, Part
from .values import number


def gearbox(part: Part, models: Models, version: int, edges: Sequence[Edge]) -> tuple[str, Mimic]:
    """Return the hinge that follows, and what it follows: θ_2 = -ratio · θ_1.

    θ_1 is the angle from the reference body to the parent about the first axis, θ_2 that to the child about the second.
    """
    reader = part.reader
    body = reader.needed(
        part.element, "gearbox_reference_body", "<gearbox_reference_body>frame</gearbox_reference_body>"
    )
    name = models.frames.full(Name(body.text, part.scope), reader, body.line)
    reference, ends = models.frames.link(name), [link_of(part, tag, models) for tag in ("parent", "child")]
    there = models.frames.pose(ends[1])
    axes = [there.A @ axis_of(part, tag, models, version, there) for tag in AXES]
    (leader, one), (follower, other) = (
        _hinge(part, reference, end, axis, models, edges) for end, axis in zip(ends, axes, strict=True)
    )
    return follower, Mimic(leader, -number(part.element, "gearbox_ratio", reader, 1.0) * one * other)


def _hinge(
    part: Part, reference: str, end: str, axis: Array, models: Models, edges: Sequence[Edge]
) -> tuple[str, float]:
    """Return the hinge between two links, and the sign of its angle from the first to the second about an axis."""
    for edge in edges:
        ends = [frames.WORLD if link == WORLD else link for link in (edge.parent, edge.child)]
        if {*ends} == {reference, end} and len(edge.motions) == 1 and isinstance(edge.motions[0], Turn):
            along = models.frames.pose(edge.child).A @ edge.motions[0].axis @ axis
            return edge.motions[0].name, float(np.sign(along)) * (1.0 if ends[0] == reference else -1.0)
    message = f"there is no hinge between {quote(reference)} and {quote(end)}. Add a revolute joint there."
    raise part.reader.refusal(message, part.element.line)
