"""The recorded geometry of wheels on a rig, in the axes of the vehicle: x rearward, y outboard, z up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..algebra import Array, cross
from ..functions import sqrt
from ..model import SarrusError
from ..model.quantity import fraction, positive
from ..outputs import Outputs
from .corner import PlacedCorner, Side


@dataclass(frozen=True)
class Vehicle:
    """Dimensions of the vehicle that characteristics of the suspension refer to.

    Parameters
    ----------
    wheelbase : [m]
    cg_height : height of the centre of mass above the road [m]
    brake_share : part of the braking force that acts on this axle, 0 to 1
    drive_share : part of the driving force that acts on this axle, 0 to 1
    inboard_brakes : whether the reaction of the braking torque acts on the chassis, not on the carrier
    tyre_stiffness : vertical stiffness of a tyre [N/m]
    """

    wheelbase: float | None = None
    cg_height: float | None = None
    brake_share: float | None = None
    drive_share: float | None = None
    inboard_brakes: bool = False
    tyre_stiffness: float | None = None

    def __post_init__(self) -> None:
        for name, unit in (("wheelbase", "m"), ("cg_height", "m"), ("tyre_stiffness", "N/m")):
            if (value := getattr(self, name)) is not None:
                positive(value, f"vehicle: {name}", f"Give it in {unit}.")
        for name in ("brake_share", "drive_share"):
            if (value := getattr(self, name)) is not None:
                fraction(value, f"vehicle: {name}", "Give the part of this axle, such as 0.6.")
        if not isinstance(self.inboard_brakes, bool):
            raise SarrusError(
                f"vehicle: inboard_brakes must be True or False, got {self.inboard_brakes!r}. Give one of them."
            )


class Axle:
    """The recorded wheels of a suspension.

    Parameters
    ----------
    o : Outputs, of the motion on the rig
    corners : by side
    vehicle : its dimensions
    """

    def __init__(self, o: Outputs, corners: Mapping[Side, PlacedCorner], vehicle: Vehicle) -> None:
        self.o, self.vehicle = o, vehicle
        self.wheels = {side: Wheel(self, placed) for side, placed in corners.items()}

    def rate(self, x: Any) -> Any:
        """The exact derivative of a recorded quantity along the sweep, recorded as well."""
        tape, o = self.o.tape, self.o
        needed, rates = set(tape.origins(x.at)), {}
        for (kind, n), variable in list(o.inputs.items()):
            if variable.at in needed and kind in ("q", "v"):
                rates[variable.at] = o.input("v" if kind == "q" else "a", n)
        if o.t.at in needed:
            rates[o.t.at] = o.constant(1.0)
        return tape.recorded_along(x, rates)


class Wheel:
    """The recorded geometry of one wheel, in the axes of the vehicle; all vectors are (3,)."""

    def __init__(self, axle: Axle, placed: PlacedCorner) -> None:
        self.axle, self.placed = axle, placed
        self._body = placed.corner.carrier

    def rate(self, x: Any) -> Any:
        """See `Axle.rate`."""
        return self.axle.rate(x)

    def _vector(self, global_vector: Array) -> Array:
        return np.asarray(self.placed.axes @ global_vector)

    def point(self, name: str) -> Array:
        """Position of a point of the carrier. [m]"""
        return self._vector(self.placed.points[name].position(self.axle.o, self._body))

    def design(self, name: str) -> Array:
        """Position of a point of the carrier in the design position. [m]"""
        return self._vector(self.placed.points[name].recorded_design(self.axle.o))

    @cached_property
    def centre(self) -> Array:
        """C, the wheel centre. [m]"""
        return self.point("centre")

    @cached_property
    def spindle(self) -> Array:
        """s, the unit vector of the spin axis, outboard."""
        return unit(self.centre - self.point("spindle"))

    @cached_property
    def contact(self) -> Array:
        """A, the lowest point of the wheel: in the plane of the wheel, at the distance of the radius from C. [m]"""
        return contact_point(self.centre, self.spindle, self.placed.corner.radius)

    @cached_property
    def kingpin(self) -> tuple[Array, Array]:
        """A point of the steering axis [m], and its upward direction (not normalized).

        Without a kingpin, the axis of the instantaneous screw of a steering motion: p = C + ω × v_C/ω².
        """
        if "lower" in self.placed.points:
            lower = self.point("lower")
            return lower, self.point("upper") - lower
        w = self.angular_velocity
        upward = np.sign(np.mean(w[2].value))
        return self.centre + cross(w, self.velocity(self.centre)) / (w @ w), upward * w

    @cached_property
    def on_road(self) -> Array:
        """G, the intersection of the steering axis with the level of the road under this wheel. [m]"""
        return self.kingpin_at(self.contact[2])

    def kingpin_at(self, z: Any) -> Array:
        """The point of the steering axis at a height. [m]"""
        point, axis = self.kingpin
        return np.asarray(point + axis * ((z - point[2]) / axis[2]))

    @cached_property
    def angular_velocity(self) -> Array:
        """ω of the carrier per unit of the sweep, in the vehicle's axes.

        Those of the right side are left-handed: the sign makes v = ω × r hold in them.
        """
        handed = float(np.linalg.det(self.placed.axes))
        return self._vector(self.axle.o.angular_velocity(self._body)) * handed

    def velocity(self, point: Array) -> Array:
        """Velocity of the point of the carrier that is at a position."""
        origin = self._vector(self.axle.o.position(self._body))
        moving = self._vector(self.axle.o.velocity(self._body))
        return np.asarray(moving + cross(self.angular_velocity, point - origin))

    @cached_property
    def contact_velocity(self) -> Array:
        """Velocity of the point of the carrier at A: that of the contact point of a locked wheel."""
        return self.velocity(self.contact)

    def length_of(self, force: str) -> Any:
        """The length of a spring or damper. [m]"""
        return self.axle.o(f"{force}.length")


def missing(needs: Sequence[str], corners: Mapping[Side, PlacedCorner], vehicle: Vehicle) -> str:
    """What a quantity needs and a suspension does not have; empty if nothing. "other" is the other wheel."""
    for need in needs:
        owners = [one.corner for one in corners.values()] if need in ("spring", "damper") else [vehicle]
        if len(corners) == 1 if need == "other" else any(getattr(one, need) is None for one in owners):
            return need
    return ""


def refuse_missing(
    what: str, needs: Sequence[str], corners: Mapping[Side, PlacedCorner], vehicle: Vehicle
) -> None:
    """Refuse a quantity for which something is missing."""
    if need := missing(needs, corners, vehicle):
        remedies = dict.fromkeys(("spring", "damper"), f"Name it in the corner, Corner(..., {need}=...)")
        remedies["other"] = "Give both wheels, left= and right="
        remedy = remedies.get(need, f"Give it, vehicle=sr.Vehicle({need}=...)")
        raise SarrusError(f"{what} needs {need}. {remedy}.")


def unit(vector: Array) -> Array:
    """The unit vector of a recorded vector."""
    return np.asarray(vector / sqrt(vector @ vector))


def contact_point(centre: Array, spindle: Array, radius: float) -> Array:
    """C + R d, with d the downward direction in the plane of the wheel, d ∝ (s·z) s - z."""
    down = spindle * spindle[2]
    down = np.array([down[0], down[1], down[2] - 1.0], dtype=down.dtype)
    return np.asarray(centre + radius * unit(down))
