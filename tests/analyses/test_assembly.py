"""Assembly: the nearest consistent state, or a sentence that says what stays open."""

import numpy as np
import pytest
from tests.analyses.linkages import contradictory_door, door, four_bar, four_bar_points
from tests.analyses.rough import rough
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr
from sarrus.euler import E, rotate

STARTS = 200


@pytest.mark.parametrize("system", [slider_crank, pytest.param(hmmwv, marks=pytest.mark.slow)])
def test_from_rough_guesses(system: object) -> None:
    """At least 95 % of 200 starts; all of them, when this was written."""
    made, random = system(), np.random.default_rng(0)  # type: ignore[operator]
    found = [sr.assemble(made, rough(made, random)) for _ in range(STARTS)]
    closed = [a for a in found if a.success and abs(made.Phi(a.q)).max() < 1e-12]
    assert len(closed) >= 0.95 * STARTS
    assert sum(a.nearest for a in closed) >= 0.95 * len(closed)


@pytest.mark.slow
def test_restarts_help_very_rough_guesses() -> None:
    """Bodies 1 m and 80° off: half of the searches get stuck, most restarts do not."""
    system, closed = hmmwv(), {}
    for restarts in (0, 8):
        random = np.random.default_rng(5)
        guesses = [rough(system, random, 1.0, 80) for _ in range(20)]
        closed[restarts] = sum(sr.assemble(system, q, restarts=restarts).success for q in guesses)
    assert closed[8] >= closed[0] + 4


@pytest.mark.parametrize("system", [slider_crank, hmmwv])
def test_from_disturbed_coordinates(system: object) -> None:
    made = system()  # type: ignore[operator]
    disturbed = made.q0 + 0.02 * np.random.default_rng(1).normal(size=made.nq)
    speed = np.random.default_rng(2).normal(size=made.nq)
    with pytest.warns(sr.SarrusWarning, match="velocity"):
        found = sr.assemble(made, disturbed, speed)
    assert found.success, found.message
    assert abs(made.Phi(found.q)).max() < 1e-12
    assert abs(made.Phi_q_xi(found.q, found.v)).max() < 1e-12
    assert 0 < found.iterations < 12


@pytest.mark.parametrize("metric", ["unit", "mass", "own"])
def test_the_change_is_the_least(metric: str) -> None:
    """No neighbour on the constraints is nearer to the guess, and the gradient along them vanishes."""
    system, random = slider_crank(), np.random.default_rng(4)
    weight: object = random.uniform(0.5, 2, size=system.nq) if metric == "own" else metric
    found = sr.assemble(system, rough(system, random), metric=weight)  # type: ignore[arg-type]
    assert found.nearest
    assert found.asked is not None
    W, guess = found.asked.weight, found.asked.q
    assert np.allclose(W * (found.q - guess) + system.Phi_qT_lam(found.q, found.lam), 0, atol=1e-10)
    motion = sr.mobility(system, found.q).motions[:, 0]
    distance = np.sum(W * (found.q - guess) ** 2)
    for step in (-0.05, 0.05):
        other = sr.assemble(system, found.q + step * motion).q
        assert np.sum(W * (other - guess) ** 2) > distance + 1e-5


def test_metric_is_checked() -> None:
    with pytest.raises(ValueError, match="metric must be"):
        sr.assemble(slider_crank(), metric="heavy")
    with pytest.raises(ValueError, match="positive"):
        sr.assemble(slider_crank(), metric=np.zeros(slider_crank().nq))


def test_velocity_is_changed_least() -> None:
    system = slider_crank()
    speed = np.random.default_rng(3).normal(size=system.nq)
    with pytest.warns(sr.SarrusWarning, match="velocity"):
        found = sr.assemble(system, system.q0, speed)
    assert found.asked is not None
    change = found.asked.weight * (found.v - speed)
    inside = np.linalg.lstsq(system.Phi_q(found.q).toarray().T, change, rcond=None)[0]
    assert np.allclose(system.Phi_q(found.q).T @ inside, change, atol=1e-12)


def test_euler_parameters_of_any_length() -> None:
    system = slider_crank()
    long = system.q0.reshape(-1, 7).copy()
    long[:, 3:] *= 3
    long[1, 3:] = 0
    found = sr.assemble(system, long.reshape(-1))
    assert found.success, found.message
    with pytest.raises(ValueError, match="finite"):
        sr.assemble(system, np.full(system.nq, np.nan))


def test_held_coordinates_and_bodies_stay() -> None:
    system, random = slider_crank(), np.random.default_rng(5)
    place = system.coordinate_names.index("slider.r.x")
    guess = rough(system, random, 0.1, 10)
    guess[place] = 4.5
    found = sr.assemble(system, guess, fixed=["slider.x"])
    assert found.success, found.message
    assert found.q[place] == 4.5
    vehicle = hmmwv()
    chassis = vehicle.coordinates_of("chassis")
    guess = rough(vehicle, random)
    guess[chassis] = vehicle.q0[chassis]
    found = sr.assemble(vehicle, guess, fixed=["chassis"])
    assert found.success, found.message
    assert np.array_equal(found.q[chassis], vehicle.q0[chassis])


def test_held_beyond_reach() -> None:
    system = slider_crank()
    guess = system.q0.copy()
    guess[system.coordinate_names.index("slider.r.x")] = 9.0  # the crank and the rod are 7 m together
    found = sr.assemble(system, guess, fixed=["slider.x"])
    assert not found.success
    assert " m" in found.message


@pytest.mark.parametrize("name", ["slyder", "slider.w"])
def test_unknown_names_are_refused(name: str) -> None:
    with pytest.raises(KeyError, match="slider"):
        sr.assemble(slider_crank(), fixed=[name])
    with pytest.raises(KeyError, match="slider"):
        sr.assemble(slider_crank(), rates={name: 1.0})


@pytest.mark.parametrize("side", [1, -1])
def test_the_guess_chooses_the_branch(side: int) -> None:
    """Open or crossed: the four-bar is built open; the guess is near one of the two positions of its coupler."""
    system = four_bar(1.0, 3.0, 2.5, 3.2, 0.9, side=1)
    A, B, C, D = four_bar_points(1.0, 3.0, 2.5, 3.2, 0.9, side)
    start = four_bar_points(1.0, 3.0, 2.5, 3.2, 0.9, 1)
    q = np.zeros((3, 7))
    for n, (one, other, one_0, other_0) in enumerate(
        ((A, B, start[0], start[1]), (B, C, start[1], start[2]), (C, D, start[2], start[3]))
    ):
        angle = np.arctan2(*(other - one)[[1, 0]]) - np.arctan2(*(other_0 - one_0)[[1, 0]])
        q[n] = [*(one + other) / 2, np.cos(angle / 2), 0, 0, np.sin(angle / 2)]
    assert np.allclose(system.Phi(q.reshape(-1)), 0, atol=1e-12)
    random = np.random.default_rng(6)
    found = sr.assemble(system, q.reshape(-1) + 0.05 * random.normal(size=21))
    assert found.success, found.message
    half = (start[2] - start[1]) / 2
    coupler = found.q[7:14]
    b, c = (coupler[:3] + rotate(coupler[3:], sign * half) for sign in (-1, 1))
    assert np.sign(np.cross(D - b, c - b)[2]) == side


def test_given_rates() -> None:
    system = slider_crank()
    crank, slider = system.coordinates_of("crank"), system.coordinates_of("slider")
    found = sr.assemble(system, rates={"pin": 3.0})
    assert found.success, found.message
    omega = 2 * E(found.q[crank][3:]) @ found.v[crank][3:]
    assert np.allclose(omega, [3.0, 0, 0], atol=1e-10)
    assert np.allclose(system.Phi_q_xi(found.q, found.v), 0, atol=1e-12)
    by_coordinate = sr.assemble(system, rates={"slider.x": -2.0})
    by_joint = sr.assemble(system, rates={"guide": -2.0})
    assert by_coordinate.v[slider][0] == pytest.approx(-2, abs=1e-12)
    assert np.allclose(by_coordinate.v, by_joint.v, atol=1e-12)


BODY = sr.Body("body", 1.0, (1, 1, 1), position=(0.4, 0.1, 0.2))
PLACED = {"point": (0.1, 0.2, 0), "axis": (0, 0, 1)}
JOINTS = {
    "revolute": sr.Revolute("j", sr.ground, BODY, **PLACED),
    "translational": sr.Translational("j", sr.ground, BODY, **PLACED),
    "cylindrical": sr.Cylindrical("j", sr.ground, BODY, **PLACED),
    "screw": sr.Screw("j", sr.ground, BODY, pitch=0.1, **PLACED),
    "planar": sr.Planar("j", sr.ground, BODY, **PLACED),
    "point on line": sr.PointOnLine("j", sr.ground, BODY, **PLACED),
    "point on plane": sr.PointOnPlane("j", sr.ground, BODY, **PLACED),
    "parallel axes": sr.ParallelAxes("j", sr.ground, BODY, axis=(0, 0, 1)),
    "universal": sr.Universal("j", sr.ground, BODY, point=(0, 0, 0), axis_i=(1, 0, 0), axis_j=(0, 1, 0)),
}


@pytest.mark.parametrize("kind", JOINTS)
def test_every_angle_and_displacement_can_be_given_its_rate(kind: str) -> None:
    system = sr.System(sr.Model(kind, [BODY], [JOINTS[kind]]))
    names = system.joint("j").names
    for name in names:
        found = sr.assemble(system, rates={f"j.{name}": 0.7})
        assert found.success, found.message
        assert system.joint("j")[name].rate(found.q, found.v) == pytest.approx(0.7)
    if len(names) > 1:
        with pytest.raises(KeyError, match=f"{kind} has no output 'j'. (Did you|Choose)"):
            sr.assemble(system, rates={"j": 0.7})


def test_contradicting_rates_are_refused() -> None:
    found = sr.assemble(slider_crank(), rates={"pin": 3.0, "slider.x": 5.0})
    assert not found.success
    assert "no velocity satisfies" in found.message
    assert "slider.x by" in found.message or "pin by" in found.message


def test_a_door_on_two_hinges() -> None:
    system, random = door(), np.random.default_rng(7)
    for _ in range(20):
        with pytest.warns(sr.SarrusWarning, match="velocity"):
            found = sr.assemble(system, rough(system, random), random.normal(size=7))
        assert found.success, found.message
        assert abs(system.Phi(found.q)).max() < 1e-12
        assert abs(system.Phi_q_xi(found.q, found.v)).max() < 1e-12


def test_open_joints_are_named() -> None:
    found = sr.assemble(contradictory_door())
    assert not found.success
    assert "contradictory door could not be assembled" in found.message
    assert "hinge_1 by 0.05 m" in found.message
    assert "hinge_2 by 0.05 m" in found.message
    assert " rad" not in found.message


def test_the_gap_of_a_rod_is_its_missing_length() -> None:
    rod = sr.Body("rod", mass=1.0, inertia=(1, 1, 1))
    post = sr.Fixed("post", sr.ground, rod, point=(0, 0, 0))
    far = sr.Distance("far", sr.ground.point(0, 0, 0), rod.point(3, 0, 0), length=9.0)
    system = sr.System(sr.Model("contradiction", bodies=[rod], joints=[post, far]))
    found = sr.assemble(system, fixed=["rod"])
    assert not found.success
    assert "far by 6 m" in found.message
    assert np.all(np.isfinite(found.q))


def test_velocities_follow_constraints_that_move(monkeypatch: pytest.MonkeyPatch) -> None:
    """Φ_q v = -Φ_t, here with a Φ_t that the mechanism can follow."""
    system, random = slider_crank(), np.random.default_rng(8)
    Phi_t = system.Phi_q(system.q0) @ random.normal(size=system.nq)
    monkeypatch.setattr(type(system), "Phi_t", lambda self, q, t=0.0: t * Phi_t)
    found = sr.assemble(system, t=2.0)
    assert found.success, found.message
    assert np.allclose(system.Phi_q_xi(found.q, found.v), -2 * Phi_t, atol=1e-10)


@pytest.mark.parametrize("degrees", [20, 160])
def test_fixed_joints_that_close_half_a_revolution_away_are_warned_of(degrees: float) -> None:
    base = sr.Body("base", mass=1, inertia=(1, 1, 1))
    block = sr.Body("block", mass=1, inertia=(1, 1, 1), position=(1, 0, 0))
    joints = [
        sr.Revolute("pin", sr.ground, base, point=(0, 0, 0), axis=(0, 1, 0)),
        sr.Fixed("weld", base, block, point=(0.5, 0, 0)),
    ]
    system = sr.System(sr.Model("welded", [base, block], joints))
    guess = system.q0.reshape(-1, 7).copy()
    guess[1, 3:] = np.cos(np.radians(degrees / 2)), 0, 0, np.sin(np.radians(degrees / 2))
    if degrees < 90:
        assert sr.assemble(system, guess.ravel()).warnings == ()
        return
    with pytest.warns(sr.SarrusWarning, match="weld: block is turned over by 180 deg relative to base"):
        assert sr.assemble(system, guess.ravel()).success


@pytest.mark.parametrize("arm", [0.0, 5e-5, 2e-4])
def test_points_beside_the_origins_of_bodies_do_not_slow_the_search(arm: float) -> None:
    """A gantry with points at the origins of its bodies, but for one nearby: a unit of its arms alone would be tiny."""
    x, y = sr.Body("x", 20.0, (1, 1, 1), (0.301, 0, 0)), sr.Body("y", 10.0, (1, 1, 1), (0.301, 1.2, 0))
    z = sr.Body("z", 5.0, (1, 1, 1), (0.3, 1.201, 0.7))
    pairs = [(sr.ground, x, (1, 0, 0)), (x, y, (0, 1, 0)), (y, z, (0, 0, 1))]
    joints = [
        sr.Translational(
            f"guide_{n}", frame_i=i.frame((arm, 0, 0), z=axis), frame_j=j.frame((0, 0, 0), z=axis)
        )
        for n, (i, j, axis) in enumerate(pairs)
    ]
    found = sr.assemble(sr.System(sr.Model("gantry", [x, y, z], joints)))
    assert found.nearest
    assert found.iterations <= 3


@pytest.mark.parametrize("off", [0.0, 5e-17, 1e-13, 1e-9])
def test_round_off_of_concentric_points_does_not_change_the_speed(off: float) -> None:
    """A rotor beside its axis by round-off has no size with which rotations could be compared, but for its inertia."""
    rotor = sr.Body("rotor", 1.0, (0.02, 0.02, 0.03), position=(0, off, 0), angular_velocity=(0, 0, 10.0))
    hinge = sr.Revolute("hinge", sr.ground, rotor, point=(0, 0, 0), axis=(0, 0, 1))
    system = sr.System(sr.Model("rotor", [rotor], [hinge]))
    found = sr.assemble(system)
    assert found.success
    assert 2 * found.v[6] == pytest.approx(10.0, rel=1e-12)


def test_concentric_bodies_are_assembled_from_guesses_that_are_off() -> None:
    wheel = sr.Body("wheel", 1.0, (0.02, 0.02, 0.03))
    system = sr.System(sr.Model("top", [wheel], [sr.Spherical("pivot", sr.ground, wheel, point=(0, 0, 0))]))
    for off in (1e-14, 1e-10, 1e-6, 1e-2):
        found = sr.assemble(system, system.q0 + off * np.eye(7)[0])
        assert found.nearest
        assert found.iterations <= 2
