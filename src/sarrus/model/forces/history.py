"""A vector that is constant or varies in time, as the elements of forces and torques take it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

from ..curve import Curve, Formula
from ..errors import ModelError
from ..law import Law, scaled, varies
from ..quantity import Vec3, Vector, is_list, number, vector

Load: TypeAlias = Vector | Sequence[Law]


class History(NamedTuple):
    """A vector, and for its three components the curves over time that scale them; none if it is constant."""

    vector: Vec3
    curves: tuple[Curve | Formula, ...]


def history(load: Any, factor: Any, field: str) -> History:
    """Return the vector ``factor`` times ``load``, of which one or the other may vary.

    Raises
    ------
    ModelError
        If both vary, or if a number or curve of them is wrong.
    """
    if not (_has_three(load) and any(varies(part) for part in load)):
        return _by_factor(vector(load, field), factor)
    if varies(factor):
        message = (
            f"has both a factor and components of its {field} that vary in time; leave one of them constant"
        )
        raise ModelError(message, field="factor")
    parts, size = [scaled(part, field, "t") for part in load], number(factor, "factor")
    x, y, z = (size * part.factor for part in parts)
    return History((x, y, z), tuple(part.curve for part in parts))


def _by_factor(load: Vec3, factor: Any) -> History:
    if varies(factor):
        return History(load, (scaled(factor, "factor", "t").curve,) * 3)
    x, y, z = (number(factor, "factor") * part for part in load)
    return History((x, y, z), ())


def _has_three(load: Any) -> bool:
    return is_list(load) and len(load) == 3
