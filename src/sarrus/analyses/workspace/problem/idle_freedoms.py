"""Idle freedoms: bodies that can spin without moving anything else, as rods between two ball joints; they are locked.

A spin about the body's axis a is locked by a direction b of the body, normal to a, that stays normal to a direction g
of the ground. That holds wherever a is not parallel to g, which is chosen as far from a as the mechanism allows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from .... import elements
from ....algebra import Array
from ....euler import G
from ....linalg.svd import singular
from ....model.coordinates import WIDTH
from ....model.expansion.blueprint import Placed
from ....model.geometry.rotation import matrix
from .measures import Measure
from .rows import Problem

FREE = 1e-8  # of a singular value that counts as zero
STEADY = 1e-6  # of an axis that stays in the body


def locks(problem: Problem, positions: Sequence[Array]) -> list[Measure]:
    """Functions that hold all idle spins when they are fixed at zero; positions are scaled."""
    return [one for body in range(problem.n // WIDTH) for one in _of_body(problem, positions, body)]


def _of_body(problem: Problem, positions: Sequence[Array], body: int) -> Iterator[Measure]:
    own = slice(WIDTH * body, WIDTH * body + WIDTH)
    found = [_spin(problem.jacobian(q)[:, own], q[own][3:]) for q in positions]
    axes = [axis for axis in found if axis is not None]
    if not axes or len(axes) < len(found) or any(abs(axes[0] @ a) < 1 - STEADY for a in axes):
        return
    a = axes[0]
    seen = np.array([matrix(q[own][3:]) @ a for q in positions])
    g = np.linalg.eigh(seen.T @ seen)[1][:, 0]
    b = np.cross(a, matrix(problem.system.q0[own][3:]).T @ g)
    b /= np.linalg.norm(b)
    name = f"{problem.system.bodies[body]} does not spin"
    values = (tuple(g.tolist()), tuple(b.tolist()))
    yield Measure(name, Placed(elements.Dot1, (0, body + 1), values, name, "lock"), "form")


def _spin(J: Array, p: Array) -> Array | None:
    """The axis in the body about which it can turn alone, if there is just one."""
    _, sizes, right = singular(J)
    if np.count_nonzero(sizes > FREE * sizes[0]) != WIDTH - 1:
        return None
    omega = 2 * G(p) @ right[-1][3:]
    size = float(np.linalg.norm(omega))
    return np.asarray(omega / size) if size > FREE else None
