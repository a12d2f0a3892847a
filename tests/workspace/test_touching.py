"""Curves that touch: the void of a symmetric five-bar beside its outer boundary, in closed form."""

from math import acos, atan2, cos, pi, sin, sqrt

import numpy as np
import pytest
from benchmarks.workspace_attack import five_bars

import sarrus as sr
from sarrus.analyses.workspace.regions.arc import Arc

CRANK, ROD = 1.0, 1.5


def five_bar(half: float, angle: float = 1.3) -> tuple[sr.System, tuple[object, ...]]:
    """Two equal cranks at ±half, two equal rods."""
    feet = [np.array([-half, 0.0]), np.array([half, 0.0])]
    elbows = [
        foot + CRANK * np.array([side * cos(angle), sin(angle)])
        for foot, side in zip(feet, (1, -1), strict=True)
    ]
    tip = np.array([0.0, elbows[0][1] + sqrt(ROD**2 - elbows[0][0] ** 2)])
    ends = [*zip(feet, elbows, strict=True), *((elbow, tip) for elbow in elbows)]
    bars = [bar(f"bar_{n}", *pair) for n, pair in enumerate(ends)]
    hinges = [
        ("a0", sr.ground, bars[0], feet[0]),
        ("a1", sr.ground, bars[1], feet[1]),
        ("b0", bars[0], bars[2], elbows[0]),
        ("b1", bars[1], bars[3], elbows[1]),
        ("p", bars[2], bars[3], tip),
    ]
    joints = [sr.Revolute(name, i, j, point=(*at, 0), axis=(0, 0, 1)) for name, i, j, at in hinges]
    return sr.System(sr.Model("five-bar", bodies=bars, joints=joints)), bars[2].point(ROD, 0, 0)["x", "y"]


def bar(name: str, a: np.ndarray, b: np.ndarray) -> sr.Body:
    turn = sr.AxisAngle((0, 0, 1), atan2(b[1] - a[1], b[0] - a[0]))
    return sr.Body(name, mass=1, inertia=(1, 1, 1), position=(*a, 0), orientation=turn)


def common(r: float, R: float, d: float) -> float:
    """The area that two discs have in common."""
    if d >= r + R:
        return 0.0
    if d <= abs(R - r):
        return pi * min(r, R) ** 2
    a, b = (d * d + r * r - R * R) / (2 * d * r), (d * d + R * R - r * r) / (2 * d * R)
    kite = 0.5 * sqrt((-d + r + R) * (d + r - R) * (d - r + R) * (d + r + R))
    return r * r * acos(a) + R * R * acos(b) - kite


def exact(half: float) -> float:
    """Two discs of the stretched legs in common, less the discs around the feet that folded legs cannot reach."""
    far, near = CRANK + ROD, ROD - CRANK
    return common(far, far, 2 * half) - 2 * common(near, far, 2 * half)


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    ("off", "seed"), [(0.0, 0), (0.0, 1), (0.0, 2), (1e-9, 0), (-1e-9, 0), (1e-6, 0), (-1e-6, 0), (1e-4, 0)]
)
def test_voids_that_touch_the_outer_boundary(off: float, seed: int) -> None:
    """With the right area, also where there are some 1e-6 between them."""
    system, output = five_bar(1 + off)
    found = sr.workspace(system, output, seed=seed, verify=False)
    assert found.success, found.message
    assert found.area == pytest.approx(exact(1 + off), rel=1e-7)
    assert abs(found.area - exact(1 + off)) <= found.area_error + 2e-9


def test_a_box_holds_the_curve_and_not_only_its_polyline() -> None:
    """A curve that began on the bulge of another one between two points of its polyline did not cut it."""
    random = np.random.default_rng(0)
    for _ in range(50):
        arc = Arc(random.normal(size=(1, 6, 2)))
        points = np.array([arc.point(at) for at in np.linspace(0, 1, 500)])
        assert np.all(points >= arc.box[0] - 1e-12)
        assert np.all(points <= arc.box[1] + 1e-12)


def lens(a: float, b: float, apart: float) -> float:
    """Area common to two circles."""
    if apart <= abs(a - b):
        return pi * min(a, b) ** 2
    x, y = ((apart**2 + one**2 - other**2) / (2 * apart) for one, other in ((a, b), (b, a)))
    return float(a**2 * acos(x / a) + b**2 * acos(y / b) - apart * sqrt(a**2 - x**2))


def test_a_boundary_that_is_traced_twice() -> None:
    """One of its two curves begins where the other one is farthest to the left."""
    (system, output, limits), _ = five_bars(np.random.default_rng([2, 9]))
    found = sr.workspace(system, output, limits=limits, verify=False)
    cranks, rods, apart = (1.0170263, 1.8502904), (1.4359471, 0.5800070), 0.7997784
    far, near = ([abs(c + sign * r) for c, r in zip(cranks, rods, strict=True)] for sign in (1, -1))
    exact = (
        lens(*far, apart) - lens(near[0], far[1], apart) - lens(far[0], near[1], apart) + lens(*near, apart)
    )
    assert found.success
    assert found.area == pytest.approx(exact, rel=1e-6)
