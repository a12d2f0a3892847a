"""Ride over a random road, with the frequency weightings of ISO 2631-1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..analyses.sensitivity.responses.responses import At, Final, Response
from ..model import RandomRoad, SarrusError, StateVariable, TransferFunction
from ..model.checks.arguments import checked_by
from ..model.states.input import Input
from ..model.tyres.rolling_tyre import RollingTyre
from ..system import System
from .manoeuvre import CAR, CHECKS, Manoeuvre, Measured, Metric, VehicleNames, driven, judged

BAND, BUTTERWORTH = (0.4, 100.0), 0.5**0.5  # [Hz] of the band limits, and their Q; ISO 2631-1, annex A
UNIFORM = "uniform_speed"  # input of the filters
AXES = {"x": "d", "y": "d", "z": "k"}  # weightings of a seated person on the seat


class Weighting(NamedTuple):
    """Frequencies [Hz] and qualities Q of a weighting, ISO 2631-1, table A.1.

    transition : f_3 = f_4 and Q_4 of the transition from acceleration to velocity
    step : f_5, Q_5, f_6 and Q_6 of the upward step, if there is one
    """

    transition: tuple[float, float]
    step: tuple[float, float, float, float] | None = None


WEIGHTINGS = {
    "k": Weighting((12.5, 0.63), (2.37, 0.91, 3.35, 0.91)),
    "d": Weighting((2.0, 0.63)),
    "e": Weighting((1.0, 0.63)),
}


def weighting_filters(name: str, velocity: str, weighting: str = "k") -> list[TransferFunction]:
    """Return filters whose output is the frequency-weighted acceleration of ISO 2631-1.

    The first filter takes a velocity, so that no filter depends on an acceleration. With ω = 2π f:

        low-pass         s ω_2²/(s² + √2 ω_2 s + ω_2²)
        high-pass        s²/(s² + √2 ω_1 s + ω_1²)
        transition       (1 + s/ω_3)/(1 + s/(Q_4 ω_4) + (s/ω_4)²)
        upward step      (1 + s/(Q_5 ω_5) + (s/ω_5)²)/(1 + s/(Q_6 ω_6) + (s/ω_6)²) · (ω_5/ω_6)²

    Parameters
    ----------
    name : of the last filter, whose output is ``name.output`` [m/s²]; the others are ``name_acceleration`` and so on
    velocity : a formula [m/s], such as ``"seat.velocity.z"``
    weighting : "k" for vertical vibration of a seat, "d" for horizontal vibration, "e" for rotation

    Raises
    ------
    SarrusError
        For another weighting.
    """
    if weighting not in WEIGHTINGS:
        known = ", ".join(WEIGHTINGS)
        raise SarrusError(f"weighting of {name} must be one of {known}, got {weighting!r}. Give one of them.")
    (f_4, Q_4), step = WEIGHTINGS[weighting]
    low, high = 2 * np.pi * BAND[0], 2 * np.pi * BAND[1]
    stages = [
        ("acceleration", [high**2, 0.0], _quadratic(high, BUTTERWORTH)),
        ("high_pass", [1.0, 0.0, 0.0], _quadratic(low, BUTTERWORTH)),
    ]
    if step is not None:
        f_5, Q_5, f_6, Q_6 = step
        stages.append(("step", _quadratic(2 * np.pi * f_5, Q_5), _quadratic(2 * np.pi * f_6, Q_6)))
    w = 2 * np.pi * f_4
    stages.append(("", [w, w**2], _quadratic(w, Q_4)))
    filters, signal = [], velocity
    for word, numerator, denominator in stages:
        own = f"{name}_{word}" if word else name
        one = TransferFunction(own, input=signal, numerator=numerator, denominator=denominator, unit="m/s^2")
        filters.append(one)
        signal = f"{own}.output"
    return filters


def _quadratic(w: float, Q: float) -> list[float]:
    """S² + (ω/Q) s + ω²."""
    return [1.0, w / Q, w**2]


@checked_by(**CHECKS)
def ride(
    system: System,
    speed: float = 80 / 3.6,
    road: RandomRoad | None = None,
    *,
    point: Sequence[float] = (0.0, 0.0, 0.0),
    duration: float = 10.0,
    at: float = 2.0,
    names: VehicleNames = CAR,
    **options: Any,
) -> Manoeuvre:
    """Straight driving over a random road with the frequency-weighted accelerations of ISO 2631-1.

    The numbers: ``weighted_x``, ``weighted_y`` and ``weighted_z``, the r.m.s. of the weighted accelerations (6.1; W_d,
    W_d and W_k, in the axes of the ground), ``total`` the root of the sum of their squares (6.5, with factors k = 1),
    and ``dose_z``, the fourth power vibration dose value [m/s^1.75] (6.3.2). An axis without vibration is left out.

    Parameters
    ----------
    system : System
    speed : [m/s]
    road : by default of class B with the seed 0; tyres on the left of the vehicle have its left track, others the right
    point : of the chassis, as of a seat, in its axes [m]
    duration : over which the accelerations are weighted [s]
    at : time from the start until then [s], in which the vehicle settles and the filters forget the start
    names : of the parts of the vehicle
    options : for `simulate`

    Raises
    ------
    SarrusError
        If the road is too short, or the vehicle has no rolling tyres.
    """
    end = (at + duration) * speed
    road = RandomRoad("B", length=1.1 * max(end, 100.0)) if road is None else road
    if not isinstance(road, RandomRoad):
        raise SarrusError(f"{system.name}: road must be a RandomRoad, got {road!r}. Give sr.RandomRoad('B').")
    if road.start + road.length < end:
        message = f"{system.name}: the road ends at {road.start + road.length:g} m, before {end:g} m"
        raise SarrusError(f"{message}. Give a longer one, or drive more slowly.")
    forces: list[Any] = [*system.model.forces]
    for n, one in enumerate(forces):
        if isinstance(one, RollingTyre):
            forces[n] = replace(one, road=road.left if _on_left(system, one) else road.right)
    x, y, z = map(float, point)
    # The start takes the states of the filters from rest, where their inputs are 0 as in uniform motion
    parts: list[Any] = [Input(UNIFORM, 0.0, unit="m/s")]
    for axis, weighting in AXES.items():
        name = f"weighted_{axis}"
        velocity = f"{names.chassis}({x}, {y}, {z}).velocity.{axis}"
        change = f"{velocity} - {UNIFORM}" if axis == "x" else velocity
        parts += weighting_filters(name, change, weighting)
        parts.append(StateVariable(f"{name}_squares", rate=f"{name}.output^2", initial=0.0))
    parts.append(StateVariable("weighted_z_fourths", rate="weighted_z.output^4", initial=0.0))
    model = replace(system.model, forces=forces).adding(*parts)
    inputs = {names.steer: 0.0, names.speed: speed, UNIFORM: speed}
    run = driven(System(model), speed, at + duration, inputs, names, options)

    def of_duration(output: str) -> list[Response]:
        return [Final(output), At(output, time=at)]

    def mean(*ends: Any) -> Any:
        return ((sum(ends[::2]) - sum(ends[1::2])) / duration) ** 0.5

    squares = {f"weighted_{axis}": of_duration(f"weighted_{axis}_squares") for axis in AXES}
    squares = {name: ends for name, ends in squares.items() if run[f"{name}_squares"][-1] > 0}
    squares["total"] = [one for ends in squares.values() for one in ends]
    responses: dict[str, Metric] = {
        name: Measured(mean, ends, symbol="m/s²") for name, ends in squares.items()
    }
    fourths = of_duration("weighted_z_fourths")
    responses["dose_z"] = Measured(lambda end, begin: (end - begin) ** 0.25, fourths, symbol="m/s^1.75")
    outputs = {"accelerations_z": "weighted_z.output", "places": f"{names.chassis}.x"}
    return judged("ride", run, responses, outputs)


def _on_left(system: System, tyre: RollingTyre) -> bool:
    """Whether a wheel is on the left side or in the middle, in the design position."""
    poses = system.model.design_poses()
    point = tyre.point.resolve(poses, "point")
    pose = poses[point.body]
    return bool((pose.r + pose.A @ np.asarray(point.s, dtype=float))[1] >= 0)
