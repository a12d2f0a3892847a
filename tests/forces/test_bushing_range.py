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
