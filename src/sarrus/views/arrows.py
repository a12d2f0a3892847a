"""Forces and torques of a run as arrows over its frames: what joints bear, and what springs and loads do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..algebra import Array
from ..elements import Force
from ..results import Trajectory
from ..system import System
from .applied import loads
from .frames import Frames, interpolated

# Percent of the time in which no arrow is longer than a long one: peaks do not make all others vanish
LONG = 90
SMALL = 1e-9  # of the largest: what is smaller all the time is not drawn
FEW = 12  # joints, of which all reactions are shown by default


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
    found = [arrow for name in _chosen(system, reactions) for arrow in _reaction(run, at, name)]
    if forces or weights:
        found += _applied(system, at, forces, weights)
    return _to_scale(found)


def _chosen(system: System, wanted: Sequence[str] | bool | None) -> Sequence[str]:
    names = list(system.rows)
    if wanted is None or isinstance(wanted, bool):
        return names if (len(names) <= FEW if wanted is None else wanted) else []
    for name in wanted:
        if name not in names:
            raise KeyError(f"no joint or driver {name!r} in {system.name}; it has {', '.join(names)}")
    return wanted


def _reaction(run: Trajectory, at: Frames, name: str) -> Iterator[Arrow]:
    if len(run.lam) != len(run.t):
        return
    lam = interpolated(run, run.lam, at.t)
    found = [run.system.reaction(name, q, one, t) for t, q, one in zip(at.t, at.q, lam, strict=True)]
    points, forces, torques = (
        np.array([getattr(w, key) for w in found]) for key in ("point", "force", "torque")
    )
    description = f"reaction of {name} on its second body"
    yield Arrow(name, "reaction", description, False, points, forces)
    yield Arrow(name, "reaction", description.replace("reaction", "reaction torque"), True, points, torques)


def _applied(system: System, at: Frames, forces: bool, weights: bool) -> list[Arrow]:
    """The force and torque of every force element on each of its moving bodies, and their weights."""
    found: list[Arrow] = []
    for p in system.populations:
        if not issubclass(p.kind, Force):
            continue
        for k, (owner, label) in enumerate(zip(p.owners, p.labels, strict=True)):
            weighing = label == "gravity"
            for load in loads(system, p, k, at) if (weights if weighing else forces) else ():
                if weighing:
                    description = f"weight of {load.body}"
                    found.append(Arrow(load.body, "force", description, False, load.points, load.forces))
                    continue
                on = f"{owner} on {load.body}"
                found.append(Arrow(owner, "force", f"force of {on}", False, load.points, load.forces))
                found.append(Arrow(owner, "force", f"torque of {on}", True, load.points, load.torques))
    return found


def _to_scale(found: list[Arrow]) -> list[Arrow]:
    """Give arrows of forces one scale and those of torques another; leave out what is always too small."""
    sizes = [np.linalg.norm(arrow.ways, axis=1) for arrow in found]
    most = {}
    for turning in (False, True):
        most[turning] = _long(
            [size for arrow, size in zip(found, sizes, strict=True) if arrow.turning is turning]
        )
    return [
        arrow._replace(most=most[arrow.turning])
        for arrow, size in zip(found, sizes, strict=True)
        if np.max(size, initial=0.0) > SMALL * most[arrow.turning]
    ]


def _long(sizes: list[Array]) -> float:
    return float(np.percentile(np.max(sizes, axis=0), LONG)) or float(np.max(sizes)) if sizes else 0.0
