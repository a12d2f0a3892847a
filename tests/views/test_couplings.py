"""Gears, racks and couplers are drawn: wheels that touch, turn with their bodies, and mesh with a rack that follows."""

from __future__ import annotations

import numpy as np
import pytest

import sarrus as sr
from sarrus.views.looks import sketch
from sarrus.views.looks.part import Part

Z = (0, 0, 1)


def wheel(name: str, x: float, y: float = 0.0) -> sr.Body:
    return sr.Body(name, mass=1, inertia=(0.1, 0.1, 0.1), position=(x, y, 0))


def model(ratio: float = -2.0, radius: float = 0.15, apart: float = 0.3) -> sr.Model:
    a, b, rack, other = wheel("a", 0), wheel("b", apart), wheel("rack", -0.1, 0.1), wheel("other", 0.8)
    return sr.Model(
        "gears",
        [a, b, rack, other],
        [
            sr.Revolute("A", sr.ground, a, point=(0, 0, 0), axis=Z),
            sr.Revolute("B", b, sr.ground, point=(apart, 0, 0), axis=Z),
            sr.Translational("slide", sr.ground, rack, point=(-0.1, 0.1, 0), axis=(1, 0, 0)),
            sr.Revolute("C", sr.ground, other, point=(0.8, 0, 0), axis=Z),
            sr.Gear("gear", "A", "B", ratio=ratio),
            sr.RackAndPinion("teeth", "slide", "A", radius=radius),
            sr.Coupler("coupler", "C.angle", "A.angle", ratio=0.5),
        ],
    )


def parts(of: sr.Model, name: str) -> list[Part]:
    return [part for part in sketch(of).parts if part.name == name]


def radius(part: Part) -> float:
    """Of a wheel, teeth included, about the axis z of its body."""
    return float(np.linalg.norm(part.mesh.vertices[:, :2], axis=1).max())


def test_gears_touch_and_have_the_ratio_of_their_angles() -> None:
    one, other = parts(model(ratio=-2.0), "gear")
    assert (one.body, other.body) == (1, 2)
    assert radius(one) + radius(other) == pytest.approx(0.3, rel=0.05)  # with both heights of teeth
    assert radius(one) / radius(other) == pytest.approx(2.0, rel=0.05)
    assert one.description == "gear, angle of B = -2 times that of A"


def test_wheels_of_the_same_sense_do_not_touch() -> None:
    one, other = parts(model(ratio=2.0), "gear")
    assert radius(one) + radius(other) < 0.2


@pytest.mark.parametrize("size", [0.15, -0.15])
def test_a_rack_lies_where_the_pinion_moves_it_its_own_way(size: float) -> None:
    """At the pinion's lower side, turned about z, the rim moves along x; at its upper side, against it."""
    pinion, rack = parts(model(radius=size), "teeth")
    height = rack.mesh.vertices[:, 1].mean() + 0.1  # the rack's frame stands there
    assert (pinion.body, rack.body) == (1, 3)
    assert radius(pinion) == pytest.approx(0.15, rel=0.05)
    assert height == pytest.approx(-size, rel=0.1)


def test_what_a_coupler_joins_is_marked_on_both_joints() -> None:
    found = parts(model(), "coupler")
    assert {part.body for part in found} == {1, 4}
    assert "0.5 times" in found[0].description


def test_a_body_that_is_a_wheel_has_a_hub_and_no_block() -> None:
    (hub,) = parts(model(), "a")
    (block,) = parts(model(), "other")
    assert radius(hub) < 0.5 * radius(block)
