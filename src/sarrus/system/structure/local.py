"""A system's vectors restricted to one element."""

from __future__ import annotations

import numpy as np

from ...algebra import Array
from ...elements import recorder
from ...model.coordinates import WIDTH
from .population import Population

GROUND = np.array(recorder.GROUND, dtype=float)


def local(p: Population, k: int, vector: Array, ground: Array) -> Array:
    """A vector of the system restricted to element k of a population; `ground` replaces the part of the fixed body."""
    return np.concatenate([ground if f < 0 else vector[f : f + WIDTH] for f in firsts(p, k)])


def firsts(p: Population, k: int) -> list[int]:
    """First coordinate of each body of element k, negative for the ground."""
    return [-WIDTH if slot < 0 else int(p.bodies[k, slot]) for slot in p.variant.slots]
