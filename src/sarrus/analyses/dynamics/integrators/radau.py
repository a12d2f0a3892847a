"""Radau IIA, three stages, order 5: for high accuracy; on the stabilized index-2 (GGL) equations, see `collocation`."""

from __future__ import annotations

from dataclasses import dataclass

from ....results import Assembly
from ....system import System
from ..methods.collocation import RADAU
from ..stepping.stepper import Settings
from ..time_loop.prescribed import StepMethod
from .described import DescribedStepper


@dataclass(frozen=True)
class Radau(StepMethod):
    """Radau IIA method of order 5 with variable steps: implicit, stiffly accurate and L-stable. The default.

    All stages are solved together by Newton's method; one real and one complex matrix are factored for them.
    """

    def stepper(self, system: System, start: Assembly, settings: Settings) -> DescribedStepper:
        """The method at work, see `Stepper`."""
        return DescribedStepper(system, RADAU, start, settings)
