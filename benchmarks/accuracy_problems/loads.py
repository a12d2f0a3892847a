"""A mass, with or without a spring, under loads of all shapes in time: harmonic, pulses, switches, tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.interpolate import PPoly

import sarrus as sr
from sarrus.algebra import Array
from sarrus.functions import exp, positive, sin

from .oscillators import READ
from .problem import Known, Problem, cart, integrated, slide, stack


def loaded(
    name: str,
    load: Any,
    until: float,
    k: float = 0.0,
    c: float = 0.0,
    stops: Sequence[float] = (),
    value: Callable[[float], float] | None = None,
    smooth: bool = False,
) -> Problem:
    """1 kg on a spring at rest, pushed by a load over time; with times of corners, and the load in Python."""

    def make() -> tuple[sr.System, Any]:
        body = cart(1.0)
        center, foot = body.point(0, 0, 0), sr.ground.point(-100, 0, 0)
        push = sr.PointForce("push", center, (1, 0, 0), factor=load)
        spring = [sr.TSDA("spring", foot, center, k=k, length=100.0, c=c)] if k or c else []
        return slide(1.0, push, *spring, body=body), None

    def known(t: Array) -> Known:
        given = value or load
        y = integrated(
            lambda t, y: np.array([y[1], given(t) - k * y[0] - c * y[1]]), (0, 0), t, stops, max_step=0.05
        )
        return Known(t, y[:, :1], y[:, 1:])

    return Problem(name, make, until, known, READ, smooth)


def pulse(begins: float, takes: float, height: float) -> Callable[[float], float]:
    """A half wave of sin², once continuously differentiable."""

    def force(t: float) -> float:
        s = (t - begins) / takes
        return height * sin(np.pi * s) ** 2 * positive(s) * positive(1 - s)

    return force


def bell(middle: float, width: float, height: float) -> Callable[[float], float]:
    """A Gaussian pulse, smooth, whose impulse is 2.5 height · width."""

    def force(t: float) -> float:
        return height * exp(-0.5 * ((t - middle) / width) ** 2)

    return force


def switch(t: float) -> float:
    """On at 1 s, off at 2.5 s."""
    return 5.0 * positive(t - 1.0) * positive(2.5 - t)


def harmonic(t: float) -> float:
    return 2.0 * sin(9.5 * t)


def sweep(t: float) -> float:
    """From 0 to 10 Hz in 10 s."""
    return 3.0 * sin(np.pi * t**2)


TABLE = ((0.0, 0.0), (1.0, 0.0), (1.1, 4.0), (1.3, -3.0), (1.4, 0.0), (6.0, 0.0))


def tabled() -> Problem:
    """A load by a table of few knots, as measured ones are, a spline between them."""
    curve = sr.Curve.table(TABLE)
    cubics = PPoly(np.array(curve.cubics).T, np.array(curve.knots))
    return loaded(
        "load by a table", curve, 6.0, k=20.0, c=0.3, stops=curve.knots, value=lambda t: float(cubics(t))
    )


def shaken(t: Array) -> Known:
    """The foot of the spring moves by a sin w t: m x'' + k x = k a sin w t."""
    k, a, w = 100.0, 0.01, 7.0
    n = np.sqrt(k)
    gain = k * a / (k - w**2)
    x = gain * (np.sin(w * t) - w / n * np.sin(n * t))
    return Known(t, stack(x), stack(gain * w * (np.cos(w * t) - np.cos(n * t))))


def make_shaken() -> tuple[sr.System, Any]:
    body, foot = cart(1.0), cart(1.0, "foot", position=(-1, 0, 0))
    spring = sr.TSDA("spring", foot.point(0, 0, 0), body.point(0, 0, 0), k=100.0, length=1.0)
    guides = [
        sr.Translational(f"guide_{one.name}", sr.ground, one, point=(0, 0, 0), axis=(1, 0, 0))
        for one in (foot, body)
    ]
    shaker = sr.DisplacementDriver("shaker", "guide_foot", motion=lambda t: 0.01 * sin(7.0 * t))
    return sr.System(sr.Model("shaken", [foot, body], guides, [spring], drivers=[shaker])), None


LOADS = (
    loaded("harmonic load near resonance", harmonic, 10.0, k=100.0, c=0.1, smooth=True),
    loaded("swept load", sweep, 10.0, k=400.0, c=0.5, smooth=True),
    loaded("pulse of 20 ms, free mass", pulse(3.0, 0.02, 100.0), 6.0, stops=(3.0, 3.02)),
    loaded("pulse of 1 ms in 10 s", pulse(5.0, 0.001, 1000.0), 10.0, k=10.0, stops=(5.0, 5.001)),
    loaded(
        "smooth pulse of 20 ms",
        bell(3.0, 0.005, 50.0),
        6.0,
        k=4.0,
        stops=(2.95, 2.98, 3.02, 3.05),
        smooth=True,
    ),
    loaded("load switched on and off", switch, 5.0, k=20.0, c=0.5, stops=(1.0, 2.5)),
    tabled(),
    Problem("foot of the spring is shaken", make_shaken, 10.0, shaken, READ),
)
