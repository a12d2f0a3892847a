"""Responses of motions that drivers prescribe, whose steps are longer than the reactions change."""

from dataclasses import replace

import numpy as np
import pytest

import sarrus as sr

TIMES = np.linspace(0.0, 1.0, 4001)


def crank_rocker(rocker_mass: float = 0.4) -> sr.System:
    """A four-bar with lengths 80, 240, 180, 220 mm, driven at one revolution per second."""
    z, a, d, c = (0, 0, 1), (0.08, 0, 0), (0.22, 0, 0), (0.24, 0.16 * 1.25**0.5, 0)
    crank = sr.Body("crank", 0.2, (1e-4, 1e-4, 1e-4), position=(0.04, 0, 0))
    coupler = sr.Body("coupler", 0.6, (3e-3, 3e-3, 3e-3), position=(0.16, c[1] / 2, 0))
    rocker = sr.Body("rocker", rocker_mass, (1e-3, 1e-3, 1e-3), position=(0.23, c[1] / 2, 0))
    joints = [
        sr.Revolute("A", sr.ground, crank, point=(0, 0, 0), axis=z),
        sr.Revolute("B", crank, coupler, point=a, axis=z),
        sr.Revolute("C", coupler, rocker, point=c, axis=z),
        sr.Revolute("D", sr.ground, rocker, point=d, axis=z),
    ]
    motor = sr.AngleDriver("motor", "A", "2*pi*t")
    bodies = [crank, coupler, rocker]
    return sr.System(sr.Model("crank-rocker", bodies, joints, drivers=[motor], gravity=(0, -9.81, 0)))


def expected(system: sr.System) -> np.ndarray:
    """The largest torque of the motor, and the integral of its square, of the motion at many times."""
    torque = sr.kinematics(system, TIMES)["motor.torque.z"]
    n = torque.argmax()
    curve = np.polynomial.Polynomial.fit(TIMES[n - 2 : n + 3], torque[n - 2 : n + 3], 4)
    top = max(curve(x.real) for x in curve.deriv().roots() if abs(x - TIMES[n]) < TIMES[1])
    return np.array([top, np.trapezoid(torque**2, TIMES)])


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("method", "digits"), [(sr.Radau(), 2e-5), (sr.HHT(), 1e-4)])
def test_extremes_and_integrals_of_reactions_are_those_of_the_prescribed_motion(method, digits):
    """Fourteen steps for one revolution are exact, but reactions between them are not polynomials through them.

    An integral of reactions needs `max_step`; a maximum is that of the reactions that the run reports.
    """
    responses = [sr.Maximum("motor.torque.z"), sr.Integral(lambda o: o("motor.torque.z") ** 2, name="square")]
    run = sr.simulate(crank_rocker(), until=1.0, method=replace(method, max_step=0.02), store="steps")
    found = sr.sensitivity(run, responses, ["rocker.mass"])
    assert found.values == pytest.approx(expected(crank_rocker()), rel=digits)
    change = 1e-4
    slopes = (expected(crank_rocker(0.4 + change)) - expected(crank_rocker(0.4 - change))) / (2 * change)
    assert found["rocker.mass"] == pytest.approx(slopes, rel=10 * digits)


def test_error_estimate_contains_what_is_interpolated():
    """The estimate is not that of the steps alone, which are exact."""
    run = sr.simulate(crank_rocker(), until=1.0, store="steps")
    found = run.error(sr.Integral(lambda o: o("motor.torque.z") ** 2, name="square"))
    exact = expected(crank_rocker())[1]
    assert 1e-3 * exact < abs(found.value - exact) < 3 * found.error
    assert abs(found.corrected - exact) < 0.5 * abs(found.value - exact)
