"""The input of the system layer: a checked model with numbered bodies, elements and plain values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ...elements import Element
from ...elements.element import WIDTHS
from ..checks.findings import part_name
from ..checks.names import find
from ..coordinates import WIDTH, slice_of
from ..errors import ModelError
from ..geometry.points import AXES, GROUND, rotation_about
from ..geometry.pose import GROUND_POSE
from ..laws.surface import Surface
from ..model import Model
from ..quantity import Array, number, numbers
from ..show import show
from ..states.block import Block
from .expand import ORIGIN, BodyState, Piece, expand


class Placement(NamedTuple):
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


class StatePlace(NamedTuple):
    """Place of a first-order state in v, or in q if drivers follow it, its unit, and its size for tolerances."""

    place: int
    unit: str
    nominal: float


@dataclass(frozen=True, eq=False)
class Blueprint:
    """A checked model in numbers.

    Attributes
    ----------
    name
        The model's name.
    bodies
        Names of the bodies without the ground: ``bodies[b - 1]`` is body number b. Blocks of states follow them.
    q, v
        Initial coordinates and their rates, 7 per body and block of states: [r; p] and [ṙ; ṗ].
    given
        True for the rates that the user gives, and for those of states.
    placed
        The elements: joints first, then drivers, inertia, gravity and forces.
    coordinates
        The elements that compute the angles and displacements of joints; they are no part of the equations.
    rotations
        Those of the rotations of bodies about global axes.
    states
        The first-order states by name: place in v, unit, and size.
    followed_states
        Those that drivers follow: place in q, unit, and size.
    """

    name: str
    bodies: tuple[str, ...]
    q: Array
    v: Array
    given: Array
    placed: tuple[Placement, ...]
    coordinates: tuple[Placement, ...] = ()
    rotations: tuple[Placement, ...] = ()
    states: Mapping[str, StatePlace] = field(default_factory=dict)
    followed_states: Mapping[str, StatePlace] = field(default_factory=dict)


def blueprint(model: Model) -> Blueprint:
    """Return the blueprint of a model.

    Raises
    ------
    ModelError
        For the first thing that is wrong in the model: part, file and line, remedy.
    """
    bodies, pieces, coordinates, blocks = expand(model)
    names = tuple(body.name for body in bodies)
    index = {name: number for number, name in enumerate((GROUND, *names, *(block.name for block in blocks)))}
    placed, measures = (
        tuple(_place(piece, index, model) for piece in some) for some in (pieces, coordinates)
    )
    rotations = tuple(
        _place(Piece(name, rotation_about(axis, name)), index, model) for name in names for axis in AXES
    )
    q, v = _coordinates(bodies, blocks), _rates(bodies, blocks)
    states, followed = (_places(len(bodies), blocks, kind) for kind in (False, True))
    given = np.array(
        [*(x for body in bodies for x in body.given), *(True for _ in blocks for _ in range(WIDTH))],
        dtype=bool,
    )
    return Blueprint(model.name, names, q, v, given, placed, measures, rotations, states, followed)


def _place(piece: Piece, index: dict[str, int], model: Model) -> Placement:
    element, bodies, values, label = piece.primitive
    try:
        _check_bodies(element, bodies, index)
        _check_values(element, values)
    except ModelError as wrong:
        message = f"its element {element.__name__} ({label}) {wrong.message}"
        part = part_name((_section(piece.owner, model), piece.owner))
        raise ModelError(message, part=part, field=wrong.field, where=model.where(piece.owner)) from None
    return Placement(element, tuple(index[name] for name in bodies), values, piece.owner, label)


def _section(owner: str, model: Model) -> str:
    return next(name for name, parts in model.sections().items() if any(p.name == owner for p in parts))


def _check_bodies(element: type[Element], bodies: tuple[str, ...], index: dict[str, int]) -> None:
    if len(bodies) != element.bodies:
        raise ModelError(f"is for {element.bodies} bodies, but is given {len(bodies)}. Name as many.")
    given: tuple[Any, ...] = bodies
    for name in given:
        if not isinstance(name, str):
            message = f"its bodies must be names, but one is {show(name)}"
            raise ModelError(f"{message}. Give body.name for a Body.", field="bodies")
        find(name, index, "bodies")


def _check_values(element: type[Element], values: tuple[Any, ...]) -> None:
    kinds = {name: kind for name, kind in element.fields.items() if kind != "Time"}
    if len(values) != len(kinds):
        message = f"takes {len(kinds)} values ({', '.join(kinds)}), but is given {len(values)}"
        raise ModelError(f"{message}. Give one for each.")
    for (name, kind), value in zip(kinds.items(), values, strict=True):
        if kind == "Curve":
            if not callable(getattr(value, "numbers", None)):
                raise ModelError(
                    f"needs a curve for {name}, but is given {show(value)}. Give a Curve.", field=name
                )
        elif kind == "Surface":
            if not isinstance(value, Surface):
                raise ModelError(
                    f"needs a surface for {name}, but is given {show(value)}. Give a Surface.", field=name
                )
        elif WIDTHS[kind] == 1:
            number(value, name)
        else:
            numbers(value, WIDTHS[kind], name, f"Give {WIDTHS[kind]} numbers.")


def _coordinates(bodies: tuple[BodyState, ...], blocks: tuple[Block, ...]) -> Array:
    poses = [x for body in bodies for x in (*body.start.r, *body.start.p)]
    slots = [x for b in blocks for x in (*(b.initial() if b.followed else ORIGIN), *GROUND_POSE.p)]
    return np.array([*poses, *slots])


def _rates(bodies: tuple[BodyState, ...], blocks: tuple[Block, ...]) -> Array:
    slots = [x for b in blocks for x in (*(ORIGIN if b.followed else b.initial()), 0.0, 0.0, 0.0, 0.0)]
    return np.array([*(x for body in bodies for x in body.rates), *slots])


def _places(bodies: int, blocks: tuple[Block, ...], followed: bool) -> dict[str, StatePlace]:
    return {
        state.name: StatePlace(slice_of(bodies + n).start + k, state.unit, state.nominal)
        for n, block in enumerate(blocks) if block.followed == followed for k, state in enumerate(block.states)
    }  # fmt: skip
