"""The compliance of a suspension at the wheels: static displacements by unit loads, rates, and their derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from ..algebra import Array, cross
from ..analyses.equilibria.state_space import linearize
from ..analyses.equilibria.statics import equilibrium
from ..analyses.optimization import Combined
from ..analyses.sensitivity import sensitivity
from ..euler import A
from ..model import Input, PointForce, SarrusError, Torque
from ..model.show import suggest
from ..outputs import Outputs
from ..results import Equilibrium, Gradient, StateSpace
from ..results.result import Result
from ..system import System
from .corner import PlacedCorner, Side, given_side, of_rig
from .rig import Rig
from .wheel import Vehicle, contact_point, missing, refuse_missing, unit

LOADS = {"Fx": "N", "Fy": "N", "Fz": "N", "Mz": "N m", "Fx_hub": "N"}  # Fx, Fy at the contact point
PARTS = {"load": "force", "moment": "torque"}  # loads at the wheel centre


@dataclass(frozen=True)
class Rate:
    """A quantity that follows from static displacements by unit loads.

    Attributes
    ----------
    unit : of its value
    of : its value, of a function that gives the displacement of this side by loads on all sides
    needs : "other" for two wheels, "tyre_stiffness" of the vehicle
    """

    unit: str
    of: Callable[[Entries, Vehicle], Any]
    needs: tuple[str, ...] = ()


def _roll_rate(c: Entries, tyre: float = 0.0) -> Any:
    return c.track() ** 2 / (c("z", "Fz", opposed=True) * 2 + tyre)


def _tyre(vehicle: Vehicle) -> float:
    assert vehicle.tyre_stiffness is not None  # a rate that needs it is refused without it
    return vehicle.tyre_stiffness


def _in_series(rate: Any, stiffness: float) -> Any:
    return rate * stiffness / (rate + stiffness)


RATES: dict[str, Rate] = {
    "wheel_rate": Rate("N/m", lambda c, v: 1 / c("z", "Fz")),
    "ride_rate": Rate("N/m", lambda c, v: _in_series(1 / c("z", "Fz"), _tyre(v)), ("tyre_stiffness",)),
    "suspension_roll_rate": Rate("N m/rad", lambda c, v: _roll_rate(c), ("other",)),
    "total_roll_rate": Rate("N m/rad", lambda c, v: _roll_rate(c, 2 / _tyre(v)), ("other", "tyre_stiffness")),
    "fore_aft_stiffness": Rate("N/m", lambda c, v: 1 / c("x", "Fx_hub")),
    "ride_steer": Rate("rad/m", lambda c, v: c.toe("Fz") / c("z", "Fz")),
    "ride_camber": Rate("rad/m", lambda c, v: c("camber", "Fz") / c("z", "Fz")),
    "lateral_force_deflection": Rate("m/N", lambda c, v: c("y", "Fy")),
    "lateral_force_steer": Rate("rad/N", lambda c, v: c("steer", "Fy")),
    "lateral_force_camber": Rate("rad/N", lambda c, v: c("camber", "Fy")),
    "longitudinal_force_deflection": Rate("m/N", lambda c, v: c("x", "Fx")),
    "longitudinal_force_steer": Rate("rad/N", lambda c, v: c("steer", "Fx")),
    "longitudinal_force_camber": Rate("rad/N", lambda c, v: c("camber", "Fx")),
    "aligning_torque_steer": Rate("rad/(N m)", lambda c, v: c("steer", "Mz")),
    "aligning_torque_camber": Rate("rad/(N m)", lambda c, v: c("camber", "Mz")),
}


class Entries:
    """The displacements of one side by unit loads on all sides, by name, from values or traced numbers.

    Called with a displacement (x forward, y to the left, z up [m], steer, camber [rad]) and a load, in the same
    direction on all sides; if `opposed`, in the opposite one on the other side, for half of the difference of both.
    """

    def __init__(self, sides: Sequence[Side], side: Side, values: Mapping[str, Any] | None = None) -> None:
        self.sides, self.side, self.values, self.names = sides, side, values, list[str]()

    def _value(self, name: str) -> Any:
        if name not in self.names:
            self.names.append(name)
        return np.nan if self.values is None else self.values[name]

    def _entry(self, output: str, side: Side, load: str, loaded: Side) -> Any:
        return self._value(f"real[{of_rig(output, side)}, {of_rig(load, loaded)}, 0]")

    def __call__(self, output: str, load: str, opposed: bool = False) -> Any:
        """The displacement by a load."""
        if not opposed:
            return sum(self._entry(output, self.side, load, other) for other in self.sides)
        signs = {side: 1.0 if side == self.side else -1.0 for side in self.sides}
        return 0.5 * sum(signs[a] * signs[b] * self._entry(output, a, load, b) for a in signs for b in signs)

    def toe(self, load: str) -> Any:
        """The toe-in by a load."""
        return self("steer", load) * (1.0 if self.side == "right" else -1.0)

    def track(self) -> Any:
        """The lateral distance of the wheel centres. [m]"""
        return self._value(of_rig("y", "left")) - self._value(of_rig("y", "right"))


@dataclass(frozen=True, eq=False)
class Compliance(Result):
    """The compliance of a suspension at one position.

    Attributes
    ----------
    name : of the system
    at : displacement of the wheels [m]
    loads : static loads of the pads by side [N]
    components : names of the rows and columns of `matrix`
    matrix : (6, 6) or (12, 12) displacements of the wheel centres by loads at the wheel centres, in global axes, first
        of the left side: x, y, z [m] and small rotations about x, y, z [rad] by forces [N] and torques [N m]
    vehicle : its dimensions
    plant, held : the linearization under the static loads, and the equilibrium on the pads
    rig : the suspension on the rig
    """

    name: str
    at: float
    loads: Mapping[Side, float]
    components: tuple[str, ...] = field(repr=False)
    matrix: Array = field(repr=False)
    vehicle: Vehicle = field(repr=False)
    plant: StateSpace = field(repr=False)
    held: Equilibrium = field(repr=False)
    rig: Rig = field(repr=False)

    def names(self) -> list[str]:
        """The names of the rates that this suspension has."""
        return [name for name, one in RATES.items() if not missing(one.needs, self.rig.corners, self.vehicle)]

    def __getitem__(self, name: str) -> float:
        """The value of a rate of the first side, ``compliance["wheel_rate"]``."""
        return self.value(name)

    def value(self, name: str, side: Side | None = None) -> float:
        """The value of a rate of one side."""
        rate, side = self._rate(name), self._side(side)
        values = {name: self.plant[name] for name in self._entries(rate, side)}
        return float(rate.of(Entries(tuple(self.loads), side, values), self.vehicle))

    def sensitivity(
        self, name: str, side: Side | None = None, *, wrt: Sequence[str] | str | None = None
    ) -> Gradient:
        """The exact derivatives of a rate with respect to parameters, at a constant position of the wheels.

        The static loads of the pads change with the parameters: d/db = ∂/∂b + Σ ∂/∂F dF/db.
        """
        rate, side = self._rate(name), self._side(side)
        sides, names = tuple(self.loads), self._entries(rate, side)

        def of(*values: Any) -> Any:
            return rate.of(Entries(sides, side, dict(zip(names, values, strict=True))), self.vehicle)

        wanted = self.rig.parameters() if wrt is None else [wrt] if isinstance(wrt, str) else wrt
        pads = [f"{of_rig('load', one)}.force.z" for one in sides]
        response = Combined(of, names, name=f"{side} {name}")
        found = sensitivity(self.plant, response, [*wanted, *pads])
        own = [k for k, one in enumerate(found.names) if one not in pads]
        kept = tuple(found.names[k] for k in own)
        self.rig.refuse_moved_joints(kept)
        held = sensitivity(self.held, [f"{of_rig('pad', one)}.force.z" for one in sides], kept)
        by_loads = np.array([found[one] for one in pads])
        matrix = found.matrix[:, own] + by_loads @ held.matrix
        return replace(
            found, names=kept, at=found.at[own], matrix=matrix, response_units=(rate.unit,),
            units=tuple(found.units[k] for k in own), table_units=tuple(found.table_units[k] for k in own),
        )  # fmt: skip

    def _side(self, side: Side | None) -> Side:
        return given_side(self.name, side, tuple(self.loads))

    def _entries(self, rate: Rate, side: Side) -> list[str]:
        recorded = Entries(tuple(self.loads), side)
        rate.of(recorded, self.vehicle)
        return recorded.names

    def _rate(self, name: str) -> Rate:
        if name not in RATES:
            raise SarrusError(f"{self.name}: there is no rate {name!r}. {suggest(name, [*RATES])}")
        refuse_missing(f"{self.name}: {name}", RATES[name].needs, self.rig.corners, self.vehicle)
        return RATES[name]

    def summary(self) -> str:
        """The rates in words."""
        lines = [f"  {name:<32}{self.value(name):>14.6g} {RATES[name].unit}" for name in self.names()]
        return "\n".join([f"{self.name}: compliance at {self.at:g} m", *lines])


def compliance(rig: Rig, vehicle: Vehicle, at: float, q: Array) -> Compliance:
    """The compliance about the static equilibrium with the wheels at a displacement.

    Parameters
    ----------
    rig, vehicle : of the suspension
    at : displacement of the wheels [m]
    q : (nq,) the position of the sweep there

    Raises
    ------
    SarrusError
        If nothing carries the load of the wheels.
    """
    held = equilibrium(System(rig.loaded("bump")), q, t=at)
    if not held.success:
        raise SarrusError(f"{held.name}: at {at:g} m: {held.message}. Choose a position within the stroke.")
    loads = {side: float(held[f"{of_rig('pad', side)}.force.z"]) for side in rig.corners}
    parts = [part for side, placed in rig.corners.items() for part in _loads(placed, loads[side])]
    model = rig.mounted(rig.steered(0.0), parts)
    named = {
        of_rig(key, side): text for side, one in rig.corners.items() for key, text in _outputs(one).items()
    }
    system = System(replace(model, outputs={**model.outputs, **named}))
    rest = equilibrium(system, held.q, stable=False)
    if not rest.success or rest.stability == "neutral":
        message = "no force carries the load of the wheels. Add a spring between carrier and chassis."
        raise SarrusError(f"{rest.name}: {message}")
    inputs = [of_rig(load, side) for side in loads for load in LOADS]
    plant = linearize(system, rest, inputs=inputs, outputs=[*named])
    columns = [
        f"{of_rig(part, side)}.{load}.{x}" for side in loads for part, load in PARTS.items() for x in "xyz"
    ]
    rows = [one for placed in rig.corners.values() for one in _six(rest, placed)]
    matrix = sensitivity(rest, rows, columns).matrix
    names = tuple(f"{side}.{one}" for side in loads for one in ("x", "y", "z", "rx", "ry", "rz"))
    return Compliance(system.name, at, loads, names, matrix, vehicle, plant, held, rig)


def _six(rest: Equilibrium, placed: PlacedCorner) -> list[Callable[[Outputs], Any]]:
    """The displacements of a wheel centre and the rotations of its carrier from an equilibrium."""
    carrier, system = placed.corner.carrier, rest.system
    assert system is not None
    axes = A(rest.q[system.coordinates_of(carrier)][3:])
    return [partial(_displacement, carrier, axes, placed.local("centre"), n) for n in range(6)]


def _loads(placed: PlacedCorner, load: float) -> list[Any]:
    """The static load, loads of zero at the wheel centre, and the inputs: forces along x and y, and so on."""
    side, ahead, left = placed.side, (-placed.axes[0]).tolist(), placed.left.tolist()
    centre, spindle = placed.coordinates("centre"), placed.coordinates("spindle")
    contact = contact_point(centre, unit(centre - spindle), placed.corner.radius)
    at_centre, at_contact = (placed.body.global_point(*point) for point in (centre, contact))
    name = {one: of_rig(one, side) for one in LOADS}
    on_road = tuple(f"{a!r}*{name['Fx']} + {b!r}*{name['Fy']}" for a, b in zip(ahead, left, strict=True))
    on_hub = (*(f"{a!r}*{name['Fx_hub']}" for a in ahead[:2]), name["Fz"])
    return [
        *(Input(name[one], 0.0, unit=unit) for one, unit in LOADS.items()),
        PointForce(of_rig("load", side), at_centre, (0.0, 0.0, load)),
        Torque(of_rig("moment", side), placed.body, (0.0, 0.0, 0.0)),
        PointForce(of_rig("on_road", side), at_contact, on_road),
        PointForce(of_rig("on_hub", side), at_centre, on_hub),
        Torque(of_rig("aligning", side), placed.body, ("0*t", "0*t", name["Mz"])),
    ]


def _outputs(placed: PlacedCorner) -> dict[str, str]:
    """Formulas of the position of the wheel centre along x, y and z, of the steer angle and of the camber."""
    centre, spindle = _place(placed, "centre"), _place(placed, "spindle")

    def along(direction: Array, point: str) -> str:
        """A component of the position of a point."""
        terms = zip(direction.tolist(), "xyz", strict=True)
        return " + ".join(f"{a!r}*{point}.{axis}" for a, axis in terms if a)

    x, y, z = (f"({along(row, centre)} + {along(-row, spindle)})" for row in placed.axes)
    sign = "" if placed.side == "left" else "-"
    angles = {"steer": f"{sign}atan2({x}, {y})", "camber": f"-atan2({z}, sqrt({x}^2 + {y}^2))"}
    directions = {"x": -placed.axes[0], "y": placed.left, "z": placed.axes[2]}
    return {name: along(one, centre) for name, one in directions.items()} | angles


def _place(placed: PlacedCorner, name: str) -> str:
    """The output of the position of a point: of its marker, which follows its hardpoint, or of the carrier."""
    point = placed.points[name]
    if not point.end:
        return f"{point.part}.position"
    x, y, z = placed.local(name).tolist()
    return f"{placed.corner.carrier}({x!r}, {y!r}, {z!r})"


def _displacement(carrier: str, axes: Array, local: Array, n: int, o: Outputs) -> Any:
    """Component n of the position of the wheel centre, or of a small rotation from known axes: ½ Σ e_i × e_i'."""
    if n < 3:
        return o.position(carrier, local)[n]
    origin = o.position(carrier)
    turned = [cross(axes[:, i], o.position(carrier, np.eye(3)[i]) - origin) for i in range(3)]
    return 0.5 * (turned[0][n - 3] + turned[1][n - 3] + turned[2][n - 3])
