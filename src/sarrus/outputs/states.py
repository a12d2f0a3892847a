"""First-order states by name: ``current``."""

from __future__ import annotations

from collections.abc import Iterator

from ..system import System
from .output import Level, Output, calls, provides


@provides
def states(system: System, part: str | None) -> Iterator[Output]:
    """The states of a part: of a `StateVariable` its own name, of others ``motor.current``."""
    for kind, level, found in (
        ("v", Level.VELOCITY, system.states),
        ("q", Level.POSITION, system.followed_states),
    ):
        for name, (place, unit, _) in found.items():
            if part in (None, name.partition(".")[0]):
                yield Output(name, unit, calls("input", kind, place), level)
