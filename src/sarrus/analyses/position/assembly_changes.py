"""Changes by assembly of the positions and velocities that a model gives, by body."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...algebra import Array
from ...model.errors import listed
from ...system import System
from ..equations.length import extent
from .velocity import given_velocities

# Of the size of the mechanism, of a radian, and of a given velocity: models are written with few digits
ACCURACY = 1e-3
NEGLIGIBLE = 1e-9  # of the largest given velocity: smaller ones count as zero


def position_changes(system: System, q: Array, assembled: Array) -> Iterator[str]:
    """Bodies whose position or orientation differs by more than `ACCURACY`, with both values."""
    (r, p), (r_new, p_new) = _poses(system, q), _poses(system, assembled)
    moved = np.linalg.norm(r_new - r, axis=1) > ACCURACY * extent(system, q)
    turns = 2 * np.arcsin(np.minimum(1.0, np.linalg.norm(_times_G(p, p_new), axis=1)))
    for k, name in enumerate(system.bodies):
        if moved[k]:
            yield f"{name}: position {_vector(r[k])} became {_vector(r_new[k])} m"
        if turns[k] > ACCURACY:
            yield f"{name}: orientation changed by {np.degrees(turns[k]):.4g} deg"


def velocity_changes(
    system: System, q: Array, v: Array, assembled_q: Array, assembled_v: Array
) -> Iterator[str]:
    """Bodies whose given velocity, or angular velocity in body axes, differs by more than `ACCURACY` of itself.

    One of zero is compared with the largest that is given.
    """
    (rd, omega), (rd_new, omega_new) = _rates(system, q, v), _rates(system, assembled_q, assembled_v)
    given, size = _poses(system, given_velocities(system, v)), extent(system, q)
    speeds = [np.linalg.norm(x, axis=1) for x in (rd, omega)]
    largest = [speed[those[:, 0]].max(initial=0.0) for speed, those in zip(speeds, given, strict=True)]
    scales = max(largest[0], size * largest[1]) * np.array([1, 1 / size])
    rows = (
        ("velocity", "m/s", given[0], rd, rd_new),
        ("angular velocity", "rad/s", given[1], omega, omega_new),
    )
    for (quantity, unit, those, before, new), speed, scale in zip(rows, speeds, scales, strict=True):
        least = ACCURACY * np.where(speed > NEGLIGIBLE * scale, speed, scale)
        changed = those[:, 0] & (np.linalg.norm(new - before, axis=1) > least) & bool(scale)
        for k, name in enumerate(system.bodies):
            if changed[k]:
                yield f"{name}: {quantity} {_both(before[k], new[k])} {unit}"


def warning(system: System, changes: tuple[str, ...]) -> list[str]:
    """Return one message for all changes."""
    if not changes:
        return []
    return [
        f"{system.name}: assembly changed the given initial state: {listed(changes, '; ')}. "
        "Correct the model, or give consistent rates of joints."
    ]


def _poses(system: System, q: Array) -> tuple[Array, Array]:
    """Of positions (bodies, 3) and Euler parameters (bodies, 4), or of their rates."""
    return q[system.layout.positions], q[system.layout.bodies.rotations]


def _rates(system: System, q: Array, v: Array) -> tuple[Array, Array]:
    """Velocities, and angular velocities in body axes (bodies, 3)."""
    (_, p), (rd, pd) = _poses(system, q), _poses(system, v)
    return rd, 2 * _times_G(p, pd)


def _times_G(p: Array, x: Array) -> Array:
    """G(p) x for each body (bodies, 3)."""
    return np.asarray(p[:, :1] * x[:, 1:] - x[:, :1] * p[:, 1:] - np.cross(p[:, 1:], x[:, 1:]))


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
