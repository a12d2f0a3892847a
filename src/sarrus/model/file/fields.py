"""How each type of field of a body, joint or force is written in a model file."""

from __future__ import annotations

from collections.abc import Mapping
from types import NoneType
from typing import Annotated, Any, Literal, TypeAlias, get_args, get_origin

from pydantic import (
    AfterValidator,
    AllowInfNan,
    ConfigDict,
    Discriminator,
    Field,
    Strict,
    StrictStr,
    Tag,
    model_validator,
)

from ..curve import Curve
from ..forces.history import Load
from ..frame import Frame
from ..inertia import Inertia
from ..law import Law
from ..matrix6 import Matrix6, Vector6
from ..names import find
from ..orientation import AxisAngle, EulerAngles, Orientation
from ..point import Point
from ..quantity import Vector
from ..solid import Solid
from .entry import Entry, said

Solids: TypeAlias = Mapping[str, Solid]


class BodyRef(str):
    """The name of a body, or ``ground``."""

    def build(self, solids: Solids) -> Solid:
        """Return the body of this name."""
        return find(str(self), solids, "body")


Number = Annotated[float, Strict(), AllowInfNan(False)]
Three = Annotated[list[Number], Field(min_length=3, max_length=3)]
Four = Annotated[list[Number], Field(min_length=4, max_length=4)]
Rows = Annotated[list[Three], Field(min_length=3, max_length=3)]
Pair = Annotated[list[Number], Field(min_length=2, max_length=2)]
Six = Annotated[list[Number], Field(min_length=6, max_length=6)]
SixRows = Annotated[list[Six], Field(min_length=6, max_length=6)]
Name = Annotated[StrictStr, AfterValidator(BodyRef)]


class PointEntry(Entry):
    """A point of a body: ``at`` in body axes from its origin, or ``global`` in the initial pose."""

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": ["at"]}, {"required": ["global"]}]})

    body: Name
    at: Three = Field(default_factory=list)
    everywhere: Three = Field(default_factory=list, alias="global")

    @model_validator(mode="after")
    def _one_of_two(self) -> PointEntry:
        if len(self.model_fields_set & {"at", "everywhere"}) != 1:
            raise said("must have one of the keys at and global; give at for body axes")
        return self

    def build(self, solids: Solids) -> Any:
        """Return the point."""
        body = find(str(self.body), solids, "body")
        return Point(body, self.at) if self.at else Point(body, self.everywhere, "global")


class FrameEntry(PointEntry):
    """A frame on a body: its origin as a point, its first axis ``x`` and third axis ``z``."""

    x: Three = Field(default_factory=list)
    z: Three = Field(default_factory=list)

    def build(self, solids: Solids) -> Frame:
        """Return the frame."""
        return Frame(super().build(solids), x=self.x or None, z=self.z or None)


class TableEntry(Entry):
    """A curve through pairs [x, y]."""

    table: Annotated[list[Pair], Field(min_length=2)]

    def build(self, solids: Solids) -> Curve:
        """Return the spline."""
        return Curve.table(self.table)


class AxisAngleEntry(Entry):
    """A rotation by ``angle`` [rad] about ``axis``."""

    axis: Three
    angle: Number

    def build(self, solids: Solids) -> AxisAngle:
        """Return the rotation."""
        return AxisAngle(self.axis, self.angle)


class EulerAnglesEntry(Entry):
    """Three rotations [rad] about the body's own axes, in the order of ``sequence``."""

    angles: Three
    sequence: StrictStr = "xyz"

    def build(self, solids: Solids) -> EulerAngles:
        """Return the rotations."""
        return EulerAngles(self.angles, self.sequence)


class InertiaEntry(Entry):
    """Entries of the inertia tensor about the centre of mass [kg m²]; xy is −∫ x y dm."""

    xx: Number
    yy: Number
    zz: Number
    xy: Number = 0.0
    xz: Number = 0.0
    yz: Number = 0.0

    def build(self, solids: Solids) -> dict[str, float]:
        """Return the entries."""
        return self.model_dump()


# Tags of untagged unions stand in parentheses: no key looks like that, see sentences.py.
def _number_or_table(value: Any) -> str:
    return "(table)" if isinstance(value, (dict, TableEntry)) else "(number)"


def _matrix6(value: Any) -> str:
    return "(matrix)" if _has_rows(value) else "(diagonal)"


def _inertia(value: Any) -> str:
    if isinstance(value, (dict, InertiaEntry)):
        return "(entries)"
    return "(matrix)" if _has_rows(value) else "(principal)"


def _orientation(value: Any) -> str:
    if isinstance(value, dict):
        return "(axis-angle)" if value.keys() & {"axis", "angle"} else "(angles)"
    return "(matrix)" if _has_rows(value) else "(parameters)"


def _has_rows(value: Any) -> bool:
    return isinstance(value, list) and any(isinstance(row, list) for row in value)


NumberOrTable = Annotated[
    Annotated[Number, Tag("(number)")] | Annotated[TableEntry, Tag("(table)")],
    Discriminator(_number_or_table),
]
Matrix6Form = Annotated[
    Annotated[Six, Tag("(diagonal)")] | Annotated[SixRows, Tag("(matrix)")],
    Discriminator(_matrix6),
]
InertiaForm = Annotated[
    Annotated[Three, Tag("(principal)")]
    | Annotated[Rows, Tag("(matrix)")]
    | Annotated[InertiaEntry, Tag("(entries)")],
    Discriminator(_inertia),
]
OrientationForm = Annotated[
    Annotated[Four, Tag("(parameters)")]
    | Annotated[Rows, Tag("(matrix)")]
    | Annotated[AxisAngleEntry, Tag("(axis-angle)")]
    | Annotated[EulerAnglesEntry, Tag("(angles)")],
    Discriminator(_orientation),
]


def _parts(annotation: Any) -> frozenset[Any]:
    parts = frozenset(get_args(annotation)) or frozenset({annotation})
    return parts - {NoneType}


_FORMS: dict[frozenset[Any], Any] = {
    _parts(float): Number,
    _parts(Vector): Three,
    _parts(Solid): Name,
    _parts(Point): PointEntry,
    _parts(Frame): FrameEntry,
    _parts(Law): NumberOrTable,
    _parts(Load): Annotated[list[NumberOrTable], Field(min_length=3, max_length=3)],
    _parts(Vector6): Six,
    _parts(Matrix6): Matrix6Form,
    _parts(Inertia): InertiaForm,
    _parts(Orientation): OrientationForm,
}


def form_of(annotation: Any) -> Any:
    """Return the file's form of a field's type; whether it may be left out is decided elsewhere."""
    if get_origin(annotation) is Literal:
        return annotation
    parts = _parts(annotation)
    if parts not in _FORMS:
        raise TypeError(f"a field of type {annotation} has no form in a model file; see {__name__}")
    return _FORMS[parts]
