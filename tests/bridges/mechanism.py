"""The problem that all bridges carry."""

from functools import cache

from tests.system.mechanisms import slider_crank

import sarrus as sr


@cache
def problem() -> sr.Problem:
    """Two responses of the slider-crank by three numbers."""
    wanted = [sr.Final("slider.x", name="last place"), sr.Integral("energy.kinetic", name="work")]
    names = ["spring.k", "rod.mass", "pin.point.y"]
    return sr.Problem(slider_crank(), wanted, names, until=0.4, rtol=1e-8, atol=1e-10)
