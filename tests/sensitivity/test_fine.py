"""Integrals, peaks and maxima over the long steps of Radau, also where events cut them: closed forms, both sweeps."""

import numpy as np
import pytest
from tests.sensitivity.test_events import BALL, BOUNCE, HIT, SIGN, STOP, ball, hung, pendulum
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.responses.evaluation import Evaluation
from sarrus.analyses.sensitivity.responses.panels import Layout, Panels, Steps
from sarrus.analyses.sensitivity.sampling.segments import Course

STRETCH = sr.Integral(lambda o: o("ball.z") ** 2 + o.t * o("ball.velocity.z"), name="stretch")


def flown(z: complex, v: complex, g: complex, begun: complex, t: complex) -> complex:
    """∫ (z² + t ż) dt of a flight from `begun` for a time t."""
    heights = z**2 * t + z * v * t**2 + (v**2 - g * z) * t**3 / 3 - g * v * t**4 / 4 + g**2 * t**5 / 20
    return heights + begun * (v * t - g * t**2 / 2) + v * t**2 / 2 - g * t**3 / 3


def bounced(h: complex, e: complex, g: complex, v0: complex) -> complex:
    """The same of the ball with three impacts in 2 s."""
    z, v, t, total = h, v0, 0.0, 0.0
    for _ in range(3):
        down = np.sqrt(v**2 + 2 * g * z)
        flight = (v + down) / g
        total, t = total + flown(z, v, g, t, flight), t + flight
        z, v = 0.0, e * down
    return total + flown(z, v, g, t, 2.0 - t)


@pytest.mark.parametrize("method", ["adjoint", "direct"])
def test_an_integral_with_impacts_is_exact_where_the_motion_is_a_polynomial(method: str) -> None:
    """Of its derivative, too, in which events move the times of all nodes."""
    numbers = {"h": 1.0, "e": 0.8, "g": 9.81, "v0": 0.5}
    run = sr.simulate(ball(), until=2.0, events=BOUNCE, store="steps", method=sr.Radau())
    assert len(run.events) == 3
    found = sr.sensitivity(run, STRETCH, list(BALL.values()), method=method)
    assert found.values[0] == pytest.approx(bounced(**numbers), rel=1e-12)
    for name in numbers:
        moved = numbers | {name: numbers[name] + 1e-30j}
        wanted = SIGN.get(name, 1.0) * bounced(**moved).imag / 1e-30
        assert found[BALL[name]] == pytest.approx(wanted, rel=1e-9), name


def test_responses_over_a_motion_with_a_stop() -> None:
    """They have as many digits as the motion, which a finer run tells."""
    responses = [
        sr.Integral(lambda o: o("bob.y") ** 2, name="integral"),
        sr.Maximum("bob.velocity.x"),
    ]
    names, found = ["L", "g", "theta0"], []
    design = {"L": 1.0, "g": 9.81, "theta0": np.pi / 2}
    for tolerance in (1e-6, 1e-8, 1e-11):
        settings = {"method": sr.Radau(rtol=tolerance, atol=tolerance), "store": "steps"}
        run = sr.simulate(pendulum(), until=2.0, events=STOP, **settings)
        found.append(sr.sensitivity(run, responses, names, design=design, formula=hung))
        direct = sr.sensitivity(run, responses, names, design=design, formula=hung, method="direct")
        assert direct.matrix == pytest.approx(found[-1].matrix, rel=1e-8)
    errors = [abs(one.matrix - found[-1].matrix).max(axis=1) for one in found[:2]]
    assert np.all(errors[0] > 8 * errors[1]), errors
    assert errors[1].max() < 1e-6, errors


FORCES = [
    sr.At("pin.force.z", time=0.271),
    sr.Integral(lambda o: o("pin.force.z") ** 2, name="squared"),
    sr.At("guide.torque.y", time=0.013),
]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("events", [[], [HIT]], ids=["smooth", "impact"])
def test_forces_between_steps(events: object) -> None:
    """They have as many digits as the motion, and so have their gradients, on both sides of an impact."""
    names, found = ["spring.k", "rod.mass", "pin.point.y", "crank.angular_velocity.x"], []
    for tolerance in (1e-5, 1e-9, 1e-11):
        settings = {"method": sr.Radau(rtol=tolerance, atol=tolerance), "store": "steps"}
        run = sr.simulate(slider_crank(), until=0.4, events=events, **settings)
        assert len(run.events) == len(events)
        found.append(sr.sensitivity(run, FORCES, names))
        direct = sr.sensitivity(run, FORCES, names, method="direct")
        assert direct.matrix == pytest.approx(found[-1].matrix, rel=1e-7, abs=1e-9 * abs(direct.matrix).max())
    scale = abs(found[-1].matrix).max(axis=1)
    errors = [(abs(one.matrix - found[-1].matrix).max(axis=1) / scale).max() for one in found[:2]]
    assert errors[0] > 8 * errors[1], errors
    assert errors[1] < 1e-7, errors
    given = sr.simulate(slider_crank(), until=0.4, events=events, t_eval=[0.013, 0.271], **settings)
    force = [given.reaction("pin").force[1, 2], given.reaction("guide").torque[0, 1]]
    assert found[1].values[[0, 2]] == pytest.approx(force, rel=1e-6, abs=1e-7)


def test_names_and_numbers_of_samples() -> None:
    run = sr.simulate(slider_crank(), until=0.2, store="steps", method=sr.Radau())
    found = sr.sensitivity(run, [sr.Integral("slider.x"), sr.Maximum("slider.x")], ["spring.k"])
    assert found.responses == ("integral of slider.x", "maximum of slider.x")
    steps = Steps.of(Course([np.array([0.0, 0.1, 0.4])], ()))
    times = Panels.some(slice(0, 2)).where(steps).t
    assert len(times) == 8
    integral = sr.Integral("slider.x", layout=Layout(np.zeros(0, int)))
    for power in range(6):  # exact up to degree five
        assert integral.value(times**power, times) == pytest.approx(0.4 ** (power + 1) / (power + 1))


def test_an_output_that_is_faster_than_the_steps_is_no_silent_one() -> None:
    """A wave of 64 periods in the few steps of a flight: the estimate and a finer run show that it is not resolved."""
    body = sr.Body("glider", 1.0, (0.1,) * 3, velocity=(2, 0, 0))
    run = sr.simulate(sr.System(sr.Model("glider", [body], gravity=(0, 0, -9.81))), until=1.0, store="steps")
    wave = sr.Integral(lambda o: np.sin(100 * o("glider.x")) ** 2, name="wave")
    found, exact = run.error(wave), 0.5 - np.sin(400) / 800
    assert run.nsteps < 60
    assert 1e-3 < abs(found.value - exact) < 3 * found.error
    assert not sr.verify(run, wave).agree


def test_samples_are_four_in_each_step() -> None:
    """Whatever the output does: no step is sampled again, so that the cost is that of the samples."""
    run = sr.simulate(slider_crank(), until=0.2, store="steps")
    for response in (sr.Integral("slider.x"), sr.Integral(lambda o: o("slider.acceleration.x") ** 2)):
        found = Evaluation(run.system, run.steps, [response], Parameters(run.system, []))
        assert len(found.signals[0]) == 4 * len(run.steps)
