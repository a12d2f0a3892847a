"""Whether a model that was accepted can exist: what mechanics asks, written without the model's own checks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

SIGNED = (
    "c",
    "damping",
    "k",
    "stiffness",
    "radius",
    "area",
    "coefficient",
    "viscosity",
    "mass",
    "pitch_radius",
)
LOOSE = 1e-6  # [-] of unit vectors and of the triangle inequality, for rounded input


def nonsense(model: Any) -> Iterator[str]:
    """Yield what is impossible about an accepted model."""
    from sarrus.model.expansion.expand import expand

    expanded = expand(model)
    for body in expanded.bodies:
        yield from _body(body)
    for piece in expanded.pieces:
        for number in _numbers(piece.primitive.values):
            if not np.isfinite(number):
                yield f"{piece.owner}: {piece.primitive.label} holds {number}"
    for section, parts in model.sections().items():
        for part in parts if section == "forces" else ():
            yield from _force(part)
    if not np.all(np.isfinite(np.array(model.gravity, dtype=float))):
        yield "gravity is not finite"
    if len({body.name for body in model.bodies}) != len(model.bodies):
        yield "two bodies have one name"


def _body(body: Any) -> Iterator[str]:
    mass, inertia, center = body.mass
    xx, yy, zz, xy, xz, yz = (float(x) for x in inertia)
    moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    massless = mass == 0 and not np.any(inertia)  # a body that other masses are attached to
    if not massless and not (np.isfinite(mass) and mass > 0):
        yield f"{body.name}: mass {mass}"
    if not massless and not (moments[0] > 0 and moments[0] + moments[1] >= moments[2] * (1 - LOOSE)):
        yield f"{body.name}: principal moments {moments}"
    if abs(np.linalg.norm(body.pose.p) - 1) > LOOSE:
        yield f"{body.name}: Euler parameters {body.pose.p}"
    if not (np.isfinite(body.pose.r).all() and np.isfinite(body.rates).all() and np.isfinite(center).all()):
        yield f"{body.name}: position, rates or centre of mass are not finite"


def _force(force: Any) -> Iterator[str]:
    for name in SIGNED:
        value = getattr(force, name, 0.0)
        if (
            isinstance(value, int | float)
            and value < 0
            and not (name == "k" and type(force).__name__ in ("TSDA", "RSDA"))
        ):
            yield f"{type(force).__name__} {force.name}: {name} is {value}"


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, np.ndarray | list | tuple):
        for one in value:
            yield from _numbers(one)
    elif isinstance(value, int | float | np.number):
        yield float(value)
