"""The form of each type of field of a body, joint or force in a model file."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import GenericAlias
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeAlias, get_origin

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictBool,
    StrictStr,
    ValidationInfo,
    WithJsonSchema,
    create_model,
    model_validator,
)

from ..bodies.inertia import Inertia
from ..bodies.shape import REMEDY, VARIABLE, Shape, inside, listed
from ..checks.names import find
from ..expression import Expression
from ..forces.loads import Load
from ..forces.paths.wrapping import Wrap
from ..forces.springs import Matrix6, Vector6
from ..geometry.orientation import AxisAngle, EulerAngles, Orientation
from ..geometry.points import Frame, Point, Solid
from ..laws.curve import Curve, Formula
from ..laws.law import Law
from ..laws.surface import Surface
from ..measure import In, typed
from ..quantity import Vector
from ..show import quote
from .scope import full_name
from .stated import (
    Entry,
    direction,
    function_in,
    invalid,
    law_in,
    list_in,
    list_of,
    mapping_of,
    marked,
    number_in,
    one_of,
    place_in,
    point_in,
)

Solids: TypeAlias = Mapping[str, Solid]


class BodyRef(str):
    """The name of a body, or ``ground``."""

    def build(self, solids: Solids) -> Solid:
        """Return the body of this name."""
        return find(str(self), solids, "body")


def _named(value: Any) -> Any:
    """Return the name that a body, or the coordinate of a joint, has in the whole model."""
    return str(full_name(value, value)) if isinstance(value, str) else value


if TYPE_CHECKING:
    Axis: TypeAlias = list[float]
    Local: TypeAlias = list[float]
    Anywhere: TypeAlias = list[Any]
    Angles: TypeAlias = list[float]
    Moment: TypeAlias = float
    Turn: TypeAlias = float
    Share: TypeAlias = float
    Radius: TypeAlias = float
    Lengths: TypeAlias = list[float]
    Heights: TypeAlias = list[list[float]]
    Turned: TypeAlias = Any
else:
    Axis, Local = direction(), list_in("m", 3)
    Anywhere = place_in("m", named=True)
    Moment, Turn, Angles = number_in("kg m^2"), number_in("rad"), list_in("rad", 3)
    Share, Radius = number_in("1"), number_in("m")
    Lengths, Heights = list_of(number_in("m")), list_of(list_of(number_in("m")))

Name = Annotated[StrictStr, BeforeValidator(_named), AfterValidator(BodyRef)]
JointName = Annotated[StrictStr, BeforeValidator(_named)]


class PointEntry(Entry):
    """A point of a body: ``at`` in body axes or at a named point, or ``global`` in the design position."""

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": ["at"]}, {"required": ["global"]}]})

    body: Name
    at: Anywhere = Field(default_factory=list)
    everywhere: Anywhere = Field(default_factory=list, alias="global")

    @model_validator(mode="before")
    @classmethod
    def _at_named_point(cls, data: Any) -> Any:
        """A named point is in global axes."""
        if isinstance(data, dict) and isinstance(data.get("at"), str) and "global" not in data:
            return {"global" if key == "at" else key: value for key, value in data.items()}
        return data

    @model_validator(mode="after")
    def _one_of_two(self) -> PointEntry:
        if len(self.model_fields_set & {"at", "everywhere"}) != 1:
            raise invalid("must have one of the keys at and global. Give at for body axes.")
        return self

    def build(self, solids: Solids) -> Any:
        body = find(str(self.body), solids, "body")
        place = [one.build(solids) if hasattr(one, "build") else one for one in self.at or self.everywhere]
        return Point(body, place, "body" if self.at else "global")


def _full_point(text: Any) -> Any:
    """Return ``chassis.damper_top`` with the names in the whole model."""
    if not isinstance(text, str) or "." not in text:
        return text
    return ".".join(full_name(text, name) for name in text.split("."))


def _point_of_text(text: str, info: ValidationInfo) -> PointEntry:
    """Return the point of ``chassis.damper_top``: where a hardpoint is, on a body."""
    body, _, point = text.partition(".")
    if not point:
        remedy = "Write body.hardpoint, or {body: rod, at: [0, 0, 1]}."
        raise invalid(f"must be a point of a body, but is {quote(text)}. {remedy}")
    place = point_in(point, info)
    return PointEntry.model_construct({"body", "everywhere"}, body=BodyRef(body), everywhere=place)


def _point_form(value: Any) -> str:
    return "text" if isinstance(value, str) else "mapping"


_text_schema = {"type": "string", "description": "A body and a hardpoint: chassis.damper_top."}
_PointText = marked(
    StrictStr, BeforeValidator(_full_point), AfterValidator(_point_of_text), WithJsonSchema(_text_schema)
)
PointForm: Any = one_of(_point_form, text=_PointText, mapping=PointEntry)


class FrameEntry(PointEntry):
    """A frame on a body: its origin as a point, its first axis ``x`` and third axis ``z``."""

    x: Axis = Field(default_factory=list)
    z: Axis = Field(default_factory=list)

    def build(self, solids: Solids) -> Frame:
        return Frame(super().build(solids), x=self.x or None, z=self.z or None)


class TableEntry(Entry):
    """A curve through pairs [x, y], which may be ``periodic``."""

    instead: ClassVar[str] = " Or give a number alone, without a key."

    table: list[list[float]]
    periodic: bool = False

    def build(self, solids: Solids) -> Curve:
        return Curve.table(self.table, periodic=self.periodic)


class AxisAngleEntry(Entry):
    """A rotation by ``angle`` [rad] about ``axis``."""

    axis: Axis
    angle: Turn

    def build(self, solids: Solids) -> AxisAngle:
        return AxisAngle(self.axis, self.angle)


class EulerAnglesEntry(Entry):
    """Three rotations [rad] about the body's own axes, in the order of ``sequence``."""

    angles: Angles
    sequence: StrictStr = "xyz"

    def build(self, solids: Solids) -> EulerAngles:
        return EulerAngles(self.angles, self.sequence)


class InertiaEntry(Entry):
    """Entries of the inertia tensor about the centre of mass [kg m²]; xy is −∫ x y dm."""

    xx: Moment
    yy: Moment
    zz: Moment
    xy: Moment = 0.0
    xz: Moment = 0.0
    yz: Moment = 0.0

    def build(self, solids: Solids) -> dict[str, float]:
        return self.model_dump()


class SurfaceEntry(Entry):
    """A surface through heights ``z`` over ``x`` and ``y``, a row for each x."""

    instead: ClassVar[str] = " Or give a number alone, without a key."

    x: Lengths
    y: Lengths
    z: Heights

    def build(self, solids: Solids) -> Surface:
        return Surface(self.x, self.y, self.z)


def _number_or_table(value: Any) -> str:
    return "table" if isinstance(value, (dict, TableEntry)) else "number"


def _matrix6(value: Any) -> str:
    return "matrix" if _has_rows(value) else "diagonal"


def _inertia(value: Any) -> str:
    if isinstance(value, (dict, InertiaEntry)):
        return "entries"
    return "matrix" if _has_rows(value) else "principal"


def _orientation(value: Any) -> str:
    if isinstance(value, dict):
        return "axis_angle" if value.keys() & {"axis", "angle"} else "angles"
    return "matrix" if _has_rows(value) else "parameters"


def _has_rows(value: Any) -> bool:
    return isinstance(value, list) and any(isinstance(row, list) for row in value)


@cache
def _table_in(unit: str, over: str) -> Any:
    """Return the form of a table whose columns are in these units."""
    pair = marked(GenericAlias(tuple, (number_in(over), number_in(unit))), BeforeValidator(_two))
    words = f"{unit}_over_{over}".replace("/", "_per_").replace(" ", "_").replace("^", "")
    return create_model(
        f"Table_{words}",
        __base__=TableEntry,
        __doc__=TableEntry.__doc__,
        table=(marked(list_of(pair), Field(min_length=2)), ...),
    )


def _two(value: Any) -> Any:
    if isinstance(value, list) and len(value) != 2:
        raise invalid(f"must have 2 entries, but has {len(value)}. Give 2.")
    return value


def _number_or_table_in(to: In, formula: bool = False) -> Any:
    number = law_in(to.unit, to.over, to.outputs, to.states) if formula else number_in(to.unit)
    over = "" if to.outputs and to.over == "1" else to.over
    return one_of(_number_or_table, number=number, table=_table_in(to.unit, over))


def _matrix_in(unit: str) -> Any:
    return marked(list_of(list_in(unit, 3)), Field(min_length=3, max_length=3))


def _surface_or_law(value: Any) -> str:
    is_surface = isinstance(value, SurfaceEntry) or (isinstance(value, dict) and "table" not in value)
    return "surface" if is_surface else _number_or_table(value)


def _road_entry(to: In) -> Any:
    number, table = law_in(to.unit, to.over, to.outputs, to.states), _table_in(to.unit, to.over)
    return one_of(_surface_or_law, number=number, table=table, surface=SurfaceEntry)


def _law_entry(to: In) -> Any:
    return _number_or_table_in(to, formula=True)


def _load_in(to: In) -> Any:
    return marked(list_of(_law_entry(to)), Field(min_length=3, max_length=3))


def _matrix6_in(unit: str) -> Any:
    rows = marked(list_of(list_in(unit, 6)), Field(min_length=6, max_length=6))
    return one_of(_matrix6, diagonal=list_in(unit, 6), matrix=rows)


InertiaForm = one_of(
    _inertia, principal=list_in("kg m^2", 3), matrix=_matrix_in("kg m^2"), entries=InertiaEntry
)
OrientationForm = one_of(
    _orientation,
    parameters=list_in("1", 4),
    matrix=_matrix_in("1"),
    axis_angle=AxisAngleEntry,
    angles=EulerAnglesEntry,
)


if not TYPE_CHECKING:
    Turned = OrientationForm


def _mesh_file(name: str) -> str:
    """Refuse a mesh file outside of the folder that the model file is in."""
    path = Path(os.path.normpath(name))
    if not name:
        raise invalid("must name a mesh file. Give one, as in file: rod.stl.")
    if (path.is_absolute() or ".." in path.parts) and not inside(path, listed(VARIABLE)):
        raise invalid(f"{quote(name)} is outside of the model's folder. {REMEDY}")
    return name


class ShapeEntry(Entry):
    """A mesh that a body is drawn with; its file is named from the folder of this one."""

    file: Annotated[StrictStr, AfterValidator(_mesh_file)]
    scale: Share = 1.0
    position: Local = Field(default_factory=list)
    orientation: Turned = Field(default_factory=lambda: None)
    color: StrictStr = ""

    def build(self, solids: Solids) -> Shape:
        given = self.orientation
        turned = given.build(solids) if hasattr(given, "build") else given
        return Shape(
            self.file,
            self.scale,
            self.position or (0.0, 0.0, 0.0),
            (1.0, 0.0, 0.0, 0.0) if turned is None else turned,
            self.color,
        )


class WrapEntry(Entry):
    """A sphere, or with ``axis`` a cylinder, that a segment of a tendon wraps.

    ``axis`` and ``side`` are in body axes; ``side`` may be a point of another body.
    """

    center: PointEntry
    radius: Radius
    axis: Axis = Field(default_factory=list)
    side: Local | PointEntry = Field(default_factory=list)

    def build(self, solids: Solids) -> Wrap:
        side = self.side.build(solids) if isinstance(self.side, PointEntry) else self.side or None
        return Wrap(self.center.build(solids), self.radius, self.axis or None, side)


def _vector_in(to: In) -> Any:
    if to.direction:
        return direction()
    return place_in(to.unit, to.named) if to.moving else list_in(to.unit, 3, to.named)


_FORMS: dict[frozenset[Any], Callable[[In], Any]] = {
    typed(float).members: lambda to: number_in(to.unit),
    typed(Vector).members: lambda to: _vector_in(to),
    typed(Sequence[float]).members: lambda to: list_of(number_in(to.unit)),
    typed(Sequence[Sequence[float]]).members: lambda to: list_of(list_of(number_in(to.unit))),
    typed(Solid).members: lambda to: Name,
    typed(Solid | str).members: lambda to: Name,
    typed(Mapping[str, float]).members: lambda to: mapping_of(number_in(to.unit)),
    typed(Point).members: lambda to: PointForm,
    typed(Frame).members: lambda to: FrameEntry,
    typed(Sequence[Wrap | None]).members: lambda to: list_of(WrapEntry | None),
    typed(Sequence[Point]).members: lambda to: list_of(PointForm),
    typed(float | Curve).members: lambda to: _number_or_table_in(to),
    typed(str).members: lambda to: JointName,
    typed(bool).members: lambda to: StrictBool,
    typed(float | Curve | Formula).members: lambda to: _number_or_table_in(to, formula=True),
    typed(Law).members: _law_entry,
    typed(Law | Surface).members: _road_entry,
    typed(Sequence[Law]).members: lambda to: list_of(_law_entry(to)),
    typed(Load).members: _load_in,
    typed(Vector6).members: lambda to: list_in(to.unit, 6),
    typed(Matrix6).members: lambda to: _matrix6_in(to.unit),
    typed(Expression).members: lambda to: function_in(to.unit, to.over),
    typed(Inertia).members: lambda to: InertiaForm,
    typed(Orientation).members: lambda to: OrientationForm,
    typed(Shape).members: lambda to: ShapeEntry,
}


def form_of(annotation: Any, field: str = "") -> Any:
    """Return the file's form of a field's type; whether it may be left out is decided elsewhere.

    Raises
    ------
    TypeError
        If there is none.
    """
    if get_origin(annotation) is Literal:
        return annotation
    members, measure = typed(annotation)
    if members not in _FORMS:
        words = annotation.__name__ if isinstance(annotation, type) else annotation
        raise TypeError(
            f"there is no form for the type {words} of its field {field}. "
            "Annotate it with one of the types of the built-in parts."
        )
    return _FORMS[members](measure)
