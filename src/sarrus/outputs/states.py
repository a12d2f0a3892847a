"""First-order states by name: ``current``."""

from __future__ import annotations

from collections.abc import Iterator

from ..system import System
from .output import Level, Output, calls, provides


@provides
def states(system: System, part: str | None) -> Iterator[Output]:
    """The states of a part: of a `StateVariable` its own name, of others ``motor.current``."""
    for name, (place, unit, _) in system.states.items():
        if part in (None, name.partition(".")[0]):
            yield Output(name, unit, calls("input", "v", place), Level.VELOCITY)
