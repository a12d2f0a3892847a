"""Gradients by a backward sweep over sections of a run that are computed again one after the other."""

from __future__ import annotations

from ....algebra import Array
from ....results import StepsTaken
from ....results.motion.steps import last_of, led
from ....system import System
from ..steps.curves import Curves
from ..steps.record import Record
from ..steps.sweep import Sweep
from .chain import BackwardState, Chain, Nodes


class Stretches:
    """Gradients that are carried from stretch to stretch, the last one first.

    A step's change of size belongs to it, and so the step before matters.

    Parameters
    ----------
    system : System
    columns : responses
    adjoints : takes those by q and v before and after all steps of a stretch (n, 2, 2 nq, columns), the last one first
    weighing : number of steps of the run if adjoints only weigh their defects, as for `Record`; gradients by
        the parameters of elements are then not computed, those by times of events always are
    """

    def __init__(
        self, system: System, columns: int, adjoints: list[Array] | None = None, weighing: int = 0
    ) -> None:
        self._system, self._columns, self._adjoints = system, columns, adjoints
        self._weighing = weighing
        self._sweep: Sweep | None = None
        self._back: BackwardState | None = None
        self._last: Nodes | None = None

    def over(self, steps: StepsTaken, lead: StepsTaken | None, nodes: Nodes, moving: bool) -> None:
        """Go over a stretch; `lead` are steps before it, None at the start or after an event, `nodes` the gradients.

        `moving` as for `Chain`.
        """
        whole = led(lead and last_of(lead, 1), steps)
        before = len(whole) - len(steps)
        if self._back is not None and self._last is not None:
            for kind in ("q", "v", "a", "lam"):
                getattr(nodes, kind)[-1] += getattr(self._last, kind)[0]
        record = Record(self._system, whole, before + nodes.asks_for_motion(), self._weighing)
        if self._sweep is None:
            self._sweep = Sweep(record, self._columns, by_parameters=not self._weighing)
        self._sweep = self._sweep.over(record)
        curves = Curves(record, moving)
        if self._back is None:
            self._back = BackwardState(curves.width, self._columns)
        self._back.over(self._sweep, curves, nodes, before, self._adjoints)
        self._first, self._last = Chain(self._system, steps, moving), nodes

    def by_start(self) -> tuple[Array, Array, Array]:
        """See `Chain.by_start`, after a stretch that begins with the run or after an event; then all begins anew."""
        assert self._back is not None
        assert self._last is not None
        found = self._back.through_start(self._first.start, self._last)
        self._back = None
        return found
