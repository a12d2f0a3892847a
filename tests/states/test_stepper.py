"""Motion sample by sample against SciPy on the reduced equations; copies and restored states to the same bits."""

import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.states.motors import INERTIA, WEIGHT, arm

import sarrus as sr
from sarrus.model import SarrusError

OUTPUTS = ("pin.angle", "pin.rate", "u", "arm.x", "lag")
STEP = 0.01


def controlled() -> sr.System:
    """The arm with a torque that is set, and a lag of it."""
    lag = sr.FirstOrderLag("lag", input="u", time=0.05)
    motor = sr.Torque("motor", "pin", value="u - 0.5*pin.rate")
    return sr.System(arm(sr.Input("u", unit="N m"), lag, motor))


def stepper(start: Any = None, **options: Any) -> sr.Stepper:
    """At its start."""
    return sr.Stepper(controlled(), start, step=STEP, outputs=OUTPUTS, **options)


def torque(k: int) -> float:
    """A torque that jumps at every sample; it turns the arm several times."""
    return 14.0 + 5.0 * (-1) ** k


def by_scipy(samples: int) -> np.ndarray[Any, Any]:
    """Angle, rate and the lag."""
    y = np.zeros(3)
    for k in range(samples):

        def rates(t: float, y: Any, u: float = torque(k)) -> list[float]:
            return [y[1], (u - 0.5 * y[1] - WEIGHT * np.cos(y[0])) / INERTIA, (u - y[2]) / 0.05]

        y = solve_ivp(rates, (0, STEP), y, rtol=1e-12, atol=1e-13).y[:, -1]
    return np.asarray(y)


def test_samples_are_those_of_the_reduced_equations() -> None:
    own, samples = stepper(method=sr.Radau(rtol=1e-10)), 150
    for k in range(samples):
        found = own.advance(torque(k))
    angle, rate, lag = by_scipy(samples)
    assert angle > 2 * np.pi
    exact = [angle, rate, torque(samples - 1), 0.5 * np.cos(angle), lag]
    assert found == pytest.approx(exact, rel=1e-7)
    assert own.t == pytest.approx(1.5, abs=1e-15)
    assert own.values == pytest.approx(found, abs=0.0)


@pytest.mark.parametrize(
    "method",
    [sr.HHT(), sr.HHT(stabilized=True), sr.GeneralizedAlpha(), sr.HHT(step=1e-3)],
    ids=["HHT", "stabilized", "generalized-α", "fixed"],
)
def test_samples_by_methods_of_order_two(method: Any) -> None:
    """Whose accelerations are those of the new inputs after each jump: else errors would be of order one."""
    own = stepper(method=replace(method, rtol=1e-8))
    for k in range(50):
        found = own.advance(torque(k))
    angle, rate, lag = by_scipy(50)
    assert found == pytest.approx([angle, rate, torque(49), 0.5 * np.cos(angle), lag], rel=5e-5)


def test_a_method_without_stored_steps_is_refused() -> None:
    for method in (3, sr.ODE()):
        with pytest.raises(TypeError, match=r"Radau\(\) or a Description, got .* Leave it out for Radau"):
            stepper(method=method)


@pytest.mark.parametrize("method", [None, sr.HHT()], ids=["Radau", "HHT"])
def test_a_restored_state_and_a_copy_go_on_to_the_same_bits(method: Any) -> None:
    own = stepper(method=method)
    for k in range(20):
        own.advance(torque(k))
    state, other = own.state(), own.copy()
    later = [own.advance(torque(k)) for k in range(20, 60)]
    assert np.array_equal([other.advance(torque(k)) for k in range(20, 60)], later)
    own.restore(state)
    assert own.t == pytest.approx(0.2)
    assert np.array_equal([own.advance(torque(k)) for k in range(20, 60)], later)
    assert np.array_equal(own.q, other.q)
    assert np.array_equal(own.v, other.v)
    assert own.steps == other.steps


def test_any_start_time_with_revolutions() -> None:
    """A stepper goes on from a state of a run, whose angle has turned."""
    system = controlled()
    run = sr.simulate(system, until=1.5, inputs={"u": 14.0})
    assert run["pin.angle"][-1] > 2 * np.pi
    own = stepper(run.final)
    assert own.values[0] == pytest.approx(run["pin.angle"][-1])
    assert own.t == 1.5
    for _ in range(20):
        found = own.advance({"u": 14.0})
    whole = sr.simulate(system, until=1.7, inputs={"u": 14.0})
    assert found[:2] == pytest.approx([whole["pin.angle"][-1], whole["pin.rate"][-1]], rel=1e-5)


def test_other_inputs_follow_their_laws() -> None:
    """Points of a table that is not set are hit within samples."""
    table = [[0, 0], [0.03, 2], [0.07, 3], [0.11, 1], [0.16, 2], [0.2, 2]]
    model = arm(sr.Input("w", table), sr.Input("u"), sr.Torque("motor", "pin", value="u + w"))
    own = sr.Stepper(sr.System(model), step=0.05, outputs=["pin.angle", "w"], method=sr.Radau(rtol=1e-10))
    for _ in range(4):
        found = own.advance(2.0)
    run = sr.simulate(sr.System(model), until=0.2, inputs={"u": 2.0}, method=sr.Radau(rtol=1e-12))
    assert found == pytest.approx([run["pin.angle"][-1], 2.0], rel=1e-7)


def test_redundant_constraints() -> None:
    """A second pin on the same axis repeats equations."""
    model = arm(sr.Input("u", 1.0), sr.Torque("motor", "pin", value="u"))
    again = sr.Revolute("again", sr.ground, model.bodies[0], point=(0, 0, 0.2), axis=(0, 0, 1))
    double = sr.Model("arm", model.bodies, [*model.joints, again], model.forces, gravity=model.gravity)
    systems = [sr.System(one) for one in (model, double)]
    found = [
        sr.Stepper(one, step=STEP, inputs=["u"], outputs=["pin.angle"], method=sr.Radau(rtol=1e-9))
        for one in systems
    ]
    for k in range(20):
        values = [one.advance(torque(k)) for one in found]
    assert values[0] == pytest.approx(values[1], rel=1e-6)


def test_what_cannot_be_stepped_is_refused() -> None:
    with pytest.raises(ValueError, match="input u must be finite"):
        stepper().advance(np.nan)
    with pytest.raises(SarrusError, match="no input of this stepper"):
        stepper().advance({"v": 1.0})
    for options, message in (
        ({"outputs": ["pin.force.x"]}, "pin.force.x is no output of positions"),
        ({"inputs": ["v"]}, 'no input "v"'),
        ({"inputs": ["u", "u"]}, 'inputs contains "u" more than once. Name each input once'),
        ({"inputs": []}, "the input u is not set"),
    ):
        given: Any = options
        with pytest.raises(SarrusError, match=message):
            sr.Stepper(controlled(), step=STEP, **given)
    law = sr.System(arm(sr.Input("u", "t"), sr.Torque("motor", "pin", value="u")))
    with pytest.raises(SarrusError, match="follows a law over time"):
        sr.Stepper(law, step=STEP, inputs=["u"])
    model = arm(sr.Input("u", 0.1, unit="rad"))
    driven = sr.Model(
        "arm", model.bodies, model.joints, model.forces, drivers=[sr.AngleDriver("turn", "pin", "u")]
    )
    with pytest.raises(SarrusError, match="drivers follow the input u"):
        sr.Stepper(sr.System(driven), step=STEP, inputs=["u"])


def test_a_motion_that_cannot_go_on_is_an_error() -> None:
    own = sr.Stepper(sr.System(arm(sr.Torque("motor", "pin", value="1/(0.05 - t)^2"))), step=STEP)
    for _ in range(4):
        own.advance()
    with pytest.raises(SarrusError, match="small"):
        own.advance()
    assert own.t < 0.06


@pytest.mark.slow
def test_the_overhead_of_a_sample_is_small() -> None:
    """Against the same steps in one call, in processor time; 5 µs where it was measured."""
    model = sr.load("slider_crank")
    motor = sr.Torque("motor", "pin", value="u")
    system = sr.System(sr.Model("crank", model.bodies, model.joints, [*model.forces, sr.Input("u"), motor]))
    own, count, times = sr.Stepper(system, step=1e-3), 400, [list[float](), list[float]()]
    own.advance(0.0)
    for _ in range(7):
        begun = time.process_time()
        for _ in range(count):
            own.advance(0.0)
        times[0].append((time.process_time() - begun) / count)
        method = own._method
        begun = time.process_time()
        _, taken = method._advance(method.run()._replace(h_max=1e-3), own.t + 0.4, count)
        assert taken == count
        times[1].append((time.process_time() - begun) / count)
        own._first += count * own.step
    assert min(times[0]) - min(times[1]) < 20e-6
