"""Reductions of an output over time to one number, ``max(slider.x)``: they make responses of outputs."""

from __future__ import annotations

from typing import Any, TypeGuard

from ..model import SarrusError
from ..model.expression import Call, Expression
from ..model.expression.tree import Function

ERROR = "error"  # error(max(x)): the estimated error of a response, see `Trajectory.error`
COUNTS = {"final": 1, "initial": 1, "at": 2, "min": 1, "max": 1, "mean": 1, "rms": 1, "integral": 1, ERROR: 1}


def _no_partials(*args: Expression) -> tuple[Expression, ...]:
    raise SarrusError("a reduction over time has no derivative as a formula. Use sensitivity().")


def reduction(name: str, value: Any = None) -> Function:
    """The reduction of a name as a function of formulas; its value is that of a history."""
    return Function(name, (COUNTS[name],), value, _no_partials)


REDUCTIONS = {name: reduction(name) for name in COUNTS}


def is_reduction(node: Expression) -> TypeGuard[Call]:
    """Whether a node of a formula is a reduction over time."""
    return isinstance(node, Call) and node.function.partials is _no_partials
