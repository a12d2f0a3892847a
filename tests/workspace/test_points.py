"""Every point of every boundary curve of all mechanisms that are known in closed form, beside the formulas."""

from collections.abc import Callable
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from scipy.optimize import brentq

import sarrus as sr
from sarrus.results.maps.workspace import BoundaryCurve as Curve

from .mechanisms import (
    DEGREE,
    Case,
    about,
    arm,
    arm_2r,
    arm_2r_both_elbows,
    delta,
    elbow_arm,
    gough,
    orthogonal_arm,
    platform_equilateral,
    platform_haug,
    puma,
    tilted,
)

CLOSE = 1e-9  # m, of points from curves
Off = Callable[[Curve], np.ndarray]  # distances of a curve's points from the formula


def active(curve: Curve) -> dict[str, int]:
    """Limits that are reached: name -> 0 at the lowest, 1 at the highest value."""
    return {told.rsplit(" ", 1)[0]: int(told.endswith("highest")) for told in curve.active}


def rings(u: np.ndarray, centres: list[tuple[float, float]], radii: list[float]) -> np.ndarray:
    """Distances from the nearest of some circles."""
    off = [abs(np.linalg.norm(u - c, axis=1) - r) for c, r in zip(centres, radii, strict=True)]
    return np.min(off, axis=0)


def off_2r(case: Case) -> Off:
    """Circles about the shoulder (elbow at a limit or stretched) and about the elbow (shoulder at a limit)."""
    _, _, limits = case
    first, second = limits["q1"], limits["q2"]
    about_elbow = [(np.cos(q), np.sin(q)) for q in first]
    about_shoulder = [np.sqrt(1.49 + 1.4 * np.cos(q)) for q in (*second, 0.0)]
    centres, radii = [*about_elbow, *[(0.0, 0.0)] * 3], [0.7, 0.7, *about_shoulder]
    return lambda curve: rings(curve.u_of_q, centres, radii)


def off_platform(case: Case, fixed: float | None) -> Off:
    """Circles where a leg and its corner are aligned, or the platform does not turn; curves of couplers of two legs."""
    legs = {
        leg.name: (np.array(leg.point_i.coordinates[:2]), np.array(leg.point_j.coordinates[:2]), pair)
        for leg, pair in case[2].items()
    }

    def off(curve: Curve) -> np.ndarray:
        found, u = active(curve), curve.u_of_q
        (first, end), *others = found.items()
        foot, corner, pair = legs[first]
        if fixed is not None:
            c, s = np.cos(fixed), np.sin(fixed)
            centre = foot - np.array([[c, -s], [s, c]]) @ corner
            return abs(np.linalg.norm(u - centre, axis=1) - pair[end])
        if not others:
            radii = [abs(pair[end] + side * np.linalg.norm(corner)) for side in (1, -1)]
            return rings(u, [tuple(foot)] * 2, radii)
        if len(found) == 2 and np.allclose(*(legs[name][1] for name in found)):
            return of_one_corner([(legs[name], end) for name, end in found.items()], u)
        two = [(legs[name], end) for name, end in found.items()]
        return np.min([of_coupler(order, u) for order in permutations(two)], axis=0)

    return off


def of_one_corner(two: list, u: np.ndarray) -> np.ndarray:
    """Two legs hold a corner still; the platform turns about it."""
    (foot, corner, pair), end = two[0]
    (other, _, others), there = two[1]
    r, R, d = pair[end], others[there], np.linalg.norm(other - foot)
    x = (d * d + r * r - R * R) / (2 * d)
    along = (other - foot) / d
    still = [foot + x * along + side * np.sqrt(r * r - x * x) * along[::-1] * (-1, 1) for side in (1, -1)]
    return rings(u, [tuple(at) for at in still], [float(np.linalg.norm(corner))] * 2)


def of_coupler(two: list, u: np.ndarray) -> np.ndarray:
    """The platform is turned so that one leg fits, which must not be aligned; how far the other is from its length."""
    (foot, corner, pair), end = two[0]
    (other, its, others), there = two[1]
    size, d = np.linalg.norm(corner), u - foot
    away = np.linalg.norm(d, axis=1)
    cosine = (pair[end] ** 2 - away**2 - size**2) / (2 * away * size)
    towards = np.arctan2(d[:, 1], d[:, 0]) - np.arctan2(corner[1], corner[0])
    best = []
    for side in (1, -1):
        turn = towards + side * np.arccos(np.clip(cosine, -1, 1))
        x = u[:, 0] + np.cos(turn) * its[0] - np.sin(turn) * its[1] - other[0]
        y = u[:, 1] + np.sin(turn) * its[0] + np.cos(turn) * its[1] - other[1]
        best.append(abs(np.hypot(x, y) - others[there]))
    return np.min(best, axis=0)


def in_space(curve: Curve, height: float) -> np.ndarray:
    return np.column_stack([curve.u_of_q, np.full(len(curve.u_of_q), height)])


def off_gough(case: Case, height: float) -> Off:
    """Spheres about the foot less the corner of the leg that is reached."""
    centres = {leg.name: np.subtract(leg.point_i.coordinates, leg.point_j.coordinates) for leg in case[2]}

    def off(curve: Curve) -> np.ndarray:
        ((leg, end),) = active(curve).items()
        return abs(np.linalg.norm(in_space(curve, height) - centres[leg], axis=1) - (0.95, 1.45)[end])

    return off


def off_delta(height: float) -> Off:
    """An arm at its limit: a sphere about its end. An arm and its rod stretched or folded: a torus with spindles."""

    def off(curve: Curve) -> np.ndarray:
        found, u, best = active(curve), in_space(curve, height), []
        for n in range(3):
            along = np.array([np.cos(2 * np.pi * n / 3), np.sin(2 * np.pi * n / 3), 0.0])
            if found and f"q{n}.angle" not in found:
                continue
            for angle in [(-30 * DEGREE, 90 * DEGREE)[found[f"q{n}.angle"]]] if found else []:
                end = (0.1 + 0.3 * np.cos(angle)) * along - (0, 0, 0.3 * np.sin(angle))
                best.append(abs(np.linalg.norm(u - end, axis=1) - 0.6))
            if not found:
                p, s = u @ along - 0.1, u @ np.cross((0, 0, 1), along)
                rod = np.sqrt(0.36 - s**2)
                best += [abs(np.hypot(p, height) - abs(rod + side * 0.3)) for side in (1, -1)]
        return np.min(best, axis=0)

    return off


def off_rings(radii: list[float]) -> Off:
    """Circles about the first axis."""
    return lambda curve: rings(curve.u_of_q, [(0.0, 0.0)] * len(radii), radii)


def of_orthogonal(height: float) -> list[float]:
    """Distances from the axis on the singular curve at a height: c2 (r2 c3 - d3 s3) = d2 s3."""

    def place(angle: float, side: int) -> tuple[float, float]:
        c3, s3 = np.cos(angle), np.sin(angle)
        c2 = s3 / (c3 - 2 * s3)
        s2 = side * np.sqrt(max(1 - c2 * c2, 0.0))
        reach = 2 + 1.5 * c3
        return float(np.hypot(1 + reach * c2, 1 + 1.5 * s3)), float(-reach * s2)

    found = []
    for low, high in ((np.pi / 4, 3.463343208), (-2.35619449, 0.321750554)):
        grid = np.linspace(low + 1e-6, high - 1e-6, 2001)
        for side in (1, -1):
            gaps = np.array([place(angle, side)[1] - height for angle in grid])
            for k in np.flatnonzero(gaps[1:] * gaps[:-1] < 0):
                angle = brentq(lambda t, s=side: place(t, s)[1] - height, grid[k], grid[k + 1], xtol=1e-15)
                found.append(place(float(angle), side)[0])
    return found


def off_elbow(height: float) -> Off:
    """In the arm's plane, circles about shoulder and elbow; or that plane, with the first hinge at a limit."""
    low, high = 20 * DEGREE, 90 * DEGREE
    shoulders = [np.sqrt(0.45**2 + 0.4**2 + 2 * 0.45 * 0.4 * np.cos(q * DEGREE)) for q in (-120, -10)]
    elbows = [(0.1 + 0.45 * np.cos(q), 0.5 + 0.45 * np.sin(q)) for q in (low, high)]

    def off(curve: Curve) -> np.ndarray:
        x, y = curve.u_of_q.T
        if "q1.angle" in active(curve):
            return np.min([abs(x * np.sin(q) - y * np.cos(q)) for q in (160 * DEGREE, -160 * DEGREE)], axis=0)
        plane = np.column_stack([np.hypot(x, y), np.full(len(x), height)])
        return rings(plane, [(0.1, 0.5)] * 2 + elbows, [*shoulders, 0.4, 0.4])

    return off


def of_puma(height: float) -> list[float]:
    """Distances from the first axis: the arm stretched, the elbow folded, or the wrist above the shoulder's axis."""
    forearm, beside = np.hypot(0.0203, 0.4331), 0.1497
    squares = [(0.4318 + forearm) ** 2 - height**2, (0.4318 - forearm) ** 2 - height**2, 0.0]
    return [float(np.sqrt(beside**2 + square)) for square in squares if square >= 0]


def planar(case: Case, off: Off, turn: float | None = None) -> tuple[Case, dict, Off]:
    fixed = {} if turn is None else {sr.Rotation(case[0].model.bodies[0]): turn}
    return case, fixed, off


def section(case: Case, height: float, off: Off) -> tuple[Case, dict, Off]:
    system, output, limits = case
    return (system, output[:2], limits), {output[2]: height}, off


def tip(made: tuple[sr.System, sr.Point], limits: dict | None = None) -> Case:
    return made[0], made[1]["x", "y", "z"], limits or {}


def cases() -> dict[str, Callable[[], tuple[Case, dict, Off]]]:
    """By name."""
    arms = {f"q{n}": (-30 * DEGREE, 90 * DEGREE) for n in range(3)}
    found: dict[str, Callable[[], tuple[Case, dict, Off]]] = {
        "2R": lambda: planar(arm_2r(), off_2r(arm_2r())),
        "2R, both elbows": lambda: planar(arm_2r_both_elbows(), off_2r(arm_2r_both_elbows())),
        "3R without limits": lambda: planar(free_arm(), off_rings([7.0, 1.0, 3.0, 5.0])),
        "3-RPR": lambda: planar(platform_haug(), off_platform(platform_haug(), None)),
        "3-RPR, equilateral": lambda: planar(
            platform_equilateral(), off_platform(platform_equilateral(), None)
        ),
        "delta": lambda: section(tip(delta()), -0.6, off_delta(-0.6)),
        "delta with limits": lambda: section(tip(delta(), arms), -0.6, off_delta(-0.6)),
        "orthogonal 3R": lambda: section(tip(orthogonal_arm()), 0.6, off_rings(of_orthogonal(0.6))),
        "elbow arm": lambda: section(elbow_arm(), 0.6, off_elbow(0.6)),
        "PUMA": lambda: section(puma(), 0.3, off_rings(of_puma(0.3))),
        "PUMA in its void": lambda: section(puma(), 0.001, off_rings(of_puma(0.001))),
    }
    for degrees in (0, 30, -60):
        found[f"3-RPR at {degrees}°"] = lambda turn=degrees * DEGREE: planar(
            platform_equilateral(), off_platform(platform_equilateral(), turn), turn
        )
    orientations = ("", np.eye(3), 1.0), (", tilted", tilted(), 1.0), (", turned", about(2, 30), 0.95)
    for name, turned, height in orientations:
        found[f"Gough{name}"] = lambda t=turned, z=height: section(gough(t), z, off_gough(gough(t), z))
    return found


def free_arm() -> Case:
    system, end = arm([4, 2, 1])
    return system, end["x", "y"], {}


CASES = cases()


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_points_of_the_boundary(name: str) -> None:
    (system, output, limits), fixed, off = CASES[name]()
    found = sr.workspace(system, output, limits=limits, fixed=fixed, verify=False)
    assert found.success, found.message
    assert max(off(curve).max() for curve in found.boundary) < CLOSE


def test_the_formulas_can_fail() -> None:
    """Moved by 2e-9 m, every boundary is seen to be wrong."""
    (system, output, limits), fixed, off = CASES["2R"]()
    found = sr.workspace(system, output, limits=limits, fixed=fixed, verify=False)
    moved = [replace(curve, u_of_q=curve.u_of_q + 2e-9) for curve in found.boundary]
    assert max(off(curve).max() for curve in moved) > CLOSE


def test_area_of_an_arm_without_limits() -> None:
    found = sr.workspace(*free_arm()[:2], verify=False)
    assert found.area == pytest.approx(48 * np.pi, rel=3e-7)
    assert len(found.components) == 1
