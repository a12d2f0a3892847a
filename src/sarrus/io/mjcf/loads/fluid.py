"""Forces of the fluid around the bodies of an MJCF model, by their boxes of equal inertia or by their shapes.

On a body one of whose shapes has coefficients of lift (`fluidshape`), forces act on its shapes that have them, and not
on the box.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from ....model import BoxDrag, EllipsoidDrag, Force, Frame
from ....model.geometry.pose import Pose
from ....model.geometry.solid import GROUND
from ....model.quantity import Array, Vec3, triple
from ...robot import Robot
from ..bodies import names_of, placed
from ..compiled import name_of
from ..flags import no_passive_forces

SPHERE, CAPSULE, CYLINDER = 2, 3, 5  # mjtGeom
SMALLEST = 1e-15  # MuJoCo's least moment of inertia


def fluid_forces(compiled: Any, robot: Robot) -> Iterator[Force]:
    """Yield the forces on all moving bodies with mass: on shapes with coefficients of lift, or else on the box."""
    if not _has_fluid(compiled):
        return
    links = names_of(compiled)
    found = list[tuple[str, Callable[[str], Force]]]()
    law: dict[str, Any] = {"density": float(compiled.opt.density), "viscosity": float(compiled.opt.viscosity)}
    law["wind"] = triple(compiled.opt.wind)
    for k, link in enumerate(links):
        if not compiled.body_mass[k] or link not in robot.links or robot.link(link).body.name == GROUND:
            continue
        first, count = compiled.body_geomadr[k], compiled.body_geomnum[k]
        shapes = [n for n in range(first, first + count) if compiled.geom_fluid[n, 0]]
        for n in shapes:
            place = placed(compiled.geom_pos[n], compiled.geom_quat[n])
            given: dict[str, Any] = {"frame": _frame(robot, link, place), "semiaxes": _semiaxes(compiled, n)}
            given |= _coefficients(compiled, n)
            found.append((f"{name_of(compiled, 'geom', n)}_fluid", partial(EllipsoidDrag, **given, **law)))
        if not shapes:
            place = placed(compiled.body_ipos[k], compiled.body_iquat[k])
            box = triple(_box(compiled.body_mass[k], compiled.body_inertia[k]))
            given = {"frame": _frame(robot, link, place), "box": box}
            found.append((f"{link}_fluid", partial(BoxDrag, **given, **law)))
    names = robot.free_names([name for name, _ in found], "_force")
    yield from (force(name) for name, (_, force) in zip(names, found, strict=True))


def _has_fluid(compiled: Any) -> bool:
    some = compiled.opt.density > 0 or compiled.opt.viscosity > 0
    return bool(some and compiled.nv and not no_passive_forces(compiled))


def _frame(robot: Robot, link: str, place: Pose) -> Frame:
    return robot.frame(link, triple(place.r), x=place.A[:, 0], z=place.A[:, 2])


def _semiaxes(compiled: Any, shape: int) -> Vec3:
    """Return the semi-axes of MuJoCo's ellipsoid for a shape."""
    a, b, c = (float(one) for one in compiled.geom_size[shape])
    kind = compiled.geom_type[shape]
    if kind == SPHERE:
        return a, a, a
    return {CAPSULE: (a, a, b + a), CYLINDER: (a, a, b)}.get(int(kind), (a, b, c))


def _coefficients(compiled: Any, shape: int) -> dict[str, Any]:
    """Return the coefficients of drag, lift and added mass of a shape."""
    _, *given = (float(one) for one in compiled.geom_fluid[shape])
    names = "blunt_drag", "slender_drag", "angular_drag", "kutta_lift", "magnus_lift"
    density = float(compiled.opt.density)
    virtual = [density * one for one in given[len(names) :]]
    return dict(zip(names, given, strict=False)) | {"added_mass": virtual[:3], "added_inertia": virtual[3:]}


def _box(mass: Any, moments: Any) -> Array:
    """Return the sides of the box with a mass and moments of inertia."""
    sums = moments.sum() - 2 * moments
    return np.asarray(np.sqrt(np.maximum(sums, SMALLEST) / mass * 6))
