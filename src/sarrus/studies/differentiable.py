"""Formulas of responses, ``max(slider.x) - min(slider.x)``, as responses whose derivatives are exact."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..analyses import At, Combined, Final, Integral, Maximum, Minimum
from ..analyses.sensitivity import Response as Differentiable
from ..model import Expression, SarrusError
from ..model.expression import Call, Name, Number
from ..model.expression.tree import call
from .responses import Response, reductions

REDUCED = reductions(np.zeros(1))
UNKNOWN = REDUCED["final"].partials


def differentiable(response: Response, until: float, begin: float = 0.0) -> Combined:
    """The same response for `sensitivity`, `Problem` and `optimize`.

    Parameters
    ----------
    response : a formula
    until, begin : end and begin of the run [s]

    Raises
    ------
    SarrusError
        For a Python function, for a reduction in a reduction, and for a formula without any output.
    """
    if not isinstance(response.of, str):
        raise SarrusError(
            f"response {response.name!r} is a function, whose derivatives are unknown; give a formula"
        )
    inner: dict[str, Differentiable] = {}
    made: dict[Expression, Expression] = {}
    tree = response.tree(np.zeros(1))
    for node in tree.nodes():
        if isinstance(node, Call) and node.function.partials is UNKNOWN:
            made[node] = _reduced(node, until, begin, inner)
        elif isinstance(node, Call):
            made[node] = Call(node.function, tuple(made[arg] for arg in node.args))
        elif isinstance(node, Name):
            made[node] = _standing(Final(_function(node)), inner)
        else:
            made[node] = node
    whole, names = made[tree], made[tree].names()
    if not inner:
        raise SarrusError(
            f"response {response.name!r} names no output of the motion; name one, such as max(slider.x)"
        )
    return Combined(
        lambda *values: whole.value(dict(zip(names, values, strict=True))),
        [inner[name] for name in names],
        name=response.name,
    )


def _standing(response: Differentiable, inner: dict[str, Differentiable]) -> Name:
    name = f"part{len(inner)}"
    inner[name] = response
    return Name(name)


def _reduced(node: Call, until: float, begin: float, inner: dict[str, Differentiable]) -> Expression:
    """A reduction as a formula of responses that can be differentiated."""
    word, of = node.function.name, node.args[0]
    if any(isinstance(one, Call) and one.function.partials is UNKNOWN for one in of.nodes()):
        raise SarrusError(f"{node} has a reduction in a reduction, which cannot be differentiated here")
    span, g = Number(until - begin), _function(of)
    if word in ("integral", "mean"):
        whole = _standing(Integral(g), inner)
        return whole if word == "integral" else whole / span
    if word == "rms":
        return call("sqrt", _standing(Integral(_function(of * of)), inner) / span)
    if word == "at":
        return _standing(At(g, time=float(node.args[1].value())), inner)
    if word == "initial":
        return _standing(At(g, time=begin), inner)
    kinds: dict[str, Any] = {"final": Final, "max": Maximum, "min": Minimum}
    return _standing(kinds[word](g), inner)


def _function(of: Expression) -> Callable[[Any], Any]:
    """A formula as a function of `Outputs`."""

    def evaluate(outputs: Any) -> Any:
        return of.value({name: outputs.output_or_parameter(name) for name in of.names()})

    return evaluate
