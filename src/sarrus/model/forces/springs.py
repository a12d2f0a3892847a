"""Springs with dampers: translational and rotational between two bodies, and along three axes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, NamedTuple, TypeAlias

import numpy as np

from ... import elements
from ..coordinate import DISPLACEMENT, angle, chosen
from ..errors import ModelError
from ..geometry.placement import AboutAxis, placed_frames, points_apart, refuse_same_body
from ..geometry.points import Frame, Point, Solid
from ..geometry.pose import Poses
from ..laws.curve import Curve, Formula
from ..laws.law import Law, of_one_variable, refuse_negative, scaled, varies
from ..measure import Angle, In, Length, Place
from ..parity import AXIAL, POLAR, declared
from ..primitive import Primitive
from ..quantity import ROUND_OFF, Vector, is_list, not_negative, number, numbers, plain, vector
from ..signals import Measure, Signal, Signals
from ..tape import values_of
from .force import Force
from .formula_element import Line, Target, along_coordinate, along_line


class LineTarget(NamedTuple):
    """A target of a load, the coordinate that it acts along, and the rate of the coordinate."""

    target: Target
    x: Signal
    v: Signal


def along_joint(joint: str, kind: Any, signals: Signals) -> LineTarget:
    """Return a coordinate of a joint, of a kind if one is wanted."""
    found = chosen(joint, kind, signals.known, "joint")
    measure = Measure.of(found.measure)
    unit = "m" if found.measure.element is DISPLACEMENT else "rad"
    x, v = Signal(measure, "Phi", 1, 0, unit), Signal(measure, "Phi_q_xi", 2, 0, f"{unit}/s")
    return LineTarget(Target(measure, along_coordinate), x, v)


@dataclass(frozen=True, eq=False)
class LineForce:
    """A force between two points, or on the displacement of a joint.

    Parameters
    ----------
    point_i, point_j
        The ends, which must not coincide; x is their distance [m], v its rate.
    joint
        Instead of points, a joint by name, ``slide``, or if it has several displacements ``table.displacement_x``; x is
        the displacement of its second body [m].
    """

    point_i: Point | None = None
    point_j: Point | None = None
    joint: str | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        given: Any = self.point_i
        if isinstance(given, str) and self.point_j is None and self.joint is None:
            object.__setattr__(self, "joint", given)  # Force("name", "slide", ...), as of a Torque
            object.__setattr__(self, "point_i", None)

    def line(self, signals: Signals) -> LineTarget:
        """Return what it acts along; a positive force pushes the points apart, or increases the displacement."""
        if self.joint is not None:
            if self.point_i is not None or self.point_j is not None:
                raise ModelError("has points and a joint. Give one or the other.", field="joint")
            return along_joint(self.joint, DISPLACEMENT, signals)
        if self.point_i is None or self.point_j is None:
            raise ModelError(
                "its place is missing. Give point_i and point_j, or joint; for a force at one point, a "
                "PointForce.",
                field="point_i",
            )
        i, j = points_apart(self.point_i, self.point_j, signals.poses)
        measure = Measure(Line, (i.body, j.body), (i.s, j.s))
        x, v = Signal(measure, "length", 1, 0, "m"), Signal(measure, "rate", 2, 0, "m/s")
        return LineTarget(Target(measure, along_line), x, v)


@dataclass(frozen=True, eq=False)
class TSDA(Force):
    """Translational spring-damper-actuator: tension f = k (l − length) + c l̇ + force at the distance l, Eq. (60).

    Parameters
    ----------
    point_i, point_j
        The ends; they must not coincide.
    k
        Stiffness [N/m], or a law k(l) over the length l [m].
    length
        Free length [m].
    c
        Damping [N s/m], or a law c(l̇) over the rate l̇ [m/s].
    force
        Actuator's tension [N], or a law over time [s].

    Notes
    -----
    A law is a function of the variable named above only (`Force` takes formulas of several): a formula in a text (in
    t over time, else in x, ``"50 + 10*abs(x - 2)"``), a table of pairs, a `Curve`, or a Python function made of
    arithmetic and of `sarrus.functions`. Numbers for k and c are not negative; laws may be.
    """

    of_several: ClassVar[str] = "sr.Force for a formula of length, rate and t"

    point_i: Point
    point_j: Point
    k: Annotated[Law, In("N/m", over="m")]
    length: Length
    c: Annotated[Law, In("N s/m", over="m/s")] = 0.0
    force: Annotated[Law, In("N", over="s")] = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the linear TSDA, or the nonlinear one if a law is a curve."""
        i, j = points_apart(self.point_i, self.point_j, poses)
        length = not_negative(self.length, "length", "Give the free length in m.")
        (k, c, force), curves = _laws(self, self.k, self.c, (self.force, "force"))
        kind = elements.NonlinearTSDA if curves else elements.TSDA
        yield Primitive(kind, (i.body, j.body), (i.s, j.s, k, c, length, force, *curves), "tsda")


@dataclass(frozen=True, eq=False)
class RSDA(AboutAxis, Force):
    """Rotational spring-damper-actuator: torque n = k (θ − angle) + c θ̇ + torque about h_i, Eq. (106).

    θ is the rotation of body j relative to body i about h_i, right-handed, with counted
    revolutions. Placed by a global ``point`` [m] and ``axis`` in the design position, where θ then
    starts at 0, or by ``frame_i`` and ``frame_j``, where θ is the angle from f_i to f_j. A positive torque decreases θ.

    Parameters
    ----------
    k
        Stiffness [N m/rad], or a law k(θ) over the angle θ [rad].
    c
        Damping [N m s/rad], or a law c(θ̇) over its rate [rad/s].
    angle
        Free angle [rad].
    torque
        Actuator's torque [N m], or a law over time [s].

    Notes
    -----
    A law is a function of the variable named above only (`Torque` takes formulas of several): a formula in a text (in
    t over time, else in x), a table of pairs, a `Curve`, or a Python function made of arithmetic and of
    `sarrus.functions`. Numbers for k and c are not negative; what drives a motion is a law.
    """

    parity = AXIAL

    of_several: ClassVar[str] = "sr.Torque on the joint for a formula of angle, rate and t"

    k: Annotated[Law, In("N m/rad", over="rad")] = field(kw_only=True)
    c: Annotated[Law, In("N m s/rad", over="rad/s")] = 0.0
    angle: Angle = 0.0
    torque: Annotated[Law, In("N m", over="s")] = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the linear RSDA, or the nonlinear one if a law is a curve, with its initial angle."""
        i, j = self.frames(poses)
        (k, c, torque), curves = _laws(self, self.k, self.c, (self.torque, "torque"))
        free, start = number(self.angle, "angle", "Give radians."), angle(i, j, poses).start
        kind = elements.NonlinearRSDA if curves else elements.RSDA
        values = (i.f, i.g, i.h, j.f, j.h, k, c, free, torque, *curves, start)
        yield Primitive(kind, (i.body, j.body), values, "rsda")


def _laws(
    part: TSDA | RSDA, k: Law, c: Law, load: tuple[Law, str]
) -> tuple[list[float], list[Curve | Formula]]:
    """Return factors and curves of stiffness, damping and load; no curves if all are numbers."""
    laws = ((k, "k", "x"), (c, "c", "x"), (*load, "t"))
    with of_one_variable(part):
        factors, curves = zip(*(scaled(*law) for law in laws), strict=True)
    refuse_negative(factors[0], "k")
    refuse_negative(factors[1], "c")
    return list(factors), list(curves) if any(varies(law) for law, *_ in laws) else []


Vector6: TypeAlias = Sequence[float] | tuple[float, ...]
Matrix6: TypeAlias = Sequence[float] | Sequence[Sequence[float]]
_SIX = "Give six numbers, three translations and then three rotations."
_MATRIX = "Give six numbers for the diagonal, or six rows of six."


def vector6(value: Any, field: str) -> tuple[float, ...]:
    """Return ``value`` as six finite floats, or raise a ModelError about ``field``."""
    return numbers(value, 6, field, _SIX)


def dissipative6(value: Any, field: str) -> tuple[float, ...]:
    """Return a matrix whose quadratic form is never negative: no motion of any direction gets energy from it.

    Raises
    ------
    ModelError
        Otherwise; also for a direction without a number of its own that is coupled to others.
    """
    entries = matrix6(value, field)
    whole = values_of(np.array(entries, dtype=object)).reshape(6, 6)
    symmetric = 0.5 * (whole + whole.T)
    own = np.diag(symmetric)
    sizes = np.sqrt(np.where(own > 0, own, 1.0))  # one unit for forces and torques
    least = float(np.linalg.eigvalsh(symmetric / np.outer(sizes, sizes))[0])
    coupled = np.any(abs(symmetric[own == 0]) > 0)
    if np.any(own < 0) or coupled or least < -ROUND_OFF:
        raise ModelError(
            f"{field} is negative in some direction. Give numbers of at least 0, or a matrix without negative "
            "eigenvalues. Model what drives a motion by a force of its own.",
            field=field,
        )
    return entries


def matrix6(value: Any, field: str) -> tuple[float, ...]:
    """Return the 36 numbers of a matrix, row by row, given in full or by its diagonal."""
    if is_list(value) and len(value) == 6 and is_list(value[0]):
        return tuple(entry for row in value for entry in numbers(row, 6, field, _MATRIX))
    return tuple(plain(entry) for entry in np.diag(numbers(value, 6, field, _MATRIX)).flat)


@dataclass(frozen=True, eq=False)
class Bushing(Force):
    """Bushing: force and torque stiffness · Ξ + damping · Ξ̇ − preload for the deformation Ξ of two frames.

    Ξ are the three coordinates of frame j's origin in frame i, and the three components there of the rotation vector
    φ n, where frame j is rotated by φ ≤ π about n. Beyond half a revolution it pulls back the shorter way, and its
    torque jumps: use an RSDA there. Placed by a global ``point`` [m], with the global axes, in
    the design position, where Ξ then starts at 0, or by ``frame_i`` and ``frame_j``.

    Parameters
    ----------
    body_i, body_j
        The two bodies that it connects.
    stiffness
        Six by six, or the six diagonal entries [N/m, N/rad; N, N m/rad]. A symmetric one conserves energy. It may not
        be negative in any direction.
    damping
        In the same form [N s/m, N s/rad; N s, N m s/rad].
    preload
        Force [N] and torque [N m] on body j, in the axes of frame i, where Ξ = 0.
    """

    parity = declared(POLAR, stiffness="matrix", damping="matrix", preload="wrench")

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None
    stiffness: Annotated[Matrix6, In("")] = field(kw_only=True)
    damping: Annotated[Matrix6, In("")] = (0.0,) * 6
    preload: Annotated[Vector6, In("")] = (0.0,) * 6

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        i, j = frames = placed_frames(self, None, poses)
        K, C = dissipative6(self.stiffness, "stiffness"), dissipative6(self.damping, "damping")
        values = (i.s, i.f, i.g, i.h, j.s, *frames.parallel(), K, C, vector6(self.preload, "preload"))
        yield Primitive(elements.Bushing, (i.body, j.body), values, "bushing")


AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ZERO = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class CartesianSpring(Force):
    """A force k (u − offset) + c u̇ along each axis of body i, for the displacement u of ``point_j`` from ``point_i``.

    Parameters
    ----------
    point_i, point_j
        The ends, which may coincide. The force acts at point_j, in the axes of the body of point_i.
    stiffness
        k for each axis [N/m].
    damping
        c for each axis [N s/m].
    offset
        The displacement u without force [m].
    """

    parity = declared(stiffness="even", damping="even", offset="polar")

    point_i: Point
    point_j: Point
    stiffness: Annotated[Vector, In("N/m")]
    damping: Annotated[Vector, In("N s/m")] = ZERO
    offset: Annotated[Vector, In("m")] = ZERO

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        i, j = self.point_i.resolve(poses, "point_i"), self.point_j.resolve(poses, "point_j")
        refuse_same_body(i.body, j.body, "point_j")
        k, c = vector(self.stiffness, "stiffness"), vector(self.damping, "damping")
        for name, three in (("stiffness", k), ("damping", c)):
            for value in three:
                not_negative(value, name, "Give three numbers of at least 0.")
        preload = [one * u for one, u in zip(k, vector(self.offset, "offset"), strict=True)]
        matrices = (dissipative6((*one, *ZERO), "stiffness") for one in (k, c))
        values = (i.s, *AXES, j.s, 1.0, ZERO, *matrices, (*preload, *ZERO))
        yield Primitive(elements.Bushing, (i.body, j.body), values, "bushing")
