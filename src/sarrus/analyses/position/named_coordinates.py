"""Coordinates by name, and selections of fixed coordinates."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...algebra import Array
from ...outputs import UnknownOutput, find_output
from ...system import System
from ..arguments import kind


def followed_coordinates(system: System) -> Array:
    """Mark the states that drivers follow (nq,)."""
    return np.isin(np.arange(system.nq), [one.place for one in system.followed_states.values()])


def held_coordinates(system: System, fixed: Iterable[str]) -> Array:
    """Mark the coordinates of the bodies and coordinates that are named (nq,).

    Raises
    ------
    KeyError
        If a name is neither a body's nor a coordinate's.
    """
    held = np.zeros(system.nq, dtype=bool)
    for name in fixed:
        if not isinstance(name, str):
            raise TypeError(
                f"fixed must be names of bodies or coordinates, got {kind(name)}. Pass a list of texts."
            )
        if name in system.bodies:
            held[system.coordinates_of(name)] = True
        else:
            held[coordinate(system, name)] = True
    return held


def coordinate(system: System, name: str) -> int:
    """The place in q of a coordinate.

    Raises
    ------
    UnknownOutput
        If there is no such coordinate.
    """
    output = find_output(system, name)
    if output.place is None:
        raise UnknownOutput(
            f"{system.name}: {name!r} is no coordinate of a body. Name a body or e.g. slider.x."
        )
    return output.place
