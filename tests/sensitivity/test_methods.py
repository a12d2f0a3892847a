"""Derivatives of every implicit method: they come from its description, and each is of the very number computed."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.analyses.test_descriptions import METHODS
from tests.sensitivity.checkpoints import by_checkpoints
from tests.sensitivity.frozen import again, differenced, solved
from tests.sensitivity.frozen import values as valued
from tests.sensitivity.test_events import STOP
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus._jit.linking.link import link
from sarrus.analyses.sensitivity.derivatives import differentiated
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.steps.record import SOURCES, Record
from sarrus.analyses.sensitivity.steps.sweep_loop import backward, forward

RESPONSES = [
    sr.Final("slider.x"),
    sr.Final("slider.velocity.x"),
    sr.Integral("energy.kinetic"),
    sr.At("pin.force.z", time=0.2),
]
NAMES = ["crank.mass", "spring.k", "spring.c", "pin.point.y", "gravity.z", "crank.angular_velocity.x"]
pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # where the crank's rate is changed

every = pytest.mark.parametrize("name", METHODS)


@cache
def swung(name: str) -> sr.Trajectory:
    run = sr.simulate(
        slider_crank(),
        until=0.4,
        t_eval=[0.4],
        method=replace(METHODS[name], rtol=1e-6, atol=1e-8),
        store="steps",
    )
    return solved(run, METHODS[name])


@cache
def adjoint(name: str) -> sr.Gradient:
    return sr.sensitivity(swung(name), RESPONSES)


@pytest.mark.one_in(4)
@every
def test_forward_and_backward_agree(name: str) -> None:
    direct = sr.sensitivity(swung(name), RESPONSES, method="direct")
    scale = abs(direct.matrix).max(axis=1)
    assert np.all(abs(direct.matrix - adjoint(name).matrix).max(axis=1) < 1e-10 * scale)


@pytest.mark.one_in(4)
@every
@pytest.mark.parametrize("number", NAMES)
def test_gradients_are_those_of_differenced_simulations(name: str, number: str) -> None:
    """Differences of reactions have round-off over h² where accelerations are unknowns."""
    wanted = differenced(swung(name), RESPONSES, number, 2e-3, METHODS[name])
    scale = np.maximum(abs(adjoint(name).matrix).max(axis=1), 1e-3)
    assert np.all(abs(adjoint(name)[number] - wanted) < np.array([1e-8, 1e-8, 1e-8, 3e-6]) * scale)


@pytest.mark.one_in(3)
@every
def test_hessians_are_symmetric_and_those_of_differenced_gradients(name: str) -> None:
    response, numbers = RESPONSES[2], ["crank.mass", "spring.k", "gravity.z"]
    found = sr.hessian(swung(name), response, numbers)
    assert found.asymmetry < 1e-8
    for k, number in enumerate(numbers):
        direction = np.eye(len(numbers))[k]
        product = sr.hessian_product(swung(name), response, {number: 1.0}, numbers)
        assert np.allclose(found.matrix @ direction, product, rtol=1e-8, atol=1e-9 * abs(found.matrix).max())
        changes = sr.hessian_product(swung(name), response, {number: 2.0}, numbers)
        assert np.allclose(changes, 2 * product, rtol=1e-12)


def stopped() -> sr.System:
    """A rod that swings against a stop; with next to no inertia impacts would magnify round-off."""
    bob = sr.Body("bob", mass=1, inertia=(0.01, 0.1, 0.1), position=(1, 0, 0))
    pin = sr.Revolute("pin", sr.ground, bob, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.System(sr.Model("rod", bodies=[bob], joints=[pin], gravity=(0, -9.81, 0)))


@pytest.mark.one_in(4)
@every
def test_remainders_of_taylor_series_have_their_orders(name: str) -> None:
    """Of runs with other numbers and the same lengths of steps: 2 behind the gradient, 3 behind the Hessian."""
    run, response, names = swung(name), RESPONSES[2], ["spring.k", "crank.mass"]
    at = dict(zip(names, Parameters(run.system, names).values, strict=True))
    way = {number: 0.2 * value for number, value in at.items()}
    gradient, hessian = sr.sensitivity(run, response, names), sr.hessian(run, response, names)
    d = np.array([way[number] for number in names])
    first, second = gradient.matrix[0] @ d, d @ hessian.matrix @ d
    remainders = []
    for e in (0.4, 0.2, 0.1):
        moved = again(run.system, run.steps, METHODS[name], {n: at[n] + e * way[n] for n in names})
        change = valued(*moved, [response])[0] - gradient.values[0]
        remainders.append((abs(change - e * first), abs(change - e * first - e**2 * second / 2)))
    slopes = np.log2(np.array(remainders[:-1]) / np.array(remainders[1:]))
    assert np.all(abs(slopes - [2, 3]) < 0.25), slopes


@pytest.mark.one_in(3)
@every
def test_checkpoints_give_the_same_gradient(name: str) -> None:
    """Over events, too."""
    system, settings = stopped(), {"until": 1.0, "method": replace(METHODS[name], rtol=1e-6, atol=1e-8)}
    run = sr.simulate(system, t_eval=[1.0], events=STOP, store="steps", **settings)
    assert run.steps.event_steps
    responses = [sr.Final("bob.x"), sr.Integral("energy.kinetic")]
    wanted = sr.sensitivity(run, responses)
    direct = sr.sensitivity(run, responses, method="direct")
    found = by_checkpoints(system, responses, events=STOP, memory=1e6, **settings)
    scale = abs(wanted.matrix).max(axis=1, keepdims=True)
    assert np.all(abs(direct.matrix - wanted.matrix) < 1e-11 * scale)
    assert np.all(abs(found.matrix - wanted.matrix) < 1e-8 * scale)


def test_sweeps_are_compiled_once_for_all_methods() -> None:
    """Whatever the number of stages, and of arrays that are recorded."""
    for name in METHODS:
        operations = Record(swung(name).system, swung(name).steps).run()
        assert len(operations.sources) == SOURCES
    adjoint("HHT")
    sr.sensitivity(swung("HHT"), RESPONSES, method="direct")
    known = {loop: link(loop).signatures for loop in (backward, forward)}
    adjoint("stabilized HHT")
    sr.sensitivity(swung("stabilized HHT"), RESPONSES, method="direct")
    assert known == {loop: link(loop).signatures for loop in (backward, forward)}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("rtol", [1e-4, 1e-7])
@pytest.mark.parametrize("name", ["stabilized HHT", "stabilized generalized-alpha"])
def test_steps_after_an_event_have_pivots_of_their_own(name: str, rtol: float) -> None:
    """The rod is horizontal or upright there: pivots that suit the last step are nothing but round-off."""
    run = sr.simulate(
        stopped(),
        until=1.0,
        events=STOP,
        store="steps",
        method=replace(METHODS[name], rtol=rtol, atol=rtol / 100),
    )
    responses = [sr.Final("bob.x"), sr.Integral("energy.kinetic")]
    direct, adjoint = (sr.sensitivity(run, responses, method=way).matrix for way in ("direct", "adjoint"))
    assert np.all(abs(direct - adjoint) < 1e-11 * abs(adjoint).max(axis=1, keepdims=True))


def test_the_hessian_of_a_stabilized_run_is_that_of_differenced_gradients() -> None:
    """Of runs with other numbers and the same lengths of steps."""

    name, response, numbers = "stabilized HHT", RESPONSES[2], ["spring.k", "crank.mass"]
    run = swung(name)
    found = sr.hessian(run, response, numbers).matrix
    at: dict[str, Any] = dict(zip(numbers, Parameters(run.system, numbers).values, strict=True))

    def gradient(number: str, e: float) -> np.ndarray:
        system, steps = again(run.system, run.steps, METHODS[name], {number: at[number] + e})
        return differentiated(
            system, steps, [response], Parameters(system, numbers, start=steps.start)
        ).matrix[0]

    for k, number in enumerate(numbers):
        slopes = [(gradient(number, e) - gradient(number, -e)) / (2 * e) for e in (4e-3, 2e-3)]
        wanted = (4 * slopes[1] - slopes[0]) / 3
        assert np.allclose(found[k], wanted, rtol=0, atol=1e-6 * abs(wanted).max())
