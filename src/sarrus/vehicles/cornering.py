"""Steady-state cornering by both methods of ISO 4138, and the linearized response to steering, ISO 7401."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..analyses.equilibria.state_space import linearize
from ..analyses.sensitivity.responses.responses import At, Maximum
from ..model import SarrusError
from ..model.checks.arguments import checked_by
from ..results import Trajectory
from ..results.state_space import StateSpace
from ..system import System
from .lane_change import PATH, SPACING, with_driver
from .manoeuvre import (
    CAR,
    CHECKS,
    DURATION,
    POSITIVE,
    Manoeuvre,
    Measured,
    Metric,
    VehicleNames,
    crossing,
    driven,
    histories,
    judged,
    rate_of,
)


@checked_by(**CHECKS)
def steady_state_cornering(
    system: System,
    speed: float = 80 / 3.6,
    angle: float = 1.0,
    *,
    rate: float = 0.2,
    levels: tuple[float, float] = (1.0, 3.0),
    wheelbase: float | None = None,
    steering_ratio: float | None = None,
    at: float = 1.0,
    names: VehicleNames = CAR,
    **options: Any,
) -> Manoeuvre:
    """Slow ramp of the steering wheel at constant speed, ISO 4138.

    The numbers: ``steer_gradient``, ``sideslip_gradient`` and ``roll_gradient``, the change of the angle of the
    steering wheel, of the sideslip and of the roll angle between two lateral accelerations, over their difference;
    ``lateral_acceleration``, the largest one. With the wheelbase L and the steering ratio i, also the
    ``understeer_gradient``, that of the understeer angle δ/i − L a_y/V². A constant delay behind the ramp does not
    change these gradients.

    Curves are those of the histories: ``result["steering_angles"]`` over ``result["lateral_accelerations"]``.

    Parameters
    ----------
    system : System
    speed : V [m/s]
    angle : of the steering wheel at the end [rad], negative to the right
    rate : of this angle [rad/s]; ISO 4138 allows up to 15 deg/s
    levels : lateral accelerations between which gradients are taken, absolute [m/s²]
    wheelbase : L [m]
    steering_ratio : i, the angle of the steering wheel over that of the front wheels [-]
    at : start of the ramp [s], until which the vehicle settles
    names : of the parts of the vehicle
    options : for `simulate`

    Raises
    ------
    SarrusError
        If the vehicle does not reach these accelerations, or numbers are out of their range.
    """
    low, high = levels
    if not (angle and 0 < low < high):
        message = "angle must not be 0, and levels must be positive and rise"
        raise SarrusError(f"{system.name}: {message}. Change angle={angle:g}, {levels=}.")
    side = float(np.sign(angle))
    inputs = {names.steer: f"{side * rate}*max(t - {at}, 0)", names.speed: speed}
    run = driven(system, speed, at + abs(angle) / rate, inputs, names, options)
    understeer = _understeer(system, names, wheelbase, steering_ratio)
    responses = _gradients(run, names, side, levels, at, understeer)
    return judged("steady-state cornering", run, responses, histories(names))


@checked_by(**CHECKS | {"rate": POSITIVE, "at": DURATION})
def constant_radius_cornering(
    system: System,
    radius: float = 100.0,
    lateral_acceleration: float = 4.0,
    *,
    rate: float = 0.1,
    levels: tuple[float, float] = (1.0, 3.0),
    wheelbase: float | None = None,
    steering_ratio: float | None = None,
    preview: float = 8.0,
    gain: float = 1.0,
    curvature_gain: float = 45.0,
    lag: float = 0.05,
    at: float = 2.0,
    names: VehicleNames = CAR,
    **options: Any,
) -> Manoeuvre:
    """A circle of constant radius R with slowly rising speed, ISO 4138: V² = R a_y, where a_y rises uniformly.

    The vehicle drives straight ahead, goes over to the circle, and settles there; then its speed rises. A driver
    replaces the input of the steering wheel, as in `double_lane_change`.

    The numbers are those of `steady_state_cornering`, and ``deviation``, the largest distance from the path of the
    point in front of the vehicle that the driver looks at. The understeer gradient is that of δ/i − L a_y/V², so that
    a small deviation from the radius does not change it. The force that raises the speed, V̇ = rate √(R/a_y)/2, has a
    part in it, and falls with the rate.

    Parameters
    ----------
    system : System
    radius : R [m], negative to the right
    lateral_acceleration : V²/R at the end [m/s²]
    rate : of this acceleration [m/s³]; ISO 4138 allows up to 0.1 m/s³
    levels : lateral accelerations between which gradients are taken, absolute [m/s²]; it begins with half of the first
    wheelbase : L [m]
    steering_ratio : i, the angle of the steering wheel over that of the front wheels [-]
    preview : distance of the point in front of the origin of the chassis at which the driver looks [m]
    gain : of the driver [rad/m]
    curvature_gain : of the driver [rad m], about i L
    lag : time constant of the driver [s]
    at : time of straight driving, of the way onto the circle, and on it before the speed rises [s]
    names : of the parts of the vehicle
    options : for `simulate`

    Raises
    ------
    SarrusError
        If the vehicle does not reach these accelerations, or numbers are out of their range.
    """
    low, high = levels
    if not (radius and 0 < low < high < lateral_acceleration):
        message = "radius must not be 0, and levels must be positive and rise to lateral_acceleration"
        given = f"{radius=:g}, {levels=}, {lateral_acceleration=:g}"
        raise SarrusError(f"{system.name}: {message}. Change {given}.")
    first, size, side = low / 2, abs(radius), float(np.sign(radius))
    speed, begin, rise = (size * first) ** 0.5, 3 * at, (lateral_acceleration - first) / rate
    inputs = {names.speed: f"sqrt({size}*({first} + {rate}*min(max(t - {begin}, 0), {rise})))"}
    way = speed * begin + 2 / 3 * size**0.5 * (lateral_acceleration**1.5 - first**1.5) / rate
    path = onto_circle(radius, speed * at, way + 5 * preview)
    driver = {"preview": preview, "gain": gain, "curvature_gain": curvature_gain, "lag": lag}
    run = driven(with_driver(system, path, names, **driver), speed, begin + rise, inputs, names, options)
    angle = _understeer(system, names, wheelbase, steering_ratio)
    responses = _gradients(run, names, side, levels, begin, angle)
    responses["deviation"] = Maximum(f"abs({PATH}.deviation)")
    return judged("constant-radius cornering", run, responses, histories(names))


def onto_circle(radius: float, straight: float, length: float) -> list[list[float]]:
    """Points [x, y] of a path along x, then onto a circle within the same length, and along it [m].

    The curvature of the way onto the circle is u² (3 − 2 u)/R. The last point is beyond `length`.
    """
    s = np.arange(0.0, length + SPACING, SPACING)
    middle = (s[1:] + s[:-1]) / 2
    u = np.clip(middle / straight - 1, 0.0, 1.0)
    heading = np.cumsum(u * u * (3 - 2 * u) * SPACING / radius)
    heading -= np.diff(heading, prepend=0.0) / 2  # at the middle of each interval
    places = np.cumsum(SPACING * np.stack([np.cos(heading), np.sin(heading)], axis=1), axis=0)
    return [[0.0, 0.0], *places.tolist()]


def _understeer(
    system: System, names: VehicleNames, wheelbase: float | None, steering_ratio: float | None
) -> str | None:
    """The understeer angle as a formula, δ/i less the Ackermann angle L a_y/V²; None without numbers."""
    if (wheelbase is None) != (steering_ratio is None):
        message = "the understeer gradient needs wheelbase and steering_ratio. Give both."
        raise SarrusError(f"{system.name}: {message}")
    if wheelbase is None:
        return None
    curvature = f"{names.lateral_acceleration}/{names.chassis}.velocity_body.x^2"
    return f"{names.steer}/{steering_ratio} - {wheelbase}*{curvature}"


def _gradients(
    run: Trajectory,
    names: VehicleNames,
    side: float,
    levels: tuple[float, float],
    after: float,
    understeer: str | None,
) -> dict[str, Metric]:
    """The changes of angles between two lateral accelerations over their difference, and the largest acceleration."""
    lateral = names.lateral_acceleration
    reached = [crossing(run, lateral, side * level, after) for level in levels]
    accelerations = [At(lateral, time=T.time) for T in reached]
    outputs = {"steer": names.steer, "sideslip": names.sideslip, "roll": names.roll}
    responses: dict[str, Metric] = {}
    for name, output in (outputs | ({"understeer": understeer} if understeer else {})).items():
        rates = [rate_of(run, output, T.time) for T in reached]

        def slope(low: Any, high: Any, a_low: Any, a_high: Any, rates: Any = rates) -> Any:
            each = zip((low, high), (a_low, a_high), rates, reached, levels, strict=True)
            first, last = (y + rate * (T(side * level, a_y) - T.time) for y, a_y, rate, T, level in each)
            return (last - first) / (side * (levels[1] - levels[0]))

        parts = [*(At(output, time=T.time) for T in reached), *accelerations]
        responses[f"{name}_gradient"] = Measured(slope, parts, symbol="rad s²/m")
    return responses | {"lateral_acceleration": Maximum(f"abs({lateral})")}


@checked_by(**CHECKS)
def steering_response(
    system: System, speed: float = 80 / 3.6, *, at: float = 5.0, names: VehicleNames = CAR, **options: Any
) -> StateSpace:
    """Linearization about straight driving by the angle of the steering wheel, for frequency responses of ISO 7401.

    Its outputs are those of a manoeuvre: yaw rate, lateral acceleration, sideslip and roll angle. Its poles are those
    of the vehicle at this speed. See `linearize` for its derivatives.

    Parameters
    ----------
    system : System
    speed : [m/s]
    at : time of straight driving before the linearization [s], in which the vehicle settles
    names : of the parts of the vehicle
    options : for `simulate`

    Raises
    ------
    SarrusError
        If a driver follows the input: steer by a force or torque.
    """
    run = driven(system, speed, at, {names.steer: 0.0, names.speed: speed}, names, options)
    assert run.system is not None
    assert run.final is not None
    outputs = [names.yaw_rate, names.lateral_acceleration, names.sideslip, names.roll]
    return linearize(run.system, run.final, inputs=[names.steer], outputs=outputs)
