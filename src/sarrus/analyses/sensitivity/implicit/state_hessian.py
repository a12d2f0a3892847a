"""Second derivatives of the equations of motion in independent coordinates, contracted: Hessians of ẋ and y."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....algebra import Array
from ....model import SarrusError
from ....model.announcement import reports_warnings
from ....model.show import suggest
from ....results import StateSpace
from .linearized_state import GivenState
from .matrices import MatricesAbout
from .recorded_coordinates import RecordedCoordinates


@reports_warnings
def state_hessian(plant: StateSpace, weights: Mapping[str, float], *, strict: bool = False) -> Array:
    """Compute the second derivatives of a weighted sum of rates of states and of outputs, by states and inputs.

    With ẋ = f(x, u) and y = g(x, u) in the independent coordinates of a linearization, the result is the Hessian of
    w·f + z·g by [x; u] at its state, exact, and symmetric to round-off.

    Parameters
    ----------
    plant : from `linearize`
    weights : by name; a state means its rate, other names outputs of the linearization:
        ``{"pin.angle.rate": 1.0}`` is the Hessian of the angular acceleration
    strict : raise the first warning as a `StrictError`

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
    given: object = weights
    if not isinstance(given, Mapping) or not all(isinstance(one, int | float) for one in given.values()):
        raise TypeError(
            f"weights must be numbers by name, got {weights!r}. Pass a mapping such as {{'pin.angle.rate': 1.0}}."
        )
    names, found = (*plant.states, *plant.outputs), np.zeros(len(plant.states) + len(plant.outputs))
    for name, weight in weights.items():
        if name not in names:
            raise SarrusError(f"{plant.name}: no state and no output is named {name}. {suggest(name, names)}")
        found[names.index(name)] += float(weight)
    state = GivenState(plant.system, plant)
    coordinates = RecordedCoordinates(plant.system, state.states, plant)
    return MatricesAbout(state, plant, coordinates).hessian(found)
