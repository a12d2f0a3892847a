"""IPOPT finds the same optima."""

import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr

pytest.importorskip("ipyopt")
pytestmark = pytest.mark.needs("ipyopt")
LOOSE = {"until": 1.0, "method": sr.Radau(rtol=1e-5, atol=1e-7)}
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


def valley(o: object) -> object:
    """A bent valley in which a quasi-Newton Hessian has to be learnt again and again."""
    k, c = o.parameter("spring.k"), o.parameter("spring.c")
    return (c - (k / 10) ** 2) ** 2 + 0.05 * (k / 10 - 1.8) ** 2 + 0.01 * o("slider.x")


@pytest.mark.parametrize(("upper", "share"), [(None, 0.5), (1.2, 0.8)])
def test_with_exact_hessians(upper: float | None, share: float) -> None:
    """The same optimum in fewer simulations, with the constraint's curvature, too."""
    limits = [sr.Within(sr.Final("slider.velocity.x", name="last"), upper=upper)] if upper else []
    bounds = {"spring.k": (1.0, 60.0), "spring.c": (0.1, 8.0)}
    settings = {"until": 0.4, "method": sr.HHT(step=0.01), "bounds": bounds, "constraints": limits}
    learnt, exact = (
        sr.optimize(
            slider_crank(), sr.Integral(valley), [*bounds], solver="IPOPT", second_order=given, **settings
        )
        for given in (False, True)
    )
    assert exact.success
    assert exact.x == pytest.approx(learnt.x, rel=1e-4)
    assert exact.value <= learnt.value + 1e-6
    assert len(exact.history) < share * len(learnt.history), (len(exact.history), len(learnt.history))
    if upper:
        assert exact.constraints["last"] == pytest.approx(upper, abs=2e-6)


def test_exact_hessians_over_events() -> None:
    stop = sr.Event("pin.angle + slider.x - 4.4", reset=sr.Impact(0.5, along="pin.angle"), name="stop")
    settings = {"bounds": BOUNDS, "solver": "IPOPT", "until": 0.4, "events": stop}
    learnt, exact = (
        sr.optimize(slider_crank(), EFFORT, [*BOUNDS], second_order=given, **settings)
        for given in (False, True)
    )
    assert exact.success
    assert exact.value == pytest.approx(learnt.value, rel=1e-5)


def test_exact_hessians_with_radau() -> None:
    settings = {"bounds": BOUNDS, "solver": "IPOPT", "until": 0.1, "method": sr.Radau()}
    learnt, exact = (
        sr.optimize(slider_crank(), EFFORT, [*BOUNDS], second_order=given, **settings)
        for given in (False, True)
    )
    assert exact.success
    assert exact.value == pytest.approx(learnt.value, rel=1e-6)
