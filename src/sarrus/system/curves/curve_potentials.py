"""Potential energies of elements with curves, such as springs with a law for their stiffness, at many times at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..._jit.formulas.expression import Expression, Graph
from ..._jit.formulas.replay import needed, replay
from ...algebra import Array
from ...elements.recorder import Variant, record_scalars
from ...model.laws.curve import Curve, Formula
from ..structure.population import Population
from .curve_derivatives import ORDERS, SIDE_BY_SIDE, curves_of, inputs_of
from .curve_integrals import Law, law_at, moments


class StoredCurve(NamedTuple):
    """A curve of the model, and the same as it is stored among parameters."""

    curve: Curve | Formula
    law: Law


@cache
def has_curve_potential(variant: Variant) -> bool:
    """Whether the potentials of elements depend on curves."""
    return "Curve" in variant.kind.fields.values() and callable(getattr(variant.kind, "potential", None))


def curve_potentials(
    populations: Iterable[Population], b: Array, memory: Mapping[int, Array], t: Array, q: Array
) -> Array:
    """The sum of the potentials that depend on curves (nt,). [J]

    Parameters
    ----------
    populations, b : the elements, and the parameters of the system
    memory : what elements remembered at each time (nt,), by place in b; others as in b
    t, q : (nt,), (nt, nq)
    """
    found = np.zeros(len(t))
    for p in populations:
        if p.count and has_curve_potential(p.variant):
            graph, wanted, order = _recorded(p.variant)
            inputs = inputs_of(p, b, memory, {"t": t, "q": q})
            for m, n in curves_of(p.kind):
                places = b[p.at + n + p.kind.size() * np.arange(p.count)].astype(int)
                pairs = zip(p.values, places, strict=True)
                inputs["numbers", n] = [StoredCurve(values[m], law_at(b, at)) for values, at in pairs]
            for value in replay(graph, wanted, inputs, OPERATIONS, order):
                found += np.broadcast_to(value, (p.count, len(t))).sum(axis=0)
    return found


@cache
def _recorded(variant: Variant) -> tuple[Graph, list[Expression], list[int]]:
    recording = record_scalars(variant, "potential")
    blocks = recording.outputs[0].blocks
    wanted = recording.graph.expressions(value for block in blocks for value in np.ravel(block))
    return recording.graph, wanted, needed(recording.graph, wanted)


def _derivative(name: str) -> Callable[[Sequence[StoredCurve], Any], Array]:
    return lambda stored, x: np.asarray(SIDE_BY_SIDE[name]([one.curve for one in stored], x))


def _moment(stored: Sequence[StoredCurve], a: Any, b: Any) -> Array:
    wide = np.broadcast(a, b).shape[-1] if np.ndim(a) or np.ndim(b) else 1
    limits = zip(stored, *(np.broadcast_to(x, (len(stored), wide)) for x in (a, b)), strict=True)
    return np.array([moments(one.law, lower, upper, 1) for one, lower, upper in limits])


OPERATIONS = SIDE_BY_SIDE | {
    **{name: _derivative(name) for name in ORDERS}, "curve_moment": _moment
}  # fmt: skip
