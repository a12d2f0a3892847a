"""Which places a map contains, as exactly as its curves are traced, beside forward kinematics and circles."""

import numpy as np
import pytest

import sarrus as sr
from sarrus.results.maps.workspace import finely, inside

from .mechanisms import arm_3r, five_bar

LENGTHS, END = np.array([4.0, 2.0, 1.0]), np.pi / 3


@pytest.fixture(scope="module")
def arm() -> sr.Workspace:
    system, output, limits = arm_3r()
    return sr.workspace(system, output, limits=limits, verify=False)


def tips(q: np.ndarray) -> np.ndarray:
    """Forward kinematics of the arm (k, 3) -> (k, 2)."""
    angles = np.cumsum(q, axis=1)
    return np.stack([np.cos(angles) @ LENGTHS, np.sin(angles) @ LENGTHS], axis=1)


@pytest.mark.slow
def test_no_reachable_place_is_outside(arm: sr.Workspace) -> None:
    """Random joint angles, with one, two or all of them at their limits, and stretched: on the boundary itself."""
    random = np.random.default_rng(0)
    q = random.uniform(-END, END, (100_000, 3))
    assert arm.contains(tips(q)).all()
    at_ends = np.where(random.random(q.shape) < 0.5, np.sign(q) * END, q)
    assert arm.contains(tips(at_ends)).all()
    stretched = q * [1, 0, 0]
    assert arm.contains(tips(stretched)).all()


def test_places_beyond_the_boundary_are_outside(arm: sr.Workspace) -> None:
    """A millionth of the reach beyond arcs of radius 7, and within those of radius 27^0.5, whose inner side is free."""
    angles = np.linspace(-END, END, 997)
    arc = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    assert not arm.contains(arc * 7 * (1 + 1e-6)).any()
    inner = np.linspace(-0.9, 0.9, 997)
    arc = np.stack([np.cos(inner), np.sin(inner)], axis=1) * 27**0.5
    assert not arm.contains(arc * (1 - 1e-6)).any()
    assert arm.contains(arc * (1 + 1e-6)).all()


@pytest.mark.slow
def test_both_sides_of_voids() -> None:
    """Holes are as exact as the outer boundary."""
    system, output, _ = five_bar()
    found = sr.workspace(system, output, verify=False)
    angles = np.linspace(0, 2 * np.pi, 1009)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for foot in (-1, 1):
        assert not found.contains(circle * 0.3 * (1 - 1e-5) + [foot, 0]).any()
        assert found.contains(circle * 0.3 * (1 + 1e-5) + [foot, 0]).all()


def test_few_pieces_of_a_circle() -> None:
    """Four quintic pieces: their polyline is 5e-3 off, the curve 1e-5."""
    pieces = []
    for k in range(4):
        tau = np.linspace(0, 1, 6)
        angle = (k + tau) * np.pi / 2
        pieces.append(
            np.linalg.solve(tau[:, None] ** np.arange(6), np.stack([np.cos(angle), np.sin(angle)], 1))
        )
    curve = np.array(pieces)
    points = np.random.default_rng(1).uniform(-1.1, 1.1, (20_000, 2))
    radius = np.hypot(*points.T)
    clear = abs(radius - 1) > 2e-5
    assert np.count_nonzero(abs(radius - 1) < 2e-3) > 30
    found = inside([finely(curve, 1e-8)], points)
    assert np.array_equal(found[clear], radius[clear] < 1)


def test_what_is_no_place_is_refused(arm: sr.Workspace) -> None:
    for points in ([1, 2, 3], [[np.nan, 0]], "somewhere", [[[1, 2]]]):
        with pytest.raises(sr.SarrusError, match="points: an array of pairs"):
            arm.contains(points)
    assert arm.contains([]).shape == (0,)
