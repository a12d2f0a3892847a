"""A corner of a vehicle: a wheel, the body that carries it, its spindle and its kingpin."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ..algebra import Array
from ..model import Body, PointForce, SarrusError, Spherical
from ..model.checks.arguments import in_si
from ..model.expression import Expression, Name, Number
from ..model.expression.formula_value import ParameterValue
from ..model.geometry.points import GROUND
from ..model.mirror_image import other_side
from ..model.quantity import Vector, positive
from ..model.show import quote, suggest
from ..outputs import Outputs, outputs_of
from ..outputs.recording import members_of
from ..system import System

Side: TypeAlias = Literal["left", "right"]
Spot: TypeAlias = Vector | str  # a global point in the design position, or the name of a hardpoint or a joint
UP = np.array([0.0, 0.0, 1.0])
FORWARD = {"x": (1.0, 0.0, 0.0), "-x": (-1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "-y": (0.0, -1.0, 0.0)}


def of_rig(*words: str) -> str:
    """The name of a part that the rig adds, beside those of the model."""
    return "_".join(("rig", *words))


@dataclass(frozen=True, eq=False)
class Corner:
    """A wheel of a suspension, and the parts that guide it.

    Parameters
    ----------
    carrier : name of the body that carries the wheel: the knuckle, or the axle
    centre : the wheel centre: a global point in the design position (3,) [m], or the name of a hardpoint
        or of a joint of the carrier
    spindle : another point of the spin axis, on the side of the vehicle's centre plane
    radius : distance of the wheel centre from the road [m], or a text such as "310 mm"
    kingpin : the lower and the upper point of the steering axis, such as the names of both ball joints
    spring, damper : names of forces with a length, for the ratios of motion
    bearing : a revolute joint about which the wheel spins; it is locked

    Notes
    -----
    In a model with parts of both sides, ``knuckle`` is ``knuckle_left`` of the left corner and ``knuckle_right`` of the
    right one, and hardpoints of the other side are mirrored: one corner describes both.
    """

    carrier: str
    centre: Spot
    spindle: Spot
    radius: float
    kingpin: tuple[Spot, Spot] | None = None
    spring: str | None = None
    damper: str | None = None
    bearing: str | None = None


class Located(NamedTuple):
    """A point of a carrier: where it is in the design position (3,) [m], and the part of the rig that has it.

    `end` is the side of a joint, "i" or "j"; it is empty if the part is a marker, a force of zero at the point. Its
    `coordinates` are then numbers or formulas of hardpoints.
    """

    design: Array
    part: str
    end: str = ""
    coordinates: tuple[Any, ...] = ()

    def recorded_design(self, o: Outputs) -> Array:
        """Where it is in the design position, recorded: it follows the hardpoints of which its coordinates are made."""
        return np.array([_recorded(o, one) for one in self.coordinates] or self.design)

    def position(self, o: Outputs, body: str) -> Array:
        """The recorded global position (3,) [m]."""
        if self.end:
            return o.point_of_joint(self.part, self.end)
        population, k = next((p, k) for p in o.system.populations for k in members_of(p, self.part))
        return o.position(body, o.element(population, k, "b").s)


def _recorded(o: Outputs, coordinate: Any) -> Any:
    """A number, or a formula of parameters with their recorded values."""
    if not isinstance(coordinate, Expression):
        return float(coordinate)
    tree = coordinate.rebuilt(lambda node: Name(node.of) if isinstance(node, ParameterValue) else None)
    return tree.value({name: o.parameter(name) for name in tree.names()})


class PlacedCorner:
    """A corner of a system in its design position.

    Parameters
    ----------
    system : System
    corner : Corner
    side : "left" or "right"
    forward : direction of travel, "x", "-x", "y" or "-y"

    Attributes
    ----------
    axes : (3, 3) rows: rearward, outboard, up
    points : the points of the carrier by name: centre, spindle, and lower and upper of a kingpin
    """

    def __init__(self, system: System, corner: Corner, side: Side, forward: str) -> None:
        self.corner, self.side, self._system = corner, side, system
        self._refuse_other_kinds()
        word = f"{side}: radius"
        radius = positive(in_si(word, corner.radius, "m"), word, "Give the radius in m.")
        self.corner = corner = replace(self._of_side(corner), radius=radius)
        if corner.carrier not in system.bodies:
            hint = suggest(corner.carrier, [*system.bodies])
            raise SarrusError(f"{side}: the model has no body {quote(corner.carrier)}. {hint}")
        ahead = np.array(FORWARD[forward])
        left = np.cross(UP, ahead)
        self.axes = np.array([-ahead, left if side == "left" else -left, UP])
        self.points = {name: self._located(name, spot) for name, spot in self._spots()}
        self._refuse_points(forward)
        for word, name in (("spring", corner.spring), ("damper", corner.damper)):
            self._refuse_no_length(word, name)

    def _of_side(self, corner: Corner) -> Corner:
        """The corner with the names of the parts of its side: ``knuckle_left`` for ``knuckle``, if that is none."""
        model = self._system.model
        known = {one.name for parts in (model.bodies, model.joints, model.forces) for one in parts}

        def name(given: Any) -> Any:
            own = f"{given}_{self.side}"
            return own if isinstance(given, str) and given not in known and own in known else given

        new = {word: name(getattr(corner, word)) for word in ("carrier", "spring", "damper", "bearing")}
        return replace(corner, **new)

    def _spots(self) -> list[tuple[str, Spot]]:
        found = [("centre", self.corner.centre), ("spindle", self.corner.spindle)]
        kingpin: Any = self.corner.kingpin
        if kingpin is not None:
            if not isinstance(kingpin, tuple | list | np.ndarray) or len(kingpin) != 2:
                message = "kingpin must be two points. Give the lower and the upper one."
                raise SarrusError(f"{self.side}: {message}")
            found += zip(("lower", "upper"), kingpin, strict=True)
        return found

    def _located(self, name: str, spot: Spot) -> Located:
        if isinstance(spot, str) and spot not in self._system.model.hardpoints:
            return self._of_joint(name, spot)
        given = self._coordinates(spot)
        try:
            place = np.array([one.value() if isinstance(one, Expression) else float(one) for one in given])
        except (TypeError, ValueError):
            place = np.zeros(0)
        if place.shape != (3,) or not np.all(np.isfinite(place)):
            message = f"{name} must be three numbers, got {spot!r}. Give a global point in m."
            raise SarrusError(f"{self.side}: {message}")
        return Located(place, of_rig(name, self.side), coordinates=tuple(given))

    def _coordinates(self, spot: Any) -> Any:
        """Three coordinates of a point: of a hardpoint by name the formulas that follow it."""
        if not isinstance(spot, str):
            return spot
        x, y, z = (self._of_parameter(f"{spot}.{axis}") for axis in "xyz")
        return [x, -y, z] if self._is_mirrored(float(y.value())) else [x, y, z]

    def _is_mirrored(self, y: float) -> bool:
        """Whether a hardpoint is on the other side of y = 0 than the carrier, which has a mirror image there."""
        carrier, bodies = self.corner.carrier, self._system.bodies
        if not carrier.endswith(f"_{self.side}") or other_side(carrier) not in bodies:
            return False
        both = (self._system.coordinates_of(one) for one in (carrier, other_side(carrier)))
        here, there = (self._system.q0[place][1] for place in both)
        own = here or self.axes[1][1]  # frames of both carriers may be on the plane
        return bool(own * y < 0 and here == -there)

    def _of_parameter(self, name: str) -> Expression:
        """The formula of free parameters that a parameter of the model follows."""
        tree = self._system.model.formulas.definitions[name]
        if not tree.names():  # a number, which may have a sign, and then is a formula
            own = tree if isinstance(tree, Number) else Number(float(tree.value()), "m")
            return ParameterValue(own.number, "m", of=name, table={name: own})
        return tree.rebuilt(lambda node: self._of_parameter(node.name) if isinstance(node, Name) else None)

    def _of_joint(self, name: str, joint: str) -> Located:
        carrier, joints = self.corner.carrier, {one.name: one for one in self._system.model.joints}
        joint = next((one for one in (joint, f"{joint}_{self.side}") if one in joints), joint)
        if joint not in joints:
            hint = suggest(joint, [*self._system.model.hardpoints, *joints])
            raise SarrusError(f"{self.side}: {name} names no hardpoint or joint {quote(joint)}. {hint}")
        marker = self._system.marker(joint)
        ends = {marker.body_i: "i", marker.body_j: "j"}
        # the top mount of a strut, which is a point of the steering axis, but not of the carrier
        is_mount = name in ("lower", "upper") and isinstance(joints[joint], Spherical)
        body = carrier if carrier in ends or not is_mount else next(one for one in ends if one != GROUND)
        if body not in ends:
            message = f"{self.side}: {name} is the joint {quote(joint)}, which is not on {quote(carrier)}"
            raise SarrusError(f"{message}. Name a joint of this body, or give a global point.")
        end = ends[body]
        s = np.asarray(marker.s_i if end == "i" else marker.s_j, dtype=float)
        return Located(self._system.model.design_poses()[body].global_point(s), joint, end)

    def design(self, name: str) -> Array:
        """A point in the design position, in global axes (3,) [m]."""
        return self.points[name].design

    def coordinates(self, name: str) -> Array:
        """The coordinates of a point in the design position (3,) [m]: formulas if they follow hardpoints."""
        point = self.points[name]
        return np.array(point.coordinates or point.design, dtype=object)

    def local(self, name: str) -> Array:
        """A point in the axes of the carrier (3,) [m]."""
        return self.body.pose().local_point(self.design(name))

    @property
    def left(self) -> Array:
        """The direction to the left of the vehicle (3,)."""
        return np.asarray(self.axes[1] if self.side == "left" else -self.axes[1])

    @property
    def body(self) -> Body:
        """The carrier."""
        return next(one for one in self._system.model.bodies if one.name == self.corner.carrier)

    def markers(self) -> list[PointForce]:
        """The parts that have the points which are given by coordinates."""
        points = [(one.part, one.coordinates) for one in self.points.values() if not one.end]
        return [PointForce(part, self.body.global_point(*place), (0.0, 0.0, 0.0)) for part, place in points]

    def _refuse_points(self, forward: str) -> None:
        table = self._system.model.hardpoints
        y = {one: float(table[one][1]) for _, one in self._spots() if isinstance(one, str) and one in table}
        if len({self._is_mirrored(one) for one in y.values() if one}) > 1:  # the model mirrors all or none
            places = ", ".join(f"{quote(name)} at {one:g} m" for name, one in y.items())
            message = f"its hardpoints are on both sides of y = 0: {places}"
            raise SarrusError(f"{self.side}: {message}. Change the sign of those on the wrong side.")
        axis = self.axes @ (self.design("centre") - self.design("spindle"))
        if not np.any(axis):
            message = f"{self.side}: spindle is the wheel centre, so that the spin axis has no direction"
            raise SarrusError(f"{message}. Give another point of the axis.")
        if axis[1] <= 0:
            message = f"{self.side}: the spin axis does not point outboard from spindle to centre"
            raise SarrusError(f"{message}. Exchange the points or the sides, or change forward={forward!r}.")
        if "lower" in self.points and self.design("upper")[2] <= self.design("lower")[2]:
            message = f"{self.side}: the second point of kingpin is not above the first"
            raise SarrusError(f"{message}. Give the lower point first, and two points.")

    def _refuse_other_kinds(self) -> None:
        if not isinstance(self.corner, Corner):
            raise SarrusError(f"{self.side} must be a corner, got {self.corner!r}. Give sr.Corner(...).")
        for word in ("carrier", "spring", "damper", "bearing"):
            name = getattr(self.corner, word)
            if not isinstance(name, str) and (name is not None or word == "carrier"):
                raise SarrusError(f"{self.side}: {word} must be a name, got {name!r}. Give one in quotes.")

    def _refuse_no_length(self, word: str, name: str | None) -> None:
        forces = [one.name for one in self._system.model.forces]
        if name is not None and name not in forces:
            raise SarrusError(f"{self.side}: {word} names no force {quote(name)}. {suggest(name, forces)}")
        if name is not None and all(one.name != f"{name}.length" for one in outputs_of(self._system, name)):
            message = f"{word} names the force {quote(name)}, which has no length"
            remedy = "Name a spring or damper between two points, such as a TSDA"
            raise SarrusError(f"{self.side}: {message}. {remedy}.")


def given_side(name: str, side: Side | None, sides: tuple[Side, ...]) -> Side:
    """A side of the suspension `name`; by default its first.

    Raises
    ------
    SarrusError
        If it has no wheel on this side.
    """
    if side is not None and side not in sides:
        raise SarrusError(f"{name}: there is no {side} wheel. Choose from {', '.join(sides)}.")
    return sides[0] if side is None else side
