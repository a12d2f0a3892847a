"""Redundant joints whose data were rounded: they are corrected once, and the mechanism moves as without rounding."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import sarrus as sr

ROUNDED = pytest.warns(sr.SarrusWarning, match="redundant joints .* disagree by rounding")
METHODS = [sr.Radau(), sr.HHT(), sr.GeneralizedAlpha()]
GROUND, CRANK, COUPLER, ROCKER = 1.2345671, 0.4, (1.3345671, 0.7), (0.1, 1.1)


def flap(error: float, gravity: float = 9.81) -> sr.Model:
    """Return a body of 1 kg whose hinge is two ball joints on the z axis, one of them drawn a little too far."""
    body, on_ground = sr.Body("flap", 1.0, (0.01,) * 3, (0.1, 0, 0)), sr.ground.point
    joints = [
        sr.Spherical("top", point_i=on_ground(0, 0, 0.1), point_j=body.point(-0.1, 0, 0.1 + error)),
        sr.Spherical("bottom", point_i=on_ground(0, 0, -0.1), point_j=body.point(-0.1, 0, -0.1)),
    ]
    return sr.Model("door", [body], joints, gravity=(0, -gravity, 0))


def four_bar(digits: int | None, driver: str = "") -> sr.Model:
    """Return a crank, coupler and rocker in a plane of any direction, with points and axes rounded in body axes."""
    plane, random = Rotation.from_rotvec((0.3, 0.2, 0.5)).as_matrix(), np.random.default_rng(0)
    solids: dict[str, tuple[sr.Body, NDArray[np.float64], NDArray[np.float64]]] = {}
    for name, x in (
        ("crank", (0.1, 0.2, 0.03)),
        ("coupler", (0.6, 0.8, -0.02)),
        ("rocker", (1.3, 0.5, 0.01)),
    ):
        A = Rotation.random(rng=random).as_matrix()
        axes = [tuple(row) for row in A]
        body = sr.Body(name, 1.0, (0.1, 0.1, 0.1), position=tuple(plane @ x), orientation=axes)
        solids[name] = body, np.array(x), A.T @ plane

    def frame(name: str | None, point: tuple[float, float]) -> sr.Frame:
        body, x, A = solids[name] if name else (sr.ground, np.zeros(3), plane)
        p, z = A @ ((*point, 0) - x), A @ (0, 0, 1)
        rounded = (tuple(v if digits is None else np.round(v, digits)) for v in (p, z))
        return body.frame(next(rounded), z=next(rounded))

    tip = GROUND + ROCKER[0], ROCKER[1]
    places = {
        "A": (None, "crank", (0.0, 0.0)),
        "B": ("crank", "coupler", (0.0, CRANK)),
        "C": ("coupler", "rocker", tip),
        "D": (None, "rocker", (GROUND, 0.0)),
    }
    joints: list[sr.Joint] = [
        sr.Revolute(name, frame_i=frame(i, at), frame_j=frame(j, at)) for name, (i, j, at) in places.items()
    ]
    drivers = [sr.AngleDriver("motor", "A", driver)] if driver else []
    bodies = [body for body, *_ in solids.values()]
    return sr.Model("four-bar", bodies, joints, drivers=drivers, gravity=tuple(plane @ (0, -9.81, 0)))


def rocker_angle(crank: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angle of the rocker from its first position by the intersection of two circles, for angles of the crank."""
    x, y = -CRANK * np.sin(crank) - GROUND, CRANK * np.cos(crank)
    distance, length, coupler = np.hypot(x, y), np.hypot(*ROCKER), np.hypot(*COUPLER)
    inner = np.arccos((length**2 + distance**2 - coupler**2) / (2 * length * distance))
    angle = np.unwrap(np.arctan2(y, x)) - inner
    return np.asarray(angle - angle[0])


@pytest.mark.parametrize("error", [1e-11, 1e-9, 1e-6])
@pytest.mark.parametrize("method", METHODS, ids=["radau", "hht", "alpha"])
def test_a_hinge_of_two_balls_turns_as_a_pendulum(error: float, method: object) -> None:
    with ROUNDED:
        system = sr.System(flap(error))
    run = sr.simulate(system, until=0.6, method=replace(method, rtol=1e-7))
    assert run.success, run.message
    pendulum = solve_ivp(lambda _, y: (y[1], -9.81 * 0.1 / 0.02 * np.cos(y[0])), (0, 0.6), (0, 0), rtol=1e-10)
    angle = pendulum.y[0, -1]
    assert angle < -np.pi / 2
    assert run["flap.x"][-1] == pytest.approx(0.1 * np.cos(angle), abs=1e-5)
    assert run["flap.y"][-1] == pytest.approx(0.1 * np.sin(angle), abs=1e-5)
    assert max(run.violation) < 1e-9
    assert len(run.warnings) == 1


@pytest.mark.parametrize("digits", [5, 6, 8])
def test_a_rounded_four_bar_moves_through_a_revolution_as_circles_intersect(digits: int) -> None:
    with ROUNDED:
        free = sr.System(four_bar(digits))
    angle = float(free.joint("A").angle(free.q0))
    with ROUNDED:
        system = sr.System(four_bar(digits, f"{angle} + 2*pi*t"))
    motion = sr.kinematics(system, until=1.0, steps=50)
    assert motion.success, motion.message
    expected = rocker_angle(2 * np.pi * motion.t)
    turned = motion["D.angle"] - motion["D.angle"][0]
    assert np.sign(turned[10]) * turned == pytest.approx(
        np.sign(expected[10]) * expected, abs=30 * 10.0**-digits
    )
    assert max(motion.violation) < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS, ids=["radau", "hht", "alpha"])
def test_runs_statics_and_modes_of_a_rounded_four_bar_are_those_without_rounding(method: object) -> None:
    exact = sr.System(four_bar(None))
    with ROUNDED:
        rounded = sr.System(four_bar(6))
    runs = [sr.simulate(system, until=1.5, method=replace(method, rtol=1e-8)) for system in (rounded, exact)]
    assert all(run.success for run in runs)
    assert np.ptp(runs[0]["A.angle"]) > np.pi / 2
    assert runs[0]["A.angle"][-1] == pytest.approx(runs[1]["A.angle"][-1], abs=1e-4)
    assert max(runs[0].violation) < 1e-8
    rest = [sr.equilibrium(system) for system in (rounded, exact)]
    assert all(found.success for found in rest)
    assert rest[0].q == pytest.approx(rest[1].q, abs=1e-5)
    frequencies = [
        sr.modes(system, at).natural_frequencies for system, at in zip((rounded, exact), rest, strict=True)
    ]
    assert frequencies[0] == pytest.approx(frequencies[1], rel=1e-5)
    assert sr.mobility(rounded).degrees_of_freedom == 1
    assert sr.linearize(rounded, rest[0]).A.shape == sr.linearize(exact, rest[1]).A.shape


def test_a_planar_four_bar_that_is_drawn_with_few_digits_is_not_corrected() -> None:
    corners, z = [(0, 0, 0), (0, 1, 0), (2.123457, 1.654321, 0), (2, 0, 0)], (0, 0, 1)
    arms = [(0, 1, 0), (2.1234567, 0.6543211, 0), (0.1234567, 1.6543211, 0)]
    a, b, c = (sr.Body(f"rod_{n}", 1.0, (0.1,) * 3, position=corners[n]) for n in (0, 1, 3))
    tips = [body.frame(arm, z=z) for body, arm in zip((a, b, c), arms, strict=True)]
    pairs = [
        (sr.ground, a.frame((0, 0, 0), z=z)),
        (tips[0], b),
        (tips[1], tips[2]),
        (sr.ground.frame((2, 0, 0)), c),
    ]
    frames = [[x if isinstance(x, sr.Frame) else x.frame((0, 0, 0), z=z) for x in pair] for pair in pairs]
    joints = [sr.Revolute(f"pin_{n}", frame_i=i, frame_j=j) for n, (i, j) in enumerate(frames)]
    system = sr.System(sr.Model("planar", [a, b, c], joints))
    assert not system.warnings
    assert sr.assemble(system).success


@pytest.mark.parametrize("error", [-1e-6, 1e-6])
def test_rods_that_just_reach_each_other_are_not_corrected(error: float) -> None:
    body = sr.Body("knot", 1.0, (0.1,) * 3, (1, 0, 0))
    rods = [
        sr.Distance("left", sr.ground.point(0, 0, 0), body.point(0, 0, 0), 1 + error),
        sr.Distance("right", sr.ground.point(2, 0, 0), body.point(0, 0, 0), 1.0),
    ]
    system = sr.System(sr.Model("rods", [body], rods))
    assert not system.warnings
    found = sr.assemble(system)
    assert found.success == (error > 0)
    assert "left" in found.message or found.success


def test_joints_that_disagree_by_more_than_rounding_are_refused_by_name() -> None:
    found = sr.assemble(sr.System(flap(1e-4)))
    assert not found.success
    assert "could not be assembled; still open" in found.message
    assert "top" in found.message


@pytest.mark.parametrize(("offset", "tilt"), [(1e-3, 0), (0, 1e-3), (1e-6, 0)])
def test_rates_of_misaligned_hinges_are_refused_because_of_their_positions(
    offset: float, tilt: float
) -> None:
    door = sr.Body("door", 20, (2, 1, 1), (0.4, 0, 1))
    hinges = [
        sr.Revolute("low", sr.ground, door, point=(0, 0, 0.3), axis=(0, 0, 1)),
        sr.Revolute("high", sr.ground, door, point=(offset, 0, 1.7), axis=(tilt, 0, 1)),
    ]
    found = sr.assemble(sr.System(sr.Model("door", [door], hinges)), rates={"low": 1.0})
    assert not found.success
    assert found.message == (
        "door is assembled, but its joints and drivers leave no degree of freedom there for the rates of low. "
        "Give no rates, or check the points and axes of low, high"
    )
