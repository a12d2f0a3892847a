"""The steps of an integration, one by one: what the derivatives of a run are made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..algebra import Array


@dataclass(frozen=True, eq=False)
class Steps:
    """All accepted steps of HHT or generalized-α, as they were taken.

    Attributes
    ----------
    scheme : the method's coefficients alpha_m, alpha_f, beta, gamma
    start : the assembly from which it started
    b : (len(system.b),) the numbers of the elements
    t : (n + 1,) start, then the end of each step [s]
    h : (n,) lengths [s]
    removed : (n,) which part of the defect of the velocity constraints was removed before each step
    q, v, a, x : (n + 1, nq) states; x is the method's own acceleration
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
    removed: Array = field(repr=False)
    q: Array = field(repr=False)
    v: Array = field(repr=False)
    a: Array = field(repr=False)
    x: Array = field(repr=False)
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
        return sum(x.nbytes for x in (self.q, self.v, self.a, self.x, self.lam))
