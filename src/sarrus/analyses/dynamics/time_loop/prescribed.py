"""A run without events, the lengths of its steps perhaps prescribed: as it is differentiated."""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ....results import Assembly, Trajectory
from ....system import System
from ..stepping.stepper import RunFailure, Settings, Stepper
from ..stepping.tolerance import Tolerances
from .outcome import nothing
from .time_loop import Plan, TimeLoop


class StepMethod:
    """Interface of methods whose steps can be prescribed."""

    def stepper(self, system: System, start: Assembly, settings: Settings) -> Stepper:
        """The method at work, see `Stepper`."""
        raise NotImplementedError

    def run(
        self,
        system: System,
        start: Assembly,
        t_eval: Array,
        *,
        rtol: float,
        atol: float,
        store_steps: bool = False,
        given: Array | None = None,
        b: Array | None = None,
    ) -> Trajectory:
        """Integrate over the times `t_eval`.

        `given` prescribes the lengths of the steps; `b` are other numbers than the system's.
        """
        settings = Settings(Tolerances.of(system, rtol, atol), store_steps=store_steps, given=given, b=b)
        none = np.zeros(0)
        try:
            stepper = self.stepper(system, start, settings)
        except RunFailure as error:
            return nothing(system, error.status, error.message)
        return TimeLoop(system, stepper, Plan(t_eval, float(t_eval[-1]), none, none)).go(start)
