"""The steps of an integration, one by one: what the derivatives of a run are made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..algebra import Array


@dataclass(frozen=True, eq=False, kw_only=True)
class StepsTaken:
    """All accepted steps of a method, as they were taken.

    Attributes
    ----------
    scheme : the method's coefficients
    start : the assembly from which it started
    b : (len(system.b),) the numbers of the elements
    t : (n + 1,) start, then the end of each step [s]
    h : (n,) lengths [s]
    q, v, a : (n + 1, nq) states
    lam : (n + 1, m)
    left_out : (n + 1, m) true for equations that others imply; (0, m) where there is none at any time
    memory : (n, number of remembered numbers) what elements remembered during each step, in `places` of b
    rtol, atol : tolerances of the steps
    """

    scheme: Any
    start: Any = field(repr=False)
    b: Array = field(repr=False)
    t: Array = field(repr=False)
    h: Array = field(repr=False)
    q: Array = field(repr=False)
    v: Array = field(repr=False)
    a: Array = field(repr=False)
    lam: Array = field(repr=False)
    left_out: Array = field(repr=False)
    places: Array = field(repr=False)
    memory: Array = field(repr=False)
    rtol: float
    atol: float

    def __len__(self) -> int:
        """Number of steps."""
        return len(self.h)

    @property
    def nbytes(self) -> int:
        """Memory that the states take [bytes]."""
        return sum(x.nbytes for x in (self.q, self.v, self.a, self.lam))


@dataclass(frozen=True, eq=False, kw_only=True)
class Steps(StepsTaken):
    """The steps of HHT or generalized-α.

    Attributes
    ----------
    removed : (n,) which part of the defect of the velocity constraints was removed before each step
    x : (n + 1, nq) the method's own acceleration
    """

    removed: Array = field(repr=False)
    x: Array = field(repr=False)

    @property
    def nbytes(self) -> int:
        """Memory that the states take [bytes]."""
        return super().nbytes + self.x.nbytes


@dataclass(frozen=True, eq=False, kw_only=True)
class RadauSteps(StepsTaken):
    """The steps of Radau IIA; a and λ at their ends are those of the equations of motion.

    Attributes
    ----------
    stage_q, stage_v : (n, 3, nq) the three stages of each step
    stage_lam, stage_mu : (n, 3, m)
    """

    stage_q: Array = field(repr=False)
    stage_v: Array = field(repr=False)
    stage_lam: Array = field(repr=False)
    stage_mu: Array = field(repr=False)

    @property
    def nbytes(self) -> int:
        """Memory that the states and stages take [bytes]."""
        stages = (self.stage_q, self.stage_v, self.stage_lam, self.stage_mu)
        return super().nbytes + sum(x.nbytes for x in stages)
