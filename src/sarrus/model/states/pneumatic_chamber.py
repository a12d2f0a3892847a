"""Pneumatic chamber: the pressure of an ideal gas behind a piston."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ...functions import sqrt
from ..forces.force import Force
from ..forces.formula_element import load_primitive
from ..forces.two_points import OnLine
from ..laws.law import Law
from ..laws.recorded import Recording
from ..measure import In, Length
from ..primitive import Primitive
from ..quantity import number, positive
from ..signals import Signals
from .block import StateValue
from .rate_load import rate_loads
from .with_input import WithInput

AMBIENT = 101325.0  # [N/m²] standard atmosphere
AIR = 287.05  # [J/(kg K)] gas constant of dry air


@dataclass(frozen=True, eq=False, kw_only=True)
class PneumaticChamber(OnLine, WithInput, Force):
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
        """Yield the pressure."""
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
