"""Action is reaction: what a force does to one body it does to the other with the opposite sign, moments included."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sarrus as sr
from sarrus.euler import A, E

A_BODY = sr.Body(
    "a",
    1.0,
    (1, 1, 1),
    position=(0.1, -0.2, 0.3),
    orientation=Rotation.from_rotvec([0.3, 1, -0.2]).as_matrix(),
)
B_BODY = sr.Body(
    "b",
    1.0,
    (1, 1, 1),
    position=(0.6, 0.4, -0.1),
    orientation=Rotation.from_rotvec([-1, 0.2, 0.7]).as_matrix(),
)
ABOUT = {"body_i": A_BODY, "body_j": B_BODY, "point": (0.2, 0.1, 0.5), "axis": (1, 2, -2)}
ANY = np.random.default_rng(3).normal(size=(6, 6))
MATRIX = ANY + 5 * np.eye(6)  # gives no energy

PAIRS = [  # the first one runs by default where only some do: its kernels are small, those of bushings large
    sr.RSDA("f", **ABOUT, k=lambda angle: 3 + angle * angle, c=2.0, angle=0.5),
    sr.TSDA("f", A_BODY.point(0, 0, 1), B_BODY.point(0, 1, 0), k=[[0, 3], [1, 5]], c=lambda v: 1 + v * v, length=0.3),
    sr.LengthStop("f", A_BODY.point(0, 0, 1), B_BODY.point(0, 1, 0), stiffness=9.0, damping=0.1, upper=0.2),
    sr.DisplacementStop("f", **ABOUT, stiffness=9.0, damping=0.1, exponent=1.5, lower=0.3),
    sr.AngleStop("f", **ABOUT, stiffness=9.0, damping=0.1, lower=0.3, upper=0.4),
    sr.SphereContact("f", A_BODY.point(0, 0, 1), B_BODY.frame((0, 1, 0), z=(1, 1, 1)), radius=9.0, stiffness=7.0,
    mu=0.3), sr.AngleFriction("f", **ABOUT, radius=0.1, load=10.0, mu=0.2, mu_static=0.3, viscous=2.0),
    sr.DisplacementFriction("f", **ABOUT, load=10.0, mu=0.2, mu_static=0.3, viscous=2.0),
    sr.Bushing("f", A_BODY, B_BODY, (0.2, 0.1, 0.5), stiffness=MATRIX, damping=MATRIX.T, preload=range(6)),
]  # fmt: skip


@pytest.mark.parametrize("force", PAIRS, ids=lambda force: type(force).__name__)
def test_net_force_and_moment_vanish(force: sr.model.Force) -> None:
    system = sr.System(sr.Model("pair", [A_BODY, B_BODY], forces=[force]))
    q, v = system.q0, np.random.default_rng(5).normal(size=system.nq)
    for at in (3, 10):
        v[at : at + 4] -= (v[at : at + 4] @ q[at : at + 4]) * q[at : at + 4]
    Q = system.Q(q, v).reshape(2, 7)
    moments = [np.cross(x[:3], f[:3]) + E(x[3:]) @ f[3:] / 2 for x, f in zip(q.reshape(2, 7), Q, strict=True)]
    assert abs(Q).max() > 0.1
    assert np.allclose(Q[0, :3] + Q[1, :3], 0, atol=1e-12)
    assert np.allclose(sum(moments), 0, atol=1e-12)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("force", PAIRS, ids=lambda force: type(force).__name__)
def test_derivatives_are_exact(force: sr.model.Force) -> None:
    report = sr.System(sr.Model("pair", [A_BODY, B_BODY], forces=[force])).check_derivatives()
    assert report, str(report)


def test_a_bushing_conserves_energy() -> None:
    """Full symmetric stiffness, no damping, large motion."""
    K = ANY @ ANY.T + 2 * np.eye(6)
    body = sr.Body("b", 2.0, (0.5, 1, 0.8), velocity=(0.3, -0.2, 0.1), angular_velocity=(4, 9, -5))
    system = sr.System(
        sr.Model("one", [body], forces=[sr.Bushing("f", sr.ground, body, (0, 0, 0), stiffness=K * 4)])
    )
    run = sr.simulate(system, until=5.0, t_eval=np.linspace(0, 5, 41), method=sr.ODE(rtol=1e-11, atol=1e-13))
    energies = []
    for q, v in zip(run.q, run.v, strict=True):
        strain = np.array([*q[:3], *Rotation.from_matrix(A(q[3:])).as_rotvec()])
        energies.append(system.kinetic_energy(q, v) + 2 * strain @ K @ strain)
    assert abs(run.q[:, 4:]).max() > 0.6
    assert np.allclose(energies, energies[0], rtol=1e-9)
