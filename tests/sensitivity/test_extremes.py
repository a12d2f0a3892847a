"""Maxima and minima converge to those of the motion, however long the steps are; against closed forms."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import sarrus as sr

AWAY, SPEED, K = 0.1, 0.7, 40.0
W = np.sqrt(K)
AMPLITUDE = np.hypot(AWAY, SPEED / W)
NAMES = ["b.position.x", "b.velocity.x"]
# The peak of x = 1 + a cos ωt + v/ω sin ωt is 1 + √(a² + v²/ω²), that of its rate is ω times as far from zero
OF_PLACE = np.array([AWAY, SPEED / K]) / AMPLITUDE


def oscillator() -> sr.System:
    """1 kg on a spring, away from its middle by `AWAY` and with a speed."""
    body = sr.Body("b", 1.0, (1, 1, 1), position=(1 + AWAY, 0, 0), velocity=(SPEED, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=K, length=1.0)
    guide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    return sr.System(sr.Model("oscillator", [body], [guide], [spring], gravity=(0, 0, 0)))


def driven() -> sr.System:
    arm = sr.Body("arm", mass=1.0, inertia=(0.1, 0.2, 0.3), position=(1, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 0, 1))
    turn = sr.AngleDriver("turn", "pin", motion="0.5*(1 - cos(5*t))")
    return sr.System(sr.Model("driven", [arm], [pin], drivers=[turn]))


def angle(t: float) -> tuple[float, float, float]:
    return 0.5 * (1 - np.cos(5 * t)), 2.5 * np.sin(5 * t), 12.5 * np.cos(5 * t)


EXTREMES: list[tuple[Any, Any]] = [
    (sr.Maximum("arm.velocity.y"), lambda t: -angle(t)[1] * np.cos(angle(t)[0])),
    (sr.Minimum("arm.velocity.x"), lambda t: -angle(t)[1] * np.sin(angle(t)[0])),
    (sr.Maximum("arm.y"), lambda t: -np.sin(angle(t)[0])),
    (sr.Maximum(lambda o: abs(o("arm.velocity.x"))), lambda t: -abs(angle(t)[1] * np.sin(angle(t)[0]))),
    (sr.Maximum(lambda o: o("pin.force.x") ** 2 + o("pin.force.y") ** 2, "force"),
     lambda t: -(angle(t)[1] ** 4 + angle(t)[2] ** 2)),
]  # fmt: skip


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
def test_extremes_of_a_driven_motion(rtol: float) -> None:
    run = sr.simulate(driven(), until=0.6, store="steps", method=sr.Radau(rtol=rtol))
    found = sr.sensitivity(run, [response for response, _ in EXTREMES], ["arm.mass"])
    for value, (response, function) in zip(found.values, EXTREMES, strict=True):
        t = np.linspace(0, 0.6, 6001)
        near = t[np.argmin([function(x) for x in t])]
        span = (max(near - 2e-4, 0.0), min(near + 2e-4, 0.6))
        inner = minimize_scalar(function, bounds=span, method="bounded", options={"xatol": 1e-9}).x
        wanted = min(function(x) for x in (inner, *span))
        # The polynomial through some samples about it is as near as the steps are short
        assert abs(value) == pytest.approx(abs(wanted), rel=1e-9 + 0.1 * rtol), response.title
    # The motion is exact; its estimate is that of stiff motions, far too large
    assert max(one.error for one in run.error([EXTREMES[0][0], EXTREMES[1][0]])) < 1e-6


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_extremes_of_a_free_motion_with_derivatives(rtol: float) -> None:
    """x = 1 + a cos ωt + v/ω sin ωt has the maximum 1 + A, A = √(a² + v²/ω²), whose Hessian is that of A."""
    run = sr.simulate(oscillator(), until=0.6, store="steps", method=sr.Radau(rtol=rtol))
    found = sr.sensitivity(run, [sr.Maximum("b.x"), sr.Minimum("b.velocity.x")], NAMES)
    assert found.values == pytest.approx([1 + AMPLITUDE, -W * AMPLITUDE], rel=30 * rtol)
    assert found.matrix == pytest.approx(np.array([OF_PLACE, -W * OF_PLACE]), rel=200 * rtol)
    wanted = (np.diag([1, 1 / W**2]) - np.outer(OF_PLACE, OF_PLACE)) / AMPLITUDE
    assert sr.hessian(run, sr.Maximum("b.x"), NAMES).matrix == pytest.approx(
        wanted, rel=2e-4 if rtol > 1e-8 else 1e-5
    )
