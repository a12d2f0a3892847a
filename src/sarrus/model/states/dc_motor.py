"""Direct-current motor with a gearbox on the angle of a joint."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ..coordinate import ANGLE
from ..errors import ModelError
from ..forces.by_formula import WithParameters
from ..forces.force import Force
from ..forces.formula_element import load_primitive
from ..forces.two_points import along_joint
from ..laws.law import Law
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import not_negative, number, positive
from ..signals import Signals
from .block import StateValue
from .rate_load import rate_loads
from .with_nominal import WithNominal


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
        """Yield the current."""
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
