"""Implicit steps are set by the motion, not by the stiffness; explicit ones by the stiffness."""

from dataclasses import replace

import numpy as np
import pytest

import sarrus as sr


def swinging(k: float) -> sr.System:
    """A rod of 1 kg on a bushing free to turn, let go from the horizontal: vibrations of up to 2 sqrt(k) rad/s."""
    rod = sr.Body("rod", mass=1.0, inertia=(0.001, 1 / 12, 1 / 12), position=(0.5, 0, 0))
    stiffness, damping = (k, k, k, 0, 0, 0), (1, 1, 1, 0, 0, 0)
    bushing = sr.Bushing("bushing", sr.ground, rod, point=(0, 0, 0), stiffness=stiffness, damping=damping)
    return sr.System(sr.Model("rod", [rod], forces=[bushing], gravity=(0, 0, -9.81)))


def pinned() -> sr.System:
    """The same rod on a hinge."""
    rod = sr.Body("rod", mass=1.0, inertia=(0.001, 1 / 12, 1 / 12), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 1, 0))
    return sr.System(sr.Model("rod", [rod], joints=[pin], gravity=(0, 0, -9.81)))


@pytest.mark.slow
def test_bushings_from_1e5_to_1e9() -> None:
    """In as many steps and with the same error (3e-3) as on a hinge."""
    settings = {"until": 2.0, "t_eval": np.linspace(0, 2, 11)}
    loose = {"rtol": 1e-5, "atol": 1e-5}
    rigid = sr.simulate(pinned(), method=sr.Radau(rtol=1e-9, atol=1e-9), **settings)
    steps = []
    for k in (1e5, 1e7, 1e9):
        run = sr.simulate(swinging(k), method=sr.HHT(-0.3, **loose), **settings)
        assert run.success, run.message
        assert np.allclose(run["rod"].position, rigid["rod"].position, atol=6e-3)
        steps.append(run.nsteps)
    assert max(steps) < 1.3 * min(steps) < 250, steps
    explicit = [sr.simulate(swinging(k), method=sr.ODE(**loose), **settings).nsteps for k in (1e3, 1e5)]
    assert explicit[1] > 5 * explicit[0], explicit


@pytest.mark.parametrize("method", [sr.HHT(-0.3), sr.Radau()])
def test_a_mass_ratio_of_1e8(method: object) -> None:
    """A hundred millionth of a mass on a stiff spring above it, with 3e8 rad/s, does not count."""
    heavy = sr.Body("heavy", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 1.0), velocity=(0, 0, 1.0))
    light = sr.Body("light", mass=1e-8, inertia=(1e-8,) * 3, position=(0, 0, 1.5), velocity=(0, 0, 1.0))
    soft = sr.TSDA("soft", sr.ground.point(0, 0, 0), heavy.point(0, 0, 0), k=100.0, c=0.0, length=1.0)
    stiff = sr.TSDA("stiff", heavy.point(0, 0, 0), light.point(0, 0, 0), k=1e9, c=0.0, length=0.5)
    up = {"point": (0, 0, 0), "axis": (0, 0, 1)}
    guides = [sr.Translational(f"guide_{b.name}", sr.ground, b, **up) for b in (heavy, light)]
    system = sr.System(sr.Model("masses", [heavy, light], guides, [soft, stiff]))
    run = sr.simulate(system, until=2.0, method=replace(method, rtol=1e-6, atol=1e-6))
    assert run.success, run.message
    assert run.nsteps < 400
    assert np.allclose(run["heavy"].position[:, 2], 1 + 0.1 * np.sin(10 * run.t), atol=2e-3)
    assert np.allclose(run["light"].position[:, 2], run["heavy"].position[:, 2] + 0.5, atol=1e-4)
