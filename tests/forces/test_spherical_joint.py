"""Spring, damper, friction and inertia of a spherical joint, against equations written by hand."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import sarrus as sr
from sarrus.elements.forces.bushing import rotation_vector

TIGHT = {"method": sr.Radau(rtol=1e-11)}
K, C, T, CREEP, I, J = 3.0, 0.2, 0.1, 0.5, 0.05, 0.4
AXIS = np.array([1, 2, 2]) / 3
SPEED = 4.0


def ball(omega: tuple[float, float, float]) -> sr.System:
    """A body on a ball at its centre of mass, with an angular velocity in its own axes."""
    turned = Rotation.from_rotvec(0.7 * AXIS)
    orientation, spin = sr.AxisAngle(tuple(AXIS), 0.7), tuple(turned.apply(omega))
    a = sr.Body("a", 2.0, (J, J, J), (0.2, 0.1, 0.3), orientation, angular_velocity=spin)
    place = {"body_i": sr.ground, "body_j": a, "point": (0.2, 0.1, 0.3)}
    forces = [
        sr.SphericalSpring("s", **place, k=K, c=C, friction=T, creep=CREEP),
        sr.SphericalInertia("rotor", sr.ground, a, inertia=I),
    ]
    return sr.System(sr.Model("ball", [a], [sr.Spherical("j", **place)], forces))


@pytest.mark.parametrize("phi", [0, 1e-9, 1e-3, 0.19, 0.2, 0.21, 1, 3, np.pi - 1e-9])
@pytest.mark.parametrize("side", [1, -1])
def test_the_rotation_vector_is_scipys(phi: float, side: int) -> None:
    x, y, z, w = side * Rotation.from_rotvec(phi * AXIS).as_quat()
    turn, _ = rotation_vector(w, np.array([x, y, z]))
    np.testing.assert_allclose(turn, phi * AXIS, rtol=1e-14, atol=1e-20)


def test_the_derivative_of_the_rotation_vector() -> None:
    """By a complex step, against Rodrigues' formula: ϑ_d δ for a rotation about another axis."""
    for phi in (0.0, 1e-8, 0.05, 0.2, 2.0, 3.1):
        d, delta = np.array([np.cos(phi / 2), *np.sin(phi / 2) * AXIS]), np.array([2.0, 1, -2]) / 3
        turned = np.array([-d[1:] @ delta, *(d[0] * delta + np.cross(delta, d[1:]))]) / 2
        h = 1e-30
        moved, beta = rotation_vector(d[0] + 1j * h * turned[0], d[1:] + 1j * h * turned[1:])
        half = phi / 2
        across = np.cross(delta, AXIS)  # δ ⟂ n: ϑ' = φ/2 cot(φ/2) δ + φ/2 δ x n
        np.testing.assert_allclose(
            moved.imag / h, (half / np.tan(half) if phi else 1.0) * delta + half * across, rtol=0, atol=1e-14
        )
        back = delta + half * across + beta.real * phi**2 * np.cross(AXIS, np.cross(AXIS, delta))
        np.testing.assert_allclose(moved.imag / h, back, rtol=0, atol=1e-14)


def test_a_rotation_about_one_axis() -> None:
    """(I + J) φ̈ = -k φ - c φ̇ - friction about z of the body."""

    def by_hand(t: float, y: np.ndarray) -> list[float]:
        return [y[1], (-K * y[0] - C * y[1] - T * np.tanh(y[1] / CREEP)) / (I + J)]

    run = sr.simulate(ball((0, 0, SPEED)), until=1.0, **TIGHT)
    expected = solve_ivp(by_hand, (0, 1), [0, SPEED], rtol=1e-12, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(run["a"].angular_velocity_body[-1], [0, 0, expected[1]], atol=1e-8)
    assert run["s.energy"][-1] == pytest.approx(K * expected[0] ** 2 / 2, rel=1e-7)


def pair(k: float = K, inertia: float = I, **given: float) -> sr.System:
    """A hinged body with another one on a ball."""
    a = sr.Body("a", 1.3, (0.1, 0.2, 0.25), (0.5, 0, 0))
    b = sr.Body("b", 0.7, (0.05, 0.02, 0.06), (1.2, 0.1, 0), orientation=sr.AxisAngle((1, 0, 1), 0.4))
    place = {"body_i": a, "body_j": b, "point": (1, 0, 0)}
    joints = [
        sr.Revolute("A", sr.ground, a, point=(0, 0, 0), axis=(0, 1, 0)),
        sr.Spherical("B", **place),
    ]
    forces = [
        sr.SphericalSpring("s", **place, k=k, **given),
        sr.SphericalInertia("rotor", a, b, inertia=inertia),
    ]
    return sr.System(sr.Model("pair", [a, b], joints, forces, gravity=(0, 0, -9.81)))


@pytest.mark.slow
def test_energy_is_conserved_without_losses() -> None:
    run = sr.simulate(pair(), until=1.0, **TIGHT)
    assert np.ptp(run.total_energy) < 1e-8 < np.ptp(run["s.energy"])


@pytest.mark.slow
def test_every_operator() -> None:
    report = pair(c=C, friction=T, creep=CREEP).check_derivatives()
    assert report, report


@pytest.mark.slow
def test_derivatives_by_the_numbers_of_both() -> None:
    """Adjoint and direct, and differences of whole runs."""
    names = ["s.k", "s.c", "s.friction", "rotor.inertia"]
    response, values = sr.Final("b.z"), (K, C, T, I)

    def run(k: float, c: float, friction: float, inertia: float) -> sr.Trajectory:
        system = pair(k=k, c=c, friction=friction, inertia=inertia, creep=CREEP)
        return sr.simulate(system, until=0.5, store="steps", **TIGHT)

    middle, h = run(*values), 1e-4
    adjoint = sr.sensitivity(middle, response, names)
    direct = sr.sensitivity(middle, response, names, method="direct")
    for n, name in enumerate(names):
        assert direct[name] == pytest.approx(adjoint[name], rel=1e-9)
        ends = [run(*(value + s * h * (n == m) for m, value in enumerate(values))) for s in (-1, 1)]
        difference = (ends[1]["b.z"][-1] - ends[0]["b.z"][-1]) / (2 * h)
        assert difference == pytest.approx(adjoint[name], rel=1e-5), name


def test_frames_give_the_orientation_without_torque() -> None:
    a = sr.Body("a", 1.0, (1, 1, 1))
    frames = {"frame_i": sr.ground.frame((0, 0, 0), z=(0, 0, 1), x=(0, 1, 0)), "frame_j": a.frame((1, 2, 3))}
    spring = sr.SphericalSpring("s", **frames, k=2.0)
    system = sr.System(sr.Model("m", [a], forces=[spring]))
    motion = sr.simulate(system, until=0.01)
    np.testing.assert_allclose([motion[f"s.torque.{axis}"][0] for axis in "xyz"], [0, 0, np.pi], atol=1e-12)


WRONG = {
    "stiffness": (lambda a: sr.SphericalSpring("s", sr.ground, a, point=(0, 0, 0), k=-1.0), "k"),
    "creep": (
        lambda a: sr.SphericalSpring("s", sr.ground, a, point=(0, 0, 0), friction=1.0, creep=0.0),
        "creep",
    ),
    "inertia": (lambda a: sr.SphericalInertia("s", sr.ground, a, inertia=-1.0), "inertia"),
    "one body": (lambda a: sr.SphericalInertia("s", a, a, inertia=1.0), "itself"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_values_are_refused(case: str) -> None:
    a = sr.Body("a", 1.0, (1, 1, 1))
    make, word = WRONG[case]
    with pytest.raises(sr.ModelError, match=word):
        sr.System(sr.Model("m", [a], forces=[make(a)]))
