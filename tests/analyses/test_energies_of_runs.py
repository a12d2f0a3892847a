"""Energies that trajectories record are the same from every analysis and every method."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
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


LAWS = {  # a stiffness over the length or angle
    "table": [[-8.0, 40.0], [-4.0, 45.0], [0.0, 48.0], [1.0, 50.0], [1.5, 56.0], [4.0, 60.0], [8.0, 70.0]],
    "formula": lambda x: 50 + 20 * x * x,
}


def law(name: str) -> object:
    """The law as a function of plain numbers, from the definition of a table by SciPy."""
    return sr.Curve.table(LAWS[name]) if name == "table" else LAWS[name]


def work(name: str, free: float, at: float) -> float:
    """∫ k(s) (s - free) ds by SciPy."""
    curve, knots = law(name), [x for x, _ in LAWS["table"]]
    inside = [x for x in knots if min(free, at) < x < max(free, at)]
    return quad(lambda s: curve(float(s)) * (s - free), free, at, points=inside or None, epsabs=1e-12)[0]


def sprung(name: str, mass: float = 2.0, free: float = 1.0) -> sr.System:
    """A mass on a spring with a law, and a flywheel on a coil with the same law that is wound for a revolution."""
    body = sr.Body("mass", mass=mass, inertia=(1, 1, 1), position=(0.3, 0, -1.2))
    wheel = sr.Body("wheel", mass=1.0, inertia=(1, 1, 1), angular_velocity=(0, 0, 40.0))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    forces = [
        sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=LAWS[name], length=free),
        sr.RSDA("coil", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1), k=LAWS[name], angle=0.3),
    ]
    return sr.System(sr.Model("sprung", [body, wheel], [pin], forces, gravity=(0, 0, -9.81)))


@pytest.mark.parametrize("name", LAWS)
def test_springs_with_laws_keep_energy(name: str) -> None:
    run = sr.simulate(sprung(name), until=1.0, store_steps=True, **PRECISE)
    angle = run.joint("pin").angle
    assert abs(angle).max() > (2.5 if name == "formula" else 5.0)
    assert run.total_energy == pytest.approx(run.total_energy[0], abs=1e-7 * run.kinetic_energy.max())
    r = run["mass"].position
    wanted = [
        2 * 9.81 * z + work(name, 1.0, float(l)) + work(name, 0.3, float(x))
        for z, l, x in zip(r[:, 2], np.linalg.norm(r, axis=1), angle, strict=True)
    ]
    assert run.potential_energy == pytest.approx(wanted, rel=1e-9)
    values = sr.sensitivity(run, ["energy.potential", "energy.total"]).values
    assert values == pytest.approx([run.potential_energy[-1], run.total_energy[-1]], rel=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_derivatives_of_the_energy_of_springs_with_laws(name: str) -> None:
    """The energy is conserved: its derivatives are those of the initial one, the second as well."""
    system = sprung(name)
    run = sr.simulate(system, until=0.5, store_steps=True, **PRECISE)
    names = ["spring.length", "mass.position.z", "coil.angle"]
    found = sr.sensitivity(run, "energy.total", names).matrix[0]

    def energy(change: np.ndarray) -> float:
        l = np.hypot(0.3, -1.2 + change[1])
        return 2 * 9.81 * change[1] + work(name, 1.0 + change[0], l) + work(name, 0.3 + change[2], 0.0)

    e = 1e-4 * np.eye(3)
    assert found == pytest.approx([(energy(d) - energy(-d)) / 2e-4 for d in e], rel=1e-5)
    second = [
        [energy(c + d) - energy(c - d) - energy(d - c) + energy(-c - d) for c in 10 * e] for d in 10 * e
    ]
    at_once = sr.At("energy.total", time=0.0)  # later ones depend on where steps meet the knots of a table
    hessian = sr.hessian(run, at_once, names).matrix
    assert hessian == pytest.approx(np.array(second) / 4e-6, abs=1e-5 * abs(hessian).max())
