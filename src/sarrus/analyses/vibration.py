"""Vibration modes: eigenvalues of the linearized equations of motion, and what they say of stability."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..algebra import Array
from ..model import reports_warnings
from ..results import Modes
from ..system import System
from .linearization import Linear, linearize
from .onto import largest
from .threads import one_thread_if_small

FREE = 1e-6  # an eigenvalue, relative to the largest: a free motion is a double zero, found to the root of round-off
UNDAMPED = 1e-9  # a real part, relative to the largest eigenvalue, that counts as zero
STEADY = 1e-6  # a - X v that counts as zero, relative to the accelerations in the system


@reports_warnings
@one_thread_if_small
def modes(
    system: System,
    q: ArrayLike,
    v: ArrayLike | None = None,
    *,
    t: float = 0.0,
    turning: ArrayLike = (0.0, 0.0, 0.0),
    strict: bool = False,
) -> Modes:
    """Vibration modes about an equilibrium or a steady motion, from exact derivatives.

    Parameters
    ----------
    system : System
    q, v : (nq,) an equilibrium (see `equilibrium`), or a state of a steady motion
    t : time [s]
    turning : (3,) angular velocity in global axes of the observer to whom the motion looks steady [rad/s]
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    Modes
        With ``success`` false and a sentence in ``message``, if this is neither an equilibrium nor a steady motion.
    """
    linear = linearize(system, q, v, t=t, turning=turning)
    values, vectors = np.linalg.eig(linear.A)
    values = np.where(abs(values) <= FREE * largest(values), 0.0, values)
    keep = _order(values)
    values = values[keep]
    stability = _stability(values, largest(linear.A))
    success, message = _verdict(system, q, v, t, linear, stability, values)
    shapes = _normalized(linear.Z @ vectors[: linear.Z.shape[1], keep])
    return Modes(
        *(system.name, tuple(system.bodies), np.array(q, dtype=float), values, shapes),
        *(linear.A, linear.M, linear.D, linear.K, linear.Z),
        *(linear.unsteady, success, message, stability),
    )


def _order(values: Array) -> Array:
    """Upper half of the plane: by rising |Im|, then falling Re; a double zero is one free motion."""
    zeros = np.flatnonzero(values == 0)
    others = np.flatnonzero((values != 0) & (values.imag >= 0))
    order = others[np.lexsort((-values[others].real, values[others].imag))]
    return np.concatenate([zeros[: (len(zeros) + 1) // 2], order])


def _stability(values: Array, scale: float) -> Literal["stable", "marginal", "unstable"]:
    real = values.real
    if np.any(real > UNDAMPED * scale):
        return "unstable"
    return "stable" if np.all(real < -UNDAMPED * scale) else "marginal"


def _verdict(
    system: System, q: ArrayLike, v: ArrayLike | None, t: float, linear: Linear, stability: str, values: Array
) -> tuple[bool, str]:
    kind = "equilibrium" if v is None or not np.any(v) else "steady motion"
    free = int(np.count_nonzero(values == 0))
    also = f", with {free} free motion{'s' if free > 1 else ''}" if free else ""
    if linear.unsteady > STEADY * (1 + _gravity(system, q, v, t)):
        told = f"{system.name} is in no {kind} there: it accelerates by {linear.unsteady:.3g}; the modes are of no use"
        return False, told
    return True, f"{system.name}: this {kind} is {stability}{also}"


def _gravity(system: System, q: ArrayLike, v: ArrayLike | None, t: float) -> float:
    """The size of accelerations in this system: forces over masses."""
    rest = np.zeros(system.nq) if v is None else np.asarray(v)
    mass = system.M(q).diagonal()
    return largest(system.Q(q, rest, t)[mass > 0] / mass[mass > 0])


def _normalized(shapes: Array) -> Array:
    if not shapes.size:
        return shapes
    top = shapes[np.argmax(abs(shapes), axis=0), np.arange(shapes.shape[1])]
    return np.asarray(shapes / np.where(abs(top) > 0, top, 1.0))
