"""The start of a run: which equations are solved, and what elements remember."""

from __future__ import annotations

from ....algebra import Array
from ....results import Assembly
from ....system import System
from ...redundancy.redundant_constraints import InconsistentConstraints, Independence
from .stepper import RunFailure


def independence_at(system: System, start: Assembly) -> Independence:
    """Return the independent equations.

    Raises
    ------
    RunFailure
        If the start is inconsistent, or equations contradict each other.
    """
    found = Independence(system, start.q, start.t)
    try:
        found.check(start)
    except InconsistentConstraints as contradiction:
        raise RunFailure("inconsistent", str(contradiction)) from None
    return found


def remember_start(system: System, start: Assembly, b: Array) -> None:
    """Write into the parameters `b` what elements remember at the start of a run."""
    if len(start.memory):
        b[system.memory_places] = start.memory
    system.remember(start.q, b, start.t)
