"""Couplings and drivers: which element each becomes, what it says in the initial pose, and what is refused."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from sarrus import elements as el
from sarrus.model import (
    AngleDriver,
    Body,
    CoordinateDriver,
    Coupler,
    Curve,
    Cylindrical,
    DisplacementDriver,
    DistanceDriver,
    Driver,
    Gear,
    Joint,
    Model,
    ModelError,
    Planar,
    Point,
    PointDriver,
    RackAndPinion,
    Revolute,
    Spherical,
    Translational,
    Universal,
    ground,
)
from sarrus.model.expansion.blueprint import Blueprint, blueprint

A, B, C = (Body(name, 1.0, (1, 1, 1), position=(x, 0, 0)) for x, name in enumerate("abc"))
PINS = [
    Revolute("pin", ground, A, point=(0, 0, 0), axis=(0, 0, 1)),
    Revolute(
        "turned",
        frame_i=ground.frame((1, 0, 0), x=(1, 0, 0), z=(0, 0, 1)),
        frame_j=B.frame((0, 0, 0), x=(0, 2, 0), z=(0, 0, 1)),
    ),
    Translational("slide", ground, C, point=(0, 0, 0), axis=(0, 1, 0)),
    Cylindrical("sleeve", A, B, point=(0, 0, 0), axis=(1, 0, 0)),
    Spherical("ball", B, C, point=(2, 0, 0)),
    Universal("hook", A, C, point=(2, 0, 0), axis_i=(0, 0, 1), axis_j=(0, 1, 0)),
    Planar("table", ground, C, point=(2, 0, 0), axis=(0, 0, 1)),
]


def plan(joints: Sequence[Joint] = (), drivers: Sequence[Driver] = ()) -> Blueprint:
    return blueprint(Model("m", [A, B, C], [*PINS, *joints], drivers=drivers))


def added(part: Joint | Driver) -> Any:
    found = plan([part]) if isinstance(part, Joint) else plan(drivers=[part])
    (placed,) = (one for one in found.placed if one.owner == part.name)
    return placed


def test_coordinates_of_joints() -> None:
    names = [f"{one.owner}.{one.label}" for one in plan().coordinates]
    assert names == [
        "pin.angle", "turned.angle", "slide.displacement", "sleeve.angle", "sleeve.displacement",
        "hook.angle_i", "hook.angle_j", "table.angle", "table.displacement_x", "table.displacement_y",
    ]  # fmt: skip


def test_placed_by_axes_all_coordinates_start_at_zero() -> None:
    starts = {f"{one.owner}.{one.label}": one.values[-1] for one in plan().coordinates}
    assert starts.pop("turned.angle") == pytest.approx(np.pi / 2)
    assert max(abs(start) for start in starts.values()) < 1e-15


@pytest.mark.parametrize(
    ("coupling", "element", "bodies", "numbers"),
    [
        (Gear("g", "pin", "turned", ratio=-2.0), el.AngleAngle, (0, 1, 0, 2), (-2.0, np.pi / 2, 0.0)),
        (Gear("g", "turned", "pin", ratio=-2.0), el.AngleAngle, (0, 2, 0, 1), (-2.0, np.pi, np.pi / 2)),
        (Gear("g", "pin", "hook.angle_j", ratio=3, offset=1), el.AngleAngle, (0, 1, 3, 1), (3.0, 1.0, 0.0)),
        (
            RackAndPinion("g", "slide", "turned", radius=0.1),
            el.DisplacementAngle,
            (0, 3, 0, 2),
            (0.1, -0.05 * np.pi),
        ),
        (Coupler("g", "pin", "slide", ratio=0.1), el.DisplacementAngle, (0, 3, 0, 1), (0.1, 0.0)),
        (
            Coupler("g", "slide", "pin", ratio=10.0, offset=2.0),
            el.DisplacementAngle,
            (0, 3, 0, 1),
            (0.1, -0.2),
        ),
        (
            Coupler("g", "slide", "sleeve.displacement", ratio=2),
            el.DisplacementDisplacement,
            (0, 3, 1, 2),
            (2.0, 0.0),
        ),
    ],
)
def test_a_coupling_is_one_element(coupling: Joint, element: type, bodies: object, numbers: object) -> None:
    placed = added(coupling)
    assert (placed.element, placed.bodies) == (element, bodies)
    np.testing.assert_allclose(placed.values[6:], numbers, atol=1e-15)


@pytest.mark.parametrize(
    ("driver", "element", "bodies", "at_two"),
    [
        (AngleDriver("d", "pin", 1.5), el.AngleDriver, (0, 1), 1.5),
        (AngleDriver("d", "hook.angle_i", "2*t + 30 deg"), el.AngleDriver, (1, 3), 4 + np.pi / 6),
        (DisplacementDriver("d", "slide", lambda t: 0.5 * t * t), el.DisplacementDriver, (0, 3), 2.0),
        (DisplacementDriver("d", "table.displacement_y", [(0, 0), (4, 8)]), el.DisplacementDriver, (0, 3), 4.0),
        (DistanceDriver("d", A.point(0, 0, 0), B.point(0, 0, 0), "1 m + 0.1*sin(t)"), el.DistanceDriver, (1, 2),
         1 + 0.1 * np.sin(2)),
        (PointDriver("d", B.point(0, 0, 1), y=Curve.constant(3.0)), el.DisplacementDriver, (0, 2), 3.0),
        (CoordinateDriver("d", C, "e2", 0.25), el.CoordinateDriver, (3,), 0.25),
    ],
)  # fmt: skip
def test_a_driver_is_one_element(driver: Driver, element: type, bodies: object, at_two: float) -> None:
    placed = added(driver)
    assert (placed.element, placed.bodies) == (element, bodies)
    scale, curve = placed.values[-2:]
    assert scale * curve(2.0) == pytest.approx(at_two)


def test_drivers_stand_between_joints_and_inertia() -> None:
    found = plan(drivers=[PointDriver("path", A.point(0, 0, 0), x="t", y="sin(t)", z=0.0)])
    owners = [one.owner for one in found.placed]
    assert owners.index("path") > owners.index("table")
    assert owners.index("path") < owners.index("a")
    assert [one.label for one in found.placed if one.owner == "path"] == ["x", "y", "z"]


WRONG = [
    (
        Gear("g", "pin", "slide", ratio=1),
        'joint "g": joint "slide" has no angle. Its coordinates: slide.displacement.',
    ),
    (Gear("g", "pni", "pin", ratio=1), 'joint "g": there is no joint "pni". Did you mean "pin"?'),
    (
        Gear("g", "pin", "hook", ratio=1),
        'joint "hook" has more than one angle. Name one it has: hook.angle_i',
    ),
    (
        Gear("g", "pin", "hook.angle", ratio=1),
        'joint "hook" has no angle "angle". Name one it has: hook.angle_i',
    ),
    (Gear("g", "pin", "turned", ratio=0), 'joint "g": ratio must not be 0'),
    (Gear("g", "pin", "ball", ratio=1), 'joint "ball" has no angle. Its coordinates: none.'),
    (RackAndPinion("g", "pin", "slide", radius=1), 'joint "slide" has no angle'),
    (
        Coupler("g", "sleeve", "pin", ratio=1),
        "more than one coordinate. Name one it has: sleeve.angle, ",
    ),
    (AngleDriver("d", "slide", 1.0), 'driver "d": joint "slide" has no angle'),
    (AngleDriver("d", "pin", "2*x"), 'driver "d": motion has the unknown name "x"'),
    (AngleDriver("d", "pin", float("nan")), 'driver "d": motion must be a finite number'),
    (AngleDriver("d", "pin", [(0, 1)]), 'driver "d": motion must have at least two points'),
    (AngleDriver("d", "pin", lambda t: t if t > 1 else 0), 'driver "d": motion cannot be used as a formula'),
    (PointDriver("d", A.point(0, 0, 0)), 'driver "d": has no path. Give at least one of x, y and z'),
    (PointDriver("d", Point(ground, (0, 0, 0)), x=1.0), 'driver "d": acts on the ground'),
    (DistanceDriver("d", A.point(0, 0, 0), A.point(1, 0, 0), 1.0), 'connects "a" to itself'),
    (CoordinateDriver("d", A, "w", 1.0), "coordinate must be one of x, y, z, e0, e1, e2, e3"),  # type: ignore[arg-type]
    (CoordinateDriver("d", Body("z", 1, (1, 1, 1)), "x", 1.0), 'there is no body "z"'),
]


@pytest.mark.parametrize(("part", "phrase"), WRONG, ids=range(len(WRONG)))
def test_a_wrong_coupling_or_driver_is_refused_by_name(part: Joint | Driver, phrase: str) -> None:
    with pytest.raises(ModelError) as caught:
        added(part)
    assert phrase in str(caught.value)
