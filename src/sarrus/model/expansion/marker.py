"""The place where a joint, coupling or driver acts: bodies, a point on each, axes on the first. For reactions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from ..drivers.of_states import DrivenByStates
from ..geometry.placement import Frames
from ..geometry.points import GROUND
from ..geometry.pose import Poses
from ..model import Model
from ..quantity import Array
from .blueprint import Placement, blueprint


class Marker(NamedTuple):
    """Names of body i and j, the joint's point on each in body axes [m], and its axes f, g, h on body i as columns.

    `joint` is the joint whose place this is. A coupling acts on the bodies of other joints, too, and is `coupled`.
    """

    body_i: str
    body_j: str
    s_i: Array
    s_j: Array
    axes_i: Array
    joint: str
    coupled: bool = False


@runtime_checkable
class FramedPart(Protocol):
    """A part that has a frame on each of two bodies."""

    def frames(self, poses: Poses) -> Frames: ...


@runtime_checkable
class JointDriver(Protocol):
    """A driver of a joint's angle or displacement, ``pin`` or ``hook.angle_i``."""

    joint: str


@runtime_checkable
class CouplingPart(Protocol):
    """A coupling, with the joint whose coordinate follows that of another."""

    @property
    def follower(self) -> str: ...


def marker(model: Model, name: str) -> Marker:
    """The marker of a joint or driver of a model that was found to be right.

    From its frames; of a driver, from the joint that it drives; of a coupling, from the joint that follows; of others,
    from the points of their first element that has two, with the axes of body i.
    """
    part = next(part for parts in model.sections().values() for part in parts if part.name == name)
    if isinstance(part, FramedPart):
        i, j = part.frames(model.design_poses())
        return Marker(i.body, j.body, np.array(i.s), np.array(j.s), np.column_stack([i.f, i.g, i.h]), name)
    if isinstance(part, CouplingPart):
        return marker(model, part.follower.partition(".")[0])._replace(coupled=True)
    if isinstance(part, JointDriver):
        return marker(model, part.joint.split(".")[0])
    return _from_elements(model, name)


def _from_elements(model: Model, name: str) -> Marker:
    plan = blueprint(model)
    placed = [p for p in plan.placed if p.owner == name]
    own = [_of_bodies(p) for p in placed]
    bodies, values = next((one for one in own if "s_j" in one[1]), own[0])
    names = (GROUND, *plan.bodies)
    body_i, body_j = (0, bodies[0]) if len(bodies) == 1 else bodies[:2]
    values["s_j"] = values.get("s_j", values.get("s", np.zeros(3)))
    s_i, s_j = (np.array(values.get(key, np.zeros(3)), dtype=float) for key in ("s_i", "s_j"))
    return Marker(names[body_i], names[body_j], s_i, s_j, np.eye(3), name)


def _of_bodies(placed: Placement) -> tuple[Sequence[int], dict[str, Any]]:
    """The numbers of an element's bodies, without blocks of states, and its values by field."""
    kind, fields = placed.element, [field for field, kind in placed.element.fields.items() if kind != "Time"]
    values = dict(zip(fields, placed.values, strict=False))
    if not issubclass(kind, DrivenByStates):
        return placed.bodies, values
    last = len(kind.structure.parts) - 1
    driven = kind.structure.parts[last]
    return [placed.bodies[n] for n in driven.places], {x: values[f"{x}_{last}"] for x in driven.kind.fields}
