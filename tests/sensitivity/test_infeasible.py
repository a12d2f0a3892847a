"""Constraints that no design meets are named after few simulations; residuals above the stated noise are reported."""

import logging
from typing import Any

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr

DEVIATION = sr.Integral(lambda o: (o("slider.x") - 4.5) ** 2, name="deviation")
STROKE = sr.Maximum("slider.x", name="stroke")
GIVEN: dict[str, Any] = {"until": 2.0, "bounds": {"spring.k": (5, 40), "spring.c": (0.5, 5)}}


def test_a_constraint_that_no_design_meets_is_named() -> None:
    """The slider cannot be farther away than crank and rod are long."""
    limits = [sr.Within(STROKE, lower=9.0), sr.Within("spring.length", upper=100.0)]
    found = sr.optimize(slider_crank(), DEVIATION, ["spring.k", "spring.c"], constraints=limits, **GIVEN)
    assert not found.success
    assert "no design that meets the constraint stroke: the nearest has 4.9" in found.message
    assert "its lower limit 9" in found.message
    assert len(found.history) + len(found.failures) <= 60


def closing(d: Any) -> dict[str, Any]:
    """A stiffness that is negative for large values of the variable, where nothing can be simulated."""
    return {"spring.k": 10 * (2 - d["x"])}


def test_designs_that_cannot_be_simulated_lead_to_a_verdict_and_one_line(caplog: Any) -> None:
    caplog.set_level(logging.WARNING, "sarrus.optimize")
    found = sr.optimize(
        slider_crank(), DEVIATION, ["x"], design={"x": 1.0}, formula=closing, until=1.0,
        bounds={"x": (0.0, 9.0)}, constraints=[sr.Within(sr.Final(lambda o: o.parameter("x"), "x"), lower=5.0)],
    )  # fmt: skip
    assert "no design that meets the constraint x" in found.message
    assert 0 < len(found.failures)
    assert len(found.history) + len(found.failures) <= 60
    lines = [one.getMessage() for one in caplog.records]
    assert len(lines) == len(set(lines)) < len(found.failures)


@pytest.mark.parametrize("noise", ["given", "estimated"])
def test_residuals_far_above_sigma_are_reported(noise: Any) -> None:
    """A constant that a wrong model cannot reach."""
    times = np.linspace(0.1, 1.0, 20)
    data = sr.simulate(slider_crank(), until=1.0, t_eval=[0, *times])["slider.x"][1:] + 0.05 * np.sin(
        40 * times
    )
    misfit = sr.Misfit("slider.x", at=times, data=data, sigma=1e-3)
    found = sr.fit(slider_crank(), misfit, ["spring.k"], noise=noise, iterations=5)
    assert "times as large as sigma" in found.message
