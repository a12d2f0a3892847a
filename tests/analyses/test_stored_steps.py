"""Steps stored for derivatives: what Newton's method leaves in them; later steps leave them unchanged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.sensitivity.frozen import solved
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.integrators import described

SETTINGS = {"until": 2.0, "t_eval": [2.0], "method": sr.HHT(rtol=1e-6, atol=1e-7)}


@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()])
def test_what_newtons_method_leaves_is_less_than_the_error_of_the_run(method: object) -> None:
    """Derivatives hold it constant: it is added to their error, which is that of the run."""
    wrt, response = ["crank.mass", "spring.k"], sr.Final("slider.velocity.x")
    settings = {"until": 2.0, "t_eval": [2.0], "store": "steps"}
    run, precise = (sr.simulate(slider_crank(), method=m, **settings) for m in (method, sr.Radau()))
    if isinstance(method, sr.Radau):
        run = sr.simulate(slider_crank(), method=replace(method, rtol=1e-6), **settings)
    exact = solved(run, method)
    found, same, wanted = (sr.sensitivity(r, response, wrt).matrix for r in (run, exact, precise))
    assert abs(exact.steps.q[-1] - run.steps.q[-1]).max() < abs(run.q[-1] - precise.q[-1]).max()
    assert 0 < abs(found - same).max() < abs(found - wanted).max()


@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()])
def test_steps_stay_as_they_are_while_room_for_more_is_made(
    method: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    tight = replace(method, rtol=1e-6, atol=1e-7)
    settings = {"until": 0.6, "t_eval": [0.6], "method": tight, "store": "steps"}
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
    run = sr.simulate(sr.System(sr.Model("m", [body], [], [pull])), until=1.0, store="steps", **settings)
    assert run.status == "not finite"
    assert run.steps is None
    with pytest.raises(ValueError, match="derivatives need a run that reached its end"):
        sr.sensitivity(run, sr.Final("b.x"), ["b.mass"])
