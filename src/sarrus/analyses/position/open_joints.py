"""Joints that an assembly leaves open, with their gaps, and fixed joints that it closes half a revolution away."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...algebra import Array
from ...euler import A
from ...model.geometry.pose import GROUND_POSE, Pose, Poses
from ...model.geometry.solid import GROUND
from ...model.joints.fixed import Fixed
from ...system import System
from .restraint import restraint

SHOWN = 4  # joints that are named
PART = 1e-3  # of the largest gap, below which a joint is not worth a word


def open_joints(
    system: System, q: Array, residual: Array, allowed: Array, t: float, per_second: bool = False
) -> str:
    """For example "post by 0.02 m, hinge by 0.013 rad"; the widest gap first, nothing if all are closed.

    Parameters
    ----------
    system : System
    q : (nq,)
    residual : (m,) Φ, or Φ_q v + Φ_t for gaps that open `per_second`
    allowed : (m,) equations that hold so well are closed
    t : time [s]
    """
    J, found = system.Phi_q(q, t), []
    for joint, rows in system.rows.items():
        gaps: dict[str, float] = {}
        for row in rows[abs(residual[rows]) > allowed[rows]]:
            there = restraint(J, int(row), q)
            xi = there.displacement(system.nq)
            curvature = 0.0 if per_second else float((system.Phi_q_xi_q(q, xi, t) @ xi)[row])
            gap = there.gap(float(residual[row]), curvature)
            gaps[there.unit] = float(np.hypot(gaps.get(there.unit, 0.0), gap))
        found += [(gap, joint, unit) for unit, gap in gaps.items()]
    return _words(sorted(found, reverse=True), "/s" if per_second else "")


def _words(found: list[tuple[float, str, str]], rate: str) -> str:
    gaps = [f"{joint} by {gap:.3g} {unit}{rate}" for gap, joint, unit in found if gap > PART * found[0][0]]
    more = f" and {len(gaps) - SHOWN} more" if len(gaps) > SHOWN else ""
    return ", ".join(gaps[:SHOWN]) + more


def turned_over(system: System, q: Array) -> Iterator[str]:
    """Yield one message for each fixed joint whose frames differ by half a revolution: right angles hold there, too."""
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
