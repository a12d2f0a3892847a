"""Outputs of the points on which forces act: ``push.position.x``."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from ..elements.forces.point_force import PointForce
from ..model.geometry.points import AXES
from ..system import System
from ..system.structure.population import Population, firsts
from .output import Output, provides


@provides
def positions(system: System, part: str | None) -> Iterator[Output]:
    """The global positions of the points of point forces."""
    for p in system.populations:
        for k, owner in enumerate(p.owners if issubclass(p.kind, PointForce) else ()):
            if part in (None, owner) and firsts(p, k)[0] >= 0:
                for n, axis in enumerate(AXES):
                    yield Output(f"{owner}.position.{axis}", "m", partial(_position, p, k, n))


def _position(p: Population, k: int, n: int, o: Any) -> Any:
    body = o.system.layout.owners[o.system.layout.owner_of[firsts(p, k)[0]]]
    return o.position(body, o.element(p, k, "b").s)[n]
