"""The angle between an axis of one body and an axis of another."""

from __future__ import annotations

from ... import elements
from ..._jit.functions import cos
from ..coordinate import turned
from ..errors import ModelError
from ..frame import LocalFrame
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import number, plain

PARALLEL = 1e-6  # [-] distance of the cosine between two axes from 1, below which its gradient vanishes


def cosine(i: LocalFrame, j: LocalFrame, poses: Poses) -> float:
    """The cosine between h_i and h_j in the initial pose."""
    return plain(turned(i.h, i.body, poses) @ turned(j.h, j.body, poses))


def cosine_of(angle: float | None, field: str, i: LocalFrame, j: LocalFrame, poses: Poses) -> float:
    """The cosine of a given angle, or that between h_i and h_j in the initial pose.

    Raises
    ------
    ModelError
        If the axes are parallel, which one equation cannot prescribe.
    """
    value = cosine(i, j, poses) if angle is None else cos(number(angle, field, "give radians"))
    if abs(value) > 1 - PARALLEL:
        raise ModelError("its axes are parallel; use a joint for parallel axes", field=field)
    return value


def constant_angle(i: LocalFrame, j: LocalFrame, value: float) -> Primitive:
    """The cosine between h_i and h_j has a value."""
    return Primitive(elements.ConstantAngle, (i.body, j.body), (i.h, j.h, value), "h_i.h_j")
