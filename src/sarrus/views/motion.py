"""A run at evenly spaced times, for pictures that move."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from ..algebra import Array
from ..elements import Force
from ..elements.evaluation import element_from, partition
from ..euler import A, E
from ..model.coordinates import POSITION, WIDTH, by_body
from ..model.show import MOST as LISTED
from ..results import Trajectory
from ..system import System
from .meshes.mesh import POINT

SAMPLES = 60  # positions of a run that rails are long enough for, and that a camera sees
MOST = 600  # frames, unless asked otherwise


class Frames(NamedTuple):
    """Evenly spaced times t (n,) [s], and q, v (n, nq) there; p of each body keeps its sign from frame to frame."""

    t: Array
    q: Array
    v: Array

    @property
    def step(self) -> float:
        """Time between two frames [s]; 1 if there is only one."""
        return float(self.t[1] - self.t[0]) if len(self.t) > 1 else 1.0


def frames(run: Trajectory, most: int = MOST) -> Frames:
    """The run at ``most`` times, by the cubic through q and v at the times that it holds.

    Raises
    ------
    ValueError
        If the run holds no state.
    """
    if not len(run.t):
        raise ValueError(f"{run.name}: the run holds no states, so there is nothing to show: {run.message}")
    if len(run.t) == 1 or run.t[-1] <= run.t[0]:
        return Frames(run.t[:1], run.q[:1], run.v[:1])
    t = np.linspace(run.t[0], run.t[-1], max(2, most))
    k = np.clip(np.searchsorted(run.t, t, side="right") - 1, 0, len(run.t) - 2)
    h = np.maximum(run.t[k + 1] - run.t[k], np.finfo(float).tiny)[:, None]
    s = (t - run.t[k])[:, None] / h
    given, v = np.asarray(run.q), np.asarray(run.v)  # they may be in files
    q = same_signs(given)
    return Frames(t, *_cubic(s, h, q, np.where(q == given, 1.0, -1.0) * v, k))


def _cubic(s: Array, h: Array, q: Array, v: Array, k: Array) -> tuple[Array, Array]:
    """Hermite's cubic and its rate."""
    q_0, q_1, v_0, v_1 = q[k], q[k + 1], h * v[k], h * v[k + 1]
    value = (1 + 2 * s) * (1 - s) ** 2 * q_0 + s * (1 - s) ** 2 * v_0
    value += s**2 * (3 - 2 * s) * q_1 + s**2 * (s - 1) * v_1
    rate = 6 * s * (1 - s) * (q_1 - q_0) + (1 - s) * (1 - 3 * s) * v_0 + s * (3 * s - 2) * v_1
    return value, rate / h


def same_signs(q: Array) -> Array:
    """The same rotations with p and not -p where that is nearer to the time before."""
    out = q.copy()
    p = by_body(out)[..., POSITION:]
    flips = np.where(np.einsum("tij,tij->ti", p[1:], p[:-1]) < 0, -1.0, 1.0)
    p[1:] *= np.cumprod(flips, axis=0)[..., None]
    return out


def interpolated(times: Array, values: Array, t: Array) -> Array:
    """Values (nt, n), known at some times, on straight lines between these."""
    columns = [np.interp(t, times, column) for column in values.T]
    return np.column_stack(columns) if columns else np.zeros((len(t), 0))


GROUND = np.array([0.0, 0, 0, 1, 0, 0, 0])


class Load(NamedTuple):
    """Force [N] at a body's points [m] and torque about them [N m], in global axes, each (n, 3)."""

    body: str
    points: Array
    forces: Array
    torques: Array


def loads(system: System, population: Any, place: int, at: Frames) -> Iterator[Load]:
    """Yield what the element at a ``place`` of a population does to each of its moving bodies."""
    slots, bodies = population.variant.slots, population.bodies[place]
    firsts = [None if slot < 0 else int(bodies[slot]) for slot in slots]
    wrenches = [*_over_time(system, population, place, firsts, at)]
    for side, first in enumerate(firsts):
        if first is not None and first < system.moving:  # no state variable
            columns = (np.array([now[side][n] for now in wrenches], dtype=float) for n in range(3))
            yield Load(system.bodies[system.layout.owner_of[first]], *columns)


def _over_time(
    system: System, population: Any, place: int, firsts: list[int | None], at: Frames
) -> Iterator[list[tuple[Array, Array, Array]]]:
    """Yield point, force and torque for each body, for each frame."""
    kind, start = population.kind, population.at + place * population.kind.size()
    numbers, memory = system.b[start : start + kind.size()].copy(), _memory(kind)
    for t, q, v in zip(at.t, at.q, at.v, strict=True):
        element: Any = element_from(kind, numbers, system.b, t)
        flat, rates = _coordinates(q, firsts, GROUND), _coordinates(v, firsts, 0 * GROUND)
        x, w = partition(kind, flat), partition(kind, rates)
        Q = element.Q(x, w, t)
        if memory:
            numbers[memory] = element.remember(x)
        states = by_body(flat)
        yield [
            _wrench(body, Q[2 * n], Q[2 * n + 1], _point(element, n, len(states)))
            for n, body in enumerate(states)
        ]


def _coordinates(y: Array, firsts: list[int | None], ground: Array) -> Array:
    """The coordinates of an element's bodies, one after the other."""
    return np.concatenate([ground if first is None else y[first : first + WIDTH] for first in firsts])


def _memory(kind: Any) -> list[int]:
    """Return the indices of an element's state variables."""
    starts = np.cumsum([0, *kind.widths()])
    return [int(at) for at, field in zip(starts, kind.fields.values(), strict=False) if field == "Memory"]


def _point(element: Any, side: int, bodies: int) -> Array:
    """The point of a force element on a body in its axes: of a weight the centre of mass; the origin if it has none."""
    alone = "center" if hasattr(element, "center") else "s"
    name = alone if bodies == 1 else ("s_i", "s_j")[side] if bodies == 2 else ""
    return np.asarray(getattr(element, name, np.zeros(3)), dtype=float)


def _wrench(body: Array, Q_r: Any, Q_p: Any, s: Array) -> tuple[Array, Array, Array]:
    """A global point, the force there and the torque about it, of a generalized force [Q_r; Q_p]; n = ½ E Q_p."""
    lever = A(body[3:]) @ s
    force = np.zeros(3) if Q_r is None else np.asarray(Q_r, dtype=float)
    turn = np.zeros(4) if Q_p is None else np.asarray(Q_p, dtype=float)
    return body[:3] + lever, force, 0.5 * E(body[3:]) @ turn - np.cross(lever, force)


# Percent of the time in which no arrow is longer than a long one: peaks do not make all others vanish
LONG = 90


class Arrow(NamedTuple):
    """Where it is (n, 3) [m], which way and how large (n, 3) [N] or [N m], and its length that counts as long."""

    name: str
    kind: Literal["reaction", "force"]
    description: str
    turning: bool
    points: Array
    ways: Array
    most: float = 1.0


def arrows(
    run: Trajectory, at: Frames, reactions: Sequence[str] | bool | None, forces: bool, weights: bool = False
) -> list[Arrow]:
    """All arrows of a run that are ever seen, those of each kind and unit to one scale.

    Parameters
    ----------
    run : Trajectory
    at : its frames
    reactions : names of joints and drivers, or whether all; left out, all if they are few
    forces : whether springs, loads, tyres and contacts are shown
    weights : whether the weights of bodies are, at their centres of mass
    """
    system = run.system
    if system is None:
        return []
    every = [arrow for name in _chosen(system, reactions) for arrow in _reaction(run, at, name)]
    if forces or weights:
        every += _applied(system, at, forces, weights)
    return _to_scale(every)


def _chosen(system: System, reactions: Sequence[str] | bool | None) -> Sequence[str]:
    """The names of the joints and drivers whose reactions are drawn, see `arrows`."""
    names = list(system.rows)
    if reactions is None or isinstance(reactions, bool):
        return names if (len(names) <= LISTED if reactions is None else reactions) else []
    for name in reactions:
        if name not in names:
            raise KeyError(f"no joint or driver {name!r} in {system.name}. Choose from {', '.join(names)}.")
    return reactions


def _reaction(run: Trajectory, at: Frames, name: str) -> Iterator[Arrow]:
    if run.system is None or len(run.lam) != len(run.t):
        return
    states = zip(at.t, at.q, interpolated(run.t, run.lam, at.t), strict=True)
    wrenches = [run.system.reaction(name, q, lam, t) for t, q, lam in states]
    points, forces, torques = (
        np.array([getattr(w, key) for w in wrenches]) for key in ("point", "force", "torque")
    )
    description = f"reaction of {name} on its second body"
    yield Arrow(name, "reaction", description, False, points, forces)
    yield Arrow(name, "reaction", description.replace("reaction", "reaction torque"), True, points, torques)


def _applied(system: System, at: Frames, forces: bool, weights: bool) -> list[Arrow]:
    """The force and torque of every force element on each of its moving bodies, and their weights."""
    arrows: list[Arrow] = []
    for p in system.populations:
        if not issubclass(p.kind, Force):
            continue
        for k, (owner, label) in enumerate(zip(p.owners, p.labels, strict=True)):
            weighing = label == "gravity"
            for load in loads(system, p, k, at) if (weights if weighing else forces) else ():
                if weighing:
                    description = f"weight of {load.body}"
                    arrows.append(Arrow(load.body, "force", description, False, load.points, load.forces))
                    continue
                on = f"{owner} on {load.body}"
                arrows.append(Arrow(owner, "force", f"force of {on}", False, load.points, load.forces))
                arrows.append(Arrow(owner, "force", f"torque of {on}", True, load.points, load.torques))
    return arrows


def _to_scale(arrows: list[Arrow]) -> list[Arrow]:
    """Give arrows of forces one scale and those of torques another; leave out what is always too small.

    Torques of the forces with a lever that is round-off of the drawing are none.
    """
    sizes = [(arrow, np.linalg.norm(arrow.ways, axis=1)) for arrow in arrows]
    most = {
        turns: _long([size for arrow, size in sizes if arrow.turning is turns]) for turns in (False, True)
    }
    extent = float(np.ptp([arrow.points for arrow in arrows], axis=(0, 1)).max()) if arrows else 0.0
    least = {False: POINT * most[False], True: max(POINT * most[True], POINT * extent * most[False])}
    return [
        arrow._replace(most=most[arrow.turning])
        for arrow, size in sizes
        if np.max(size, initial=0.0) > least[arrow.turning]
    ]


def _long(sizes: list[Array]) -> float:
    return float(np.percentile(np.max(sizes, axis=0), LONG)) or float(np.max(sizes)) if sizes else 0.0
