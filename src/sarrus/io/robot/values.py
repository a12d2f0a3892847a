"""The values of joints that a person gives by name: how many numbers, and whether the joint is there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...model.errors import ModelError
from ...model.geometry.motion import Motion
from ...model.quantity import Array, number, numbers
from ...model.show import quote, suggest


def known(name: str, names: Iterable[str], field: str) -> str:
    """Return the name, or raise a ModelError with a suggestion if there is no such joint that moves."""
    right = list(names)
    if name not in right:
        message = f"{field} names {quote(str(name))}, but no joint that moves has this name"
        raise ModelError(f"{message}; {suggest(str(name), right)}", field=field)
    return name


def values_of(given: Mapping[str, Any], motions: Mapping[str, Motion], field: str) -> dict[str, Array]:
    """Return the checked values by motion."""
    return {
        name: _values(motions[known(name, motions, field)], value, field) for name, value in given.items()
    }


def _values(motion: Motion, value: Any, field: str) -> Array:
    label = f"{field} of {quote(motion.name)}"
    if motion.width == 1:
        return np.array([number(value, label, "give an angle in rad or a displacement in m")])
    values = np.array(
        numbers(value, motion.width, label, f"give {motion.width} numbers, {_ORDER[motion.width]}")
    )
    if not np.linalg.norm(values[-4:]):
        raise ModelError(
            f"{label} has Euler parameters of zero length; give [1, 0, 0, 0] for no turn", field=field
        )
    return values


_ORDER = {4: "the Euler parameters", 7: "position and Euler parameters"}
