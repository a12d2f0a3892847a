"""Designs of motions with events: values, gradients and products of a bouncing ball, the best restitution, memory."""

import numpy as np
import pytest
from tests.sensitivity.test_events import BOUNCE, ball

import sarrus as sr
from sarrus.analyses.optimization.point import DesignError

NAMES = ["ball.velocity.z", "bounce.restitution"]
G = 9.81


def problem(responses: object, **settings: object) -> sr.Problem:
    return sr.Problem(ball(), responses, NAMES, until=1.0, events=BOUNCE, **settings)


def landed(v: float, e: float) -> tuple[float, float]:
    """Time of the first impact, and the height a second after the start; the ball falls from 1 m."""
    speed = np.sqrt(v * v + 2 * G)
    first = (v + speed) / G
    left = 1.0 - first
    return first, e * speed * left - 0.5 * G * left * left


@pytest.mark.parametrize(
    ("method", "memory"),
    [
        (sr.HHT(), None),
        (sr.Radau(), 1e7),
        pytest.param(sr.HHT(), 1e7, marks=pytest.mark.slow),
        pytest.param(sr.Radau(), None, marks=pytest.mark.slow),
    ],
)
def test_values_and_gradients_are_those_of_the_closed_form(method: object, memory: float | None) -> None:
    """At the first design and at others, whose restitution is another."""
    told = problem([sr.AtEvent("t", event="bounce"), sr.Final("ball.z")], method=method, memory=memory)
    assert told.x0 == pytest.approx([0.5, 0.8])
    for x in ([0.5, 0.8], [0.3, 0.6]):
        step = 1e-20j * np.eye(2)
        slopes = np.array([np.imag(landed(*(x + own))) / 1e-20 for own in step]).T
        assert told.values(np.array(x)) == pytest.approx(landed(*x), abs=1e-12)
        assert told.gradient(np.array(x)).matrix == pytest.approx(slopes, abs=1e-11)


def test_products_agree_with_gradients() -> None:
    told, x = problem([sr.AtEvent("t", event="bounce"), sr.Final("ball.z")]), np.array([0.2, 0.7])
    change, weights = np.array([0.3, -0.4]), np.array([2.0, 1.5])
    matrix = told.gradient(x).matrix
    assert told.jvp(x, change) == pytest.approx(matrix @ change, abs=1e-12)
    assert told.vjp(x, weights) == pytest.approx(weights @ matrix, abs=1e-12)


@pytest.mark.parametrize("memory", [None, 1e7])
def test_the_restitution_with_which_a_height_is_reached(memory: float | None) -> None:
    miss = sr.Final(lambda o: (o("ball.z") - 0.7) ** 2, name="miss")
    settings = {"until": 1.0, "events": BOUNCE, "memory": memory, "tolerance": 1e-10}
    found = sr.optimize(ball(), miss, ["bounce.restitution"], **settings)
    first, _ = landed(0.5, 0.8)
    wanted = (0.7 + 0.5 * G * (1 - first) ** 2) / (np.sqrt(0.25 + 2 * G) * (1 - first))
    assert found.success
    assert found.x == pytest.approx([wanted], abs=1e-6)
    assert len(found.run.events) == 1


def test_an_impact_that_never_comes_has_no_influence() -> None:
    told = problem(sr.Final("ball.z"))
    matrix = told.gradient(np.array([9.0, 0.8])).matrix
    assert matrix[0] == pytest.approx([1.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("memory", [None, 1e7])
def test_a_design_without_the_event_of_a_response_cannot_be_simulated(memory: float | None) -> None:
    told = problem(sr.AtEvent("t", event="bounce"), memory=memory)
    for _ in range(2):
        with pytest.raises(DesignError, match="the run has 0 events 'bounce'"):
            told.values(np.array([9.0, 0.8]))


@pytest.mark.slow
def test_a_search_steps_back_from_designs_without_the_event() -> None:
    """The ball that is thrown highest comes down latest; too high a one is not seen to come down."""
    latest = sr.AtEvent(lambda o: -1 * o.t, event="bounce", name="latest")
    bounds = {"ball.velocity.z": (0.0, 20.0)}
    found = sr.optimize(ball(), latest, [*bounds], until=1.0, bounds=bounds, events=BOUNCE, iterations=20)
    assert found.failures
    assert "0 events 'bounce'" in found.failures[0]
    assert -1.0 <= found.value < -0.95


def test_several_starts_in_other_processes(tmp_path: object) -> None:
    """Events and memory go with the problem."""
    from concurrent.futures import ThreadPoolExecutor

    miss = sr.Final(lambda o: (o("ball.z") - 0.7) ** 2, name="miss")
    bounds = {"bounce.restitution": (0.2, 1.0)}
    with ThreadPoolExecutor(1) as executor:
        settings = {"until": 1.0, "bounds": bounds, "events": BOUNCE, "memory": 1e7, "executor": executor}
        found = sr.optimize(ball(), miss, [*bounds], starts=2, **settings)
    assert found.value < 1e-8
    assert len(found.starts) == 2


@pytest.mark.parametrize("asked", ["jvp", "vjp", "hvp"])
def test_what_needs_all_steps_is_refused_with_memory(asked: str) -> None:
    told = problem(sr.Final("ball.z"), memory=1e7)
    with pytest.raises(ValueError, match="with memory= there are values and gradients only"):
        getattr(told, asked)(told.x0, np.ones(1 if asked == "vjp" else 2))


def test_hessian_products_over_events_are_those_of_differenced_gradients() -> None:
    told, at = problem(sr.Final("ball.z")), np.array([0.02, -0.01])
    found, e = told.hvp(told.x0, at), 1e-3
    wanted = (told.gradient(told.x0 + e * at).matrix - told.gradient(told.x0 - e * at).matrix)[0] / (2 * e)
    assert found == pytest.approx(wanted, rel=1e-6)


def test_a_restitution_is_fitted_to_heights() -> None:
    """Some were measured before the first impact, some between it and the next."""
    times = np.array([0.1, 0.3, 0.45, 0.6, 0.8, 1.0])
    true = sr.Problem(
        ball(), [sr.At("ball.z", time=t) for t in times], NAMES, until=1.0, events=BOUNCE, method=sr.Radau()
    )
    data = sr.Misfit("ball.z", at=times, data=true.values(np.array([0.4, 0.7])), sigma=1e-3)
    found = sr.fit(ball(), data, NAMES, events=BOUNCE, method=sr.Radau())
    assert found.success
    assert found.x == pytest.approx([0.4, 0.7], abs=1e-6)


def test_a_restitution_beyond_its_limits_is_a_design_that_cannot_be_simulated() -> None:
    """Without bounds the height that only a gain of energy reaches leads there."""
    told = problem(sr.Final("ball.z"))
    for restitution in (1.2, -0.1):
        with pytest.raises(DesignError, match="restitution of an Impact must be between 0 and 1"):
            told.values(np.array([0.5, restitution]))
    miss = sr.Final(lambda o: (o("ball.z") - 2.0) ** 2, name="miss")
    found = sr.optimize(ball(), miss, ["bounce.restitution"], until=1.0, events=BOUNCE)
    assert 0 <= found.x[0] <= 1
    assert any("restitution" in failure for failure in found.failures)
