"""Refusals and warnings about what a format does not have."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

import numpy as np

from ...model.errors import ModelError, SarrusWarning
from .contents import Contents


def refuse(name: str, what: str) -> ModelError:
    """Return the error for a part that a format does not have."""
    return ModelError(
        f"the format has no {what}. Leave it out with ignore=[{name!r}], or export it as .xml.", part=name
    )


def refuse_loads(contents: Contents, allowed: Iterable[str]) -> None:
    """Raise a ModelError for rods, springs between points, constant forces, or dynamics other than those allowed."""
    for parts, what in (
        (contents.rods, "rods"),
        (contents.springs, "springs between points"),
        (contents.pushes, "constant forces"),
    ):
        for part in parts:
            raise refuse(part.name, what)
    for name in contents.actuators:
        raise refuse(name, "actuators")
    for name, given in contents.dynamics.items():
        for field, value in given._asdict().items():
            if value and field not in allowed:
                raise ModelError(f"the format has no {field} of joints. Export it as .xml.", part=name)


def warn_of_rates(contents: Contents) -> None:
    """Warn that initial velocities are not in the file."""
    if any(np.any(np.abs(rate) > 0) for rate in contents.rates.values()):
        message = f"{contents.name}: the format has no initial velocities; the file is at rest."
        warnings.warn(message, SarrusWarning, stacklevel=5)
