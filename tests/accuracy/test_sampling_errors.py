"""Errors of derivatives of extremes by their samples, of an oscillator whose motion is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.sensitivity import long_run

AWAY, SPEED, K = 0.1, 0.7, 40.0
W = np.sqrt(K)
AMPLITUDE = np.hypot(AWAY, SPEED / W)
NAMES = ["b.position.x", "b.velocity.x"]


def oscillator() -> sr.System:
    """1 kg on a spring, away from its middle by `AWAY` and with a speed."""
    body = sr.Body("b", 1.0, (1, 1, 1), position=(1 + AWAY, 0, 0), velocity=(SPEED, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=K, length=1.0)
    guide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    return sr.System(sr.Model("oscillator", [body], [guide], [spring], gravity=(0, 0, 0)))


# The peak of x = 1 + a cos ωt + v/ω sin ωt is 1 + √(a² + v²/ω²), that of its rate is ω times as far from zero
OF_PLACE = np.array([AWAY, SPEED / K]) / AMPLITUDE
FASTEST = sr.Peak(lambda o: -o("b.velocity.x"), "fastest")
CASES = [
    (FASTEST, W * OF_PLACE, sr.Radau(), 1e-6),
    (sr.Peak("b.x"), OF_PLACE, sr.Radau(), 1e-6),
    (sr.Peak("b.x"), OF_PLACE, sr.Radau(), 1e-4),
    (FASTEST, W * OF_PLACE, sr.Radau(), 1e-5),
]


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("response", "exact", "method", "rtol"), CASES)
def test_derivatives_of_extremes_know_the_error_of_their_samples(
    response: Any, exact: Any, method: Any, rtol: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By errors of states alone, estimates were down to 1/38 of the error."""
    monkeypatch.setattr(long_run, "FIRST", 6)
    system, given = oscillator(), {"until": 0.6, "method": method, "rtol": rtol}
    stored = sr.sensitivity(sr.simulate(system, store_steps=True, **given), response, NAMES, error=True)
    again = sr.sensitivity_by_checkpoints(system, response, NAMES, error=True, **given)
    error = np.linalg.norm((stored.matrix[0] - exact) * stored.at) / np.linalg.norm(exact * stored.at)
    for found in (stored, again):
        assert error / 2 < found.relative_errors[0] < 10 * error
    assert again.relative_errors == pytest.approx(stored.relative_errors, rel=0.05)
