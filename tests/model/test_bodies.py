"""Bodies: poses, rates and inertia, against SciPy's rotations, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sarrus import load
from sarrus.model import AxisAngle, Body, EulerAngles, Model, ModelError, ground
from sarrus.model.expansion.blueprint import blueprint

TURN = Rotation.from_rotvec([0.3, -1.1, 2.0])


def of(orientation: object) -> np.ndarray:
    """Return the rotation matrix that a blueprint holds for an orientation."""
    body = Body("b", 1.0, (1, 1, 1), orientation=orientation)  # type: ignore[arg-type]
    p = blueprint(Model("m", [body])).q[3:]
    assert abs(p @ p - 1) < 1e-15
    return np.asarray(Rotation.from_quat(p, scalar_first=True).as_matrix())


@pytest.mark.parametrize("turn", list(Rotation.random(20, random_state=1)), ids=range(20))
def test_every_way_to_give_an_orientation_is_the_same_rotation(turn: Rotation) -> None:
    vector = turn.as_rotvec()
    ways = [
        turn.as_quat(scalar_first=True),
        -turn.as_quat(scalar_first=True),
        turn.as_matrix(),
        turn.as_matrix().tolist(),
        AxisAngle(5.0 * vector, float(np.linalg.norm(vector))),
        EulerAngles(turn.as_euler("ZXZ"), "zxz"),
        EulerAngles(turn.as_euler("XYZ")),
    ]
    for way in ways:
        np.testing.assert_allclose(of(way), turn.as_matrix(), atol=1e-14)


@pytest.mark.parametrize("axis", np.eye(3), ids="xyz")
def test_half_turns_are_read_from_their_matrix(axis: np.ndarray) -> None:
    A = 2 * np.outer(axis, axis) - np.eye(3)
    np.testing.assert_array_equal(of(A), A)


def test_rounded_euler_parameters_are_normalized() -> None:
    p = np.round(TURN.as_quat(scalar_first=True), 7)
    np.testing.assert_allclose(of(p), TURN.as_matrix(), atol=1e-6)


@pytest.mark.parametrize(
    ("orientation", "phrase"),
    [
        ((1.0, 0.0, 0.0, 1e-2), "orientation must be unit Euler parameters"),
        (np.diag([1.0, 1.0, -1.0]), "right-handed"),
        (1.001 * np.eye(3), "not perpendicular unit vectors"),
        (AxisAngle((0, 0, 0), 1.0), "orientation axis has zero length"),
        (AxisAngle((0, 0, 1), np.nan), "orientation angle must be a finite number"),
        (EulerAngles((0, 0, 0), "xyw"), "orientation sequence must be three axes"),
        (EulerAngles((0, 0), "xyz"), "orientation angles must have 3 numbers"),
        ("upright", "orientation must be a list of numbers"),
        (np.array(1.0), "orientation must be a list of numbers, but is 1.0"),
        ([[1, 0, 0], 1, 1], "orientation must be a list of numbers, but is 1"),
        (None, "orientation must be a list of numbers, but is empty"),
    ],
)
def test_what_is_no_rotation_is_refused(orientation: object, phrase: str) -> None:
    with pytest.raises(ModelError, match=f'^body "b": .*{phrase}'):
        of(orientation)


def test_rates_turn_the_body_with_its_angular_velocity() -> None:
    omega, h = np.array([0.4, -2.0, 1.0]), 1e-6
    body = Body("b", 1.0, (1, 1, 1), orientation=TURN.as_matrix(), velocity=(1, 2, 3), angular_velocity=omega)
    plan = blueprint(Model("m", [body]))
    np.testing.assert_array_equal(plan.v[:3], (1, 2, 3))
    later = Rotation.from_quat(plan.q[3:] + h * plan.v[3:], scalar_first=True)
    np.testing.assert_allclose((later * TURN.inv()).as_rotvec() / h, omega, atol=1e-8)
    assert abs(plan.q[3:] @ plan.v[3:]) < 1e-15


def inertia_of(inertia: object) -> tuple[float, ...]:
    """Return the six entries that a blueprint holds for an inertia."""
    plan = blueprint(Model("m", [Body("b", 1.0, inertia)]))  # type: ignore[arg-type]
    entries: tuple[float, ...] = plan.placed[0].values[1]
    return entries


def test_every_way_to_give_an_inertia_is_the_same_tensor() -> None:
    entries = {"xx": 2.0, "yy": 3.0, "zz": 4.0, "xy": 0.1, "xz": 0.2, "yz": 0.3}
    J = np.array([[2.0, 0.1, 0.2], [0.1, 3.0, 0.3], [0.2, 0.3, 4.0]])
    assert inertia_of(entries) == inertia_of(J) == inertia_of(J.tolist()) == tuple(entries.values())
    assert inertia_of((2, 3, 4)) == inertia_of(np.diag([2, 3, 4])) == (2, 3, 4, 0, 0, 0)


def test_a_flat_plate_is_allowed_and_a_hair_more_is_not() -> None:
    assert inertia_of((0.1, 0.2, 0.1 + 0.2)) == (0.1, 0.2, 0.1 + 0.2, 0, 0, 0)
    with pytest.raises(ModelError, match='body "b": inertia breaks the triangle inequality'):
        inertia_of((0.1, 0.2, 0.3 * (1 + 1e-6)))


def test_the_triangle_inequality_holds_for_principal_moments_not_for_the_diagonal() -> None:
    A = Rotation.from_rotvec([0.5, 0.2, -0.4]).as_matrix()
    turned = A @ np.diag([1.0, 1.0, 2.2]) @ A.T
    assert turned[0, 0] + turned[1, 1] > turned[2, 2]
    with pytest.raises(ModelError, match=r"principal moments are 1, 1, 2\.2"):
        inertia_of(turned)


@pytest.mark.parametrize("inertia", [(1, 1, 0), (1, 1, -1), {"xx": 1, "yy": 1, "zz": 1, "xy": 1.5}])
def test_an_inertia_that_is_not_positive_definite_is_refused(inertia: object) -> None:
    with pytest.raises(ModelError, match='body "b": inertia must be positive definite'):
        inertia_of(inertia)


@pytest.mark.parametrize("mass", [0, -1, np.nan, np.inf, "0", None, True, 1e60, 10**400])
def test_what_is_no_mass_is_refused(mass: object) -> None:
    with pytest.raises(ModelError, match=r'^body "b": mass .*. Give the mass in kg\.$'):
        blueprint(Model("m", [Body("b", mass, (1, 1, 1))]))  # type: ignore[arg-type]


def test_a_centre_of_mass_off_the_origin_makes_eccentric_elements() -> None:
    bodies = [Body("a", 1.0, (1, 1, 1)), Body("b", 2.0, (1, 1, 1), center_of_mass=(0, 0, 0.5))]
    plan = blueprint(Model("m", bodies, gravity=(0, 0, -9.81)))
    shown = [(one.element.__name__, one.bodies, one.values) for one in plan.placed]
    assert shown == [
        ("RigidInertia", (1,), (1.0, (1, 1, 1, 0, 0, 0))),
        ("EccentricInertia", (2,), (2.0, (1, 1, 1, 0, 0, 0), (0, 0, 0.5))),
        ("Gravity", (1,), (1.0, (0, 0, -9.81))),
        ("EccentricGravity", (2,), (2.0, (0, 0, 0.5), (0, 0, -9.81))),
    ]


def test_without_gravity_there_is_no_weight() -> None:
    plan = blueprint(Model("m", [Body("a", 1.0, (1, 1, 1))]))
    assert [one.element.__name__ for one in plan.placed] == ["RigidInertia"]


def test_the_ground_has_the_reserved_name() -> None:
    assert ground.name == "ground"
    with pytest.raises(ModelError, match='the name "ground" is taken by the ground'):
        blueprint(Model("m", [Body("ground", 1.0, (1, 1, 1))]))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"mass": -1.0, "inertia": (1, 1, 1)}, "mass must be greater than 0, but is -1"),
        ({"mass": (1, 1, 1), "inertia": 2.0}, "mass must be a number, but is a list"),
        (
            {"mass": "2 m", "inertia": (1, 1, 1)},
            'mass must be in kg, or another unit of that kind, got "2 m"',
        ),
        ({"mass": 1.0, "inertia": (1, 1, 5)}, "inertia breaks the triangle inequality"),
        ({"mass": 1.0, "inertia": (1, 1, 1), "position": (0, 0)}, "position must have 3 numbers"),
    ],
)
def test_a_body_that_cannot_be_is_refused_where_it_is_made(given: Any, message: str) -> None:
    with pytest.raises(ModelError, match=f'body "b": {re.escape(message)}'):
        Body("b", **given)


def test_a_file_reports_every_wrong_body_and_none_that_is_missing(tmp_path: Path) -> None:
    """Joints may connect bodies that are refused."""
    file = tmp_path / "two.yaml"
    file.write_text(
        "bodies:\n  a: {mass: -1, inertia: [1, 1, 1]}\n  b: {mass: 1, inertia: [1, 1, 5]}\n"
        "joints:\n  j: {type: revolute, bodies: [a, b], point: [0, 0, 0], axis: [0, 0, 1]}\n"
        "  k: {type: revolute, bodies: [a, c], point: [0, 0, 0], axis: [0, 0, 1]}\n"
    )
    with pytest.raises(ModelError, match=r'two.yaml:2: body "a": mass must be .* \(and 2 more\)$'):
        load(file)
