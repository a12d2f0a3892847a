"""Double lane changes by ISO 3888: lanes, a path through them, a driver who follows it, and the distance to cones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ..analyses.dynamics.events.events import Event
from ..analyses.sensitivity.responses.responses import At, Final, Maximum, Minimum
from ..model import FirstOrderLag, PathFollower, SarrusError
from ..model.checks.arguments import checked_by
from ..model.states.input import Input
from ..system import System
from .manoeuvre import CAR, CHECKS, Manoeuvre, Metric, VehicleNames, driven, histories, judged

SPACING = 4.0  # [m] of the points of the path
PATH, PASSED = "path_of_driver", "passed"  # names of the part, and of the event at the end
SLOWEST = 2.0  # times as long as at constant speed, after which the vehicle has not passed
STEEP = 10.0  # growth of the distance to cones beyond the ends of a lane: a vehicle does not turn as steeply


class Lane(NamedTuple):
    """A lane between cones.

    begin, end : along the road, from the first cone [m]
    centre : of the lane, to the left of that of the first lane [m]
    width : [m]
    """

    begin: float
    end: float
    centre: float
    width: float


def severe(width: float) -> tuple[Lane, ...]:
    """The lanes of ISO 3888-1 for a vehicle of a width [m], with 3.5 m from edge to edge of neighbouring lanes."""
    first, second, third = (factor * width + 0.25 for factor in (1.1, 1.2, 1.3))
    offset = 3.5 + (second - first) / 2  # right edges
    return Lane(0, 15, 0, first), Lane(45, 70, offset, second), Lane(95, 125, (third - first) / 2, third)


def avoidance(width: float) -> tuple[Lane, ...]:
    """The lanes of ISO 3888-2, with 1 m between the left edge of the first and the right edge of the second lane."""
    first, second, third = 1.1 * width + 0.25, width + 1.0, max(1.3 * width + 0.25, 3.0)
    offset = first / 2 + 1.0 + second / 2
    return Lane(0, 12, 0, first), Lane(25.5, 36.5, offset, second), Lane(49, 61, (third - first) / 2, third)


@dataclass(frozen=True)
class Track:
    """A lane change: lanes for a width, the length within them in which the path leaves their centres [m], coasting."""

    lanes: Callable[[float], tuple[Lane, ...]]
    overlap: float
    coasting: bool


TRACKS = {"3888-1": Track(severe, 5.5, False), "3888-2": Track(avoidance, 2.0, True)}
RELEASE = (2.0, 0.1)  # [m] behind the first cones, where the driver coasts in ISO 3888-2; [s] of the release


def path_through(lanes: Sequence[Lane], beyond: float, overlap: float) -> list[list[float]]:
    """Points [x, y] of the path along the centres of lanes, from -`beyond` to `beyond` behind the last one [m].

    Between two lanes, from `overlap` before the end of one to `overlap` behind the begin of the other, it is
    y = y_1 + (y_2 − y_1) (10 u³ − 15 u⁴ + 6 u⁵), whose curvature is continuous.
    """
    x = np.arange(-beyond, lanes[-1].end + beyond, SPACING)
    y = np.full(len(x), float(lanes[0].centre))
    for one, other in pairwise(lanes):
        first, last = one.end - overlap, other.begin + overlap
        u = np.clip((x - first) / (last - first), 0.0, 1.0)
        y += (other.centre - one.centre) * u**3 * (10 - 15 * u + 6 * u * u)
    return [[float(a), float(b)] for a, b in zip(x, y, strict=True)]


@dataclass(frozen=True)
class Cones:
    """The distance of a vehicle to the cones of a lane, as a function of `Outputs` [m]; negative where it hits them.

    It is that of the corners of the vehicle. Before and behind the lane it grows steeply, so that its minimum is in the
    lane.
    """

    lane: Lane
    chassis: str
    corners: tuple[tuple[float, float], ...]

    def unit(self, system: System) -> str:
        """m."""
        return "m"

    def __call__(self, o: Any) -> Any:
        """The smallest distance of all corners."""
        found = None
        for x, y in self.corners:
            place = o.position(self.chassis, (x, y, 0.0))
            beyond = np.maximum(np.maximum(self.lane.begin - place[0], place[0] - self.lane.end), 0.0)
            distance = self.lane.width / 2 - np.abs(place[1] - self.lane.centre) + STEEP * beyond
            found = distance if found is None else np.minimum(found, distance)
        return found


@checked_by(**CHECKS)
def double_lane_change(
    system: System,
    speed: float = 80 / 3.6,
    standard: str = "3888-1",
    *,
    width: float = 1.7,
    length: tuple[float, float] = (1.95, -2.15),
    overlap: float | None = None,
    preview: float = 4.0,
    gain: float = 1.0,
    curvature_gain: float = 60.0,
    lag: float = 0.05,
    at: float = 1.0,
    names: VehicleNames = CAR,
    **options: Any,
) -> Manoeuvre:
    """Double lane change at constant speed, ISO 3888-1, or with coasting to avoid an obstacle, ISO 3888-2.

    A driver replaces the input of the steering wheel. For a point in front of the vehicle, its angle is -`gain` times
    the distance to the left of the path, and `curvature_gain` times the curvature of the path, behind a lag. The
    gradient includes what the driver does.

    The numbers: ``margin_1`` to ``margin_3``, the smallest distances of the vehicle to the cones of each lane, negative
    where it hits them; ``lateral_acceleration``, ``roll`` and ``steer``, the largest values; ``entry_speed`` and
    ``final_speed``. The run ends when the rear end of the vehicle leaves the last lane.

    Parameters
    ----------
    system : System
    speed : at the start [m/s]
    standard : "3888-1" or "3888-2"
    width : of the vehicle [m], from which the widths of lanes follow
    length : x of the front and of the rear end of the vehicle in the axes of the chassis [m]
    overlap : length within each lane in which the path leaves or nears its centre [m], by default 5.5 m or 2 m
    preview : distance of the point in front of the origin of the chassis [m]
    gain : of the driver [rad/m]
    curvature_gain : of the driver [rad m], that of the steady state: the speed over the yaw rate gain
    lag : time constant of the driver [s]
    at : time from the start to the first lane [s], in which the vehicle settles
    names : of the parts of the vehicle
    options : for `simulate`

    Raises
    ------
    SarrusError
        If the vehicle does not pass the lanes, or there is no such standard.
    """
    if standard not in TRACKS:
        raise SarrusError(f"{system.name}: standard must be one of {', '.join(TRACKS)}, got {standard!r}.")
    if not length[0] > length[1]:
        message = f"{system.name}: length must be x of the front and of the rear end, got {length}"
        raise SarrusError(f"{message}. Give the greater one first.")
    track, ahead = TRACKS[standard], at * speed
    cones = [one._replace(begin=one.begin + ahead, end=one.end + ahead) for one in track.lanes(width)]
    overlap = track.overlap if overlap is None else overlap
    path = path_through(cones, ahead + 5 * preview, overlap)
    driver = {"preview": preview, "gain": gain, "curvature_gain": curvature_gain, "lag": lag}
    steered = with_driver(system, path, names, **driver)
    inputs: dict[str, Any] = {names.speed: speed}
    if track.coasting:
        release = at + RELEASE[0] / speed
        inputs[names.drive] = f"1 - step(t, {release}, 0, {release + RELEASE[1]}, 1)"
    end = cones[-1].end - length[1]
    passed = Event(f"{names.chassis}.x - {end}", direction=1, terminal=True, name=PASSED)
    run = driven(steered, speed, SLOWEST * end / speed, inputs, names, options, passed)
    if run.status != "event":
        message = f"{system.name}: it leaves the road, or stops, before the end of the lanes"
        raise SarrusError(f"{message}. Drive more slowly, or change the gains of the driver.")
    corners = tuple((x, y) for x in length for y in (width / 2, -width / 2))
    responses: dict[str, Metric] = {
        f"margin_{n}": Minimum(Cones(lane, names.chassis, corners)) for n, lane in enumerate(cones, 1)
    }
    largest = {"lateral_acceleration": names.lateral_acceleration, "roll": names.roll, "steer": names.steer}
    responses |= {name: Maximum(f"abs({output})") for name, output in largest.items()}
    forward = f"{names.chassis}.velocity_body.x"
    responses |= {"entry_speed": At(forward, time=at), "final_speed": Final(forward)}
    return judged(f"double lane change ISO {standard}", run, responses, histories(names))


def with_driver(
    system: System,
    path: Sequence[Sequence[float]],
    names: VehicleNames,
    *,
    preview: float,
    gain: float,
    curvature_gain: float,
    lag: float,
) -> System:
    """The system with a driver who follows a path in place of the input of the steering wheel.

    T δ̇ = k_c κ − k e − δ, with the deviation e and the curvature κ of the path at a point in front of the chassis.

    Raises
    ------
    SarrusError
        If the system has no such input.
    """
    names.refuse_missing(system, [names.steer])
    others = [one for one in system.model.forces if not (isinstance(one, Input) and one.name == names.steer)]
    angle = f"{curvature_gain}*{PATH}.curvature - {gain}*{PATH}.deviation"
    model = replace(system.model, forces=others).adding(
        PathFollower(PATH, f"{names.chassis}({preview}, 0, 0)", path),
        FirstOrderLag(names.steer, input=angle, time=lag, unit="rad"),
    )
    return System(model)
