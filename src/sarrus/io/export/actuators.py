"""Forces and torques along joints that are linear in an input, as actuators: the inverse of their import.

A value is (gain + gain_x x + gain_v v) u + offset - kp x - kv v, between limits, with the coordinate x, its rate v and
u, an input between limits, or a state that follows it as a lag or an integral. The coefficients are those of a
polynomial: other formulas, such as limits of a state or of a sum with the coordinate, have no place in an actuator.
A lag with a gain is that gain times a lag without.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Container
from math import inf
from typing import Any, TypeAlias

from ...elements import Element
from ...model import FirstOrderLag, Input, Model, StateVariable, Torque
from ...model.coordinate import ANGLE, DISPLACEMENT
from ...model.expression import Call, Expression, Name, Number
from ...model.forces.by_formula import Force
from ...model.laws.recorded import parsed
from ..robot import Activation, Actuator
from .loads import Match
from .missing import Gap, NotInFormat, no_place

OWN = {"x": "x", "angle": "x", "displacement": "x", "v": "v", "rate": "v"}
TERMS = (("u",), ("u", "x"), ("u", "v"), (), ("x",), ("v",))
Find: TypeAlias = "Callable[[str, type[Element] | None], Match | None]"
Polynomial: TypeAlias = "dict[tuple[str, ...], float]"  # coefficients by the sorted names of a product


class Actuators:
    """The actuators of a model by the name of their input, or of the force.

    Attributes
    ----------
    controls : the value of each input
    parts : by actuator, the names of its force, input and state
    missing : what no actuator can be
    """

    def __init__(self, model: Model, find: Find) -> None:
        self.inputs = {part.name: part for part in model.forces if isinstance(part, Input)}
        self.states = {
            part.name: part for part in model.forces if isinstance(part, StateVariable | FirstOrderLag)
        }
        self.actuators: dict[str, Actuator] = {}
        self.controls: dict[str, float] = {}
        self.parts: dict[str, tuple[str, ...]] = {}
        self.missing: list[Gap] = []
        for part in model.forces:
            if isinstance(part, Torque | Force) and part.joint is not None:
                try:
                    self._add(part, part.joint, find)
                except NotInFormat as error:
                    names = dict.fromkeys((part.name, *error.missing.names))
                    self.missing.append(error.missing._replace(names=tuple(names)))
        for name in (*self.inputs, *self.states):
            if name not in self.done:
                self.missing.append(no_place(name, "input or state that moves no actuator").missing)

    @property
    def done(self) -> set[str]:
        """The names of the parts that are actuators, and of those that cannot be."""
        missing = (one.names for one in self.missing)
        return {name for names in (*self.parts.values(), *missing) for name in names}

    def _add(self, part: Any, joint: str, find: Find) -> None:
        match, kind = find(joint, ANGLE if isinstance(part, Torque) else DISPLACEMENT), type(part).__name__
        if match is None:
            raise no_place(part.name, f"{kind} along a coordinate of {joint}")
        tree = _tree(part, part.value)
        factor = _tree(part, getattr(part, "factor", 1.0))
        value, forces = clamped(tree * factor if str(factor) != "1" else tree)
        value, controls = _without_limits(part.name, value, self.inputs)
        driving = [name for name in value.names() if name not in OWN]
        if len(driving) > 1 or not self.inputs.keys() | self.states.keys() >= {*driving}:
            raise no_place(part.name, f"{kind} that depends on {' and '.join(driving)}")
        one = driving[0] if driving else ""
        given = _linear(value, one)
        if given is None:
            raise no_place(part.name, f"{kind} that is not linear in its input, coordinate and rate")
        self._write(part.name, one, match, given, forces, controls.get(one, (-inf, inf)))

    def _write(
        self, part: str, driving: str, match: Match, given: Any, forces: Any, limits: tuple[float, float]
    ) -> None:
        s, start = match.sign, match.start
        activation, control, factor = None, driving, 1.0
        if driving in self.states:
            activation, factor, control, limits = self._activation(driving)
        name = control or part
        if name in self.actuators:
            raise no_place(part, f"second actuator of the input {name}")
        gain, gain_x, gain_v = (factor * one for one in given[:3])
        offset, kp, kv = given[3:]
        self.actuators[name] = Actuator(
            match.motion,
            gain=s * (gain + gain_x * start),
            offset=s * (offset - kp * start),
            kp=kp,
            kv=kv,
            gain_x=gain_x,
            gain_v=gain_v,
            controls=limits,
            forces=forces if s > 0 else (-forces[1], -forces[0]),
            activation=activation,
        )
        self.controls[name] = self._control(control)
        self.parts[name] = tuple(dict.fromkeys(one for one in (part, driving, control) if one))

    def _control(self, name: str) -> float:
        if not name:
            return 0.0
        value = self.inputs[name].value
        if not isinstance(value, int | float | None):
            raise no_place(name, "input that varies in time")
        return float(value or 0.0)

    def _activation(self, name: str) -> tuple[Activation, float, str, tuple[float, float]]:
        """Return a lag or an integral, the gain of the lag, the input that it follows, and its limits."""
        state = self.states[name]
        rate, limits = _without_limits(name, _rate(state).replaced({"x": Name(name)}), self.inputs)
        inputs = [one for one in rate.names() if one != name]
        terms = polynomial(rate)
        if len(inputs) == 1 and inputs[0] in self.inputs and terms is not None:
            decay, other = (terms.pop((one,), 0.0) for one in (name, inputs[0]))
            if not any(terms.values()) and other and (decay < 0 or (decay == 0 and other == 1)):
                time, gain = (-1 / decay, -other / decay) if decay else (0.0, 1.0)
                return (
                    Activation(time, float(state.initial or 0.0) / gain),
                    gain,
                    inputs[0],
                    limits[inputs[0]],
                )
        raise no_place(name, "state other than a lag or an integral of an input")


def clamped(tree: Expression) -> tuple[Expression, tuple[float, float]]:
    """Return a formula without the outer `min` and `max` of a number, and its limits; a number for equal limits."""
    lower, upper = -inf, inf
    while isinstance(tree, Call) and tree.function.name in ("min", "max") and len(tree.args) == 2:
        numbers = [arg for arg in tree.args if not arg.names()]
        if len(numbers) != 1:
            break
        bound = float(numbers[0].value())
        if tree.function.name == "min":
            upper = max(lower, min(upper, bound))  # the outer bounds count
        else:
            lower = min(upper, max(lower, bound))
        tree = next(arg for arg in tree.args if arg is not numbers[0])
    return (Number(lower), (-inf, inf)) if lower == upper else (tree, (lower, upper))


def _without_limits(
    part: str, tree: Expression, names: Container[str]
) -> tuple[Expression, dict[str, tuple[float, float]]]:
    """Return a formula with names in place of names between limits, and these limits, the same wherever a name is."""
    limits: dict[str, tuple[float, float]] = {}

    def freed(node: Expression) -> Expression:
        inner, ends = clamped(node)
        if isinstance(inner, Name) and inner.name in names:
            if limits.setdefault(inner.name, ends) != ends:
                raise no_place(part, f"formula with {inner.name} between different limits")
            return inner
        if isinstance(node, Call) and not isinstance(inner, Number):
            return Call(node.function, tuple(freed(arg) for arg in node.args))
        return inner

    return freed(tree), limits


def _rate(state: StateVariable | FirstOrderLag) -> Expression:
    """Return the formula of a state's rate."""
    if isinstance(state, StateVariable):
        return _tree(state, state.rate)
    return (Number(state.gain) * _tree(state, state.input) - Name(state.name)) / Number(state.time)


def _tree(part: Any, law: Any) -> Expression:
    """Return a law as a formula with numbers in place of parameters."""
    if not isinstance(law, str | int | float | Expression):
        raise no_place(part.name, f"{type(part).__name__} by a function or a table")
    tree = (
        parsed(law, "value") if isinstance(law, str) else law if isinstance(law, Expression) else Number(law)
    )
    return tree.replaced({name: Number(float(value)) for name, value in part.parameters.items()})


def _linear(tree: Expression, driving: str) -> tuple[float, ...] | None:
    """Return gain, gain_x, gain_v, offset, kp and kv of a formula, None if it is not linear."""
    terms = polynomial(tree.replaced({name: Name(word) for name, word in OWN.items()} | {driving: Name("u")}))
    if terms is None or any(terms[term] for term in terms.keys() - {*TERMS}):
        return None
    gain, gain_x, gain_v, offset, by_x, by_v = (terms.get(term, 0.0) for term in TERMS)
    return gain, gain_x, gain_v, offset, -by_x, -by_v


def polynomial(tree: Expression) -> Polynomial | None:
    """Return the coefficients of a formula of at most second degree, None for another one."""
    found: dict[Expression, Polynomial | None] = {}
    for node in tree.nodes():
        args = [found[arg] for arg in node.args]
        if isinstance(node, Name):
            found[node] = {(node.name,): 1.0}
        elif all(arg is not None and arg.keys() == {()} for arg in args):
            found[node] = {(): float(node.value())}
        else:
            found[node] = None if None in args else _combined(node, args)
    return found[tree]


def _combined(node: Any, args: Any) -> Polynomial | None:
    """Return the sum, difference or product of polynomials, or the quotient by a number, if the node is one."""
    word, first, other = node.function.name, args[0], args[-1]
    if word in ("+", "-"):
        sign = 1.0 if word == "+" else -1.0
        return {one: first.get(one, 0.0) + sign * other.get(one, 0.0) for one in first.keys() | other.keys()}
    if word in ("neg", "deg", "rad"):
        return {one: node.function.value(c) for one, c in first.items()}
    if word == "/" and other.keys() == {()} and other[()]:
        return {one: c / other[()] for one, c in first.items()}
    if word != "*":
        return None
    product: Polynomial = {}
    for (a, x), (b, y) in itertools.product(first.items(), other.items()):
        one = tuple(sorted(a + b))
        product[one] = product.get(one, 0.0) + x * y
    return product if max(map(len, product)) <= 2 else None
