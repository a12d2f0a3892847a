"""What elements remember between accepted states: numbers that are no design numbers, such as counted turns."""

from __future__ import annotations

import numpy as np

from ..algebra import Array
from ..elements import recorder
from ..elements.evaluation import element_from, partition
from .population import WIDTH, Population

GROUND = np.array(recorder.GROUND, dtype=float)


def local(p: Population, k: int, vector: Array, ground: Array) -> Array:
    """A vector of the system as element k of a population sees it; `ground` stands for the fixed body's part."""
    return np.concatenate([ground if f < 0 else vector[f : f + WIDTH] for f in firsts(p, k)])


def firsts(p: Population, k: int) -> list[int]:
    """First coordinate of each body of element k, negative for ground."""
    return [-WIDTH if slot < 0 else int(p.bodies[k, slot]) for slot in p.variant.slots]


def refresh(p: Population, memory: list[int], q: Array, b: Array, t: float) -> None:
    """Let every element of a population write its memory fields (given by place) at the coordinates q."""
    size, starts = p.kind.size(), np.cumsum([0, *p.kind.widths()])
    for k in range(p.count):
        at = p.at + k * size
        element = element_from(p.kind, b[at : at + size], b, t)
        values = element.remember(partition(p.kind, local(p, k, q, GROUND)))  # type: ignore[attr-defined]
        for field, value in zip(memory, values, strict=True):
            b[at + starts[field]] = value


def places(p: Population) -> list[int]:
    """Places of a population's memory fields among the system's numbers."""
    starts = np.cumsum([0, *p.kind.widths()])
    memory = [int(starts[n]) for n, kind in enumerate(p.kind.fields.values()) if kind == "Memory"]
    return [p.at + k * p.kind.size() + at for k in range(p.count) for at in memory]
