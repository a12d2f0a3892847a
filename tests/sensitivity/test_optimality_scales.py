"""The verdict of a search is the same for the objectives f and a·f + b, however small f is beside b."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sarrus as sr

Array = NDArray[np.float64]
NEAR = 1e-2  # of the distance from start to optimum, within which a search that succeeded ends
SCALES = [
    (1.0, 0.0),
    (1.0, 1e3),
    (1e-9, 1e6),
    (1e9, -1e6),
    (1e-4, 1.0),
]  # a, and b in units of a·f at the start
IPOPT = pytest.param("IPOPT", marks=pytest.mark.needs("ipyopt"))
SOLVERS = ["L-BFGS-B", "SLSQP", "trust-constr", IPOPT]


@cache
def slider() -> sr.System:
    block = sr.Body("block", mass=1, inertia=(1, 1, 1), position=(1, 0, 0))
    guide = sr.Translational("guide", sr.ground, block, point=(0, 0, 0), axis=(1, 0, 0))
    return sr.System(sr.Model("slider", [block], [guide]))


def random_quadratic(seed: int, count: int = 3) -> tuple[Array, Array, Array]:
    """A start, the optimum, and a positive definite matrix with a condition number of up to 1000."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(count, count)))[0]
    best = rng.uniform(-2, 2, count)
    start = best + rng.normal(size=count)
    return start, best, turn @ np.diag(10.0 ** rng.uniform(-2, 1, count)) @ turn.T


def searched(
    f: Callable[[list[Any]], Any], start: Array, a: float, b: float, **settings: Any
) -> tuple[sr.Optimum, Array]:
    names = [f"x{k}" for k in range(len(start))]

    def goal(o: Any) -> Any:
        return a * (f([o.parameter(name) for name in names]) + b) + 0 * o("block.x")

    found = sr.optimize(
        slider(), sr.Final(goal, name="goal"), design=dict(zip(names, start, strict=True)),
        formula=lambda d: {"block.mass": 1 + 0 * d[names[0]]}, until=1e-3, **settings,
    )  # fmt: skip
    return found, found.x


def quadratic(best: Array, A: Array) -> Callable[[list[Any]], Any]:
    def f(x: list[Any]) -> Any:
        d = [one - c for one, c in zip(x, best, strict=True)]
        return sum(A[i, j] * d[i] * d[j] for i in range(len(d)) for j in range(len(d))) / 2

    return f


@pytest.mark.slow
@pytest.mark.parametrize(("a", "b"), SCALES)
@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("seed", range(3))
def test_a_search_ends_at_the_optimum_whatever_unit_and_constant(
    seed: int, solver: str, a: float, b: float
) -> None:
    start, best, A = random_quadratic(seed)
    f = quadratic(best, A)
    first = float(f(list(start)))
    found, x = searched(f, start, a, b * first, solver=solver, iterations=200)
    left = (x - best) @ A @ (x - best) / ((start - best) @ A @ (start - best))
    assert found.success, found.message
    assert np.sqrt(left) < NEAR


@pytest.mark.parametrize(("a", "b"), SCALES)
def test_a_constant_in_the_objective_does_not_hide_where_its_optimum_is(a: float, b: float) -> None:
    found, x = searched(lambda x: (x[0] - 0.55) ** 2, np.array([1.0]), a, 0.2 * b)
    assert found.success, found.message
    assert x[0] == pytest.approx(0.55, abs=5e-3)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("a", "b"), SCALES)
@pytest.mark.parametrize("solver", SOLVERS)
def test_a_search_that_is_cut_off_is_not_called_converged(solver: str, a: float, b: float) -> None:
    start, best, A = random_quadratic(5)
    f = quadratic(best, A)
    found, x = searched(f, start, a, b * float(f(list(start))), solver=solver, iterations=1)
    left = float(f(list(x))) / float(f(list(start)))
    assert np.sqrt(left) > 0.05
    assert not found.success


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("a", "b"), SCALES)
@pytest.mark.parametrize("solver", ["SLSQP", "trust-constr", IPOPT])
def test_limits_press_in_any_unit(solver: str, a: float, b: float) -> None:
    """The nearest point to (2, 1) with x² + y² ≤ 1, at the bound y ≤ 0.3."""
    names = ["x0", "x1"]
    circle = sr.Within(
        sr.Final(lambda o: o.parameter("x0") ** 2 + o.parameter("x1") ** 2 + 0 * o("block.x")), upper=1.0
    )
    found, x = searched(
        lambda x: (x[0] - 2) ** 2 + (x[1] - 1) ** 2, np.array([0.3, 0.2]), a, 3 * b, solver=solver,
        constraints=[circle], bounds={names[0]: (-2, 2), names[1]: (-0.3, 0.3)}, iterations=200,
    )  # fmt: skip
    assert found.success, found.message
    assert x == pytest.approx([np.sqrt(1 - 0.09), 0.3], abs=1e-2)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("start", [0.0, 1.0, 1.0 + 1e-9, 1.0 + 1e-5, 0.999])
@pytest.mark.parametrize(("a", "b"), SCALES)
def test_a_search_may_start_at_the_optimum(start: float, a: float, b: float) -> None:
    found, x = searched(lambda x: (x[0] - 1) ** 2 + (x[1] - 2) ** 2, np.array([start, 2.0]), a, b)
    assert found.success, found.message
    assert x == pytest.approx([1.0, 2.0], abs=1e-2)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("sigma", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("constant", [0.0, 1.0, 1e3])
def test_a_fit_ends_at_the_optimum_whatever_sigma_and_constant(sigma: float, constant: float) -> None:
    """Data of a decay, and of an output that no parameter changes: its misfit is a constant, some `constant`²."""
    true, start = [2.0, 0.7], {"x0": 1.0, "x1": 0.2}
    times = np.linspace(0.0, 3.0, 5)
    decay = [
        sr.Misfit(
            lambda o, t=t: o.parameter("x0") * np.exp(-o.parameter("x1") * t) + 0 * o("block.x"),
            at=[0.001], data=[true[0] * np.exp(-true[1] * t)], sigma=sigma, name=f"at {t:g}",
        )
        for t in times
    ]  # fmt: skip
    other = sr.Misfit(
        lambda o: constant + 0 * o("block.x") + 0 * o.parameter("x0"), at=[0.001], data=[0.0], sigma=sigma
    )
    found = sr.fit(slider(), [*decay, other], design=start, formula=lambda d: {"block.mass": 1 + 0 * d["x0"]})
    assert found.success, found.message
    assert found.x == pytest.approx(true, rel=1e-3)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("sigma", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("constant", [0.0, 1e3])
def test_a_fit_that_is_cut_off_is_not_called_converged(sigma: float, constant: float) -> None:
    banana = [
        sr.Misfit(
            lambda o: 10 * (o.parameter("y") - o.parameter("x") ** 2), at=[0.001], data=[0.0], sigma=sigma
        ),
        sr.Misfit(lambda o: o.parameter("x") + 0 * o("block.x"), at=[0.001], data=[1.0], sigma=sigma),
        sr.Misfit(lambda o: constant + 0 * o.parameter("x"), at=[0.001], data=[0.0], sigma=sigma),
    ]
    found = sr.fit(
        slider(), banana, design={"x": -1.2, "y": 1.0}, formula=lambda d: {"block.mass": 1 + 0 * d["x"]},
        iterations=4,
    )  # fmt: skip
    assert abs(found["x"] - 1) > 0.1
    assert not found.success
