"""Second derivatives of the equations of motion in independent coordinates, contracted: Hessians of ẋ and y."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ...model.announcement import reports_warnings
from ...model.show import suggest
from ...outputs.motion import states_of
from ...results import StateSpace
from ...system import System
from ..equilibria.balance import input_changes
from ..equilibria.linear_loop import Maps
from ..equilibria.state_space import plan_of
from ..sensitivity.implicit.recorded_outputs import RecordedOutputs, weighted
from ..sensitivity.implicit.solved_states import Slopes
from .independent_hessian import IndependentHessian


@reports_warnings
def state_hessian(plant: StateSpace, weights: Mapping[str, float]) -> Array:
    """Compute the second derivatives of a weighted sum of rates of states and of outputs, by states and inputs.

    With ẋ = f(x, u) and y = g(x, u) in the independent coordinates of a linearization, the result is the Hessian of
    w·f + z·g by [x; u] at its state, exact, and symmetric to round-off.

    Parameters
    ----------
    plant : from `linearize`
    weights : by name; a state means its rate, other names outputs of the linearization:
        ``{"pin.angle.rate": 1.0}`` is the Hessian of the angular acceleration

    Returns
    -------
    Array
        (nx + nu, nx + nu), in the order of `StateSpace.states` and `StateSpace.inputs`

    Raises
    ------
    SarrusError
        For names that the linearization does not have, and a linearization without its system.
    """
    if plant.system is None:
        raise SarrusError(
            f"{plant.name}: this linearization does not know its system. Use that of `linearize`."
        )
    of_rates, of_outputs = _by_place(plant, weights)
    system, n = plant.system, (len(plant.states) - len(plant.system.states)) // 2
    independent = plan_of(system, plant.states[:n], plant.inputs).independent
    hessian = IndependentHessian(system.forward_dynamics, independent, plant.inputs)
    outputs = _Outputs(plant, system, of_outputs)
    by = outputs.gradient
    for to, slopes in zip(hessian.adjoint, (by.q, by.v, by.a), strict=False):
        to[:] = slopes
    bent = hessian(plant.q, plant.v, np.concatenate([of_rates, by.lam]), plant.t, b=system.b)
    return bent + outputs.hessian(hessian.plan.maps, plant.inputs)


def _by_place(plant: StateSpace, weights: Mapping[str, float]) -> tuple[Array, Array]:
    """The weights of the rates of states (nx,) and of the outputs (ny,)."""
    mapping: object = weights
    if not isinstance(mapping, Mapping) or not all(isinstance(x, int | float) for x in mapping.values()):
        raise TypeError(
            f"weights must be numbers by name, got {weights!r}. Pass a mapping such as {{'pin.angle.rate': 1.0}}."
        )
    names, by_place = (*plant.states, *plant.outputs), np.zeros(len(plant.states) + len(plant.outputs))
    for name, weight in weights.items():
        if name not in names:
            raise SarrusError(f"{plant.name}: no state and no output is named {name}. {suggest(name, names)}")
        by_place[names.index(name)] += float(weight)
    return by_place[: len(plant.states)], by_place[len(plant.states) :]


class _Outputs:
    """A weighted sum of outputs: its gradient, and its second derivatives at constant derivatives of the state."""

    def __init__(self, plant: StateSpace, system: System, weights: Array) -> None:
        self._recorded = RecordedOutputs(system, states_of(plant), plant.outputs if weights.any() else ())
        self._bars = weighted((self._recorded.outputs, weights)) if weights.any() else {}
        self._system = system
        self.gradient = self._recorded.gradient(self._bars)

    def hessian(self, maps: Maps, inputs: Sequence[str]) -> Array:
        """The second derivatives along the changes of the state with x and u."""
        b, c = input_changes(self._system, inputs), np.zeros(len(self._system.joint_coordinates.b))
        nq, count = self._system.nq, maps.motion.shape[1]
        b = np.hstack([np.zeros((len(b), count - len(inputs))), b])
        every = maps.q, maps.v, maps.motion[:nq], maps.motion[nq:], b
        along = [Slopes._make([*(x[:, k].copy() for x in every), c]) for k in range(count)]
        changes = [self._recorded.change(self._bars, slopes) for slopes in along] if self._bars else []
        curvatures = np.zeros((count, count))
        for k, change in enumerate(changes):
            curvatures[k] = [
                sum(float(x @ y) for x, y in zip(change, slopes, strict=True)) for slopes in along
            ]
        return curvatures
