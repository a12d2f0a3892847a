"""The motion and the reactions of one body or joint over the times of a trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...algebra import Array
from ...deferred import renderer
from ...euler import E, G
from ...model.coordinates import coordinates_of
from ...outputs.motion import reaction_outputs, shared_by, words_of
from ..result import values_of

ORIGIN, TURN = slice(3), slice(3, None)  # of a body's coordinates


@dataclass(frozen=True, repr=False)
class BodyMotion:
    """One body's motion over the times of a trajectory."""

    run: Any
    name: str

    def __post_init__(self) -> None:
        coordinates_of(self.name, self.run.bodies, self.run.name)  # refuses an unknown name

    def _of(self, array: Array, places: slice) -> Array:
        found: Array = array[:, coordinates_of(self.name, self.run.bodies, self.run.name)][:, places]
        return values_of(self.run, found)

    @property
    def position(self) -> Array:
        """That of the frame's origin, in global axes (nt, 3) [m]."""
        return self._of(self.run.q, ORIGIN)

    @property
    def euler(self) -> Array:
        """Euler parameters, scalar first (nt, 4)."""
        return self._of(self.run.q, TURN)

    @property
    def velocity(self) -> Array:
        """That of the frame's origin, in global axes (nt, 3) [m/s]."""
        return self._of(self.run.v, ORIGIN)

    @property
    def angular_velocity_global(self) -> Array:
        """In global axes, 2 E(p) ṗ, as the output ``angular_velocity`` (nt, 3) [rad/s]."""
        return self._spin(E, self.euler, self._of(self.run.v, TURN))

    @property
    def angular_velocity_body(self) -> Array:
        """In body axes, 2 G(p) ṗ (nt, 3) [rad/s]."""
        return self._spin(G, self.euler, self._of(self.run.v, TURN))

    @property
    def acceleration(self) -> Array:
        """That of the frame's origin, in global axes (nt, 3) [m/s²]."""
        return self._of(self.run.a, ORIGIN)

    @property
    def angular_acceleration_global(self) -> Array:
        """In global axes, 2 E(p) p̈, as Ė ṗ = 0 (nt, 3) [rad/s²]."""
        return self._spin(E, self.euler, self._of(self.run.a, TURN))

    @property
    def angular_acceleration_body(self) -> Array:
        """In body axes, 2 G(p) p̈ (nt, 3) [rad/s²]."""
        return self._spin(G, self.euler, self._of(self.run.a, TURN))

    def _spin(self, matrix: Callable[[Array], Array], p: Array, pd: Array) -> Array:
        """2 E(p) ṗ, in global axes, or 2 G(p) ṗ, in body axes (nt, 3); the same of p̈."""
        linear = np.array([matrix(unit) for unit in np.eye(4)])  # matrix(p) is linear in p
        return values_of(self.run, np.asarray(np.einsum("tn,nij,tj->ti", 2 * p, linear, pd)))

    def __getitem__(self, word: str) -> Any:
        """An output of the body, ``run["rod"]["x"]``."""
        return self.run[f"{self.name}.{word}"]

    def __getattr__(self, word: str) -> Any:
        if word.startswith("_"):
            raise AttributeError(word, name=word, obj=self)
        raise AttributeError(
            f"the motion of {self.name} has no {word!r}. Choose from {self._words()}, or use an output, "
            f'run["{self.name}.x"].',
            name=word,
            obj=self,
        )

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.name!r}: {self._words()})"

    def _words(self) -> str:
        return ", ".join(name for name, value in vars(BodyMotion).items() if isinstance(value, property))


@dataclass(frozen=True)
class JointMotion:
    """Angles and displacements of a joint with their rates, over time.

    Attributes
    ----------
    values, rates : by the coordinate's name, ``angle``, ``displacement``, ``angle_i`` ... (nt,) [rad or m], [1/s]
    """

    name: str
    values: Mapping[str, Array] = field(repr=False)
    rates: Mapping[str, Array] = field(repr=False)

    def _one(self, found: Mapping[str, Array], name: str) -> Array:
        if name not in found:
            raise AttributeError(f"joint {self.name!r}: There is no {name}. Choose from {', '.join(found)}.")
        return found[name]

    @property
    def angle(self) -> Array:
        """The angle, including all revolutions (nt,). [rad]"""
        return self._one(self.values, "angle")

    @property
    def displacement(self) -> Array:
        """The displacement (nt,). [m]"""
        return self._one(self.values, "displacement")

    @property
    def rate(self) -> Array:
        """The rate of the angle, or of the displacement where there is no angle (nt,)."""
        return self._one(self.rates, "angle" if "angle" in self.rates else "displacement")


@dataclass(frozen=True)
class Reaction:
    """Reaction of a joint or driver: force and torque on its second body, over time.

    For a gear, coupler or rack and pinion, it is the load on the second body of the driven joint, `joint_j` or `rack`.
    If the second body is the ground, it is the load on the ground. With redundant constraints, it follows from the
    least norm of forces and moments, see `run.reaction`.

    Attributes
    ----------
    joint : its name
    t : (nt,) [s]
    point : the joint's point on body j, in global axes (nt, 3) [m]
    force : on body j, in global axes (nt, 3) [N]
    torque : on body j about the point, in global axes (nt, 3) [N m]
    axes : the joint's axes f, g, h, fixed in body i, as columns (nt, 3, 3)
    shared : the redundant joints that share it; none where it is determined
    """

    joint: str
    t: Array = field(repr=False)
    point: Array = field(repr=False)
    force: Array = field(repr=False)
    torque: Array = field(repr=False)
    axes: Array = field(repr=False)
    run: Any = field(default=None, repr=False, compare=False)

    @property
    def shared(self) -> tuple[str, ...]:
        """The redundant joints that share it, in least norm; none where it is determined."""
        return shared_by(self.run, reaction_outputs(self.joint))

    @property
    def joint_force(self) -> Array:
        """The force along the joint's axes f, g, h (nt, 3) [N]."""
        return np.asarray(np.einsum("tab,ta->tb", self.axes, self.force))

    @property
    def joint_torque(self) -> Array:
        """The torque about the joint's axes f, g, h (nt, 3) [N m]."""
        return np.asarray(np.einsum("tab,ta->tb", self.axes, self.torque))

    def __str__(self) -> str:
        largest = (np.linalg.norm(x, axis=1).max(initial=0.0) for x in (self.force, self.torque))
        force, torque = (f"{x:.6g}" for x in largest)
        return (
            f"reaction of {self.joint} at {len(self.t)} times: force up to {force} N, torque up to {torque} N m; "
            "arrays t, point, force, torque, axes, joint_force, joint_torque"
            f"{words_of(self.shared)}"
        )

    def plot(self, ax: Any = None) -> Any:
        """Draw force and torque in global axes over time; see `sarrus.views.plot_reaction`."""
        return renderer().plot_reaction(self, ax)


def reaction(run: Any, joint: str) -> Reaction:
    """Collect `System.reaction` over the states of a trajectory."""
    found = [run.system.reaction(joint, q, lam, t) for t, q, lam in zip(run.t, run.q, run.lam, strict=True)]
    shapes = ((3,), (3,), (3,), (3, 3))
    columns = zip(*found, strict=True) if found else ([] for _ in shapes)
    point, force, torque, axes = (
        np.array(list(c)).reshape(-1, *s) for c, s in zip(columns, shapes, strict=True)
    )
    return Reaction(joint, run.t, point, force, torque, axes, run)
