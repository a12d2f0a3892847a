"""The problem that all bridges carry."""

from functools import cache

import numpy as np
from tests.system.mechanisms import slider_crank

import sarrus as sr


@cache
def problem() -> sr.Problem:
    """Two responses of the slider-crank by three numbers."""
    wanted = [sr.Final("slider.x", name="last place"), sr.Integral("energy.kinetic", name="work")]
    names = ["spring.k", "rod.mass", "pin.point.y"]
    return sr.Problem(slider_crank(), wanted, names, until=0.4, method=sr.Radau(rtol=1e-8, atol=1e-10))


def second_of_square_times() -> np.ndarray:
    """The Hessian of a² b of both responses at the start, by their own gradients and Hessians."""
    p = problem()
    (a, b, *_), rows = p.values(p.x0), p.gradient(p.x0).matrix
    one, two = (np.array([p.hvp(p.x0, d, row) for d in np.eye(len(p.x0))]) for row in (0, 1))
    cross = np.outer(rows[0], rows[1]) + np.outer(rows[1], rows[0])
    return 2 * b * np.outer(rows[0], rows[0]) + 2 * a * cross + 2 * a * b * one + a**2 * two
