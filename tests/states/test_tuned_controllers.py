"""Gains of sampled controllers by `optimize` and `fit`, with exact gradients through the samples."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from tests.states.motors import arm

import sarrus as sr

GOAL, PERIOD, UNTIL = 0.5, 0.04, 0.32


def servo(t: float, o: Any) -> dict[str, Any]:
    """A discrete PID controller whose gains are inputs."""
    error = GOAL - o["pin.angle"]
    sum_of_errors = o["sum"] + PERIOD * error
    return {"u": o["kp"] * error + o["ki"] * sum_of_errors - o["kd"] * o["pin.rate"], "sum": sum_of_errors}


PID = sr.Controller(servo, period=PERIOD, memory={"sum": 0.0})
OFF = sr.Integral(lambda o: (GOAL - o("pin.angle")) ** 2 + 1e-5 * o("u") ** 2, name="cost")
GAINS = ["kp.value", "ki.value", "kd.value"]


def system(kp: float = 40.0, ki: float = 30.0, kd: float = 5.0) -> sr.System:
    gains = (sr.Input(name, value) for name, value in (("kp", kp), ("ki", ki), ("kd", kd)))
    return sr.System(arm(sr.Input("u", unit="N m"), *gains, sr.Torque("motor", "pin", value="u")))


def test_gradients_of_a_problem_with_controllers_are_those_of_its_runs() -> None:
    problem = sr.Problem(system(), OFF, GAINS, until=UNTIL, controllers=[PID], method=sr.Radau(rtol=1e-9))
    for x in (problem.x0, problem.x0 * [1.1, 0.9, 1.2]):
        run = sr.simulate(
            system(*x), until=UNTIL, controllers=[PID], store="steps", method=sr.Radau(rtol=1e-9)
        )
        expected = sr.sensitivity(run, OFF, wrt=GAINS)
        value, gradient = problem.value_and_grad(x)
        assert value == pytest.approx(expected.values[0], rel=1e-12)
        assert gradient == pytest.approx(expected.matrix[0], rel=1e-9)


@pytest.mark.slow
def test_gains_of_a_pid_controller_are_tuned() -> None:
    """The best cost is that of a run with the best gains, and a change of 3 % of one is worse."""
    bounds = {"kp.value": (10, 300), "kd.value": (1, 40)}
    best = sr.optimize(system(), OFF, list(bounds), bounds=bounds, until=UNTIL, controllers=[PID])
    assert best.success
    kp, kd = best.x
    designs = [(kp, kd), (0.97 * kp, kd), (1.03 * kp, kd), (kp, 0.97 * kd), (kp, 1.03 * kd)]
    costs = [cost(system(kp, kd=kd)) for kp, kd in designs]
    assert best.value == pytest.approx(costs[0], rel=1e-5)
    assert costs[0] == min(costs)
    assert [type(force) for force in best.model.forces] == [type(force) for force in system().model.forces]


def cost(system: sr.System) -> float:
    """The cost of a run."""
    run = sr.simulate(system, until=UNTIL, controllers=[PID], store="steps")
    return float(sr.sensitivity(run, OFF, wrt=["kp.value"]).values[0])


@pytest.mark.slow
def test_gains_are_fitted_to_a_measured_motion() -> None:
    times = np.linspace(0.02, UNTIL, 16)
    measured = sr.simulate(system(45.0, kd=6.0), until=UNTIL, t_eval=times, controllers=[PID])["pin.angle"]
    misfit = sr.Misfit("pin.angle", at=times, data=measured, sigma=1e-4)
    found = sr.fit(system(), misfit, ["kp.value", "kd.value"], controllers=[PID])
    assert found.x == pytest.approx([45.0, 6.0], rel=1e-3)


@pytest.mark.slow
def test_starts_in_other_threads_have_the_same_controllers() -> None:
    bounds = {"kd.value": (2.0, 20.0)}
    with ThreadPoolExecutor(1) as executor:
        best = sr.optimize(
            system(),
            OFF,
            ["kd.value"],
            bounds=bounds,
            until=UNTIL,
            controllers=[PID],
            starts=2,
            executor=executor,
        )
    assert best.success
    assert "sum" not in {force.name for force in best.model.forces}


def test_what_is_not_supported_with_controllers_is_refused() -> None:
    one = system()
    with pytest.raises(ValueError, match="memory is not supported with controllers"):
        sr.Problem(one, OFF, GAINS, until=UNTIL, controllers=[PID], memory=1e6)
    with pytest.raises(ValueError, match="start must be None or a mapping"):
        sr.Problem(one, OFF, GAINS, until=UNTIL, controllers=[PID], start=sr.assemble(one))
    with pytest.raises(TypeError, match="controllers, method and memory are those of a simulation"):
        sr.Problem(one, sr.Final("pin.angle"), GAINS, analysis=sr.Statics(), controllers=[PID])
