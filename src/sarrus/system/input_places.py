"""Places of the numbers of inputs among the parameters of a system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..algebra import Array
from ..model import Input, Model
from ..model.expansion.blueprint import Placed
from ..model.quantity import InputNumber
from .structure.population import Population, places_of


class InputPlaces(NamedTuple):
    """Where the number of an input is in the parameter vector `b`: once for each element that it occurs in.

    Attributes
    ----------
    places : indices in b; none for an input that varies in time, whose law is stored in each of these elements
    unit : of the input
    varies : whether it is a law over time
    is_set : whether it has a value
    driving : whether drivers follow it
    """

    places: Array
    unit: str
    varies: bool
    is_set: bool
    driving: bool


def input_places(
    model: Model, placed: Sequence[Placed], populations: Sequence[Population], b: Array
) -> dict[str, InputPlaces]:
    """The places of all inputs of a model by name."""
    inputs = [force for force in model.forces if isinstance(force, Input)]
    if not inputs:
        return {}
    own: dict[str, list[int]] = {one.name: [] for one in inputs}
    for place, value in places_of(populations, placed, b):
        if isinstance(value, InputNumber):
            own[value.name].append(place)
    rows = [(p.at, p.end) for p in populations if p.kind.rows]
    return {
        one.name: InputPlaces(
            np.array(own[one.name], dtype=np.int64), one.unit, one.constant is None, one.value is not None,
            any(begin <= place < end for place in own[one.name] for begin, end in rows),
        )
        for one in inputs
    }  # fmt: skip
