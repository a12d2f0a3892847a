"""Surfaces through grids: against SciPy and polynomials, in files, and what is none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import RectBivariateSpline

import sarrus as sr
from sarrus._jit.formulas.surfaces import surface_value

RANDOM = np.random.default_rng(3)
X, Y = np.cumsum(RANDOM.uniform(0.4, 1.6, 9)), np.cumsum(RANDOM.uniform(0.4, 1.6, 7))
HEIGHTS = RANDOM.normal(size=(9, 7))
ORDERS = [(i, n - i) for n in range(4) for i in range(n + 1)]


def places(count: int = 200) -> tuple[Any, Any]:
    return RANDOM.uniform(X[0], X[-1], count), RANDOM.uniform(Y[0], Y[-1], count)


def stored(surface: sr.Surface, x: Any, y: Any, i: int, j: int) -> Any:
    """The formula of kernels in plain Python."""
    numbers = surface.numbers()
    return np.array([surface_value(numbers, 0, *at, i, j) for at in zip(x, y, strict=True)])


@pytest.mark.parametrize("orders", [one for one in ORDERS if max(one) < 3])
def test_against_the_spline_of_scipy(orders: tuple[int, int]) -> None:
    """FITPACK interpolates by B-splines without the second and the last but one knot: the same not-a-knot spline."""
    surface, (x, y) = sr.Surface(X, Y, HEIGHTS), places()
    expected = RectBivariateSpline(X, Y, HEIGHTS, s=0)(x, y, *orders, grid=False)
    assert surface.derivative(x, y, *orders) == pytest.approx(expected, abs=1e-12)
    assert stored(surface, x, y, *orders) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("orders", ORDERS)
def test_a_cubic_polynomial_is_exact(orders: tuple[int, int]) -> None:
    """A product of cubics is the spline through its own points, with all derivatives of kernels."""
    in_x, in_y = np.polynomial.Polynomial([1, -2, 0.5, 0.25]), np.polynomial.Polynomial([0.3, 1, -1, 0.5])
    surface, (x, y) = sr.Surface(X, Y, np.outer(in_x(X), in_y(Y))), places()
    expected = in_x.deriv(orders[0])(x) * in_y.deriv(orders[1])(y)
    assert surface.derivative(x, y, *orders) == pytest.approx(expected, rel=1e-10, abs=1e-9)
    assert stored(surface, x, y, *orders) == pytest.approx(expected, rel=1e-10, abs=1e-9)


def test_derivatives_by_complex_step() -> None:
    numbers, step = sr.Surface(X, Y, HEIGHTS).numbers(), 1e-30
    for x, y in zip(*(values - 2 for values in places(30)), strict=True):  # some beyond the grid
        for i, j in [one for one in ORDERS if sum(one) < 3]:
            by_x = surface_value(numbers, 0, complex(x, step), y, i, j).imag / step
            by_y = surface_value(numbers, 0, x, complex(y, step), i, j).imag / step
            assert surface_value(numbers, 0, x, y, i + 1, j) == pytest.approx(by_x, rel=1e-12, abs=1e-12)
            assert surface_value(numbers, 0, x, y, i, j + 1) == pytest.approx(by_y, rel=1e-12, abs=1e-12)


def test_beyond_the_grid_it_is_continued_by_its_tangents() -> None:
    surface = sr.Surface(X, Y, HEIGHTS)
    y, beyond = places(20)[1], np.array([0.0, 0.5, 40.0])
    for at, x in ((X[0], X[0] - beyond), (X[-1], X[-1] + beyond)):
        for one in x:
            expected = surface.height(at, y) + (one - at) * surface.derivative(at, y, 1, 0)
            for heights in (surface.height(one, y), stored(surface, [one] * 20, y, 0, 0)):
                assert heights == pytest.approx(expected, rel=1e-12, abs=1e-12)
    corner = [surface.derivative(X[-1], Y[0], *n) for n in ((0, 0), (1, 0), (0, 1), (1, 1))]
    assert surface.height(X[-1] + 2, Y[0] - 3) == pytest.approx(np.dot([1, 2, -3, -6], corner), rel=1e-12)
    assert (
        stored(surface, [X[-1] + 2], [Y[0] - 3], 2, 0) == stored(surface, [X[-1] + 2], [Y[0] - 3], 1, 2) == 0
    )


@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_with_equal_rows_it_is_the_curve_through_one(count: int) -> None:
    """Also beyond the ends, with natural and with not-a-knot splines."""
    curve = sr.Curve.table(zip(X[:count], HEIGHTS[:count, 0], strict=True))
    surface = sr.Surface(X[:count], Y, np.tile(HEIGHTS[:count, :1], (1, 7)))
    for x in np.linspace(X[0] - 1, X[count - 1] + 1, 50):
        assert surface.height(x, 1.7) == pytest.approx(curve(x), rel=1e-12, abs=1e-12)


def test_a_random_road_between_its_tracks() -> None:
    road = sr.RandomRoad("C", length=20.0, seed=4, width=1.5)
    for x in np.linspace(-1.0, 22.0, 60):
        left, right = road.left(x), road.right(x)
        across = road.surface.height(x, [0.75, -0.75, 0.0, 1.5])
        assert across == pytest.approx([left, right, (left + right) / 2, 1.5 * left - right / 2], abs=1e-13)
    with pytest.raises(sr.ModelError, match="width is 0, so that both tracks are one"):
        _ = sr.RandomRoad("C", length=20.0, width=0.0).surface


def test_equal_surfaces() -> None:
    one, same, other = (sr.Surface(X, Y, heights) for heights in (HEIGHTS, HEIGHTS.tolist(), HEIGHTS + 1e-9))
    assert one == same != other
    assert hash(one) == hash(same)
    assert repr(one).startswith("<Surface of 9 x 7 points, x ")
    with pytest.raises(ValueError, match="read-only"):
        one.z[0, 0] = 1.0


FILE = """\
name: one wheel
bodies:
  wheel: {mass: 20, inertia: [1, 1, 1], position: [0, 0, 0.3]}
forces:
  tyre:
    type: road_tyre
    point: {body: wheel, at: [0, 0, 0]}
    k: 2e5
    c: 100
    radius: 0.31
    road: {x: [0, 100 cm, 2], y: [-1, 1], z: [[0, 0], [0, 5 mm], [0.01, 0.02]]}
"""


def test_in_a_model_file(tmp_path: Path) -> None:
    (tmp_path / "wheel.yaml").write_text(FILE)
    model = sr.load(tmp_path / "wheel.yaml")
    surface = sr.Surface([0, 1, 2], [-1, 1], [[0, 0], [0, 5e-3], [0.01, 0.02]])
    assert model.forces[0].road == surface
    model.save(tmp_path / "again.yaml")
    assert sr.load(tmp_path / "again.yaml").forces[0].road == surface
    assert not any(name.startswith("tyre.road") for name in sr.System(model).parameter_names)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (([0, 1], [0, 1], [[0, 0]]), "z has 1 x 2 heights, but x and y need 2 x 2. Give rising x"),
        (([0, 1, 1], [0, 1], np.zeros((3, 2))), "x must rise, but 1.0 follows 1.0"),
        (([0], [0, 1], [[0, 0]]), "x must have at least two numbers, but has 1"),
        (([0, 1], [0, np.nan], np.zeros((2, 2))), "y has a number that is not finite"),
        (([0, 1], [0, 1], [[0, 1], [np.inf, 0]]), "z has a number that is not finite"),
        (([0, 1], [0, 1], [[0, 1], [0]]), "z must be an array of numbers"),
        (([0, 1], [0, 1], [0, 1]), "z must be a list of rows of numbers"),
        ((0, [0, 1], [[0, 1]]), "x must be a list of numbers"),
        (("road", [0, 1], [[0, 1]]), "x must be an array of numbers"),
    ],
)
def test_what_is_no_surface(given: Any, message: str) -> None:
    with pytest.raises(sr.ModelError, match=message):
        sr.Surface(*given)


@pytest.mark.parametrize(
    ("road", "message"),
    [
        ("{x: [0, 1], y: [0, 1]}", "road.*z is missing"),
        ("{x: [0, 1], y: [0, 1], z: [[0, 1], [2]]}", "z must be an array of numbers"),
        ("{x: [0, 1 kg], y: [0, 1], z: [[0, 1], [2, 3]]}", "kg"),
    ],
)
def test_what_is_no_surface_in_a_file(tmp_path: Path, road: str, message: str) -> None:
    (tmp_path / "wheel.yaml").write_text(FILE[: FILE.index("    road:")] + f"    road: {road}\n")
    with pytest.raises(sr.ModelError, match=message):
        sr.load(tmp_path / "wheel.yaml")
