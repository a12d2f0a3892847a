"""Inertia of joint coordinates and massless frames between joints, against equations written by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sarrus as sr

G, L, MASS, J = 9.81, 0.7, 1.3, 0.02
ROTORS = 0.05, 0.03
TIGHT = {"method": sr.Radau(rtol=1e-11)}


def double_pendulum(rotors: tuple[float, float] = ROTORS) -> sr.Model:
    """Two rods from the horizontal, with a rotor's inertia in each hinge."""
    inertia = (J, J, J)
    a = sr.Body("a", MASS, inertia, (L, 0, 0))
    b = sr.Body("b", MASS, inertia, (3 * L, 0, 0))
    first = {"body_i": sr.ground, "body_j": a, "point": (0, 0, 0), "axis": (0, 0, 1)}
    second = {"body_i": a, "body_j": b, "point": (2 * L, 0, 0), "axis": (0, 0, 1)}
    hinges = [sr.Revolute("A", **first), sr.Revolute("B", **second)]
    added = [
        sr.AngleInertia(f"rotor_{n}", **place, inertia=I)
        for n, (place, I) in enumerate(zip((first, second), rotors, strict=True))
    ]
    return sr.Model("double pendulum", [a, b], hinges, added, gravity=(0, -G, 0))


def test_an_inertia_of_a_joint_by_its_name_is_that_placed_like_the_joint() -> None:
    """Angles and displacements; a joint in two ways, without the coordinate or unknown is refused."""
    model = double_pendulum()
    named = [
        sr.AngleInertia(f"rotor_{n}", joint=hinge, inertia=I)
        for n, (hinge, I) in enumerate(zip("AB", ROTORS, strict=True))
    ]
    systems = [sr.System(model), sr.System(replace(model, forces=named))]
    first, second = (one.M(one.q0).toarray() for one in systems)
    assert second == pytest.approx(first, abs=1e-15)
    cart = sr.Body("cart", MASS, (J, J, J))
    rail = sr.Prismatic("rail", sr.ground, cart, point=(0, 0, 0), axis=(1, 0, 0))
    system = sr.System(
        sr.Model("cart", [cart], [rail], [sr.DisplacementInertia("spindle", joint="rail", inertia=2.0)])
    )
    assert system.M(system.q0).toarray()[0, 0] == pytest.approx(MASS + 2.0)
    for given, message in (
        ({"joint": "A", "axis": (0, 0, 1)}, "both joint and axis"),
        ({"joint": "C"}, 'no joint "C"'),
        ({}, "bodies are missing"),
    ):
        with pytest.raises(sr.ModelError, match=message):
            sr.System(replace(model, forces=[sr.AngleInertia("rotor", inertia=1.0, **given)]))


def by_hand(t: float, y: np.ndarray) -> np.ndarray:
    """Lagrange's equations of both angles, the second relative to the first."""
    (x, z), (u, w) = y[:2], y[2:]
    c, s, K = np.cos(z), np.sin(z), MASS * L * L
    M = np.array([[6 * K + 4 * K * c + 2 * J, K + 2 * K * c + J], [K + 2 * K * c + J, K + J]]) + np.diag(
        ROTORS
    )
    gyro = 2 * K * s * np.array([-(2 * u + w) * w, u * u])
    weight = -MASS * G * L * np.array([3 * np.cos(x) + np.cos(x + z), np.cos(x + z)])
    return np.concatenate([y[2:], np.linalg.solve(M, weight - gyro)])


@pytest.mark.slow
def test_a_double_pendulum_with_rotors() -> None:
    run = sr.simulate(sr.System(double_pendulum()), until=1.5, store="steps", **TIGHT)
    expected = solve_ivp(by_hand, (0, 1.5), np.zeros(4), method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    found = [run.joint("A").angle[-1], run.joint("B").angle[-1]]
    np.testing.assert_allclose(found, expected[:2], atol=1e-8)
    assert abs(np.ptp(run.total_energy)) < 1e-8
    without = sr.simulate(sr.System(double_pendulum((0.0, 0.0))), until=1.5, **TIGHT)
    assert abs(without.joint("B").angle[-1] - found[1]) > 0.1


@pytest.mark.slow
def test_derivatives_by_the_inertia_of_a_rotor() -> None:
    """Direct, adjoint, and differences of whole runs; the Hessian by differences of gradients."""
    names = ["rotor_0.inertia", "rotor_1.inertia", "b.mass"]
    response = sr.Final("b.x")

    def run(inertia: float) -> sr.Trajectory:
        return sr.simulate(sr.System(double_pendulum((inertia, 0.03))), until=1.0, store="steps", **TIGHT)

    middle, h = run(0.05), 1e-4
    adjoint = sr.sensitivity(middle, response, names)
    direct = sr.sensitivity(middle, response, names, method="direct")
    np.testing.assert_allclose([direct[n] for n in names], [adjoint[n] for n in names], rtol=1e-10)
    ends = [run(0.05 + k * h) for k in (-2, -1, 1, 2)]
    weights = np.array([1, -8, 8, -1]) / (12 * h)
    values = [end["b"].position[-1, 0] for end in ends]
    assert weights @ values == pytest.approx(adjoint[names[0]], rel=1e-7)
    gradients = [[sr.sensitivity(end, response, names)[n] for n in names] for end in ends]
    hessian = sr.hessian(middle, response, names)
    np.testing.assert_allclose(hessian.matrix[0], weights @ np.array(gradients), rtol=1e-5)


def test_a_mass_on_a_slide_with_a_rotor() -> None:
    """A screw jack's nut: (m + I) ẍ = m g."""
    nut = sr.Body("nut", 2.0, (1, 1, 1))
    place = {"body_i": sr.ground, "body_j": nut, "point": (0, 0, 0), "axis": (0, 0, 1)}
    rotor = sr.DisplacementInertia("rotor", **place, inertia=3.0)
    model = sr.Model("jack", [nut], [sr.Translational("guide", **place)], [rotor], gravity=(0, 0, -G))
    run = sr.simulate(sr.System(model), until=1.0)
    assert run["nut"].position[-1, 2] == pytest.approx(-G * 2 / 5 / 2, rel=1e-9)


def crossed_hinges(cross: bool) -> sr.Model:
    """A body on two skew hinges with a massless frame between them, or on a universal joint."""
    body = sr.Body("body", 2.0, (0.1, 0.2, 0.25), (0.5, 0.1, 0))
    if not cross:
        joints = [sr.Universal("hook", sr.ground, body, (0, 0, 0), axis_i=(0, 1, 0), axis_j=(0, 0, 1))]
        return sr.Model("one", [body], joints, gravity=(0, 0, -G))
    frame = sr.Body("frame", 0, (0, 0, 0))
    joints = [
        sr.Revolute("first", sr.ground, frame, (0, 0, 0), (0, 1, 0)),
        sr.Revolute("second", frame, body, (0, 0, 0), (0, 0, 1)),
    ]
    return sr.Model("two", [frame, body], joints, gravity=(0, 0, -G))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT(), sr.ODE()], ids=["Radau", "HHT", "ODE"])
def test_a_massless_frame_between_two_hinges(method: object) -> None:
    rtol = 1e-6 if isinstance(method, sr.HHT) else 1e-10
    one, two = (
        sr.simulate(sr.System(crossed_hinges(cross)), until=1.0, method=replace(method, rtol=rtol))
        for cross in (False, True)
    )
    assert two.success
    np.testing.assert_allclose(two["body"].position[-1], one["body"].position[-1], atol=1e3 * rtol * 0.1)


def test_a_frame_that_moves_nothing_is_named() -> None:
    frame = sr.Body("frame", 0, (0, 0, 0))
    model = sr.Model("m", [frame], [sr.Revolute("first", sr.ground, frame, (0, 0, 0), (0, 1, 0))])
    run = sr.simulate(sr.System(model), until=1.0)
    assert not run.success
    assert "body frame: it has no inertia along a motion" in run.message


def test_mass_without_inertia_and_inertia_without_mass_are_refused() -> None:
    for mass, inertia in ((0, (1, 1, 1)), (1, (0, 0, 0))):
        with pytest.raises(sr.ModelError):
            sr.System(sr.Model("m", [sr.Body("a", mass, inertia)]))
