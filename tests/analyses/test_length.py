"""The size of a system, against the rotation matrix of each body."""

import numpy as np

import sarrus as sr
from sarrus.analyses.equations.length import extent, unit_displacement


def rotation(p: np.ndarray) -> np.ndarray:
    """The rotation matrix, I + 2 (e0 ẽ + ẽ ẽ)."""
    e0, (x, y, z) = p[0], p[1:]
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * (e0 * skew + skew @ skew)


def test_the_extent_is_that_of_all_points() -> None:
    ball = sr.Body("ball", mass=1.0, inertia=[1, 1, 1])
    spring = sr.TSDA("spring", sr.ground.point(0, -3, 0), ball.point(0, 0, 2), k=1.0, length=1.0)
    system = sr.System(sr.Model("model", bodies=[ball], forces=[spring]))
    q = np.array([0.1, 0.2, 0.3, *np.array([0.9, 0.3, -0.2, 0.1]) / np.sqrt(0.95)])
    points = np.array([q[:3], [0.0, -3.0, 0.0]])  # with the end of the spring as the only lever arm
    squares = ((points - points.mean(axis=0)) ** 2).sum() + 2.0**2
    assert np.isclose(unit_displacement(system, q), 2 * np.sqrt(squares / 3), rtol=1e-14)
    disc = sr.RollingDisc(
        "disc", center=ball.point(0, 0, 2), plane=sr.ground.frame((0, 0, 0)), radius=1.0, axis=(0, 1, 0)
    )
    rolling = sr.System(sr.Model("model", bodies=[ball], joints=[disc]))
    points[1] = 0.0  # of the plane; the disc is two elements with a center and a radius each
    squares = ((points - points.mean(axis=0)) ** 2).sum() + 2 * (2.0**2 + 1.0**2)
    assert np.isclose(unit_displacement(rolling, q), 2 * np.sqrt(squares / 6), rtol=1e-14)
    ends = np.array([q[:3], [0.0, -3.0, 0.0], q[:3] + rotation(q[3:]) @ [0.0, 0.0, 2.0]])
    assert np.isclose(extent(system, q), np.ptp(ends, axis=0).max(), rtol=1e-14)
