"""A run at evenly spaced times, for pictures that move."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from .._jit.formulas.expression import Graph
from .._jit.formulas.replay import needed
from ..algebra import Array, cross
from ..elements import Force
from ..euler import E, rotate
from ..model.coordinates import POSITION, by_body, slice_of
from ..model.show import MOST as LISTED
from ..results import Trajectory
from ..system import System
from ..system.curves.curve_derivatives import values_of_elements
from ..system.curves.lanes import recorded_element
from ..system.structure.population import Population
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
    q = same_signs(given, len(run.bodies))
    return Frames(t, *_cubic(s, h, q, np.where(q == given, 1.0, -1.0) * v, k))


def _cubic(s: Array, h: Array, q: Array, v: Array, k: Array) -> tuple[Array, Array]:
    """Hermite's cubic and its rate."""
    q_0, q_1, v_0, v_1 = q[k], q[k + 1], h * v[k], h * v[k + 1]
    value = (1 + 2 * s) * (1 - s) ** 2 * q_0 + s * (1 - s) ** 2 * v_0
    value += s**2 * (3 - 2 * s) * q_1 + s**2 * (s - 1) * v_1
    rate = 6 * s * (1 - s) * (q_1 - q_0) + (1 - s) * (1 - 3 * s) * v_0 + s * (3 * s - 2) * v_1
    return value, rate / h


def same_signs(q: Array, bodies: int) -> Array:
    """The same rotations of so many bodies with p and not -p where that is nearer to the time before."""
    out = q.copy()
    p = by_body(out[:, : slice_of(bodies).start])[..., POSITION:]
    flips = np.where(np.einsum("tij,tij->ti", p[1:], p[:-1]) < 0, -1.0, 1.0)
    p[1:] *= np.cumprod(flips, axis=0)[..., None]
    return out


def interpolated(times: Array, values: Array, t: Array) -> Array:
    """Values (nt, n), known at some times, on straight lines between these."""
    columns = [np.interp(t, times, column) for column in values.T]
    return np.column_stack(columns) if columns else np.zeros((len(t), 0))


class Load(NamedTuple):
    """Force [N] at a body's points [m] and torque about them [N m], in global axes, each (n, 3)."""

    body: str
    points: Array
    forces: Array
    torques: Array


def loads(system: System, p: Population, at: Frames) -> Iterator[tuple[int, Load]]:
    """Yield what each element of a population, by its number, does to each of its moving bodies."""
    graph = Graph()
    element, (x, v, t) = recorded_element(p.variant, graph, graph.inputs("numbers", p.kind.size()))
    Q, slots = element.Q(x, v, t), p.variant.slots
    moving = [side for side, slot in enumerate(slots) if slot >= 0 and p.kind.is_body(side)]
    if not moving:
        return
    states, forces = p.kind.by_owner(x), p.kind.by_owner(Q)
    own = [(states[n], forces[n], _point(element, n, len(slots))) for n in moving]
    wanted = graph.expressions(number for one in own for number in _wrench(*one))
    operands = _remembered(system, at), at._asdict()
    values = values_of_elements(p, graph, wanted, needed(graph, wanted), system.b, *operands)
    for k, bodies in enumerate(p.bodies):
        for side, wrench in zip(moving, values[:, k].reshape(len(moving), 3, 3, -1), strict=True):
            first = int(bodies[slots[side]])
            if first < system.moving:  # no state variable
                yield k, Load(system.bodies[system.layout.owner_of[first]], *wrench.swapaxes(1, 2))


def _wrench(state: Any, Q: Any, s: Any) -> Iterator[Any]:
    """Yield a global point, the force there and the torque about it of [Q_r; Q_p]: ½ E Q_p less lever × force."""
    r, p = state
    force, turn = (np.zeros(len(x)) if block is None else block for block, x in zip(Q, state, strict=True))
    lever = rotate(p, s)
    yield from (*(r + lever), *force, *(E(p) @ turn / 2 - cross(lever, force)))


def _point(element: Any, side: int, bodies: int) -> Any:
    """The point of a force element on a body in its axes: of a weight the centre of mass; the origin if it has none."""
    alone = "center" if hasattr(element, "center") else "s"
    name = alone if bodies == 1 else ("s_i", "s_j")[side] if bodies == 2 else ""
    return getattr(element, name, np.zeros(3))


def _remembered(system: System, at: Frames) -> dict[int, Array]:
    """The state variables of elements at each frame (n,), as those before remember them, by place."""
    b, places = system.b.copy(), system.memory_places
    values = np.zeros((len(at.t), len(places)))
    for n in range(len(at.t) if len(places) else 0):
        values[n] = b[places]
        system.remember(at.q[n], b, float(at.t[n]))
    return dict(zip(places.tolist(), values.T, strict=True))


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
        shown = [weights if label == "gravity" else forces for label in p.labels]
        for k, load in loads(system, p, at) if any(shown) else ():
            if p.labels[k] == "gravity" and shown[k]:
                description = f"weight of {load.body}"
                arrows.append(Arrow(load.body, "force", description, False, load.points, load.forces))
            elif shown[k]:
                owner, on = p.owners[k], f"{p.owners[k]} on {load.body}"
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
