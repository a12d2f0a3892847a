"""Rack and pinion: the travel of one joint is proportional to the angle of another. 1 equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import ANGLE, TRAVEL, Known, chosen
from ..measure import Length
from ..primitive import Primitive
from .coupling import Coupling, coupled, ratio_of


@dataclass(frozen=True, eq=False)
class RackAndPinion(Coupling):
    """Displacement of ``rack`` = ``radius`` [m] · angle of ``pinion`` + ``offset`` [m], revolutions included.

    The joints are given by name, ``pin``, or where one has several angles ``hook.angle_i``. The sign of the radius
    is the sense of travel. Left out, the offset is that of the initial pose.

    Its reaction, `run.reaction`, is the force on the second body of ``rack`` along the travel; the second body of
    ``pinion`` feels the torque -``radius`` times this force. The tooth force is not transmitted to bearings: the
    pinion's carries nothing of it, and a rack feels no moment from the line on which teeth would touch.
    """

    rack: str
    pinion: str
    radius: Length
    offset: Length | None = None

    @property
    def follower(self) -> str:
        """The rack."""
        return self.rack

    def relations(self, known: Known) -> Iterator[Primitive]:
        """Yield travel - radius θ - offset."""
        pinion = chosen(self.pinion, ANGLE, known, "pinion")
        yield coupled(
            pinion, chosen(self.rack, TRAVEL, known, "rack"), ratio_of(self.radius, "radius"), self.offset
        )
