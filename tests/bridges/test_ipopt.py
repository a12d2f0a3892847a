"""IPOPT finds the same optima."""

import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr

pytest.importorskip("ipyopt")
LOOSE = {"until": 1.0, "rtol": 1e-5, "atol": 1e-7}
BOUNDS = {"spring.k": (5.0, 40.0), "spring.c": (0.5, 5.0)}
EFFORT = sr.Integral(lambda o: o("slider.velocity.x") ** 2)


def test_with_bounds() -> None:
    found, same = (
        sr.optimize(slider_crank(), EFFORT, [*BOUNDS], bounds=BOUNDS, solver=solver, **LOOSE)
        for solver in ("IPOPT", "L-BFGS-B")
    )
    assert found.success
    assert found.value == pytest.approx(same.value, rel=1e-4)


def test_with_a_constraint() -> None:
    limit = [sr.Within(sr.Final("slider.velocity.x", name="last"), upper=-1.0)]
    found, same = (
        sr.optimize(
            slider_crank(), EFFORT, [*BOUNDS], bounds=BOUNDS, constraints=limit, solver=solver, **LOOSE
        )
        for solver in ("IPOPT", "SLSQP")
    )
    assert found.constraints["last"] == pytest.approx(-1.0, abs=1e-4)
    assert found.value == pytest.approx(same.value, rel=1e-3)
