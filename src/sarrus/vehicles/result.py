"""The result of a suspension on the rig: characteristics over bump, roll and steer, and their derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from ..algebra import Array
from ..analyses.driven.kinematics import kinematics
from ..analyses.sensitivity import At, sensitivity
from ..deferred import renderer
from ..model import SarrusError
from ..model.announcement import announce
from ..model.checks.arguments import in_si
from ..model.quantity import number
from ..outputs import Outputs
from ..outputs.motion import motion_outputs, over
from ..outputs.units import quotient
from ..results import Gradient, Trajectory
from ..results.result import Result
from ..system import System
from .characteristics import CHARACTERISTICS, RECIPROCALS, SLOPES, Characteristic, SweepName, find
from .compliance import Compliance, compliance
from .corner import Side, given_side
from .elastic import whole_motion
from .rig import Rig, Sweep, coordinate
from .tables import ROUND_OFF, frame_of, text_table, write_csv
from .wheel import Axle, Vehicle, missing, refuse_missing

SAME = 1e-9  # of the range of a sweep: displacements so near are the same


@dataclass(frozen=True)
class Recorded:
    """A characteristic or its slope as a function of `Outputs`, for responses of sweeps.

    The slope in roll is that by the roll angle, in other sweeps that by the displacement.
    """

    suspension: Suspension
    characteristic: Characteristic
    sweep: SweepName
    side: Side
    slope: bool

    @property
    def __name__(self) -> str:
        return f"{'slope of ' * self.slope}{self.side} {self.characteristic.name} in {self.sweep}"

    def unit(self, system: System) -> str:
        """The unit of its value."""
        own = self.characteristic.unit
        return quotient(own, self.suspension.unit(self.sweep)) if self.slope else own

    def __call__(self, o: Outputs) -> Any:
        """The recorded value."""
        return self.of(Axle(o, self.suspension.rig.corners, self.suspension.vehicle))

    def of(self, axle: Axle) -> Any:
        """The value, of recorded wheels."""
        wheel = axle.wheels[self.side]
        value = self.characteristic.of(wheel)
        if not self.slope:
            return value
        by = axle.rate(CHARACTERISTICS["roll_angle"].of(wheel)) if self.sweep == "roll" else 1.0
        return axle.rate(value) / by


@dataclass(frozen=True, eq=False)
class Suspension(Result):
    """Result of `suspension`: characteristics over sweeps.

    Attributes
    ----------
    name : of the system
    rig : the suspension on the rig
    vehicle : dimensions of the vehicle
    sweeps : the motions of the sweeps by name: bump, roll, steer
    success : whether all sweeps reached their ends
    message : which did not, and why
    """

    name: str
    rig: Rig = field(repr=False)
    vehicle: Vehicle
    sweeps: Mapping[SweepName, Sweep] = field(repr=False)
    success: bool
    message: str

    @property
    def sides(self) -> tuple[Side, ...]:
        """The sides with a wheel."""
        return tuple(self.rig.corners)

    def unit(self, sweep: SweepName) -> str:
        """The unit of that by which slopes are taken: of the displacement, in roll of the roll angle."""
        if sweep in ("steer", "kingpin"):
            return "m" if "displacement" in coordinate(self.rig.system, self.rig.steering)[1] else "rad"
        return {"bump": "m", "roll": "rad"}[sweep]

    def compliance(self, at: float = 0.0) -> Compliance:
        """The compliance at the wheels, with the wheels at a displacement of bump under their static loads.

        Raises
        ------
        SarrusError
            If no spring carries the wheels.
        """
        row = self._row("bump", at)
        return compliance(self.rig, self.vehicle, float(self.x("bump")[row]), self._sweep("bump").run.q[row])

    def names(self, sweep: SweepName = "bump") -> list[str]:
        """The names of the characteristics that a sweep has for this suspension."""
        allowed = [one for one in CHARACTERISTICS.values() if sweep in self._allowed(one)]
        return [one.name for one in allowed if not missing(one.needs, self.rig.corners, self.vehicle)]

    def x(self, sweep: SweepName = "bump") -> Array:
        """Displacement of the sweep (n,): of the wheels upward; in roll of the right wheel; of the steering."""
        return self._sweep(sweep).run.t

    def curve(
        self, name: str, sweep: SweepName | None = None, side: Side | None = None, *, slope: bool = False
    ) -> Array:
        """The values of a characteristic over a sweep (n,), or its exact slopes.

        Parameters
        ----------
        name : ``toe``, or the name of a slope, ``ride_steer``
        sweep : by default bump, or the first in which it is defined
        side : by default the only one, or the left
        slope : the derivative by the displacement, in roll by the roll angle
        """
        return self._values(self.response(name, sweep, side, slope=slope))

    def _values(self, response: Recorded) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):  # a radius is infinite straight ahead
            values = over(response.of(self._axles[response.sweep]), self.x(response.sweep))
        return np.where(abs(values) * ROUND_OFF > 1.0, np.inf, values)  # over an angle that is round-off

    @cached_property
    def _axles(self) -> dict[SweepName, Axle]:
        """The recorded wheels of each sweep, for the values of curves."""
        return {name: self._axle(one) for name, one in self.sweeps.items()}

    def _axle(self, sweep: Sweep) -> Axle:
        assert sweep.run.system is not None
        outputs = motion_outputs(sweep.run.system, sweep.run, Outputs)
        return Axle(outputs, self.rig.corners, self.vehicle)

    def __getitem__(self, name: str) -> Array:
        """The curve of a characteristic, ``result["toe"]``, see `curve`."""
        return self.curve(name)

    def at(
        self,
        name: str,
        at: float = 0.0,
        sweep: SweepName | None = None,
        side: Side | None = None,
        *,
        slope: bool = False,
    ) -> float:
        """The value of a characteristic, or its slope, at one displacement of the sweep."""
        sweep = self.response(name, sweep, side).sweep
        return float(self.curve(name, sweep, side, slope=slope)[self._row(sweep, at)])

    def sensitivity(
        self,
        name: str | Sequence[str],
        at: float = 0.0,
        sweep: SweepName | None = None,
        side: Side | None = None,
        *,
        slope: bool = False,
        wrt: Sequence[str] | None = None,
    ) -> Gradient:
        """The exact derivatives of characteristics of one sweep, or of their slopes, at one displacement.

        Parameters
        ----------
        name, sweep, side, slope : as in `curve`; several names for several rows
        at : one of the displacements `x`
        wrt : names of parameters, ``lower_ball.point``; by default all

        Warns
        -----
        SarrusWarning
            For each characteristic that is infinite or undefined there, such as the length of the swing arm of parallel
            arms; it is left out. `SarrusError` if it is the only one.
        """
        names = [name] if isinstance(name, str) else name
        responses = [self.response(one, sweep, side, slope=slope) for one in names]
        found = {one.sweep for one in responses}
        if not found:
            raise SarrusError(f"{self.name}: there is no name of a characteristic. Give one, such as 'toe'.")
        if len(found) > 1:
            raise SarrusError(f"{self.name}: {', '.join(found)} are different sweeps. Give sweep=.")
        chosen, row = self._sweep(responses[0].sweep).run, self._row(responses[0].sweep, at)
        time = float(chosen.t[row])
        responses = self._defined(responses, row)
        at_time = [At(one, f"{one.__name__} at {time:g}", time=time) for one in responses]
        gradient = sensitivity(chosen, at_time, self.rig.parameters() if wrt is None else wrt)
        self.rig.refuse_moved_joints(gradient.names)
        return gradient

    def _defined(self, responses: Sequence[Recorded], row: int) -> list[Recorded]:
        """The responses with a finite value at a place of the sweep; the others are left out with a warning."""
        at = self.x(responses[0].sweep)[row]
        values = {one: float(self._values(one)[row]) for one in responses}
        finite = [one for one, value in values.items() if np.isfinite(value)]
        words = {one: "infinite" if np.isinf(value) else "undefined" for one, value in values.items()}
        left = [one for one in responses if one not in finite]
        messages = [f"{self.name}: {one.__name__} is {words[one]} at {at:g}. {_instead(one)}" for one in left]
        if not finite:
            raise SarrusError(messages[0])
        announce(messages)
        return finite

    def analysis(self, sweep: SweepName = "bump") -> Callable[[System], Trajectory]:
        """The motion of a sweep as a function of its system with other parameters, for `optimize` and `Problem`."""
        run = self._sweep(sweep).run
        if run.analysis == "equilibria":
            return partial(whole_motion, displacements=run.t)
        return partial(kinematics, times=run.t, q=run.q[0])

    def table(self, sweep: SweepName = "bump", side: Side | None = None) -> str:
        """The characteristics in the design position and their slopes, in mm and degrees, as text."""
        self._sweep(sweep)
        return text_table(self, sweep, given_side(self.name, side, self.sides))

    def to_csv(self, path: str | Path, sweep: SweepName = "bump") -> None:
        """Write all curves of a sweep, in mm and degrees."""
        self._sweep(sweep)
        write_csv(self, path, sweep)

    def to_frame(self, sweep: SweepName = "bump") -> Any:
        """All curves of a sweep as a pandas DataFrame, in mm and degrees; needs the extra `tables`."""
        self._sweep(sweep)
        return frame_of(self, sweep)

    def plot(self, sweep: SweepName = "bump", *names: str, ax: Any = None) -> Any:
        """Draw curves of a sweep, by default the usual sheet; see `sarrus.views.plot_suspension`."""
        for name in names:
            self.response(name, sweep)
        self._sweep(sweep)
        return renderer().plot_suspension(self, sweep, names, ax)

    def summary(self) -> str:
        """The characteristics of the first side in bump, and which sweeps end early."""
        sweep = next(iter(self.sweeps))
        return self.table(sweep) + ("" if self.success else f"\n{self.message}")

    def headline(self) -> str:
        """The name, the sides and the sweeps."""
        return f"{self.name}: {' and '.join(self.sides)}, {', '.join(self.sweeps)}"

    def response(
        self, name: str, sweep: SweepName | None = None, side: Side | None = None, *, slope: bool = False
    ) -> Recorded:
        """A characteristic or its slope as a function of outputs of a sweep, for `At`, `Maximum`, `Integral`.

        Raises
        ------
        SarrusError
            For a name, a sweep or a side that this suspension does not have.
        """
        if name in SLOPES:
            of, own = SLOPES[name]
            if sweep not in (None, own):
                message = f"{name} is the slope of {of} in {own}, not in {sweep}"
                remedy = f"Leave out the sweep, or take {of} with slope=True"
                raise SarrusError(f"{self.name}: {message}. {remedy}.")
            name, sweep, slope = of, own, True
        found = find(name)
        side = given_side(self.name, side, self.sides)
        refuse_missing(f"{self.name}: {name}", found.needs, self.rig.corners, self.vehicle)
        allowed = self._allowed(found)
        usual = next((one for one in allowed if one in self.sweeps), allowed[0])
        chosen: SweepName = usual if sweep is None else sweep
        self._sweep(chosen)
        if chosen not in allowed:
            raise SarrusError(f"{self.name}: {name} is not defined in {chosen}. Use {', '.join(allowed)}.")
        return Recorded(self, found, chosen, side, slope)

    def _allowed(self, found: Characteristic) -> tuple[SweepName, ...]:
        """The sweeps in which a characteristic is defined; if it is about virtual kingpins, only their own."""
        if "kingpin" in found.sweeps and any(one.corner.kingpin is None for one in self.rig.corners.values()):
            return ("kingpin",)
        return found.sweeps

    def _sweep(self, sweep: SweepName) -> Sweep:
        if sweep not in self.sweeps:
            limits_of_roll = "Give limits, roll=(-0.03, 0.03)"
            remedy = {
                "roll": limits_of_roll if len(self.sides) > 1 else "Give both wheels, left= and right=",
                "steer": "Give the joint that steers, steering=, and limits, steer=(-0.03, 0.03)",
                "bump": "Give limits, bump=(-0.05, 0.05)",
                "kingpin": "Give both points of kingpin in the corners, or steering= and their springs",
            }.get(sweep, f"Choose from {', '.join(self.sweeps)}")
            raise SarrusError(f"{self.name}: there is no sweep {sweep!r}. {remedy}.")
        return self.sweeps[sweep]

    def _row(self, sweep: SweepName, at: float) -> int:
        """The place of a displacement among those of a sweep."""
        what = f"{self.name}: the displacement"
        at = in_si(what, at, "m" if sweep == "roll" else self.unit(sweep))
        at = number(at, what, "Give one of those of x.")
        x = self.x(sweep)
        row = int(np.argmin(abs(x - at)))
        if abs(x[row] - at) > SAME * np.ptp(x):
            message = f"{at:g} is no displacement of {sweep}. Take {x[row]:g}, or change steps."
            raise SarrusError(f"{self.name}: {message}")
        return row


def _instead(response: Recorded) -> str:
    """What to differentiate in the place of a response without a finite value."""
    name = response.characteristic.name
    if name in RECIPROCALS and not response.slope:
        return f"Take the derivatives of its reciprocal, {RECIPROCALS[name]}."
    return "Take its derivatives at another displacement, at=."
