"""Paths around and through spheres and cylinders: lengths against MuJoCo's, directions against complex steps."""

from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.model.forces.paths.wrapping import Corner, Detour

RADIUS = 0.3
WAYS = {"shorter": 0.0, "side": 2.0, "through": 0.5}  # distance of the side from the centre, over the radius


def path(p: Any, q: Any, side: Any, way: str, axis: Any = None) -> Detour:
    corner = Corner.of(p, q, RADIUS, side if way == "side" else None, axis)
    return corner.through() if way == "through" else corner.around()


def ends(number: int, seed: int = 1) -> Any:
    """Points in all positions: in the circle, near it and far from it."""
    rng = np.random.default_rng(seed)
    for _ in range(number):
        side = rng.normal(size=3)
        yield *(rng.normal(size=3) * rng.choice([0.2, 0.4, 1]) for _ in range(2)), side / np.linalg.norm(side)


FILE = """<mujoco><worldbody><site name="s" pos="1 2 3" euler="1 2 3"/><geom name="g" type="{}" size="0.3 1"/>
<body><freejoint/><geom size="1"/><site name="a"/></body><body><freejoint/><geom size="1"/><site name="b"/></body>
</worldbody><tendon><spatial><site site="a"/><geom geom="g"{}/><site site="b"/></spatial></tendon></mujoco>"""


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_lengths_are_those_of_mujoco(shape: str, way: str) -> None:
    mujoco: Any = pytest.importorskip("mujoco", "4.0")  # before, sites at the side had another meaning
    model = mujoco.MjModel.from_xml_string(FILE.format(shape, ' sidesite="s"' if WAYS[way] else ""))
    data, touching, flat = mujoco.MjData(model), 0, np.array([1, 1, int(shape == "sphere")])
    for p, q, direction in ends(500):
        side = WAYS[way] * RADIUS * direction
        model.site("s").pos[:] = side
        data.qpos[:3], data.qpos[7:10] = p, q
        mujoco.mj_forward(model, data)
        rise = (q - p) * (1 - flat)
        for axis in [None] if shape == "sphere" else [None, np.eye(3)[2], -np.eye(3)[2]]:
            flat_length = path(p * flat, q * flat, side * flat, way, axis).length
            found = np.hypot(flat_length, np.linalg.norm(rise))
            assert found == pytest.approx(data.ten_length[0], abs=1e-11)
        touching += data.ten_wrapnum[0] > 2
    assert 50 < touching < 450


@pytest.mark.parametrize("way", WAYS)
def test_directions_are_derivatives_of_the_length(way: str) -> None:
    for p, q, side in ends(100):
        found = path(p, q, side, way)
        for n in range(3):
            step = 1e-200j * np.eye(3)[n]
            assert path(p + step, q, side, way).length.imag / 1e-200 == pytest.approx(
                -found.first[n], abs=1e-10
            )
            assert path(p, q + step, side, way).length.imag / 1e-200 == pytest.approx(
                found.last[n], abs=1e-10
            )


OPPOSITE = {"side": (0, 0.5, 0.1), "side on the line": (2, 0, 0), "shorter": None}


@pytest.mark.parametrize("case", OPPOSITE)
@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_ends_on_opposite_sides_of_the_centre_have_a_path(shape: str, case: str) -> None:
    """Half a revolution less two angles around the shape, in the plane of the side if there is one."""
    side = None if OPPOSITE[case] is None else np.array(OPPOSITE[case], float)
    axis = np.array([0.0, 0, 1]) if shape == "cylinder" else None
    found = Corner.of(np.array([-1.0, 0, 0]), np.array([2.0, 0, 0]), RADIUS, side, axis).around()
    tangents = [np.sqrt(d * d - RADIUS**2) for d in (1, 2)]
    arc = np.pi - sum(np.arctan(t / RADIUS) for t in tangents)
    assert found.length == pytest.approx(sum(tangents) + RADIUS * arc, abs=1e-14)
    for direction, t, d in zip((found.first, found.last), tangents, (1, 2), strict=True):
        assert direction[0] == pytest.approx(t / d)
        assert np.linalg.norm(direction) == pytest.approx(1)
    if case == "side":
        toward = (side * (1, 1, axis is None))[1:]
        assert found.first[1:] == pytest.approx(RADIUS * toward / np.linalg.norm(toward))


@pytest.mark.parametrize("axis", [None, np.array([0.0, 0, 1])], ids=["sphere", "cylinder"])
@pytest.mark.parametrize("angle", [0, 1e-11, 1e-8, 1e-5])
def test_directions_through_a_ring_have_derivatives_where_both_ends_are_on_one_ray(
    angle: float, axis: Any
) -> None:
    """By complex steps, against central differences, in and out of the plane."""
    p, away = np.array([1.0, 0.2, 0.3]), np.array([0.3, -0.5, 0.1])

    def directions(q: Any) -> Any:
        found = Corner.of(p, q, RADIUS, None, axis).through()
        return np.array([found.first, found.last])

    for step in np.eye(3):
        q = 2 * p + angle * away
        found = directions(q + 1e-100j * step).imag / 1e-100
        expected = (directions(q + 1e-5 * step) - directions(q - 1e-5 * step)) / 2e-5
        np.testing.assert_allclose(found, expected, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(directions(q), axis=1), 1)


def system(first: Any, last: Any, around: sr.Wrap | None) -> sr.System:
    """A free body on a cable with inertia."""
    body = sr.Body("body", 1.0, (0.1, 0.1, 0.1), last)
    ends = [sr.ground.point(*first), body.point(0, 0, 0)]
    cable = sr.Tendon("cable", ends, around=[around], value="-10 - 3*x - 0.1*v", inertia=1.0)
    return sr.System(sr.Model("m", [body], [], [cable]))


V = np.array([0.1, 0.2, 0.3, 0, 0, 0, 0])
CENTER = sr.ground.point(0, 0, 0)


@pytest.mark.slow
def test_a_straight_cable_along_a_cylinder_has_the_derivatives_of_a_straight_cable() -> None:
    systems = [system((1, 0, 0), (1, 0, 1), one) for one in (None, sr.Wrap(CENTER, 0.2, axis=(0, 0, 1)))]
    goal, found = (one.forward_dynamics.hessian(one.q0, V, np.arange(7.0)) for one in systems)
    np.testing.assert_allclose(found, goal, atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "last", "wrap"),
    [
        ((-1, 0, 0), (1, 0, 0), sr.Wrap(CENTER, 0.2, (0, 0, 1), side=(0, 0.3, 0))),
        ((-1, 0, 0), (1, 1e-9, 0), sr.Wrap(CENTER, 0.2, (0, 0, 1), side=(0, 0.3, 0))),
        ((1, 0.2, 0), (2, 0.4, 0), sr.Wrap(CENTER, 0.2, side=(0, 0.05, 0))),
        ((1, 0.2, 0), (2, 0.4, 0.1), sr.Wrap(CENTER, 0.2, (0, 0, 1), side=(0, 0.05, 0))),
    ],
    ids=["cylinder, opposite", "cylinder, nearly opposite", "sphere, one ray", "cylinder, one ray"],
)
def test_derivatives_where_both_ends_are_on_a_line_through_the_centre(
    first: Any, last: Any, wrap: sr.Wrap
) -> None:
    """Against differences of accelerations, and of their derivatives."""
    cable = system(first, last, wrap)
    dynamics, q = cable.forward_dynamics, cable.q0
    found, second = dynamics.derivatives(q, V).a_q[:3, :3], dynamics.hessian(q, V, np.eye(7)[1])[:3, :3]
    for n, step in enumerate(1e-5 * np.eye(7)[:3]):
        change = (dynamics(q + step, V).a - dynamics(q - step, V).a)[:3] / 2e-5
        np.testing.assert_allclose(found[:, n], change, atol=1e-7)
        rows = [dynamics.derivatives(q + sign * step, V).a_q[1, :3] for sign in (1, -1)]
        np.testing.assert_allclose(second[:, n], (rows[0] - rows[1]) / 2e-5, atol=1e-6)
