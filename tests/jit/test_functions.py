"""The functions that kernels may call: for numbers, for complex steps, in many digits, and as they are compiled."""

import cmath
import math

import mpmath
import numpy as np
import pytest
from numba import njit

from sarrus._jit.compiled_functions import COMPILED
from sarrus._jit.curves import curve_slope, curve_value
from sarrus._jit.expression import Graph
from sarrus._jit.functions import atan2, nearest, sqrt

STEP = 1e-200
CURVE = np.array(
    [9.0, 9.0, 9.0, 3, -1, 0, 2, 3, 1, -2, 4, 3, 2, 1, -3, 5, 0.5, 0, 1, -1]
)  # stored from place 3 on
AT = 3
PLACES = [-7.0, -1.0, -0.5, 0.0, 1.0, 2.0, 2.5, 3.0, 11.0]  # before, at and between the knots, and after


def by_hand(x):
    knots, cubics = [-1, 0, 2], [(1, -2, 4, 3), (2, 1, -3, 5), (0.5, 0, 1, -1)]
    k = 0 if x < 0 else 1 if x < 2 else 2
    return np.polynomial.Polynomial(cubics[k][::-1])(np.polynomial.Polynomial([-knots[k], 1]))


@pytest.mark.parametrize("x", PLACES)
def test_curve_and_slope(x):
    cubic = by_hand(x)
    assert curve_value(CURVE, AT, x) == pytest.approx(cubic(x), rel=1e-14)
    assert curve_slope(CURVE, AT, x) == pytest.approx(cubic.deriv()(x), rel=1e-14)
    assert curve_value(CURVE, AT, complex(x, STEP)).imag / STEP == pytest.approx(cubic.deriv()(x), rel=1e-14)
    assert curve_value(CURVE, AT, mpmath.mpf(x)) == pytest.approx(curve_value(CURVE, AT, x), rel=1e-14)


@pytest.mark.parametrize("name", ["curve", "curve_slope"])
def test_curves_as_compiled(name):
    plain, compiled = {"curve": curve_value, "curve_slope": curve_slope}[name], njit(COMPILED[name])
    assert [compiled(CURVE, float(AT), x) for x in PLACES] == [plain(CURVE, AT, x) for x in PLACES]


def test_a_curve_of_one_piece():
    one, compiled = np.array([1.0, 0, 1, 1, 2, 3, 4]), njit(COMPILED["curve"])
    assert [curve_value(one, 0, x) for x in (-1.0, 0.5, 3.0)] == [2.0, 6.125, 58.0]
    assert [compiled(one, 0.0, x) for x in (-1.0, 0.5, 3.0)] == [2.0, 6.125, 58.0]


@pytest.mark.parametrize(
    ("x", "whole"), [(-1.6, -2), (-1.5, -1), (-0.4, 0), (0.5, 1), (2.49, 2), (1e9 + 0.6, 1e9 + 1)]
)
def test_nearest(x, whole):
    assert (
        nearest(x)
        == nearest(complex(x, 1.0))
        == nearest(mpmath.mpf(x))
        == njit(COMPILED["nearest"])(x)
        == whole
    )


@pytest.mark.parametrize("angle", [-3.0, -1.7, -0.2, 0.0, 0.9, 1.6, 3.1])
def test_atan2(angle):
    y, x = 2.5 * math.sin(angle), 2.5 * math.cos(angle)
    assert atan2(y, x) == njit(COMPILED["atan2"])(y, x) == math.atan2(y, x)
    assert atan2(mpmath.mpf(y), mpmath.mpf(x)) == mpmath.atan2(y, x)
    for dy, dx in ((1, 0), (0, 1), (0.3, -2)):
        found = atan2(complex(y, dy * STEP), complex(x, dx * STEP))
        assert found.real == math.atan2(y, x)
        assert found.imag / STEP == pytest.approx((x * dy - y * dx) / 2.5**2, rel=1e-12)


def test_sqrt():
    assert sqrt(2.25) == 1.5
    assert sqrt(4) == 2.0
    assert sqrt(complex(2, 1)) == cmath.sqrt(complex(2, 1))
    assert sqrt(complex(2.25, STEP)).imag / STEP == pytest.approx(1 / 3, rel=1e-14)
    with mpmath.workdps(70):
        assert abs(sqrt(mpmath.mpf(2)) ** 2 - 2) < mpmath.mpf(10) ** -60


def test_recorded_calls_are_nodes():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    for recorded, op in (
        (sqrt(x), "sqrt"),
        (atan2(y, x), "atan2"),
        (atan2(1, x), "atan2"),
        (nearest(x), "nearest"),
    ):
        assert graph.nodes[recorded.id].op == op
    assert graph.nodes[atan2(y, x).id].args == (y.id, x.id)
    assert graph.nodes[graph.nodes[atan2(1, x).id].args[0]].value == 1
