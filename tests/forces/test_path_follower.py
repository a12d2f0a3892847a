"""The place along a path: on straight lines and circles in closed form."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

import sarrus as sr
from sarrus.model.laws.path import lengths, spline

Z = (0, 0, 1)


def carried(points, velocity, position, **options):
    """A body that flies straight, and its follower."""
    body = sr.Body("car", mass=1.0, inertia=(1, 1, 1), position=position, velocity=velocity)
    follower = sr.PathFollower("path", "car", points, **options)
    return sr.System(sr.Model("m", [body], forces=[follower], gravity=(0, 0, 0)))


def test_straight_path():
    """The projection onto the line through (1, 2) with the direction (3, 4)/5."""
    of = carried([[1, 2], [4, 6], [7, 10]], (2.0, 1.0, 0.0), (1.0, 2.0, 0.5))
    run = sr.simulate(of, until=3.0)
    apart = np.outer(run.t, [2.0, 1.0])
    assert run["path.progress"] == pytest.approx(apart @ [0.6, 0.8], abs=1e-9)
    assert run["path.deviation"] == pytest.approx(apart @ [-0.8, 0.6], abs=1e-9)
    assert abs(run["path.curvature"]).max() < 1e-12


def test_circle_from_outside():
    """A point that turns at R + d about the centre of a circle to the left is d to its right."""
    R, d = 10.0, 0.5
    angles = np.linspace(-np.pi / 2, np.pi, 201)
    arm = sr.Body("arm", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 0), angular_velocity=(0, 0, 0.5))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=Z)
    follower = sr.PathFollower(
        "path", f"arm(0, {-R - d}, 0)", np.column_stack([R * np.cos(angles), R * np.sin(angles)])
    )
    run = sr.simulate(sr.System(sr.Model("m", [arm], [pin], [follower])), until=6.0)
    chord = 2 * R * np.sin((angles[1] - angles[0]) / 2) / (angles[1] - angles[0])
    inner = slice(100, None)  # behind the first knots, where the path becomes a line
    assert run["path.progress"][inner] == pytest.approx(chord * 0.5 * run.t[inner], rel=1e-6, abs=1e-5)
    assert run["path.deviation"][inner] == pytest.approx(np.full(len(run.t) - 100, -d), abs=1e-6)
    assert run["path.curvature"][inner] == pytest.approx(np.full(len(run.t) - 100, 1 / R), rel=1e-3)


def test_it_returns_to_the_nearest_place():
    """From a wrong place, ġ = -k g: the distance along a straight path decays with exp(-k t)."""
    of = carried([[0, 0], [10, 0]], (1.0, 0.0, 0.0), (0.0, 0.3, 0.0), initial=0.2, return_rate=4.0)
    run = sr.simulate(of, until=1.0)
    assert run["path.progress"] - run.t == pytest.approx(0.2 * np.exp(-4 * run.t), abs=1e-8)


@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_the_path_is_the_spline_of_scipy(count):
    points = np.random.default_rng(count).normal(size=(count, 2))
    u = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    assert lengths(points.tolist()) == pytest.approx(u, rel=1e-14)
    for y in points.T:
        found = spline(u.tolist(), y.tolist())
        straight = [(2, 0.0), (3, 0.0)]
        wanted = make_interp_spline(u, y, 5, bc_type=(straight, straight))
        offset, second = found.offset(), found.second()
        for x in np.linspace(0, u[-1], 50)[:-1]:
            s, c4, c5 = offset(x), found.fourth(x), found.fifth(x)
            assert found.cubic(x) + s**4 * (c4 + s * c5) == pytest.approx(float(wanted(x)), abs=1e-12)
            bend = second(x) + s**2 * (12 * c4 + 20 * s * c5)
            assert bend == pytest.approx(float(wanted(x, 2)), abs=1e-10 * abs(wanted(u, 4)).max() + 1e-10)
        for end, side in ((0.0, -1), (u[-1], 1)):
            assert found.fourth(end + 3 * side) == found.fifth(end + 3 * side) == 0
            assert found.cubic(end + 3 * side) == pytest.approx(
                float(wanted(end) + 3 * side * wanted(end, 1))
            )


def test_gradients_by_points_that_change_the_lengths():
    """Of the place along a bend, whose knots move with the points: differences of runs."""

    def path(x=4.0):
        return carried([[0, 0], [x, 0.5], [7, 2.5], [9, 6]], (2.0, 1.0, 0), (1.0, 0.3, 0))

    names, h = ["path.path.2.1"], 1e-3
    run = sr.simulate(path(), until=2.0, store="steps")
    for output in ("path.progress", "path.deviation", "path.curvature"):
        ends = [sr.simulate(path(4.0 + s), until=2.0)[output][-1] for s in (-h, h)]
        found = sr.sensitivity(run, sr.Final(output), wrt=names)
        assert found.matrix[0, 0] == pytest.approx((ends[1] - ends[0]) / (2 * h), rel=2e-5), output


def test_gradients_by_points_of_the_path():
    """Moving the whole of a path sideways moves the deviation back."""
    of = carried([[0, 0], [5, 0], [10, 0]], (2.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    run = sr.simulate(of, until=2.0, store="steps")
    names = [f"path.path.{n}.2" for n in (1, 2, 3)]
    found = sr.sensitivity(run, sr.Final("path.deviation"), wrt=names)
    assert sum(float(found[name]) for name in names) == pytest.approx(-1.0, rel=1e-9)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ([[0, 0]], "path must be a list of points"),
        ([[0, 0], [0, 0], [1, 0]], "path has the point .* twice"),
        ([[0, 0], [1, np.nan]], "finite"),
        ([[0, 0, 0], [1, 0, 0]], "path"),
    ],
)
def test_what_is_no_path(path, message):
    with pytest.raises(sr.ModelError, match=message):
        carried(path, (1, 0, 0), (0, 0, 0))
