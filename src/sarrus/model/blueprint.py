"""What the system layer takes: a checked model with numbered bodies, elements and plain values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..elements import Element
from .expand import BodyState, Piece, expand
from .model import Model
from .quantity import Array
from .solid import GROUND


class Placed(NamedTuple):
    """One element of the system.

    ``element`` is its class, ``bodies`` the numbers of its bodies (0 is the ground), ``values``
    its fields in their declared order, ``owner`` the joint, force or body it belongs to, and
    ``label`` which of the owner's elements it is, as in ``pin: f_i.h_j``.
    """

    element: type[Element]
    bodies: tuple[int, ...]
    values: tuple[Any, ...]
    owner: str
    label: str


@dataclass(frozen=True, eq=False)
class Blueprint:
    """A checked model in numbers.

    Attributes
    ----------
    name
        The model's name.
    bodies
        Names of the bodies without the ground: ``bodies[b - 1]`` is body number b.
    q, v
        Initial coordinates and their rates, 7 per body: [r; p] and [ṙ; ṗ]. (7 nb,)
    placed
        The elements: joints first, then drivers, inertia, gravity and forces.
    coordinates
        The elements that measure the angles and travels of joints; they are no part of the equations.
    """

    name: str
    bodies: tuple[str, ...]
    q: Array
    v: Array
    placed: tuple[Placed, ...]
    coordinates: tuple[Placed, ...] = ()


def blueprint(model: Model) -> Blueprint:
    """Return the blueprint of a model.

    Raises
    ------
    ModelError
        For the first thing that is wrong in the model: part, file and line, remedy.
    """
    bodies, pieces, coordinates = expand(model)
    names = tuple(body.name for body in bodies)
    index = {name: number for number, name in enumerate((GROUND, *names))}
    placed, measures = (tuple(_place(piece, index) for piece in some) for some in (pieces, coordinates))
    return Blueprint(model.name, names, _coordinates(bodies), _rates(bodies), placed, measures)


def _place(piece: Piece, index: dict[str, int]) -> Placed:
    element, bodies, values, label = piece.primitive
    return Placed(element, tuple(index[name] for name in bodies), values, piece.owner, label)


def _coordinates(bodies: tuple[BodyState, ...]) -> Array:
    return np.array([x for body in bodies for x in (*body.pose.r, *body.pose.p)])


def _rates(bodies: tuple[BodyState, ...]) -> Array:
    return np.array([x for body in bodies for x in body.rates])
