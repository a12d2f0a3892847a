"""The choice of independent equations at the start of a run."""

from __future__ import annotations

from ...results import Assembly
from ...system import System
from ..independence import Inconsistent, Independence
from .stepper import Trouble


def independence_at(system: System, start: Assembly) -> Independence:
    """Which equations are solved.

    Raises
    ------
    Trouble
        If the start is inconsistent, or equations contradict each other.
    """
    found = Independence(system, start.q, 0.0)
    try:
        found.check(start)
    except Inconsistent as contradiction:
        raise Trouble("inconsistent", str(contradiction)) from None
    return found
