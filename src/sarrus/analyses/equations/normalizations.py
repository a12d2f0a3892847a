"""Indices of the normalizations of Euler parameters among the equations of a system."""

from __future__ import annotations

import numpy as np

from ...algebra import Array
from ...system import System


def normalizations(system: System) -> Array:
    """Mark the equations of the Euler parameters (m,)."""
    mark = np.ones(system.m, dtype=bool)
    for rows in system.rows.values():
        mark[rows] = False
    return mark
