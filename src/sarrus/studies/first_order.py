"""How uncertain responses are, to first order: from one run and one adjoint sweep, beside thousands of random runs.

With independent parameters of mean μ_i and standard deviation σ_i a response R has about the mean R(μ) and the variance
Σ (∂R/∂μ_i σ_i)². It is what Monte Carlo converges to where R is nearly linear over the spread of the parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ..analyses import At, Final, Integral, assemble, sensitivity, simulate
from ..analyses.sensitivity import Response as Differentiable
from ..analyses.sensitivity.outputs import UnknownOutput
from ..model import Expression, Model, SarrusError
from ..model.expression import Call, Name, Number
from ..model.expression.tree import call
from ..results import Trajectory
from ..system import System
from .conduct import Asked, ask
from .parameters import Array, Distribution, Parameter, Range, Values
from .responses import Response, reductions
from .runs import Simulation
from .samples import Listed


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Means and standard deviations of responses, to first order.

    Attributes
    ----------
    parameters, responses : names
    values : (r,) the responses at the means of the parameters
    matrix : (r, p) their derivatives there
    deviations : (p,) standard deviations of the parameters
    std : (r,) of the responses
    """

    parameters: tuple[str, ...]
    responses: tuple[str, ...]
    values: Array = field(repr=False)
    matrix: Array = field(repr=False)
    deviations: Array = field(repr=False)

    @property
    def std(self) -> Array:
        """√(Σ (∂R/∂μ_i σ_i)²) (r,)."""
        return np.asarray(np.sqrt(np.sum((self.matrix * self.deviations) ** 2, axis=1)))

    @property
    def shares(self) -> Array:
        """The part of each parameter in the variance of each response (r, p), rows with the sum 1."""
        parts = (self.matrix * self.deviations) ** 2
        whole = parts.sum(axis=1, keepdims=True)
        return np.asarray(parts / np.where(whole > 0, whole, 1.0))

    def __str__(self) -> str:
        width = max([8, *(len(name) for name in self.responses)])
        lines = [f"{'response':<{width}}{'mean':>14}{'std':>14}  parts in the variance"]
        for name, mean, std, parts in zip(self.responses, self.values, self.std, self.shares, strict=True):
            order = [k for k in np.argsort(-parts, kind="stable") if parts[k] > 0.005][:4]
            told = ", ".join(f"{self.parameters[k]} {100 * parts[k]:.0f} %" for k in order)
            lines.append(f"{name:<{width}}{mean:>14.6g}{std:>14.6g}  {told}")
        return "\n".join(lines)


def uncertainty(
    model: Model | System, parameters: Mapping[str, Any], responses: Any, *, analysis: Simulation
) -> Uncertainty:
    """Propagate the spread of parameters to responses of a simulation, to first order, by exact derivatives.

    Parameters
    ----------
    model, parameters, responses : as for `study`; responses are formulas. A maximum or minimum is differentiated at the
        time at which it is met.
    analysis : a `Simulation` by `HHT` or `GeneralizedAlpha`

    Returns
    -------
    Uncertainty

    Raises
    ------
    SarrusError
        For what cannot be meant, and if the run fails.
    """
    if not isinstance(analysis, Simulation):
        raise SarrusError("uncertainty is propagated through a Simulation; for other analyses use study")
    return uncertainty_of(ask(model, parameters, responses, analysis=analysis, sample=Listed(())))


def uncertainty_of(asked: Asked) -> Uncertainty:
    """The same for a study that was checked."""
    run = asked.task.run
    if not isinstance(run, Simulation):
        raise SarrusError("uncertainty is propagated through a simulation; this study has another analysis")
    moments = np.array([_moments(one) for one in asked.parameters.values()]).reshape(-1, 2)
    names = tuple(asked.parameters)
    system, start = asked.task.source.made(dict(zip(names, moments[:, 0], strict=True)))
    begin = assemble(system, start.q, start.v)
    steps = {name: getattr(run, name) for name in ("method", "rtol", "atol", "max_step")}
    motion = simulate(system, begin, until=run.until, keep_steps=True, **steps)
    if not motion.success:
        raise SarrusError(motion.message)
    parts = [_parts(response, motion) for response in asked.task.responses]
    values, matrix = _chained(parts, motion, names)
    titles = tuple(response.name for response in asked.task.responses)
    return Uncertainty(names, titles, values, matrix, moments[:, 1])


def _moments(parameter: Parameter) -> tuple[float, float]:
    """Mean and standard deviation."""
    if isinstance(parameter, Distribution):
        frozen = parameter.frozen()
        return float(frozen.mean()), float(frozen.std())
    if isinstance(parameter, Values):
        return float(np.mean(parameter.values)), float(np.std(parameter.values))
    if isinstance(parameter, Range) and not parameter.log:
        return (parameter.low + parameter.high) / 2, (parameter.high - parameter.low) / 12**0.5
    x = parameter.at((np.arange(4096) + 0.5) / 4096)
    return float(x.mean()), float(x.std())


class _Parts(NamedTuple):
    """A formula of responses that can be differentiated: each stands in it under a name."""

    outer: Expression
    inner: dict[str, Differentiable]


def _parts(response: Response, run: Trajectory) -> _Parts:
    if not isinstance(response.of, str):
        raise SarrusError(
            f"response {response.name!r} is a function, whose derivatives are unknown; give a formula"
        )
    inner: dict[str, Differentiable] = {}
    made: dict[Expression, Expression] = {}
    tree = response.tree(run.t)
    reduced = reductions(run.t)
    for node in tree.nodes():
        if isinstance(node, Call) and node.function.name in reduced and node.function.partials is UNKNOWN:
            made[node] = _reduced(node, run, inner)
        elif isinstance(node, Call):
            made[node] = Call(node.function, tuple(made[arg] for arg in node.args))
        elif isinstance(node, Name):
            made[node] = _standing(Final(_function(node)), inner)
        else:
            made[node] = node
    return _Parts(made[tree], {name: inner[name] for name in made[tree].names()})


UNKNOWN = reductions(np.zeros(1))["final"].partials


def _standing(response: Differentiable, inner: dict[str, Differentiable]) -> Name:
    name = f"part{len(inner)}"
    inner[name] = response
    return Name(name)


def _reduced(node: Call, run: Trajectory, inner: dict[str, Differentiable]) -> Expression:
    """A reduction as a response that can be differentiated."""
    word, of = node.function.name, node.args[0]
    if any(isinstance(one, Call) and one.function.partials is UNKNOWN for one in of.nodes()):
        raise SarrusError(f"{node} has a reduction in a reduction, which cannot be differentiated here")
    span = Number(float(run.t[-1] - run.t[0]))
    if word in ("integral", "mean"):
        whole = _standing(Integral(_function(of)), inner)
        return whole if word == "integral" else whole / span
    if word == "rms":
        return call("sqrt", _standing(Integral(_function(of * of)), inner) / span)
    if word == "final":
        return _standing(Final(_function(of)), inner)
    return _standing(At(_function(of), time=_time(node, run)), inner)


def _time(node: Call, run: Trajectory) -> float:
    """When a value is taken, or met."""
    if node.function.name == "initial":
        return float(run.t[0])
    if node.function.name == "at":
        return float(node.args[1].value())
    g = _history(node.args[0], run)
    return float(run.t[int(np.argmax(g) if node.function.name == "max" else np.argmin(g))])


def _history(of: Expression, run: Trajectory) -> Array:
    from .runs import lookup_of

    lookup = lookup_of(run.system, run)
    return np.broadcast_to(np.asarray(of.value({name: lookup(name) for name in of.names()})), run.t.shape)


def _function(of: Expression) -> Callable[[Any], Any]:
    """A formula as a function of `Outputs`."""

    def evaluate(outputs: Any) -> Any:
        return of.value({name: _output(outputs, name) for name in of.names()})

    return evaluate


def _output(outputs: Any, name: str) -> Any:
    try:
        return outputs(name)
    except UnknownOutput:
        return outputs.parameter(name)


def _chained(parts: list[_Parts], run: Trajectory, names: tuple[str, ...]) -> tuple[Array, Array]:
    """Values (r,) and derivatives (r, p), by one sweep for all parts of all formulas."""
    every = [response for one in parts for response in one.inner.values()]
    gradient = sensitivity(run, every, list(names))
    values, rows, first = [], [], 0
    for one in parts:
        count = len(one.inner)
        env = dict(zip(one.inner, gradient.values[first : first + count].tolist(), strict=True))
        slopes = [float(one.outer.derivative(name).value(env)) for name in one.inner]
        values.append(float(one.outer.value(env)))
        rows.append(np.array(slopes) @ gradient.matrix[first : first + count])
        first += count
    return np.array(values), np.array(rows).reshape(len(parts), len(names))
