"""A bushing: an elastic and damping connection of two frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, TypeAlias

import numpy as np

from ... import elements
from ..errors import ModelError
from ..geometry.frame import Frame
from ..geometry.placement import placed_frames
from ..geometry.pose import Poses
from ..geometry.solid import Solid
from ..measure import In, Place
from ..primitive import Primitive
from ..quantity import is_list, numbers, plain
from ..tape import values_of
from .force import Force

Vector6: TypeAlias = Sequence[float] | tuple[float, ...]
Matrix6: TypeAlias = Sequence[float] | Sequence[Sequence[float]]
ROUND_OFF = 1e-9  # [-] of eigenvalues of a matrix with a diagonal of ones
_SIX = "Give six numbers, three translations and then three rotations."
_MATRIX = "Give six numbers for the diagonal, or six rows of six."


def vector6(value: Any, field: str) -> tuple[float, ...]:
    """Return ``value`` as six finite floats, or raise a ModelError about ``field``."""
    return numbers(value, 6, field, _SIX)


def dissipative6(value: Any, field: str) -> tuple[float, ...]:
    """Return a matrix whose quadratic form is never negative: no motion of any direction gets energy from it.

    Raises
    ------
    ModelError
        Otherwise; also for a direction without a number of its own that is coupled to others.
    """
    entries = matrix6(value, field)
    whole = values_of(np.array(entries, dtype=object)).reshape(6, 6)
    symmetric = 0.5 * (whole + whole.T)
    own = np.diag(symmetric)
    sizes = np.sqrt(np.where(own > 0, own, 1.0))  # one unit for forces and torques
    least = float(np.linalg.eigvalsh(symmetric / np.outer(sizes, sizes))[0])
    coupled = np.any(abs(symmetric[own == 0]) > 0)
    if np.any(own < 0) or coupled or least < -ROUND_OFF:
        raise ModelError(
            f"{field} is negative in some direction. Give numbers of at least 0, or a matrix without negative "
            "eigenvalues. Model what drives a motion by a force of its own.",
            field=field,
        )
    return entries


def matrix6(value: Any, field: str) -> tuple[float, ...]:
    """Return the 36 numbers of a matrix, row by row, given in full or by its diagonal."""
    if is_list(value) and len(value) == 6 and is_list(value[0]):
        return tuple(entry for row in value for entry in numbers(row, 6, field, _MATRIX))
    return tuple(plain(entry) for entry in np.diag(numbers(value, 6, field, _MATRIX)).flat)


@dataclass(frozen=True, eq=False)
class Bushing(Force):
    """Bushing: force and torque stiffness · Ξ + damping · Ξ̇ − preload for the deformation Ξ of two frames.

    Ξ are the three coordinates of frame j's origin in frame i, and the three components there of the rotation vector
    φ n, where frame j is rotated by φ ≤ π about n. Beyond half a revolution it pulls back the shorter way, and its
    torque jumps: use an RSDA there. Placed by a global ``point`` [m], with the global axes, in
    the initial pose, where Ξ then starts at 0, or by ``frame_i`` and ``frame_j``.

    Parameters
    ----------
    body_i, body_j
        The two bodies that it connects.
    stiffness
        Six by six, or the six diagonal entries [N/m, N/rad; N, N m/rad]. A symmetric one conserves energy. It may not
        be negative in any direction.
    damping
        In the same form [N s/m, N s/rad; N s, N m s/rad].
    preload
        Force [N] and torque [N m] on body j, in the axes of frame i, where Ξ = 0.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None
    stiffness: Annotated[Matrix6, In("")] = field(kw_only=True)
    damping: Annotated[Matrix6, In("")] = (0.0,) * 6
    preload: Annotated[Vector6, In("")] = (0.0,) * 6

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the bushing."""
        i, j = frames = placed_frames(self, None, poses)
        K, C = dissipative6(self.stiffness, "stiffness"), dissipative6(self.damping, "damping")
        values = (i.s, i.f, i.g, i.h, j.s, *frames.parallel(), K, C, vector6(self.preload, "preload"))
        yield Primitive(elements.Bushing, (i.body, j.body), values, "bushing")
