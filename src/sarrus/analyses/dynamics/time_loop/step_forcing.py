"""Search for the part that limits the step size: its force is farthest from a cubic over the last steps.

Forces that vary slowly against the steps are nearly cubic in time over some of them, whatever their size. What is left
is divided by the roots of the inertias that it accelerates, so that a small force on a light part counts, too.
"""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ...._jit.formulas.replay import needed
from ....algebra import Array
from ....model.states.rate_load import RateLoad
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives, entries_of
from ....system.structure.population import Population
from ..stepping.nodes import Nodes

LOOKED_AT = 48  # steps of a stretch
STRETCHES = 8  # of a run, half of them or more
WINDOW = 7  # states to which a cubic is fitted
MOST = 0.5  # of the whole remainder: a dependence that explains so much of it is the cause
# Of accelerations: with a smaller remainder nothing is fast, and the tolerances force the steps
SMOOTH = 1e-9
SHARE = 0.1  # of the remainder of all accelerations: forces that make less of it are not the cause
CAUSES = {
    "time": ("over time", "Give it a smoother law, without what is too fast to matter"),
    "speed": ("with the speed", "Make its law smoother at low speed, as by a larger creep speed"),
    "position": (
        "with the position",
        "Give it damping or a softer, smoother law, or put a joint in its place",
    ),
}
OF_STATES, OF_MOTIONS, OF_TOLERANCES = (
    "state",
    "motion",
    "tolerances",
)  # rate of a first-order state, motion of a driver
OTHERS = {
    OF_STATES: "The rate of the state {part} changes fast and forces the steps. Check its law.",
    OF_MOTIONS: "The motion of {part}, which changes fast over time, forces the steps. Give it a smoother law, "
    "without what is too fast to matter.",
    OF_TOLERANCES: "Forces and motion are smooth; the tolerances force the steps.",
    "": "The fast motion of {part} forces the steps.",
}


class Forcing(NamedTuple):
    """The part that limits the step size, and the reason.

    Attributes
    ----------
    part : of the model: a force or a driver, else a body
    cause : what its force changes with: "time", "speed" or "position"; or one of `OTHERS`, empty for a body
    """

    part: str
    cause: str = ""

    def __str__(self) -> str:
        if self.cause in OTHERS:
            return OTHERS[self.cause].format(part=self.part)
        how, remedy = CAUSES[self.cause]
        return f"The force of {self.part}, which changes fast {how}, forces the steps. {remedy}."


class Stretches:
    """Stretches of a run, evenly over its steps: the last one alone may be another motion than most steps are for."""

    def __init__(self) -> None:
        self.last: Nodes | None = None
        self._taken, self._steps, self._next, self._every = list[Nodes](), 0, 0, LOOKED_AT

    def take(self, nodes: Nodes) -> None:
        """Further steps."""
        if self.last is not None and len(nodes.t) <= WINDOW:
            return
        self.last = nodes.part(slice(-LOOKED_AT, None))
        self._steps += len(nodes.t) - 1
        if self._steps > self._next:
            self._next = self._steps + self._every
            self._taken.append(self.last)
        if len(self._taken) > STRETCHES:
            self._taken, self._every = self._taken[1::2], 2 * self._every

    def forcing(self, system: System, b: Array, ended: bool) -> Forcing | None:
        """Return what limits most steps; of a run that ended by steps too small what limited the last ones."""
        if self.last is None:
            return None
        if ended:
            return forcing(system, b, self.last, ended)
        found = Counter(forcing(system, b, one) for one in [*self._taken, self.last])
        return found.most_common(1)[0][0]


def forcing(system: System, b: Array, nodes: Nodes, ended: bool = False) -> Forcing | None:
    """Return what limits the steps between some nodes; None if nothing moves."""
    if len(nodes.t) < 2 or not all(np.all(np.isfinite(x)) for x in (nodes.q, nodes.v, nodes.a)):
        return None
    nodes = _around_the_last(nodes) if len(nodes.t) < WINDOW else nodes
    inertia = abs(system.M(nodes.q[-1], b=b).diagonal()).reshape(-1, 7)
    weight = np.concatenate(
        [inertia[:, :3], np.repeat(inertia[:, 3:].mean(axis=1)[:, None], 4, axis=1)], axis=1
    ).ravel()
    root = np.sqrt(np.where(weight > 0, weight, np.inf))
    accelerations = (nodes.a.T * np.sqrt(weight)[:, None])[: system.moving]
    bodies = _remainders(nodes.t, accelerations).reshape(-1, 7).sum(axis=1)
    found = {
        (number, k): value
        for number, p in enumerate(system.populations) if p.is_force and p.count
        for k, value in enumerate(_of_forces(system, p, b, nodes, root))
    }  # fmt: skip
    worst = max(found, key=found.__getitem__, default=None)
    most, size = found[worst] if worst else 0.0, np.sum(accelerations**2)
    if not ended and 0 < max(bodies.sum(), most) <= SMOOTH**2 * size:
        return Forcing("", OF_TOLERANCES)
    row, left, driven = _of_drivers(system, b, nodes, root)
    if left > max(SHARE**2 * bodies.sum(), most) or (
        most <= SHARE**2 * bodies.sum() and driven > MOST * size
    ):
        return Forcing(system.row_names[row].split(": ")[0], OF_MOTIONS)
    if worst is None or not most > SHARE**2 * bodies.sum():
        return Forcing(system.bodies[int(np.argmax(bodies))]) if bodies.sum() > 0 else None
    number, k = worst
    return Forcing(system.populations[number].owners[k], _cause(system, number, k, b, nodes, root, most))


def _around_the_last(nodes: Nodes) -> Nodes:
    """The motion with the last acceleration, for as long as the last step before and behind its end."""
    last = nodes.part(slice(-1, None))
    s = np.linspace(-1, 1, LOOKED_AT)[:, None] * (nodes.t[-1] - nodes.t[-2])
    v = last.v + s * last.a
    held = (np.repeat(x, LOOKED_AT, axis=0) for x in last[3:])
    return Nodes(last.t + s[:, 0], last.q + s * (last.v + v) / 2, v, *held)


def _cause(system: System, number: int, k: int, b: Array, nodes: Nodes, root: Array, whole: float) -> str:
    """Return what explains most of a remainder: a state, the time, the speed, or the position."""
    p = system.populations[number]
    if issubclass(p.kind, RateLoad):
        return OF_STATES
    q, v = (np.broadcast_to(x[-1], x.shape) for x in (nodes.q, nodes.v))
    if _of_forces(system, p, b, nodes._replace(q=q, v=v), root)[k] > MOST * whole:
        return "time"
    return "speed" if _of_forces(system, p, b, nodes._replace(v=v), root)[k] < MOST * whole else "position"


def _of_drivers(system: System, b: Array, nodes: Nodes, root: Array) -> tuple[int, float, float]:
    """The equation whose prescribed motion is least smooth, the weighed square of its remainder, and of all of it."""
    q, J = nodes.q[-1], system.Phi_q(nodes.q[-1], nodes.t[-1], b=b)
    gamma = np.stack([system.Phi_tt(q, t, b=b) for t in nodes.t], axis=1)
    if not np.ptp(gamma, axis=1).any():
        return 0, 0.0, 0.0
    scaled = csr_array((J.data / root[J.indices], J.indices, J.indptr), shape=J.shape)
    compliance = np.asarray(scaled.multiply(scaled).sum(axis=1)).ravel()
    gamma = gamma / np.sqrt(np.where(compliance > 0, compliance, np.inf))[:, None]
    left = _remainders(nodes.t, gamma)
    row = int(np.argmax(left))
    return row, float(left[row]), float(np.sum(gamma[row] ** 2))


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
