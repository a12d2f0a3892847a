"""Responses of a result that equations determine, and their derivatives, direct or adjoint: g' = g_y y' + g_b b'."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ....algebra import Array
from ....outputs import Outputs
from ....results import Gradient
from ....system import System
from ..chain.chain import Gradients, Nodes
from ..gradients import by_parameters, gradient_of
from ..parameters.parameters import Parameters
from ..responses.evaluation import DirectTerms, Evaluation
from ..responses.panels import Layout
from ..responses.responses import AtEvent, ExtremeValue, Integral, Response
from ..sampling.sampling import READ, Sampling
from ..steps.sweep import PerOperation
from .solved_states import Moves, SolvedStates, StatesAt

AT = 1e-9  # of the duration of a result, within which a time is one of its own

Solved = Callable[[Array], SolvedStates]


class ResponsesOfResult(Evaluation):
    """Responses of a result that equations determine: their values and outputs, and the derivatives of both.

    Parameters
    ----------
    system, name : of the result
    t : (nt,) its times
    solved : gives its states at some of the times, by their places
    responses : evaluated in this order
    parameters : by which they are differentiated
    """

    def __init__(
        self,
        system: System,
        name: str,
        t: Array,
        solved: Solved,
        responses: Sequence[Response],
        parameters: Parameters,
    ) -> None:
        rows = [_rows(response, t, name) for response in responses]
        chosen = np.unique(np.concatenate(rows))
        self.system, self._solved, self._asked = system, solved(chosen), responses
        where: Any = [np.searchsorted(chosen, own) for own in rows]
        super().__init__(system, self._solved.steps, responses, parameters, self._solved.angles, where)

    def _add(self, response: Response, where: Any) -> None:
        """Evaluate one more response at some of the states; an integral or extreme at samples of panels."""
        sampling, outputs, found = self._evaluated(response, StatesAt(self._solved, where))
        own, at = _in_panels(response, self._signal(sampling, found))
        if own is not response:
            sampling, outputs, found = self._evaluated(own, StatesAt(self._solved, where[at]))
        self._append(own, sampling, outputs, found)

    def _evaluated(
        self, response: Response, where: Sampling, sides: Sequence[Array] = ()
    ) -> tuple[Sampling, Outputs, Any]:
        outputs = self._outputs_at(where, sides)
        outputs.about = self._solved.about.result if self._solved.about else None
        return where, outputs, response.evaluate(outputs)

    def changes(self) -> list[Array]:
        """The derivatives of every output by the parameters (nt, p), by one solution for each; NaN without any."""
        parameters, states = self._parameters, self._solved
        every, undefined = np.eye(len(parameters.names)), states.undefined(parameters)
        moves = Moves(*parameters.along(every))
        dots = Nodes.zeros(self._steps, len(every))
        for k in np.flatnonzero(~undefined).tolist():
            change = states.along(moves.column(k))
            for kind in READ:
                getattr(dots, kind)[..., k] = getattr(change, kind)[..., 0]
        named = dict(zip(parameters.names, every, strict=True))
        found = self.signals_along(dots, moves.b, moves.c, named)
        for own in found:
            own[:, undefined] = np.nan
        return found

    def gradient(self, method: str = "adjoint") -> Gradient:
        """The responses with their derivatives.

        Raises
        ------
        UndefinedResponse
            For a response whose derivative is infinite.
        """
        nodes, explicit = self.gradients()
        columns = range(len(self._responses))
        if method == "direct":
            matrix = np.array(
                [self._weights(n) @ own for n, own in zip(columns, self.changes(), strict=True)]
            )
        else:
            each = [self._solved.gradient(nodes.column(n)) for n in columns]
            by = Gradients(*(np.concatenate(x, axis=1) for x in zip(*each, strict=True)))
            matrix = by_parameters(by, self._parameters, explicit)
        undefined = self._solved.undefined(self._parameters)
        return gradient_of(self._asked, self._parameters, self.values, matrix, undefined)

    def _with_reported(self, dots: Nodes, b: Array) -> Nodes:
        return replace(dots, lam=self._reported.along(dots, b, self._reported.times(dots.shift)))

    def _collected(
        self, n: int, bars: list[Any], nodes: Nodes, k: int, *sources: PerOperation
    ) -> tuple[Nodes, DirectTerms]:
        """See `Evaluation`; also those by what is derived from a single state."""
        nodes, explicit = super()._collected(n, bars, nodes, k, *sources)
        inputs = self._outputs[n].inputs.items()
        derived = {key: np.sum(bars[x.at]) for key, x in inputs if key[0] not in (*READ, "b", "c")}
        moves = self._solved.through_derived(derived, nodes.column(k))
        explicit.b[:] += moves.b
        explicit.c[: len(moves.c)] += moves.c
        return nodes, explicit


def _in_panels(response: Response, g: Array) -> tuple[Response, Array]:
    """A response between the times of a result, and at which of them it is sampled: linear or about an extreme."""
    if isinstance(response, Integral):
        return replace(response, layout=Layout(size=2)), np.repeat(np.arange(len(g)), 2)[1:-1]
    if isinstance(response, ExtremeValue):
        size = min(3, len(g))
        first = int(np.clip(response.outermost(g) - 1, 0, len(g) - size))
        return replace(response, layout=Layout(size=size)), first + np.arange(size)
    return response, np.arange(len(g))


def _rows(response: Response, t: Array, name: str) -> Array:
    """The places of the times at which a response is taken.

    Raises
    ------
    ValueError
        For times that the result does not have, and responses over time of a single state.
    """
    if isinstance(response, AtEvent):
        raise ValueError(f"{response.title}: {name} has no events. Use At(...) with a time.")
    if len(t) == 1 and not response.pointwise:
        raise ValueError(f"{response.title}: {name} is one state without a history. Use Final(...).")
    wanted = response.times(t)
    if wanted is None:
        return np.arange(len(t))
    places = np.clip(np.searchsorted(t, wanted), 1, max(len(t) - 1, 1))
    places = places - (abs(wanted - t[places - 1]) <= abs(wanted - t[np.minimum(places, len(t) - 1)]))
    gaps = abs(wanted - t[places])
    if len(gaps) and gaps.max() > AT * max(float(np.ptp(t)), abs(t).max()):
        time = np.asarray(wanted)[np.argmax(gaps)]
        raise ValueError(f"{response.title}: {name} has no state at {time:g} s. Add this time to its times.")
    return np.asarray(places)
