"""A robot description without its format: links, edges that attach each link to its parent, and names for a model."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...model.geometry.motion import Motion
from ...model.geometry.points import GROUND, Axes
from ...model.geometry.pose import Pose
from ...model.quantity import Array, Vec3
from .zone import Zone

WORLD = ""  # the name of no link: the ground


class Inertia(NamedTuple):
    """Mass [kg], centre of mass (3,) [m] and inertia about it (3, 3) [kg m²], in some axes."""

    mass: float
    center: Array
    tensor: Array

    def seen_from(self, frame: Pose) -> Inertia:
        """Return the same in the axes in which ``frame``, the present axes, is given."""
        return Inertia(self.mass, frame.global_point(self.center), frame.A @ self.tensor @ frame.A.T)

    def about(self, point: Array) -> Array:
        """Return the inertia about a point: Steiner. (3, 3)"""
        d = self.center - point
        return np.asarray(self.tensor + self.mass * ((d @ d) * np.eye(3) - np.outer(d, d)))


MASSLESS = Inertia(0.0, np.zeros(3), np.zeros((3, 3)))  # of a frame between joints


def combined(parts: Iterable[Inertia]) -> Inertia:
    """Return the inertial of parts that move as one, all in the same axes; its mass may be 0."""
    parts = list(parts)
    mass = sum(part.mass for part in parts)
    if not mass:
        return Inertia(0.0, np.zeros(3), np.zeros((3, 3)))
    if len(parts) == 1:
        return parts[0]
    center = sum((part.mass / mass * part.center for part in parts), np.zeros(3))
    return Inertia(mass, center, sum((part.about(center) for part in parts), np.zeros((3, 3))))


class Limit(NamedTuple):
    """The range, effort and speed of a joint, in SI units; None where there is no limit.

    The range is one of the model's joint coordinate. The soft limits are those of a safety controller.
    """

    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    soft_lower: float | None = None
    soft_upper: float | None = None

    def range(self) -> tuple[float, float]:
        """Return the ends of the range, infinite where there is no limit; both are if the range is empty."""
        lower = -np.inf if self.lower is None else self.lower
        upper = np.inf if self.upper is None else self.upper
        return (lower, upper) if lower < upper else (-np.inf, np.inf)


class Mimic(NamedTuple):
    """A joint that follows another: its value is ``offset`` plus ``multiplier`` times the other's value.

    ``higher`` are factors of the other's square, cube, ...
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0
    higher: Sequence[float] = ()

    def is_constant(self) -> bool:
        """Return whether the joint stays where it is, whatever the other does."""
        return not self.multiplier and not any(self.higher)


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


class Obstacle(NamedTuple):
    """A sphere or a cylinder of a link that a segment wraps, in the axes of the link, as a `sarrus.Wrap`.

    The side is a point of a link.
    """

    link: str
    center: Vec3
    radius: float
    axis: Vec3 | None = None
    side: tuple[str, Vec3] | None = None


class Path(NamedTuple):
    """The way of a tendon: a factor for each motion, or points of links with a factor for each segment between them.

    Its length is ``start`` plus the sum of factors times motions, or the length of its segments, which go around
    obstacles.
    """

    joints: Mapping[str, float] = {}
    points: Sequence[tuple[str, Vec3]] = ()
    factors: Sequence[float] = ()
    start: float = 0.0
    around: Sequence[Obstacle | None] = ()

    def scaled(self, factor: float) -> Path:
        """Return a path that is longer by a factor."""
        joints = {name: factor * one for name, one in self.joints.items()}
        factors = [factor * one for one in self.factors]
        return self._replace(joints=joints, factors=factors, start=factor * self.start)


class TendonForces(NamedTuple):
    """Forces along a path, in SI units: a spring outside of two lengths, a damper, dry friction, a stop at limits.

    Higher factors of spring and damper are those of the square and the cube: stiffness · z + stiffness_2 · z² +
    stiffness_3 · z³ and damping · v + damping_2 · v |v| + damping_3 · v³. The inertia is that of what moves along with
    the path.
    """

    path: Path
    stiffness: float = 0.0
    shortest: float = 0.0
    longest: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    lower: float = 0.0
    upper: float = 0.0
    stop: float = 0.0  # stiffness
    loss: float = 0.0  # damping after Hunt and Crossley
    inertia: float = 0.0
    stiffness_2: float = 0.0
    stiffness_3: float = 0.0
    damping_2: float = 0.0
    damping_3: float = 0.0


class TendonEquality(NamedTuple):
    """The length of a path over joints less its ``start`` is a polynomial of that of another, or the first factor.

    A path over two points has the length ``start`` plus the first factor.
    """

    path: Path
    start: float
    factors: Sequence[float]
    other: Path | None = None


class Wrench(NamedTuple):
    """A force and a torque at a point of a link, in link axes, or in those of the root."""

    link: str
    point: Vec3
    force: Vec3
    torque: Vec3
    axes: Axes = "body"


class Activation(NamedTuple):
    """First-order state between a control and a force: a lag with a ``time`` constant [s], or the integral for 0.

    It stays between limits, which it approaches within the time ``arrest`` [s].
    """

    time: float = 0.0
    start: float = 0.0
    lower: float = -np.inf
    upper: float = np.inf
    arrest: float = 1e-3


class MuscleDynamics(NamedTuple):
    """Activation of a muscle, as of a `sarrus.MuscleActivation`: time constants [s]."""

    activation_time: float
    deactivation_time: float
    smoothing: float
    initial: float = 0.0


class Contraction(NamedTuple):
    """Tension of a muscle, as of a `sarrus.Muscle`."""

    peak_force: float
    optimal_length: float
    tendon_length: float
    min_length: float
    max_length: float
    max_velocity: float
    passive_force: float
    eccentric_force: float


class Actuator(NamedTuple):
    """A motor or servo on a coordinate x: (gain + gain_x x + gain_v ẋ) u + offset − kp x − kv ẋ, in SI units.

    It acts ``on`` a motion by name, a path or a link. u is its control, or the activation that follows from it.
    ``controls`` and ``forces`` are the limits of the control and of the force. With a ``contraction`` it is a muscle
    along a path, with the activation u.
    """

    on: str | Path | Wrench
    gain: float
    offset: float = 0.0
    kp: float = 0.0
    kv: float = 0.0
    controls: tuple[float, float] = (-np.inf, np.inf)
    forces: tuple[float, float] = (-np.inf, np.inf)
    gain_x: float = 0.0
    gain_v: float = 0.0
    activation: Activation | MuscleDynamics | None = None
    contraction: Contraction | None = None

    def motions(self) -> Iterable[str]:
        """Return the motions that it acts on by name."""
        if isinstance(self.on, str):
            return (self.on,)
        return self.on.joints if isinstance(self.on, Path) else ()


class Sensor(NamedTuple):
    """A sensor of a frame on a link, with its axes as columns, or of a joint: ``factor`` · coordinate + ``start``.

    ``kind`` is one of the words of MJCF, such as gyro. A sensor of forces is of ``links``: of their ``masses`` by body,
    see `interaction`, and of contacts and loops ``acting`` on them, with an end of each. A touch sensor has a ``zone``.
    """

    kind: str
    link: str = ""
    point: Array = np.zeros(3)
    axes: Array = np.eye(3)
    joint: str = ""
    factor: float = 1.0
    start: float = 0.0
    zone: Zone = ()
    links: Collection[str] = ()
    masses: Sequence[tuple[str, Inertia | None]] = ()
    acting: Sequence[tuple[str, str]] = ()


class Visual(NamedTuple):
    """The shape of a link: for drawing only, never used in an equation.

    ``shape`` is box, cylinder, sphere, capsule, ellipsoid or mesh; ``size`` its sides, its radius and length, or its
    radii [m], for a mesh the scale; ``file`` the mesh as the description names it; ``pose`` in link axes.
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
    inertial: Inertia | None
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
    tendons: Mapping[str, TendonForces] = field(default_factory=dict)
    equalities: Mapping[str, TendonEquality] = field(default_factory=dict)
    actuators: Mapping[str, Actuator] = field(default_factory=dict)
    lifted: Mapping[str, float] = field(default_factory=dict)  # part of the weight that is taken off, by link
    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    visuals: Sequence[Visual] = ()
    notes: Sequence[str] = ()
    zero: Mapping[str, ArrayLike] = field(default_factory=dict)

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
