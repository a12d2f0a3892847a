"""Compensated weights of an MJCF model, ``gravcomp``."""

from __future__ import annotations

from typing import Any

from ..bodies import names_of
from ..flags import disabled, no_passive_forces
from .actuators import count


def lifted_by(compiled: Any) -> dict[str, float]:
    """Return the part of its weight that is taken from each body."""
    if disabled(compiled, "GRAVITY") or no_passive_forces(compiled):
        return {}
    return dict(zip(names_of(compiled), map(float, compiled.body_gravcomp), strict=True))


def limited_lifts(compiled: Any) -> int:
    """Return how many joints compensate weights by their actuators, which are limited, switched off or missing."""
    if not any(lifted_by(compiled).values()):
        return 0
    missing = disabled(compiled, "ACTUATION") or not count(compiled)
    return int(((compiled.jnt_actgravcomp != 0) & ((compiled.jnt_actfrclimited != 0) | missing)).sum())
