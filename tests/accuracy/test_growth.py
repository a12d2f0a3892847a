"""Derivatives of chaotic motions know how many of their digits are right."""

from __future__ import annotations

import warnings
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.sensitivity.accuracy.derivatives.error_changes import by_changes_of_errors
from sarrus.analyses.sensitivity.accuracy.derivatives.growth import WARNED, certain
from sarrus.analyses.sensitivity.accuracy.derivatives.random_changes import RandomChanges
from sarrus.analyses.sensitivity.parameters.parameters import Parameters


def double_pendulum(mass: float = 1.0) -> sr.System:
    """Two bodies of 1 m, from the horizontal."""
    one = sr.Body("a", mass, (0.1,) * 3, position=(0.5, 0, 0))
    two = sr.Body("b", 1.0, (0.1,) * 3, position=(1.5, 0, 0))
    pins = [
        sr.Revolute("A", sr.ground, one, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Revolute("B", one, two, point=(1, 0, 0), axis=(0, 0, 1)),
    ]
    return sr.System(sr.Model("double pendulum", [one, two], pins, gravity=(0, -9.81, 0)))


@cache
def gradient(until: float, rtol: float) -> tuple[float, list[str]]:
    """By the first mass, and the warnings."""
    run = sr.simulate(double_pendulum(), until=until, method=sr.Radau(), rtol=rtol, store_steps=True)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = sr.sensitivity(run, "b.x", ["a.mass"])
    return float(found.matrix[0, 0]), [str(one.message) for one in told]


def test_a_short_motion_has_its_digits() -> None:
    """Two tolerances agree, and nothing warns."""
    (one, told), (other, _) = gradient(5.0, 1e-7), gradient(5.0, 1e-10)
    assert not told
    assert one == pytest.approx(other, rel=0.01)


@pytest.mark.filterwarnings("ignore:.*errors have grown beyond")
def test_a_chaotic_motion_warns() -> None:
    advice = {15.0: "smaller tolerances", 20.0: "the adjoint grows", 40.0: "shorter run"}
    for until, wanted in advice.items():
        value, told = gradient(until, 1e-7)
        assert any("the adjoint grows" in message for message in told), told
        assert np.isfinite(value)
        assert any(wanted in message for message in told)


@pytest.mark.slow
def test_long_regular_motions_do_not_warn() -> None:
    """A thousand swings: errors of the phase add up, but do not double."""
    bob = sr.Body("bob", 1.0, (1e-3,) * 3, position=(0.5, 0, -0.5))
    pin = sr.Revolute("pin", sr.ground, bob, point=(0, 0, 0), axis=(0, -1, 0))
    system = sr.System(sr.Model("pendulum", [bob], [pin], gravity=(0, 0, -9.81)))
    run = sr.simulate(system, until=200.0, store_steps=True)
    assert not sr.sensitivity(run, "bob.x", ["bob.mass"]).warnings


def derivatives(kind: str, until: float) -> tuple[str, ...]:
    """The warnings of some kind of derivatives by the first mass."""
    system = double_pendulum()
    if kind == "checkpoints":
        found = sr.sensitivity_by_checkpoints(system, "b.x", ["a.mass"], until=until, rtol=1e-7, memory=3e6)
        return found.warnings
    run = sr.simulate(system, until=until, rtol=1e-7, store_steps=True)
    calls = {
        "direct": lambda: sr.sensitivity(run, "b.x", ["a.mass"], method="direct"),
        "hessian": lambda: sr.hessian(run, "b.x", ["a.mass"]),
        "product": lambda: sr.hessian_product(run, "b.x", {"a.mass": 1.0}),
        "states": lambda: sr.state_derivatives(run, ["a.mass"]),
    }
    return tuple(calls[kind]().warnings)


@pytest.mark.one_in(8)
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", ["direct", "hessian", "product", "states", "checkpoints"])
def test_all_kinds_of_derivatives_warn(kind: str) -> None:
    assert any("the adjoint grows" in message for message in derivatives(kind, 20.0))
    assert not derivatives(kind, 5.0)


@pytest.mark.one_in(3)
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("until", "rtol"), [(8.0, 1e-5), (14.0, 1e-9), (10.0, 1e-9)])
def test_checkpoints_estimate_the_same_errors(until: float, rtol: float) -> None:
    """Also where growth alone would leave one digit and there are three, as after 10 s."""
    system = double_pendulum()
    run = sr.simulate(system, until=until, rtol=rtol, store_steps=True)
    given = {"until": until, "rtol": rtol, "memory": 3e6}
    found = sr.sensitivity_by_checkpoints(system, "b.x", ["a.mass"], **given).warnings
    assert bool(found) == bool(sr.sensitivity(run, "b.x", ["a.mass"]).warnings)
    assert bool(found) == (until != 10.0)


@pytest.mark.filterwarnings("ignore")
def test_checkpoints_estimate_the_errors_of_a_run_that_an_event_ends() -> None:
    """Its planned end is far behind."""
    end = sr.Event(lambda t, q, v: t - 8, terminal=True, name="end")
    given = {"until": 1e4, "rtol": 1e-4, "memory": 3e6, "events": [end]}
    found = sr.sensitivity_by_checkpoints(double_pendulum(), "b.x", ["a.mass"], **given).warnings
    assert any("the adjoint grows" in one for one in found)


@pytest.mark.one_in(8)
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("method", [sr.HHT(), sr.GeneralizedAlpha()])
@pytest.mark.parametrize(("until", "few"), [(3.0, False), (5.0, True), (8.0, True)])
def test_methods_of_order_two_lose_the_digits_of_derivatives_earlier(
    method: object, until: float, few: bool
) -> None:
    """At their default tolerances: errors of 0.4 % at 3 s, of 56 % and more at 5 s and at 8 s."""
    system = double_pendulum()
    run = sr.simulate(system, until=until, method=method, store_steps=True)
    exact = float(
        sr.sensitivity(sr.simulate(system, until=until, store_steps=True), "b.x", ["a.mass"]).matrix[0, 0]
    )
    found = sr.sensitivity(run, "b.x", ["a.mass"])
    assert (abs(float(found.matrix[0, 0]) - exact) > 0.3 * abs(exact)) == few
    assert any("the adjoint grows" in message for message in found.warnings) == few


def test_steps_of_a_given_length_have_errors_of_their_own() -> None:
    """Tolerances say nothing of them: with 1 ms the derivative is right to 2 percent."""
    run = sr.simulate(double_pendulum(), until=5.0, method=sr.HHT(step=1e-3), store_steps=True)
    assert not sr.sensitivity(run, "b.x", ["a.mass"]).warnings


def stopped(stiffness: float) -> sr.System:
    """A mass between two stops 0.1 m apart."""
    body = sr.Body("m", 1.0, (1, 1, 1), velocity=(2.0, 0, 0))
    guide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    stop = sr.DisplacementStop(
        "stops", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0), stiffness=stiffness, lower=-0.05, upper=0.05,
        rounding=1e-3,
    )  # fmt: skip
    return sr.System(sr.Model("stopped", [body], [guide], [stop]))


BETWEEN_STOPS = ["m.velocity.x", "stops.upper"]


@pytest.fixture(scope="module")
def truth() -> np.ndarray:
    exact = sr.simulate(stopped(1e7), until=1.0, store_steps=True, rtol=1e-9)
    return sr.sensitivity(exact, "m.x", BETWEEN_STOPS).matrix


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*(its derivatives|errors have grown)")
@pytest.mark.parametrize(("method", "few"), [(sr.HHT(), True), (sr.Radau(), False)])
def test_growth_is_seen_through_corners(method: Any, few: bool, truth: np.ndarray) -> None:
    """Steps of the run end at first touches, and what goes through them is no gradient of the response itself."""
    system, names = stopped(1e7), BETWEEN_STOPS
    run = sr.simulate(system, until=1.0, store_steps=True, method=method)
    alike = [sr.sensitivity(run, "m.x", names, error=error) for error in (False, True)]
    alike += [sr.sensitivity_by_checkpoints(system, "m.x", names, until=1.0, method=method)]
    for found in alike:
        assert (abs(found.matrix - truth).max() > 0.3 * abs(truth).max()) == few
        assert any("its derivatives" in one for one in found.warnings) == few


@pytest.mark.parametrize(("size", "taken"), [(0.05, 1), (0.012, 2), (1e-4, 2), (0.0, 1)])
def test_one_random_change_is_enough_where_it_causes_a_warning(size: float, taken: int) -> None:
    """The errors of two derivatives of a response: their size is exact by two orthogonal changes."""
    errors, found, moved = size * np.array([0.6, -0.8]), np.array([[3.0, 4.0]]), list[np.ndarray]()

    def move(change: np.ndarray) -> tuple[np.ndarray, float]:
        moved.append(change)
        return np.array([0.7 + 1e-6 * 5.0 * errors @ change]), 1e-6

    system = double_pendulum()
    parameters = Parameters(system, ["a.mass", "b.mass"])
    random = RandomChanges.of(parameters, np.ones((1, 2)), sr.assemble(system), 1.0)
    random = RandomChanges(parameters, np.ones(2), random.each / random.weights)
    relative = by_changes_of_errors(
        random, found, lambda: np.array([0.7]), move, partial(certain, warned=WARNED[1])
    )
    assert len(moved) == taken
    assert relative is not None
    first = np.sqrt(2) * abs(errors @ moved[0])
    assert relative[0] == pytest.approx(size if taken == 2 else first, rel=1e-4)
