"""A robot description without its format: links, edges that attach each link to its parent, and names for a model."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from ...model.geometry.motion import Motion
from ...model.geometry.pose import Pose
from ...model.geometry.solid import GROUND
from ...model.quantity import Array, Vec3

WORLD = ""  # the name of no link: the ground


class Inertial(NamedTuple):
    """Mass [kg], centre of mass (3,) [m] and inertia about it (3, 3) [kg m²], in some axes."""

    mass: float
    center: Array
    tensor: Array

    def seen_from(self, frame: Pose) -> Inertial:
        """Return the same in the axes in which ``frame``, the present axes, is given."""
        return Inertial(self.mass, frame.global_point(self.center), frame.A @ self.tensor @ frame.A.T)

    def about(self, point: Array) -> Array:
        """Return the inertia about a point: Steiner. (3, 3)"""
        d = self.center - point
        return np.asarray(self.tensor + self.mass * ((d @ d) * np.eye(3) - np.outer(d, d)))


MASSLESS = Inertial(0.0, np.zeros(3), np.zeros((3, 3)))  # of a frame between joints


def combined(parts: Iterable[Inertial]) -> Inertial:
    """Return the inertial of parts that move as one, all in the same axes; its mass may be 0."""
    parts = list(parts)
    mass = sum(part.mass for part in parts)
    if not mass:
        return Inertial(0.0, np.zeros(3), np.zeros((3, 3)))
    if len(parts) == 1:
        return parts[0]
    center = sum((part.mass / mass * part.center for part in parts), np.zeros(3))
    return Inertial(mass, center, sum((part.about(center) for part in parts), np.zeros((3, 3))))


class Limit(NamedTuple):
    """The range, effort and speed of a joint in the description, in SI units; None if not given.

    The soft limits are those of a safety controller.
    """

    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    soft_lower: float | None = None
    soft_upper: float | None = None


class Mimic(NamedTuple):
    """A joint that follows another: its value is ``multiplier`` times the other's plus ``offset``."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


class Dynamics(NamedTuple):
    """Forces and inertia of one joint coordinate, in SI units, with rad for a rotation and m for a displacement.

    A spring ``stiffness`` about the value ``free`` of the coordinate, ``damping`` of its rate, dry ``friction`` and
    the ``inertia`` of its rate.
    """

    stiffness: float = 0.0
    free: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    inertia: float = 0.0


class Stop(NamedTuple):
    """A one-sided contact of a joint coordinate with each end of its range, see `sarrus.AngleStop`, in SI units."""

    lower: float
    upper: float
    stiffness: float
    damping: float


class Actuator(NamedTuple):
    """A motor or servo on a joint coordinate x: gain · u + offset − kp x − kv ẋ, for the control u, in SI units.

    ``controls`` and ``forces`` are the limits of u and of the force.
    """

    joint: str
    gain: float
    offset: float = 0.0
    kp: float = 0.0
    kv: float = 0.0
    controls: tuple[float, float] = (-np.inf, np.inf)
    forces: tuple[float, float] = (-np.inf, np.inf)


class Visual(NamedTuple):
    """The shape of a link: for drawing only, never used in an equation.

    ``shape`` is box, cylinder, sphere, capsule or mesh; ``size`` its sizes as the format gives them [m], for a mesh
    the scale; ``file`` the mesh as the description names it; ``pose`` in link axes.
    """

    link: str
    shape: str
    size: tuple[float, ...]
    pose: Pose
    file: str = ""
    color: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Link:
    """A link with its inertials, and the line it is on."""

    name: str
    inertial: Inertial | None
    line: int = 0


@dataclass(frozen=True, eq=False)
class Edge:
    """Connection of ``child`` with ``parent``: its frame in the parent's axes, then its motions."""

    name: str
    parent: str
    child: str
    pose: Pose
    motions: tuple[Motion, ...] = ()
    line: int = 0


@dataclass(frozen=True, eq=False)
class Description:
    """A robot: its root, all other links in the order of the tree, and what the model only keeps."""

    name: str
    file: str
    links: Mapping[str, Link]
    edges: Sequence[Edge]
    root: str
    gravity: Vec3
    loops: Sequence[Edge] = ()  # joints between links that the tree already has
    limits: Mapping[str, Limit] = field(default_factory=dict)
    mimics: Mapping[str, Mimic] = field(default_factory=dict)
    dynamics: Mapping[str, Dynamics] = field(default_factory=dict)
    stops: Mapping[str, Stop] = field(default_factory=dict)
    actuators: Mapping[str, Actuator] = field(default_factory=dict)
    lifted: Mapping[str, float] = field(default_factory=dict)  # part of the weight that is taken off, by link
    visuals: Sequence[Visual] = ()
    notes: Sequence[str] = ()
    zero: Mapping[str, Any] = field(default_factory=dict)
    ignorable: Sequence[str] = ("dynamics",)

    def where(self, line: int) -> str:
        """Return ``file:line``, or the file alone if the format has no lines."""
        return f"{self.file}:{line}" if line else self.file

    def line_of(self, edge: Edge) -> int:
        """Return the line of the link at the end of an edge; of a frame between joints, that of the edge."""
        return self.links[edge.child].line if edge.child in self.links else edge.line


def legal(names: Iterable[str], taken: set[str], ending: str) -> dict[str, str]:
    """Return a name of letters, digits, _ and - for each name; one that is ``taken`` gets the ending, then numbers."""
    found: dict[str, str] = {}
    tried: dict[str, Iterator[str]] = {}
    for name in names:
        plain = _plain(name)
        tries = tried.setdefault(plain, _tries(plain, ending))
        found[name] = next(one for one in tries if one not in taken and one != GROUND)
        taken.add(found[name])
    return found


def _plain(name: str) -> str:
    plain = re.sub(r"[^\w-]", "_", name)
    return plain if re.match(r"[^\W\d]", plain) else f"_{plain}"


def _tries(name: str, ending: str) -> Iterator[str]:
    yield from (name, f"{name}{ending}")
    yield from (f"{name}{ending}{n}" for n in count(2))
