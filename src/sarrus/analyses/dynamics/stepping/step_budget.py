"""Limits of the number of steps of a run: the user's, or an extrapolation that ends runs with tiny steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....system import System
from .nodes import Nodes
from .stepper import RunFailure, RunPart

WINDOW = 20_000  # steps over which the mean step length is measured
WINDOWS = 3  # in a row that crawl, before a run is ended: a transient may need short steps for a while
# That would still follow at the present mean length: more than that is called crawling
MOST_STEPS = 5_000_000
CHOSEN = 0.5  # mean length over `max_step`, above which the user has chosen the length
GROWTH = 2.0  # mean length over that of the window before, from which steps recover by themselves
SHORT = ("too many steps", "step too small")  # statuses of runs whose steps are too short


@dataclass(frozen=True)
class StepBudget:
    """Limits of the number of steps of a run.

    Attributes
    ----------
    max_steps : limit of the user's, or None
    longest : longest step that the user allows, or the fixed length [s]
    method : of integration, for the advice
    """

    max_steps: int | None = None
    longest: float = np.inf
    method: object = None

    def advice(self) -> str:
        """Return a remedy for steps that are too short."""
        if hasattr(self.method, "stabilized"):
            return "Try method=sr.Radau(), more numerical damping (sr.HHT(alpha=-0.3)), or larger tolerances."
        other = "" if type(self.method).__name__ == "Radau" else "method=sr.Radau(), "
        return f"Try {other}some damping in the model, smoother laws of forces, or larger tolerances."


def changing_fastest(system: System, nodes: Nodes) -> str:
    """The end of a message: the body or state whose acceleration changes most over the last step.

    Accelerations are weighted with the roots of the inertias, so that a light part counts, too.
    """
    change = abs(nodes.a[-1] - nodes.a[-2]) * np.sqrt(abs(system.M(nodes.q[-1]).diagonal()))
    k = int(np.argmax(change))
    if not np.all(np.isfinite(change)) or change[k] == 0.0:
        return ""
    states = {one.place: f"rate of the state {name}" for name, one in system.states.items()}
    what = (
        f"motion of {system.layout.owners[system.layout.owner_of[k]]}"
        if k < system.moving
        else states.get(k, "rate of a state")
    )
    return f" The {what} changes fastest there."


class StepWatch(RunPart):
    """Counts the steps of one run against its budget.

    Parameters
    ----------
    budget : StepBudget
    until : end of the run [s]
    """

    VARIABLES = "_t", "_count", "_mean", "_crawled"

    def __init__(self, budget: StepBudget, until: float) -> None:
        self.budget, self._until = budget, until
        self._t, self._count, self._mean, self._crawled = 0.0, 0, 0.0, 0

    def begin(self, t: float) -> None:
        """The time at which the run starts, from which the first steps are counted."""
        self._t = t

    def look(self, t: float, count: int) -> None:
        """After some steps: time and number of steps reached.

        Raises
        ------
        RunFailure
            If there are more than `max_steps`, or if the run crawls.
        """
        most = self.budget.max_steps
        if most is not None:
            if count >= most and t < self._until:
                raise RunFailure(
                    "too many steps",
                    f"Limits(steps={most}): {count} steps were taken by t = {t:.6g} s, before the end.",
                )
            return
        if count - self._count < WINDOW:
            return
        mean, before = (t - self._t) / (count - self._count), self._mean
        self._t, self._count, self._mean = t, count, mean
        ahead = (self._until - t) / mean if mean > 0 else np.inf
        crawls = ahead > MOST_STEPS and mean < CHOSEN * self.budget.longest
        recovers = before > 0 and mean > GROWTH * before
        self._crawled = self._crawled + 1 if crawls and not recovers else 0
        if self._crawled >= WINDOWS:
            raise RunFailure(
                "too many steps",
                f"steps have become too short near t = {t:.6g} s, {mean:.1e} s on average: {ahead:.1e} more would "
                "follow. Pass limits=sr.Limits(steps=...) to go on.",
            )
