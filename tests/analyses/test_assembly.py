"""Assembly: the nearest consistent state, or a sentence that says what stays open."""

import numpy as np
import pytest
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr


@pytest.mark.parametrize("system", [slider_crank, hmmwv])
def test_from_disturbed_coordinates(system: object) -> None:
    made = system()  # type: ignore[operator]
    disturbed = made.q0 + 0.02 * np.random.default_rng(1).normal(size=made.nq)
    speed = np.random.default_rng(2).normal(size=made.nq)
    found = sr.assemble(made, disturbed, speed)
    assert found.success, found.message
    assert abs(made.Phi(found.q)).max() < 1e-12
    assert abs(made.Phi_q_xi(found.q, found.v)).max() < 1e-12
    assert 0 < found.iterations < 12


def test_velocity_is_changed_least() -> None:
    system = slider_crank()
    speed = np.random.default_rng(3).normal(size=system.nq)
    found = sr.assemble(system, system.q0, speed)
    change = found.v - speed
    inside = np.linalg.lstsq(system.Phi_q(found.q).toarray().T, change, rcond=None)[0]
    assert np.allclose(system.Phi_q(found.q).T @ inside, change, atol=1e-12)


def test_open_joints_are_named() -> None:
    rod = sr.Body("rod", mass=1.0, inertia=(1, 1, 1))
    rope = sr.Distance("rope", sr.ground.point(0, 0, 0), rod.point(1, 0, 0), length=1.0)
    post = sr.Spherical("post", sr.ground, rod, point=(3, 0, 0))
    far = sr.Distance("far", sr.ground.point(0, 0, 0), rod.point(3, 0, 0), length=9.0)
    system = sr.System(sr.Model("contradiction", bodies=[rod], joints=[post, rope, far]))
    found = sr.assemble(system)
    assert not found.success
    assert "contradiction could not be assembled" in found.message
    assert "far: " in found.message
    assert np.all(np.isfinite(found.q))
