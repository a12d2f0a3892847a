"""Responses of a result that equations determine, and their derivatives, direct or adjoint: g' = g_y y' + g_b b'."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ....algebra import Array
from ....results import Gradient
from ....system import System
from ..chain.chain import Gradients
from ..parameters.parameters import Parameters
from ..responses.panels import Layout
from ..responses.responses import AtEvent, ExtremeValue, Integral, Response
from ..responses.undefined import along_with_weight, gradient_of
from ..steps.sweep_loop import NodeArrays
from .solved_states import KINDS, Moves, SolvedStates

AT = 1e-9  # of the duration of a result, within which a time is one of its own

Solved = Callable[[Array], SolvedStates]


class ResponsesOfResult:
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
        self.system, self._responses, self._parameters = system, responses, parameters
        rows = [_rows(response, t, name) for response in responses]
        chosen = np.unique(np.concatenate(rows))
        self._states = solved(chosen)
        self._every = [
            _Response(response, self._states, np.searchsorted(chosen, own), parameters)
            for response, own in zip(responses, rows, strict=True)
        ]

    @property
    def values(self) -> Array:
        """The responses (r,)."""
        return np.array([one.value for one in self._every])

    @property
    def signals(self) -> list[Array]:
        """The output of every response at its times (nt,)."""
        return [one.signal for one in self._every]

    def signals_along(self) -> list[Array]:
        """Their derivatives by the parameters (nt, p), by one solution for each; NaN for those without any."""
        states, parameters = self._states, self._parameters
        every = parameters.along(np.eye(len(parameters.names)))
        found = [np.zeros((len(one.signal), len(parameters.names))) for one in self._every]
        undefined = states.undefined(parameters)
        for k in np.flatnonzero(~undefined).tolist():
            moves = Moves._make(np.ascontiguousarray(x[:, k : k + 1]) for x in every)
            change = states.along(moves)
            for own, one in zip(found, self._every, strict=True):
                own[:, k] = one.along(k, change, moves)
        for n, one in enumerate(self._every):
            found[n] = along_with_weight(found[n], one.weights == 0.0, one.bars)
            found[n][:, undefined] = np.nan
        return found

    def gradient(self, method: str = "adjoint") -> Gradient:
        """The responses with their derivatives.

        Raises
        ------
        UndefinedResponse
            For a response whose derivative is infinite.
        """
        bars = [one.bars() for one in self._every]
        if method == "direct":
            along = zip(self._every, self.signals_along(), strict=True)
            matrix = np.array([one.weights @ moved for one, moved in along])
        else:
            matrix = np.array([one.gradient(own) for one, own in zip(self._every, bars, strict=True)])
            matrix[:, self._states.undefined(self._parameters)] = np.nan
        system, parameters, responses = self.system, self._parameters, self._responses
        return Gradient(
            tuple(one.title for one in responses), tuple(parameters.names), self.values, parameters.values, matrix,
            response_units=tuple(one.unit(system) for one in responses), units=parameters.units,
        )  # fmt: skip


class _Response:
    """One response: its value, and its gradients by the states and the parameters.

    Parameters
    ----------
    response : Response
    solved : the states
    rows : of the states, at which it is taken
    parameters : Parameters
    """

    def __init__(self, response: Response, solved: SolvedStates, rows: Array, parameters: Parameters) -> None:
        self._solved, self._parameters = solved, parameters
        self._outputs = solved.outputs(parameters)
        self._found, self._title = response.evaluate(self._outputs), response.title
        t = solved.states.t
        self._rows = rows
        self.signal = np.broadcast_to(np.asarray(self._found.value, dtype=float), t.shape)[rows]
        response, at = _in_panels(response, self.signal)
        g, t = self.signal[at], t[rows][at]
        self.value = response.value(g, t)
        weights = response.weights(g, t)
        self.weights = np.zeros(len(rows))
        np.add.at(self.weights, at, weights)
        self._vanishing = np.zeros(len(rows), dtype=bool)
        np.logical_or.at(self._vanishing, at, response.vanishing_weights(g, t, weights))

    def bars(self) -> list[Any]:
        """Its gradient by the entries of its tape."""
        weights = self._placed(self.weights)
        return gradient_of(
            self._title,
            self._outputs,
            self._found,
            weights,
            vanishing=lambda: self._placed(self._vanishing),
        )

    def _placed(self, given: Array) -> Array:
        """Numbers of its times among all states."""
        found = np.zeros(len(self._solved.states.t), dtype=given.dtype)
        found[self._rows] = given
        return found

    def gradient(self, bars: list[Any]) -> Array:
        """Its gradient by the parameters (p,), by one adjoint solution."""
        outputs, system = self._outputs, self._solved.system
        by, derived = self._solved.zeros(), dict[Any, Any]()
        by_b, by_c = np.zeros((len(system.b), 1)), np.zeros((self._parameters.c_size, 1))
        for (kind, n), variable in outputs.inputs.items():
            bar = bars[variable.at]
            if kind in KINDS:
                getattr(by, kind)[:, n, 0] += bar
            elif kind in ("b", "c"):
                (by_b if kind == "b" else by_c)[n, 0] += np.sum(bar)
            else:
                derived[kind, n] = np.sum(bar)
        through = self._solved.through_derived(derived, by)
        found = Moves._make(map(np.add, through, self._solved.gradient(by)))
        by_b += found.b
        by_c[: len(found.c)] += found.c
        whole = self._parameters.gradient(Gradients(by_b, found.q, found.v), by_c)[:, 0]
        own = {name: float(np.sum(bars[variable.at])) for name, variable in outputs.named.items()}
        return np.asarray(whole + [own.get(name, 0.0) for name in self._parameters.names])

    def along(self, k: int, change: NodeArrays, moves: Moves) -> Array:
        """The change of its output with parameter k, which changes the states and what they depend on."""
        outputs, moved = self._outputs, dict[int, Any]()
        keys = [key for key in outputs.inputs if key[0] not in (*KINDS, "b", "c")]
        derived = self._solved.derived_along(keys, change, moves)
        for (kind, n), variable in outputs.inputs.items():
            if kind in KINDS:
                moved[variable.at] = getattr(change, kind)[:, n, 0]
            elif kind in ("b", "c"):
                moved[variable.at] = getattr(moves, kind)[n, 0]
            else:
                moved[variable.at] = derived[kind, n]
        name = self._parameters.names[k]
        moved |= {variable.at: 1.0 for own, variable in outputs.named.items() if own == name}
        with np.errstate(divide="ignore", invalid="ignore"):  # what is infinite has no weight, or is refused
            g_dot = outputs.tape.along(moved)[self._found.at]
        return np.broadcast_to(g_dot, self._solved.states.t.shape)[self._rows]


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
