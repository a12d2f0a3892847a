"""What formats other than MJCF do not have: loads that are refused, and initial velocities."""

from __future__ import annotations

import warnings
from collections.abc import Container, Iterator

import numpy as np

from ...model.errors import SarrusWarning
from .contents import Contents
from .missing import Missing


def missing_loads(contents: Contents, allowed: Container[str]) -> Iterator[Missing]:
    """Yield rods, springs between points, constant forces, actuators, and dynamics other than those allowed."""
    for parts, what in (
        (contents.rods, "rods"),
        (contents.springs, "springs between points"),
        (contents.pushes, "constant forces"),
    ):
        for part in parts:
            yield Missing(f"no {what}", (part.name,))
    for parts_of_actuator in contents.actuator_parts.values():
        yield Missing("no actuators", parts_of_actuator)
    for (_, field), names in contents.owners.items():
        if field not in allowed:
            yield Missing(f"no {field} of joints", tuple(names))


def warn_of_rates(contents: Contents) -> None:
    """Warn that initial velocities are not in the file."""
    if any(np.any(np.abs(rate) > 0) for rate in contents.rates.values()):
        message = f"{contents.name}: the format has no initial velocities; the file is at rest."
        warnings.warn(message, SarrusWarning, stacklevel=5)
