"""Outputs of the whole system: time and energies."""

from __future__ import annotations

from collections.abc import Iterator

from ..system import System
from .output import Level, Output, calls, provides


@provides
def totals(system: System, part: str | None) -> Iterator[Output]:
    """``t``, ``energy.kinetic``, ``energy.potential``, their sum ``energy.total``, and ``energy.elastic``."""
    if part in (None, "t"):
        yield Output("t", "s", lambda o: o.t)
    if part in (None, "energy"):
        yield Output("energy.kinetic", "J", calls("kinetic_energy"), Level.VELOCITY)
        yield Output("energy.potential", "J", calls("potential_energy"))
        yield Output("energy.elastic", "J", calls("elastic_energy"), Level.VELOCITY)
        yield Output("energy.total", "J", lambda o: o.kinetic_energy() + o.potential_energy(), Level.VELOCITY)
