"""Outputs and reactions of an equilibrium, against those that a lever and a hand calculation have."""

import numpy as np
import pytest

import sarrus as sr


def lift(angle: float = np.radians(30)) -> sr.System:
    """A scissor of one stage, two arms of 1.2 m and 8 kg, held at the foot of one; a platform of 100 kg on top."""
    c, s = 1.2 * np.cos(angle), 1.2 * np.sin(angle)
    turned = sr.AxisAngle((0, 0, 1), angle), sr.AxisAngle((0, 0, 1), -angle)
    middle, z, x = (c / 2, s / 2, 0), (0, 0, 1), (1, 0, 0)
    up, down = (
        sr.Body(name, 8.0, (0.01, 1, 1), position=middle, orientation=one)
        for name, one in zip(("up", "down"), turned, strict=True)
    )
    plate = sr.Body("plate", 100.0, (9, 9, 9), position=(0, s, 0))
    foot = sr.Body("foot", 5.0, (0.1, 0.1, 0.1), position=(c, 0, 0))
    joints = [
        sr.Revolute("pin", sr.ground, up, point=(0, 0, 0), axis=z),
        sr.Revolute("cross", up, down, point=middle, axis=z),
        sr.Revolute("hinge", down, plate, point=(0, s, 0), axis=z),
        sr.Revolute("heel", foot, down, point=(c, 0, 0), axis=z),
        sr.Translational("guide", sr.ground, foot, point=(c, 0, 0), axis=x),
        sr.PointOnLine("rail", plate, up, point=(c, s, 0), axis=x),
    ]
    jack = sr.DisplacementDriver("jack", "guide", "-0.1*t")
    return sr.System(sr.Model("lift", [up, down, plate, foot], joints, drivers=[jack], gravity=(0, -9.81, 0)))


@pytest.mark.parametrize("t", [0.0, 2.0])
def test_force_of_a_jack(t: float) -> None:
    """Virtual work: (100 + 8) 9.81 dy + F dx = 0 with x = 1.2 cos, y = 1.2 sin of the angle of the arms."""
    rest = sr.equilibrium(lift(), t=t)
    x = 1.2 * np.cos(np.radians(30)) - 0.1 * t
    force = -(100 + 8) * 9.81 * x / np.sqrt(1.2**2 - x**2)
    assert rest["jack.force.x"] == pytest.approx(force, rel=1e-10)
    assert rest["jack.force"] == pytest.approx([force, 0, 0], abs=1e-8)
    assert rest.reaction("jack").force == pytest.approx(rest["jack.force"], abs=1e-12)
    assert rest["plate.y"] == pytest.approx(np.sqrt(1.2**2 - x**2), rel=1e-12)
    assert rest["guide"] == pytest.approx(-0.1 * t, abs=1e-12)
    with pytest.raises(KeyError, match="has no output"):
        rest["jack.forces"]


def test_completion_lists_the_outputs() -> None:
    rest = sr.equilibrium(lift())
    names = rest._ipython_key_completions_()
    assert {"jack.force.x", "plate.y", "energy.potential"} <= {*names}
    assert all(np.isfinite(rest[name]) for name in names[::20])
