"""Derivatives of motions that roll without slip: of every method, of both directions and orders, over an event."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.analyses.rolling import leaning
from tests.analyses.test_descriptions import METHODS
from tests.sensitivity.frozen import again, differenced, solved

import sarrus as sr
from sarrus.analyses.sensitivity.derivatives import differentiated
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.model.written import with_numbers

RESPONSES = [
    sr.Final("disc.x"),
    sr.Final("disc.velocity.y"),
    sr.Integral("disc.z"),
    sr.At("rolls.force.z", time=0.2),
]
NAMES = ["rolls.radius", "disc.mass", "spring.k", "spring.c", "disc.angular_velocity.y"]
WALL = sr.Event("disc.x - 0.4", direction=1, reset=sr.Impact(0.6), name="wall")
pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # where rate or radius is changed
every = pytest.mark.parametrize("name", METHODS)


def coin() -> sr.System:
    return leaning(0.25, (0.5, 6.0, 1.0), k=5.0, c=0.3)


@cache
def rolled(name: str) -> sr.Trajectory:
    run = sr.simulate(
        coin(), until=0.4, t_eval=[0.4], method=replace(METHODS[name], rtol=1e-6, atol=1e-8), store="steps"
    )
    return solved(run, METHODS[name])


@cache
def adjoint(name: str) -> sr.Gradient:
    return sr.sensitivity(rolled(name), RESPONSES)


@pytest.mark.slow
@every
def test_forward_and_backward_agree(name: str) -> None:
    direct = sr.sensitivity(rolled(name), RESPONSES, method="direct")
    scale = abs(direct.matrix).max(axis=1)
    assert np.all(abs(direct.matrix - adjoint(name).matrix).max(axis=1) < 1e-10 * scale)


@pytest.mark.slow
@every
@pytest.mark.parametrize("number", NAMES)
def test_gradients_are_those_of_differenced_simulations(name: str, number: str) -> None:
    wanted = differenced(rolled(name), RESPONSES, number, 1e-3, METHODS[name])
    scale = np.maximum(abs(adjoint(name).matrix).max(axis=1), 1e-3)
    assert np.all(abs(adjoint(name)[number] - wanted) < np.array([1e-7, 1e-7, 1e-7, 3e-6]) * scale)


@pytest.mark.slow
@every
def test_hessian_products_are_those_of_differenced_gradients(name: str) -> None:
    run, names = rolled(name), ["rolls.radius", "disc.mass", "spring.k"]
    for response in RESPONSES[:3]:
        found = sr.hessian(run, response, names)
        assert found.asymmetry < 1e-8
        at, e = 0.3, 1e-4
        ends = []
        for radius in (at + e, at - e):
            system, steps = again(run.system, run.steps, METHODS[name], {"rolls.radius": radius})
            parameters = Parameters(system, names, start=steps.start)
            ends.append(differentiated(system, steps, [response], parameters).matrix[0])
        wanted = (ends[0] - ends[1]) / (2 * e)
        assert np.allclose(found.matrix[:, 0], wanted, rtol=1e-5, atol=1e-6 * abs(found.matrix).max())


def against_a_wall(changes: dict[str, float]) -> sr.Trajectory:
    """The coin strikes a wall: an impact along an output, with the impulses of rolling."""
    system = sr.System(with_numbers(coin().model, changes))
    settings = {"method": sr.Radau(rtol=1e-10, atol=1e-12), "store": "steps"}
    run = sr.simulate(system, until=0.5, t_eval=[0.5], events=WALL, **settings)
    assert run.steps.event_steps
    return run


@pytest.mark.slow
def test_derivatives_over_an_impact() -> None:
    names = ["rolls.radius", "disc.mass", "spring.k", "wall.restitution"]
    run, responses = against_a_wall({}), RESPONSES[:3]
    for q, v in zip(run.q, run.v, strict=True):
        assert abs(run.system.Phi_q_xi(q, v)).max() < 1e-9
    found = sr.sensitivity(run, responses, names)
    direct = sr.sensitivity(run, responses, names, method="direct")
    scale = abs(found.matrix).max(axis=1, keepdims=True)
    assert np.all(abs(found.matrix - direct.matrix) < 1e-10 * scale)
    hessian, e = sr.hessian(run, responses[0], names), 1e-4
    for k, (name, at) in enumerate({"rolls.radius": 0.3, "disc.mass": 2.0, "spring.k": 5.0}.items()):
        ends = [against_a_wall({name: at + d}) for d in (e, -e)]
        values = [np.array([sr.sensitivity(one, r, names).values[0] for r in responses]) for one in ends]
        assert np.allclose(found.matrix[:, k], (values[0] - values[1]) / (2 * e), rtol=1e-5, atol=1e-5)
        gradients = [sr.sensitivity(one, responses[0], names).matrix[0] for one in ends]
        wanted = (gradients[0] - gradients[1]) / (2 * e)
        assert np.allclose(hessian.matrix[k], wanted, rtol=1e-4, atol=1e-5 * abs(hessian.matrix).max())
