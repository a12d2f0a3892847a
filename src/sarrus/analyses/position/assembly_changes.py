"""Changes by assembly of the positions and velocities that a model gives, by body."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...algebra import Array
from ...euler import E, G
from ...model.errors import listed
from ...system import System
from ..equations.length import extent
from .velocity import given_velocities

# Of the size of the mechanism, of a radian, and of a given velocity: models are written with few digits
ACCURACY = 1e-3
NEGLIGIBLE = 1e-9  # of the largest given velocity: smaller ones count as zero


def position_changes(system: System, q: Array, assembled: Array) -> Iterator[str]:
    """Bodies whose position or orientation differs by more than `ACCURACY`, with both values."""
    size = extent(system, q)
    for name, (r, p), (r_new, p_new) in _poses(system, q, assembled):
        if np.linalg.norm(r_new - r) > ACCURACY * size:
            yield f"{name}: position {_vector(r)} became {_vector(r_new)} m"
        turn = 2 * np.arcsin(min(1.0, float(np.linalg.norm(E(p) @ p_new))))
        if turn > ACCURACY:
            yield f"{name}: orientation changed by {np.degrees(turn):.4g} deg"


def velocity_changes(
    system: System, q: Array, v: Array, assembled_q: Array, assembled_v: Array
) -> Iterator[str]:
    """Bodies whose given velocity, or angular velocity in body axes, differs by more than `ACCURACY` of itself.

    One of zero is compared with the largest that is given.
    """
    states = zip(_poses(system, q, assembled_q), _poses(system, v, assembled_v), strict=True)
    chosen = given_velocities(system, v).reshape(-1, 7)
    kinds: tuple[list[tuple[str, Array, Array]], ...] = ([], [])
    for ((name, (_, p), (_, p_new)), (_, (rd, pd), (rd_new, pd_new))), of_body in zip(
        states, chosen, strict=False
    ):
        kinds[0].extend([(name, rd, rd_new)] * bool(of_body[0]))
        kinds[1].extend([(name, 2 * (G(p) @ pd), 2 * (G(p_new) @ pd_new))] * bool(of_body[3]))
    largest = [max((np.linalg.norm(before) for _, before, _ in bodies), default=0.0) for bodies in kinds]
    size = extent(system, q)
    scales = max(largest[0], size * largest[1]) * np.array([1, 1 / size])
    for quantity, unit, scale, bodies in zip(
        ("velocity", "angular velocity"), ("m/s", "rad/s"), scales, kinds, strict=True
    ):
        for name, before, new in bodies if scale else ():
            speed = float(np.linalg.norm(before))
            if np.linalg.norm(new - before) > ACCURACY * (speed if speed > NEGLIGIBLE * scale else scale):
                yield f"{name}: {quantity} {_both(before, new)} {unit}"


def warning(system: System, changes: tuple[str, ...]) -> list[str]:
    """Return one message for all changes."""
    if not changes:
        return []
    return [
        f"{system.name}: assembly changed the given initial state: {listed(changes, '; ')}. "
        "Correct the model, or give consistent rates of joints."
    ]


def _poses(
    system: System, q: Array, assembled: Array
) -> Iterator[tuple[str, tuple[Array, Array], tuple[Array, Array]]]:
    """Position and Euler parameters of each body in two states, or their rates."""
    old, new = (x[: system.moving].reshape(-1, 7) for x in (q, assembled))
    rows = zip(system.bodies, old, new, strict=True)
    for name, old, new in rows:
        yield name, (old[:3], old[3:]), (new[:3], new[3:])


def _both(before: Array, new: Array) -> str:
    """Both values: numbers where they have one direction along an axis in common, else vectors."""
    axes = np.flatnonzero(
        (abs(before) > NEGLIGIBLE * abs(before).max()) | (abs(new) > NEGLIGIBLE * abs(new).max())
    )
    if len(axes) == 1:
        return f"{before[axes[0]]:.4g} became {new[axes[0]]:.4g}"
    return f"{_vector(before)} became {_vector(new)}"


def _vector(x: Array) -> str:
    rounded = np.where(abs(x) > NEGLIGIBLE * abs(x).max(), x, 0.0)
    return f"({', '.join(f'{entry:.4g}' for entry in rounded)})"
