"""Bushings at large angles, against closed forms, and steps of stiff ones."""

import numpy as np
import pytest

import sarrus as sr


def rod(*more: sr.Force, **options: object) -> sr.System:
    body = sr.Body("rod", 1.0, (0.1, 0.1, 0.1))
    hinge = sr.Revolute("hinge", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    bush = sr.Bushing("bush", sr.ground, body, point=(0, 0, 0), stiffness=(0, 0, 0, 0, 0, 10))
    return sr.System(sr.Model("rod", [body], [hinge], [bush, *more], **options))


@pytest.mark.parametrize("axis", [(0, 0, 1), (2 / 3, -1 / 3, 2 / 3)])
def test_a_prescribed_turn(axis: tuple[float, float, float]) -> None:
    """The torque grows with the angle up to half a revolution; to small angles it was one of sin φ cos φ."""
    body = sr.Body("rod", 1.0, (0.1, 0.1, 0.1))
    hinge = sr.Revolute("hinge", sr.ground, body, point=(0, 0, 0), axis=axis)
    bush = sr.Bushing("bush", sr.ground, body, point=(0, 0, 0), stiffness=(0, 0, 0, 10, 10, 10))
    motor = sr.AngleDriver("motor", "hinge", "t")
    run = sr.kinematics(
        sr.System(sr.Model("rod", [body], [hinge], [bush], drivers=[motor])), [0, 0.01, 1, 2, 3.1]
    )
    assert run["bush.torque"] == pytest.approx(-10 * np.outer(run.t, axis), abs=1e-11)
    assert run["bush.rotation"] == pytest.approx(np.outer(run.t, axis), abs=1e-13)


def test_a_load_that_tore_it_loose() -> None:
    """θ̈ = 60 - 100 θ swings between 0 and 1.2 rad: θ = 0.6 (1 - cos 10 t)."""
    run = sr.simulate(rod(sr.Torque("load", "hinge", value=6.0)), until=2.0, method=sr.Radau(rtol=1e-9))
    assert run["hinge.angle"] == pytest.approx(0.6 * (1 - np.cos(10 * run.t)), abs=1e-6)
    assert not run.warnings


@pytest.mark.parametrize("top", [2.5, 3.5])
def test_a_torsion_pendulum(top: float) -> None:
    """θ = ω/10 sin 10 t, also near half a revolution; beyond, the torque jumps and the energy does not."""
    body = sr.Body("rod", 1.0, (0.1, 0.1, 0.1), angular_velocity=(0, 0, 10 * top))
    bush = sr.Bushing("bush", sr.ground, body, point=(0, 0, 0), stiffness=(1, 1, 1, 10, 10, 10))
    run = sr.simulate(
        sr.System(sr.Model("free", [body], forces=[bush])), until=1.0, method=sr.Radau(rtol=1e-10)
    )
    energy = run["energy.potential"] + run["energy.kinetic"]
    assert energy == pytest.approx(energy[0], rel=1e-6)
    if top < np.pi:
        assert run["bush.rotation.z"] == pytest.approx(top * np.sin(10 * run.t), abs=1e-6)
    else:
        assert abs(run["bush.rotation.z"]).max() <= np.pi


def test_a_gradient_by_the_stiffness_at_large_angles() -> None:
    """θ(T) = a sin(√(k/J) T), a = ω √(J/k), of a rod that starts at 25 rad/s: dθ/dk in closed form."""
    body = sr.Body("rod", 1.0, (0.1, 0.1, 0.1), angular_velocity=(0, 0, 25.0))
    bush = sr.Bushing("bush", sr.ground, body, point=(0, 0, 0), stiffness=(1, 1, 1, 10, 10, 10))
    system = sr.System(sr.Model("free", [body], forces=[bush]))
    run = sr.simulate(system, until=0.2, method=sr.Radau(rtol=1e-10), store="steps")
    found = sr.sensitivity(run, sr.Final("bush.rotation.z"), wrt=["bush.stiffness.6"])
    w, T = 10.0, 0.2
    by_w = 25 * (T * np.cos(w * T) / w - np.sin(w * T) / w**2)
    assert float(found["bush.stiffness.6"]) == pytest.approx(by_w * 5 / w, rel=1e-6)  # w = √(10 k)


def test_steps_of_an_undamped_chain_resolve_its_fastest_vibration() -> None:
    """Eight rods on bushings: some eight steps for each period of the highest of their dense eigenfrequencies."""
    bodies, forces, before = [], [], sr.ground
    for n in range(8):
        rod = sr.Body.rod(f"rod_{n}", (0.1 * n, 0, 0), (0.1 * n + 0.1, 0, 0), radius=0.01, mass=0.1)
        stiffness = 3 * (1e6,) + 3 * (1e3,)
        forces.append(sr.Bushing(f"b_{n}", before, rod, point=(0.1 * n, 0, 0), stiffness=stiffness))
        bodies.append(rod)
        before = rod
    system = sr.System(sr.Model("chain", bodies, forces=forces, gravity=(0, 0, -9.81)))
    highest = max(sr.modes(system, sr.equilibrium(system)).natural_frequencies)
    run = sr.simulate(system, until=0.02)
    assert 4 < run.nsteps / (0.02 * highest) < 10
    calm = sr.simulate(system, sr.equilibrium(system), until=0.02)
    assert calm.nsteps < 0.1 * run.nsteps
