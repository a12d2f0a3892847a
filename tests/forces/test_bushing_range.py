"""Bushings that are turned beyond their largest torque are named."""

import numpy as np
import pytest

import sarrus as sr


def rod(*more: sr.Force, **options: object) -> sr.System:
    body = sr.Body("rod", 1.0, (0.1, 0.1, 0.1))
    hinge = sr.Revolute("hinge", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    bush = sr.Bushing("bush", sr.ground, body, point=(0, 0, 0), stiffness=(0, 0, 0, 0, 0, 10))
    return sr.System(sr.Model("rod", [body], [hinge], [bush, *more], **options))


@pytest.mark.parametrize(("angle", "warned"), [(0.78, False), (0.80, True)])
def test_a_prescribed_turn(angle: float, warned: bool) -> None:
    system = rod(drivers=[sr.AngleDriver("motor", "hinge", f"{angle}*t")])
    if not warned:
        assert not sr.kinematics(system, np.linspace(0, 1, 5)).warnings
        return
    with pytest.warns(sr.SarrusWarning, match=r"bush: it is turned by more than 45° at t = 1 s, .* RSDA"):
        sr.kinematics(system, np.linspace(0, 1, 5))


def test_a_simulation_that_tears_it_loose() -> None:
    with pytest.warns(sr.SarrusWarning, match="bush: it is turned by more than 45°"):
        sr.simulate(rod(sr.Torque("load", "hinge", value=6.0)), until=2.0)


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
