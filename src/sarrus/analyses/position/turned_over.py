"""Fixed joints that an assembly closes half a revolution away: right angles between axes hold there, too."""

from __future__ import annotations

from collections.abc import Iterator

from ...algebra import Array
from ...euler import A
from ...model.geometry.pose import GROUND_POSE, Pose, Poses
from ...model.geometry.solid import GROUND
from ...model.joints.fixed import Fixed
from ...system import System


def turned_over(system: System, q: Array) -> Iterator[str]:
    """Yield one message for each fixed joint whose frames differ by half a revolution."""
    fixed = [joint for joint in system.model.joints if isinstance(joint, Fixed)]
    if not fixed:
        return
    drawn, found = _poses(system, system.q0), _poses(system, q)
    for joint in fixed:
        i, j = joint.frames(drawn)
        axes = zip((i.f, i.g, i.h), (j.f, j.g, j.h), strict=True)
        if any((found[i.body].A @ a) @ (found[j.body].A @ b) < 0.0 for a, b in axes):
            yield (
                f"{joint.name}: {j.body} is turned over by 180 deg relative to {i.body}, which satisfies the "
                "equations of a fixed joint, too. Start the assembly from a nearer position."
            )


def _poses(system: System, q: Array) -> Poses:
    states = q[: system.moving].reshape(-1, 7)
    own = {name: Pose(x[:3], x[3:], A(x[3:])) for name, x in zip(system.bodies, states, strict=True)}
    return {GROUND: GROUND_POSE, **own}
