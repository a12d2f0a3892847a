"""Designs simulated one after another: responses and their exact gradients as functions of the design variables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ...results import Gradient, Trajectory
from ...system import System
from ..assembly import assemble
from ..dynamics import HHT, GeneralizedAlpha, simulate
from ..sensitivity.chain import Chain
from ..sensitivity.derivatives import Wanted, as_responses, sensitivity
from ..sensitivity.evaluation import Evaluation
from ..sensitivity.parameters import Design, Parameters
from ..sensitivity.responses import Response


class Infeasible(SarrusError):
    """A design that cannot be simulated."""


@dataclass(frozen=True, eq=False)
class Study:
    """A system, what is simulated, and what may be changed.

    Parameters
    ----------
    system : with the design at the start
    responses : one or several, see `sensitivity`
    wrt : names of the design variables, see `sensitivity`
    until : end time [s]
    design, formula : named design variables and the function that gives numbers of the model from them
    method : `HHT` or `GeneralizedAlpha`
    rtol, atol : tolerances
    """

    system: System
    responses: Wanted
    wrt: Sequence[str] | None = None
    until: float = 1.0
    design: Mapping[str, float] | None = None
    formula: Design | None = None
    method: HHT | GeneralizedAlpha = field(default_factory=HHT)
    rtol: float = 1e-6
    atol: float = 1e-8

    def start(self) -> Point:
        """The design that the system has."""
        return Point(
            self, self.system, Parameters(self.system, self.wrt, design=self.design, formula=self.formula)
        )

    def wanted(self) -> list[Response]:
        """The responses."""
        return as_responses(self.responses)


class Point:
    """One design, simulated."""

    def __init__(self, study: Study, system: System, parameters: Parameters) -> None:
        self.study, self.system, self.parameters = study, system, parameters
        self._gradient: Gradient | None = None
        self._run: Trajectory | None = None

    def at(self, x: Array) -> Point:
        """Another design."""
        model = self.parameters.model_at([float(value) for value in x])
        design = None
        if self.study.design is not None:
            own = dict(zip(self.parameters.names, map(float, x), strict=True))
            design = {name: own.get(name, value) for name, value in self.study.design.items()}
        system = System(model)
        again = Parameters(system, self.parameters.names, design=design, formula=self.study.formula)
        return Point(self.study, system, again)

    @property
    def run(self) -> Trajectory:
        """Its simulation.

        Raises
        ------
        Infeasible
            If it cannot be assembled, or the run does not reach its end.
        """
        if self._run is None:
            self._run = self._simulated()
        return self._run

    def _simulated(self) -> Trajectory:
        study, start = self.study, assemble(self.system)
        if not start.success:
            raise Infeasible(start.message)
        settings = {"method": study.method, "rtol": study.rtol, "atol": study.atol, "keep_steps": True}
        run = simulate(self.system, start, until=study.until, t_eval=[study.until], **settings)  # type: ignore[arg-type]
        if not run.success:
            raise Infeasible(run.message)
        return run

    @property
    def design(self) -> dict[str, float]:
        """The design variables with their values."""
        return dict(zip(self.parameters.names, map(float, self.parameters.values), strict=True))

    @property
    def gradient(self) -> Gradient:
        """Responses and their gradients, by one sweep backwards."""
        if self._gradient is None:
            self._gradient = sensitivity(self.run, self.study.wanted(), **self._named())
        return self._gradient

    def _named(self) -> dict[str, Any]:
        design = self.study.design
        values = (
            None if design is None else {**design, **{n: v for n, v in self.design.items() if n in design}}
        )
        return {"wrt": self.parameters.names, "design": values, "formula": self.study.formula}

    def values(self) -> Array:
        """The responses alone (r,)."""
        if self._gradient is not None:
            return self._gradient.values
        assert self.run.steps is not None
        return Evaluation(self.system, self.run.steps, self.study.wanted(), self.parameters).values

    def signals(self) -> tuple[list[Array], list[Array]]:
        """The output of every response at its times (nt,), and its derivatives (nt, p), by one sweep forwards."""
        steps, parameters = self.run.steps, self.parameters
        assert steps is not None
        evaluation = Evaluation(self.system, steps, self.study.wanted(), parameters)
        every = np.eye(len(parameters.names))
        b, q, v, c = parameters.along(every)
        dots = Chain(self.system, steps).along(b, q, v)
        named = dict(zip(parameters.names, every, strict=True))
        return list(evaluation.signals), evaluation.signals_along(dots, b, c, named)
