"""Compensated weights of an MJCF model, ``gravcomp``."""

from __future__ import annotations

from typing import Any

from ..bodies import names_of
from ..flags import disabled, no_passive_forces


def lifted_by(compiled: Any) -> dict[str, float]:
    """Return the part of its weight that is taken from each body."""
    if disabled(compiled, "GRAVITY") or no_passive_forces(compiled):
        return {}
    return dict(zip(names_of(compiled), map(float, compiled.body_gravcomp), strict=True))
