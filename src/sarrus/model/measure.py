"""The physical quantity of a numeric field, declared in the annotation of the field.

``mass: Annotated[float, In("kg")]`` declares that a model file may give the mass in any unit of mass, and
that a formula for it must not have the unit metre.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, NamedTuple, TypeAlias, Union, get_args, get_origin, get_type_hints

from .quantity import Vector


@dataclass(frozen=True)
class In:
    """The SI unit of a field.

    Parameters
    ----------
    unit
        SI base units, N, V, ohm and H with powers, at most one ``/``: ``kg m^2``, ``N s/m``, ``rad``; ``1`` for a plain
        number; empty for any unit.
    over
        For a field that may be a table: the unit of the table's first column.
    named
        Whether the name of a point of the model file may stand for the numbers.
    outputs
        Whether a formula may contain outputs.
    states
        Whether a law over time may contain states and outputs of filters, as the motion of a driver.
    moving
        Whether coordinates may be formulas in t, where the point is one of the ground.
    direction
        Whether only the direction of the vector counts: it may be of lengths, or given by two points.
    """

    unit: str
    over: str = "1"
    named: bool = False
    outputs: bool = False
    states: bool = False
    moving: bool = False
    direction: bool = False


Mass: TypeAlias = Annotated[float, In("kg")]
Length: TypeAlias = Annotated[float, In("m")]
Angle: TypeAlias = Annotated[float, In("rad")]
Position: TypeAlias = Annotated[Vector, In("m", named=True)]  # a global point
Place: TypeAlias = Annotated[Vector, In("m", named=True, moving=True)]  # one that may move with the ground
Offset: TypeAlias = Annotated[Vector, In("m")]  # in body axes
Direction: TypeAlias = Annotated[Vector, In("1", direction=True)]
Velocity: TypeAlias = Annotated[Vector, In("m/s")]
AngularVelocity: TypeAlias = Annotated[Vector, In("rad/s")]
Acceleration: TypeAlias = Annotated[Vector, In("m/s^2")]
Ratio: TypeAlias = Annotated[float, In("1")]


class TypedField(NamedTuple):
    """A field's type, taken apart: the members of its union without None, and what it measures."""

    members: frozenset[object]
    measure: In


def typed(annotation: Any) -> TypedField:
    """Return the members of a field's type and its declared unit."""
    if get_origin(annotation) is Annotated:
        base, *marks = get_args(annotation)
        return TypedField(typed(base).members, next((mark for mark in marks if isinstance(mark, In)), In("")))
    if get_origin(annotation) not in (Union, UnionType):
        return TypedField(frozenset({annotation}) - {NoneType}, In(""))
    parts = [typed(part) for part in get_args(annotation)]
    measure = next((part.measure for part in parts if part.measure.unit), In(""))
    return TypedField(frozenset().union(*(part.members for part in parts)), measure)


@cache
def _hints(kind: type) -> dict[str, Any]:
    """The annotations of a dataclass; of a user's class whose annotations cannot be read, none."""
    try:
        return get_type_hints(kind, include_extras=True)
    except (NameError, TypeError):
        return {}


@cache
def measures(kind: type) -> dict[str, In]:
    """Return what each field of a dataclass measures."""
    return {name: typed(hint).measure for name, hint in _hints(kind).items()}


@cache
def scalar_fields(kind: type) -> frozenset[str]:
    """Return the fields of a dataclass that may be a single number."""
    return frozenset(name for name, hint in _hints(kind).items() if float in typed(hint).members)


@cache
def matrix_fields(kind: type) -> frozenset[str]:
    """Return the fields of a dataclass that may be a list of rows, but no single number and no table of pairs."""
    members = {name: typed(hint).members for name, hint in _hints(kind).items()}
    return frozenset(
        name for name, kinds in members.items() if Sequence[Sequence[float]] in kinds and float not in kinds
    )


@cache
def directed_fields(kind: type) -> frozenset[str]:
    """Return the fields of a dataclass that may have directions: vectors, frames, and matrices in a frame."""
    members = {name: typed(hint).members for name, hint in _hints(kind).items()}
    vector = typed(Vector).members
    return frozenset(
        name
        for name, kinds in members.items()
        if vector <= kinds or any(getattr(one, "__name__", "") == "Frame" for one in kinds)
    )


def measures_of(part: Any) -> dict[str, In]:
    """Return what each field of a part measures, which may depend on its other fields."""
    return {**measures(part.__class__), **getattr(part, "law_measures", {})}
