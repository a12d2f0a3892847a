"""Values of forces that are formulas or functions of outputs and the time, and the force between two points by one."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import Parameter
from typing import Annotated, Any, ClassVar, cast

from ..._jit.formulas.expression import Expression as Recorded
from ..checks.names import matches
from ..coordinate import WORDS
from ..errors import ModelError, restated
from ..expression import Expression
from ..expression.units import fits, in_ascii, powers_of, unit_of
from ..laws.curve import Curve, Formula, Tree
from ..laws.jumps import TIME
from ..laws.law import Law
from ..laws.recorded import Recording, arguments, has_all_outputs, parsed
from ..laws.text_units import check_unit, has_parameters
from ..measure import In
from ..primitive import Primitive
from ..quantity import is_list, number
from ..show import quote, show
from ..signals import Measure, Signal, Signals
from .force import Force as BaseForce
from .formula_element import Target, along_coordinate, constraint_primitive, load_primitive
from .springs import LineForce, along_joint

WORD = r"[^\W\d]\w*"
RESERVED = ("x", "v", TIME, "pi")  # in formulas
BASE_SYMBOLS = {"kg", "m", "s", "rad", "A", "K"}


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class WithParameters:
    """Numbers by name, which formulas may use, and with respect to which derivatives can be taken.

    Parameters
    ----------
    parameters
        Numbers by name that the formulas may use, such as ``{"k": 2.0}``; derivatives are taken by them, too.
    """

    parameters: Annotated[Mapping[str, float], In("")] = field(default_factory=dict)

    def checked_parameters(self) -> Mapping[str, Any]:
        """Return the parameters: numbers, whose names have no meaning of their own."""
        given: Any = self.parameters
        if not isinstance(given, Mapping):
            message = f"parameters must be a mapping, but is {show(given)}. Give one such as {{'k': 2.0}}."
            raise ModelError(message, field="parameters")
        for name, value in given.items():
            if not matches(WORD, name) or name in RESERVED:
                message = f"parameters has the name {show(name)}, which formulas cannot use. Rename it."
                raise ModelError(message, field="parameters")
            number(value, f"parameters.{name}")
        return given

    def recorded_law(self, recording: Recording, field: str, law: Any, over: str | None = None) -> Recorded:
        """Return a law of this part on the recording of another one."""
        outer = recording.parameters, recording.field
        owner = (
            f"{getattr(self, 'name', '')}." if recording.within else ""
        )  # for the recording of another part
        recording.parameters, recording.field = self.checked_parameters(), f"{owner}{field}"
        value = recording.law(law, over)
        recording.parameters, recording.field = outer
        return value

    def depends_on_outputs(self, load: Any, factor: Any) -> bool:
        """Return whether components of a load, or its factor, depend on more than the time."""
        laws = [*(load if has_three(load) else ()), factor]
        return any(has_outputs(law, self.parameters) for law in laws)

    def vector_load(
        self, target: Target, load: Any, factor: Any, field: str, unit: str, signals: Signals
    ) -> Primitive:
        """Return the load of three components, each scaled by a factor."""
        laws = list(load)
        recording = Recording("factor", {}, self.checked_parameters(), variables=signals.variables)
        scale = recording.law(factor, TIME)
        recording.field = field
        results = [recording.law(law, TIME) * scale for law in laws]
        found = signals.of(recording)
        units = self._units(recording, found)
        check_law_unit(factor, "factor", "1", units)
        for law in laws:
            check_law_unit(law, field, unit, units)
        return load_primitive(target, results, recording, found)

    def check_units(self, law: Any, field: str, unit: str, recording: Recording, signals: Signals) -> None:
        """Refuse a recorded law in another unit; none accepts every unit."""
        known = self._units(recording, signals.of(recording))
        if unit and known_powers(unit) is not None and None not in known.values():
            check_law_unit(law, field, unit, known)

    def _units(self, recording: Recording, found: Sequence[Signal]) -> dict[str, Any]:
        """The units of names; those of parameters are not known."""
        pairs = zip(recording.signals, found, strict=True)
        return {name: known_powers(one.unit) for name, one in pairs} | dict.fromkeys(self.parameters)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ByFormula(WithParameters):
    """A value that is a formula of outputs.

    Parameters
    ----------
    value
        A number; a text such as ``"(T0 - k*pin.rate)*step(t, 0, 0, 1, 1)"`` of outputs, ``t``, ``parameters``, and
        ``x`` and ``v``, the coordinate that the force acts along and its rate; a Python function, of arguments with
        these names, ``lambda x, v, t: ...``, or of one that has all outputs, ``lambda o: -o["pin.rate"]``; or a table
        over what ``over`` names.
    over
        For a table: an output, or a formula.
    """

    value: Annotated[Law | None, In("", outputs=True)] = None
    over: str = ""
    unit: ClassVar[str] = "N"  # of the value

    @property
    def law_measures(self) -> dict[str, In]:
        """The physical quantity of the value."""
        return {"value": In(self.unit, outputs=True)}

    def loaded(
        self,
        target: Target,
        own: Mapping[str, Signal],
        signals: Signals,
        factor: Any = None,
        unit: str | None = None,
    ) -> Primitive:
        """Return the load on a target, whose own coordinate and rate formulas may call x and v."""
        table, over = self.value, cast(Any, self.over)
        if not isinstance(over, str):
            message = f"over must be an output or a formula as a text, but is {show(over)}. Give one."
            raise ModelError(message, field="over")
        if over and not (is_list(table) or isinstance(table, Curve)):
            raise ModelError("over is for a table. Leave it out, or give a table.", field="over")
        recording = Recording(
            "value", with_full(own, self), self.checked_parameters(), variables=signals.variables
        )
        signals.refuse_hidden(recording)
        result = recording.law(self.value, self.over)
        if factor is not None:
            recording.field = "factor"
            result = result * recording.law(factor, TIME)
        fields = zip(recording.signals, recording.fields, strict=True)
        found = [own[name] if name in own else signals.find(name, field) for name, field in fields]
        units = self._units(recording, found)
        check_law_unit(factor, "factor", "1", units)
        unit = self.unit if unit is None else unit
        check_law_unit(self.value, "value", unit, units)
        return load_primitive(target, [result], recording, found, unit)

    def on_joint(self, joint: str, kind: Any, signals: Signals, factor: Any = None) -> Primitive:
        """Return the load along a joint's coordinate."""
        target, x, v = along_joint(joint, kind, signals)
        return self.loaded(target, own_names(x, v) | {WORDS[kind]: x}, signals, factor)


def known_powers(unit: str) -> dict[str, float] | None:
    """The powers of base units in a unit; None where it is not given, or of other symbols, such as V."""
    powers = powers_of(in_ascii(unit))
    return powers if unit and powers.keys() <= BASE_SYMBOLS else None


def own_names(coordinate: Signal, rate: Signal) -> dict[str, Signal]:
    """Return the names of a force's own coordinate and rate in formulas."""
    return {"x": coordinate, "v": rate, "rate": rate}


def with_full(own: Mapping[str, Signal], part: Any) -> dict[str, str]:
    """The names of own signals, also behind the name of the part, as in ``strut.length``."""
    return {name: name for name in own} | {f"{part.name}.{name}": name for name in own}


def has_outputs(law: Any, parameters: Collection[str] = ()) -> bool:
    """Return whether a law depends on more than the time, by its names or the arguments of a function."""
    if isinstance(law, str):
        law = parsed(law, "force")
    if isinstance(law, Expression):
        return bool(set(law.names()) - {TIME})
    function = law.function if isinstance(law, Formula) else law
    if isinstance(function, Curve | Tree) or not callable(function):
        return False
    known = {TIME, *parameters}
    wanted = arguments(function, known)
    named = len(wanted) > 1 or Parameter.KEYWORD_ONLY in wanted.values()
    return named or not wanted.keys().isdisjoint(parameters) or has_all_outputs(function, known)


def refuse_other_than_positions(recording: Recording, found: Sequence[Signal], reason: str) -> None:
    """Refuse rates and the time in a formula of positions."""
    wrong = [name for name, one in zip(recording.signals, found, strict=True) if one.arguments > 1]
    wrong += [TIME for node in recording.graph.nodes if node.value == (TIME,)]
    if wrong:
        field = recording.field
        raise ModelError(f"{field} uses {quote(wrong[0])}, but {reason}. Use positions.", field=field)
    if not found:
        raise ModelError(
            f"{recording.field} has no output. Name one, such as pin.angle.", field=recording.field
        )


def has_three(load: Any) -> bool:
    """Return whether a load is a list of three components."""
    return is_list(load) and len(load) == 3


def check_law_unit(value: Any, field: str, unit: str, units: Mapping[str, Any]) -> None:
    """Refuse a formula in another unit, be its numbers without units in those that fit, or outputs plain numbers.

    A sum of outputs in different units is refused even so.
    """
    tree = parsed(value, field) if isinstance(value, str) else value
    if not isinstance(tree, Expression) or has_parameters(tree):
        return
    names = tree.names()
    plain: dict[str, Any] = {name: None if units.get(name, {}) is None else {} for name in names}
    with restated(field, field=field):
        try:
            check_unit(tree, str(tree), unit, {TIME: {"s": 1}, **units})
        except ModelError:
            unit_of(tree, {TIME: {"s": 1}, **units}, loose=True)
            check_unit(tree, str(tree), unit, plain)


@dataclass(frozen=True, eq=False)
class Force(LineForce, ByFormula, BaseForce):
    """A force [N] between two points, or along the displacement of a joint or a formula, by a formula of outputs.

    A positive value pushes the points apart, or increases the displacement: it does work at the rate value · v. (The
    ``force`` of a TSDA is a tension, with the opposite sign.)

    Parameters
    ----------
    point_i, point_j
        The ends, which must not coincide; x is their distance [m], v its rate. Or instead of both the name of a joint,
        ``Force("jack", "slide", value=5)``.
    joint
        Instead of points, a joint by name, ``slide``, or if it has several displacements ``table.displacement_x``; x is
        the displacement of its second body [m].
    along
        Instead of points, a formula of positions, or a function, that is x: ``"tappet.x - A*cos(shaft.angle)"``. Each
        body has the force of the value times the gradient of x by its motion, here the tappet a force along x, and the
        shaft a torque. Of an x in m the value is a force [N], of an angle a torque [N m].
    value
        See above; for example ``"p*A*step(t, 0, 0, 1 ms, 1) - c*v"``, or ``lambda x, v, t: -100*x**3``.
    """

    along: Annotated[Law | None, In("", outputs=True)] = field(default=None, kw_only=True)

    @property
    def law_measures(self) -> dict[str, In]:
        """The physical quantities of the value, and of what it acts along."""
        return {"along": In("", outputs=True), "value": In("" if self.along else self.unit, outputs=True)}

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        if self.value is None:
            raise ModelError(
                "value is missing. Give a number, a formula, a function or a table.", field="value"
            )
        if self.along is not None:
            yield self._along_formula(signals)
            return
        target, x, v = self.line(signals)
        named = "length" if self.joint is None else "displacement"
        yield self.loaded(target, own_names(x, v) | {named: x}, signals)

    def _along_formula(self, signals: Signals) -> Primitive:
        """Return the load along the gradient of a formula of positions."""
        if (self.joint, self.point_i, self.point_j) != (None, None, None):
            raise ModelError("has along, and a joint or points. Give one of them.", field="along")
        recording = Recording("along", {}, self.checked_parameters(), variables=signals.variables)
        law = recording.law(self.along)
        found = signals.of(recording)
        refuse_other_than_positions(recording, found, "a force acts along a formula of positions only")
        unit = self._unit_along(self._units(recording, found))
        measure = Measure.of(constraint_primitive(law, recording, found))
        x, v = Signal(measure, "Phi", 1, 0, unit), Signal(measure, "Phi_q_xi", 2, 0, f"{unit}/s")
        target = Target(measure, along_coordinate)
        return self.loaded(target, own_names(x, v), signals, unit={"m": "N", "rad": "N m"}.get(unit, "J"))

    def _unit_along(self, units: Mapping[str, Any]) -> str:
        """The unit of the coordinate, m or rad, where its formula has one."""
        tree = parsed(self.along, "along") if isinstance(self.along, str) else self.along
        if not isinstance(tree, Expression) or has_parameters(tree) or None in units.values():
            return "m"
        powers = unit_of(tree, units, loose=True)
        return "m" if fits(powers, "m") and powers else "rad" if fits(powers, "rad") else ""
