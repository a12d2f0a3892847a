"""Motions of drivers that depend on first-order states, θ = f(x, t): a filtered command that a joint follows.

The constraint is that of the driver's own element, with the value of the law in place of f(t). See decision 046.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple, TypeVar

from ... import elements
from ..._jit.formulas.expression import Expression as Recorded
from ...algebra import Array
from ...elements.element import Time
from ..errors import ModelError
from ..expression.units import is_coherent
from ..forces.by_formula import check_law_unit, known_powers
from ..forces.formula_element import OutputLaws, Target, load_primitive
from ..laws.curve import Curve, Formula
from ..laws.jumps import TIME, jumps
from ..laws.law import Law
from ..laws.recorded import Recording, has_all_outputs, written_formula
from ..measure import measures_of
from ..primitive import Primitive
from ..show import quote
from ..signals import Measure, Signals

Part = TypeVar("Part")
WHY = "A driver follows states and t"


class DrivenByStates(OutputLaws, elements.Primitive, abstract=True):
    """Φ of a driver's element, with the value of a law of states and t as its motion."""

    own_fields: ClassVar[dict[str, str]] = {"t": "Time"}
    t: Time

    def Phi(self, x: Any) -> Array:
        last = len(self.structure.parts) - 1
        found: Array = self._measures()[-1](self.values(x, x, self.t)[0]).Phi(self._local(last, x))
        return found


class DrivenElement(NamedTuple):
    """A driver's element without its motion: what is driven."""

    element: type[elements.Element]
    base: type[OutputLaws] = DrivenByStates

    @property
    def fields(self) -> dict[str, str]:
        """Its fields but for the motion and the time."""
        return {name: kind for name, kind in self.element.fields.items() if kind not in ("Curve", "Time")}

    @property
    def rows(self) -> int:
        """Number of equations."""
        return self.element.rows

    def __call__(self, *values: Any) -> Callable[[Any], Any]:
        """Return the element as a function of the value of its motion."""
        given = dict(zip(self.fields, values, strict=True))
        kinds = {kind: name for name, kind in self.element.fields.items()}
        return lambda value: self.element(**given, **{kinds["Curve"]: lambda t: value, kinds["Time"]: 0})


@dataclass(frozen=True)
class StateMotion(Curve):
    """Place of a motion that depends on states: a law, the field of the driver that has it, and its unit."""

    law: Law | None = None
    field: str = ""
    unit: str = ""

    def recorded(self, variables: Mapping[str, Any]) -> tuple[Recording, Recorded]:
        """Return the law with the states that it uses."""
        recording = Recording(self.field, {}, {}, variables=variables)
        return recording, recording.law(self.law)


def with_state_motions(driver: Part, names: Collection[str]) -> Part:
    """Return a driver whose motions that use some states are `StateMotion`s."""
    found: dict[str, Any] = {}
    for field, measure in measures_of(driver).items() if names else ():
        law = getattr(driver, field, None)
        if measure.states and _uses(law, names):
            found[field] = StateMotion((0.0, 1.0), ((0.0,) * 4,), law=law, field=field, unit=measure.unit)
    whole: Any = driver
    return replace(whole, **found) if found else whole  # type: ignore[no-any-return]


def _uses(law: Any, names: Collection[str]) -> bool:
    """Return whether a motion is a formula with one of some names, or a function that has all outputs."""
    tree = written_formula(law)
    if tree is not None:
        return not set(names).isdisjoint(tree.names())
    return not isinstance(law, Curve | Formula) and callable(law) and has_all_outputs(law, {TIME})


def motions_of(primitive: Primitive) -> Iterator[StateMotion]:
    """Yield the motion of a primitive that depends on states, if it has one."""
    yield from (value for value in primitive.values if isinstance(value, StateMotion))


def followed_states(motion: StateMotion, states: Collection[str], variables: Mapping[str, Any]) -> list[str]:
    """Return the states that a motion uses.

    Raises
    ------
    ModelError
        If it uses other outputs.
    """
    recording, _ = motion.recorded(variables)
    other = next((name for name in recording.signals if name not in states), None)
    if other is not None:
        remedy = "For coordinates of joints use sr.FormulaCoupler, for other outputs sr.Torque or sr.Force."
        message = f"{motion.field} uses {quote(other)}, which is no state. {WHY} only. {remedy}"
        raise ModelError(message, field=motion.field)
    return recording.signals


def driven_by_states(primitive: Primitive, signals: Signals, units: Mapping[str, str]) -> Primitive:
    """Return a driver's primitive with the constraint that its motion by states gives; others as they are.

    Parameters
    ----------
    primitive, signals
        The primitive, and the signals of the model.
    units
        Declared units of outputs that are formulas of states.

    Raises
    ------
    ModelError
        If the motion jumps, is in another unit, or uses an output in a unit other than those of the SI.
    """
    motion = next(motions_of(primitive), None)
    if motion is None:
        return primitive
    recording, law = motion.recorded(signals.variables)
    if jumps(law):
        message = f"{motion.field} jumps, but the position of a driver cannot"
        raise ModelError(f"{message}. Use step(t, t0, 0, t1, 1), or put a lag between.", field=motion.field)
    own = signals.of(recording)
    declared = {name: one.unit for name, one in zip(recording.signals, own, strict=True)}
    _refuse_scaled(motion, declared | {name: units.get(name, "") for name in recording.recorded})
    powers = {name: known_powers(unit) for name, unit in declared.items()}
    if not recording.recorded and None not in powers.values():
        check_law_unit(motion.law, motion.field, motion.unit, powers)
    kind = DrivenElement(primitive.element)
    values = tuple(value for value in primitive.values if value is not motion)
    target = Target(Measure(kind, primitive.bodies, values), kind)
    return load_primitive(target, [law], recording, own)._replace(label=primitive.label)


def _refuse_scaled(motion: StateMotion, units: Mapping[str, str]) -> None:
    """Refuse a motion that uses an output in a unit such as deg, whose values would be taken for those in rad."""
    tree = written_formula(motion.law)
    for name, unit in units.items():
        if not is_coherent(unit) and (tree is None or name in tree.names()):
            message = f"{motion.field} uses {name} in {unit}, but motions are computed in SI units"
            remedy = f"Give {name} in {motion.unit}, or omit its unit and convert it in {motion.field}."
            raise ModelError(f"{message}. {remedy}", field=motion.field)
