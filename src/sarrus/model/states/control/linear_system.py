"""Linear systems of `scipy.signal` and python-control, as arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import ModelError
from ...show import show


def arrays_of(system: Any, convert: str, fields: str | tuple[str, ...], part: str) -> list[Any]:
    """Return arrays of a linear system in continuous time, as lists.

    Parameters
    ----------
    system
        An object of `scipy.signal` or python-control.
    convert
        Its method that returns the same system with these fields, ``to_ss`` or ``to_tf``, if it has one.
    fields
        Names of the arrays.
    part
        The part that is made of it, for messages.

    Raises
    ------
    ModelError
        If it is no such object, or in discrete time.
    """
    if getattr(system, "dt", None):
        raise ModelError("system has a sampling time. Give one in continuous time.", part=part)
    found = getattr(system, convert)() if hasattr(system, convert) else system
    if not all(hasattr(found, field) for field in fields):
        message = f"system must be a linear system of scipy.signal or python-control, but is {show(system)}"
        raise ModelError(f"{message}. Give one, or {', '.join(fields)} by name.", part=part)
    return [np.asarray(getattr(found, field)).tolist() for field in fields]
