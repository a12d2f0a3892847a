"""Scalars and counters of the time integration loops of implicit methods."""

from __future__ import annotations

from ...._jit.kernels.scalars import Scalars


class StepControl(Scalars):
    """Where a time integration loop is, and what it has counted.

    Attributes
    ----------
    t : the time reached [s]
    h : length of the next step [s]
    last_h : length of the last step [s]; 0 at a start
    steps, rejected, residuals, matrices : accepted and rejected steps, evaluated residuals, factored matrices
    rejected_since : steps rejected since the last accepted one
    """

    t: float
    h: float
    last_h: float
    steps: int
    rejected: int
    residuals: int
    matrices: int
    rejected_since: int
