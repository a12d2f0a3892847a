"""What numbers of curves do to the steps of a run: coefficients of tables, numbers in functions of time or length.

The sweeps are compiled for the numbers of elements; a curve has as many numbers as it has points. So their part of all
equations is evaluated here for all steps at once: as what is added to the right sides forwards, and backwards from what
was solved for.
"""

from __future__ import annotations

from functools import cached_property
from typing import Generic, TypeVar

import numpy as np

from ...algebra import Array
from ...results import Steps, StepsTaken
from ...system import System
from ...system.curve_derivatives import CurveDerivatives, Entries
from ...system.time_derivatives import TimeDerivatives
from ..dynamics.alpha_loop import weights_of
from .sweep import Sweep
from .sweep_loop import Kept, Sources

Kind = TypeVar("Kind", bound=StepsTaken)


class CurvesOf(Generic[Kind]):
    """What the derivatives of a run by the numbers of curves have in common for all methods.

    Parameters
    ----------
    system, steps : the run
    moving : whether it begins at a time that moves: that has a place behind all numbers, like one more of them

    Attributes
    ----------
    of : the derivatives of the operators
    """

    def __init__(self, system: System, steps: Kind, moving: bool = False) -> None:
        self._system, self._steps = system, steps
        self.of = TimeDerivatives(system) if moving else CurveDerivatives(system)

    def __bool__(self) -> bool:
        return bool(self.of)

    @property
    def width(self) -> int:
        """How many numbers there are, with the time."""
        return self.of.width

    def moved_by(self, db: Array) -> bool:
        """Whether changes of the numbers (len(b), k) change a curve."""
        return bool(self.of) and bool(np.any(db[self._system.nb :]))


class Curves(CurvesOf[Steps]):
    """The derivatives of all steps of HHT or generalized-α by the numbers of curves."""

    def sources(self, db: Array) -> Sources:
        """The changes of the residuals of all steps and changes of the step size (n, nq + m, k)."""
        steps, system, k = self._steps, self._system, db.shape[1]
        found = Sources._make(np.zeros((len(steps), system.nq + system.m, k)) for _ in Sources._fields)
        force, load, row = self._step
        found.step[:, : system.nq] = force.along(db, system.nq) - load.along(db, system.nq)
        found.step[:, system.nq :] = row.along(db, system.m) / self._beta[:, None, None]
        s = self._defects().s
        force, rate, drift = self._rescale(s)
        at = self._rescaled
        found.rescale[at, : system.nq] = force.along(db, system.nq)
        found.rescale[at, system.nq :] = -rate.along(db, system.m) - drift.along(db, system.m)
        return found

    def gradient(self, kept: Kept) -> Array:
        """What the adjoint variables of all steps give for the gradients by the numbers (len(b), k)."""
        nq, size, at = self._system.nq, self.width, self._rescaled
        force, load, row = self._step
        mu, z = kept.step, kept.rescale[at]
        found = load.gradient(mu[:, :nq], size) - force.gradient(mu[:, :nq], size)
        found -= row.gradient(mu[:, nq:] / self._beta[:, None, None], size)
        force, rate, drift = self._rescale(kept.s)
        found -= force.gradient(z[:, :nq], size)
        return np.asarray(found + rate.gradient(z[:, nq:], size) + drift.gradient(z[:, nq:], size))

    @cached_property
    def _beta(self) -> Array:
        return np.asarray(weights_of(self._steps.scheme, self._steps.h)[0])

    @cached_property
    def _rescaled(self) -> Array:
        """The steps before which a defect was removed."""
        return np.flatnonzero(self._steps.removed)

    @cached_property
    def _step(self) -> tuple[Entries, Entries, Entries]:
        """Of (Φ_qᵀλ), Q and Φ at the ends of the steps."""
        steps = self._steps
        memory = dict(zip(steps.places.tolist(), steps.memory.T, strict=True))
        q, v, lam, t = steps.q[1:], steps.v[1:], steps.lam[1:], steps.t[1:]
        return (
            self.of("Phi_qT_lam", steps.b, memory, q=q, lam=lam, t=t),
            self.of("Q", steps.b, memory, q=q, v=v, t=t),
            self.of("Phi", steps.b, memory, q=q, t=t),
        )

    def _rescale(self, s: Array) -> tuple[Entries, Entries, Entries]:
        """Of (Φ_qᵀσ), Φ_q (v - s) and Φ_t before changes of the step size, with (s, σ) in the rows of `s`."""
        steps, at, nq = self._steps, self._rescaled, self._system.nq
        memory = dict(zip(steps.places.tolist(), steps.memory[at].T, strict=True))
        q, t = steps.q[at], steps.t[at]
        return (
            self.of("Phi_qT_lam", steps.b, memory, q=q, lam=s[at, nq:], t=t),
            self.of("Phi_q_xi", steps.b, memory, q=q, xi=steps.v[at] - s[at, :nq], t=t),
            self.of("Phi_t", steps.b, memory, q=q, t=t),
        )

    def _defects(self) -> Kept:
        """What was removed of the velocities, by a sweep backwards of nothing."""
        sweep, count = Sweep(self._system, self._steps, 1), len(self._steps)
        kept = sweep.kept()
        sweep.backward(sweep.bars(), sweep.given(count), 0, count, kept)
        return kept
