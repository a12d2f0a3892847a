"""Responses of a result that equations determine, and their derivatives, direct or adjoint: g' = g_y y' + g_b b'."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ....algebra import Array
from ....results import Gradient
from ....system import System
from ..chain.chain import Gradients
from ..parameters.parameters import Parameters
from ..responses.responses import AtEvent, Response
from .solved_states import KINDS, SolvedStates

AT = 1e-9  # of the duration of a result, within which a time is one of its own

Solved = Callable[[Array], SolvedStates]


class ResponseOfResult:
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
        self._found = response.evaluate(self._outputs)
        t = solved.states.t
        g = np.broadcast_to(np.asarray(self._found.value, dtype=float), t.shape)[rows]
        self.value = response.value(g, t[rows])
        self._weights = np.zeros(len(t))
        self._weights[rows] = response.weights(g, t[rows])

    def gradient(self) -> Array:
        """Its gradient by the parameters (p,), by one adjoint solution."""
        outputs, system = self._outputs, self._solved.system
        bars = outputs.tape.gradient({self._found.at: self._weights})
        by, modal = self._solved.zeros(), dict[Any, Any]()
        by_b, by_c = np.zeros((len(system.b), 1)), np.zeros((self._parameters.c_size, 1))
        for (kind, n), variable in outputs.inputs.items():
            bar = bars[variable.at]
            if kind in KINDS:
                getattr(by, kind)[:, n, 0] += bar
            elif kind in ("b", "c"):
                (by_b if kind == "b" else by_c)[n, 0] += np.sum(bar)
            else:
                modal[kind, n] = np.sum(bar)
        by_b += self._solved.through_modes(modal, by)
        by_b += self._solved.gradient(by)
        none = np.zeros((system.nq, 1))
        found = self._parameters.gradient(Gradients(by_b, none, none), by_c)[:, 0]
        own = {name: float(np.sum(bars[variable.at])) for name, variable in outputs.named.items()}
        return np.asarray(found + [own.get(name, 0.0) for name in self._parameters.names])

    def along(self, k: int, change: Any, db: Array, dc: Array) -> float:
        """Its change with parameter k, which changes the states, the numbers of elements (len(b), 1) and of joints."""
        outputs, moved = self._outputs, dict[int, Any]()
        keys = [key for key in outputs.inputs if key[0] not in (*KINDS, "b", "c")]
        modal = self._solved.modal_along(keys, change, db)
        for (kind, n), variable in outputs.inputs.items():
            if kind in KINDS:
                moved[variable.at] = getattr(change, kind)[:, n, 0]
            elif kind in ("b", "c"):
                moved[variable.at] = (db if kind == "b" else dc)[n, 0]
            else:
                moved[variable.at] = modal[kind, n]
        name = self._parameters.names[k]
        moved |= {variable.at: 1.0 for own, variable in outputs.named.items() if own == name}
        g_dot = outputs.tape.along(moved)[self._found.at]
        return float(self._weights @ np.broadcast_to(g_dot, self._weights.shape))


def gradient_of_result(
    system: System, name: str, t: Array, solved: Solved, responses: Sequence[Response], parameters: Parameters,
    method: str,
) -> Gradient:  # fmt: skip
    """The derivatives of responses of a result.

    Parameters
    ----------
    name : of the result, in messages
    t : (nt,) its times
    solved : gives its states at some of the times, by their places
    """
    rows = [_rows(response, t, name) for response in responses]
    chosen = np.unique(np.concatenate(rows))
    states = solved(chosen)
    every = [
        ResponseOfResult(response, states, np.searchsorted(chosen, own), parameters)
        for response, own in zip(responses, rows, strict=True)
    ]
    values, missing = np.array([one.value for one in every]), states.undefined(parameters)
    matrix = _direct(every, states, parameters, ~missing) if method == "direct" else None
    if matrix is None:
        matrix = np.array([one.gradient() for one in every])
    matrix[:, missing] = np.nan
    return Gradient(
        tuple(one.title for one in responses), tuple(parameters.names), values, parameters.values, matrix,
        response_units=tuple(one.unit(system) for one in responses), units=parameters.units,
    )  # fmt: skip


def _direct(
    every: Sequence[ResponseOfResult], states: SolvedStates, parameters: Parameters, chosen: Array
) -> Array:
    """One solution for each parameter; zero for those not chosen."""
    found = np.zeros((len(every), len(parameters.names)))
    b, _, _, c = parameters.along(np.eye(len(parameters.names)))
    for k in np.flatnonzero(chosen).tolist():
        db = np.ascontiguousarray(b[:, k : k + 1])
        change = states.along(db)
        found[:, k] = [one.along(k, change, db, c[:, k : k + 1]) for one in every]
    return found


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
