"""Singularities of inputs, manipulability."""

import numpy as np
import pytest

import sarrus as sr

from .mechanisms import arm, five_bar, platform_equilateral

HEIGHT = (1.2**2 - 1.0) ** 0.5  # of the cranks' common end over the middle of their pivots


@pytest.fixture(scope="module")
def found() -> sr.InputSingularities:
    system, output, _ = five_bar()
    return sr.input_singularities(system, output, ("a1", "a2"))


def test_five_bar_loses_control_where_its_rods_align(found: sr.InputSingularities) -> None:
    """Rods stretched: a coupler curve; rods on each other: circles about the two places where the cranks' ends meet."""
    assert found.success
    assert all(curve.closed for curve in found.curves)
    stretched, circles = 0, set()
    for curve in found.curves:
        ends = [curve.q[:, first : first + 2] for first in (14, 21)]  # the rods begin at the cranks' ends
        for corner in (HEIGHT, -HEIGHT):
            if abs(np.linalg.norm(curve.u - (0, corner), axis=1) - 1.5).max() < 1e-9:
                circles.add(corner)
        if abs(np.linalg.norm(curve.u - (ends[0] + ends[1]) / 2, axis=1)).max() < 1e-9:
            stretched += 1
            assert np.linalg.norm(ends[0] - ends[1], axis=1) == pytest.approx(3)
    assert (stretched, circles) == (1, {HEIGHT, -HEIGHT})


def test_outputs_are_lost_there(found: sr.InputSingularities) -> None:
    system, output, _ = five_bar()
    at = [curve.q[2] for curve in found.curves]
    assert max(one.conditioning for one in sr.dexterity(system, at, output, ("a1", "a2"))) < 1e-9


def test_manipulability_of_an_arm() -> None:
    """L1 L2 sin q2."""
    system, tip = arm([1, 0.7])
    for _, q in zip(range(5), sr.WorkspaceMap(system, tip["x", "y"]).samples, strict=False):
        q = q * sr.WorkspaceMap(system, tip["x", "y"]).problem.scale
        (one,) = sr.dexterity(system, q, tip["x", "y"], ("q1", "q2"))
        assert one.manipulability == pytest.approx(0.7 * abs(np.sin(system.joint("q2").angle(q))), rel=1e-9)


def test_section_of_a_platform() -> None:
    """At a fixed orientation, the legs lose control where their lines meet in a point."""
    system, output, legs = platform_equilateral()
    turn = sr.Turn(system.model.bodies[0])
    found = sr.input_singularities(system, output, legs, fixed={turn: 0.4})
    assert found.success
    assert found.curves
    feet = np.array([leg.point_i.coordinates for leg in legs])[:, :2]
    corners = np.array([leg.point_j.coordinates for leg in legs])[:, :2]
    c, s = np.cos(0.4), np.sin(0.4)
    arms = corners @ np.array([[c, s], [-s, c]])
    for curve in found.curves:
        for u in curve.u:
            d = u + arms - feet
            lines = np.column_stack([d, arms[:, 0] * d[:, 1] - arms[:, 1] * d[:, 0]])
            assert abs(np.linalg.det(lines)) < 1e-9


@pytest.mark.parametrize(
    ("inputs", "options", "told"),
    [(("a1",), {}, "give as many inputs"), (("a1", "a2"), {"fixed": {"b1": 0.0}}, "fix functions until two")],
)
def test_misuse(inputs: tuple[str, ...], options: dict[str, object], told: str) -> None:
    system, output, _ = five_bar()
    with pytest.raises(sr.SarrusError, match=told):
        sr.input_singularities(system, output, inputs, **options)
