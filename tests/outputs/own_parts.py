"""A user's joint, driver and force, each with outputs of its own, on a bead in a bowl."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any

import numpy as np

import sarrus as sr
from sarrus import elements, model
from sarrus.algebra import single
from sarrus.elements import Element, output
from sarrus.elements.element import Curve, Scalar, Time, Vec3
from sarrus.functions import sqrt
from sarrus.model.geometry.points import Solid
from sarrus.model.laws.law import Law, motion_of
from sarrus.model.measure import In
from sarrus.model.primitive import Primitive
from sarrus.model.quantity import Vector


class Bowl(elements.Primitive, bodies=1, rows=1, derivatives="automatic", rare=True):
    """The origin of a body is on z = k (x² + y²) / 2."""

    k: Scalar

    @output("1")
    def steepness(self, x):
        return self.k * sqrt(x.r[0] * x.r[0] + x.r[1] * x.r[1])

    @output("1", vector=True)
    def normal(self, x):
        return np.array([-self.k * x.r[0], -self.k * x.r[1], 1 + 0 * x.r[2]])

    @output("m/s")
    def speed(self, x, v):
        return sqrt(v.r @ v.r)

    def Phi(self, x):
        return single(x.r[2] - self.k * (x.r[0] * x.r[0] + x.r[1] * x.r[1]) / 2)[0]


class Push(elements.Primitive, bodies=1, rows=1, derivatives="automatic", rare=True):
    """The x of a body follows a motion."""

    scale: Scalar
    motion: Curve
    t: Time

    @output("m")
    def target(self, x):
        return self.scale * self.motion(self.t) + 0 * x.r[0]

    @output("m²/s")
    def sweep(self, x, v):
        return x.r[1] * v.r[0] + self.scale * self.motion(self.t) * v.r[1]

    def Phi(self, x):
        return single(x.r[0] - self.scale * self.motion(self.t))[0]


class Pull(elements.Force, bodies=1, derivatives="automatic", rare=True):
    """A force of strength / d² towards a place."""

    place: Vec3
    strength: Scalar

    @output("m")
    def distance(self, x):
        d = self.place - x.r
        return sqrt(d @ d)

    @output("N")
    def attraction(self, x, v, t):
        return self.strength / self.distance(x) ** 2

    def Q(self, x, v, t):
        return self.attraction(x, v, t) / self.distance(x) * (self.place - x.r), None


@dataclass(frozen=True, eq=False)
class OnBowl(model.Joint):
    """A body's origin slides in a bowl."""

    body: Solid
    k: float

    def primitives(self, poses: Any) -> Iterator[Primitive]:
        yield Primitive(Bowl, (self.body.name,), (self.k,), "bowl")


@dataclass(frozen=True, eq=False)
class PushDriver(model.Driver):
    """A body's x follows a motion."""

    body: Solid
    motion: Annotated[Law, In("m", over="s")]

    def primitives(self, poses: Any, known: Any) -> Iterator[Primitive]:
        yield Primitive(Push, (self.body.name,), tuple(motion_of(self.motion, "motion")), "push")


@dataclass(frozen=True, eq=False)
class Attractor(model.Force):
    """A place attracts a body."""

    body: Solid
    place: Vector
    strength: float

    def primitives(self, poses: Any) -> Iterator[Primitive]:
        yield Primitive(Pull, (self.body.name,), (self.place, self.strength), "pull")


KINDS: dict[type, dict[str, type]] = {
    kind: {name: own for name, own in kind.kinds.items() if own in (OnBowl, PushDriver, Attractor)}
    for kind in (model.Joint, model.Driver, model.Force)
}
for kind, own in KINDS.items():  # other tests list all kinds
    for name in own:
        del kind.kinds[name]
for element in (Bowl, Push, Pull):
    del Element.registry[element.__name__]

K, STRENGTH, PLACE = 2.0, 3.0, (1.0, 1.0, 2.0)
FILE = """
name: bead in a bowl
gravity: [0, 0, -9.81]
bodies:
  bead: {mass: 2, inertia: [1, 1, 1], position: [0, 0.3, 0.09]}
joints:
  bowl: {type: on_bowl, body: bead, k: 2}
drivers:
  push: {type: push, body: bead, motion: 0.1*sin(3*t)}
forces:
  magnet: {type: attractor, body: bead, place: [1, 1, 2], strength: 3}
"""


@cache
def described() -> sr.Model:
    """The bead."""
    bead = sr.Body("bead", mass=2.0, inertia=(1, 1, 1), position=(0, 0.3, 0.09))
    bowl, magnet = OnBowl("bowl", bead, K), Attractor("magnet", bead, PLACE, STRENGTH)
    push = PushDriver("push", bead, sr.Formula(lambda t: 0.1 * np.sin(3 * t)))
    parts = {"bodies": [bead], "joints": [bowl], "drivers": [push], "forces": [magnet]}
    return sr.Model("bead in a bowl", **parts, gravity=(0, 0, -9.81))


def _far(q: Any) -> Any:
    return np.linalg.norm(q[:, :3] - PLACE, axis=1)


def _own(run: sr.Trajectory) -> dict[str, Any]:
    t, q, v = run.t, run.q, run.v
    return {
        "bowl.steepness": K * np.hypot(q[:, 0], q[:, 1]),
        "bowl.normal.x": -K * q[:, 0],
        "bowl.speed": np.linalg.norm(v[:, :3], axis=1),
        "bowl.multiplier.1": run.lam[:, run.system.rows["bowl"][0]],
        "bowl.force.z": run.reaction("bowl").force[:, 2],
        "push.target": 0.1 * np.sin(3 * t),
        "push.sweep": q[:, 1] * v[:, 0] + 0.1 * np.sin(3 * t) * v[:, 1],
        "push.force.x": run.reaction("push").force[:, 0],
        "magnet.distance": _far(q),
        "magnet.attraction": STRENGTH / _far(q) ** 2,
        "magnet.force.y": STRENGTH * (PLACE[1] - q[:, 1]) / _far(q) ** 3,
    }


VALUES: Callable[[sr.Trajectory], dict[str, Any]] = _own
NAMES = (
    *("bowl.steepness", "bowl.normal.x", "bowl.speed", "bowl.multiplier.1", "bowl.force.z"),
    *("push.target", "push.sweep", "push.force.x", "magnet.distance", "magnet.attraction", "magnet.force.y"),
)
UNITS = dict(zip(NAMES, ("1", "1", "m/s", "", "N", "m", "m²/s", "N", "m", "N", "N"), strict=True))
