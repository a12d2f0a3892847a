"""Spatial mechanisms: ranges of one output, slices and volumes of three."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms

from .mechanisms import DEGREE, Limits, arm_3r, delta, orthogonal_arm


def test_range_of_the_spatial_slider_crank() -> None:
    """Between the dead centres, found as roots of the crank's closure by an independent code."""
    found = sr.workspace_range(sr.System(sr.load(mechanisms.path("slider_crank"))), "slider.x")
    assert found.success
    assert found.intervals == (pytest.approx((3.652827090146428, 4.965566860842011), abs=1e-12),)
    assert {one.cause for one in found.critical} == {"singularity"}
    assert "slider.x can be from 3.65282709 to 4.96556686 m" in str(found)


def test_range_of_a_limited_arm() -> None:
    system, output, limits = arm_3r()
    found = sr.workspace_range(system, output[1], limits=limits)
    low, high = found.intervals[0]
    assert len(found.intervals) == 1
    assert low == pytest.approx(-high, abs=1e-12)
    assert high == pytest.approx(4 * np.sin(np.pi / 3) + 3, abs=1e-12)  # shoulder up, elbow and wrist upright


def translated(
    legs: dict[tuple[tuple[float, ...], tuple[float, ...]], tuple[float, float]],
) -> tuple[object, ...]:
    """A body that is moved without turning by three slides, with limited lengths to points of the ground."""
    x, y = (sr.Body(name, mass=1, inertia=(1, 1, 1)) for name in "xy")
    tool = sr.Body("tool", mass=1, inertia=(1, 1, 1), position=(0, 0, 1))
    joints = [
        sr.Translational("slide_x", sr.ground, x, point=(0, 0, 0), axis=(1, 0, 0)),
        sr.Translational("slide_y", x, y, point=(0, 0, 0), axis=(0, 1, 0)),
        sr.Translational("slide_z", y, tool, point=(0, 0, 0), axis=(0, 0, 1)),
    ]
    limits: Limits = {
        sr.Length(sr.ground.point(*foot), tool.point(*corner), f"leg {n}"): pair
        for n, ((foot, corner), pair) in enumerate(legs.items(), start=1)
    }
    system = sr.System(sr.Model("translated", bodies=[x, y, tool], joints=joints))
    return system, tool.point(0, 0, 0)["x", "y", "z"], limits


def shell() -> tuple[object, ...]:
    return translated({((0, 0, 0), (0, 0, 0)): (0.5, 1.0)})


def test_volume_of_a_shell(tmp_path: Path) -> None:
    """Slices are annuli and discs; half of the slices tell the error."""
    system, output, limits = shell()
    found = sr.workspace_volume(system, output, limits=limits, slices=16)
    exact = 4 / 3 * np.pi * (1 - 0.125)
    assert found.success
    assert found.ranges == (pytest.approx((-1.0, 1.0)),)
    assert abs(found.volume - exact) < 2 * found.volume_error < 0.02 * exact
    for one in found.slices:
        area = np.pi * (1 - one.height**2 - max(0.25 - one.height**2, 0))
        assert one.area == pytest.approx(area, rel=1e-6)
    assert found.enclosed() == pytest.approx(exact, rel=0.05)
    found.to_obj(tmp_path / "shell.obj")
    assert (tmp_path / "shell.obj").read_text().count("\nv ") == len(found.vertices)
    assert "volume" in str(found)
    assert len(found.plot().collections) == 1


def test_slices_run_on_an_executor() -> None:
    system, output, limits = shell()
    with ThreadPoolExecutor(2) as pool:
        there = sr.workspace_volume(system, output, limits=limits, slices=8, executor=pool)
    here = sr.workspace_volume(system, output, limits=limits, slices=8)
    assert there.volume == pytest.approx(here.volume, rel=1e-6)


@pytest.mark.parametrize(
    ("output", "slices", "told"),
    [(("tool.x", "tool.y"), 8, "of three outputs"), (("tool.x",) * 3, 7, "even number")],
)
def test_misuse(output: tuple[str, ...], slices: int, told: str) -> None:
    system, _, limits = shell()
    with pytest.raises(sr.SarrusError, match=told):
        sr.workspace_volume(system, output, limits=limits, slices=slices)


def gough() -> tuple[object, ...]:
    """A platform on six legs with a fixed orientation."""
    feet = [(np.cos(a * DEGREE), np.sin(a * DEGREE), 0.0) for a in (10, 110, 130, 230, 250, 350)]
    corners = [
        (0.6 * np.cos(a * DEGREE), 0.6 * np.sin(a * DEGREE), 0.0) for a in (50, 70, 170, 190, 290, 310)
    ]
    return translated(dict.fromkeys(zip(feet, corners, strict=True), (0.95, 1.45)))


def test_a_slice_of_a_gough_platform() -> None:
    system, output, limits = gough()
    found = sr.workspace(system, output[:2], limits=limits, fixed={output[2]: 0.9}, verify=False)
    assert found.area == pytest.approx(0.532204528, rel=5e-7)


@pytest.mark.slow
def test_volume_of_a_gough_platform() -> None:
    system, output, limits = gough()
    found = sr.workspace_volume(system, output, limits=limits, between=(0, 2), slices=40)
    assert found.success
    assert found.ranges == (pytest.approx((0.679524344, 1.289090117), abs=1e-8),)
    assert found.volume == pytest.approx(0.14492075, rel=2e-3)
    assert abs(found.volume - 0.14492075) < 2 * found.volume_error


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


@pytest.mark.parametrize(("height", "area"), [(-0.45, 1.109989587), (-0.75, 0.471025881)])
def test_sections_of_a_delta_robot(height: float, area: float) -> None:
    system, tip = delta()
    x, y, z = tip["x", "y", "z"]
    found = sr.workspace(system, (x, y), fixed={z: height}, verify=False)
    assert found.success, found.message
    assert found.area == pytest.approx(area, rel=5e-7)
