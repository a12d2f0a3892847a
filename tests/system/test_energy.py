"""Potential energies: the force at rest is their negative gradient."""

import numpy as np
import pytest

import sarrus as sr

STEP = 1e-5  # of central differences, whose error is about 1e-10 of the third derivative


def pair(kind: str) -> sr.System:
    a = sr.Body("a", mass=2.0, inertia=(1, 2, 3), position=(0.3, 0.2, 0.9), center_of_mass=(0.1, 0.3, -0.2))
    b = sr.Body("b", mass=1.0, inertia=(1, 1, 1), position=(1.0, 0.1, -0.2))
    K = np.diag([1.0, 2, 3, 4, 5, 6])
    K[0, 4] = K[4, 0] = 0.5
    preload = (1, 2, 3, 0.1, 0.2, 0.3)
    forces = {
        "tsda": sr.TSDA("s", a.point(0.1, 0.2, 0), b.point(0, 0.3, 0.1), k=7.0, c=2.0, length=0.4),
        "rsda": sr.RSDA("s", a, b, point=(0, 0, 0), axis=(0, 0, 1), k=3.0, angle=0.3),
        "bushing": sr.Bushing("s", a, b, point=(0.5, 0, 0), stiffness=K.tolist(), preload=preload),
    }
    return sr.System(sr.Model("pair", bodies=[a, b], forces=[forces[kind]], gravity=(1.0, -2.0, -9.81)))


@pytest.mark.parametrize("kind", ["tsda", "rsda", "bushing"])
def test_the_force_at_rest_is_the_negative_gradient(kind: str) -> None:
    system = pair(kind)
    directions = np.eye(14)
    q = system.q0.copy()
    if kind == "rsda":  # its torque derives from a potential for turns about the common axis
        directions = directions[[0, 1, 2, 6, 13]]
    else:
        q += 0.1 * np.random.default_rng(0).normal(size=14)
        for p in (q[3:7], q[10:]):  # of unit length, along which nothing acts
            p /= np.linalg.norm(p)
    if kind == "bushing":
        for at in (3, 10):
            directions[:, at : at + 4] -= np.outer(
                directions[:, at : at + 4] @ q[at : at + 4], q[at : at + 4]
            )
    Q = system.Q(q, np.zeros(14))
    for e in directions:
        ahead, behind = (system.potential_energy(q + s * STEP * e) for s in (1, -1))
        assert (behind - ahead) / (2 * STEP) == pytest.approx(e @ Q, abs=1e-7)


def test_energies_of_a_fall() -> None:
    ball = sr.Body("ball", mass=2.0, inertia=(1, 1, 1), position=(0, 0, 3.0), velocity=(0, 0, 2.0))
    one = sr.System(sr.Model("fall", bodies=[ball], gravity=(0, 0, -9.81)))
    assert one.potential_energy(one.q0) == pytest.approx(2 * 9.81 * 3)
    assert one.kinetic_energy(one.q0, one.v0) == pytest.approx(4.0)
