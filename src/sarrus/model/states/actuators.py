"""Actuators with states: DC motors, hydraulic and pneumatic cylinders, and the activation of muscles."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from ..._jit.formulas.expression import Expression as Recorded
from ...functions import maximum, minimum, sqrt, step
from ..coordinate import ANGLE
from ..errors import ModelError
from ..forces.by_formula import WithParameters
from ..forces.force import Force
from ..forces.formula_element import load_primitive
from ..forces.springs import LineForce, along_joint
from ..laws.law import Law
from ..laws.recorded import Recording
from ..measure import In, Length
from ..primitive import Primitive
from ..quantity import fraction, not_negative, number, positive
from ..signals import Signals
from ..tape import value_of
from .block import StateValue, WithInput, WithNominal, rate_loads


@dataclass(frozen=True, eq=False)
class DCMotor(WithParameters, WithNominal, Force):
    """A motor on a ``joint``: inductance · di/dt = voltage - resistance · i - constant · gear · rate, and its torque.

    The torque on the joint is efficiency · gear · constant · i, ``name.value`` [N m]; the current i is the state
    ``name.current`` [A]. The inertia of the rotor is an `AngleInertia` of the same
    ``joint``, gear² times as much.

    Parameters
    ----------
    joint
        By name, or one of its angles, ``hook.angle_i``.
    voltage
        [V] A number, or a formula of outputs such as ``"pid.output"``, or a function.
    resistance, inductance
        Of the armature [Ω], [H].
    constant
        Of torque [N m/A], which is that of the back-EMF [V s].
    gear
        Revolutions of the motor for one of the joint.
    efficiency
        Of the gearbox, for the torque.
    initial
        Current at the start of a run [A].
    """

    joint: str
    voltage: Annotated[Law, In("V", outputs=True)]
    resistance: Annotated[float, In("ohm")]
    inductance: Annotated[float, In("H")]
    constant: Annotated[float, In("N m/A")]
    gear: Annotated[float, In("1")] = 1.0
    efficiency: Annotated[float, In("1")] = 1.0
    initial: Annotated[float, In("A")] = 0.0

    def states(self) -> Iterator[StateValue]:
        yield StateValue(f"{self.name}.current", number(self.initial, "initial"), "A", self.state_size())

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of the current's rate, and the torque."""
        target, x, v = along_joint(self.joint, ANGLE, signals)
        signals = signals.extended({"x": x, "v": v})
        current = f"{self.name}.current"
        r = Recording("voltage", {}, self.checked_parameters(), variables=signals.variables)
        back = r.number(number(self.constant, "constant")) * r.number(self._gear()) * r.named("v")
        drop = r.number(not_negative(self.resistance, "resistance", "Give it in Ω.")) * r.named(current)
        inductance = r.number(positive(self.inductance, "inductance", "Give it in H, however small."))
        slope = (r.law(self.voltage) - drop - back) / inductance
        yield from rate_loads([current], [slope], r, signals, "A/s")
        r = Recording("torque", {}, {})
        factors = (self.efficiency, "efficiency"), (self._gear(), "gear"), (self.constant, "constant")
        torque = r.named(current)
        for value, field in factors:
            torque = r.number(number(value, field)) * torque
        yield load_primitive(target, [torque], r, signals.of(r), "N m")

    def _gear(self) -> float:
        """The checked ratio."""
        ratio = number(self.gear, "gear")
        if ratio == 0.0:
            raise ModelError(
                "gear must not be 0. Give the motor's revolutions for one of the joint.", field="gear"
            )
        return ratio


@dataclass(frozen=True, eq=False, kw_only=True)
class HydraulicCylinder(LineForce, WithInput, Force):
    """A cylinder between two points, or on the displacement of a joint, behind a valve of four edges.

    ṗ_a = bulk · (q_a - leakage · (p_a - p_b) - area · v) / V_a,    V_a = dead + area · (x - retracted),
    ṗ_b = bulk · (q_b + leakage · (p_a - p_b) + rod_area · v) / V_b,
    V_b = dead + rod_area · (retracted + stroke - x),
    q_a = f(u₊, supply - p_a) - f(u₋, p_a - tank),    q_b = f(u₋, supply - p_b) - f(u₊, p_b - tank),
    f(u, Δ) = u · rated_flow · Δ / √(rated_drop · √(Δ² + width²)),    u± = (√(u² + underlap²) ± u) / 2

    f is the flow of an orifice, proportional to √|Δ|, rounded within ``width`` of zero; u is the ``input``. A positive
    u connects chamber a to the supply and b to the tank. The force that pushes the points apart, or increases the
    displacement, is p_a · area - p_b · rod_area, ``name.value``. The states are ``name.pressure_a`` and
    ``name.pressure_b`` [N/m²], relative to that outside; the flows are ``name.flow_a`` and ``name.flow_b`` [m³/s]. A
    run ends if a volume becomes 0: end stops are a `LengthStop` or a `DisplacementStop`.

    Parameters
    ----------
    point_i, point_j
        The ends, which must not coincide; x is their distance. Or instead of both the joint.
    joint
        By name; x is its displacement.
    input
        Opening u of the valve, -1 to 1: a number, a formula of outputs, or a function.
    area, rod_area
        Of the piston in chamber a, and in chamber b, less the rod [m²].
    retracted, stroke
        x at which the piston is at the end of chamber a, and from there to the end of chamber b [m].
    dead
        Volume of each chamber at its end, with its hose [m³].
    bulk
        Bulk modulus of the oil [N/m²].
    supply, tank
        Pressures of the pump and of the tank [N/m²].
    rated_flow, rated_drop
        Flow through one edge of the open valve [m³/s], at a pressure drop [N/m²].
    leakage
        Laminar flow between the chambers per pressure [m⁵/(N s)].
    width
        Pressure drop below which the flow is proportional to it [N/m²].
    underlap
        Part of the opening by which all edges are open around u = 0.
    initial_a, initial_b
        Pressures at the start of a run [N/m²].
    """

    area: Annotated[float, In("m^2")]
    rod_area: Annotated[float, In("m^2")]
    stroke: Length
    dead: Annotated[float, In("m^3")]
    supply: Annotated[float, In("N/m^2")]
    rated_flow: Annotated[float, In("m^3/s")]
    rated_drop: Annotated[float, In("N/m^2")]
    retracted: Length = 0.0
    bulk: Annotated[float, In("N/m^2")] = 1.4e9
    tank: Annotated[float, In("N/m^2")] = 0.0
    leakage: Annotated[float, In("m^5/N s")] = 0.0
    width: Annotated[float, In("N/m^2")] = 1e4
    underlap: Annotated[float, In("1")] = 1e-3
    initial_a: Annotated[float, In("N/m^2")] = 0.0
    initial_b: Annotated[float, In("N/m^2")] = 0.0

    def states(self) -> Iterator[StateValue]:
        nominal = float(value_of(positive(self.supply, "supply", "Give the pressure of the pump in N/m².")))
        for side, initial in (("a", self.initial_a), ("b", self.initial_b)):
            start = number(initial, f"initial_{side}")
            yield StateValue(f"{self.name}.pressure_{side}", start, "N/m²", nominal)

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of the pressures' rates, and the force."""
        target, x, v = self.line(signals)
        signals = signals.extended({"x": x, "v": v})
        r = self.recording("input", signals)
        flows = self._flows(r)
        names = [one.name for one in self.states()]
        outputs = {f"flow_{side}": (flow, "m³/s") for side, flow in zip("ab", flows, strict=True)}
        yield from rate_loads(names, self._rates(r, *flows), r, signals, outputs=outputs)
        r = Recording("area", {}, {})
        a, b = (r.named(name) for name in names)
        force = self._given(r, "area") * a - self._given(r, "rod_area") * b
        yield load_primitive(target, [force], r, signals.of(r), "N")

    def _given(self, r: Recording, field: str, checked: Any = positive) -> Recorded:
        """A checked number of the part."""
        return r.number(checked(getattr(self, field), field, "Give it in SI units."), f"{field}.own")

    def _flows(self, r: Recording) -> tuple[Recorded, Recorded]:
        """Flows into the chambers."""
        u, underlap = self.recorded_input(r), self._given(r, "underlap")
        both = sqrt(u * u + underlap * underlap)
        ahead, back = (both + u) / 2, (both - u) / 2
        width, drop = self._given(r, "width"), self._given(r, "rated_drop")
        rated, supply = self._given(r, "rated_flow"), self._given(r, "supply")
        tank = self._given(r, "tank", number)

        def flow(opening: Recorded, apart: Recorded) -> Any:
            return opening * rated * apart / sqrt(drop * sqrt(apart * apart + width * width))

        a, b = (r.named(f"{self.name}.pressure_{side}") for side in "ab")
        return flow(ahead, supply - a) - flow(back, a - tank), flow(back, supply - b) - flow(ahead, b - tank)

    def _rates(self, r: Recording, into_a: Recorded, into_b: Recorded) -> list[Recorded]:
        """Rates of the pressures; a negative volume has no root."""
        a, b = (r.named(f"{self.name}.pressure_{side}") for side in "ab")
        x, v = r.named("x") - self._given(r, "retracted", number), r.named("v")
        area, rod_area, dead = (self._given(r, field) for field in ("area", "rod_area", "dead"))
        leak, bulk = self._given(r, "leakage", not_negative) * (a - b), self._given(r, "bulk")
        net = into_a - leak - area * v, into_b + leak + rod_area * v
        volumes = dead + area * x, dead + rod_area * (self._given(r, "stroke") - x)
        return [bulk * flow / sqrt(volume) / sqrt(volume) for flow, volume in zip(net, volumes, strict=True)]


AMBIENT = 101325.0  # [N/m²] standard atmosphere
AIR = 287.05  # [J/(kg K)] gas constant of dry air


@dataclass(frozen=True, eq=False, kw_only=True)
class PneumaticChamber(LineForce, WithInput, Force):
    """A chamber with an ideal gas between two points, or on the displacement of a joint.

    ṗ = exponent · (gas_constant · temperature · ṁ - p · area · v) / V,    V = dead + area · (x - retracted)

    Without flow, p · V^exponent is constant. The force that pushes the points apart, or increases the displacement, is
    (p - ambient) · area, ``name.value``; the pressure p is the state ``name.pressure`` [N/m²], absolute. A run ends if
    the volume becomes 0. An equilibrium of a chamber without flow keeps the initial pressure, not the mass of the gas.

    Parameters
    ----------
    point_i, point_j
        The ends, which must not coincide; x is their distance. Or instead of both the joint.
    joint
        By name; x is its displacement.
    input
        Mass flow ṁ into the chamber [kg/s]: a number, 0 of a closed one; a formula of outputs, its pressure among them;
        or a function.
    area
        Of the piston [m²].
    retracted
        x at which the volume is ``dead`` [m].
    dead
        Volume of the chamber there [m³].
    exponent
        1 of an isothermal chamber, 1.4 of air without exchange of heat, or between them.
    temperature
        Of the gas that flows in or out [K], constant.
    gas_constant
        Per mass [J/(kg K)], 287.05 of air.
    ambient
        Pressure on the other side of the piston [N/m²].
    initial
        Pressure at the start of a run [N/m²].
    """

    input: Annotated[Law | None, In("kg/s", outputs=True)] = None
    area: Annotated[float, In("m^2")]
    dead: Annotated[float, In("m^3")]
    retracted: Length = 0.0
    exponent: Annotated[float, In("1")] = 1.0
    temperature: Annotated[float, In("K")] = 293.15
    gas_constant: Annotated[float, In("m^2/s^2 K")] = AIR
    ambient: Annotated[float, In("N/m^2")] = AMBIENT
    initial: Annotated[float, In("N/m^2")] = AMBIENT

    def states(self) -> Iterator[StateValue]:
        initial = positive(self.initial, "initial", "Give an absolute pressure in N/m².")
        yield StateValue(f"{self.name}.pressure", initial, "N/m²", AMBIENT)

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of the pressure's rate, and the force."""
        target, x, v = self.line(signals)
        pressure, signals = f"{self.name}.pressure", signals.extended({"x": x, "v": v})
        r = self.recording("input", signals)
        p, area = r.named(pressure), r.number(positive(self.area, "area", "Give it in m²."))
        temperature = r.number(positive(self.temperature, "temperature", "Give it in K."))
        gas = r.number(positive(self.gas_constant, "gas_constant", "Give it in J/(kg K)."))
        dead = r.number(positive(self.dead, "dead", "Give a volume in m³."))
        root = sqrt(dead + area * (r.named("x") - r.number(number(self.retracted, "retracted"))))
        net = gas * temperature * self.recorded_input(r) - p * area * r.named("v")
        exponent = r.number(positive(self.exponent, "exponent", "Give 1 of an isothermal chamber."))
        yield from rate_loads([pressure], [exponent * net / root / root], r, signals)
        r = Recording("area", {}, {})
        ambient, area = r.number(number(self.ambient, "ambient")), r.number(self.area)
        yield load_primitive(target, [(r.named(pressure) - ambient) * area], r, signals.of(r), "N")


def activation_rate(u: Any, a: Any, rise: Any, fall: Any, width: Any = None) -> Any:
    """ȧ = (u - a)/τ for an excitation u, with τ as in `MuscleActivation`; the switch is smooth over a width."""
    factor = 0.5 + 1.5 * _clamped(a)
    apart, rise, fall = _clamped(u) - a, rise * factor, fall / factor
    if width is None:
        rises = step(apart)
        return apart * (rises / rise + (1 - rises) / fall)
    s = _clamped(apart / width + 0.5)
    return apart / (fall + (rise - fall) * (s * s * s * (s * (6 * s - 15) + 10)))


def _clamped(x: Any) -> Any:
    return maximum(minimum(x, 1), 0)


@dataclass(frozen=True, eq=False, kw_only=True)
class MuscleActivation(WithInput, WithNominal, Force):
    """The activation a of a `Muscle`, which follows its excitation, the input u: ȧ = (u - a)/τ. Its output is its name.

    τ is activation_time · (0.5 + 1.5 a) where u > a, and deactivation_time/(0.5 + 1.5 a) where u < a, as in MuJoCo. An
    input below 0 acts like 0, one above 1 like 1. Without smoothing, derivatives of an equilibrium, where u = a, are
    those of u < a; those of a run that stays there to rounding lie between those of both sides.

    Parameters
    ----------
    activation_time, deactivation_time
        Time constants [s].
    smoothing
        Range of u - a over which one time constant becomes the other by a polynomial of fifth degree; 0 switches.
    initial
        Its value at the start of a run, from 0 to 1.
    """

    activation_time: Annotated[float, In("s")] = 0.01
    deactivation_time: Annotated[float, In("s")] = 0.04
    smoothing: Annotated[float, In("1")] = 0.0
    initial: Annotated[float, In("1")] = 0.0

    @property
    def absent_numbers(self) -> Collection[tuple[str, ...]]:
        """The smoothing where it is zero, because τ then switches."""
        return () if self.smoothing else [("smoothing",)]

    def states(self) -> Iterator[StateValue]:
        initial = fraction(self.initial, "initial", "Give the activation at the start.")
        yield StateValue(self.name, initial, "1", self.state_size())

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of its rate."""
        r = self.recording("input", signals)
        rise, fall = (
            r.number(positive(getattr(self, field), field, "Give a time constant in s."))
            for field in ("activation_time", "deactivation_time")
        )
        width = not_negative(self.smoothing, "smoothing", "Give a range of activations, or 0.")
        smooth = r.number(width) if value_of(width) else None
        rate = activation_rate(self.recorded_input(r), r.named(self.name), rise, fall, smooth)
        yield from rate_loads([self.name], [rate], r, signals, "1/s")
