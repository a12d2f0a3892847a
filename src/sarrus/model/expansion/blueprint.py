"""The input of the system layer: a checked model with numbered bodies, elements and plain values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ...elements import Element
from ...elements.element import RIGID, WIDTHS, Kind
from ..checks.findings import part_name
from ..checks.names import find
from ..errors import ModelError
from ..geometry.points import AXES, GROUND, rotation_about
from ..laws.surface import Surface
from ..model import Model
from ..quantity import Array, number, numbers
from ..show import show
from ..states.block import Block
from .expand import Piece, expand


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
        Names of the bodies without the ground: ``bodies[b - 1]`` is body number b. Other owners follow them.
    owners
        The kinds of the blocks of each body, other block of coordinates, and block of states, by name.
    q, v
        Initial coordinates and their rates, of bodies [r; p] and [ṙ; ṗ].
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
    owners: Mapping[str, tuple[Kind, ...]]
    q: Array
    v: Array
    given: Array
    placed: tuple[Placement, ...]
    coordinates: tuple[Placement, ...] = ()
    rotations: tuple[Placement, ...] = ()
    states: Mapping[str, StatePlace] = field(default_factory=dict)
    followed_states: Mapping[str, StatePlace] = field(default_factory=dict)

    def bodies_of(self, one: Placement) -> tuple[int, ...]:
        """The bodies that an element is on by number, 0 for the ground, without other owners of coordinates."""
        return tuple(number for number in one.bodies if number <= len(self.bodies))


def blueprint(model: Model) -> Blueprint:
    """Return the blueprint of a model.

    Raises
    ------
    ModelError
        For the first thing that is wrong in the model: part, file and line, remedy.
    """
    bodies, pieces, coordinates, others, blocks = expand(model)
    names = tuple(body.name for body in bodies)
    behind = (*others, *(block.coordinates() for block in blocks))
    owners = dict.fromkeys(names, RIGID) | {block.name: block.kinds for block in behind}
    every = {GROUND: RIGID, **owners}
    known = {name: Owner(number, every[name]) for number, name in enumerate(every)}
    placed, measures = (
        tuple(_place(piece, known, model) for piece in some) for some in (pieces, coordinates)
    )
    rotations = tuple(
        _place(Piece(name, rotation_about(axis, name)), known, model) for name in names for axis in AXES
    )
    poses = [x for body in bodies for x in (*body.start.r, *body.start.p)]
    q = np.array([*poses, *(x for block in behind for x in block.q)])
    v = np.array([*(x for body in bodies for x in body.rates), *(x for block in behind for x in block.v)])
    firsts = np.cumsum([len(poses), *(len(block.q) for block in behind)])[len(others) :]
    states, followed = (_places(firsts, blocks, kind) for kind in (False, True))
    given = np.ones(len(q), dtype=bool)
    given[: len(poses)] = [x for body in bodies for x in body.given]
    return Blueprint(model.name, names, owners, q, v, given, placed, measures, rotations, states, followed)


class Owner(NamedTuple):
    """A body, or another owner of coordinates: its number, and the kinds of its blocks."""

    number: int
    kinds: tuple[Kind, ...]


def _place(piece: Piece, known: Mapping[str, Owner], model: Model) -> Placement:
    element, bodies, values, label = piece.primitive
    try:
        _check_bodies(element, bodies, known)
        _check_values(element, values)
    except ModelError as wrong:
        message = f"its element {element.__name__} ({label}) {wrong.message}"
        part = part_name((_section(piece.owner, model), piece.owner))
        raise ModelError(message, part=part, field=wrong.field, where=model.where(piece.owner)) from None
    return Placement(element, tuple(known[name].number for name in bodies), values, piece.owner, label)


def _section(owner: str, model: Model) -> str:
    return next(name for name, parts in model.sections().items() if any(p.name == owner for p in parts))


def _check_bodies(element: type[Element], bodies: tuple[str, ...], known: Mapping[str, Owner]) -> None:
    if len(bodies) != element.bodies:
        raise ModelError(f"is for {element.bodies} bodies, but is given {len(bodies)}. Name as many.")
    given: tuple[Any, ...] = bodies
    for name, wanted in zip(given, element.owners(), strict=True):
        if not isinstance(name, str):
            message = f"its bodies must be names, but one is {show(name)}"
            raise ModelError(f"{message}. Give body.name for a Body.", field="bodies")
        kinds = find(name, known, "bodies").kinds
        if _widths(kinds) != _widths(wanted):
            message = f"is for blocks of {_words(wanted)}, but those of {name} are {_words(kinds)}"
            raise ModelError(f"{message}. Name another one, or declare its owners().", field="bodies")


def _widths(kinds: Sequence[Kind]) -> list[int]:
    return [len(kind.parts) for kind in kinds]


def _words(kinds: Sequence[Kind]) -> str:
    """For example ``position (3) and rotation (4)``."""
    return " and ".join(f"{kind.name} ({len(kind.parts)})" for kind in kinds)


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


def _places(firsts: Array, blocks: tuple[Block, ...], followed: bool) -> dict[str, StatePlace]:
    return {
        state.name: StatePlace(int(first) + k, state.unit, state.nominal)
        for first, block in zip(firsts, blocks, strict=False) if block.followed == followed
        for k, state in enumerate(block.states)
    }  # fmt: skip
