"""Static equilibria: closed forms, the vehicle's reference, stability."""

import numpy as np
import pytest
from tests.analyses.driven import MASS, G, J, L, pendulum
from tests.analyses.linkages import bennett, sarrus
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr

FREQUENCIES = [
    0.81384,
    1.23916,
    1.83293,
    2.07777,
    9.00204,
    9.11632,
    9.17198,
    9.37482,
]  # [Hz], the reference's digits


@pytest.mark.parametrize("angle", [0.4, 2.0, 3.0, np.pi, -3.1])
def test_a_pendulum_comes_to_hang(angle: float) -> None:
    found = sr.equilibrium(pendulum(angle=angle))
    assert found.success, found.message
    assert found.stability == "stable"
    assert str(found) == found.message
    assert np.allclose(found.q[:2], [0, -L], atol=1e-10)
    assert found.squares == pytest.approx([MASS * G * L / (J + MASS * L**2)], rel=1e-9)


def test_the_nearest_equilibrium_may_be_unstable() -> None:
    found = sr.equilibrium(pendulum(angle=3.0), stable=False)
    assert found.success
    assert found.stability == "unstable"
    assert "unstable along 1 motion" in found.message
    assert np.allclose(found.q[:2], [0, L], atol=1e-10)
    assert found.squares == pytest.approx([-MASS * G * L / (J + MASS * L**2)], rel=1e-9)


def test_slider_crank_with_its_spring() -> None:
    """Along the crank's angle, weight and spring balance: 2.5 g z_B' and k (x - 5) x', for z_B = 1 + 2 cos θ."""
    found = sr.equilibrium(slider_crank())
    assert found.success, found.message
    assert found.stability == "stable"
    y, z = found.q[1], found.q[2]  # the crank's centre, half way to the pin
    th = np.arctan2(-(y - 1), z - 1)
    x = np.sqrt(19 + 4 * np.sin(th) - 4 * np.cos(th))
    slope = 2 * (np.cos(th) + np.sin(th)) / x
    weight = 9.81 * (
        -np.sin(th) - np.sin(th)
    )  # of the crank at half height, of the rod at half the pin's height
    assert weight + 10 * (x - 5) * slope == pytest.approx(0, abs=1e-9)
    assert found.q[14] == pytest.approx(x, abs=1e-10)


@pytest.mark.parametrize(("stable", "off"), [(True, 0.03), (False, 0.005)])
@pytest.mark.parametrize("seed", range(3))
def test_the_vehicle_settles_on_its_wheels(seed: int, stable: bool, off: float) -> None:
    system = hmmwv()
    disturbed = system.q0 + off * np.random.default_rng(seed).normal(size=system.nq)
    found = sr.equilibrium(system, disturbed, stable=stable)
    assert found.success, found.message
    assert found.stability == "neutral"
    assert "3 motions have no stiffness" in found.message
    assert found.residual < 1e-7
    assert np.allclose(found.q[2::7], system.q0[2::7], atol=1e-9)  # heights
    assert np.allclose(np.sqrt(found.squares[3:]) / (2 * np.pi), FREQUENCIES, atol=1e-5)


def test_newton_converges_quadratically() -> None:
    """With one wrong derivative the last steps would fall by a constant factor instead."""
    system = hmmwv()
    disturbed = system.q0 + 0.003 * np.random.default_rng(5).normal(size=system.nq)
    assert sr.equilibrium(system, disturbed).iterations <= 6


def test_far_away() -> None:
    """Dropped from half a metre, rolled and pitched: the wheels find the ground again."""
    system = hmmwv()
    lifted = system.q0.copy()
    lifted[2::7] += 0.5
    found = sr.equilibrium(system, lifted)
    assert found.success, found.message
    assert np.allclose(found.q[2::7], system.q0[2::7], atol=1e-8)


def test_a_held_driver_bears_the_weight() -> None:
    system = pendulum("2*t")
    found = sr.equilibrium(system, t=0.35)
    assert found.success
    assert "cannot move at all" in found.message
    torque = system.reaction("motor_0", found.q, found.lam, 0.35).torque
    assert torque == pytest.approx([0, 0, MASS * G * L * np.sin(0.7)], abs=1e-11)


def test_a_body_that_falls_has_none() -> None:
    stone = sr.Body("stone", mass=1.0, inertia=(1, 1, 1))
    system = sr.System(sr.Model("stone", [stone], gravity=(0, 0, -G)))
    for stable in (True, False):
        found = sr.equilibrium(system, stable=stable, iterations=30)
        assert not found.success
        assert found.stability == "unknown"
        assert "no equilibrium found" in found.message


def test_a_body_without_forces_is_neutral() -> None:
    stone = sr.Body("stone", mass=1.0, inertia=(1, 1, 1))
    found = sr.equilibrium(sr.System(sr.Model("stone", [stone])))
    assert found.success
    assert found.stability == "neutral"
    assert "6 motions have no stiffness" in found.message


def test_a_linkage_that_does_not_close() -> None:
    rod = sr.Body("rod", mass=1.0, inertia=(1, 1, 1))
    rope = sr.Distance("rope", sr.ground.point(0, 0, 0), rod.point(1, 0, 0), length=1.0)
    post = sr.Spherical("post", sr.ground, rod, point=(3, 0, 0))
    far = sr.Distance("far", sr.ground.point(0, 0, 0), rod.point(3, 0, 0), length=9.0)
    found = sr.equilibrium(sr.System(sr.Model("contradiction", bodies=[rod], joints=[post, rope, far])))
    assert not found.success
    assert "could not be assembled" in found.message


def test_a_rest_where_motions_cross_is_told() -> None:
    """Sarrus' linkage hangs with straight arms, where each pair of them could move by itself for an instant."""
    rest = sr.equilibrium(sarrus())
    assert rest.q[2] == pytest.approx(-2)
    assert "the constraints lose rank here" in rest.message
    assert "lose rank" not in sr.equilibrium(bennett()).message


def test_a_start_at_a_failed_equilibrium_is_a_warning() -> None:
    ball = sr.Body("ball", mass=1, inertia=(1, 1, 1))
    system = sr.System(sr.Model("ball", [ball], gravity=(0, 0, -9.81)))
    with pytest.warns(sr.SarrusWarning, match="ball: the start is a failed search for an equilibrium"):
        sr.simulate(system, sr.equilibrium(system), until=0.1)


@pytest.mark.parametrize("angle", [1.0, 3.5, -6.2])
def test_equilibria_have_their_revolutions(angle: float) -> None:
    """A body on a torsion spring rests where the spring is free: outputs, restarts and derivatives know how far."""
    body = sr.Body("b", 1.0, (0.2, 0.2, 0.2))
    where = {"point": (0, 0, 0), "axis": (0, 0, 1)}
    spring = sr.RSDA("s", sr.ground, body, k=3.0, c=0.05, angle=angle, **where)
    system = sr.System(sr.Model("m", [body], [sr.Revolute("pin", sr.ground, body, **where)], [spring]))
    rest = sr.equilibrium(system)
    assert rest.success, rest.message
    assert [rest["pin.angle"], rest["s.torque"], rest["s.energy"]] == pytest.approx([angle, 0, 0], abs=1e-9)
    assert sr.sensitivity(rest, ["pin.angle"], ["s.k"]).matrix == pytest.approx(0.0, abs=1e-9)
    assert sr.modes(system, rest).frequencies == pytest.approx(
        np.sqrt(3 / 0.2 - 0.025**2 / 0.04) / 2 / np.pi, rel=1e-4
    )
    for start in (rest, {"equilibrium": True}):
        run = sr.simulate(system, start, until=1.0)
        assert run["pin.angle"] == pytest.approx(angle, abs=1e-9)
    assert sr.equilibrium(system, run.final)["pin.angle"] == pytest.approx(angle, abs=1e-9)


@pytest.mark.filterwarnings("ignore:spring. angle is")
@pytest.mark.parametrize("stable", [True, False])
@pytest.mark.parametrize("angle", [0.5, 2.0, 10.0, 40.0])
def test_a_spring_that_relaxes_leaves_no_other_force(angle: float, stable: bool) -> None:
    """Where the only force vanishes, what remains is that of the last step; the way there has several turns."""
    rod = sr.Body("rod", 1.0, (0.1, 0.1, 0.1), position=(1, 0, 0))
    hinge = sr.Revolute("hinge", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1))
    spring = sr.RSDA("spring", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1), k=10.0, c=0.0, angle=angle)
    found = sr.equilibrium(sr.System(sr.Model("relaxed", [rod], [hinge], [spring])), stable=stable)
    assert found.success, found.message
    assert found["hinge.angle"] == pytest.approx(angle, rel=1e-9)
    assert found.squares == pytest.approx([10.0 / 1.1], rel=1e-9)


def test_a_weight_beside_a_stiff_spring_that_relaxes() -> None:
    """A body that falls has no equilibrium, however stiff a spring of another body is."""
    fixed = sr.Body("fixed", 1.0, (0.1, 0.1, 0.1), position=(1, 0, 0))
    free = sr.Body("free", 1.0, (0.1, 0.1, 0.1), position=(0, 1, 0))
    joints = [
        sr.Translational("rail", sr.ground, fixed, point=(0, 0, 0), axis=(1, 0, 0)),
        sr.Translational("drop", sr.ground, free, point=(0, 1, 0), axis=(0, 0, 1)),
    ]
    spring = sr.TSDA("spring", sr.Point(sr.ground, (0, 0, 0)), sr.Point(fixed, (0, 0, 0)), k=1e9, length=1.3)
    model = sr.Model("falls", [fixed, free], joints, [spring], gravity=(0, 0, -9.81))
    found = sr.equilibrium(sr.System(model))
    assert not found.success
    assert "a force of 9.81 remains" in found.message
