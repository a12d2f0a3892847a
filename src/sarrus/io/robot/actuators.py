"""Motors and servos of a description, as forces by formulas."""

from __future__ import annotations

import math
from typing import Any

from ...model import Force, Torque
from ...model.errors import ModelError
from ...model.geometry.motion import Turn
from ...model.show import quote, show
from .description import Actuator, Edge
from .joints import coordinate_of

CONTROL = "u"
TERMS = {"gain": "+ gain*{u}", "offset": "+ offset", "kp": "{against} kp*x", "kv": "{against} kv*v"}


def actuator_force(name: str, joint: str, edge: Edge, given: Actuator, control: Any) -> Force:
    """Return the force of an actuator that acts on a motion of an edge, whose joint has this name.

    Raises
    ------
    ModelError
        If the control is neither a number nor a formula of the time, or the motion is no rotation or slide.
    """
    found = coordinate_of(edge.motions, given.joint)
    if found is None:
        message = f"acts on {quote(given.joint)}, which neither rotates about one axis nor slides along one"
        raise ModelError(f'{message}. Import it with ignore=["actuators"].', part=f"actuator {quote(name)}")
    coordinate, sign = found
    kind = Torque if isinstance(_motion(edge, given.joint), Turn) else Force
    parameters = {word: getattr(given, word) for word in TERMS if getattr(given, word)}
    if isinstance(control, str):
        control = f"({control})"
    elif isinstance(control, int | float):
        parameters[CONTROL], control = float(control), CONTROL
    else:
        message = f"its control must be a number or a formula of t, got {show(control)}"
        raise ModelError(f"{message}. Give one of them.", part=f"actuator {quote(name)}", field="controls")
    against = "-" if sign > 0 else "+"
    u = _between(control, given.controls)
    terms = (TERMS[word].format(u=u, against=against) for word in TERMS if word in parameters)
    value = _between(" ".join(terms).lstrip("+ ") or "0", given.forces)
    value = value if sign > 0 else f"-({value})"
    return kind(name, joint=f"{joint}.{coordinate}", value=value, parameters=parameters)


def _motion(edge: Edge, name: str) -> Any:
    return next(motion for motion in edge.motions if motion.name == name)


def _between(text: str, limits: tuple[float, float]) -> str:
    """Return a formula with limits."""
    lower, upper = limits
    if math.isfinite(upper):
        text = f"min({text}, {upper!r})"
    return f"max({text}, {lower!r})" if math.isfinite(lower) else text
