"""Parameters of derivatives: of the model and its file, design variables, table values and constants.

The chain from these to the numbers b of the elements and to the guess (q₀, v₀) of the assembly is the construction of
the model; it is recorded once and differentiated exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import cached_property
from math import isfinite
from typing import Any

import numpy as np

from ....algebra import Array
from ....model import Model, SarrusError
from ....model.expansion.blueprint import blueprint
from ....model.expression import Call, Expression, Number
from ....model.quantity import is_list
from ....model.show import suggest
from ....model.tape import Tape, Tracer, value_of
from ....model.written import (
    exchanged,
    following_numbers,
    named,
    numbers_in_jumps,
    with_numbers,
    written_numbers,
)
from ....outputs import find_output
from ....outputs.units import product, units_of
from ....system import System
from ....system.cached import once
from ....system.structure.population import places_of
from ..chain.chain import Gradients
from .design_start import own_rates, own_start
from .linearized import TapeDerivatives

Design = Callable[[Mapping[str, Any]], Mapping[str, Any]]
GUESS = ("start.q.", "start.v.")
# [-] relative difference between numbers of a design and of the model that may come from rounding
SAME = 1e-7


class UnknownParameter(SarrusError):
    """A parameter that the model does not have."""


class Parameters:
    """Named numbers, and the derivatives of b, q₀ and v₀ with respect to them.

    Parameters
    ----------
    system : System
    wrt : names: ``rod.mass``, ``pin.point`` (all three), ``pin.point.x``, a parameter of the model file or a design
        variable (which are meant where a number has the same name), a number of an element ``spring[tsda].k``, or
        ``start.q.crank.r.x``, ``start.v...`` for the guess of the assembly; None for all parameters of the model
    design : values of design variables
    formula : a Python function of the design variables that returns parameters of the model by name
    start : of the run, which depends on the model's own initial state, if it does
    restitutions : of the run's impacts, by name

    Notes
    -----
    The numbers c are those of the joints' coordinates, given rates of the start, and restitutions.
    """

    def __init__(
        self,
        system: System,
        wrt: Sequence[str] | None = None,
        *,
        design: Mapping[str, float] | None = None,
        formula: Design | None = None,
        start: Any = None,
        restitutions: Mapping[str, float] | None = None,
    ) -> None:
        self.system, self.restitutions = system, dict(restitutions or {})
        self._design, self._formula = dict(design or {}), formula
        _refuse_incomplete(self._design, formula)
        self.names = self._expanded(wrt)
        self.values = np.array([self._value(name) for name in self.names])
        self._own_q, self._own_v = own_start(system, start)
        self.rates = own_rates(system, start)
        if self._design or self._formula or (self.names and not self._known.keys() >= set(self.names)):
            self._refuse_both()
            self._refuse_other(self._moving)

    @cached_property
    def _numbers(self) -> Mapping[str, float]:
        return numbers_of(self.system)

    @cached_property
    def _known(self) -> Mapping[str, float]:
        """The values in the model whose names are not those of design variables or of its parameters."""
        hidden = self._design.keys() | self.system.model.parameters.keys()
        return {n: v for n, v in self._numbers.items() if n not in hidden} if hidden else self._numbers

    def _expanded(self, wrt: Sequence[str] | None) -> list[str]:
        if wrt is None:
            return [*self._design] if self._design else [n for n in self._numbers if n not in self._jumps]
        return list(dict.fromkeys(found for name in listed(wrt) for found in self._matches(name)))

    def _matches(self, name: str) -> list[str]:
        if name in self._design or name in self._known or name in self.system.model.parameters:
            return [name]
        if name in self._element_numbers or name in self.restitutions or name.startswith(GUESS):
            return [name]
        found = self._in_group(name)
        if not found:
            _refuse_default(self.system, name)
            known = [*self._design, *self._known, *self.system.model.parameters, *self.restitutions]
            raise UnknownParameter(f"{self.system.name} has no parameter {name!r}. {suggest(name, known)}")
        return found

    def _in_group(self, name: str) -> list[str]:
        """The three coordinates of a hardpoint, those of all hardpoints, or the numbers of a field."""
        hardpoints = self.system.model.formulas.hardpoints
        if name == "hardpoints" or name in hardpoints:
            points = [name] if name in hardpoints else [*hardpoints]
            return [f"{point}.{axis}" for point in points for axis in "xyz"]
        return [known for known in self._numbers if known.startswith(f"{name}.")]

    def _value(self, name: str) -> float:
        if name in self._design:
            return float(self._design[name])
        if name in self._known:
            return self._known[name]
        if name in self.system.model.parameters:
            return float(self.system.model.parameters[name])
        if name in self.restitutions:
            return self.restitutions[name]
        if name.startswith(GUESS):
            whole = self.system.q0 if name.startswith(GUESS[0]) else self.system.v0
            return float(whole[_coordinate(self.system, name)])
        return float(self.system.b[self._element_numbers[name]])

    @property
    def units(self) -> tuple[str, ...]:
        """Their units; empty for design variables, and others whose unit is not known."""
        found = dict(zip(self.names, units_of(self.system, tuple(self.names)), strict=True))
        found |= dict.fromkeys(found.keys() & self.restitutions.keys(), "1")
        for name in found.keys() & {f"rates.{name}" for name in self.system.model.rates}:
            found[name] = product((find_output(self.system, name.partition(".")[2]).unit, 1), ("s", -1))
        return tuple("" if name in self._design else unit for name, unit in found.items())

    @property
    def table_units(self) -> tuple[str, ...]:
        """The units in which tables show them: those of hardpoints, and empty for others."""
        hardpoints, own = self.system.model.formulas.hardpoints, self.system.model.parameters
        found = (hardpoints.get(name.rpartition(".")[0], "") if name in own else "" for name in self.names)
        return tuple(
            "" if name in self._design else unit for name, unit in zip(self.names, found, strict=True)
        )

    @cached_property
    def _element_numbers(self) -> dict[str, int]:
        """Places of the numbers of elements in b, by name."""
        return {name: n for n, name in enumerate(self.system.parameter_names)}

    @cached_property
    def _tape(self) -> Tape:
        """What the construction of the model is recorded on."""
        return Tape()

    @cached_property
    def variables(self) -> dict[str, Tracer]:
        """The parameters as they are recorded."""
        return {n: self._tape.variable(v) for n, v in zip(self.names, self.values, strict=True)}

    @cached_property
    def _moving(self) -> dict[str, Any]:
        """The model's values that follow from the chosen parameters, recorded."""
        return self._places(self.variables)

    @cached_property
    def _outputs(self) -> list[tuple[int, int]]:
        """Where recorded numbers arrive when the model is built of them: place in [b; q₀; v₀; c], place on the tape."""
        system, size = self.system, len(self.system.b)
        self._refuse_jumps()
        model = self._model()
        plan = blueprint(model)
        found: list[tuple[int, int]] = []

        def note(place: int, value: Any) -> None:
            if isinstance(value, Tracer):
                found.append((place, value.at))

        for place, value in places_of(system.populations, plan.placed, system.b):
            note(place, value)
        for first, whole, own in ((size, plan.q, self._own_q), (size + system.nq, plan.v, self._own_v)):
            for k, value in enumerate(whole if own else ()):
                note(first + k, value)
        joints, first = system.joint_coordinates, size + 2 * system.nq
        for place, value in places_of(joints.populations, plan.coordinates, joints.b):
            note(first + place, value)
        first += len(joints.b)
        struck = [self._struck.get(name) for name in self.restitutions]
        for place, value in enumerate([*(model.rates.get(name) for name in self.rates), *struck]):
            note(first + place, value)
        for name, variable in self.variables.items():
            if name.startswith(GUESS):
                at = size + _coordinate(system, name) + (0 if name.startswith(GUESS[0]) else system.nq)
                found.append((at, variable.at))
            elif name not in self._design and name not in self._known and name in self._element_numbers:
                found.append((self._element_numbers[name], variable.at))
        return found

    @property
    def _struck(self) -> dict[str, Any]:
        """The restitutions that follow from the parameters, recorded."""
        return {name: x for name, x in (self.variables | self._moving).items() if name in self.restitutions}

    def restitutions_at(self, values: Sequence[float]) -> dict[str, float]:
        """The restitutions with other values of the parameters."""
        given = {name: float(value) for name, value in zip(self.names, values, strict=True)}
        moved = given | self._places(given)
        return {name: float(moved.get(name, own)) for name, own in self.restitutions.items()}

    @property
    def c_size(self) -> int:
        """The number of parameters of joint coordinates, with those of the run."""
        return len(self.system.joint_coordinates.b) + len(self.of_run)

    @property
    def of_run(self) -> list[str]:
        """The names of the start's given rates, and of restitutions; empty for rates that are not the model's."""
        return [*(name and f"rates.{name}" for name in self.rates), *self.restitutions]

    @property
    def in_curves(self) -> bool:
        """Whether they change numbers of tables or functions."""
        return any(self.system.nb <= place < len(self.system.b) for place, _ in self._outputs)

    def _model(self) -> Model:
        """The model with recorded numbers in the places that depend on the parameters."""
        return exchanged(self.system.model, lambda steps, value: self._moving.get(named(steps), value))

    def _places(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """The model's parameters, by name, for numbers of any kind as values of the chosen ones."""
        places = self._from_file(given) | self._from_design(given)
        return places | {name: value for name, value in given.items() if name in self._known}

    def _of_file(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """The names of the model file, with values as they follow from its parameters; empty if none is given."""
        formulas = self.system.model.formulas
        own = {n: v for n, v in given.items() if n in formulas.parameters and n not in self._design}
        return formulas.values(own) if own else {}

    def _from_file(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Numbers that follow from the parameters of the model file."""
        formulas = self.system.model.formulas
        values = self._of_file(given)
        own = {n: v for n, v in given.items() if n in values and n in formulas.parameters}
        self._refuse_exponents(formulas.following(own))
        return following_numbers(self.system.model, own)

    def _from_design(self, given: Mapping[str, Any]) -> dict[str, Any]:
        if self._formula is None:
            return {}
        own = {name: given.get(name, value) for name, value in self._design.items()}
        numbers: Any = self._formula(own)
        if not isinstance(numbers, Mapping) or not numbers:
            raise UnknownParameter(
                f"a design's formula returns parameters of the model by name, {{'spring.k': ...}}, but not {numbers!r}"
            )
        return {
            found: entry
            for name, value in numbers.items()
            for found, entry in _entries(name, value, {**self._numbers, **self.restitutions})
        }

    def model_at(self, values: Sequence[float]) -> Model:
        """The model with other values of the parameters.

        Raises
        ------
        UnknownParameter
            For numbers of elements and of the start, which are no parameters of the model.
        """
        given = {name: float(value) for name, value in zip(self.names, values, strict=True)}
        model = self.system.model
        parameters = {*self._design, *self._known, *model.parameters, *self.restitutions}
        if name := next((name for name in given if name not in parameters), None):
            raise UnknownParameter(
                f"{name} is no parameter of the model. Choose from {', '.join([*self._known][:5])} ..."
            )
        own = {name: value for name, value in given.items() if name in model.parameters}
        places = {name: x for name, x in self._places(given).items() if name not in self.restitutions}
        return with_numbers(replace(model, formulas=model.formulas.with_values(own)), places)

    def _refuse_both(self) -> None:
        """A number that follows from another one that is asked for has no derivative of its own beside it."""
        follow = self._from_file(self.variables) | self._from_design(self.variables)
        both = next((name for name in self.names if name in follow and name in self._known), None)
        if both is not None:
            raise UnknownParameter(
                f"{both}: follows by a formula from other parameters that are asked for, and has no derivative of "
                "its own beside theirs. Leave it out, or them."
            )

    @cached_property
    def _jumps(self) -> frozenset[str]:
        """The numbers that move jumps of laws."""
        return numbers_in_jumps(self.system.model)

    def _refuse_jumps(self) -> None:
        """Derivatives by a number that moves a jump of a law are not those of its operations, which are zero."""
        moved = next((name for name in {**self.variables, **self._moving} if name in self._jumps), None)
        if moved is not None:
            raise UnknownParameter(
                f"{moved} moves a jump of a law, by sign or step of one argument, and has no derivative here. Leave it "
                "out of wrt, with what it follows from, or use step(x, x0, h0, x1, h1)."
            )

    def _refuse_exponents(self, moving: Iterable[str]) -> None:
        """Exponents are constants of a formula, which would not follow from parameters of the file."""
        if name := next((name for name in moving if name in self._exponents), None):
            raise UnknownParameter(
                f"{name} is an exponent in a formula of {self._exponents[name]}, where it is a constant. Give the "
                f"part a parameter of its own, as in parameters: {{p: {name}}}, and take p in the formula."
            )

    @cached_property
    def _exponents(self) -> Mapping[str, str]:
        return parameters_in_exponents(self.system.model)

    def _refuse_other(self, found: Mapping[str, Any]) -> None:
        """The model must be the one that the design describes."""
        numbers = {**self._numbers, **self.restitutions}
        for name, entry in found.items():
            if name not in numbers:
                message = f"{name} follows from a formula, but is no number that has derivatives"
                raise UnknownParameter(f"{message}. Leave out the parameters that it depends on.")
            own, given = numbers[name], float(value_of(entry))
            if abs(given - own) > SAME * max(1.0, abs(own)):
                message = f"the design gives {given:.9g} for {name}, but the model has {own:.9g}"
                raise UnknownParameter(
                    f"{message}. Make the model with `with_numbers` from the design's values."
                )

    def number(self, name: str, variable: Callable[[str, float], Any]) -> Any:
        """Any number by name, as it follows from the parameters, which `variable` records.

        Raises
        ------
        UnknownParameter
            If there is none.
        """
        value = self._value(self._matches(name)[0])
        if name in self.names:
            return variable(name, value)
        own = {given: variable(given, self._value(given)) for given in self.names}
        places = {} if name in self.system.model.parameters else self._places(own)
        return (self._of_file(own) | places).get(name, value)

    def along(self, change: Array) -> tuple[Array, Array, Array, Array]:
        """Changes of b, q₀, v₀ and the joints' numbers c (…, k) for changes of the parameters (p, k)."""
        return self._split(self._construction.along(np.asarray(change, dtype=float)))

    def second(self, change: Array, other: Array) -> tuple[Array, Array, Array, Array]:
        """Second derivatives of b, q₀, v₀ and the joints' numbers c along two changes of the parameters (p,)."""
        return self._split(self._construction.second(change, other))

    def gradient(self, by: Gradients, by_c: Array) -> Array:
        """Gradients by the parameters (p, k) of responses with the gradients given."""
        return self._construction.gradient(np.concatenate([by.b, by.q, by.v, by_c]))

    def gradient_along(self, bars: Array, bar_dots: Array, change: Array) -> Array:
        """The change of a gradient (p,), with changes of the parameters and of the gradient by [b; q₀; v₀; c]."""
        return self._construction.gradient_along(bars, bar_dots, change)

    @cached_property
    def _construction(self) -> TapeDerivatives:
        """Return [b; q₀; v₀; c] as recorded functions of the parameters."""
        own, fixed = (
            self._known.keys() | self.system.model.parameters.keys(),
            tuple(self.restitutions.items()),
        )
        if self._design or self._formula or not own.issuperset(self.names):
            return self.recorded()
        own_start = self._own_q, self._own_v, self.rates
        return _recorded(self.system, tuple(self.names), own_start, fixed)

    def recorded(self) -> TapeDerivatives:
        """The same, by building the model."""
        size, outputs = len(self.system.b) + 2 * self.system.nq + self.c_size, self._outputs
        places = [variable.at for variable in self.variables.values()]
        return TapeDerivatives(self._tape, places, outputs, size)

    def _split(self, whole: Array) -> tuple[Array, Array, Array, Array]:
        size, nq = len(self.system.b), self.system.nq
        b, q, v, c = np.split(whole, [size, size + nq, size + 2 * nq])
        return b, q, v, c


def listed(wrt: Any) -> list[str]:
    """Names of parameters as a list; a single one, too.

    Raises
    ------
    TypeError
        For a mapping, whose values would have no effect, and for anything else that has no names.
    """
    names = [wrt] if isinstance(wrt, str) else list(wrt) if isinstance(wrt, Iterable) else [wrt]
    if isinstance(wrt, Mapping) or not all(isinstance(name, str) for name in names):
        message = f"wrt must be names of parameters, got {wrt!r:.60}. Give a list such as ['spring.k']"
        raise TypeError(
            f"{message}{'; limits of a search are bounds=.' if isinstance(wrt, Mapping) else '.'}"
        )
    return names


@once
def _refuse_default(system: System, name: str) -> None:
    """Refuse a number of a field that is not given, whose default follows from other fields.

    Raises
    ------
    UnknownParameter
    """
    part, _, rest = name.partition(".")
    field = rest.partition(".")[0]
    parts = (one for section in system.model.sections().values() for one in section if one.name == part)
    if field and getattr(next(parts, None), field, 0) is None:
        raise UnknownParameter(f"{part}: {field} is not given. Give {field} to differentiate by it.")


@once
def numbers_of(system: System) -> Mapping[str, float]:
    """Every number that was written into a system's model, by name."""
    return written_numbers(system.model)


@once
def _recorded(
    system: System,
    names: tuple[str, ...],
    own: tuple[bool, bool, tuple[str, ...]],
    restitutions: tuple[tuple[str, float], ...],
) -> TapeDerivatives:
    """Of numbers that are the model's, which does not change."""
    found = Parameters(system, names, restitutions=dict(restitutions))
    found._own_q, found._own_v, found.rates = own
    return found.recorded()


def _refuse_incomplete(design: Mapping[str, Any], formula: Design | None) -> None:
    """A formula needs variables, which are finite numbers; variables without one are for responses alone."""
    if formula is not None and not design:
        raise UnknownParameter(
            "formula: it is given without design. Give the values of the variables, design={...}."
        )
    for name, value in design.items():
        if isinstance(value, str) or not isfinite(value):
            raise UnknownParameter(
                f"design variable {name!r} must be a finite number, but is {value!r}. Replace it."
            )


def _entries(name: str, value: Any, known: Mapping[str, float]) -> list[tuple[str, Any]]:
    """A number, or the numbers of a vector, by their full names."""
    if name in known:
        return [(name, value)]
    found = [own for own in known if own.startswith(f"{name}.")]
    if not found or len(found) != np.size(value):
        raise UnknownParameter(
            f"the design gives {name!r}, which is no number of the model. {suggest(name, known)}"
        )
    return list(zip(found, np.ravel(np.asarray(value, dtype=object)), strict=True))


def _coordinate(system: System, name: str) -> int:
    """Place in q of the coordinate that ``start.q.crank.r.x`` names."""
    names = system.coordinate_names
    if name[len(GUESS[0]) :] not in names:
        raise UnknownParameter(f"{system.name} has no coordinate {name!r}. {suggest(name, names)}")
    return names.index(name[len(GUESS[0]) :])


def parameters_in_exponents(model: Model) -> dict[str, str]:
    """Return the parameters of the file that are exponents, with a part in whose formula each is."""
    return {
        exponent.of: part.name
        for parts in model.sections().values()
        for part in parts
        for tree in _trees(part)
        for node in tree.nodes()
        if isinstance(node, Call) and node.function.name == "**"
        for exponent in node.args[1:]
        if isinstance(exponent, Number) and exponent.of
    }


def _trees(value: Any) -> Iterator[Expression]:
    """Yield all formulas of a part."""
    if isinstance(value, Expression):
        yield value
        return
    entries = list[Any]()
    if is_dataclass(value) and not isinstance(value, type):
        entries = [getattr(value, field.name) for field in fields(value)]
    elif isinstance(value, Mapping):
        entries = [*value.values()]
    elif is_list(value):
        entries = [*value]
    for entry in entries:
        yield from _trees(entry)
