"""Inputs by name: exogenous variables of forces, states and drivers, such as a voltage or the opening of a valve."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, TypeVar

from ..._jit.formulas.expression import Expression as Recorded
from ..errors import ModelError
from ..expression import Expression, Number
from ..expression.units import fits, in_ascii, powers_of
from ..forces.by_formula import RESERVED, WithParameters, check_law_unit, known_powers
from ..forces.force import Force
from ..forces.formula_element import FormulaLoad, Target, load_primitive
from ..geometry.points import GROUND
from ..geometry.pose import Poses
from ..laws.jumps import TIME
from ..laws.law import Law, scaled, varies
from ..laws.recorded import Recording, written_formula
from ..measure import In, measures_of
from ..model import Model
from ..primitive import Primitive
from ..quantity import InputNumber
from ..show import quote, suggest
from ..signals import Measure, Signals


def refuse_unknown_input(owner: str, name: Any, known: Collection[str]) -> None:
    """Refuse a name that is none of the inputs of a model.

    Raises
    ------
    ModelError
    """
    if name not in known:
        near = suggest(str(name), known) if known else 'Add sr.Input("u", 0.0) to its forces.'
        raise ModelError(f"{owner} has no input {quote(str(name))}. {near}")


def refuse_repeated_inputs(owner: str, names: Sequence[str]) -> None:
    """Refuse a list that names an input more than once.

    Raises
    ------
    ModelError
    """
    for name in names:
        if names.count(name) > 1:
            raise ModelError(f"{owner}: inputs contains {quote(name)} more than once. Name each input once.")


def with_input_values(model: Model, values: Mapping[str, Any]) -> Model:
    """Return the model with other values of inputs by name; they no longer follow from parameters of its file.

    Raises
    ------
    ModelError
        If it has no input of a name.
    """
    own = {force.name for force in model.forces if isinstance(force, Input)}
    for name in values:
        refuse_unknown_input(model.name, name, own)
    forces = [
        replace(force, value=values[force.name])
        if isinstance(force, Input) and force.name in values
        else force
        for force in model.forces
    ]
    gone = {("forces", name, "value") for name in values}
    expressions = {path: x for path, x in model.formulas.expressions.items() if path[:3] not in gone}
    return replace(model, forces=forces, formulas=replace(model.formulas, expressions=expressions))


UNSET = float("nan")
OWN = (*RESERVED, "rate", "length", "angle", "displacement")  # names that forces have in their formulas
Part = TypeVar("Part")


class InputLaw(FormulaLoad, abstract=True):
    """The law of an input, which acts on nothing: it has no operators, and is compiled for none."""

    family = ()

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.outputs = {}


@dataclass(frozen=True)
class Anywhere:
    """A body, which an input does not act on."""

    fields: ClassVar[dict[str, str]] = {}
    bodies: ClassVar[int] = 1
    load: ClassVar[type[FormulaLoad]] = InputLaw


def nothing(of: Any, values: Any, x: Any, v: Any, t: Any) -> tuple[None, None]:
    return None, None


@dataclass(frozen=True, eq=False)
class Input(WithParameters, Force):
    """A variable by name that is prescribed from outside: a voltage, the opening of a valve, a torque.

    Formulas of forces, torques and states use its name like an output, and ``run["u"]`` is its value along a run. The
    fields of other parts that are laws over time, such as the motion of a driver or the force of a `TSDA`, may be the
    name alone: ``AngleDriver("turn", "pin", "u")``.

    Parameters
    ----------
    value
        A number; a formula in a text, of ``t`` and ``parameters``; a table of pairs [t, value], interpolated by a cubic
        spline, with respect to whose values derivatives are taken; a `Curve`; or a function of t. None for an input
        that is set later, in ``simulate(..., inputs={"u": ...})`` or by a `Stepper`.
    unit
        Of the value, for plots and tables; formulas of other units are refused.
    parameters
        Numbers by name for the formula.
    """

    value: Annotated[Law | None, In("", outputs=True)] = None
    unit: str = ""

    @property
    def law_measures(self) -> dict[str, In]:
        """The physical quantity of the value."""
        return {"value": In(self.unit, outputs=True)}

    @property
    def constant(self) -> Any:
        """Its number, marked with its name: NaN where it is not set; None if it varies in time."""
        if self.value is not None and varies(self.value):
            return None
        number = UNSET if self.value is None else scaled(self.value, "value", TIME).factor
        return InputNumber.of(self.name, number)

    def recorded(self, recording: Recording) -> Recorded:
        number = self.constant
        if number is not None:
            return recording.number(number, f"{self.name}.value")
        return self.recorded_law(recording, "value", self.value, TIME)

    def over_time(self) -> Any:
        """Its value as a law over time, with its parameters as numbers."""
        if self.constant is not None:
            return self.constant
        tree = written_formula(self.value) or self.value
        known = self.checked_parameters()
        if not isinstance(tree, Expression) or not known:
            return tree
        return tree.replaced({name: Number(known[name]) for name in tree.names() if name in known})

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield nothing; refuse a name that formulas use for something else."""
        if self.name in OWN:
            raise ModelError(f"formulas use {quote(self.name)} for something else. Rename the input.")
        yield from ()

    def variables(self) -> Iterator[tuple[str, Any]]:
        yield self.name, self.recorded

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield its law, for outputs."""
        r = Recording("value", {}, self.checked_parameters(), variables=signals.variables)
        law = self.recorded(r)
        if r.signals:
            message = f"value depends on {quote(r.signals[0])}, but an input depends on the time alone"
            raise ModelError(f"{message}. Use a controller, such as sr.PID, or a formula.", field="value")
        if known_powers(self.unit) is not None:
            check_law_unit(self.value, "value", self.unit, dict.fromkeys(self.parameters))
        body = next(name for name in signals.poses if name != GROUND)
        yield load_primitive(Target(Measure(Anywhere, (body,), ()), nothing), [law], r, signals.of(r))


def _followed(part: Any, inputs: Mapping[str, Input]) -> Iterator[tuple[str, Input]]:
    """Yield the fields of a part that are laws over time and name an input."""
    for field, measure in measures_of(part).items() if inputs else ():
        if measure.over != "s" or measure.outputs:
            continue
        tree = written_formula(getattr(part, field, None))
        names = [name for name in tree.names() if name in inputs] if tree is not None else []
        if names and str(tree) != names[0]:
            message = f"{field} uses the input {names[0]} in a formula, {quote(str(tree))}"
            raise ModelError(f"{message}. Give its name alone, and the formula to the input.", field=field)
        if names:
            yield field, inputs[names[0]]


def with_inputs(part: Part, inputs: Mapping[str, Input]) -> Part:
    """Return a part whose laws over time that are names of inputs have the values of these.

    Raises
    ------
    ModelError
        If the unit of the input is another one.
    """
    changed: dict[str, Any] = {}
    for field, source in _followed(part, inputs):
        measure = measures_of(part)[field]
        if source.unit and measure.unit and not fits(powers_of(in_ascii(source.unit)), measure.unit):
            message = f"{field} is in {measure.unit}, but the input {source.name} in {source.unit}"
            raise ModelError(f"{message}. Change the unit of the input.", field=field)
        changed[field] = source.over_time()
    whole: Any = part
    return replace(whole, **changed) if changed else whole  # type: ignore[no-any-return]


def refuse_lost(part: Part, primitives: Iterable[Primitive], inputs: Mapping[str, Input]) -> None:
    """Refuse a part that follows an input with a number in another way than by a number of its element.

    Raises
    ------
    ModelError
    """
    found = {value.name for one in primitives for value in one.values if isinstance(value, InputNumber)}
    for field, source in _followed(part, inputs):
        if isinstance(source.constant, InputNumber) and source.name not in found:
            message = f"{field} cannot follow the input {source.name}, which is a number"
            raise ModelError(f"{message}. Give the input a table or a formula of t.", field=field)
