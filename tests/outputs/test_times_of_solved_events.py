"""Times of events of accelerations and reactions have derivatives: against closed forms, and in both directions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import sarrus as sr
from sarrus.model.written import with_numbers

METHODS = {"Radau": sr.Radau(), "HHT": sr.HHT(), "stabilized": sr.GeneralizedAlpha(stabilized=True)}
PRECISE = {"rtol": 1e-9, "atol": 1e-11}
COARSE = {"rtol": 1e-6, "atol": 1e-8}
LENGTH, MASS, GRAVITY, WEIGHT = 1.0, 2.0, 9.81, 1e-9


def pendulum() -> sr.System:
    """A heavy point that falls from the horizontal; the force of its pin is 3 m g sin(angle) along the rod."""
    bob = sr.Body("bob", mass=MASS, inertia=(WEIGHT,) * 3, position=(LENGTH, 0, 0))
    pin = sr.Revolute("pin", sr.ground, bob, point=(0, 0, 0), axis=(0, 1, 0))
    return sr.System(sr.Model("pendulum", bodies=[bob], joints=[pin], gravity=(0, 0, -GRAVITY)))


def time_to(sine: float, gravity: float) -> float:
    """When sin(angle) has a value, from the horizontal: angle' = sqrt(2 g sin(angle) / l)."""
    whole = np.arcsin(sine)
    return float(quad(lambda u: 2 * u / np.sqrt(2 * gravity / LENGTH * np.sin(u * u)), 0, np.sqrt(whole))[0])


def slope(value, x: float) -> float:
    """The derivative of a closed form, by central differences of order eight."""
    h, weights = 1e-2 * x, (4 / 5, -1 / 5, 4 / 105, -1 / 280)
    return sum(w * (value(x + k * h) - value(x - k * h)) / h for k, w in enumerate(weights, start=1))


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_the_time_at_which_a_pin_bears_a_load(method: str) -> None:
    """sin(angle) = F / (3 m g): by the mass it is the angle alone that moves, by gravity also the fall."""
    load = 40.0
    event = sr.Event("sqrt(pin.force.x**2 + pin.force.z**2) - 40", direction=1, terminal=True, name="load")
    accuracy = PRECISE if method == "Radau" else COARSE
    fall = sr.simulate(
        pendulum(), until=1.0, events=event, method=replace(METHODS[method], **accuracy), store="steps"
    )
    responses = [sr.AtEvent("t", event="load"), sr.AtEvent("bob.x", event="load")]
    found, forward = (
        sr.sensitivity(fall, responses, ["bob.mass", "gravity.z"], method=way)
        for way in ("adjoint", "direct")
    )
    assert np.allclose(found.matrix, forward.matrix, rtol=1e-9)

    def time(mass: float, gravity: float) -> float:
        return time_to(load / (3 * mass * gravity), gravity)

    rel = 1e-5 if method == "Radau" else 1e-3
    assert found.values[0] == pytest.approx(time(MASS, GRAVITY), rel=rel)
    wanted = [slope(lambda m: time(m, GRAVITY), MASS), -slope(lambda g: time(MASS, g), GRAVITY)]
    assert found.matrix[0] == pytest.approx(wanted, rel=rel)
    sine = load / (3 * MASS * GRAVITY)
    by_sine = -LENGTH * sine / np.sqrt(1 - sine**2)  # x = l cos(angle)
    assert found.matrix[1] == pytest.approx([-by_sine * sine / MASS, by_sine * sine / GRAVITY], rel=rel)


def test_the_time_at_which_a_driver_needs_a_torque() -> None:
    """A motor lifts an arm: its torque depends on the time through the driver alone."""
    arm = sr.Body("arm", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 1, 0))
    motor = sr.AngleDriver("motor", "pin", lambda t: 1.5 * t**2)
    one = sr.System(sr.Model("crane", bodies=[arm], joints=[pin], drivers=[motor], gravity=(0, 0, -GRAVITY)))
    # about y, from the balance of moments: I a - m g l cos(angle), I = 0.1 + 2 / 4
    event = sr.Event("motor.torque.y - 6", terminal=True, name="strong")
    run = sr.simulate(one, until=2.0, events=event, method=sr.Radau(**PRECISE), store="steps")
    assert run.status == "event"
    t = run.events[0].t
    angle, inertia = 1.5 * t * t, 0.6
    assert inertia * 3.0 - 2.0 * GRAVITY * 0.5 * np.cos(angle) == pytest.approx(6.0, rel=1e-6)
    found = sr.sensitivity(run, sr.AtEvent("t", event="strong"), ["arm.mass", "gravity.z"])
    rate = 2.0 * GRAVITY * 0.5 * np.sin(angle) * 3.0 * t
    by_mass = 0.25 * 3.0 - GRAVITY * 0.5 * np.cos(angle)
    assert found.matrix[0] == pytest.approx([-by_mass / rate, -2.0 * 0.5 * np.cos(angle) / rate], rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rod.acceleration.y", "pin.multiplier.2", "slider.acceleration.x"])
def test_states_after_a_reset_follow_the_time_of_the_event(name: str) -> None:
    """Against runs of changed models, whose differences are known to seven digits."""

    system = sr.System(sr.load("slider_crank"))
    free = sr.simulate(system, until=0.3, method=sr.Radau(**PRECISE))
    middle = float(np.interp(0.15, free.t, free[name]))
    event = sr.Event(f"{name} - {middle}", name="here", reset=lambda t, q, v: 0.9 * v)
    run = sr.simulate(system, until=0.3, events=event, method=sr.Radau(**PRECISE), store="steps")
    assert run.events
    wrt = ["rod.mass", "spring.k"]
    responses = [sr.AtEvent("t", event="here"), sr.Final("slider.x"), sr.Final(name)]
    back, forward = (sr.sensitivity(run, responses, wrt, method=way) for way in ("adjoint", "direct"))
    assert np.allclose(back.matrix, forward.matrix, rtol=1e-8, atol=1e-10)
    for k, parameter in enumerate(wrt):
        base, h = back.at[k], 1e-4 * back.at[k]
        ends = []
        for sign in (1, -1):
            moved = sr.System(with_numbers(sr.load("slider_crank"), {parameter: base + sign * h}))
            other = sr.simulate(moved, until=0.3, events=event, method=sr.Radau(**PRECISE))
            ends.append(np.array([other.events[0].t, other["slider.x"][-1], other[name][-1]]))
        difference = (ends[0] - ends[1]) / (2 * h)
        assert back.matrix[:, k] == pytest.approx(difference, rel=1e-4, abs=1e-5)
