"""Stops of joints, as forces of the model."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....model import AngleStop, DisplacementStop
from ....model.forces import Force
from ....model.geometry.motion import Slide, Turn
from ..description import Stop
from ..joints import Hinge

ROUNDING = 1e-4  # [rad, m] less than the depth of usual loads


def stop_of(hinge: Hinge, motion: Turn | Slide, given: Stop) -> Force:
    """Return the stop of a motion, named after it."""
    turn = isinstance(motion, Turn)
    kind: Any = AngleStop if turn else DisplacementStop
    i, j = hinge.frames(motion.point if isinstance(motion, Turn) else np.zeros(3), motion.axis)
    stop: Force = kind(f"{motion.name}_stop", frame_i=i, frame_j=j, rounding=ROUNDING, **given._asdict())
    return stop
