"""A manoeuvre: a run of a vehicle from straight driving, and the numbers by which it is judged, with derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev

from ..algebra import Array
from ..analyses.dynamics.events.events import Event
from ..analyses.dynamics.simulation import simulate
from ..analyses.sensitivity.combined import Combined
from ..analyses.sensitivity.derivatives import response_values, sensitivity
from ..analyses.sensitivity.responses.responses import At, Final
from ..euler import A
from ..model import SarrusError
from ..model.announcement import announce, collecting, is_strict
from ..model.checks.arguments import Check, Number, NumberIn, Numbers
from ..model.errors import listed
from ..model.show import suggest
from ..results import Gradient, Trajectory
from ..results.result import Result
from ..system import System
from .rolling_start import rolling_start

INTERVAL = 0.005  # [s] of the output times, between which crossings are interpolated
# Of the polynomial within one step; of the step, within which its root may be outside
DEGREE, ROUND = 10, 1e-6
ASTRAY = 0.02  # [rad] from the x axis at the start; asymmetric wheels may turn a vehicle a little
OVER = "rolls over"  # name of the event
Metric = Any  # a response, or `Combined` ones
POSITIVE = Number(positive=True)
LENGTH, DURATION = NumberIn("m", POSITIVE), NumberIn("s", POSITIVE)
CHECKS: dict[str, Check] = {  # units and limits of the arguments that manoeuvres have in common
    **dict.fromkeys(("speed", "stop"), NumberIn("m/s", POSITIVE)),
    **dict.fromkeys(("width", "wheelbase", "overlap"), LENGTH),
    **dict.fromkeys(("rise", "until", "duration", "lag"), DURATION),
    **dict.fromkeys(("levels", "band", "length"), Numbers(2)),
    **dict.fromkeys(("gain", "curvature_gain"), Number()),
    "at": NumberIn("s", Number(0.0)),
    "angle": NumberIn("rad"),
    "rate": NumberIn("rad/s", POSITIVE),
    "radius": NumberIn("m"),
    "preview": NumberIn("m", Number(0.0)),
    "lateral_acceleration": NumberIn("m/s^2", POSITIVE),
    "level": NumberIn("1", Number(positive=True, most=1.0)),
    "steering_ratio": POSITIVE,
    "point": Numbers(3),
}


@dataclass(frozen=True)
class VehicleNames:
    """Names of the parts of a vehicle that a manoeuvre uses; the default ones are those of the mechanism ``car``.

    Parameters
    ----------
    chassis
        Body whose x axis is forward and whose y axis is to the left; its origin is the reference point. At the
        start, these are the global axes.
    steer, speed, brake, drive
        Inputs: angle of the steering wheel [rad], positive to the left; target of the speed controller [m/s]; brake
        from 0 to 1; share of the speed controller, 0 to coast.
    """

    chassis: str = "chassis"
    steer: str = "steer"
    speed: str = "speed"
    brake: str = "brake"
    drive: str = "drive"

    def refuse_missing(self, system: System, inputs: Iterable[str]) -> None:
        """Refuse a vehicle without this chassis, or without inputs.

        Raises
        ------
        SarrusError
            If one is missing.
        """
        here = "Give the names of the vehicle by names=sr.VehicleNames(...), '' for an input that it does not have"
        if self.chassis not in system.bodies:
            raise SarrusError(f"{system.name} has no body {self.chassis!r}. {here}.")
        for name in inputs:
            if name not in system.inputs:
                message = f"{system.name} has no input {name!r}"
                raise SarrusError(f"{message}. {here}. Its inputs: {', '.join(system.inputs) or 'none'}.")

    @property
    def yaw_rate(self) -> str:
        """ψ̇ [rad/s]."""
        return f"{self.chassis}.angular_velocity.z"

    @property
    def yaw_acceleration(self) -> str:
        """ψ̈ [rad/s²]."""
        return f"{self.chassis}.angular_acceleration.z"

    @property
    def lateral_acceleration(self) -> str:
        """a_y in the axes of the chassis [m/s²]."""
        return f"{self.chassis}.acceleration_body.y"

    @property
    def roll(self) -> str:
        """φ [rad]."""
        return f"{self.chassis}.roll"

    @property
    def sideslip(self) -> str:
        """β, the angle of the velocity to the x axis of the chassis [rad]."""
        return f"atan({self.chassis}.velocity_body.y/{self.chassis}.velocity_body.x)"


CAR = VehicleNames()


@dataclass(frozen=True, eq=False)
class Manoeuvre(Result):
    """Result of a manoeuvre.

    Attributes
    ----------
    name : of the manoeuvre and the system
    run : the run, with its steps
    responses : the numbers by which the manoeuvre is judged, by name: responses, and combinations of them
    values : their values
    histories : outputs that are usually plotted, by name
    """

    name: str
    run: Trajectory = field(repr=False)
    responses: Mapping[str, Metric] = field(repr=False)
    values: Mapping[str, float]
    histories: Mapping[str, str] = field(repr=False)

    @property
    def success(self) -> bool:
        """Whether the run reached its end."""
        return self.run.success

    @property
    def message(self) -> str:
        """How the run ended."""
        return self.run.message

    def __getitem__(self, name: str) -> Any:
        """A number by which the manoeuvre is judged, ``result["overshoot"]``, or a history over ``result.run.t``.

        Raises
        ------
        KeyError
            If there is none of this name.
        """
        if name in self.histories:
            return self.run[self.histories[name]]
        if name not in self.values:
            raise KeyError(f"no {name!r} in {self.name}. {suggest(name, [*self.values, *self.histories])}")
        return self.values[name]

    def sensitivity(
        self, names: str | Sequence[str] | None = None, wrt: Sequence[str] | None = None, **options: Any
    ) -> Gradient:
        """The derivatives of numbers by which the manoeuvre is judged, by default of all, see `sarrus.sensitivity`.

        Raises
        ------
        KeyError
            If there is none of a name.
        """
        wanted = [*self.responses] if names is None else [names] if isinstance(names, str) else [*names]
        for name in wanted:
            if name not in self.responses:
                raise KeyError(f"no response {name!r} in {self.name}. {suggest(name, [*self.responses])}")
        return sensitivity(self.run, [self.responses[name] for name in wanted], wrt, **options)

    def summary(self) -> str:
        """The numbers by which the manoeuvre is judged."""
        wide = max(map(len, self.values), default=0)
        rows = [
            f"  {name:{wide}}  {value:12.6g} {self.responses[name].unit(self.run.system)}".rstrip()
            for name, value in self.values.items()
        ]
        return "\n".join([f"{self.name}: {self.message}", *rows])


def driven(
    system: System,
    speed: float,
    until: float,
    inputs: Mapping[str, Any],
    names: VehicleNames,
    options: Mapping[str, Any],
    *events: Event,
) -> Trajectory:
    """The run of a manoeuvre from straight driving, with events that end it.

    Raises
    ------
    SarrusError
        If the vehicle does not have the names, does not start forwards along the global x axis, or rolls over, and
        if the run fails: there is nothing to judge.
    """
    if fixed := sorted({"system", "start", "until", "t_eval", "store"}.intersection(options)):
        message = f"{system.name}: {listed(fixed)} is determined by the manoeuvre"
        raise SarrusError(f"{message}. Leave it out, or call sr.simulate.")
    known = dict(options.get("inputs") or {}) | {name: value for name, value in inputs.items() if name}
    names.refuse_missing(system, known)
    t = np.linspace(0.0, until, round(until / INTERVAL) + 1)
    start = rolling_start(system, speed, known)
    place = system.coordinates_of(names.chassis)
    for what, (x, y, _) in (
        ("the velocity", start.v[place][:3]),
        (f"the x axis of {names.chassis}", A(start.q[place][3:])[:, 0]),
    ):
        if not abs(y) < ASTRAY * x:
            heading = f"{what} is along ({x:.3g}, {y:.3g}) at the start"
            remedy = "Turn the vehicle: forward is along the global x axis."
            raise SarrusError(f"{system.name}: {heading}. {remedy}")
    upright = Event(f"1 - 2*{names.chassis}.e1^2 - 2*{names.chassis}.e2^2", -1, terminal=True, name=OVER)
    given = options.get("events", ())
    every = [*events, upright, *(given if isinstance(given, Sequence) else [given])]
    rest = {**options, "events": every, "inputs": known}
    with collecting(is_strict()) as found:  # a vehicle that rolls over is an error alone
        run = simulate(system, start, until=until, t_eval=t, store="steps", **rest)
    if not run.success:
        message = f"{run.message.removesuffix('.')}. Correct the model, or drive more slowly."
        raise SarrusError(f"{system.name}: {message}")
    if run.status == "event" and run.events[-1].name == OVER:
        message = f"it rolls over, {names.chassis} lies on its side at t = {run.events[-1].t:.3g} s"
        raise SarrusError(f"{system.name}: {message}. Drive more slowly, or steer less.")
    announce(found.messages)
    return run


def judged(
    name: str, run: Trajectory, metrics: Mapping[str, Metric], histories: Mapping[str, str]
) -> Manoeuvre:
    """The result with the values of its responses, whose names in tables are those in the result."""
    responses = {name: replace(one, name=name) for name, one in metrics.items()}
    values = dict(zip(responses, map(float, response_values(run, [*responses.values()])), strict=True))
    return Manoeuvre(f"{name} of {run.name}", run, responses, values, histories)


def histories(names: VehicleNames) -> dict[str, str]:
    """Outputs that are plotted for a vehicle that turns."""
    return {
        "steering_angles": names.steer,
        "yaw_rates": names.yaw_rate,
        "lateral_accelerations": names.lateral_acceleration,
        "sideslips": names.sideslip,
        "rolls": names.roll,
    }


@dataclass(frozen=True, eq=False)
class Measured(Combined):
    """Combined responses whose unit is known."""

    symbol: str = "s"

    def unit(self, system: System) -> str:
        """The unit."""
        return self.symbol


class Crossing(NamedTuple):
    """A time T [s] at which an output y crosses a level L, and ẏ(T), by which T changes: dT = (dL − dy(T))/ẏ."""

    time: float
    rate: float

    def __call__(self, level: Any, now: Any) -> Any:
        """T, of the level and y(T)."""
        return self.time + (level - now) / self.rate


def crossing(run: Trajectory, output: str, level: float, after: float) -> Crossing:
    """The first crossing after a time, on the polynomial through samples of the motion within one step.

    Raises
    ------
    SarrusError
        If there is none.
    """
    t, y = run.t, run[output] - level
    inside = np.flatnonzero((t[:-1] >= after) & (y[:-1] * y[1:] <= 0) & (y[:-1] != y[1:]))
    for n in inside:
        for begin, end in pairwise(_nodes(run, t[n], t[n + 1])):
            y_of = _polynomial(run, output, begin, end)
            roots = (y_of - level).roots()
            near = roots[abs(roots - np.clip(roots.real, begin, end)) <= ROUND * (end - begin)].real
            if len(near):
                return Crossing(float(near.min()), float(y_of.deriv()(near.min())))
    message = f"{run.name}: {output} does not reach {level:g} after {after:g} s"
    raise SarrusError(f"{message}. Let the run end later, or steer more.")


def rate_of(run: Trajectory, output: str, time: float) -> float:
    """The rate of an output, on the polynomial through samples of the motion within one step."""
    nodes = _nodes(run, time - INTERVAL, time + INTERVAL)
    n = int(np.clip(np.searchsorted(nodes, time), 1, len(nodes) - 1))
    return float(_polynomial(run, output, nodes[n - 1], nodes[n]).deriv()(time))


def _nodes(run: Trajectory, begin: float, end: float) -> Array:
    """Two times, and the ends of steps between them."""
    assert run.steps is not None
    begin, end = max(begin, run.t[0]), min(end, run.t[-1])
    inner = run.steps.t[(run.steps.t > begin) & (run.steps.t < end)]
    return np.unique([begin, *inner, end])


def _polynomial(run: Trajectory, output: str, begin: float, end: float) -> Chebyshev:
    def samples(times: Array) -> Array:
        return response_values(run, [At(output, time=float(t)) for t in times])

    return Chebyshev.interpolate(samples, DEGREE, [begin, end])


def time_of(run: Trajectory, output: str, share: float, since: float) -> Measured:
    """The time from `since` until an output is a share of its final value."""
    T = crossing(run, output, share * run[output][-1], since)
    return Measured(lambda end, now: T(share * end, now) - since, [Final(output), At(output, time=T.time)])
