"""Distance joint: two points keep their distance, as by a massless rod with ball ends. 1 equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ... import elements
from ..errors import ModelError
from ..measure import Length
from ..placement import refuse_same_body
from ..point import Point
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import SMALLEST_LENGTH, plain, positive
from .joint import Joint


@dataclass(frozen=True, eq=False)
class Distance(Joint):
    """A rod of given ``length`` [m] between two points; left out, their initial distance."""

    point_i: Point
    point_j: Point
    length: Length | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φˢˢ(P_i, P_j, C), Eq. (28)."""
        i = self.point_i.resolve(poses, "point_i")
        j = self.point_j.resolve(poses, "point_j")
        refuse_same_body(i.body, j.body, "point_j")
        apart = plain(np.linalg.norm(j.position(poses) - i.position(poses)))
        if apart < SMALLEST_LENGTH:
            message = "its two points coincide; move one of them, or use a spherical joint"
            raise ModelError(message, field="point_i")
        length = apart if self.length is None else positive(self.length, "length", "give the length in m")
        yield Primitive(elements.Distance, (i.body, j.body), (i.s, j.s, length), "distance")
