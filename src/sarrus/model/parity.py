"""How the fields of a part change in the mirror image about the plane y = 0.

A class declares it in ``parity``, for each field with directions: a polar vector, such as a force, becomes (x, -y, z);
an axial one, such as a torque, (-x, y, -z). An axis is polar if displacements along it are coordinates, and axial if
angles about it are: these have the same values in the mirror image. Terms of a law are listed in ``odd_terms`` of the
class if they change their sign, and in ``exchanged_terms`` if they take the place of another one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, TypeAlias

Parity: TypeAlias = Literal["polar", "axial", "even", "odd", "wrench", "matrix", "terms", "refused"]
Parities: TypeAlias = Mapping[str, Parity]

SIGNS: dict[Parity, tuple[int, ...]] = {
    "polar": (1, -1, 1),
    "axial": (-1, 1, -1),
    # Force and torque, or displacement and rotation vector, in a frame; a matrix of such rows, whose diagonal remains
    "wrench": (1, -1, 1, -1, 1, -1),
    "matrix": (1, -1, 1, -1, 1, -1),
}
NONE: Parities = {}


def declared(base: Parities = NONE, /, **fields: Parity) -> Parities:
    """Return how fields change, beside those of a base."""
    return {**base, **fields}


FIELDS = ("axis", "axis_i", "axis_j", "frame_i", "frame_j")
POLAR: Parities = dict.fromkeys(FIELDS, "polar")
AXIAL: Parities = dict.fromkeys(FIELDS, "axial")
