"""What is simulated by `dynamics.py`: models, where they are looked at, and for how long."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import sarrus as sr
from sarrus import euler, mechanisms
from sarrus.functions import cos, positive, sin

EXAMPLES = Path(__file__).parent.parent / "examples"
sys.path.insert(0, str(EXAMPLES))
SPEED, HEIGHT, LENGTH, BEGINS = 5.0, 0.06, 2.0, 6.0  # of the vehicle [m/s]; of the bump on its road [m]
Place = tuple[str, tuple[float, float, float]]


class Problem(NamedTuple):
    """One problem.

    Attributes
    ----------
    points : points of bodies, whose places at the end are compared
    until : end [s]
    steps : numbers of equal steps that both codes take
    known : where the points are at the end, if others have told; else it is found
    referenced : whether errors are looked at
    others : forces that Exudyn has in its own way, by their names
    longest : the longest step that a method may choose, so that it does not pass by what lasts shortly [s]
    stops : times at which forces have corners, for the reference [s]
    tolerances : with which methods choose their steps
    """

    name: str
    system: sr.System
    start: sr.Assembly
    points: Sequence[Place]
    until: float
    steps: tuple[int, ...]
    known: Any = None
    referenced: bool = True
    others: tuple[dict[str, Any], ...] = ()
    longest: float = np.inf
    stops: tuple[float, ...] = ()
    tolerances: tuple[float, ...] = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)

    def end(self, run: sr.Trajectory) -> np.ndarray:
        """The points at the end, one after another."""
        return np.concatenate([_place(run, body, at) for body, at in self.points])


def _place(run: sr.Trajectory, body: str, at: tuple[float, float, float]) -> np.ndarray:
    return run[body].position[-1] + np.array(euler.rotate(run[body].euler[-1], np.array(at)), dtype=float)


def slider_crank() -> Problem:
    """That of SUNDIALS; the slider after 10 s."""
    system = sr.System(sr.load(EXAMPLES / "sundials_slider_crank.yaml"))
    known, points = (1.0235785589798, 0.0, 0.0), [("rod", (0.0, 0.0, 0.0))]
    return Problem("slider_crank", system, sr.assemble(system), points, 10.0, (250, 500, 1000, 2000), known)


def andrews() -> Problem:
    """The squeezer; the centres of three bodies after 0.03 s."""
    system = sr.System(sr.load(EXAMPLES / "andrews.yaml"))
    points = [(body, (0.0, 0.0, 0.0)) for body in ("K2", "K3", "K5")]
    return Problem("andrews", system, sr.assemble(system), points, 0.03, (250, 500, 1000, 2000))


def four_bars() -> Problem:
    """40 four-bar mechanisms, which are folded flat several times; B_0 after 10 s."""
    from four_bars import four_bars as made

    system, known = sr.System(made(40)), (0.180512226686728, 0.983572740582312, 0.0)
    points = [("upright_0", (0.0, 0.5, 0.0))]
    return Problem(
        "four_bars_40", system, sr.assemble(system), points, 10.0, (1000, 2000, 5000), known,
        tolerances=(1e-6,),
    )  # fmt: skip


def chain(n: int, steps: tuple[int, ...]) -> Problem:
    """Rods of 1 m and 1 kg in a row, pinned to each other and to the ground, that fall for 0.5 s."""
    bodies = [
        sr.Body(f"rod_{k}", mass=1, inertia=(1 / 1200, 1 / 12, 1 / 12), position=(k + 0.5, 0, 0))
        for k in range(n)
    ]
    pairs = zip([sr.ground, *bodies], bodies, strict=False)
    joints = [
        sr.Revolute(f"pin_{k}", i, j, point=(float(k), 0, 0), axis=(0, 0, 1))
        for k, (i, j) in enumerate(pairs)
    ]
    system = sr.System(sr.Model(f"chain of {n}", bodies, joints, gravity=(0, -9.81, 0)))
    end = [("rod_0", (0.5, 0.0, 0.0))]
    return Problem(f"chain_{n}", system, sr.assemble(system), end, 0.5, steps, referenced=n <= 100)


def hmmwv() -> Problem:
    """The vehicle over a bump under its left wheels, for 2 s; four points of it.

    Its tyres are the linear ones of the shipped model, which both codes have. The road rises under a wheel in the time
    in which its centre passes the bump at the speed of the start: a vertical force k h(t) + c ḣ(t) at the centre.
    """
    from hmmwv_bump import moved

    model = sr.load(mechanisms.path("hmmwv"))
    places = {body.name: body.position[0] for body in model.bodies}
    lifts, told, stops = [], [], []
    for tyre in (f for f in model.forces if isinstance(f, sr.Tyre) and f.name.endswith("left")):
        begins = (BEGINS - places[tyre.point.body.name]) / SPEED
        bump = Bump(tyre.k, tyre.c, HEIGHT, begins, LENGTH / SPEED)
        name, at = f"bump_{tyre.name}", {"body": tyre.point.body.name, "at": list(tyre.point.coordinates)}
        lifts.append(sr.PointForce(name, tyre.point, (0, 0, 1), factor=bump.force))
        told.append({"name": name, "type": "bump", "point": at, **bump._asdict()})
        stops += [begins, begins + bump.takes]
    system = sr.System(dataclasses.replace(model, forces=[*model.forces, *lifts]))
    corners = [("chassis", (x, x / 2, 0.0)) for x in (1.0, -1.0)]
    wheels = [(f"knuckle_{corner}", (0.0, 0.0, 0.0)) for corner in ("front_left", "rear_left")]
    return Problem(
        "hmmwv", system, moved(system, speed=SPEED), [*corners, *wheels], 2.0, (250, 500, 1000, 2000),
        others=tuple(told), longest=0.05, stops=tuple(sorted(stops)),
    )  # fmt: skip


class Bump(NamedTuple):
    """A road that rises and falls by h = height sin⁴ π s, s = (t - begins) / takes, under a tyre with k and c."""

    k: float
    c: float
    height: float
    begins: float
    takes: float

    def force(self, t: float) -> float:
        """k h + c ḣ [N]."""
        s = (t - self.begins) / self.takes
        inside = positive(s) * positive(1 - s)
        rise = self.k * self.height * sin(pi * s) + 4 * pi * self.c * self.height / self.takes * cos(pi * s)
        return inside * sin(pi * s) ** 3 * rise
