"""Singularities of inputs, manipulability."""

import csv
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

from .mechanisms import arm, five_bar, orthogonal_arm, platform_equilateral

HEIGHT = (1.2**2 - 1.0) ** 0.5  # of the cranks' common end over the middle of their pivots


@pytest.fixture(scope="module")
def found() -> sr.InputSingularities:
    system, output, _ = five_bar()
    return sr.input_singularities(system, output, ("a1", "a2"))


@pytest.mark.slow
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


def angles_of(system: sr.System, v: np.ndarray) -> np.ndarray:
    """Of the cranks from the x-axis; joints count from the model's position."""
    bodies = {body.name: body.orientation for body in system.model.bodies}
    drawn = [2 * np.arctan2(bodies[name][3], bodies[name][0]) for name in ("crank_1", "crank_2")]
    return np.asarray(v + drawn)


def test_control_is_lost_at_a_distance_of_the_cranks(found: sr.InputSingularities) -> None:
    """Over the inputs: the cranks' ends are two rods apart, or in one place, which is a point of the inputs."""
    system, _, _ = five_bar()
    for curve in found.curves:
        a = angles_of(system, curve.input_line)
        one = np.stack([-1 + 1.2 * np.cos(a[:, 0]), 1.2 * np.sin(a[:, 0])], axis=1)
        other = np.stack([1 + 1.2 * np.cos(a[:, 1]), 1.2 * np.sin(a[:, 1])], axis=1)
        away = np.linalg.norm(one - other, axis=1)
        exact = away[:: (len(curve.line) - 1) // (len(curve.u) - 1)]
        if np.ptp(curve.v, axis=0).max() < 1e-6:
            assert away == pytest.approx(0, abs=1e-6)
        else:
            assert exact == pytest.approx(3, abs=1e-9)
            assert away == pytest.approx(3, abs=1e-4)
            assert np.ptp(curve.v, axis=0).max() > 1


@pytest.mark.slow
def test_outputs_lose_a_direction_where_a_crank_and_its_rod_align() -> None:
    system, output, _ = five_bar()
    found = sr.input_singularities(system, output, ("a1", "a2"), lost="outputs")
    assert found.success
    for curve in found.curves:
        a = angles_of(system, curve.v)
        off = []
        for n, x in enumerate((-1, 1)):
            crank = np.stack([np.cos(a[:, n]), np.sin(a[:, n])], axis=1)
            reached = curve.u - (x, 0)
            off.append(abs(crank[:, 0] * reached[:, 1] - crank[:, 1] * reached[:, 0]).max())
        assert min(off) < 1e-9
        assert abs(np.diff(curve.input_line, axis=0)).max() < 1  # angles go on from each other
    assert max(np.ptp(curve.v) for curve in found.curves) > np.pi


@pytest.mark.slow
def test_an_orthogonal_arm_loses_a_direction_on_two_curves_of_its_angles() -> None:
    """cos q2 (cos q3 - 2 sin q3) = sin q3, on both sides of q2 = 0; one of its parts is missed by 30 random starts."""
    system, tip = orthogonal_arm()
    x, y, z = tip["x", "y", "z"]
    inputs = ("q1", "q2", "q3")
    found = sr.input_singularities(system, (x, z), inputs, lost="outputs", fixed={y: 0.3})
    assert found.success
    assert "the last 100 crossings by random walks were of known curves" in found.message
    lower = []
    for curve in found.curves:
        _, q2, q3 = curve.v.T
        assert abs(np.cos(q2) * (np.cos(q3) - 2 * np.sin(q3)) - np.sin(q3)).max() < 1e-9
        lower += np.sign(q2[abs(q3 + 1.5) < 0.4]).tolist()
    assert set(lower) == {1, -1}


def test_pictures_over_the_inputs(found: sr.InputSingularities) -> None:
    """Angles between -π and π, with gaps where a curve leaves at a side; points are dots."""
    axes = found.plot(over="inputs")
    lines = [np.array(line.get_xydata()) for line in axes.get_lines()]
    assert axes.get_xlabel() == "a1 [rad]"
    assert sorted(line.get_marker() for line in axes.get_lines()) == ["None", "o", "o"]
    for line in lines:
        assert np.nanmax(abs(line)) <= np.pi
        step = np.diff(line, axis=0)
        assert np.nanmax(abs(step), initial=0) < 1
    with pytest.raises(sr.SarrusError, match=r'there is no input "b1". Choose from'):
        found.plot(over="inputs", axes=["a1", "b1"])


@pytest.mark.slow
def test_an_arm_within_limits() -> None:
    """Outputs lose a direction where the elbow is straight, between the limits; its motors never lose control."""
    system, tip = arm([1, 0.7])
    limits = {"q1": (-1.0, 2.0), "q2": (-0.5, 1.5)}
    found = sr.input_singularities(system, tip["x", "y"], ("q1", "q2"), lost="outputs", limits=limits)
    assert found.success
    v = np.concatenate([curve.v for curve in found.curves])
    assert v[:, 1] == pytest.approx(0, abs=1e-9)
    assert (v[:, 0].min(), v[:, 0].max()) == (pytest.approx(-1), pytest.approx(2))
    lines = found.plot(over="inputs").get_lines()
    drawn = {tuple(along) for line in lines for along in (line.get_xdata(), line.get_ydata())}
    assert {(-1.0, -1.0), (2.0, 2.0), (-0.5, -0.5), (1.5, 1.5)} <= drawn
    other = sr.input_singularities(system, tip["x", "y"], ("q1", "q2"), limits=limits)
    assert str(other) == (
        "arm: q1 and q2 lose control on no curve. No curve broke off; random walks crossed none."
    )


def test_table(found: sr.InputSingularities, tmp_path: Path) -> None:
    found.to_csv(tmp_path / "lost.csv")
    with (tmp_path / "lost.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["a2"]) for row in rows] == [v[1] for c in found.curves for v in c.input_line]


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


@pytest.mark.slow
def test_section_of_a_platform() -> None:
    """At a fixed orientation, the legs lose control where their lines meet in a point."""
    system, output, legs = platform_equilateral()
    turn = sr.Rotation(system.model.bodies[0])
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
    [
        (("a1",), {}, "Give as many inputs"),
        (("a1", "a2"), {"fixed": {"b1": 0.0}}, "Fix functions until two"),
        (("a1", "a2"), {"lost": "both"}, "lost: must be 'inputs' or 'outputs'"),
    ],
)
def test_misuse(inputs: tuple[str, ...], options: dict[str, object], told: str) -> None:
    system, output, _ = five_bar()
    with pytest.raises(sr.SarrusError, match=told):
        sr.input_singularities(system, output, inputs, **options)
