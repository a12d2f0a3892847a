"""The characteristics of a suspension: names, units and definitions, each a function of a recorded wheel.

The axes are x rearward, y outboard and z up, on both sides; C is the wheel centre, s the unit vector of the spin axis,
k the steering axis, A the contact point, G the point of the steering axis on the road. A dot is the derivative along
the sweep.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

from ..functions import atan, atan2, cos, sin, sqrt, tan
from ..model import SarrusError
from ..model.show import suggest
from .wheel import Wheel, contact_point, unit

SweepName: TypeAlias = Literal["bump", "roll", "steer", "kingpin"]
EVERY: tuple[SweepName, ...] = ("bump", "roll", "steer")
ABOUT_KINGPIN: tuple[SweepName, ...] = (*EVERY, "kingpin")
VERTICAL: tuple[SweepName, ...] = ("bump", "roll")
Needed: TypeAlias = tuple[str, ...]


@dataclass(frozen=True)
class Characteristic:
    """A quantity of a suspension over a sweep.

    Attributes
    ----------
    name, unit : ``toe``, rad
    of : its value, of a recorded wheel
    sweeps : in which it is defined
    needs : dimensions of `Vehicle`, parts of `Corner`, "other" for the other wheel
    """

    name: str
    unit: str
    of: Callable[[Wheel], Any]
    sweeps: tuple[SweepName, ...] = EVERY
    needs: Needed = ()


CHARACTERISTICS: dict[str, Characteristic] = {}


def characteristic(
    unit: str, *, sweeps: tuple[SweepName, ...] = EVERY, needs: Needed = ()
) -> Callable[[Callable[[Wheel], Any]], Callable[[Wheel], Any]]:
    """Register a function of a wheel as the characteristic of its name."""

    def register(of: Callable[[Wheel], Any]) -> Callable[[Wheel], Any]:
        CHARACTERISTICS[of.__name__] = Characteristic(of.__name__, unit, of, sweeps, needs)
        return of

    return register


class Slope(NamedTuple):
    """A characteristic and the sweep of which its slope has a name of its own."""

    characteristic: str
    sweep: SweepName


SLOPES = {
    "ride_steer": Slope("toe", "bump"),
    "ride_camber": Slope("camber", "bump"),
    "ride_caster": Slope("caster", "bump"),
    "roll_steer": Slope("toe", "roll"),
    "roll_camber": Slope("camber", "roll"),
    "roll_caster": Slope("caster", "roll"),
}


@characteristic("rad")
def toe(w: Wheel) -> Any:
    """Toe-in: -atan2(s_x, s_y); positive if the front of the wheel is turned inward."""
    return -atan2(w.spindle[0], w.spindle[1])


@characteristic("rad")
def camber(w: Wheel) -> Any:
    """asin(-s_z); positive if the top of the wheel leans outboard."""
    x, y, z = w.spindle
    return -atan2(z, sqrt(x * x + y * y))


@characteristic("rad", sweeps=ABOUT_KINGPIN)
def caster(w: Wheel) -> Any:
    """atan2(k_x, k_z); positive if the top of the steering axis leans rearward."""
    return atan2(w.kingpin[1][0], w.kingpin[1][2])


@characteristic("rad", sweeps=ABOUT_KINGPIN)
def kingpin_inclination(w: Wheel) -> Any:
    """atan2(-k_y, k_z); positive if the top of the steering axis leans inboard."""
    return -atan2(w.kingpin[1][1], w.kingpin[1][2])


@characteristic("m", sweeps=ABOUT_KINGPIN)
def scrub_radius(w: Wheel) -> Any:
    """A_y - G_y; positive if the contact point is outboard of the steering axis."""
    return w.contact[1] - w.on_road[1]


@characteristic("m", sweeps=ABOUT_KINGPIN)
def caster_trail(w: Wheel) -> Any:
    """A_x - G_x; positive if the contact point is behind the steering axis."""
    return w.contact[0] - w.on_road[0]


@characteristic("m", sweeps=ABOUT_KINGPIN)
def mechanical_trail(w: Wheel) -> Any:
    """Distance of the contact point from the steering axis in side view: caster_trail cos(caster)."""
    return caster_trail(w) * cos(caster(w))


@characteristic("m", sweeps=ABOUT_KINGPIN)
def spindle_offset(w: Wheel) -> Any:
    """The distance of the wheel centre outboard of the steering axis, at the height of the centre."""
    return w.centre[1] - w.kingpin_at(w.centre[2])[1]


@characteristic("m", sweeps=ABOUT_KINGPIN)
def hub_trail(w: Wheel) -> Any:
    """The distance of the wheel centre behind the steering axis, at the height of the centre."""
    return w.centre[0] - w.kingpin_at(w.centre[2])[0]


@characteristic("m")
def wheel_travel(w: Wheel) -> Any:
    """Displacement of the wheel centre upward."""
    return w.centre[2] - w.design("centre")[2]


@characteristic("m")
def wheel_recession(w: Wheel) -> Any:
    """Displacement of the wheel centre rearward."""
    return w.centre[0] - w.design("centre")[0]


@characteristic("m")
def track_change(w: Wheel) -> Any:
    """Displacement of the contact point outboard: the change of half the track."""
    centre, spindle = w.design("centre"), w.design("spindle")
    return w.contact[1] - contact_point(centre, unit(centre - spindle), w.placed.corner.radius)[1]


@characteristic("rad", sweeps=VERTICAL)
def fvsa_angle(w: Wheel) -> Any:
    """Angle of the front-view swing arm: atan(Ȧ_y/Ȧ_z); positive if it rises inboard from the contact point."""
    return atan(w.contact_velocity[1] / w.contact_velocity[2])


@characteristic("m", sweeps=VERTICAL)
def fvsa_length(w: Wheel) -> Any:
    """Horizontal length of the front-view swing arm: -Ȧ_z over the rate of camber; positive if inboard."""
    return -w.contact_velocity[2] / w.rate(camber(w))


@characteristic("1/m", sweeps=VERTICAL)
def fvsa_curvature(w: Wheel) -> Any:
    """Reciprocal of the length of the front-view swing arm; 0 if it is infinite, as with parallel arms."""
    return -w.rate(camber(w)) / w.contact_velocity[2]


@characteristic("rad", sweeps=VERTICAL)
def svsa_angle(w: Wheel) -> Any:
    """Angle of the side-view swing arm: atan(Ȧ_x/Ȧ_z), of C with inboard brakes; positive if it rises forward."""
    x, _, z = _braked(w)
    return atan(x / z)


@characteristic("m", sweeps=VERTICAL)
def svsa_length(w: Wheel) -> Any:
    """Horizontal length of the side-view swing arm: -Ȧ_z/ω_y; positive if its end is ahead of the wheel."""
    return -_braked(w)[2] / w.angular_velocity[1]


@characteristic("1/m", sweeps=VERTICAL)
def svsa_curvature(w: Wheel) -> Any:
    """Reciprocal of the length of the side-view swing arm; 0 if it is infinite."""
    return -w.angular_velocity[1] / _braked(w)[2]


def _braked(w: Wheel) -> Any:
    return w.velocity(w.centre) if w.axle.vehicle.inboard_brakes else w.contact_velocity


@characteristic("m", sweeps=VERTICAL)
def roll_centre_height(w: Wheel) -> Any:
    """Height above the road of the point in which the normals to Ȧ meet in front view.

    Of one wheel, where its normal meets the centre plane: A_y Ȧ_y/Ȧ_z.
    """
    if len(w.axle.wheels) == 1:
        return w.contact[1] * w.contact_velocity[1] / w.contact_velocity[2]
    left, right = (w.axle.wheels[side].contact for side in ("left", "right"))
    return _roll_centre(w)[1] - 0.5 * (left[2] + right[2])


@characteristic("m", sweeps=VERTICAL, needs=("other",))
def roll_centre_lateral(w: Wheel) -> Any:
    """Lateral position of this point, to the left of the centre plane."""
    return _roll_centre(w)[0]


def _roll_centre(w: Wheel) -> tuple[Any, Any]:
    """y (to the left) and z of the intersection: (y - A_y) Ȧ_y + (z - A_z) Ȧ_z = 0 on both sides, by Cramer's rule."""
    rows = []
    for side, sign in (("left", 1.0), ("right", -1.0)):
        wheel = w.axle.wheels[side]  # type: ignore[index]
        n_y, n_z = sign * wheel.contact_velocity[1], wheel.contact_velocity[2]
        rows.append((n_y, n_z, n_y * (sign * wheel.contact[1]) + n_z * wheel.contact[2]))
    (a, b, e), (c, d, f) = rows
    determinant = a * d - b * c
    return (e * d - b * f) / determinant, (a * f - e * c) / determinant


@characteristic("%", sweeps=VERTICAL, needs=("wheelbase", "cg_height", "brake_share"))
def anti_dive(w: Wheel) -> Any:
    """Of a front axle under braking, in percent: -100 p (L/h) Ȧ_x/Ȧ_z, of C with inboard brakes."""
    return -_anti(w, "brake_share") * _braked(w)[0] / _braked(w)[2]


@characteristic("%", sweeps=VERTICAL, needs=("wheelbase", "cg_height", "brake_share"))
def anti_lift(w: Wheel) -> Any:
    """Of a rear axle under braking, in percent: 100 p (L/h) Ȧ_x/Ȧ_z, of C with inboard brakes."""
    return _anti(w, "brake_share") * _braked(w)[0] / _braked(w)[2]


@characteristic("%", sweeps=VERTICAL, needs=("wheelbase", "cg_height", "drive_share"))
def anti_squat(w: Wheel) -> Any:
    """Of a rear axle whose differential is on the chassis, under drive, in percent: 100 p (L/h) Ċ_x/Ċ_z."""
    x, _, z = w.velocity(w.centre)
    return _anti(w, "drive_share") * x / z


def _anti(w: Wheel, share: str) -> float:
    vehicle: Any = w.axle.vehicle
    return float(100 * getattr(vehicle, share) * vehicle.wheelbase / vehicle.cg_height)


@characteristic("1", sweeps=VERTICAL, needs=("spring",))
def spring_ratio(w: Wheel) -> Any:
    """Motion ratio of the spring: the derivative of its length by the travel of the wheel centre."""
    return w.rate(w.length_of(str(w.placed.corner.spring))) / w.velocity(w.centre)[2]


@characteristic("1", sweeps=VERTICAL, needs=("damper",))
def damper_ratio(w: Wheel) -> Any:
    """Motion ratio of the damper: the derivative of its length by the travel of the wheel centre."""
    return w.rate(w.length_of(str(w.placed.corner.damper))) / w.velocity(w.centre)[2]


@characteristic("rad", sweeps=("roll",), needs=("other",))
def roll_angle(w: Wheel) -> Any:
    """Roll of the chassis relative to the road, positive to the right: the right wheel is in bump."""
    left, right = (w.axle.wheels[side].contact for side in ("left", "right"))
    return atan2(right[2] - left[2], left[1] + right[1])


@characteristic("rad")
def steer_angle(w: Wheel) -> Any:
    """Angle of the wheel about the vertical axis, positive to the left."""
    return toe(w) * (1.0 if w.placed.side == "right" else -1.0)


def _steered(w: Wheel) -> tuple[Any, Any]:
    """Steer angles of the left and the right wheel."""
    return steer_angle(w.axle.wheels["left"]), steer_angle(w.axle.wheels["right"])


@characteristic("rad", sweeps=("steer",), needs=("other",))
def ackermann_angle(w: Wheel) -> Any:
    """Steer angle of the inner minus that of the outer wheel: δ_left - δ_right, in both directions."""
    left, right = _steered(w)
    return left - right


@characteristic("rad", sweeps=("steer",), needs=("other", "wheelbase"))
def ackermann_error(w: Wheel) -> Any:
    """ackermann_angle minus that of cot δ_right - cot δ_left = track/wheelbase with the angle of this wheel."""
    return ackermann_angle(w) - _ideal(w)


@characteristic("%", sweeps=("steer",), needs=("other", "wheelbase"))
def ackermann_percentage(w: Wheel) -> Any:
    """ackermann_angle in percent of the ideal one; not defined straight ahead."""
    return 100 * ackermann_angle(w) / _ideal(w)


def _ideal(w: Wheel) -> Any:
    """δ_left - δ_right of a common centre of rotation on the line of the other axle, with the angle of this wheel."""
    left, right = (w.axle.wheels[side].contact for side in ("left", "right"))
    track, t = left[1] + right[1], tan(steer_angle(w))
    other = 1.0 if w.placed.side == "left" else -1.0  # tan δ of the other wheel is t/(1 ± t track/L)
    return other * (steer_angle(w) - atan2(t, 1 + other * t * track / w.axle.vehicle.wheelbase))


@characteristic("m", sweeps=("steer",), needs=("wheelbase",))
def turn_radius(w: Wheel) -> Any:
    """Radius of the path of this wheel about a centre on the line of the other axle: L/sin|δ|."""
    return w.axle.vehicle.wheelbase / sqrt(sin(steer_angle(w)) ** 2)


@characteristic("m", sweeps=("steer",), needs=("wheelbase",))
def turn_diameter(w: Wheel) -> Any:
    """Twice the radius of the path of this wheel; of the outer wheel, the turning circle between kerbs."""
    return 2 * turn_radius(w)


RECIPROCALS = {"fvsa_length": "fvsa_curvature", "svsa_length": "svsa_curvature"}


def find(name: str) -> Characteristic:
    """A characteristic by name.

    Raises
    ------
    SarrusError
        If there is none.
    """
    if name not in CHARACTERISTICS:
        hint = suggest(name, [*CHARACTERISTICS, *SLOPES])
        raise SarrusError(f"characteristics: there is no {name!r}. {hint}")
    return CHARACTERISTICS[name]


__all__ = ["CHARACTERISTICS", "SLOPES", "Characteristic", "find"]
