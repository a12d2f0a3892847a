"""The coordinates of a rigid body and their indices in q, and blocks of coordinates of other parts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..algebra import Array
from ..elements.element import Kind
from .arithmetic import Numeric
from .show import quote, suggest

POSITION, ROTATION = 3, 4  # widths of r [m] and of the Euler parameters p
WIDTH = POSITION + ROTATION


class CoordinateBlock(NamedTuple):
    """Coordinates that a part adds to those of bodies, such as amplitudes of modes.

    Attributes
    ----------
    name
        That of the part, or ``masses.modes`` of a part ``masses``. Elements name it in the place of a body.
    kinds
        Those of its blocks, such as ``(modal(5),)``.
    q, v
        Coordinates at the start of a run, and their rates.
    """

    name: str
    kinds: tuple[Kind, ...]
    q: Sequence[Numeric]
    v: Sequence[Numeric]


def number_of(body: str, bodies: Sequence[str], name: str) -> int:
    """Place of a body among the bodies of the system that has this name.

    Raises
    ------
    KeyError
        If there is no such body.
    """
    if body not in bodies:
        raise KeyError(f"no body {quote(str(body))} in {name}. {suggest(str(body), bodies)}")
    return list(bodies).index(body)


def slice_of(number: int) -> slice:
    """Place of the seven coordinates of a body in q, by number from 0 without the ground."""
    return slice(WIDTH * number, WIDTH * number + WIDTH)


def by_body(q: Array) -> Array:
    """The coordinates [r; p] of each body (..., bodies, 7), from those of all (..., nq)."""
    return q.reshape(*q.shape[:-1], -1, WIDTH)


def coordinates_of(body: str, bodies: Sequence[str], name: str) -> slice:
    """Place of a body's seven coordinates in q.

    Raises
    ------
    KeyError
        If there is no such body.
    """
    return slice_of(number_of(body, bodies, name))
