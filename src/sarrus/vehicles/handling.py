"""Open-loop manoeuvres: step steer, sine with dwell, and straight braking."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..analyses.dynamics.events.events import Event
from ..analyses.sensitivity.combined import Combined
from ..analyses.sensitivity.responses.responses import At, AtEvent, Final, Maximum, Minimum
from ..model import SarrusError
from ..model.checks.arguments import checked_by
from ..results import Trajectory
from ..system import System
from .manoeuvre import (
    CAR,
    CHECKS,
    Manoeuvre,
    Measured,
    Metric,
    VehicleNames,
    crossing,
    driven,
    histories,
    judged,
    time_of,
)

SETTLED = 0.9  # share of the final value that defines response times, ISO 7401
SINE, DWELL = 0.7, 0.5  # [Hz], [s] of the steering of FMVSS 126
DECAY = {"yaw_rate_ratio_1_00": 1.0, "yaw_rate_ratio_1_75": 1.75}  # [s] after the steering, FMVSS 126
DISPLACEMENT_AT = 1.07  # [s] after the start of the steering, FMVSS 126
STOPPED, SLOWEST = "stopped", 0.5  # name of the event; [m/s²] mean deceleration that a vehicle must have
FULL = (0.8, 0.1)  # shares of the initial speed between which the deceleration is fully developed, ECE R13-H


@checked_by(**CHECKS)
def step_steer(
    system: System,
    speed: float = 80 / 3.6,
    angle: float = 0.5,
    *,
    rise: float = 0.1,
    at: float = 1.0,
    until: float = 5.0,
    names: VehicleNames = CAR,
    **options: Any,
) -> Manoeuvre:
    """Step input of the steering wheel at constant speed, ISO 7401.

    The numbers: ``yaw_rate``, ``lateral_acceleration`` and ``sideslip`` at the end, which must be steady;
    ``yaw_rate_gain`` [1/s] and ``lateral_acceleration_gain`` [m/s²], over the angle of the steering wheel; of both,
    ``yaw_rate_response_time`` and ``lateral_acceleration_response_time`` from half of the steering input to 90 % of the
    final value, ``..._peak``, and ``..._overshoot``, the peak over the final value less 1; if the yaw rate has a peak
    before the end, ``yaw_rate_peak_time`` from half of the steering input, and the ``tb_factor``, its product with the
    final sideslip [rad s].

    Parameters
    ----------
    system : System
    speed : [m/s]
    angle : of the steering wheel [rad], positive to the left
    rise : duration of the step [s]; ISO 7401 asks for at least 200 deg/s
    at : start of the step [s], until which the vehicle settles
    until : end [s]
    names : of the parts of the vehicle
    options : for `simulate`, such as ``method``
    """
    if not angle:
        raise SarrusError(f"{system.name}: angle must not be 0. Give the angle of the steering wheel in rad.")
    if not until > at + rise:
        message = f"until must be later than the end of the step, {at + rise:g} s, got {until:g}"
        raise SarrusError(f"{system.name}: {message}. Give a later time.")
    names.refuse_missing(system, [names.steer])
    steer = f"{angle}*step(t, {at}, 0, {at + rise}, 1)"
    run = driven(system, speed, until, {names.steer: steer, names.speed: speed}, names, options)
    begin, responses = at + rise / 2, dict[str, Metric]()
    outputs = {"yaw_rate": names.yaw_rate, "lateral_acceleration": names.lateral_acceleration}
    for name, output in (*outputs.items(), ("sideslip", names.sideslip)):
        responses[name] = Final(output)
    for name, output in outputs.items():
        peak = (Maximum if run[output][-1] > 0 else Minimum)(output)
        responses[f"{name}_gain"] = Combined(lambda y, wheel: y / wheel, [Final(output), Final(names.steer)])
        responses[f"{name}_response_time"] = time_of(run, output, SETTLED, begin)
        responses[f"{name}_peak"] = peak
        responses[f"{name}_overshoot"] = Combined(lambda top, end: top / end - 1, [peak, Final(output)])
    top = int(np.argmax(abs(run[names.yaw_rate])))
    if top + 1 < len(run.t):
        T = crossing(run, names.yaw_acceleration, 0.0, run.t[top - 1])
        now = At(names.yaw_acceleration, time=T.time)
        responses["yaw_rate_peak_time"] = Measured(lambda y: T(0.0, y) - begin, [now])
        both: list[Any] = [now, Final(names.sideslip)]
        responses["tb_factor"] = Measured(lambda y, beta: (T(0.0, y) - begin) * beta, both, symbol="rad s")
    return judged("step steer", run, responses, histories(names))


@checked_by(**CHECKS)
def sine_with_dwell(
    system: System,
    speed: float = 80 / 3.6,
    angle: float = 1.5,
    *,
    at: float = 1.0,
    names: VehicleNames = CAR,
    **options: Any,
) -> Manoeuvre:
    """Sine of 0.7 Hz with a dwell of 0.5 s at its second peak, FMVSS 126; the vehicle coasts from its start.

    The numbers: ``yaw_rate_peak`` after the steering reverses; ``yaw_rate_ratio_1_00`` and ``yaw_rate_ratio_1_75``, the
    yaw rate 1 s and 1.75 s after the steering ends over this peak, which must not be more than 0.35 and 0.2;
    ``lateral_displacement`` 1.07 s after the steering begins, of which 1.83 m are required up to 3.5 t.

    Parameters
    ----------
    system : System
    speed : at the start [m/s]
    angle : amplitude of the steering wheel [rad], positive to the left at first
    at : start of the sine [s], until which the vehicle settles
    names : of the parts of the vehicle
    options : for `simulate`
    """
    names.refuse_missing(system, [names.steer])
    dwell, end = at + 0.75 / SINE, at + 1 / SINE + DWELL
    phase = f"min(max(t - {at}, 0), {0.75 / SINE}) + min(max(t - {dwell + DWELL}, 0), {0.25 / SINE})"
    inputs = {names.steer: f"{angle}*sin(2*pi*{SINE}*({phase}))", names.speed: speed}
    inputs[names.drive] = f"1 - step(t, {at}, 0, {at + 0.1}, 1)"
    run = driven(system, speed, end + max(DECAY.values()), inputs, names, options)
    yaw, place = names.yaw_rate, f"{names.chassis}.y"
    peak = (Minimum if angle > 0 else Maximum)(yaw)
    responses: dict[str, Metric] = {"yaw_rate_peak": peak}
    for name, later in DECAY.items():
        responses[name] = Combined(lambda now, top: now / top, [At(yaw, time=end + later), peak])
    parts = [At(place, time=at + DISPLACEMENT_AT), At(place, time=at)]
    responses["lateral_displacement"] = Combined(lambda now, before: now - before, parts)
    return judged("sine with dwell", run, responses, histories(names))


@checked_by(**CHECKS)
def straight_braking(
    system: System,
    speed: float = 100 / 3.6,
    level: float = 1.0,
    *,
    rise: float = 0.2,
    at: float = 1.0,
    stop: float = 0.5,
    names: VehicleNames = CAR,
    **options: Any,
) -> Manoeuvre:
    """Braking on a straight road, ISO 21994, without the antilock system of the standard.

    The numbers: ``distance`` from the start of braking until the speed is `stop`, and on with the last deceleration;
    ``time`` until then; ``deceleration``, the mean fully developed one, (v_b² − v_e²)/(2 (s_e − s_b)) from 80 % to 10 %
    of the initial speed.

    Parameters
    ----------
    system : System
    speed : at the start [m/s]
    level : of the input of the brakes, from 0 to 1
    rise : duration of its increase [s]
    at : start of braking [s], until which the vehicle settles
    stop : speed at which the run ends [m/s]: brakes creep at standstill
    names : of the parts of the vehicle
    options : for `simulate`
    """
    if not stop < speed:
        message = f"{system.name}: stop must be less than the speed at the start, {speed:g} m/s, got {stop:g}"
        raise SarrusError(f"{message}. Give a smaller one.")
    place, along, rate = (f"{names.chassis}.{word}" for word in ("x", "velocity.x", "acceleration.x"))
    event = Event(f"{along} - {stop}", direction=-1, terminal=True, name=STOPPED)
    rising = f"step(t, {at}, 0, {at + rise}, 1)"
    inputs = {names.brake: f"{level}*{rising}", names.drive: f"1 - {rising}", names.speed: speed}
    longest = at + rise + speed / SLOWEST
    run = driven(system, speed, longest, inputs, names, options, event)
    if run.status != "event":
        message = f"{system.name}: it does not stop within {longest:.0f} s"
        raise SarrusError(f"{message}. Give stronger brakes, or a greater level.")
    begin, initial = At(place, time=at), At(along, time=at)
    last = [AtEvent(one, event=STOPPED) for one in (place, along, rate)]
    responses: dict[str, Metric] = {
        "distance": Combined(lambda s, v, a, before: s - v * v / (2 * a) - before, [*last, begin]),
        "time": Combined(lambda end: end - at, [AtEvent("t", event=STOPPED)]),
        "deceleration": _developed(run, (place, along, rate), initial, at),
    }
    outputs = {"speeds": along, "accelerations": rate, "places": place}
    return judged("straight braking", run, responses, outputs)


def _developed(run: Trajectory, motion: tuple[str, str, str], initial: Metric, at: float) -> Metric:
    """The mean fully developed deceleration, where s at the time T of v = share · v_0 is s(T) + v (share v_0 − v)/a."""
    first, last = FULL
    parts = [initial]
    for share in FULL:
        level = share * run[motion[1]][np.searchsorted(run.t, at)]
        T = crossing(run, motion[1], level, at)
        parts += [At(one, time=T.time) for one in motion]

    def mean(v_0: Any, s_b: Any, v_b: Any, a_b: Any, s_e: Any, v_e: Any, a_e: Any) -> Any:
        b, e = s_b + v_b * (first * v_0 - v_b) / a_b, s_e + v_e * (last * v_0 - v_e) / a_e
        return (first**2 - last**2) * v_0 * v_0 / (2 * (e - b))

    return Combined(mean, parts)
