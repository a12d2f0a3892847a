"""The HMMWV on tyres that lift off: over a bump against a reference, and dropped."""

import dataclasses
from collections.abc import Callable
from math import pi
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.functions import positive, sin

REFERENCE = Path(__file__).parent.parent / "reference"
MODEL = sr.load(mechanisms.path("hmmwv"))


def on_road(**bumps: Callable[[float], float]) -> sr.System:
    """The shipped vehicle with its bilateral tyres exchanged."""
    forces = [
        sr.RoadTyre(f.name, f.point, f.k, f.c, f.radius, bump=bumps.get(f.name, 0.0))
        if isinstance(f, sr.Tyre)
        else f
        for f in MODEL.forces
    ]
    return sr.System(dataclasses.replace(MODEL, forces=forces))


def wave(start: float) -> Callable[[float], float]:
    """6 cm high, from `start` on for 0.4 s."""
    return lambda t: 0.06 * sin(pi * (t - start) / 0.4) ** 4 * positive(t - start) * positive(start + 0.4 - t)


def test_on_the_ground_they_are_the_bilateral_ones() -> None:
    flat, bilateral = on_road(), sr.System(MODEL)
    q, v = flat.q0, np.zeros(flat.nq)
    v[2::7] = 0.01
    assert np.array_equal(flat.Q(q, v), bilateral.Q(q, v))
    assert abs(flat.Q_q(q, v) - bilateral.Q_q(q, v)).max() < 1e-9


def test_over_a_bump_the_vehicle_follows_the_reference() -> None:
    reference = np.genfromtxt(REFERENCE / "hmmwv_T2.csv", delimiter=",", names=True)
    system = on_road(tyre_front_left=wave(0.2), tyre_rear_left=wave(0.55))
    times = reference["t"][reference["t"] <= 1.0]
    run = sr.simulate(system, until=1.0, t_eval=times, method=sr.ODE(rtol=1e-9, atol=1e-11))
    for k, axis in enumerate("xyz"):
        assert np.allclose(run["chassis"].position[:, k], reference[axis][: len(times)], atol=2e-7)


def test_dropped_it_leaves_the_ground_and_settles_where_the_bilateral_one_rests() -> None:
    system = on_road()
    q = system.q0.copy()
    q[2::7] += 0.06
    start = dataclasses.replace(sr.assemble(system), q=q)
    run = sr.simulate(system, start, until=4.0, t_eval=[0.02, 4.0], method=sr.ODE(rtol=1e-6, atol=1e-8))
    masses = np.array([body.mass for body in MODEL.bodies])
    fall = masses @ (q - run.q[0])[2::7] / masses.sum()
    assert fall == pytest.approx(9.81 * 0.02**2 / 2, rel=1e-6)  # no tyre holds it
    assert np.allclose(run.q[-1].reshape(-1, 7)[:, 2], system.q0.reshape(-1, 7)[:, 2], atol=3e-4)


@pytest.mark.slow
def test_a_profile_is_felt_where_the_wheel_is() -> None:
    """A mass on a road z = 0.02 sin(3 x) at a steady speed rides as on a bump in time."""
    rides = []
    for given in ({"road": lambda x: 0.02 * sin(3 * x)}, {"bump": lambda t: 0.02 * sin(3 * 4 * t)}):
        wheel = sr.Body("wheel", 100.0, (1, 1, 1), position=(0, 0, 0.49), velocity=(4.0, 0, 0))
        tyre = sr.RoadTyre("tyre", wheel.point(0, 0, 0), k=1e5, c=500.0, radius=0.5, **given)
        system = sr.System(sr.Model("m", [wheel], forces=[tyre], gravity=(0, 0, -9.81)))
        run = sr.simulate(system, until=2.0, method=sr.ODE(rtol=1e-9, atol=1e-11))
        rides.append(run["wheel"].position[:, 2])
        assert system.check_derivatives()
    assert np.allclose(*rides, atol=1e-7)
    assert np.ptp(rides[0]) > 0.03
