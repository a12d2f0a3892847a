"""Motors and servos of a description, as forces by formulas, with first-order states for their activation."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from ....model import Force, Input, Muscle, MuscleActivation, PointForce, StateVariable, Tendon, Torque
from ....model.errors import ModelError, restated
from ....model.forces import Force as BaseForce
from ....model.geometry.points import GROUND
from ....model.quantity import triple
from ....model.show import quote, show
from ..description import Activation, Actuator, Contraction, MuscleDynamics, Path, Wrench
from ..tree.coordinates import Coordinates

REMEDY = 'Import it with ignore=["actuators"].'
TERMS = {
    "gain": "+ gain*{u}",
    "gain_x": "{along} gain_x*x*{u}",
    "gain_v": "{along} gain_v*v*{u}",
    "offset": "+ offset",
    "kp": "{against} kp*x",
    "kv": "{against} kv*v",
}
PARAMETERS = (*TERMS, "time", "lower", "upper", "arrest")  # of formulas of actuators


def actuator_forces(
    name: str, actuator: Actuator, coordinates: Coordinates, control: Input
) -> Iterator[BaseForce]:
    """Yield the force of an actuator and its activation; nothing if what it acts on does not move.

    Its `control` is an input of the model.

    Raises
    ------
    ModelError
        If the control is neither a number nor a formula of the time, or the motion is no rotation or slide.
    """
    if not isinstance(control.value, str | int | float):
        message = f"its control must be a number or a formula of t, got {show(control.value)}"
        raise ModelError(f"{message}. Give one of them.", part=f"actuator {quote(name)}", field="controls")
    u, states = _between(control.name, actuator.controls), list[BaseForce]()
    if actuator.activation is not None:
        states = [_state(name, actuator.activation, u)]
        u = states[0].name
    with restated(part=f"actuator {quote(name)}"):
        forces = list(_forces(name, actuator, coordinates, u))
    yield from [*states, *forces] if forces else ()


def _forces(name: str, given: Actuator, coordinates: Coordinates, u: str) -> Iterator[BaseForce]:
    if isinstance(given.on, Wrench):
        yield from _wrench(name, given, given.on, coordinates, u)
    elif given.contraction is not None:
        assert isinstance(given.on, Path)
        yield from _muscle(name, given.contraction, given.on, coordinates, u)
    elif isinstance(given.on, str):
        if given.on in coordinates.edges:
            coordinate = coordinates.find(given.on, REMEDY)
            kind: Any = Torque if coordinate.rotates else Force
            value = _value(given, u, coordinate.sign)
            value = value if coordinate.sign > 0 else f"-({value})"
            yield kind(name, joint=coordinate.name, value=value, parameters=_parameters(given))
    else:
        route = coordinates.lay(given.on, REMEDY)
        if route is not None:
            start = given.on.start - route.start
            given = given._replace(
                gain=given.gain - given.gain_x * start, offset=given.offset + given.kp * start
            )
            yield Tendon(name, **route.fields, value=_value(given, u, 1.0), parameters=_parameters(given))


def _muscle(
    name: str, given: Contraction, path: Path, coordinates: Coordinates, activation: str
) -> Iterator[BaseForce]:
    """Yield a muscle along a path, the length of which is longer than x."""
    route = coordinates.lay(path, REMEDY)
    if route is not None:
        given = given._replace(tendon_length=given.tendon_length - route.start)
        yield Muscle(name, **route.fields, activation=activation, **given._asdict())


def _wrench(name: str, given: Actuator, on: Wrench, coordinates: Coordinates, u: str) -> Iterator[BaseForce]:
    """Yield a force and a torque that act on a link."""
    link = coordinates.links.get(on.link)
    if link is None or link.body.name == GROUND:
        return
    turn = link.place.A if on.axes == "body" else np.eye(3)
    force, torque = (triple(turn @ np.array(vector)) for vector in (on.force, on.torque))
    value = _value(given, u, 1.0)
    options: dict[str, Any] = {"axes": on.axes, "factor": value, "parameters": _parameters(given)}
    if any(force):
        yield PointForce(name, link.point(*on.point), force, **options)
    if any(torque):
        ending = "_torque" if any(force) else ""
        yield Torque(f"{name}{ending}", link.body, torque, **options)


def _parameters(actuator: Actuator) -> dict[str, float]:
    """Return the coefficients of an actuator's terms that are not 0."""
    return {word: getattr(actuator, word) for word in TERMS if getattr(actuator, word)}


def _value(actuator: Actuator, u: str, sign: float) -> str:
    """Return the formula of a force in terms of a coordinate with this sign."""
    along, against = ("+", "-") if sign > 0 else ("-", "+")
    text = " ".join(TERMS[word].format(u=u, along=along, against=against) for word in _parameters(actuator))
    return _between(text.removeprefix("+ ") or "0", actuator.forces)


def _state(name: str, activation: Activation | MuscleDynamics, u: str) -> StateVariable | MuscleActivation:
    """Return the activation: that of a muscle, the integral of the control, or a lag, which stops at limits."""
    if isinstance(activation, MuscleDynamics):
        return MuscleActivation(activation_name(name), input=u, **activation._asdict())
    lag = activation.time > 0
    rate = f"({u} - x)/time" if lag else u
    parameters = {"time": activation.time} if lag else {}
    if math.isfinite(activation.upper):
        parameters |= {"lower": activation.lower, "upper": activation.upper, "arrest": activation.arrest}
        rate = f"max(min({rate}, (upper - x)/arrest), (lower - x)/arrest)"
    return StateVariable(activation_name(name), rate=rate, initial=activation.start, parameters=parameters)


def activation_name(actuator: str) -> str:
    """Return the name of an actuator's activation."""
    return re.sub(r"\W", "_", f"{actuator}_activation")


def _between(text: str, limits: tuple[float, float]) -> str:
    """Return a formula with limits."""
    lower, upper = limits
    if math.isfinite(upper):
        text = f"min({text}, {upper!r})"
    return f"max({text}, {lower!r})" if math.isfinite(lower) else text
