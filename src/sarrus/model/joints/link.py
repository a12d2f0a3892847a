"""A massless link between two bodies: where its ends are, and its length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ... import elements
from ..errors import ModelError
from ..frame import Frame, LocalFrame, frame_axes
from ..measure import Length
from ..placement import Frames, refuse_both, refuse_same_body
from ..point import LocalPoint, Point
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import SMALLEST_LENGTH, Vector, plain, positive, triple


@dataclass(frozen=True, eq=False)
class Link:
    """Ends by a point on each body and global axes in the initial pose, or by a frame on each body."""

    point_i: Point | None = None
    point_j: Point | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None
    length: Length | None = None

    def ends(
        self, poses: Poses, axis_i: Vector | None, axis_j: Vector | None, fields: tuple[str, str]
    ) -> Frames:
        """Return the frames of both ends in body axes, with h along the axes."""
        if self.frame_i is not None or self.frame_j is not None:
            if self.frame_i is None or self.frame_j is None:
                raise ModelError(
                    "one of its two frames is missing; give a frame on each body", field="frame_i"
                )
            refuse_both({"point_i": self.point_i, "point_j": self.point_j, fields[0]: axis_i}, "frames")
            frames = Frames(self.frame_i.resolve(poses, "frame_i"), self.frame_j.resolve(poses, "frame_j"))
        elif self.point_i is None or self.point_j is None:
            raise ModelError("its ends are missing; give a point or a frame on each body", field="point_i")
        else:
            i, j = self.point_i.resolve(poses, "point_i"), self.point_j.resolve(poses, "point_j")
            frames = Frames(_end(i, axis_i, fields[0], poses), _end(j, axis_j, fields[1], poses))
        refuse_same_body(frames.i.body, frames.j.body, "point_j")
        return frames

    def distance(self, i: LocalFrame, j: LocalFrame, poses: Poses) -> Primitive:
        """The distance of the ends: the given length, or the one in the initial pose."""
        apart = poses[j.body].global_point(np.array(j.s)) - poses[i.body].global_point(np.array(i.s))
        initial = plain(np.linalg.norm(apart))
        if self.length is None and initial < SMALLEST_LENGTH:
            raise ModelError("its two ends coincide; move one of them", field="point_i")
        length = initial if self.length is None else positive(self.length, "length", "give the length in m")
        return Primitive(elements.Distance, (i.body, j.body), (i.s, j.s, length), "distance")


def _end(point: LocalPoint, axis: Vector | None, field: str, poses: Poses) -> LocalFrame:
    if axis is None:
        raise ModelError(
            f"{field} is missing; give points and {field} in global axes, or a frame on each body"
        )
    axes = poses[point.body].A.T @ frame_axes(None, axis, field)
    return LocalFrame(*point, triple(axes[:, 0]), triple(axes[:, 1]), triple(axes[:, 2]))
