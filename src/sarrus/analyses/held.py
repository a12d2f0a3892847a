"""Coordinates by name: which of them are held, and which one is meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

import numpy as np

from ..algebra import Array
from ..system import System
from .misuse import kind


def place_of(system: System, name: str) -> int | None:
    """Place in q of ``slider.x`` (short for ``slider.r.x``) or ``crank.e0``; None if there is no such coordinate."""
    full = system.coordinate_names
    short = [n.replace(".r.", ".").replace(".p.", ".") for n in full]
    for names in (full, short):
        if name in names:
            return names.index(name)
    return None


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
            raise TypeError(f"fixed must be names of bodies or coordinates, got {kind(name)}.")
        if name in system.bodies:
            held[system.coordinates_of(name)] = True
        else:
            held[known(system, name)] = True
    return held


def known(system: System, name: str) -> int:
    """As `place_of`, but a KeyError names the nearest things that exist."""
    place = place_of(system, name)
    if place is None:
        raise KeyError(unknown(system, name, "body or coordinate"))
    return place


def unknown(system: System, name: str, what: str) -> str:
    """The sentence for a name that does not exist."""
    if name in system.bodies:
        return f"{name!r} is a body, not a {what}; give one such as {name}.x, {name}.z or {name}.e0"
    short = [n.replace(".r.", ".").replace(".p.", ".") for n in system.coordinate_names]
    known_names = [*system.bodies, *system.rows, *short]
    near = [one for one in known_names if one.casefold() == name.casefold()]
    near = near or get_close_matches(name, known_names, 3)
    hint = f"did you mean {' or '.join(near)}?" if near else f"try {system.bodies[0]} or {short[0]}"
    return f"no {what} {name!r} in {system.name}; {hint}"
