"""Joints: their primitives, and that all of them vanish in the pose they were placed in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sarrus.elements import Dot1
from sarrus.model import (
    Body,
    Cartesian,
    ConstantAngle,
    Cylindrical,
    Distance,
    Fixed,
    Frame,
    Gear,
    Joint,
    Model,
    ModelError,
    ParallelAxes,
    Planar,
    Point,
    PointOnLine,
    PointOnPlane,
    Revolute,
    RevoluteRevolute,
    RevoluteSpherical,
    Screw,
    Spherical,
    Translational,
    Universal,
    ground,
)
from sarrus.model.expansion.blueprint import Blueprint, blueprint

LargestPhi = Callable[[Blueprint], float]
AllPhi = Callable[[Blueprint], np.ndarray]

A_I, A_J = (Rotation.from_rotvec(v).as_matrix() for v in ([0.4, 1.0, -2.0], [2.0, 0.1, 0.3]))
ONE = Body("one", 1.0, (1, 1, 1), position=(0.3, -0.2, 1.0), orientation=A_I)
TWO = Body("two", 1.0, (1, 1, 1), position=(-1.0, 2.0, 0.5), orientation=A_J)
POINT, AXIS = (0.7, 0.1, -0.4), np.array([1.0, 2.0, -0.5])
ACROSS = np.cross(AXIS, [0.0, 0.0, 1.0])

LABELS = {
    "spherical": ["point"],
    "revolute": ["point", "f_i.h_j", "g_i.h_j"],
    "universal": ["point", "h_i.h_j"],
    "translational": ["g_i.h_j", "f_i.h_j", "f_i.g_j", "g_i.d", "f_i.d"],
    "cylindrical": ["f_i.h_j", "g_i.h_j", "f_i.d", "g_i.d"],
    "fixed": ["point", "f_i.h_j", "g_i.h_j", "f_i.g_j"],
    "distance": ["distance"],
    "screw": ["f_i.h_j", "g_i.h_j", "f_i.d", "g_i.d", "screw"],
    "planar": ["f_i.h_j", "g_i.h_j", "h_i.d"],
    "cartesian": ["f_i.h_j", "g_i.h_j", "f_i.g_j"],
    "revolute_spherical": ["h_i.d", "distance"],
    "revolute_revolute": ["h_i.h_j", "h_i.d", "h_j.d", "distance"],
    "point_on_line": ["f_i.d", "g_i.d"],
    "point_on_plane": ["h_i.d"],
    "parallel_axes": ["f_i.h_j", "g_i.h_j"],
    "constant_angle": ["h_i.h_j"],
}
COUPLINGS = {"gear", "rack_and_pinion", "coupler", "formula_coupler"}  # see test_couplings.py
ROLLING = {"rolling_sphere", "rolling_disc", "rolling_wheel", "knife_edge"}  # see analyses/test_rolling.py
ROWS = {
    "spherical": 3,
    "revolute": 5,
    "universal": 4,
    "translational": 5,
    "cylindrical": 4,
    "fixed": 6,
    "distance": 1,
    "screw": 5,
    "planar": 3,
    "cartesian": 3,
    "revolute_spherical": 2,
    "revolute_revolute": 4,
    "point_on_line": 2,
    "point_on_plane": 1,
    "parallel_axes": 2,
    "constant_angle": 1,
}
ABOUT_AXIS = (
    "revolute",
    "translational",
    "cylindrical",
    "planar",
    "cartesian",
    "point_on_line",
    "point_on_plane",
    "screw",
)


def by_point(kind: str, i: Body, j: Body) -> Joint:
    """Return a joint that is placed by a global point and directions."""
    about: dict[str, object] = {}
    if kind in ABOUT_AXIS:
        about = {"axis": AXIS} | ({"pitch": 0.3} if kind == "screw" else {})
    if kind in ("revolute_spherical", "revolute_revolute"):
        return link(kind, i, j)
    if kind == "parallel_axes":
        return ParallelAxes("joint", i, j, axis=AXIS)
    if kind == "constant_angle":
        return ConstantAngle("joint", i, j, axis_i=AXIS, axis_j=(1.0, 0.0, 0.0))
    if kind == "universal":
        about = {"axis_i": AXIS, "axis_j": ACROSS}
    if kind == "distance":
        return Distance("joint", i.point(0.1, 0.2, 0.3), j.point(1.0, 0.0, 2.0))
    made: Any = Joint.kinds[kind]
    joint: Joint = made("joint", i, j, point=POINT, **about)
    return joint


def link(kind: str, i: Body, j: Body) -> Joint:
    """Return a link whose axes are normal to it, and neither parallel nor perpendicular to each other."""
    apart = np.array([0.3, -1.0, 0.4])
    ends = i.global_point(*POINT), j.global_point(*(np.array(POINT) + apart))
    across, other = np.cross(apart, AXIS), np.cross(apart, [1.0, 0.0, 0.2])
    if kind == "revolute_spherical":
        return RevoluteSpherical("joint", *ends, axis=across)
    return RevoluteRevolute("joint", *ends, axis_i=across, axis_j=other)


def plan_of(*joints: Joint) -> Blueprint:
    """Return the blueprint of the two bodies with joints."""
    return blueprint(Model("m", [ONE, TWO], joints))


def test_every_joint_is_tested_here() -> None:
    assert set(Joint.kinds) == set(LABELS) | COUPLINGS | ROLLING
    assert set(LABELS) == set(ROWS)


@pytest.mark.parametrize("kind", LABELS)
@pytest.mark.parametrize("pair", [(ONE, TWO), (TWO, ONE), (ground, TWO), (ONE, ground)], ids=range(4))
def test_phi_vanishes_in_the_pose_a_joint_was_placed_in(
    kind: str, pair: tuple[Body, Body], largest_phi: LargestPhi
) -> None:
    plan = plan_of(by_point(kind, *pair))
    number = {"ground": 0, "one": 1, "two": 2}
    own = [one for one in plan.placed if one.owner == "joint"]
    assert [one.label for one in own] == LABELS[kind]
    assert sum(one.element.rows for one in own) == ROWS[kind]
    assert {tuple(sorted(one.bodies)) for one in own} == {tuple(sorted(number[b.name] for b in pair))}
    assert largest_phi(plan) < 1e-15 * 20


@pytest.mark.parametrize("kind", LABELS)
def test_values_fit_the_elements_fields(kind: str) -> None:
    for one in plan_of(by_point(kind, ONE, TWO)).placed:
        kinds = list(one.element.fields.values())
        assert len(one.values) == len(kinds)
        assert all(len(v) == {"Vec3": 3, "Inertia": 6}[k] for v, k in zip(one.values, kinds) if k != "Scalar")
        assert all(type(v) is float for v, k in zip(one.values, kinds) if k == "Scalar")


UNIT = AXIS / np.linalg.norm(AXIS)


@pytest.mark.parametrize(
    ("kind", "turn", "slide", "free"),
    [
        ("screw", 0.8 * UNIT, 0.3 * 0.8 / (2 * np.pi) * UNIT, True),
        ("screw", 5.0 * UNIT, 0.3 * 5.0 / (2 * np.pi) * UNIT, True),
        ("screw", 0 * UNIT, 0.3 * UNIT, True),
        ("screw", 0.8 * UNIT, 0 * UNIT, False),
        ("screw", 0 * UNIT, 0.1 * UNIT, False),
        ("planar", 0.8 * UNIT, 0.5 * ACROSS, True),
        ("planar", 0 * UNIT, 0.1 * UNIT, False),
        ("planar", 0.1 * ACROSS, 0 * UNIT, False),
        ("cartesian", 0 * UNIT, np.array([1.0, 2.0, 3.0]), True),
        ("cartesian", 0.1 * UNIT, 0 * UNIT, False),
        ("point_on_line", [0.3, -0.4, 1.2], 0.3 * UNIT, True),
        ("point_on_line", 0 * UNIT, 0.3 * ACROSS, False),
        ("point_on_plane", [0.3, -0.4, 1.2], 0.3 * ACROSS, True),
        ("point_on_plane", 0 * UNIT, 0.3 * UNIT, False),
        ("parallel_axes", 0.8 * UNIT, np.array([1.0, 2.0, 3.0]), True),
        ("parallel_axes", 0.1 * ACROSS, 0 * UNIT, False),
        ("constant_angle", 0.8 * UNIT, np.array([1.0, 2.0, 3.0]), True),
        ("constant_angle", 0.1 * ACROSS, 0 * UNIT, False),
        ("revolute", 0.8 * UNIT, 0 * UNIT, True),
        ("revolute", 0.8 * ACROSS, 0 * UNIT, False),
        ("revolute", 0 * UNIT, 0.3 * UNIT, False),
        ("cylindrical", 0.8 * UNIT, 0.3 * UNIT, True),
        ("cylindrical", 0 * UNIT, 0.3 * ACROSS, False),
        ("cylindrical", 0.2 * ACROSS, 0 * UNIT, False),
        ("translational", 0 * UNIT, 0.3 * UNIT, True),
        ("translational", 0.8 * UNIT, 0 * UNIT, False),
        ("translational", 0 * UNIT, 0.3 * ACROSS, False),
        ("translational", 0.2 * ACROSS, 0 * UNIT, False),
        ("spherical", [0.3, -0.4, 1.2], 0 * UNIT, True),
        ("spherical", 0 * UNIT, 0.1 * UNIT, False),
        ("universal", 0.7 * UNIT, 0 * UNIT, True),
        ("universal", 0.7 * ACROSS, 0 * UNIT, True),
        ("universal", 0.7 * np.cross(UNIT, ACROSS), 0 * UNIT, False),
        ("fixed", 0 * UNIT, 0 * UNIT, True),
        ("fixed", 0.1 * UNIT, 0 * UNIT, False),
        ("fixed", 0.1 * ACROSS, 0 * UNIT, False),
        ("fixed", 0 * UNIT, 0.1 * UNIT, False),
    ],
)
def test_a_joint_lets_through_its_own_motions_only(
    kind: str, turn: object, slide: object, free: bool, largest_phi: LargestPhi
) -> None:
    plan = plan_of(by_point(kind, ONE, TWO))
    motion = Rotation.from_rotvec(turn)
    r = np.asarray(POINT) + motion.apply(np.asarray(TWO.position) - POINT) + slide
    p = Rotation.from_matrix(motion.as_matrix() @ A_J).as_quat(scalar_first=True)
    plan.q[7:] = [*r, *p]
    assert (largest_phi(plan) < 1e-14) is free


@pytest.mark.parametrize("kind", LABELS)
def test_the_equations_of_a_joint_are_independent(kind: str, all_phi: AllPhi) -> None:
    """The rank of Φ over the three rotations and three displacements of body two."""
    plan, h = plan_of(by_point(kind, ONE, TWO)), 1e-6
    columns = []
    for turn, slide in zip([*np.eye(3), *np.zeros((3, 3))], [*np.zeros((3, 3)), *np.eye(3)]):
        p = Rotation.from_matrix(Rotation.from_rotvec(h * turn).as_matrix() @ A_J).as_quat(scalar_first=True)
        q = np.concatenate([plan.q[:7], TWO.position + h * slide, p])
        columns.append(all_phi(replace(plan, q=q)) / h)
    assert np.linalg.matrix_rank(np.transpose(columns), tol=1e-3) == ROWS[kind]


BY_FRAMES: dict[str, Any] = {
    "planar": Planar,
    "cartesian": Cartesian,
    "point_on_line": PointOnLine,
    "point_on_plane": PointOnPlane,
    "parallel_axes": ParallelAxes,
    "revolute_spherical": RevoluteSpherical,
    "revolute_revolute": RevoluteRevolute,
    "revolute": Revolute,
    "translational": Translational,
    "cylindrical": Cylindrical,
    "fixed": Fixed,
}


@pytest.mark.parametrize("kind", BY_FRAMES)
def test_frames_and_points_place_the_same_joint(kind: str, largest_phi: LargestPhi) -> None:
    x, z = np.cross(AXIS, (1, 0, 0)), AXIS
    local = [body.frame(A.T @ (np.array(POINT) - body.position), x=A.T @ x, z=A.T @ z) for body, A in PLACES]
    around = [body.frame(body.global_point(*POINT), x=x, z=z) for body, _ in PLACES]
    more = {"length": 0.5} if kind.startswith("revolute_") else {}
    plans = [plan_of(BY_FRAMES[kind]("joint", frame_i=i, frame_j=j, **more)) for i, j in (local, around)]
    assert more or max(largest_phi(plan) for plan in plans) < 1e-14
    for one, other in zip(plans[0].placed, plans[1].placed):
        np.testing.assert_allclose(np.ravel(one.values[:2][0]), np.ravel(other.values[:2][0]), atol=1e-14)


PLACES = [(ONE, A_I), (TWO, A_J)]


def test_a_spherical_joint_takes_a_point_on_each_body() -> None:
    points = ONE.point(1, 2, 3), TWO.point(4, 5, 6)
    plan = plan_of(Spherical("joint", point_i=points[0], point_j=points[1]))
    assert plan.placed[0].values == ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))


def test_a_distance_keeps_the_length_it_is_given_or_the_one_it_has() -> None:
    i, j = ONE.global_point(0, 0, 0), ground.point(3, 4, 0)
    free, given = plan_of(Distance("d", i, j)), plan_of(Distance("d", i, j, length=7))
    assert abs(free.placed[0].values[2] - 5.0) < 1e-15 * 10
    assert given.placed[0].values[2] == 7.0


def test_axes_of_a_frame_are_right_handed_and_along_what_was_given() -> None:
    joint = Revolute(
        "pin", frame_i=ground.frame((1, 2, 3), x=(0, 3, 0), z=(0, 0, -2)), frame_j=ONE.frame((0, 0, 0))
    )
    placed = plan_of(joint).placed
    assert placed[1].element is Dot1
    f, g = placed[1].values[0], placed[2].values[0]
    np.testing.assert_array_equal([f, g], [(0, 1, 0), (1, 0, 0)])
    assert placed[1].values[1] == (0.0, 0.0, 1.0)


@pytest.mark.parametrize("z", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (1, 1, 1), (1e-9, 1, 0), (3e9, -2e9, 5e9)])
def test_any_axis_has_perpendiculars(z: tuple[float, float, float]) -> None:
    i, j = ground.frame((0, 0, 0), z=z), ONE.frame((0, 0, 0))
    _, f, g = (one.values[0] for one in plan_of(Revolute("pin", frame_i=i, frame_j=j)).placed[:3])
    axes = np.array([f, g, np.asarray(z) / np.linalg.norm(z)])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) > 0


WRONG = [
    (Revolute("pin", ONE, TWO, point=POINT), "axis is missing. Give point and axis in global axes"),
    (Revolute("pin", ONE, TWO, axis=AXIS), "point is missing. Give point and axis in global axes"),
    (Revolute("pin", point=POINT, axis=AXIS), "its bodies are missing"),
    (Revolute("pin", ONE, ONE, point=POINT, axis=AXIS), 'connects "one" to itself'),
    (Revolute("pin", ONE, TWO, point=POINT, axis=(0, 0, 0)), "axis has zero length"),
    (Revolute("pin", ONE, TWO, point=POINT, axis=(0, 1e-13, 0)), "axis has zero length"),
    (Revolute("pin", ONE, TWO, point=POINT, axis=(0, np.nan, 1)), "axis must be a finite number"),
    (Revolute("pin", ONE, TWO, point=(0, 0), axis=AXIS), "point must have 3 numbers, but has 2"),
    (Revolute("pin", frame_i=ONE.frame(POINT)), "one of its two frames is missing"),
    (Revolute("pin", frame_i=ONE.frame(POINT), frame_j=ONE.frame(POINT)), 'connects "one" to itself'),
    (
        Revolute("pin", TWO, frame_i=ONE.frame(POINT), frame_j=TWO.frame(POINT)),
        'frame_i is on "one", but the body',
    ),
    (
        Revolute("pin", point=POINT, frame_i=ONE.frame(POINT), frame_j=TWO.frame(POINT)),
        "both point and frames",
    ),
    (Revolute("pin", axis=AXIS, frame_i=ONE.frame(POINT), frame_j=TWO.frame(POINT)), "both axis and frames"),
    (
        Screw("pin", ONE, TWO, point=POINT, axis=AXIS, pitch=0),
        "pitch must not be 0. Give it in m, or use a revolute",
    ),
    (ParallelAxes("pin", ONE, TWO), "axis is missing"),
    (
        ConstantAngle("pin", ONE, TWO, axis_i=AXIS, axis_j=-AXIS),
        "its axes are parallel. Use a joint for parallel",
    ),
    (ConstantAngle("pin", ONE, TWO, axis_i=AXIS, axis_j=ACROSS, angle=0.0), "its axes are parallel"),
    (
        RevoluteSpherical("pin", ONE.point(0, 0, 0)),
        "its ends are missing. Give a point or a frame on each body",
    ),
    (
        RevoluteSpherical("pin", ONE.point(0, 0, 0), TWO.point(0, 0, 0)),
        "axis is missing. Give points and axis",
    ),
    (
        RevoluteRevolute("pin", ONE.point(0, 0, 0), ONE.point(0, 1, 0), axis_i=AXIS),
        'connects "one" to itself',
    ),
    (Gear("pin", "a", "b", ratio=2), 'there is no joint "a". '),
    (Fixed("pin", ONE, TWO), "point is missing. Give point in global axes, or a frame on each body"),
    (
        Fixed("pin", frame_i=ONE.frame(POINT, z=(0, 0, 0)), frame_j=TWO.frame(POINT)),
        "frame_i has zero length",
    ),
    (
        Fixed("pin", frame_i=ONE.frame(POINT), frame_j=TWO.frame(POINT, x=(1, 0, 0), z=(1, 0, 1))),
        "frame_j has axes x and z that are not perpendicular",
    ),
    (
        Universal("pin", ONE, TWO, point=POINT, axis_i=AXIS),
        "axis_j is missing. Give point and axis_i and axis_j",
    ),
    (Universal("pin", ONE, TWO, point=POINT, axis_i=AXIS, axis_j=AXIS), "must be perpendicular"),
    (Spherical("pin", ONE, TWO), "point is missing"),
    (Spherical("pin", point=POINT), "its bodies are missing"),
    (Spherical("pin", point_i=ONE.point(0, 0, 0)), "one of its two points is missing"),
    (Spherical("pin", ONE, TWO, POINT, ONE.point(0, 0, 0), TWO.point(0, 0, 0)), "has both point and points"),
    (Distance("pin", ONE.point(0, 0, 0), ground.point(0.3, -0.2, 1.0)), "its two points coincide"),
    (Distance("pin", ONE.point(0, 0, 0), ONE.point(1, 0, 0)), 'connects "one" to itself'),
    (Distance("pin", ONE.point(0, 0, 0), TWO.point(0, 0, 0), length=0.0), "length must be greater than 0"),
    (Spherical("pin", ONE, Body("tow", 1.0, (1, 1, 1)), point=POINT), 'no body "tow". Did you mean "two"?'),
    (
        Revolute(
            "pin", frame_i=Frame(Point(ONE, POINT)), frame_j=Frame(Point(Body("x", 1, (1, 1, 1)), POINT))
        ),
        'no body "x"',
    ),
]


@pytest.mark.parametrize(("joint", "phrase"), WRONG, ids=range(len(WRONG)))
def test_a_wrong_joint_is_refused_by_name(joint: Joint, phrase: str) -> None:
    with pytest.raises(ModelError) as caught:
        plan_of(joint)
    assert str(caught.value).startswith('joint "pin": ')
    assert phrase in str(caught.value)


def test_cylindrical_and_translational_need_an_axis() -> None:
    for kind in (Cylindrical, Translational):
        with pytest.raises(ModelError, match="axis is missing"):
            plan_of(kind("slide", ONE, TWO, point=POINT))


def test_one_body_of_two_is_refused_where_the_part_is_made() -> None:
    with pytest.raises(ModelError, match='Revolute "pin": one of its two bodies is missing'):
        Revolute("pin", ONE, point=POINT, axis=AXIS)
    Revolute("pin", ONE, frame_i=ONE.frame((0, 0, 0)), frame_j=TWO.frame((0, 0, 0)))
