"""Which runs with events can keep their steps for derivatives."""

from __future__ import annotations

import numpy as np

from ..._jit.emit import Recording
from ..._jit.expression import Expression
from ..._jit.replay import needed
from ...elements.recorder import record
from ...system import System
from ...system.population import Population
from .alpha import HHT, GeneralizedAlpha
from .radau import Radau


def refuse(system: System, method: object, saved: bool) -> None:
    """Refuse a run with events that shall keep its steps, where it cannot.

    Raises
    ------
    ValueError
        For other methods, for a run that is saved, whose folder has room for the steps since the last event only, and
        where motions or forces depend on time by themselves: after an event their steps are taken at other times.
    """
    if not isinstance(method, HHT | GeneralizedAlpha | Radau):
        raise ValueError("steps are kept by HHT(), GeneralizedAlpha() and Radau() only; take one")
    if saved:
        raise ValueError("the steps of a run with events are not saved; leave save= or keep_steps= away")
    timed = [p for p in system.populations if p.count and _timed(p)]
    if timed:
        told = f"{timed[0].owners[0]} depends on time by itself"
        raise ValueError(
            f"steps cannot be kept for derivatives where there are events and {told}; leave one of them out"
        )


def _timed(p: Population) -> bool:
    """Whether an element's equations contain the time."""
    names = [name for name in ("Phi", "Q") if any(operator.name == name for operator in p.kind.family)]
    return any(("t",) in _inputs(record(p.variant, (name,))) for name in names)


def _inputs(recording: Recording) -> list[object]:
    """What the entries of a recorded operator depend on."""
    entries = [e for output in recording.outputs for block in output.blocks for e in np.ravel(block)]
    wanted = [e for e in entries if isinstance(e, Expression)]
    return [recording.graph.nodes[n].value for n in needed(recording.graph, wanted)]
