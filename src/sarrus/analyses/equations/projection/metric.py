"""The metric in which coordinates and velocities change least: the diagonal of W."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ....algebra import Array
from ....system import System
from ...arguments import kind
from ..length import unit_displacement, units


def metric(system: System, given: str | ArrayLike, q: Array) -> Array:
    """The diagonal of W (nq,).

    Parameters
    ----------
    system : System
    given : "unit": 1 rad counts like a displacement by the root mean square of the model's dimensions, which are
        distances of joint points and ends of springs from the origins of their bodies, radii of rolling bodies, and
        distances of these origins, and of points on the ground, from their mean. "mass": of every body its mass for r,
        and 4/3 of the trace of its inertia about the body's origin for p, so that heavy bodies move less. Or (nq,)
        positive numbers.
    q : (nq,) the estimate of the coordinates

    Raises
    ------
    ValueError
        For another word, a wrong shape, or numbers that are not positive.
    """
    if isinstance(given, str):
        if given not in ("unit", "mass"):
            raise ValueError(
                f'metric must be "unit", "mass" or {system.nq} positive numbers, but is {given!r}. Give one of them.'
            )
        return units(system.nq, unit_displacement(system, q)) ** -2.0 if given == "unit" else _mass(system)
    try:
        weight = np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(
            f'metric must be "unit", "mass" or numbers, got {kind(given)}. Choose one of them.'
        ) from None
    if weight.shape != (system.nq,) or not np.all((weight > 0) & np.isfinite(weight)):
        raise ValueError(f"metric: it must be {system.nq} positive numbers. Give one for each coordinate.")
    return weight


def _mass(system: System) -> Array:
    weight = system.M(system.q0).diagonal().reshape(-1, 7)
    weight[:, 3:] = weight[:, 3:].sum(axis=1, keepdims=True) / 3
    weight[len(system.bodies) :] = 1.0
    return np.asarray(weight.reshape(-1))
