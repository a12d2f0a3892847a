"""Derivatives of accelerations and multipliers by parameters, and of multipliers of minimum norm, at one state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ...outputs.recording import States
from ...system import System
from ...system.curves.curve_derivatives import CurveDerivatives
from ..sensitivity.chain.start import Start
from ..sensitivity.implicit.solved_states import as_steps
from ..sensitivity.parameters.parameters import Parameters
from ..sensitivity.sampling.reported import Changes, Place, Reported


def parameter_changes(system: System, names: str | Sequence[str], own: bool) -> Array:
    """The derivatives of the elements' parameters b by those that are named (len(b), p).

    Parameters
    ----------
    own : whether b differs from that of the system, of which only the elements' own parameters are known

    Raises
    ------
    SarrusError
        For unknown parameters, and for those of the model if `own`.
    """
    names = [names] if isinstance(names, str) else names
    if not len(names):
        return np.zeros((len(system.b), 0))
    for name in names if own else ():
        if name not in system.parameter_names:
            raise SarrusError(
                f"{system.name}: {name} is no parameter of an element. Leave out b, or name parameters of "
                "system.parameter_names."
            )
    parameters = Parameters(system, names)
    return parameters.along(np.eye(len(parameters.names)))[0]


class StateChanges:
    """Changes of a and λ at one state.

    Parameters
    ----------
    system : System
    state : t, q, v, and the a and λ that belong to them
    b : parameters of the elements
    rows : of independent constraints; None if all are
    """

    def __init__(
        self, system: System, state: tuple[float, Array, Array, Array, Array], b: Array, rows: Array | None
    ) -> None:
        (t, q, v, a, lam), left_out = state, np.zeros((1, system.m), dtype=bool)
        if rows is not None:
            left_out[0] = True
            left_out[0, rows] = False
        states = States(np.array([t]), q[None], v[None], a[None], lambda: lam[None])
        self._system = system
        self._steps = as_steps(system, states, b[system.memory_places][None], b, left_out)
        self._minimum = Reported(system, self._steps, moving=False).slopes(Place(0, 0))

    def by_parameters(self, changes: Array) -> Array:
        """The derivatives of a and λ (nq + m, k) for changes of b (len(b), k) at constant q and v."""
        still = np.zeros((self._system.nq, changes.shape[1]))
        a, lam = Start(self._system, self._steps, CurveDerivatives(self._system)).along(still, still, changes)
        return np.vstack([a, self.reported(still, changes, lam)])

    def reported(self, q: Array, b: Array, lam: Array) -> Array:
        """The changes of the multipliers of minimum norm (m, k), for those of any."""
        if self._minimum is None:
            return lam
        return self._minimum.along(Changes(q, b, np.zeros(q.shape[1])), lam)
