"""How do gradients go backwards over a run that is there stretch by stretch? For each method with its own carry."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from ...algebra import Array
from ...results import RadauSteps, Steps, StepsTaken
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

    def over(self, steps: Any, before: float, nodes: Nodes) -> None:
        """Go over a stretch; `before` is the length of the step before it, `nodes` the gradients by its states."""

    def by_start(self) -> tuple[Array, Array, Array]:
        """See `Chain.by_start`, after the first stretch."""


def stretches_of(system: System, steps: StepsTaken, columns: int) -> Stretches:
    """Those of the method that took the steps."""
    return (RadauStretches if isinstance(steps, RadauSteps) else AlphaStretches)(system, columns)


class AlphaStretches:
    """Of HHT and generalized-α; a step's change of size belongs to it, and so the step before matters."""

    def __init__(self, system: System, columns: int) -> None:
        self._system, self._columns = system, columns
        self._by_curves = np.zeros((len(system.b), columns))
        self._sweep: Sweep | None = None
        self._last: Nodes | None = None

    def over(self, steps: Steps, before: float, nodes: Nodes) -> None:
        """See `Stretches`."""
        if self._last is not None:
            for kind in Given._fields:
                getattr(nodes, kind)[-1] += getattr(self._last, kind)[0]
        led = _led(steps, before) if before else steps
        if self._sweep is None:
            self._sweep = Sweep(self._system, led, self._columns)
            self._bars = self._sweep.bars()
        self._sweep.over(led)
        curves = Curves(self._system, led)
        kept = self._sweep.kept() if curves else None
        self._sweep.backward(self._bars, nodes.after_start(), len(led) - len(steps), len(led), kept)
        if kept is not None:
            self._by_curves += curves.gradient(kept)
        self._first, self._last = steps, nodes

    def by_start(self) -> tuple[Array, Array, Array]:
        """See `Stretches`."""
        assert self._last is not None
        by_q, by_v, by_b = Chain(self._system, self._first).through_start(self._last, self._bars)
        return by_q, by_v, by_b + self._by_curves


class RadauStretches:
    """Of Radau IIA, whose steps know nothing of each other; accelerations of a node are found from its state."""

    def __init__(self, system: System, columns: int) -> None:
        self._system, self._columns = system, columns
        sizes = (system.nq, system.nq, len(system.b))
        self._bars = radau.Bars._make(np.zeros((size, columns)) for size in sizes)
        self._by_curves = np.zeros((len(system.b), columns))

    def over(self, steps: RadauSteps, before: float, nodes: Nodes) -> None:
        """See `Stretches`."""
        sweep, curves = RadauSweep(self._system, steps, self._columns), RadauCurves(self._system, steps)
        kept = sweep.kept() if curves else None
        sweep.backward(self._bars, radau.Given(nodes.q, nodes.v, nodes.a, nodes.lam), kept)
        if kept is not None:
            self._by_curves += curves.gradient(kept)

    def by_start(self) -> tuple[Array, Array, Array]:
        """See `Stretches`."""
        return self._bars.q, self._bars.v, self._bars.b + self._by_curves


def _led(steps: Steps, before: float) -> Steps:
    """Steps with one before them, of which nothing but its length is told."""
    doubled: dict[str, Any] = {
        name: _doubled(getattr(steps, name)) for name in ("t", "q", "v", "a", "x", "lam", "memory")
    }
    left_out = _doubled(steps.left_out) if len(steps.left_out) else steps.left_out
    h, removed = np.concatenate([[before], steps.h]), np.concatenate([[0.0], steps.removed])
    return replace(steps, left_out=left_out, h=h, removed=removed, **doubled)


def _doubled(rows: Array) -> Array:
    """The first row twice."""
    return np.concatenate([rows[:1], rows])
