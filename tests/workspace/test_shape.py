"""Derivatives of areas and reach by numbers of a design: closed forms, and workspaces of changed designs."""

import numpy as np
import pytest

import sarrus as sr

from .mechanisms import DEGREE, arm, arm_3r, five_bar, platform_equilateral


def area_of(system: sr.System, output: object, limits: object) -> sr.Workspace:
    return sr.workspace(system, output, limits=limits, verify=False)


def test_area_of_a_3r_arm() -> None:
    """By lengths, whose weighted sum is twice the area, and by limits; one-sided where two arcs coincide."""
    found = area_of(*arm_3r())
    lengths = ["q2[point].s_i.x", "q3[point].s_i.x", "link_3.x[x].s_j.x", "link_3.y[y].s_j.x"]
    by = sr.area_gradient(found, [*lengths, "q1.angle highest", "q2.angle highest", "q3.angle highest"])
    first, second, x, y = (by[name] for name in lengths)
    assert (first, second, x + y) == pytest.approx((5.7197512, 8.5388349, 23.0383461), rel=1e-7)
    assert 4 * first + 2 * second + x + y == pytest.approx(2 * found.area, rel=1e-7)
    assert by["q1.angle highest"] == pytest.approx(11.0, rel=1e-7)
    assert by["q2.angle highest"] == pytest.approx(22.7655924, rel=1e-7)
    assert by["q3.angle highest"] == pytest.approx(10.8827962, rel=1e-7)
    assert by.kinked == pytest.approx(np.sqrt(27) * np.pi / 3, rel=1e-6)
    assert "by q1.angle highest" in str(by)


@pytest.mark.slow
def test_area_of_a_platform_beside_changed_ones() -> None:
    """By the place of a foot, by a corner and by a limit."""
    h = 1e-4

    def changed(x: float, corner: float, longest: float) -> sr.Workspace:
        system, output, legs = platform_equilateral()
        one, *others = legs
        (fx, fy, fz), (cx, cy, cz) = one.point_i.coordinates, one.point_j.coordinates
        body = system.model.bodies[0]
        moved = sr.Length(sr.ground.point(fx + x, fy, fz), body.point(cx, cy + corner, cz), "leg 1")
        limits = {moved: (0.8, 2.2 + longest), **{leg: legs[leg] for leg in others}}
        return sr.workspace(system, output, limits=limits, verify=False, longest=0.15)

    names = ["leg 1[length].s_i.x", "leg 1[length].s_j.y", "leg 1 highest"]
    by = sr.area_gradient(changed(0, 0, 0), names)
    for n, name in enumerate(names):
        up, down = (changed(*(sign * h * np.eye(3)[n])).area for sign in (1, -1))
        assert by[name] == pytest.approx((up - down) / (2 * h), rel=2e-5, abs=2e-5)


@pytest.mark.slow
def test_area_by_a_number_of_the_model() -> None:
    """The pivot of a crank is moved on the ground and on the crank at once."""
    system, output, _ = five_bar()
    by = sr.area_gradient(area_of(system, output, {}), ["a1[point].s_i.x", "a1[point].s_j.x", "a1.point.x"])
    crank = system.model.bodies[0]
    along = crank.pose().A.T @ np.array([1.0, 0.0, 0.0])
    by_y = sr.area_gradient(area_of(system, output, {}), ["a1[point].s_j.y"])["a1[point].s_j.y"]
    both = by["a1[point].s_i.x"] + along[0] * by["a1[point].s_j.x"] + along[1] * by_y
    assert by["a1.point.x"] == pytest.approx(both, rel=1e-9)


@pytest.mark.slow
def test_reach_of_an_arm() -> None:
    """Upright with the shoulder at its limit: L1 sin 60° + L2 + L3."""
    system, output, limits = arm_3r()
    found = sr.workspace_range(system, output[1], limits=limits)
    names = ["q2[point].s_i.x", "q3[point].s_i.x", "link_3.y[y].s_j.x", "q1.angle highest"]
    by = sr.end_gradient(found, found.intervals[0][1], names)
    expected = [np.sin(60 * DEGREE), 1.0, 1.0, 4 * np.cos(60 * DEGREE)]
    assert [by[name] for name in names] == pytest.approx(expected, abs=1e-9)


def test_distance_from_the_boundary() -> None:
    """Of places before and behind the arm's outer circle, which has the radius L1 + L2 + L3, and beside a corner."""
    found = area_of(*arm_3r())
    names = ["q2[point].s_i.x", "q3[point].s_i.x"]
    for place, room in (((6.5, 1.0), 7 - np.sqrt(43.25)), ((8.0, 2.0), 7 - np.sqrt(68))):
        by = sr.distance_gradient(found, place, names)
        assert by.value == pytest.approx(room, abs=1e-10)
        assert [by[name] for name in names] == pytest.approx([1.0, 1.0], abs=1e-9)
    limit = sr.distance_gradient(found, (2.3, 5.7), ["q1.angle highest"])
    off = np.array([2.3, 5.7]) - (
        2,
        2 * np.sqrt(3),
    )  # about the elbow, a circle of 3 m that turns with the shoulder
    room = 3 - np.linalg.norm(off)
    assert limit.value == pytest.approx(room, abs=1e-10)
    elbow_moves = np.array([-2 * np.sqrt(3), 2])
    assert limit["q1.angle highest"] == pytest.approx(elbow_moves @ off / np.linalg.norm(off), abs=1e-9)
    with pytest.raises(sr.SarrusError, match="is a corner"):
        sr.distance_gradient(found, (-3.0, 0.0), names)


@pytest.mark.slow
def test_boundaries_without_speed() -> None:
    """Free angles have no boundary; an end where the constraints alone are singular has no derivative."""
    system, tip = arm([1, 0.7])
    with pytest.warns(sr.SarrusWarning, match="no boundary curve was found"):
        free = sr.workspace(system, ("q1.angle", "q2.angle"), verify=False)
    with pytest.raises(sr.SarrusError, match="arm: what is not complete has no derivatives"):
        sr.distance_gradient(free, (0.0, 0.0), [])
    found = sr.workspace_range(system, tip["x"])
    end = found.intervals[0][1]
    for start in found.search.found:
        start.x[-1] = 0.0
    with pytest.raises(sr.SarrusError, match=r"link_2\(0\.7, 0, 0\)\.x: no end at 1\.7 moves"):
        sr.end_gradient(found, end, [])


def test_misuse() -> None:
    system, tip = arm([1, 0.7])
    found = area_of(system, tip["x", "y"], {})
    with pytest.raises(sr.SarrusError, match="q2"):
        sr.area_gradient(found, ["q7.point.x"])
    with pytest.raises(sr.SarrusError, match=r"one by one: q2\.point\.x"):
        sr.area_gradient(found, ["q2.point"])
