"""Vibration modes against closed forms and simulated motions: at rest, damped, and in steady motion."""

import numpy as np
import pytest
from tests.analyses.driven import MASS, G, J, L, pendulum
from tests.analyses.test_statics import FREQUENCIES
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr
from sarrus.algebra import skew
from sarrus.euler import E

Z3 = np.zeros(3)


def test_pendulum() -> None:
    system = pendulum()
    found = sr.modes(system, system.q0)
    assert found.success, found.message
    assert found.stability == "marginal"
    assert found.eigenvalues == pytest.approx([1j * np.sqrt(MASS * G * L / (J + MASS * L**2))], rel=1e-12)
    assert found.damping_ratios == pytest.approx([0.0], abs=1e-12)
    shape = found.shape(0, "bob")
    assert shape.translation / shape.rotation[2] == pytest.approx([L, 0, 0], abs=1e-12)
    assert shape.rotation / shape.rotation[2] == pytest.approx([0, 0, 1], abs=1e-12)


def test_an_inverted_pendulum_is_unstable() -> None:
    system = pendulum(angle=np.pi)
    found = sr.modes(system, system.q0)
    assert found.stability == "unstable"
    rate = np.sqrt(MASS * G * L / (J + MASS * L**2))
    assert found.eigenvalues == pytest.approx([rate, -rate], rel=1e-12)


def double_pendulum(k: float = 0.0, c: float = 0.0) -> sr.System:
    """Two equal uniform links of length 1, with a rotational spring-damper in the second hinge; all along -y."""
    first = sr.Body("first", mass=1.0, inertia=(1, 1, 1 / 12), position=(0, -0.5, 0))
    second = sr.Body("second", mass=1.0, inertia=(1, 1, 1 / 12), position=(0, -1.5, 0))
    pins = [
        sr.Revolute("top", sr.ground, first, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Revolute("elbow", first, second, point=(0, -1, 0), axis=(0, 0, 1)),
    ]
    frames = {"frame_i": first.frame((0, -0.5, 0)), "frame_j": second.frame((0, 0.5, 0))}
    spring = [sr.RSDA("spring", **frames, k=k, c=c)] if k or c else []
    return sr.System(sr.Model("double pendulum", [first, second], pins, spring, gravity=(0, -G, 0)))


def double_pendulum_matrices(k: float, c: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """In the angles from the vertical, of two uniform links of mass 1 and length 1."""
    M = np.array([[1 / 3 + 1, 0.5], [0.5, 1 / 3]])
    coupling = np.array([[1.0, -1.0], [-1.0, 1.0]])
    return M, c * coupling, np.diag([1.5 * G, 0.5 * G]) + k * coupling


def upper(values: np.ndarray) -> np.ndarray:
    """The half plane that is told, in a fixed order."""
    kept = values[values.imag >= 0].round(12)
    return kept[np.lexsort((kept.real, kept.imag))]


@pytest.mark.parametrize(("k", "c"), [(0.0, 0.0), (3.0, 0.0), (2.0, 0.4), (0.0, 6.0)])
def test_double_pendulum(k: float, c: float) -> None:
    system = double_pendulum(k, c)
    M, C, K = double_pendulum_matrices(k, c)
    inverse = np.linalg.inv(M)
    want = np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ K, -inverse @ C]]))
    found = sr.modes(system, system.q0)
    assert np.allclose(upper(found.eigenvalues), upper(want), atol=1e-10)
    assert found.stability == ("stable" if c else "marginal")


@pytest.mark.parametrize("c", [0.3, 40.0])
def test_mass_spring_damper(c: float) -> None:
    """A slide along x with a spring along it: s² m + s c + k = 0, over- and underdamped."""
    block = sr.Body("block", mass=2.0, inertia=(1, 1, 1))
    guide = sr.Translational("guide", sr.ground, block, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(-1, 0, 0), block.point(0, 0, 0), k=50.0, c=c, length=1.0)
    system = sr.System(sr.Model("oscillator", [block], [guide], [spring]))
    found = sr.modes(system, system.q0)
    want = np.roots([2.0, c, 50.0]).astype(complex)
    assert np.allclose(upper(found.eigenvalues), upper(want), atol=1e-10)
    assert found.natural_frequencies[0] * 2 * np.pi == pytest.approx(abs(found.eigenvalues[0]))
    if c < 20:
        assert found.damping_ratios == pytest.approx([c / (2 * np.sqrt(2.0 * 50.0))], rel=1e-10)


def test_the_vehicle() -> None:
    system = hmmwv()
    found = sr.modes(system, system.q0)
    assert found.success, found.message
    assert np.count_nonzero(found.eigenvalues == 0) == 3
    assert np.all(found.eigenvalues.real[3:] < 0)
    undamped = np.sqrt(np.linalg.eigvals(np.linalg.solve(found.M, found.K)).real.clip(0)) / (2 * np.pi)
    assert np.allclose(np.sort(undamped)[3:], FREQUENCIES, atol=1e-5)
    rack = found.shape(int(np.argmin(abs(found.frequencies - 0.8155))), "steering_rack")
    assert abs(rack.translation[1]) == pytest.approx(abs(rack.translation).max())


def test_simulated_decay() -> None:
    """Released a little along its mode, the slider-crank follows shape·exp(s t) to the square of that little."""
    system = slider_crank()
    rest = sr.equilibrium(system)
    found = sr.modes(system, rest.q)
    s, shape, little = found.eigenvalues[0], found.shapes[:, 0], 1e-4
    assert s.real < 0 < s.imag
    start = sr.assemble(system, rest.q + little * shape.real, little * (s * shape).real)
    t = np.linspace(0.0, 8.0, 41)
    run = sr.simulate(system, start, until=8.0, t_eval=t, method=sr.ODE(rtol=1e-11, atol=1e-14))
    want = little * (shape[:, None] * np.exp(s * t)).real.T
    assert abs(run.q - rest.q - want).max() < 5 * little**2
    assert abs(want[-1]).max() < 0.7 * little


MT, IT, IZ, H = (
    2.0,
    0.3,
    0.05,
    0.25,
)  # top: mass, inertia about its tip across and along its axis, height of its centre


def top(tilt: float = 0.0) -> sr.System:
    """A symmetric top on its tip at the origin, axis z of its body frame, tilted about x."""
    across = IT - MT * H**2
    where = (0.0, -H * np.sin(tilt), H * np.cos(tilt))
    body = sr.Body(
        "top",
        mass=MT,
        inertia=(across, across, IZ),
        position=where,
        orientation=sr.AxisAngle((1, 0, 0), tilt) if tilt else (1, 0, 0, 0),
    )
    tip = sr.Spherical("tip", sr.ground, body, point=(0, 0, 0))
    return sr.System(sr.Model("top", [body], [tip], gravity=(0, 0, -G)))


def turning_velocity(system: sr.System, omega: np.ndarray) -> np.ndarray:
    r, p = system.q0[:3], system.q0[3:]
    return np.concatenate([skew(omega) @ r, 0.5 * E(p).T @ omega])


@pytest.mark.parametrize("spin", [40.0, 100.0])
def test_sleeping_top(spin: float) -> None:
    """I φ'' - i I_z Ω φ' - m g h φ = 0: awake below a critical spin, asleep above."""
    system = top()
    found = sr.modes(system, system.q0, turning_velocity(system, np.array([0, 0, spin])))
    assert found.success, found.message
    root = np.sqrt(complex((IZ * spin) ** 2 - 4 * IT * MT * G * H))
    want = np.array([1j * (IZ * spin + sign * root) / (2 * IT) for sign in (1, -1)])
    want = np.concatenate([want, want.conj()])
    moving = found.eigenvalues[found.eigenvalues != 0]
    assert np.allclose(upper(moving), upper(want), atol=1e-8)
    critical = np.sqrt(4 * IT * MT * G * H) / IZ
    assert 40 < critical < 100
    assert found.stability == ("marginal" if spin > critical else "unstable")


def test_precessing_top() -> None:
    """Nutation about slow steady precession: I ω² is the curvature of the effective potential of the tilt."""
    tilt, spin = 0.6, 140.0  # spin: of the body about its axis, in all
    c, s = np.cos(tilt), np.sin(tilt)
    roots = np.roots([IT * c, -IZ * spin, MT * G * H])  # I c Ω² - I_z ω_z Ω + m g h = 0
    slow = roots[np.argmin(abs(roots))]
    axis = np.array([0.0, -s, c])
    omega = np.array([0, 0, slow]) + (spin - slow * c) * axis
    system = top(tilt)
    v = turning_velocity(system, omega)
    found = sr.modes(system, system.q0, v, turning=(0, 0, slow))
    assert found.success, found.message

    def potential(th: float) -> float:
        p_z, p_3 = IT * slow * s * s + IZ * spin * c, IZ * spin
        return float((p_z - p_3 * np.cos(th)) ** 2 / (2 * IT * np.sin(th) ** 2) + MT * G * H * np.cos(th))

    d = 1e-3  # fourth-order difference of a smooth function: 1e-9 of its value
    values = np.array([potential(tilt + k * d) for k in (-2, -1, 0, 1, 2)])
    curvature = np.array([-1, 16, -30, 16, -1]) @ values / (12 * d * d)
    moving = found.eigenvalues[found.eigenvalues != 0]
    assert moving == pytest.approx([1j * np.sqrt(curvature / IT)], rel=1e-6)
    assert np.count_nonzero(found.eigenvalues == 0) == 2


def test_a_wrong_observer_is_told() -> None:
    """Seen from outside, the precessing top is no steady motion."""
    system = top(0.6)
    v = turning_velocity(system, np.array([0, 0, 5.0]))
    with pytest.warns(sr.SarrusWarning, match="is in no steady motion there"):
        found = sr.modes(system, system.q0, v)
    assert not found.success
    assert "is in no steady motion there" in found.message


def test_no_equilibrium_is_told() -> None:
    system = pendulum(angle=0.5)
    with pytest.warns(sr.SarrusWarning, match="is in no equilibrium there"):
        found = sr.modes(system, system.q0)
    assert not found.success
    assert "is in no equilibrium there" in found.message
    assert any(found.message in one for one in found.warnings)
    with pytest.raises(sr.StrictError, match="is in no equilibrium there"), sr.strict():
        sr.modes(system, system.q0)


def test_unknown_body() -> None:
    system = pendulum()
    with pytest.raises(KeyError, match='no body "bop"'):
        sr.modes(system, system.q0).shape(0, "bop")
