"""The part that changes fastest over the last steps of a run: it is named where a run ends because of short steps.

Forces that vary slowly against the steps are nearly cubic in time over some of them, whatever their size. What is left
is divided by the roots of the inertias that it accelerates, so that a small force on a light part counts, too.
"""

from __future__ import annotations

import numpy as np

from ...._jit.formulas.replay import needed
from ....algebra import Array
from ....model.states.block import RateLoad
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives, entries_of
from ....system.structure.population import Population
from ..stepping.nodes import Nodes

LOOKED_AT = 48  # steps at the end of a run
WINDOW = 7  # states to which a cubic is fitted
SHARE = 0.1  # of the remainder of all accelerations: forces that make less of it are not the cause


def least_smooth(system: System, b: Array, nodes: Nodes) -> str:
    """The end of a message: the force, state or body that changes fastest between some nodes, if anything moves."""
    if len(nodes.t) < 2 or not all(np.all(np.isfinite(x)) for x in (nodes.q, nodes.v, nodes.a)):
        return ""
    nodes = _around_the_last(nodes) if len(nodes.t) < WINDOW else nodes
    inertia = abs(system.M(nodes.q[-1], b=b).diagonal()).reshape(-1, 7)
    inertia[:, 3:] = inertia[:, 3:].mean(axis=1)[:, None]
    root = np.sqrt(np.where(inertia > 0, inertia, np.inf)).ravel()
    accelerations = (nodes.a.T * np.sqrt(inertia.ravel())[:, None])[: system.moving]
    bodies = _remainders(nodes.t, accelerations).reshape(-1, 7).sum(axis=1)
    found = {
        (p.owners[k], issubclass(p.kind, RateLoad)): value
        for p in system.populations if p.is_force and p.count
        for k, value in enumerate(_of_forces(system, p, b, nodes, root))
    }  # fmt: skip
    worst = max(found, key=found.__getitem__, default=None)
    if worst and found[worst] > SHARE**2 * bodies.sum():
        what = "rate of the state" if worst[1] else "force of"
        return f" The {what} {worst[0]} changes fastest there."
    return (
        f" The motion of {system.bodies[int(np.argmax(bodies))]} changes fastest there."
        if bodies.any()
        else ""
    )


def _around_the_last(nodes: Nodes) -> Nodes:
    """The motion with the last acceleration, for as long as the last step before and behind its end."""
    last = nodes.part(slice(-1, None))
    s = np.linspace(-1, 1, LOOKED_AT)[:, None] * (nodes.t[-1] - nodes.t[-2])
    v = last.v + s * last.a
    held = (np.repeat(x, LOOKED_AT, axis=0) for x in last[3:])
    return Nodes(last.t + s[:, 0], last.q + s * (last.v + v) / 2, v, *held)


def _of_forces(system: System, p: Population, b: Array, nodes: Nodes, root: Array) -> Array:
    """The weighed square of the remainder of each force of a population (elements,)."""
    graph, places, entries = entries_of(p.variant, "Q")
    memory = dict(zip(system.memory_places.tolist(), nodes.memory.T, strict=True))
    operands = {"q": nodes.q, "v": nodes.v, "t": nodes.t}
    found = CurveDerivatives(system).on_elements(
        p, graph, entries, needed(graph, entries), b, memory, operands
    )
    total = np.zeros(p.count)
    for (block, entry), values in zip(places, found, strict=True):
        rows = p.bodies[:, block // 2] + (3 if block % 2 else 0) + entry
        total += _remainders(nodes.t, values / root[rows][:, None])
    return np.where(np.isfinite(total), total, 0.0)


def _remainders(t: Array, values: Array) -> Array:
    """Return for each row of values (k, nt) the sum of squares that cubics over a few times leave (k,)."""
    total = np.zeros(len(values))
    for first in range(len(t) - WINDOW + 1):
        own = t[first : first + WINDOW]
        u = (own - own[0]) / (own[-1] - own[0]) if own[-1] > own[0] else np.linspace(0, 1, WINDOW)
        basis = np.linalg.qr(u[:, None] ** np.arange(4))[0]
        part = values[:, first : first + WINDOW]
        total += ((part - (part @ basis) @ basis.T) ** 2).sum(axis=1)
    return total
