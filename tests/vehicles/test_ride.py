"""Ride: the weightings of ISO 2631-1, and a vehicle on two wheels over a random road."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lsim

import sarrus as sr
from sarrus.algebra import Array

# ISO 2631-1:1997, table 3: 1000 times the principal frequency weightings at frequencies [Hz]
TABLE = {
    "k": {0.4: 352, 0.5: 418, 1: 482, 2: 531, 4: 967, 5: 1039, 6.3: 1054, 8: 1036, 10: 988, 16: 768, 31.5: 405},
    "d": {0.5: 853, 1: 1011, 2: 890, 4: 512, 8: 253, 16: 125},
}  # fmt: skip
NAMES = sr.VehicleNames(steer="", speed="", brake="", drive="")
SPEED, MASS = 20.0, 400.0
FINE = sr.Radau(rtol=1e-6)


@pytest.mark.parametrize("weighting", TABLE)
def test_the_weightings_are_those_of_the_table(weighting: str) -> None:
    seat = sr.Body("seat", 1.0, (1, 1, 1))
    rail = sr.Translational("rail", sr.ground, seat, point=(0, 0, 0), axis=(0, 0, 1))
    push = [sr.Input("u", 0.0, unit="N"), sr.Force("push", "rail", value="u")]
    filters = sr.weighting_filters("weighted", "seat.velocity.z", weighting)
    system = sr.System(sr.Model("seat", [seat], [rail], [*push, *filters]))
    plant = sr.linearize(system, system.q0, outputs=["weighted.output"])
    for frequency, printed in TABLE[weighting].items():
        of_acceleration = abs(plant.transfer(2j * np.pi * frequency)[0, 0])
        assert of_acceleration == pytest.approx(printed / 1000, abs=1e-3)


def test_an_unknown_weighting_is_refused() -> None:
    with pytest.raises(sr.SarrusError, match="one of k, d, e, got 'z'"):
        sr.weighting_filters("seat", "seat.velocity.z", "z")


def skate(damping: float = 4e3, stiffness: float = 4e4) -> sr.System:
    """A body on two wheels in the plane of x and z, 0.3 m before and behind."""
    height = 0.3 - (MASS + 4.0) * 9.81 / 2 / stiffness
    chassis = sr.Body("chassis", MASS, (40, 40, 40), position=(0, 0, height))
    wheels = [
        sr.Body(f"wheel_{n}", 2.0, (0.2, 0.3, 0.2), position=(x, 0, height))
        for n, x in enumerate((0.3, -0.3))
    ]
    joints = [
        sr.Planar("plane", sr.ground, chassis, point=(0, 0, height), axis=(0, 1, 0)),
        *(sr.Revolute(f"hub_{one.name}", chassis, one, point=one.position, axis=(0, 1, 0)) for one in wheels),
    ]
    numbers = {
        "radius": 0.3,
        "k": stiffness,
        "c": damping,
        "c_kappa": 5e4,
        "c_alpha": 5e4,
        "mu": 1.0,
        "half_length": 0.05,
    }
    tyres = [sr.BrushTyre(f"tyre_{one.name}", one.point(0, 0, 0), **numbers) for one in wheels]
    return sr.System(sr.Model("skate", [chassis, *wheels], joints, tyres, gravity=(0, 0, -9.81)))


def weighted(acceleration: Array, t: Array, at: float) -> float:
    """R.m.s. of the acceleration behind W_k, with numbers of table A.1 and linear interpolation of samples."""
    w = 2 * np.pi * np.array([0.4, 100.0, 12.5, 2.37, 3.35])
    low, high = [1, w[0] * 2**0.5, w[0] ** 2], [1, w[1] * 2**0.5, w[1] ** 2]
    transition = np.array([1 / w[2] ** 2, 1 / (0.63 * w[2]), 1])
    up, down = [1 / w[3] ** 2, 1 / (0.91 * w[3]), 1], [1 / w[4] ** 2, 1 / (0.91 * w[4]), 1]
    above, below = np.array([w[1] ** 2, 0, 0]), np.array([1.0])
    for one in ([1 / w[2], 1], up, [(w[3] / w[4]) ** 2]):
        above = np.polymul(above, one)
    for one in (low, high, transition, down):
        below = np.polymul(below, one)
    _, filtered, _ = lsim((above, below), acceleration, t)
    inside = t >= at
    return float(np.sqrt(np.trapezoid(filtered[inside] ** 2, t[inside]) / (t[-1] - at)))


ROAD = sr.RandomRoad(2e-6, length=100.0, seed=4, start=1.0)


def ridden(damping: float = 4e3) -> sr.Manoeuvre:
    return sr.ride(
        skate(damping), SPEED, ROAD, point=(0.2, 0, 0.1), duration=1.5, at=1.0, names=NAMES, method=FINE
    )


def test_the_weighted_acceleration_is_that_of_a_filter_behind_the_run() -> None:
    result = ridden()
    t = np.arange(0.0, 2.5, 5e-4)
    run = sr.simulate(
        result.run.system, sr.rolling_start(result.run.system, SPEED), until=2.5, t_eval=t, method=FINE
    )
    expected = weighted(run["chassis(0.2, 0, 0.1).acceleration.z"], run.t, 1.0)
    assert result["weighted_z"] == pytest.approx(expected, rel=2e-3)
    assert result["total"] == pytest.approx(np.hypot(result["weighted_z"], result["weighted_x"]), rel=1e-9)
    assert result["dose_z"] == pytest.approx(1.5**0.25 * result["weighted_z"], rel=0.5)


def test_its_derivative_is_that_of_other_runs() -> None:
    result = ridden()
    found = result.sensitivity("weighted_z", ["tyre_wheel_0.c", "tyre_wheel_1.c"]).matrix.sum()
    step = 4.0
    expected = (ridden(4e3 + step)["weighted_z"] - ridden(4e3 - step)["weighted_z"]) / (2 * step)
    assert found == pytest.approx(expected, rel=1e-2)


def test_a_road_that_ends_is_refused() -> None:
    with pytest.raises(sr.SarrusError, match="the road ends at 101 m, before 400 m"):
        sr.ride(skate(), SPEED, ROAD, duration=18.0, names=NAMES)
