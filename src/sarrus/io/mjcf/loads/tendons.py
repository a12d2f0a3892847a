"""Tendons of an MJCF model: fixed ones over joints, and spatial ones over sites and pulleys, around shapes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....model.geometry.motion import unit
from ....model.geometry.rotation import matrix
from ....model.quantity import triple
from ....model.show import quote
from ...robot import Obstacle, Path, TendonForces
from ..compiled import disabled, name_of
from .compliance import STATIONARY, compliance

JOINT, PULLEY, SITE, SPHERE, CYLINDER = range(1, 6)  # mjtWrap


def tendons_of(compiled: Any, limits: bool) -> dict[str, TendonForces]:
    """Return the supported tendons with forces by name, with their stops if wanted."""
    supported = (k for k in range(compiled.ntendon) if is_supported(compiled, k))
    forces = {tendon_name(compiled, k): _forces(compiled, k, limits) for k in supported}
    return {name: tendon for name, tendon in forces.items() if any(tendon[1:])}


def tendon_name(compiled: Any, k: int) -> str:
    """Return the name of a tendon."""
    return name_of(compiled, "tendon", k)


def is_supported(compiled: Any, k: int) -> bool:
    """Return whether a tendon has no spring that yields."""
    spring = _polynomial(compiled, k, "stiffness")
    return not (any(spring.values()) and np.any(getattr(compiled, "tendon_springyield", np.zeros(k + 1))[k]))


def path_of(compiled: Any, k: int) -> Path:
    """Return the way of a tendon."""
    kinds = compiled.wrap_type[_wraps(compiled, k)]
    return _over_joints(compiled, k) if kinds[0] == JOINT else _over_sites(compiled, k)


def _wraps(compiled: Any, k: int) -> slice:
    first = int(compiled.tendon_adr[k])
    return slice(first, first + int(compiled.tendon_num[k]))


def _over_joints(compiled: Any, k: int) -> Path:
    """Return a fixed tendon: sum of factors times joints, which are relative to the file's pose here."""
    wraps, factors, start = _wraps(compiled, k), dict[str, float](), 0.0
    for joint, factor in zip(compiled.wrap_objid[wraps], compiled.wrap_prm[wraps], strict=True):
        name = name_of(compiled, "joint", joint)
        factors[name] = factors.get(name, 0.0) + float(factor)
        start += float(factor * compiled.qpos0[compiled.jnt_qposadr[joint]])
    return Path(joints=factors, start=start)


def _over_sites(compiled: Any, k: int) -> Path:
    """Return a spatial tendon; a segment counts one over the divisor of the pulley before it."""
    wraps = _wraps(compiled, k)
    entries = list(
        zip(compiled.wrap_type[wraps], compiled.wrap_objid[wraps], compiled.wrap_prm[wraps], strict=True)
    )
    factor, weights, around = 1.0, list[float](), list[Obstacle | None]()
    before, shape = PULLEY, None
    for kind, place, number in entries:
        if kind == PULLEY:
            factor = 1 / float(number)
        elif kind == SITE:
            weights.append(factor if before != PULLEY else 0.0)
            around.append(shape)
        shape = _obstacle(compiled, int(place), number, kind == CYLINDER) if kind > SITE else None
        before = kind
    sites = [int(site) for kind, site, _ in entries if kind == SITE]
    points = tuple(
        (name_of(compiled, "body", compiled.site_bodyid[n]), triple(compiled.site_pos[n])) for n in sites
    )
    return Path(points=points, factors=tuple(weights[1:]), around=around[1:] if any(around) else ())


def _obstacle(compiled: Any, shape: int, side: Any, cylinder: bool) -> Obstacle:
    """Return a sphere or cylinder, with a site at its side if it has one."""
    site = round(float(side))
    axis = matrix(unit(np.array(compiled.geom_quat[shape], dtype=float)))[:, 2] if cylinder else None
    return Obstacle(
        name_of(compiled, "body", compiled.geom_bodyid[shape]),
        triple(compiled.geom_pos[shape]),
        float(compiled.geom_size[shape, 0]),
        None if axis is None else triple(axis),
        (name_of(compiled, "body", compiled.site_bodyid[site]), triple(compiled.site_pos[site]))
        if site >= 0
        else None,
    )


def _forces(compiled: Any, k: int, limits: bool) -> TendonForces:
    path, fields = path_of(compiled, k), dict[str, float]()
    spring = {} if disabled(compiled, "SPRING") else _polynomial(compiled, k, "stiffness")
    if any(spring.values()):
        shortest, longest = (float(x) for x in compiled.tendon_lengthspring[k])
        fields |= spring | {"shortest": shortest, "longest": longest}
    if not disabled(compiled, "DAMPER"):
        fields |= _polynomial(compiled, k, "damping")
    if compiled.tendon_frictionloss[k] and not disabled(compiled, "FRICTIONLOSS"):
        fields["friction"] = float(compiled.tendon_frictionloss[k])
    if hasattr(compiled, "tendon_armature"):  # since MuJoCo 3.2
        fields["inertia"] = float(compiled.tendon_armature[k])
    if limits and compiled.tendon_limited[k] and not disabled(compiled, "LIMIT"):
        fields |= _stop(compiled, k)
    return TendonForces(path, **fields)


def _polynomial(compiled: Any, k: int, word: str) -> dict[str, float]:
    """Return the factors of a spring or damper; those of the square and higher powers since MuJoCo 4."""
    higher = getattr(compiled, f"tendon_{word}poly", np.zeros((k + 1, 0)))[k]
    powers = {f"{word}_{power}": float(factor) for power, factor in enumerate(higher, 2)}
    return {word: float(getattr(compiled, f"tendon_{word}")[k])} | powers


def stationary_limits(compiled: Any) -> int:
    """Return how many limited tendons have a length that is stationary in the pose of the file."""
    limited = [k for k in range(compiled.ntendon) if compiled.tendon_limited[k] and is_supported(compiled, k)]
    return 0 if disabled(compiled, "LIMIT") else sum(_is_stationary(compiled, k) for k in limited)


def _is_stationary(compiled: Any, k: int) -> bool:
    return (
        float(compiled.tendon_invweight0[k]) * _largest_mass(compiled, k)
        < STATIONARY
        < _largest_mass(compiled, k)
    )


def _largest_mass(compiled: Any, k: int) -> float:
    """Return the largest mass of a body at the sites of a tendon, with what hangs on it; 0 for a fixed tendon."""
    sites = compiled.wrap_objid[_wraps(compiled, k)][compiled.wrap_type[_wraps(compiled, k)] == SITE]
    bodies = compiled.body_weldid[compiled.site_bodyid[sites]]
    return float(max(compiled.body_subtreemass[bodies[bodies > 0]], default=0.0))


def _stop(compiled: Any, k: int) -> dict[str, float]:
    inverse = float(compiled.tendon_invweight0[k])
    if _is_stationary(compiled, k):
        inverse = 1 / _largest_mass(compiled, k)
    if not inverse:  # its length is constant
        return {}
    part = f"tendon {quote(tendon_name(compiled, k))}"
    law = compliance(compiled, compiled.tendon_solref_lim[k], compiled.tendon_solimp_lim[k], inverse, part)
    margin, (lower, upper) = float(compiled.tendon_margin[k]), (float(x) for x in compiled.tendon_range[k])
    ends = {"lower": lower + margin, "upper": upper - margin}
    return ends | {"stop": law.stiffness, "loss": law.damping}
