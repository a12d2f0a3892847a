"""Forces of the fluid around the bodies of an MJCF model, by their boxes of equal inertia.

Bodies whose shapes have the coefficients of MuJoCo's other model, with lift and added masses, are not supported.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ....model import BoxDrag
from ....model.geometry.solid import GROUND
from ....model.quantity import Array, triple
from ...robot import Robot
from ..bodies import names_of, placed
from ..flags import no_passive_forces

SMALLEST = 1e-15  # MuJoCo's least moment of inertia


def fluid_forces(compiled: Any, robot: Robot) -> Iterator[BoxDrag]:
    """Yield a force for each moving body with mass."""
    if not _has_fluid(compiled):
        return
    links = names_of(compiled)
    moving = [
        k
        for k in range(compiled.nbody)
        if compiled.body_mass[k] and links[k] in robot.links and robot.link(links[k]).body.name != GROUND
    ]
    names = robot.free_names([f"{links[k]}_fluid" for k in moving], "_force")
    law = {"density": float(compiled.opt.density), "viscosity": float(compiled.opt.viscosity)}
    for name, k in zip(names, moving, strict=True):
        place = placed(compiled.body_ipos[k], compiled.body_iquat[k])
        frame = robot.frame(links[k], triple(place.r), x=place.A[:, 0], z=place.A[:, 2])
        box = triple(_box(compiled.body_mass[k], compiled.body_inertia[k]))
        yield BoxDrag(name, frame, box, **law, wind=triple(compiled.opt.wind))


def other_fluids(compiled: Any) -> int:
    """Return how many shapes have the coefficients of the other model of a fluid."""
    return int(np.count_nonzero(compiled.geom_fluid[:, 0])) if _has_fluid(compiled) else 0


def _has_fluid(compiled: Any) -> bool:
    some = compiled.opt.density > 0 or compiled.opt.viscosity > 0
    return bool(some and compiled.nv and not no_passive_forces(compiled))


def _box(mass: Any, moments: Any) -> Array:
    """Return the sides of the box with a mass and moments of inertia."""
    sums = moments.sum() - 2 * moments
    return np.asarray(np.sqrt(np.maximum(sums, SMALLEST) / mass * 6))
