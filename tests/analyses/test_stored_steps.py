"""Steps stored for derivatives: their cost, and that later steps leave them unchanged."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.integrators import described

SETTINGS = {"until": 2.0, "t_eval": [2.0], "rtol": 1e-6, "atol": 1e-7, "method": sr.HHT()}


@cache
def run(store_steps: bool = True) -> sr.Trajectory:
    return sr.simulate(slider_crank(), store_steps=store_steps, **SETTINGS)


def test_steps_that_are_kept_take_few_corrections_and_factors_more() -> None:
    kept, plain = run(), run(store_steps=False)
    assert abs(kept.nsteps - plain.nsteps) <= 3
    assert kept.nfev < 1.45 * plain.nfev
    assert kept.njev < 0.5 * kept.nsteps


def test_no_correction_is_missing_in_steps_that_are_kept() -> None:
    """The same lengths of steps give the same motion where tolerances are narrow."""
    kept = run().steps
    narrow = sr.HHT().run(
        slider_crank(),
        kept.start,
        np.array([0.0, 2.0]),
        rtol=1e-10,
        atol=1e-12,
        store_steps=True,
        given=kept.h,
    )
    assert abs(narrow.steps.q - kept.q).max() < 5e-10
    assert abs(narrow.steps.v - kept.v).max() < 2e-9


@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()])
def test_steps_stay_as_they_are_while_room_for_more_is_made(
    method: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = SETTINGS | {"until": 0.6, "t_eval": [0.6], "method": method, "store_steps": True}
    whole = sr.simulate(slider_crank(), **settings)
    monkeypatch.setattr(described, "RECORD_SIZE", 7 * (4 * slider_crank().nq + slider_crank().m))
    parts = sr.simulate(slider_crank(), **settings)
    assert len(parts.steps) == len(whole.steps) > 10
    for name in ("t", "h", "q", "v", "a", "lam", "memory"):
        assert np.array_equal(getattr(parts.steps, name), getattr(whole.steps, name)), name


@pytest.mark.parametrize("method", [None, sr.HHT(), sr.Radau()])
def test_a_run_that_cannot_begin_stores_no_steps(method: object) -> None:
    body = sr.Body("b", mass=1.0, inertia=(0.1,) * 3, position=(1, 0, 0))
    pull = sr.Force("f", sr.ground.point(0, 0, 0), body.point(0, 0, 0), value="sqrt(t - 1)")
    settings = {"method": method} if method else {}
    run = sr.simulate(sr.System(sr.Model("m", [body], [], [pull])), until=1.0, store_steps=True, **settings)
    assert run.status == "not finite"
    assert run.steps is None
    with pytest.raises(ValueError, match="derivatives need a run that reached its end"):
        sr.sensitivity(run, sr.Final("b.x"), ["b.mass"])
