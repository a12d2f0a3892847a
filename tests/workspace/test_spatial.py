"""Spatial mechanisms: ranges of one output, sections of three."""

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms

from .mechanisms import arm_3r, delta, elbow_arm, gough, orthogonal_arm, tilted


def test_range_of_the_spatial_slider_crank() -> None:
    """Between the dead centres, found as roots of the crank's closure by an independent code."""
    found = sr.workspace_range(sr.System(sr.load(mechanisms.path("slider_crank"))), "slider.x")
    assert found.success
    assert found.intervals == (pytest.approx((3.652827090146428, 4.965566860842011), abs=1e-12),)
    assert {one.cause for one in found.critical} == {"singularity"}
    assert "slider.x can be from 3.65282709 to 4.96556686 m" in str(found)


@pytest.mark.slow
def test_range_of_a_limited_arm() -> None:
    system, output, limits = arm_3r()
    found = sr.workspace_range(system, output[1], limits=limits)
    low, high = found.intervals[0]
    assert len(found.intervals) == 1
    assert low == pytest.approx(-high, abs=1e-12)
    assert high == pytest.approx(4 * np.sin(np.pi / 3) + 3, abs=1e-12)  # shoulder up, elbow and wrist upright


def test_a_slice_of_a_gough_platform() -> None:
    system, output, limits = gough()
    found = sr.workspace(system, output[:2], limits=limits, fixed={output[2]: 0.9}, verify=False)
    assert found.area == pytest.approx(0.532204528, rel=5e-7)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("height", "seed", "area"),
    [(0.97570841, 0, 0.242828738931), (0.78846361, 1, 0.009155363388), (0.89407216, 1, 0.114128138528)],
)
def test_a_limit_that_is_passed_for_a_moment(height: float, seed: int, area: float) -> None:
    """Curves are cut where they leave the workspace and come back within one step: areas from circles by hand."""
    system, output, limits = gough(tilted())
    held = {output[2]: height}
    found = sr.workspace(system, output[:2], limits=limits, fixed=held, verify=False, seed=seed)
    assert found.success, found.message
    assert found.area == pytest.approx(area, abs=1e-7)


@pytest.mark.slow
def test_a_section_of_an_orthogonal_arm() -> None:
    """Across its first axis: circles with the stationary distances from the axis, two of them barriers inside."""
    system, tip = orthogonal_arm()
    x, y, z = tip["x", "y", "z"]
    found = sr.workspace(system, (x, y), fixed={z: 0.6}, verify=False)
    assert found.success, found.message
    radii = {kind: [] for kind in ("outer", "void", "barrier")}
    for curve in found.curves:
        rho = np.linalg.norm(curve.u_of_q, axis=1)
        assert np.ptp(rho) < 1e-9
        if not any(abs(rho[0] - other) < 1e-6 for other in radii[curve.kind]):
            radii[curve.kind].append(rho[0])
    theta = np.linspace(-np.pi, np.pi, 400_001)
    arm = 2 + 1.5 * np.cos(theta)
    ok = arm >= 0.6
    stationary: list[float] = []
    for side in (1, -1):
        out = 1 + side * np.sqrt(np.maximum(arm[ok] ** 2 - 0.36, 0.0))
        rho = np.hypot(out, 1 + 1.5 * np.sin(theta[ok]))
        change = np.diff(rho)
        stationary += rho[np.flatnonzero(change[1:] * change[:-1] < 0) + 1].tolist()
    mine = sorted(r for some in radii.values() for r in some)
    assert mine == pytest.approx(sorted(stationary), abs=1e-8)
    (outer,), void = radii["outer"], radii["void"]
    assert found.area == pytest.approx(np.pi * (outer**2 - sum(r**2 for r in void)), rel=3e-7)


def test_a_section_through_the_first_axis() -> None:
    """The first hinge is held, so that the arm keeps to a plane with its axis; the area is known in closed form."""
    system, (x, _, z), limits = elbow_arm()
    found = sr.workspace(system, (x, z), limits=limits, fixed={"q1": 0.0}, verify=False)
    assert found.success, found.message
    assert found.area == pytest.approx(0.326526279020, rel=3e-7)


def test_a_section_with_two_ways_of_assembly() -> None:
    """In the plane of its second axis the arm is stretched to either side; no motion in this plane joins the two."""
    system, tip = orthogonal_arm()
    x, y, z = tip["x", "y", "z"]
    found = sr.workspace(system, (x, y), fixed={z: 0.0}, verify=False)
    theta = np.linspace(-np.pi, np.pi, 400_001)
    rho = np.array(
        [np.hypot(1 + side * (2 + 1.5 * np.cos(theta)), 1 + 1.5 * np.sin(theta)) for side in (1, -1)]
    )
    assert found.area == pytest.approx(np.pi * (rho.max() ** 2 - rho.min() ** 2), rel=3e-7)


@pytest.mark.slow
@pytest.mark.parametrize(("height", "area"), [(-0.45, 1.109989587), (-0.75, 0.471025881)])
def test_sections_of_a_delta_robot(height: float, area: float) -> None:
    system, tip = delta()
    x, y, z = tip["x", "y", "z"]
    found = sr.workspace(system, (x, y), fixed={z: height}, verify=False)
    assert found.success, found.message
    assert found.area == pytest.approx(area, rel=5e-7)


def test_points_of_a_gough_platform_lie_on_spheres() -> None:
    """Every point of every curve of a slice, about the foot less the corner of a leg that is reached."""
    system, output, limits = gough()
    found = sr.workspace(system, output[:2], limits=limits, fixed={output[2]: 1.1}, verify=False)
    centres = {leg.name: np.subtract(leg.point_i.coordinates, leg.point_j.coordinates) for leg in limits}
    for curve in found.curves:
        u = np.column_stack([curve.u_of_q, np.full(len(curve.u_of_q), 1.1)])
        for active in curve.active:
            leg, end = active.rsplit(" ", 1)
            radius = {"lowest": 0.95, "highest": 1.45}[end]
            assert np.linalg.norm(u - centres[leg], axis=1) == pytest.approx(radius, abs=1e-9)


@pytest.mark.slow
def test_points_of_a_delta_robot_lie_on_tori() -> None:
    """Where the boundary is, an arm and its rod are stretched or folded: the arm's plane meets two spheres."""
    system, tip = delta()
    x, y, z = tip["x", "y", "z"]
    found = sr.workspace(system, (x, y), fixed={z: -0.45}, verify=False)
    assert found.boundary
    for curve in found.boundary:
        off = []
        for angle in (0, 2 * np.pi / 3, 4 * np.pi / 3):
            along, across = (
                np.array([np.cos(angle), np.sin(angle)]),
                np.array([-np.sin(angle), np.cos(angle)]),
            )
            p, s = curve.u_of_q @ along - 0.1, curve.u_of_q @ across
            in_plane = np.hypot(p, 0.45)  # of the shoulder; the rod reaches the plane in a circle
            rod = np.sqrt(0.36 - s**2)
            off.append(np.min([abs(in_plane - abs(rod + side * 0.3)) for side in (1, -1)], axis=0).max())
        assert min(off) < 1e-9
