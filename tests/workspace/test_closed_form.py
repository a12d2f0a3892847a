"""Workspaces that are known in closed form: areas, perimeters, parts, every point of every curve."""

import json
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

from .mechanisms import (
    DEGREE,
    Case,
    arm_2r,
    arm_2r_both_elbows,
    arm_3r,
    five_bar,
    platform_equilateral,
    platform_haug,
)

REFERENCE = Path(__file__).parent.parent / "reference" / "workspace"
A1, A2 = (-1.0, 0.0), (1.0, 0.0)
LENS = 11.788984798867766
CASES = {  # area, perimeter where it is known exactly
    "arm_2r": (arm_2r, 3.970981336311, 10.093743790582),
    "arm_2r_both_elbows": (arm_2r_both_elbows, 4.338201405864, 12.399393690749),
    "arm_3r": (arm_3r, 31.497510350119, 39.362540404433),
    "five_bar": (five_bar, LENS, 16.63690819031),
    "platform_haug": (platform_haug, 4.160783189, None),
    "platform_equilateral": (platform_equilateral, 2.986132374, None),
}


def mapped(case: Case, **options: object) -> sr.Workspace:
    system, output, limits = case
    return sr.workspace(system, output, limits=limits, verify=False, **options)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", CASES)
def test_areas(name: str) -> None:
    case, area, perimeter = CASES[name]
    found = mapped(case())
    assert found.success, found.message
    assert found.area == pytest.approx(area, rel=3e-7)
    assert abs(found.area - area) < 3 * found.area_error
    assert perimeter is None or found.perimeter == pytest.approx(perimeter, rel=3e-7)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("degrees", "area", "perimeter"),
    [
        (0, 1.405663308789, 7.335695409705),
        (30, 1.626396967826, 6.271643932680),
        (-60, 1.669048533929, 4.822736168057),
    ],
)
def test_a_platform_that_does_not_turn(degrees: float, area: float, perimeter: float) -> None:
    """Three annuli meet."""
    system, output, limits = platform_equilateral()
    turn = {sr.Rotation(system.model.bodies[0]): degrees * DEGREE}
    found = sr.workspace(system, output, limits=limits, fixed=turn, verify=False)
    assert found.success, found.message
    assert (found.area, found.perimeter) == pytest.approx((area, perimeter), rel=3e-7)


@pytest.mark.slow
def test_an_area_converges_with_shorter_steps() -> None:
    found = mapped(arm_3r(), longest=0.12)
    assert found.area == pytest.approx(CASES["arm_3r"][1], rel=2e-9)


def test_parts_that_do_not_hang_together() -> None:
    parts = [part.area for part in mapped(platform_haug()).components]
    assert parts == pytest.approx([1.152898365, 1.152898365, 0.927493230, 0.927493230], rel=3e-7)


@pytest.mark.slow
def test_points_of_a_five_bar_lie_on_circles() -> None:
    found = mapped(five_bar())
    assert {curve.kind for curve in found.curves} == {"outer", "void"}
    for curve in found.curves:
        radii = [1.5 + 1.2] if curve.kind == "outer" else [1.5 - 1.2]
        off = [
            abs(np.linalg.norm(curve.u_of_q - centre, axis=1) - r).max() for centre in (A1, A2) for r in radii
        ]
        assert min(off) < 1e-9


def rows() -> list[dict[str, object]]:
    """Arcs of the 3R arm, with what each of their pieces is."""
    return list(json.loads((REFERENCE / "arm_3R_barriers.json").read_text())["rows"])


@pytest.fixture(scope="module")
def arm() -> sr.Workspace:
    return mapped(arm_3r())


def test_points_of_a_3r_arm_lie_on_its_19_arcs(arm: sr.Workspace) -> None:
    arcs = [(np.array(row["centre"]), row["r"]) for row in rows()]
    for curve in arm.curves:
        off = [abs(np.linalg.norm(curve.u_of_q - centre, axis=1) - r).max() for centre, r in arcs]
        assert min(off) < 1e-9


def test_every_arc_of_a_3r_arm_is_found_and_classified(arm: sr.Workspace) -> None:
    """Barriers with their open side, and arcs that can be crossed, against second-order terms worked out by hand."""
    for row in rows():
        centre, r = np.array(row["centre"]), row["r"]
        active = active_of(row["q_deg"])
        for piece in row["pieces"]:
            middle = np.mean(piece["arc_angle_deg"]) * np.pi / 180
            at = centre + r * np.array([np.cos(middle), np.sin(middle)])
            assert_piece(arm, at, (at - centre) / r, active, piece["type"])


def active_of(q: list[float | None]) -> set[str]:
    """Joints at an end of their range; others are free or aligned."""
    at_end = [(n, x) for n, x in enumerate(q, start=1) if x is not None and abs(abs(x) - 60) < 1e-9]
    return {f"q{n}.angle {'lowest' if x < 0 else 'highest'}" for n, x in at_end}


def assert_piece(arm: sr.Workspace, at: np.ndarray, outward: np.ndarray, active: set[str], kind: str) -> None:
    mine = [curve for curve in arm.curves if set(curve.active) == active]
    curve = min(mine, key=lambda one: float(np.linalg.norm(one.u - at, axis=1).min()))
    k = int(np.argmin(np.linalg.norm(curve.u - at, axis=1)))
    assert np.linalg.norm(curve.u[k] - at) < 0.1
    if kind == "crossable":
        assert curve.kind == "crossable"
    else:
        assert curve.kind in ("outer", "barrier")
        assert (curve.inward[k] @ outward > 0) == (kind == "barrier:r>=")


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_limits_with_one_end() -> None:
    """The tip of an arm is kept within 1.5 m of its pivot, without a limit below: a ring."""
    system, output, _ = arm_2r()
    tip = system.model.bodies[-1].point(0.7, 0, 0)
    limits = {sr.Length(sr.ground.point(0, 0, 0), tip, "rope"): (None, 1.5)}
    found = sr.workspace(system, output, limits=limits, verify=False)
    assert found.success
    assert found.area == pytest.approx(np.pi * (1.5**2 - 0.3**2), rel=1e-6)
