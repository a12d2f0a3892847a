"""Hardpoints: named points in global axes in the design position, each coordinate of which is one parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from .checks.names import matches
from .errors import ModelError, restated
from .expression import Call, Expression, Number, parse
from .expression.formula_value import ParameterValue
from .expression.functions import CONSTANTS
from .expression.quantity import quantity_of
from .quantity import Vector, is_list, number
from .show import quote, show, suggest

AXES = ("x", "y", "z")
TAKEN = (*CONSTANTS, "t", "ground", "unit")  # in formulas, and in the table of a file
WORD = r"[^\W\d]\w*"  # of a name in formulas


class Hardpoint(tuple[Expression, ...]):
    """Three coordinates [m] in global axes, formulas of those of hardpoints; arithmetic is that of vectors."""

    __slots__ = ()

    @property
    def x(self) -> Expression:
        """The first coordinate."""
        return self[0]

    @property
    def y(self) -> Expression:
        """The second coordinate."""
        return self[1]

    @property
    def z(self) -> Expression:
        """The third coordinate."""
        return self[2]

    def __repr__(self) -> str:
        return f"Hardpoint({', '.join(f'{float(x.value()):g}' for x in self)})"

    def __add__(self, other: Any) -> Hardpoint:
        return Hardpoint(a + b for a, b in zip(self, other, strict=True))

    def __radd__(self, other: Any) -> Hardpoint:
        return Hardpoint(a + b for a, b in zip(other, self, strict=True))

    def __sub__(self, other: Any) -> Hardpoint:
        return Hardpoint(a - b for a, b in zip(self, other, strict=True))

    def __rsub__(self, other: Any) -> Hardpoint:
        return Hardpoint(a - b for a, b in zip(other, self, strict=True))

    def __neg__(self) -> Hardpoint:
        return Hardpoint(-a for a in self)

    def __mul__(self, factor: Any) -> Hardpoint:
        return Hardpoint(a * factor for a in self)

    def __rmul__(self, factor: Any) -> Hardpoint:
        return Hardpoint(factor * a for a in self)

    def __truediv__(self, factor: Any) -> Hardpoint:
        return Hardpoint(a / factor for a in self)


class Hardpoints(Mapping[str, Hardpoint]):
    """A table of named points, in global axes in the design position.

    Parts of a model that are given such points follow them: each coordinate is one parameter of the system, such as
    ``lower_ball.z``, whichever number of parts uses it.

    Parameters
    ----------
    points : three coordinates for each name, numbers or texts with a unit
    unit : of coordinates that are numbers; derivatives by them are printed per this unit

    Raises
    ------
    ModelError
        For a name that formulas cannot contain, or coordinates that are not three lengths.

    Examples
    --------
    >>> p = Hardpoints({"lower_ball": (-12.5, 562, -60), "upper_ball": (28, 538, 80)}, unit="mm")
    >>> p.lower_ball
    Hardpoint(-0.0125, 0.562, -0.06)
    >>> 0.5 * (p["lower_ball"] + p["upper_ball"])
    Hardpoint(0.00775, 0.55, 0.01)
    """

    def __init__(self, points: Mapping[str, Vector | Sequence[Any]], *, unit: str = "m") -> None:
        if not isinstance(points, Mapping):
            raise ModelError(
                f'hardpoints must be a mapping such as {{"ball": (0, 1, 2)}}, got {show(points)}.'
            )
        definitions: dict[str, Number] = {}
        for name, place in points.items():
            with restated(part=f"hardpoint {quote(str(name))}"):
                check_hardpoint_name(name)
                definitions |= {
                    f"{name}.{axis}": one for axis, one in zip(AXES, coordinates(place, unit), strict=True)
                }
        self._points = {str(name): Hardpoint(_values(str(name), definitions)) for name in points}

    def __getitem__(self, name: str) -> Hardpoint:
        if name not in self._points:
            raise KeyError(f"there is no hardpoint {quote(name)}. {suggest(name, self._points)}")
        return self._points[name]

    def __getattr__(self, name: str) -> Hardpoint:
        found: Hardpoint | None = vars(self).get("_points", {}).get(name)
        if found is None:
            known = vars(self).get("_points", {})
            raise AttributeError(f"there is no hardpoint {quote(name)}. {suggest(name, known)}")
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self._points)

    def __len__(self) -> int:
        return len(self._points)

    def __repr__(self) -> str:
        return f"Hardpoints({', '.join(self._points)})"


def check_hardpoint_name(name: object) -> None:
    """Refuse a name that formulas cannot contain, or that has another meaning in them or in files."""
    if not matches(WORD, name):
        message = f"its name must be letters, digits and _, starting with a letter, but is {show(name)}"
        raise ModelError(f"{message}. Rename it.")
    if name in TAKEN:
        raise ModelError(f"has the name {quote(str(name))}, which has a meaning of its own. Rename it.")


def coordinates(place: Any, unit: str) -> list[Number]:
    """Return the coordinates of a hardpoint in SI units, each as it was given in its unit.

    Raises
    ------
    ModelError
        For other than three lengths.
    """
    if not is_list(place) or len(place) != 3:
        given = f"{len(place)} numbers" if is_list(place) else show(place)
        raise ModelError(f"must be three coordinates, got {given}. Give [x, y, z].")
    return [_coordinate(value, axis, unit) for value, axis in zip(place, AXES, strict=True)]


def written_number(tree: Expression) -> tuple[str, str]:
    """Return a number and its unit as they are written, which may have a sign; empty for formulas."""
    negative = isinstance(tree, Call) and tree.function.name == "neg"
    number = tree.args[0] if negative else tree
    if not isinstance(number, Number) or not number.written or (negative and number.written.startswith("-")):
        return "", ""
    text, _, unit = number.written.partition(" ")
    return f"{'-' * negative}{text}", unit or "m"


def _coordinate(value: Any, axis: str, unit: str) -> Number:
    if not isinstance(value, str):
        value = f"{number(value, axis)!r} {unit}"
    with restated(axis, field=axis):
        found = quantity_of(parse(value), "m", value)
        return Number(found.value, "m", written=value if found.powers else f"{value} m")


def _values(name: str, definitions: dict[str, Number]) -> Iterator[ParameterValue]:
    for axis in AXES:
        key = f"{name}.{axis}"
        yield ParameterValue(definitions[key].number, "m", of=key, table=definitions)
