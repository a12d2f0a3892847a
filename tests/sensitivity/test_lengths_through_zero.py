"""A length whose ends pass through each other: its force reverses at once."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import sarrus as sr

T, SPEED, FREE = 0.3, 5.0, 0.5


def guided(
    kind: str,
    k: float = 20.0,
    aside: float = 0.0,
    rail: bool = True,
    speed: float = SPEED,
    free: float = FREE,
) -> sr.System:
    """A mass that moves along x through the anchor of its spring, or beside it."""
    at = (-0.4, aside, 0)
    body = sr.Body("b", mass=1.0, inertia=(0.1,) * 3, position=at, velocity=(speed, 0, 0))
    ends = sr.ground.point(0, 0, 0), body.point(0, 0, 0)
    law = {"value": "-k*(x - 0.5)", "parameters": {"k": k}}
    forces: dict[str, Any] = {
        "tsda": lambda: sr.TSDA("s", *ends, k=k, length=free),
        "curve": lambda: sr.TSDA("s", *ends, k=lambda x: k + 0 * x, length=free),
        "force": lambda: sr.Force("s", *ends, **law),
        "tendon": lambda: sr.Tendon("s", list(ends), **law),
    }
    slide = sr.Translational("g", sr.ground, body, point=at, axis=(1, 0, 0))
    return sr.System(sr.Model("m", [body], [slide] if rail else [], [forces[kind]()], gravity=(0, 0, 0)))


def closed_form(k: complex) -> complex:
    """x at T: a harmonic motion about -0.5 up to x = 0, then about 0.5."""
    w = np.sqrt(k)
    t: complex = 0.08
    for _ in range(50):
        x = -FREE + 0.1 * np.cos(w * t) + SPEED / w * np.sin(w * t)
        u = -0.1 * w * np.sin(w * t) + SPEED * np.cos(w * t)
        t -= x / u
    u = -0.1 * w * np.sin(w * t) + SPEED * np.cos(w * t)
    return complex(FREE - FREE * np.cos(w * (T - t)) + u / w * np.sin(w * (T - t)))


@pytest.mark.parametrize("method", [sr.Radau(rtol=1e-8), sr.HHT(rtol=1e-8)])
@pytest.mark.parametrize("kind", ["tsda", "curve", "force", "tendon"])
@pytest.mark.parametrize("store", ["samples", "steps"])
def test_states_are_those_of_the_closed_form(kind: str, method: Any, store: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = sr.simulate(guided(kind), until=T, method=method, store=store)
    assert run["b.x"][-1] == pytest.approx(closed_form(20).real, abs=5e-5)


def test_a_spring_without_a_free_length_does_not_reverse() -> None:
    """x = -0.4 cos ωt + (5/ω) sin ωt, and its derivative by the stiffness, by a complex step."""

    def x(k: complex) -> complex:
        w = np.sqrt(k)
        return complex(-0.4 * np.cos(w * T) + SPEED / w * np.sin(w * T))

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = sr.simulate(guided("tsda", free=0.0), until=T, store="steps")
        found = sr.sensitivity(run, sr.Final("b.x"), ["s.k"])
    assert run["b.x"][-1] == pytest.approx(x(20).real, abs=1e-9)
    assert found.matrix[0, 0] == pytest.approx(x(20 + 1e-30j).imag / 1e-30, rel=1e-6)


def hung(force: float = 10.0, speed: float = 4.0) -> sr.System:
    """A mass below an anchor, in gravity, that a constant force draws to the anchor from both sides."""
    body = sr.Body("b", mass=1.0, inertia=(0.1,) * 3, position=(0, 0, -0.4), velocity=(0, 0, speed))
    rail = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    law: dict[str, Any] = {"value": "-F", "parameters": {"F": force}}
    drawn = sr.Force("s", sr.ground.point(0, 0, 0), body.point(0, 0, 0), **law)
    return sr.System(sr.Model("m", [body], [rail], [drawn], gravity=(0, 0, -2)))


def height(force: float, speed: float, end: float) -> float:
    """Its height: parabolas from one crossing to the next."""
    t, z, u, side = 0.0, -0.4, speed, -1
    while True:
        a = -2 - side * force
        passage = (-u - side * np.sqrt(u * u - 2 * a * z)) / a
        if t + passage > end:
            return z + u * (end - t) + a / 2 * (end - t) ** 2
        t, z, u, side = t + passage, 0.0, u + a * passage, -side


@pytest.mark.parametrize("speed", [4.0, 5.0, 6.0])
def test_states_over_many_crossings(speed: float) -> None:
    times = np.linspace(0, 8, 401)
    run = sr.simulate(hung(speed=speed), until=8.0, t_eval=times)
    np.testing.assert_allclose(run["b.z"], [height(10, speed, t) for t in times], atol=5e-5)


def test_an_event_where_the_ends_meet() -> None:
    meets = sr.Event("b.z", direction=1, name="meets")
    run = sr.simulate(hung(speed=5.0), until=0.5, events=meets)
    (event,) = run.events
    assert event.t == pytest.approx((np.sqrt(25 + 2 * 8 * 0.4) - 5) / 8, abs=1e-9)


@pytest.mark.parametrize("aside", [1e-4, 1e-2])
def test_ends_that_pass_beside_each_other_are_resolved(aside: float) -> None:
    run = sr.simulate(guided("tsda", aside=aside), until=T, store="steps")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = sr.sensitivity(run, sr.Final("b.x"), ["s.k"]).matrix[0, 0]
    ends = [
        sr.simulate(guided("tsda", k, aside), until=T, method=sr.Radau(rtol=1e-12))["b"].position[-1, 0]
        for k in (20.1, 19.9)
    ]
    assert found == pytest.approx((ends[0] - ends[1]) / 0.2, rel=1e-4)
