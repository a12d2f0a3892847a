"""How do gradients go backwards over a run that is there stretch by stretch? For each method with its own carry."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from ...algebra import Array
from ...results import RadauSteps, Steps, StepsTaken
from ...results.steps import last_of, led
from ...system import System
from . import radau_sweep_loop as radau
from .chain import Chain, Nodes
from .curves import Curves
from .radau_curves import RadauCurves
from .radau_sweep import RadauSweep
from .sweep import Sweep
from .sweep_loop import Given


class Stretches(Protocol):
    """Gradients that are carried from stretch to stretch, the last one first."""

    def over(self, steps: Any, lead: Any, nodes: Nodes, moving: bool) -> None:
        """Go over a stretch; `lead` are steps before it, None at the start or after an event, `nodes` the gradients.

        `moving` as for `Chain`.
        """

    def by_start(self) -> tuple[Array, Array, Array]:
        """See `Chain.by_start`, after a stretch that begins with the run or after an event; then all begins anew."""


def stretches_of(system: System, kind: type[StepsTaken], columns: int) -> Stretches:
    """Those of the method that took steps of this kind."""
    return (RadauStretches if issubclass(kind, RadauSteps) else AlphaStretches)(system, columns)


class AlphaStretches:
    """Of HHT and generalized-α; a step's change of size belongs to it, and so the step before matters."""

    def __init__(self, system: System, columns: int) -> None:
        self._system, self._columns = system, columns
        self._sweep: Sweep | None = None
        self._last: Nodes | None = None

    def over(self, steps: Steps, lead: Steps | None, nodes: Nodes, moving: bool) -> None:
        """See `Stretches`."""
        whole = led(lead and last_of(lead, 1), steps)
        if self._sweep is None:
            self._sweep = Sweep(self._system, whole, self._columns)
        self._sweep.over(whole)
        curves = Curves(self._system, whole, moving)
        if self._last is None:
            self._bars = self._sweep.bars(np.zeros((curves.width, self._columns)))
        else:
            for kind in Given._fields:
                getattr(nodes, kind)[-1] += getattr(self._last, kind)[0]
        kept = self._sweep.kept() if curves else None
        self._sweep.backward(self._bars, nodes.after_start(), len(whole) - len(steps), len(whole), kept)
        if kept is not None:
            self._bars.b[:] += curves.gradient(kept)
        self._first, self._last = Chain(self._system, steps, moving), nodes

    def by_start(self) -> tuple[Array, Array, Array]:
        """See `Stretches`."""
        assert self._last is not None
        found = self._first.through_start(self._last, self._bars)
        self._last = None
        return found


class RadauStretches:
    """Of Radau IIA, whose steps know nothing of each other; accelerations of a node are found from its state."""

    def __init__(self, system: System, columns: int) -> None:
        self._system, self._columns = system, columns
        self._sweep: RadauSweep | None = None
        self._bars: radau.Bars | None = None

    def over(self, steps: RadauSteps, lead: RadauSteps | None, nodes: Nodes, moving: bool) -> None:
        """See `Stretches`."""
        if self._sweep is None:
            self._sweep = RadauSweep(self._system, steps, self._columns)
        self._sweep.over(steps)
        curves = RadauCurves(self._system, steps, moving)
        if self._bars is None:
            sizes = (self._system.nq, self._system.nq, curves.width)
            self._bars = radau.Bars._make(np.zeros((size, self._columns)) for size in sizes)
        kept = self._sweep.kept() if curves else None
        self._sweep.backward(self._bars, radau.Given(nodes.q, nodes.v, nodes.a, nodes.lam), kept)
        if kept is not None:
            self._bars.b[:] += curves.gradient(kept)

    def by_start(self) -> tuple[Array, Array, Array]:
        """See `Stretches`."""
        assert self._bars is not None
        found, self._bars = self._bars, None
        return found.q, found.v, found.b
