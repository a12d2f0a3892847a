"""Forces and torques along joints that are linear in an input, as actuators: the inverse of their import.

A value is (gain + gain_x x + gain_v v) u + offset - kp x - kv v, between limits, with the coordinate x, its rate v and
u, an input between limits, or a state that follows it as a lag or an integral. The coefficients are derivatives of the
formula at zero; a formula that they do not reproduce at other places is not linear.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from typing import Any, TypeAlias

import numpy as np

from ...elements import Element
from ...model import Input, Model, StateVariable, Torque
from ...model.coordinate import ANGLE, DISPLACEMENT
from ...model.errors import ModelError
from ...model.expression import Call, Expression, Name, Number
from ...model.forces.by_formula import Force
from ...model.laws.recorded import parsed
from ..robot import Activation, Actuator
from .loads import Found, no_place

OWN = {"x": "x", "angle": "x", "displacement": "x", "v": "v", "rate": "v"}
PLACES = np.random.default_rng(0).normal(size=(8, 3))  # of x, v and u, where a linear formula is compared
ROUNDING = 1e-12
Find: TypeAlias = "Callable[[str, type[Element] | None], Found | None]"


class Actuators:
    """The actuators of a model by the name of their input, or of the force; ``done`` are the parts that they are.

    Attributes
    ----------
    controls : the value of each input
    """

    def __init__(self, model: Model, find: Find) -> None:
        self.inputs = {part.name: part for part in model.forces if isinstance(part, Input)}
        self.states = {part.name: part for part in model.forces if isinstance(part, StateVariable)}
        self.actuators: dict[str, Actuator] = {}
        self.controls: dict[str, float] = {}
        self.done: set[str] = set()
        for part in model.forces:
            if isinstance(part, Torque | Force) and part.joint is not None:
                self._add(part, part.joint, find)
        for name in (*self.inputs, *self.states):
            if name not in self.done:
                raise no_place(name, "input or state that moves no actuator")

    def _add(self, part: Any, joint: str, find: Find) -> None:
        found, kind = find(joint, ANGLE if isinstance(part, Torque) else DISPLACEMENT), type(part).__name__
        if found is None:
            raise no_place(part.name, f"{kind} along a coordinate of {joint}")
        tree = _tree(part, part.value)
        factor = _tree(part, getattr(part, "factor", 1.0))
        value, forces = clamped(tree * factor if str(factor) != "1" else tree)
        value, controls = _without_limits(value, {*self.inputs, *self.states})
        driving = [name for name in value.names() if name not in OWN]
        if len(driving) > 1 or (
            driving and driving[0] not in controls.keys() | self.inputs.keys() | self.states.keys()
        ):
            raise no_place(part.name, f"{kind} that depends on {' and '.join(driving)}")
        one = driving[0] if driving else ""
        given = _linear(value, one)
        if given is None:
            raise no_place(part.name, f"{kind} that is not linear in its input, coordinate and rate")
        self._write(part.name, one, found, given, forces, controls.get(one, (-inf, inf)))

    def _write(
        self, part: str, driving: str, found: Found, given: Any, forces: Any, limits: tuple[float, float]
    ) -> None:
        s, start = found.sign, found.start
        activation, control = None, driving
        if driving in self.states:
            activation, control, limits = self._activation(driving)
        name = control or part
        if name in self.actuators:
            raise no_place(part, f"second actuator of the input {name}")
        gain, gain_x, gain_v, offset, kp, kv = given
        self.actuators[name] = Actuator(
            found.motion,
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
        self.done |= {part, driving, control} - {""}

    def _control(self, name: str) -> float:
        if not name:
            return 0.0
        value = self.inputs[name].value
        if not isinstance(value, int | float | None):
            raise no_place(name, "input that varies in time")
        return float(value or 0.0)

    def _activation(self, name: str) -> tuple[Activation, str, tuple[float, float]]:
        """Return a lag or an integral, the input that it follows, and its limits."""
        state = self.states[name]
        rate, limits = _without_limits(_tree(state, state.rate), {*self.inputs})
        rate = rate.replaced({"x": Name(name)})
        inputs = [one for one in rate.names() if one != name]
        if len(inputs) == 1 and inputs[0] in self.inputs:
            by_own, by_input = (rate.derivative(one) for one in (name, inputs[0]))
            slopes = [
                one.value(dict(zip((name, *inputs), place, strict=False)))
                for one in (by_own, by_input)
                for place in PLACES
            ]
            own, other = slopes[0], slopes[len(PLACES)]
            constant = np.ptp(slopes[: len(PLACES)]) + np.ptp(slopes[len(PLACES) :]) < ROUNDING * abs(other)
            zero = rate.value({name: 0.0, inputs[0]: 0.0}) == 0
            if constant and zero and other > 0 and (own == -other or (own == 0 and other == 1)):
                start = float(state.initial or 0.0)
                return (
                    Activation(1 / other if own else 0.0, start),
                    inputs[0],
                    limits.get(inputs[0], (-inf, inf)),
                )
        raise no_place(name, "state other than a lag or an integral of an input")


def clamped(tree: Expression) -> tuple[Expression, tuple[float, float]]:
    """Return a formula without the outer `min` and `max` of a number, and its limits."""
    lower, upper = -inf, inf
    while isinstance(tree, Call) and tree.function.name in ("min", "max") and len(tree.args) == 2:
        numbers = [one for one in tree.args if not one.names()]
        if len(numbers) != 1:
            break
        bound = float(numbers[0].value())
        if tree.function.name == "min":
            upper = max(lower, min(upper, bound))  # the outer bounds count
        else:
            lower = min(upper, max(lower, bound))
        tree = next(one for one in tree.args if one is not numbers[0])
    return tree, (lower, upper)


def _without_limits(tree: Expression, names: set[str]) -> tuple[Expression, dict[str, tuple[float, float]]]:
    """Return a formula with names in place of names between limits, and these limits."""
    limits: dict[str, tuple[float, float]] = {}

    def freed(node: Expression) -> Expression:
        inner, ends = clamped(node)
        if isinstance(inner, Name) and inner.name in names:
            limits[inner.name] = ends
            return inner
        if isinstance(node, Call):
            return Call(node.function, tuple(freed(arg) for arg in node.args))
        return node

    return freed(tree), limits


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
    tree = tree.replaced({name: Name(word) for name, word in OWN.items()} | {driving: Name("u")})

    def at(one: Expression, place: Any) -> float:
        return float(one.value(dict(zip("xvu", map(float, place), strict=True))))

    by_x, by_v, by_u = (tree.derivative(name) for name in "xvu")
    zero = np.zeros(3)
    try:
        gain, offset, kp, kv = at(by_u, zero), at(tree, zero), -at(by_x, zero), -at(by_v, zero)
        gain_x, gain_v = (at(by_u.derivative(name), zero) for name in "xv")
        for x, v, u in PLACES:
            terms = np.array([gain * u, gain_x * x * u, gain_v * v * u, offset, -kp * x, -kv * v])
            if abs(at(tree, (x, v, u)) - terms.sum()) > ROUNDING * abs(terms).max():
                return None
    except (ModelError, ZeroDivisionError):
        return None
    return gain, gain_x, gain_v, offset, kp, kv
