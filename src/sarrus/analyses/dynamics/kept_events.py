"""Which runs with events can keep their steps for derivatives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..._jit.emit import Recording
from ..._jit.expression import Expression
from ..._jit.replay import needed
from ...elements.recorder import record
from ...system import System
from ...system.population import Population
from .alpha import HHT, GeneralizedAlpha
from .events import Event, Impact
from .radau import Radau


def refuse(system: System, method: object, events: Sequence[Event]) -> None:
    """Steps are kept where every event is a formula that ends the run, has an `Impact`, or only notes.

    Raises
    ------
    ValueError
        For other events and methods, and where motions or forces depend on time by themselves: after an event their
        steps are taken at other times.
    """
    if not isinstance(method, HHT | GeneralizedAlpha | Radau):
        raise ValueError("steps are kept by HHT(), GeneralizedAlpha() and Radau() only; take one")
    for event in events:
        if not isinstance(event.function, str) or not (
            event.reset is None or isinstance(event.reset, Impact)
        ):
            raise ValueError(
                "where steps are kept for derivatives, an event is a formula, and its reset an Impact; a Python "
                "function has no derivatives"
            )
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
