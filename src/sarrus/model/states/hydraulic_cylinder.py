"""Hydraulic cylinder with a directional valve: the pressures of two chambers, after Merritt (1967)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from ..._jit.formulas.expression import Expression as Recorded
from ...functions import sqrt
from ..forces.force import Force
from ..forces.formula_element import load_primitive
from ..forces.two_points import OnLine
from ..laws.recorded import Recording
from ..measure import In, Length
from ..primitive import Primitive
from ..quantity import not_negative, number, positive
from ..signals import Signals
from ..tape import value_of
from .block import StateValue
from .rate_load import rate_loads
from .with_input import WithInput


@dataclass(frozen=True, eq=False, kw_only=True)
class HydraulicCylinder(OnLine, WithInput, Force):
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
        """Yield the pressures."""
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
