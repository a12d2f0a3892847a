"""Energies that trajectories record are the same from every analysis and every method."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.analyses.driven import pushed

import sarrus as sr
from sarrus import mechanisms

T = np.linspace(0.0, 1.0, 11)
PRECISE = {"rtol": 1e-10, "atol": 1e-12, "method": sr.Radau()}


def driven() -> sr.System:
    """A slider-crank that turns twice in a second, with a coil on its pin that counts revolutions."""
    model = sr.load(mechanisms.path("slider_crank"))
    motor = sr.AngleDriver("motor", "pin", "12.6*t")
    pin = next(joint for joint in model.joints if joint.name == "pin")
    coil = sr.RSDA("coil", sr.ground, pin.body_j, point=pin.point, axis=pin.axis, k=3.0, c=0.0)
    return sr.System(replace(model, drivers=[motor], forces=[*model.forces, coil]))


def test_a_driven_motion_has_the_energies_of_its_simulation() -> None:
    system = driven()
    run = sr.kinematics(system, T)
    simulated = sr.simulate(system, until=1.0, t_eval=T, **PRECISE)
    scale = simulated.kinetic_energy.max()
    for name in ("kinetic_energy", "potential_energy", "total_energy"):
        assert getattr(run, name) == pytest.approx(getattr(simulated, name), abs=1e-7 * scale), name
    assert np.all(run.velocity_violation < 1e-9)
    assert len(run.plot_energies().lines) == 3


def test_a_motion_that_locks_has_those_up_to_its_end() -> None:
    run = sr.kinematics(pushed(0.5), np.linspace(0.0, 4.0, 41))
    assert run.status == "lock-up"
    assert (
        run.kinetic_energy.shape == run.potential_energy.shape == run.velocity_violation.shape == run.t.shape
    )


def test_inverse_dynamics_has_those_of_its_own_bodies() -> None:
    system = driven()
    run = sr.kinematics(system, T)
    bodies = [replace(body, mass=2 * body.mass) for body in system.model.bodies]
    heavy = sr.System(replace(system.model, bodies=bodies))
    found, wanted = sr.inverse_dynamics(heavy, run), sr.kinematics(heavy, T)
    assert np.allclose(found.kinetic_energy, wanted.kinetic_energy, rtol=1e-12)
    assert np.allclose(found.potential_energy, wanted.potential_energy, rtol=1e-12)


@pytest.mark.parametrize("method", [sr.HHT(), sr.GeneralizedAlpha(), sr.Radau(), sr.ODE()])
def test_every_method_records_them(method: object, tmp_path: Path) -> None:
    """A mass on a spring and its weight; also read from a folder."""
    body = sr.Body("mass", mass=2.0, inertia=(1, 1, 1), position=(0, 0, -1.2))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=50.0, length=1.0)
    system = sr.System(sr.Model("hung", [body], forces=[spring], gravity=(0, 0, -9.81)))
    run = sr.simulate(
        system, until=1.0, t_eval=T, method=method, save=tmp_path / "run", rtol=1e-8, atol=1e-10
    )
    for one in (run, sr.load_run(tmp_path / "run", system)):
        z, rate = one["mass"].position[:, 2], one["mass"].velocity[:, 2]
        assert one.kinetic_energy == pytest.approx(rate**2, rel=1e-12, abs=1e-14)
        assert one.potential_energy == pytest.approx(2 * 9.81 * z + 25.0 * (-z - 1) ** 2, rel=1e-12)
