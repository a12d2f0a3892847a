"""Random mechanisms: trees, loops, planar and spherical loops of random joints, with random springs and gravity.

They can be made in any unit of length and mass: accelerations grow with the unit of length, times stay, so that
eigenvalues do not depend on the units.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

import sarrus as sr

Array = np.ndarray[Any, Any]
KINDS = ("tree", "loop", "planar", "spherical")


@dataclass
class Mechanism:
    """A model with what its potential energy consists of, for an independent one."""

    length: float
    mass: float
    copies: int
    bodies: list[Any] = field(default_factory=list)
    joints: list[Any] = field(default_factory=list)
    springs: list[tuple[int, Array, Array, float, float]] = field(
        default_factory=list
    )  # body, ground, s, k, length
    forces: list[Any] = field(default_factory=list)
    weight: Array = field(default_factory=lambda: np.zeros(3))

    def system(self) -> sr.System:
        model = sr.Model("random", self.bodies, self.joints, self.forces, gravity=tuple(self.weight))
        return sr.System(model)

    def body(self, random: np.random.Generator, position: Array) -> Any:
        m, k = self.mass * random.uniform(0.5, 2), self.length * random.uniform(0.2, 0.5)
        inertia = m * k * k * random.uniform(0.8, 1.2, size=3)
        turn = random.normal(size=4)
        body = sr.Body(
            f"b{len(self.bodies)}",
            mass=m,
            inertia=tuple(inertia),
            position=tuple(self.length * position),
            orientation=tuple(turn / np.linalg.norm(turn)),
        )
        self.bodies.append(body)
        return body

    def join(self, kind: Any, i: Any, j: Any, **where: Any) -> None:
        """A joint, as often as there are copies."""
        for _ in range(self.copies):
            self.joints.append(kind(f"j{len(self.joints)}", i, j, **where))

    def distance(self, random: np.random.Generator, i: Any, j: Any) -> None:
        ends = 0.3 * self.length * random.normal(size=(2, 3))
        for _ in range(self.copies):
            self.joints.append(sr.Distance(f"j{len(self.joints)}", i.point(*ends[0]), j.point(*ends[1])))

    def spring(self, random: np.random.Generator, n: int, c: float = 0.0) -> None:
        body, L = self.bodies[n], self.length
        s, far = 0.4 * L * random.normal(size=3), L * 2 * random.normal(size=3)
        k, rest = self.mass * 10 ** random.uniform(0.5, 2.5), L * random.uniform(0.3, 1.5)
        self.springs.append((n, far, s, k, rest))
        name = f"s{len(self.forces)}"
        self.forces.append(
            sr.TSDA(name, sr.ground.point(*far), body.point(*s), k=k, c=c * self.mass, length=rest)
        )

    def potential(self, q: Array) -> Any:
        """Of springs and gravity, by vectors, at positions (..., nq), which may be complex."""
        total: Any = 0.0
        for n, body in enumerate(self.bodies):
            total = total - body.mass * (q[..., 7 * n : 7 * n + 3] @ self.weight)
        for n, far, s, k, rest in self.springs:
            r, e0, e = (q[..., 7 * n + i : 7 * n + j] for i, j in ((0, 3), (3, 4), (4, 7)))
            d = r + s + 2 * np.cross(e, np.cross(e, s) + e0 * s) - far
            total = total + 0.5 * k * (np.sqrt((d * d).sum(axis=-1)) - rest) ** 2
        return total

    def gradient(self, q: Array) -> Array:
        """Of the potential energy, by complex steps: exact."""
        return np.asarray(self.potential(q + 1e-30j * np.eye(len(q))).imag / 1e-30)


def mechanism(
    seed: int, kind: str = "tree", *, length: float = 1.0, mass: float = 1.0, copies: int = 1, c: float = 0.0
) -> Mechanism:
    """The mechanism of a seed."""
    random = np.random.default_rng([seed, KINDS.index(kind)])
    made = Mechanism(length, mass, copies)
    made.weight = 9.81 * length * unit(random)
    {"tree": _tree, "loop": _loop, "planar": _planar, "spherical": _spherical}[kind](made, random)
    for n in range(len(made.bodies)):
        made.spring(random, n, c * random.uniform(0.0, 1.0))
    return made


def unit(random: np.random.Generator) -> Array:
    """A random direction."""
    a = random.normal(size=3)
    return np.asarray(a / np.linalg.norm(a))


def _tree(made: Mechanism, random: np.random.Generator) -> None:
    for _ in range(random.integers(1, 4)):
        _attach(made, random)


def _loop(made: Mechanism, random: np.random.Generator) -> None:
    """A tree with a bar of fixed length across."""
    for _ in range(random.integers(2, 4)):
        _attach(made, random)
    made.distance(random, random.choice([sr.ground, made.bodies[0]]), made.bodies[-1])


def _attach(made: Mechanism, random: np.random.Generator) -> None:
    parents = [sr.ground, *made.bodies]
    parent = parents[random.integers(len(parents))]
    child, L = made.body(random, random.normal(size=3)), made.length
    point, axis, other = tuple(L * random.normal(size=3)), unit(random), unit(random)
    across = tuple(np.cross(axis, other) / np.linalg.norm(np.cross(axis, other)))
    along = {"point": point, "axis": tuple(axis)}
    kinds: list[tuple[Any, dict[str, Any]]] = [
        (sr.Revolute, along),
        (sr.Translational, along),
        (sr.Cylindrical, along),
        (sr.Planar, along),
        (sr.PointOnLine, along),
        (sr.PointOnPlane, along),
        (sr.Screw, {**along, "pitch": 0.3 * L}),
        (sr.Spherical, {"point": point}),
        (sr.Universal, {"point": point, "axis_i": tuple(axis), "axis_j": across}),
    ]
    chosen, where = kinds[random.integers(len(kinds))]
    made.join(chosen, parent, child, **where)


def _planar(made: Mechanism, random: np.random.Generator) -> None:
    """A closed chain of four to five hinges with parallel axes: three equations repeat others."""
    count, axis = int(random.integers(4, 6)), unit(random)
    turn = np.linalg.svd(axis[None, :])[2][1:]
    angles = np.sort(random.uniform(0, 2 * np.pi, size=count))
    corners = (
        random.uniform(0.6, 1.6, size=(count, 1)) * np.stack([np.cos(angles), np.sin(angles)], axis=1) @ turn
    )
    _ring(made, random, corners, np.tile(axis, (count, 1)))


def _spherical(made: Mechanism, random: np.random.Generator) -> None:
    """The same with axes through one point."""
    count = int(random.integers(4, 6))
    axes = np.array([unit(random) for _ in range(count)])
    _ring(made, random, axes * random.uniform(0.5, 1.5, size=(count, 1)), axes)


def _ring(made: Mechanism, random: np.random.Generator, points: Array, axes: Array) -> None:
    """Ground and as many bodies as there are hinges less one."""
    for n in range(len(points) - 1):
        made.body(random, 0.5 * (points[n] + points[n + 1]))
    parts = [sr.ground, *made.bodies, sr.ground]
    for i, j, point, axis in zip(parts[:-1], parts[1:], points, axes, strict=True):
        made.join(sr.Revolute, i, j, point=tuple(made.length * point), axis=tuple(axis))
