"""A law of several outputs and the time: a formula, a Python function or a table, recorded as a list of operations."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Container, Mapping
from contextlib import suppress
from dataclasses import dataclass
from dataclasses import field as own_field
from functools import partial
from inspect import Parameter
from typing import Any, NamedTuple

from ..._jit.formulas.expression import Expression as Recorded
from ..._jit.formulas.expression import Graph, Node
from ..._jit.formulas.replay import needed, replay
from ..arithmetic import Numeric
from ..errors import ModelError, restated
from ..expression import Call, Expression, Name, parse
from ..quantity import is_list, number
from .curve import Curve, Formula, Tree, curve_of
from .jumps import TIME, refuse_jumps, refuse_recorded_jumps

VARIABLE = (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)
ALL = "o"  # how messages call the argument of a function that has all outputs


class Operations(NamedTuple):
    """Operations of laws on signals, numbers, curves and the time, and the indices of their results."""

    nodes: tuple[Node, ...]
    results: tuple[int, ...]

    def values(self, signals: list[Any], numbers: list[Any], curves: list[Any], t: Any) -> list[Any]:
        """The laws' values for numbers of any kind."""
        graph = Graph()
        graph.nodes.extend(self.nodes)
        inputs: dict[tuple[Any, ...], Any] = {(TIME,): t}
        for kind, given in (("signal", signals), ("number", numbers), ("curve", curves)):
            inputs |= {(kind, n): value for n, value in enumerate(given)}
        return replay(graph, [Recorded(graph, n) for n in self.results], inputs)


@dataclass
class Recording:
    """Laws of one force while they are recorded.

    Attributes
    ----------
    field : for messages
    fields : of each signal, the field in which it was met
    own : what the force's own coordinate and its rate are called, and the names of the outputs that they are
    parameters : numbers that formulas name
    signals, numbers, curves : what was met, in the order of the inputs
    variables : outputs of other parts that are formulas themselves, which are recorded where they are named
    within : the variables that are being recorded
    recorded : those that were
    """

    field: str
    own: Mapping[str, str]
    parameters: Mapping[str, Numeric]
    signals: list[str] = own_field(default_factory=list)
    fields: list[str] = own_field(default_factory=list)
    numbers: list[Numeric] = own_field(default_factory=list)
    labels: list[str] = own_field(default_factory=list)
    curves: list[Curve | Formula] = own_field(default_factory=list)
    graph: Graph = own_field(default_factory=Graph)
    variables: Mapping[str, Callable[[Recording], Recorded]] = own_field(default_factory=dict)
    within: list[str] = own_field(default_factory=list)
    recorded: dict[str, Recorded] = own_field(default_factory=dict)

    def law(self, value: Any, over: str | None = None) -> Recorded:
        """The value of a law: of a number, a formula, a function, or a table.

        Parameters
        ----------
        value : what the user gives
        over : what a table is over, and the one argument of a function that neither names it nor has all outputs; None
            where the part has no field for it

        Raises
        ------
        ModelError
            If it is none of these, or cannot be recorded.
        """
        if isinstance(value, str):
            value = parsed(value, self.field)
        if isinstance(value, Formula):
            value = value.function
        if isinstance(value, Tree):
            value = value.tree
        if isinstance(value, Expression):
            return self._formula(value)
        if isinstance(value, Curve) or is_list(value):
            return self._table(curve_of(value, self.field), over)
        return self._function(value, over) if callable(value) else self.number(number(value, self.field))

    def operations(self, results: list[Recorded]) -> Operations:
        """All that was recorded for some values, and no more."""
        order = needed(self.graph, results)
        place = {old: new for new, old in enumerate(order)}
        nodes = (self.graph.nodes[n] for n in order)
        return Operations(
            tuple(Node(op, tuple(place[arg] for arg in args), value) for op, args, value in nodes),
            tuple(place[result.id] for result in results),
        )

    def number(self, value: Any, label: str = "") -> Recorded:
        """A number of the model: a parameter, that derivatives can be taken by."""
        if label not in self.labels or not label:
            self.numbers.append(value)
            self.labels.append(label)
            return self.graph.input("number", len(self.numbers) - 1)
        return self.graph.input("number", self.labels.index(label))

    def named(self, name: str) -> Recorded:
        """Return the value of a name in a formula: the time, a parameter, or an output."""
        if name == TIME:
            return self.graph.input(TIME)
        if name in self.parameters:
            label = ".".join([*self.within[-1:], name])
            return self.number(number(self.parameters[name], f"parameters.{name}"), label)
        full = self.own.get(name, name)
        if full in self.variables:
            if full not in self.recorded:
                self.recorded[full] = self._variable(full)
            return self.recorded[full]
        if full not in self.signals:
            self.signals.append(full)
            self.fields.append(self.field)
        return self.graph.input("signal", self.signals.index(full))

    def _variable(self, name: str) -> Recorded:
        """A variable of another part, whose own names are not those of the law that contains it."""
        if name in self.within:
            circle = " → ".join([*self.within[self.within.index(name) :], name])
            message = f"{self.field} is in an algebraic loop: {circle}. Put a state between, such as a first-order lag."
            raise ModelError(message, field=self.field)
        self.within.append(name)
        outer = self.own, self.parameters
        self.own, self.parameters = {}, {}
        value = self.variables[name](self)
        self.own, self.parameters = outer
        self.within.pop()
        return value

    def _formula(self, tree: Expression) -> Recorded:
        refuse_jumps(tree, self.field)
        refuse_undefined(tree, self.field)
        constants: list[Any] = []

        def mark(n: int, constant: Any) -> Any:
            constants.append(constant.number)
            return Name(f"#{n}")

        marked = tree.exchanged(mark)
        env = {name: self.named(name) for name in tree.names()}
        env |= {f"#{n}": self.number(value) for n, value in enumerate(constants)}
        return self._expression(marked.value(env))

    def _table(self, curve: Curve | Formula, over: str | None) -> Recorded:
        if over is None:
            message = f"{self.field} cannot be a table. Give the table to an Input"
            raise ModelError(f"{message}, as the value over t, and its name here.", field=self.field)
        if not over:
            message = f"{self.field} is a table, whose first column is not known. Name an output in over"
            raise ModelError(f"{message}, such as over='pin.rate', or t for the time.", field="over")
        return self.looked_up(curve, Recording.law(self, over))

    def looked_up(self, curve: Curve | Formula, x: Recorded, function: str = "curve") -> Recorded:
        """The value of a curve at x; its slope or bend with ``curve_slope`` or ``curve_bend``."""
        place = next((n for n, one in enumerate(self.curves) if one is curve), len(self.curves))
        if place == len(self.curves):
            self.curves.append(curve)
        return self.graph.input("curve", place).call(function, x)

    def _function(self, function: Callable[..., Any], over: str | None) -> Recorded:
        try:
            first, again = (self._expression(self._called(function, over)) for _ in range(2))
        except ModelError:
            raise
        except (TypeError, ValueError, AttributeError, ArithmeticError) as error:
            text = str(error).rstrip(".")
            remedy = "" if ". " in text else " Use functions of sarrus.functions or NumPy."
            message = f"{self.field} cannot be used as a function: {text}.{remedy}"
            raise ModelError(message, field=self.field) from None
        if first.id != again.id:
            message = f"{self.field} is another function each time it is called, as with random numbers"
            raise ModelError(f"{message}. Draw the numbers first.", field=self.field)
        refuse_recorded_jumps(first, self.field)
        return first

    def _called(self, function: Callable[..., Any], over: str | None) -> Any:
        """Call a function with its arguments by name, or with one argument that has all outputs."""
        known = {TIME, *self.own, *self.parameters}
        wanted = arguments(function, known)
        if has_all_outputs(function, known):
            return function(NamedOutputs(self))
        if over and len(wanted) == 1 and not known.intersection(wanted):
            return function(self.named(over))
        for name in wanted:
            if name not in known:
                names = ", ".join(one for one in sorted(known) if one.isidentifier())
                raise ModelError(
                    f"{self.field} has the argument {name}. Name its arguments {names}, "
                    f"or give it one, {ALL}, and write {ALL}['pin.rate'].",
                    field=self.field,
                )
        given = {name: self.named(name) for name in wanted}
        by_name = {name: given.pop(name) for name, one in wanted.items() if one is Parameter.KEYWORD_ONLY}
        return function(*given.values(), **by_name)

    def _expression(self, value: Any) -> Recorded:
        if isinstance(value, Recorded):
            return value
        return self.graph.constant(number(value, self.field))


class NamedOutputs:
    """Argument of a law given as a Python function: ``o["pin.rate"]``, or ``o("pin.rate")``, ``o.t``, ``o.x``."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording

    def __getitem__(self, name: str) -> Recorded:
        return self._recording.named(str(name))

    __call__ = __getitem__

    def __getattr__(self, name: str) -> Recorded:
        if name.startswith("_"):
            raise AttributeError(name)
        return self._recording.named(name)


class Probe:
    """An argument that notes whether a function looks for outputs in it."""

    asked = False

    def __getitem__(self, name: object) -> Any:
        self.asked = self.asked or isinstance(name, str)  # an iteration asks for 0
        raise TypeError

    __call__ = __getitem__

    def __getattr__(self, name: str) -> Any:
        self.asked = self.asked or not (name.startswith("_") or hasattr(Expression, name))
        raise AttributeError(name)


def arguments(function: Callable[..., Any], known: Container[str]) -> dict[str, Any]:
    """The arguments of a function by name, with their kinds, but for those with defaults that are not `known`."""
    try:
        found = inspect.signature(function).parameters
    except (TypeError, ValueError):  # some functions that are compiled
        return {"x": Parameter.POSITIONAL_ONLY}
    fixed = function.keywords if isinstance(function, partial) else {}
    wanted = {
        name: one.kind
        for name, one in found.items()
        if one.kind not in VARIABLE
        and name not in fixed
        and (name in known or one.default is Parameter.empty)
    }
    return wanted or {name: one.kind for name, one in found.items() if one.kind is Parameter.VAR_POSITIONAL}


def has_all_outputs(function: Callable[..., Any], known: Container[str]) -> bool:
    """Return whether a function has one argument that is not `known`, in which it finds outputs by their names."""
    wanted = [*arguments(function, known)]
    if len(wanted) != 1 or wanted[0] in known:
        return False
    probe = Probe()
    with suppress(Exception):  # such as arithmetic on it
        function(probe)
    return probe.asked or wanted[0] == ALL


def parsed(text: str, field: str) -> Expression:
    """The formula of a text, whose names are looked up later."""
    with restated(field, field=field):
        return parse(text)


def written_formula(law: Any) -> Expression | None:
    """Return the formula of a law, if it is one that can be read; another place reports one that cannot."""
    if isinstance(law, str):
        with suppress(ModelError):
            return parse(law)
    written = law.written if isinstance(law, Formula) else None
    found = written.tree if written else law
    return found if isinstance(found, Expression) else None


def refuse_undefined(tree: Expression, field: str) -> None:
    """Refuse a formula with a part that contains numbers alone and has no value, as ``1/0``.

    Raises
    ------
    ModelError
    """
    with restated(field, field=field):
        for node in tree.nodes():
            if isinstance(node, Call) and not node.names():
                node.value()
