"""Errors of responses by checkpoints are those of runs whose steps are all stored."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from tests.sensitivity.checkpoints import by_checkpoints

import sarrus as sr
from sarrus.analyses.sensitivity import long_run

NAMES = ["a.mass", "b.mass"]
RESPONSES = [
    "b.y",
    sr.Integral("a.x"),
    sr.Maximum("b.x"),
]
EVENTS = {"none": (), "new velocities": sr.Event("a.x", reset=lambda t, q, v: 0.99 * v)}


def double_pendulum() -> sr.System:
    """Two bodies of 1 m, from the horizontal."""
    one = sr.Body("a", 1.0, (0.1,) * 3, position=(0.5, 0, 0))
    two = sr.Body("b", 1.0, (0.1,) * 3, position=(1.5, 0, 0))
    pins = [
        sr.Revolute("A", sr.ground, one, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Revolute("B", one, two, point=(1, 0, 0), axis=(0, 0, 1)),
    ]
    return sr.System(sr.Model("double pendulum", [one, two], pins, gravity=(0, -9.81, 0)))


@pytest.mark.one_in(6)
@pytest.mark.parametrize("events", EVENTS)
@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau(), sr.GeneralizedAlpha(step=0.01)])
def test_errors_by_checkpoints(method: Any, events: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the errors of samples, in several stretches."""
    monkeypatch.setattr(long_run, "FIRST", 60)
    system = double_pendulum()
    given = {"method": replace(method, rtol=1e-5), "events": EVENTS[events], "until": 2.0}
    stored = sr.sensitivity(sr.simulate(system, store="steps", **given), RESPONSES, NAMES, error=True)
    found = by_checkpoints(system, RESPONSES, NAMES, error=True, **given)
    assert found.matrix == pytest.approx(stored.matrix, rel=1e-6)
    for one, other in zip(found.errors, stored.errors, strict=True):
        assert (one.response, one.value) == (other.response, pytest.approx(other.value, rel=1e-8))
        assert one.estimate == pytest.approx(other.estimate, rel=0.05, abs=0.01 * other.spread)
        assert one.spread == pytest.approx(other.spread, rel=0.05)
        assert one.round_off == pytest.approx(other.round_off, rel=0.05)
