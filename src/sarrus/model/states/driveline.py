"""Drivelines: shafts, engines, electric motors, transmissions, torque converters, differentials and brakes.

Each part names the shafts that it connects: a joint by its name, whose angle it then loads, a tyre whose spin is a
state, which it loads too, or another part with a rate, a `Shaft` or a `Differential`, whose formula takes its torque.
Shafts are states, not bodies: a crankshaft at 6000 rev/min does not shorten the steps.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, TypeAlias

from ..._jit.formulas.expression import Expression as Recorded
from ...algebra import Row
from ...functions import absolute, sqrt, tanh
from ..announcement import announce
from ..checks.findings import part_name
from ..coordinate import ANGLE
from ..errors import ModelError, restated
from ..forces.by_formula import WithParameters
from ..forces.force import Force
from ..forces.formula_element import Target, load_primitive
from ..forces.springs import along_joint
from ..laws.law import Law, scaled, varies
from ..laws.recorded import Recording
from ..measure import In, Ratio, measures_of
from ..primitive import Primitive
from ..quantity import not_negative, number, positive
from ..show import quote, show
from ..signals import Signals
from .block import StateValue, WithNominal, rate_loads
from .rotor import OnRotor

VALUE, RATE, OUTPUT, LEFT, RIGHT, TORQUE = "value", "rate", "output", "left", "right", "torque"
UNITS = {RATE: "rad/s"} | dict.fromkeys((VALUE, OUTPUT, LEFT, RIGHT, TORQUE), "N m")
SHARPNESS = 8  # exponent that rounds the corner between the torque and the power of a motor


Limits: TypeAlias = Mapping[str, tuple[float, float]]


class Shown(NamedTuple):
    """No load: laws that are outputs, of a word and a unit."""

    outputs: tuple[tuple[str, str], ...]

    def __call__(self, of: Any, values: Any, x: Any, v: Any, t: Any) -> Row:
        """Q = 0."""
        return (None,) * len(x)


@dataclass(frozen=True, eq=False)
class Driveline(WithParameters):
    """Torques between shafts; ``name.value`` is the one that the part transmits [N m]."""

    shafts: ClassVar[tuple[str, ...]] = ("joint",)  # fields with the names of joints, or of parts with a rate
    shown: ClassVar[tuple[str, ...]] = (VALUE,)  # outputs of the torques: transmitted, and on each shaft
    limits: ClassVar[Limits] = {}  # of fields that are plain numbers
    not_zero: ClassVar[tuple[str, ...]] = ()  # such fields that must not be 0
    reacts: ClassVar[bool] = False  # on the carrier of a tyre's wheel, as what is mounted there
    if TYPE_CHECKING:
        name: str

    def torques(self, r: Recording) -> tuple[Recorded, ...]:
        """Return the torque that the part transmits, and that on each shaft."""
        raise NotImplementedError

    def recorded(self, r: Recording) -> list[Recorded]:
        """The torques on a recording, where they are recorded once."""
        names = [f"{self.name}/{n}" for n in range(len(self.shafts) + 1)]
        if names[0] not in r.recorded:
            with restated(part=part_name(("forces", self.name))):
                r.recorded.update(zip(names, self.torques(r), strict=True))
        return [r.recorded[name] for name in names]

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        self._check_numbers()
        self._check_shafts(signals)
        r = Recording("torque", {}, self.checked_parameters(), variables=signals.variables)
        torques = self.recorded(r)[1:]
        for field, measure in measures_of(self).items():
            if measure.outputs:
                self.check_units(getattr(self, field), field, measure.unit, r, signals)
        for field, torque in zip(self.shafts, torques, strict=True):
            shaft = getattr(self, field)
            if f"{shaft}.{RATE}" not in {*signals.states, *signals.variables}:
                yield load_primitive(self._target(shaft, signals), [torque], r, signals.of(r))
        shown = {name.rpartition(".")[2]: record(r) for name, record in self.variables()}
        act = Shown(tuple((word, UNITS[word]) for word in shown))
        found = signals.of(r)
        yield load_primitive(Target(found[0].measure, act), [*shown.values()], r, found)

    def _check_numbers(self) -> None:
        """Refuse plain numbers out of their limits, and a part between a shaft and itself."""
        names = [getattr(self, field) for field in self.shafts]
        if len(set(names)) < len(names):
            message = f"{' and '.join(self.shafts)} are both {quote(names[0])}"
            raise ModelError(f"{message}. Name two different shafts.", field=self.shafts[1])
        for field in (*self.limits, *self.not_zero):
            value, (low, high) = getattr(self, field), self.limits.get(field, (-inf, inf))
            if not isinstance(value, int | float):
                continue
            is_zero = field in self.not_zero and value == 0
            if is_zero or not low <= value <= high:
                rule = "be 0" if is_zero else f"be less than {low:g}" if value < low else f"exceed {high:g}"
                raise ModelError(f"{field} must not {rule}, but is {value:g}. Correct it.", field=field)

    def _check_shafts(self, signals: Signals) -> None:
        """Refuse what has no rate, and warn of a shaft whose formula has no torque of this part."""
        for field in self.shafts:
            shaft: Any = getattr(self, field)
            if signals.rolls(shaft) and not signals.rotor(shaft):
                message = f"{field} is the tyre {quote(shaft)}, whose spin is no state"
                remedy = "Give the tyre spin_inertia, or name the joint of the wheel."
                raise ModelError(f"{message}. {remedy}", field=field)
            if f"{shaft}.{RATE}" not in {*signals.states, *signals.variables}:
                self._refuse_other(field, shaft, signals)
                continue
            r = Recording(TORQUE, {}, {}, variables=signals.variables)
            with suppress(ModelError):  # which the shaft reports
                r.named(f"{shaft}.{TORQUE}")
                if f"{self.name}/0" not in r.recorded:
                    message = f"{self.name} does not act on {shaft}, whose torque has no output of it"
                    announce([f"{message}. Add one, such as {self.name}.{VALUE}, to {shaft}.{TORQUE}."])

    def _refuse_other(self, field: str, shaft: Any, signals: Signals) -> None:
        try:
            self._target(shaft, signals)
        except ModelError:
            message = f"{field} must name a joint that turns, a tyre with spin_inertia, or a part with a rate"
            raise ModelError(f"{message}, but is {show(shaft)}.", field=field) from None

    def _target(self, shaft: str, signals: Signals) -> Target:
        rotor = signals.rotor(shaft)
        return Target(rotor, OnRotor(self.reacts)) if rotor else along_joint(shaft, ANGLE, signals).target

    def variables(self) -> Iterator[tuple[str, Any]]:
        for n, word in enumerate(self.shown):
            if word:
                yield f"{self.name}.{word}", partial(self._torque, n)

    def _torque(self, n: int, r: Recording) -> Recorded:
        return self.recorded(r)[n]

    def rate(self, r: Recording, field: str) -> Recorded:
        """The rate of a shaft."""
        return r.named(f"{getattr(self, field)}.{RATE}")

    def law(self, r: Recording, field: str) -> Recorded:
        """A formula of outputs and the time."""
        return self.recorded_law(r, field, getattr(self, field))

    def curve(self, r: Recording, field: str, x: Recorded) -> Recorded:
        """A number, or a table or formula over x."""
        value = getattr(self, field)
        factor, curve = scaled(value, field)
        return r.looked_up(curve, x) if varies(value) else r.number(factor)

    def sign(self, r: Recording, rate: Recorded) -> Recorded:
        """The direction of friction, tanh(rate / creep)."""
        creep: Any = getattr(self, "creep")  # noqa: B009
        found: Recorded = tanh(rate / r.number(positive(creep, "creep", "Give a small speed in rad/s.")))
        return found


@dataclass(frozen=True, eq=False, kw_only=True)
class Shaft(WithParameters, WithNominal, Force):
    """A rotor on its own bearings: inertia · ω̇ = torque. Its speed is the state ``name.rate`` [rad/s].

    ``name.torque`` is the sum of the torques on it [N m].

    Parameters
    ----------
    inertia
        About its axis [kg m²].
    torque
        The sum of all torques on it [N m], a formula such as ``"engine.value - gearbox.value"``, or a function.
    initial
        Speed at the start of a run [rad/s].
    """

    inertia: Annotated[float, In("kg m^2")]
    torque: Annotated[Law, In("N m", outputs=True)]
    initial: Annotated[float, In("rad/s")] = 0.0

    def states(self) -> Iterator[StateValue]:
        yield StateValue(f"{self.name}.{RATE}", number(self.initial, "initial"), "rad/s", self.state_size())

    def variables(self) -> Iterator[tuple[str, Any]]:
        yield f"{self.name}.{TORQUE}", lambda r: self.recorded_law(r, TORQUE, self.torque)

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        r = Recording(TORQUE, {}, self.checked_parameters(), variables=signals.variables)
        inertia = r.number(positive(self.inertia, "inertia", "Give it in kg m²."))
        torque = r.law(self.torque)
        self.check_units(self.torque, TORQUE, "N m", r, signals)
        outputs = {TORQUE: (torque, UNITS[TORQUE])}
        yield from rate_loads([f"{self.name}.{RATE}"], [torque / inertia], r, signals, outputs=outputs)


@dataclass(frozen=True, eq=False)
class Engine(Driveline, Force):
    """A combustion engine by its map: u · full_load(ω) + (1 − u) · motoring(ω), the torque on its crankshaft.

    Parameters
    ----------
    joint
        The crankshaft, a `Shaft` or a joint by name; ω is its rate.
    throttle
        u from 0 to 1: a number, a formula of outputs such as ``"cruise.output"``, or a function.
    full_load
        Torque with open throttle [N m]: a number, or a table or formula over ω [rad/s].
    motoring
        Torque with closed throttle [N m], which brakes where it is negative; likewise.
    """

    joint: str
    throttle: Annotated[Law, In("1", outputs=True)]
    full_load: Annotated[Law, In("N m", over="rad/s")]
    motoring: Annotated[Law, In("N m", over="rad/s")] = 0.0
    limits: ClassVar[Limits] = {"throttle": (0.0, 1.0)}

    def torques(self, r: Recording) -> tuple[Recorded, ...]:
        speed, throttle = self.rate(r, "joint"), self.law(r, "throttle")
        full_load, motoring = (self.curve(r, field, speed) for field in ("full_load", "motoring"))
        torque = throttle * full_load + (1 - throttle) * motoring
        return torque, torque


@dataclass(frozen=True, eq=False)
class ElectricMotor(Driveline, Force):
    """A motor within limits of torque and power: command · torque / (1 + (torque · |ω| / power)⁸)^(1/8).

    The eighth power rounds the corner between both limits, where the torque is 8 % smaller than either.

    Parameters
    ----------
    joint
        By name; ω is its rate.
    command
        From −1 to 1: a number, a formula of outputs, or a function.
    torque
        Largest torque [N m].
    power
        Largest mechanical power [W].
    """

    joint: str
    command: Annotated[Law, In("1", outputs=True)]
    torque: Annotated[float, In("N m")]
    power: Annotated[float, In("kg m^2/s^3")]
    reacts = True
    limits: ClassVar[Limits] = {"command": (-1.0, 1.0)}

    def torques(self, r: Recording) -> tuple[Recorded, ...]:
        most = r.number(positive(self.torque, "torque", "Give it in N m."))
        power = r.number(positive(self.power, "power", "Give it in W."))
        share = (most * self.rate(r, "joint") / power) ** SHARPNESS
        torque = self.law(r, "command") * most / (1 + share) ** (1 / SHARPNESS)
        return torque, torque


@dataclass(frozen=True, eq=False)
class Transmission(Driveline, Force):
    """A friction clutch with the gears behind it, between two shafts.

    With the slip Δω = ω_input − ratio · ω_output, the clutch transmits T = engagement · capacity · tanh(Δω / creep):
    −T on the input, ratio · T on the output, ``name.output``. A closed clutch slips by less than ``creep`` below three
    quarters of its capacity. Change gears by a formula of time or outputs for ``ratio``, while ``engagement`` is small.

    Parameters
    ----------
    input, output
        The shafts: joints, or parts with a rate, by name.
    ratio
        Revolutions of the input for one of the output; a negative one reverses. A number, a formula, or a function.
    capacity
        Largest torque of the clutch at its input [N m].
    engagement
        From 0, open, to 1, closed: a number, a formula of outputs, or a function.
    creep
        Slip within which the torque changes its sign [rad/s].
    """

    input: str
    output: str
    ratio: Annotated[Law, In("1", outputs=True)]
    capacity: Annotated[float, In("N m")]
    engagement: Annotated[Law, In("1", outputs=True)] = 1.0
    creep: Annotated[float, In("rad/s")] = 1.0
    shafts = ("input", "output")
    shown = (VALUE, "", OUTPUT)
    limits: ClassVar[Limits] = {"engagement": (0.0, 1.0)}
    not_zero = ("ratio",)

    def torques(self, r: Recording) -> tuple[Recorded, ...]:
        capacity = r.number(positive(self.capacity, "capacity", "Give the largest torque in N m."))
        ratio = self.law(r, "ratio")
        slip = self.rate(r, "input") - ratio * self.rate(r, "output")
        torque = self.law(r, "engagement") * capacity * self.sign(r, slip)
        return torque, -torque, ratio * torque


@dataclass(frozen=True, eq=False)
class TorqueConverter(Driveline, Force):
    """A hydrodynamic torque converter: T_p = capacity(s) · ω_p² on the pump, torque_ratio(s) · T_p on the turbine.

    s = ω_t / √(ω_p² + idle²) is the ratio of the speeds of the turbine and of the pump. ``name.value`` is T_p and
    ``name.output`` the torque on the turbine.

    Parameters
    ----------
    pump, turbine
        The shafts: joints, or parts with a rate, by name.
    capacity
        T_p / ω_p² [N m s²/rad²], 1/K² of the capacity factor K: a number, or a table or formula over s.
    torque_ratio
        Likewise, above 1 where the stator multiplies the torque.
    idle
        Speed of the pump [rad/s], small beside that of idling, that keeps s finite at standstill.
    """

    pump: str
    turbine: str
    capacity: Annotated[Law, In("N m s^2/rad^2", over="rad/rad")]
    torque_ratio: Annotated[Law, In("1", over="rad/rad")]
    idle: Annotated[float, In("rad/s")] = 10.0
    shafts = ("pump", "turbine")
    shown = (VALUE, "", OUTPUT)
    limits: ClassVar[Limits] = {"capacity": (0.0, inf)}

    def torques(self, r: Recording) -> tuple[Recorded, ...]:
        pump = self.rate(r, "pump")
        idle = r.number(positive(self.idle, "idle", "Give a small speed in rad/s."))
        ratio = self.rate(r, "turbine") / sqrt(pump * pump + idle * idle)
        torque = self.curve(r, "capacity", ratio) * pump * pump
        return torque, -torque, self.curve(r, "torque_ratio", ratio) * torque


@dataclass(frozen=True, eq=False)
class Differential(Driveline, Force):
    """A differential, open or with limited slip: it divides a torque between two shafts.

    Its rate, ``name.rate``, is ratio · (ω_left + ω_right) / 2; the shafts get ratio · torque / 2 each, and the friction
    T = (preload + ramp · ratio · |torque|) · tanh((ω_left − ω_right) / creep) from the faster to the slower one,
    ``name.value``. The torques on the shafts are ``name.left`` and ``name.right``, and ``name.torque`` is that at its
    input. A Torsen differential with the torque bias ratio b, the largest ratio of its two torques, has
    ramp = (b − 1) / (b + 1) / 2.

    Parameters
    ----------
    left, right
        The shafts: joints, or parts with a rate, by name.
    ratio
        Revolutions of its input for one of its case.
    torque
        At its input [N m]: a number, a formula of outputs such as ``"gearbox.output"``, or a function.
    preload
        Friction without a torque [N m].
    ramp
        Friction as a share of the torque on the case.
    creep
        Difference of rates within which the friction changes its sign [rad/s].
    """

    left: str
    right: str
    ratio: Ratio
    torque: Annotated[Law, In("N m", outputs=True)]
    preload: Annotated[float, In("N m")] = 0.0
    ramp: Ratio = 0.0
    creep: Annotated[float, In("rad/s")] = 1.0
    shafts = ("left", "right")
    shown = (VALUE, LEFT, RIGHT)
    not_zero = ("ratio",)

    def torques(self, r: Recording) -> tuple[Recorded, ...]:
        case = self._ratio(r) * self.law(r, "torque")
        preload = r.number(not_negative(self.preload, "preload", "Give it in N m."))
        ramp = r.number(not_negative(self.ramp, "ramp", "Give a share of the torque."))
        apart = self.rate(r, "left") - self.rate(r, "right")
        friction = (preload + ramp * absolute(case)) * self.sign(r, apart)
        return friction, case / 2 - friction, case / 2 + friction

    def variables(self) -> Iterator[tuple[str, Any]]:
        yield from super().variables()
        yield f"{self.name}.{RATE}", self._rate
        yield f"{self.name}.{TORQUE}", lambda r: self.law(r, TORQUE)

    def _rate(self, r: Recording) -> Recorded:
        found: Recorded = self._ratio(r) * (self.rate(r, "left") + self.rate(r, "right")) / 2
        return found

    def _ratio(self, r: Recording) -> Recorded:
        return r.number(number(self.ratio, "ratio"))


@dataclass(frozen=True, eq=False)
class Brake(Driveline, Force):
    """A friction brake: torque · tanh(ω / creep) against the rotation. What it holds creeps; `LuGre` sticks.

    Parameters
    ----------
    joint
        By name; ω is its rate.
    torque
        [N m], not negative: a number, a formula such as ``"4000*pedal"``, or a function.
    creep
        Rate within which the torque changes its sign [rad/s].
    """

    joint: str
    torque: Annotated[Law, In("N m", outputs=True)]
    creep: Annotated[float, In("rad/s")] = 0.1
    limits: ClassVar[Limits] = {"torque": (0.0, inf)}
    reacts = True

    def torques(self, r: Recording) -> tuple[Recorded, ...]:
        torque = self.law(r, "torque") * self.sign(r, self.rate(r, "joint"))
        return torque, -torque
