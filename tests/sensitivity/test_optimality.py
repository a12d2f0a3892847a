"""What "converged" means: the optimality conditions hold, whatever the solver says; every start is reported."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from tests.patience import within_by_the_clock
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.optimization.optimality import OPTIMAL

NAMES = ["spring.k", "rod.mass"]
LOW, HIGH = np.array([-20.0, -200.0]), np.array([20.0, 200.0])


def valley(x: Any, y: Any) -> Any:
    """A curved valley; at its start some 10⁶ times as high as in its lowest point."""
    return 100 * (y - x * x) ** 2 + (1 - x) ** 2 + 0.5


def numbers(d: Any) -> dict[str, Any]:
    return {"spring.k": 10 + 0 * d["x"]}


def solved(start: tuple[float, float], limit: float | None = None, **settings: Any) -> sr.Optimum:
    goal = sr.Final(lambda o: valley(o.parameter("x"), o.parameter("y")) + 0 * o("slider.x"), name="valley")
    both = sr.Final(lambda o: o.parameter("x") + o.parameter("y") + 0 * o("slider.x"), name="both")
    constraints = [] if limit is None else [sr.Within(both, upper=limit)]
    return sr.optimize(
        slider_crank(),
        goal,
        design={"x": start[0], "y": start[1]},
        formula=numbers,
        until=0.01,
        bounds={"x": (LOW[0], HIGH[0]), "y": (LOW[1], HIGH[1])},
        constraints=constraints,
        **settings,
    )


def optima(limit: float | None) -> list[float]:
    """Values of all local minima: (1, 1), or those along the line x + y = limit, which cuts it off."""
    if limit is None:
        return [0.5]
    x = np.linspace(LOW[0], HIGH[0], 4001)
    along = valley(x, limit - x)
    low = np.flatnonzero((along[1:-1] < along[:-2]) & (along[1:-1] < along[2:])) + 1
    return [
        float(
            minimize_scalar(
                lambda x: valley(x, limit - x), bounds=x[[k - 1, k + 1]], options={"xatol": 1e-12}
            ).fun
        )
        for k in low
    ]


@pytest.mark.one_in(8)
@pytest.mark.parametrize("limit", [None, 1.0, -0.2])
@pytest.mark.parametrize("start", [(-8.0, 3.0), (9.0, -150.0), (-3.0, 100.0)])
def test_a_search_goes_on_until_the_optimum(start: tuple[float, float], limit: float | None) -> None:
    if limit is not None and sum(start) > limit:
        start = (start[0], limit - start[0] - 1)
    found = solved(start, limit, iterations=400, solver="SLSQP")
    assert found.success, found.message
    assert found.optimality <= OPTIMAL
    assert min(abs(found.value - value) / value for value in optima(limit)) < 1e-5


def test_a_solver_that_gives_up_early_is_not_called_converged() -> None:
    found = solved((-8.0, 3.0), iterations=3)
    assert not found.success
    assert found.status == "not converged"
    assert found.optimality > OPTIMAL


@pytest.mark.parametrize("solver", ["L-BFGS-B", "SLSQP", "trust-constr"])
def test_a_loose_tolerance_of_a_solver_is_no_verdict(solver: str) -> None:
    """At the start the gradient is not zero; a solver that ends there at once calls that converged."""
    found = solved((-8.0, 3.0), solver=solver, tolerance=1e3, iterations=200)
    assert found.success == (found.optimality <= OPTIMAL)
    if found.success:
        assert found.value == pytest.approx(0.5, rel=1e-2)


def test_optimality_counts_limits_that_press() -> None:
    found = sr.optimize(
        slider_crank(), sr.Final(lambda o: o.parameter("spring.k") ** 2 + 0 * o("slider.x")), ["spring.k"],
        until=0.01, bounds={"spring.k": (5.0, 20.0)},
    )  # fmt: skip
    assert found["spring.k"] == 5.0
    assert found.success
    assert found.optimality == 0.0


def test_every_start_is_reported() -> None:
    def wall(d: Any) -> dict[str, Any]:
        return {"spring.k": 10 + 0 * d["x"], "rod.mass": d["x"]}  # no mass is negative

    goal = sr.Final(lambda o: (o.parameter("x") - 0.5) ** 2 + 0.1 + 0 * o("slider.x"), name="goal")
    found = sr.optimize(
        slider_crank(), goal, design={"x": 1.0}, formula=wall, until=0.01, bounds={"x": (-8.0, 3.0)}, starts=6,
    )  # fmt: skip
    assert [one.number for one in found.start_reports] == [1, 2, 3, 4, 5, 6]
    assert len(found.starts) == 6  # designs without a mechanism were replaced
    assert any("could not be simulated" in one.message for one in found.start_reports)
    assert all(one.success for one in found.start_reports)
    table = found.table()
    assert all(f"start {n}: 0.1, " in table for n in range(1, 7))


def test_starts_that_cannot_be_simulated_are_reported() -> None:
    def wall(d: Any) -> dict[str, Any]:
        return {"spring.k": 10 + 0 * d["x"], "rod.mass": d["x"]}

    goal = sr.Final(lambda o: (o.parameter("x") - 0.5) ** 2 + 0.1 + 0 * o("slider.x"), name="goal")
    found = sr.optimize(
        slider_crank(), goal, design={"x": 1.0}, formula=wall, until=0.01, bounds={"x": (-1e9, 1.5)}, starts=3,
    )  # fmt: skip
    lost = [one for one in found.start_reports if np.isnan(one.value)]
    assert [one.number for one in lost] == [2, 3]
    assert all(one.message.startswith("cannot be simulated: ") for one in lost)
    assert "start 2: no value, cannot be simulated" in found.table()


def test_a_time_limit_keeps_the_best_design() -> None:
    goal = sr.Final(lambda o: o("slider.x") + o.parameter("spring.k"))
    with within_by_the_clock(30):
        found = sr.optimize(
            slider_crank(), goal, ["spring.k"], until=0.05, bounds={"spring.k": (1.0, 30.0)}, total_time_limit=3.0,
            starts=10_000,
        )  # fmt: skip
    assert 0 < len(found.start_reports) < 10_000
    assert found.start_reports[-1].message
    with pytest.raises(sr.SarrusError, match="time limit of 1e-06 s"):
        sr.optimize(slider_crank(), goal, ["spring.k"], until=0.05, total_time_limit=1e-6)
