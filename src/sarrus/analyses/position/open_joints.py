"""Text that lists the joints that are not closed, with their gaps."""

from __future__ import annotations

import numpy as np

from ...algebra import Array
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
