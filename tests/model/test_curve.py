"""Curves: the spline, its straight ends, and its numbers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from sarrus._jit.formulas.curves import curve_bend, curve_slope, curve_value
from sarrus.model import Curve, ModelError
from sarrus.system.curves.curve_integrals import moments

PAIRS = [(-1.0, 2.0), (0.0, 0.5), (0.7, 1.0), (2.0, 3.0), (2.5, -1.0)]


def evaluated(numbers: tuple[float, ...], x: float) -> float:
    """Evaluate a curve from its numbers, as a kernel would."""
    n = int(numbers[0])
    knots, cubics = np.array(numbers[1 : n + 2]), np.reshape(numbers[n + 2 :], (n, 4))
    k = int(np.clip(np.searchsorted(knots, x, side="right") - 1, 0, n - 1))
    return float(np.polyval(cubics[k], x - knots[k]))


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_a_table_is_a_spline_inside_and_straight_outside(count: int) -> None:
    pairs = PAIRS[:count]
    x, y = np.transpose(pairs)
    spline = CubicSpline(x, y, bc_type="natural" if count < 4 else "not-a-knot")
    curve = Curve.table(pairs)
    for at in np.linspace(x[0], x[-1], 41):
        assert abs(curve(at) - spline(at)) < 1e-13
    for beyond in (0.1, 0.9, 1.0, 5.0, 300.0):
        assert abs(curve(x[0] - beyond) - (y[0] - beyond * spline(x[0], 1))) < 1e-11
        assert abs(curve(x[-1] + beyond) - (y[-1] + beyond * spline(x[-1], 1))) < 1e-11


def test_numbers_hold_the_whole_curve() -> None:
    curve = Curve.table(PAIRS)
    numbers = curve.numbers()
    segments = len(PAIRS) - 1 + 2
    assert numbers[0] == segments
    assert len(numbers) == 1 + (segments + 1) + 4 * segments
    assert all(type(number) is float for number in numbers)
    for at in np.linspace(-5, 6, 111):
        assert evaluated(numbers, at) == pytest.approx(curve(at), abs=1e-12)


def test_a_constant_is_one_segment() -> None:
    curve = Curve.constant(2.5)
    assert curve.numbers() == (1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.5)
    assert [curve(x) for x in (-10.0, 0.5, 10.0)] == [2.5] * 3


@pytest.mark.parametrize(
    ("pairs", "phrase"),
    [
        ([], "at least two points, but has 0"),
        ([(0, 1)], "at least two points, but has 1"),
        ([(0, 1), (0, 2)], "rising x, but 0.0 follows 0.0"),
        ([(0, 1), (2, 2), (1, 2)], "rising x, but 1.0 follows 2.0"),
        ([(0, 1), (1, np.nan)], "finite number, but is nan"),
        ([(0, 1), (1, 2, 3)], "must have 2 numbers, but has 3"),
        ([(0, 1e40), (1e-300, 2), (1, 2)], "too near to each other"),
        ([1, 2], "must be a list of numbers, but is 1"),
        (5, "must be a list of pairs, but is 5"),
    ],
)
def test_a_wrong_table_is_refused(pairs: list[tuple[float, ...]], phrase: str) -> None:
    with pytest.raises(
        ModelError, match=f"^curve: table .*{phrase}.*. Give a table|^curve: table .*{phrase}.*. Sort"
    ):
        Curve.table(pairs)


@pytest.mark.parametrize("count", [3, 5])
def test_a_periodic_table_is_a_periodic_spline(count: int) -> None:
    pairs = [*PAIRS[: count - 1], (2.9, PAIRS[0][1])]
    spline = CubicSpline(*np.transpose(pairs), bc_type="periodic", extrapolate="periodic")
    curve = Curve.table(pairs, periodic=True)
    x = np.linspace(-30, 40, 211)
    assert np.allclose([curve(at) for at in x], spline(x), atol=1e-12)
    for order, function in enumerate((curve_value, curve_slope, curve_bend)):
        assert np.allclose([function(curve.numbers(), 0, at) for at in x], spline(x, order), atol=1e-11)
    assert np.allclose(moments(curve.numbers(), 0.2, x, 0), [spline.integrate(0.2, b) for b in x], atol=1e-11)


def test_a_periodic_table_ends_as_it_begins() -> None:
    with pytest.raises(
        ModelError, match=r"begins with 2\.0 and ends with -1\.0\. Give the same value at both ends"
    ):
        Curve.table(PAIRS, periodic=True)
    almost = [*PAIRS[:-1], (2.5, PAIRS[0][1] * (1 + 1e-15))]
    assert Curve.table(almost, periodic=True).pairs[-1][1] == PAIRS[0][1]
