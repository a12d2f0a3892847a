"""The functions that kernels may call: for numbers, for complex steps, in many digits, and as they are compiled."""

import cmath
import math
from functools import cache

import mpmath
import numpy as np
import pytest
from numba import njit

from sarrus import functions
from sarrus._jit.formulas.curves import (
    CODES,
    STEPS,
    curve_bend,
    curve_slope,
    curve_twist,
    curve_value,
)
from sarrus._jit.formulas.differentiate import jacobian
from sarrus._jit.formulas.expression import Graph
from sarrus._jit.formulas.functions import atan2, nearest, sqrt
from sarrus._jit.formulas.program import program
from sarrus._jit.formulas.replay import replay
from sarrus._jit.kernels.compiled_functions import COMPILED

STEP = 1e-200
KEPLER = 0.6  # eccentricity of M = u - e sin u
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


# ------------------------------------------------------------------------------------------ stored formulas

UNARY = {
    name: getattr(functions, name)
    for name in ("sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "exp", "log")
}
FORMULAS = {
    **{name: lambda x, f=f: 2 * f(x / 4) * x for name, f in UNARY.items()},
    "tanh": lambda x: functions.tanh(x) / x,
    "positive": lambda x: x * x * functions.positive(x - 1) - functions.positive(-x),
    "ramp": lambda x: functions.ramp(x - 1) ** 3 + functions.ramp(1 - x),
    "absolute": lambda x: functions.absolute(x - 1) * x,
    "minimum": lambda x: functions.minimum(x * x, 3) + functions.maximum(x, 1),
    "abs": lambda x: functions.abs(x - 1) * x + abs(x),
    "min": lambda x: functions.min(x * x, 3) + functions.max(x, 1),
    "sign": lambda x: functions.sign(x - 1) * x**3 + functions.sign(-x),
    "step": lambda x: functions.step(x, 1, 2, 1.5, -3),
    "floor": lambda x: functions.floor(3 * x) * x**2,
    "mod": lambda x: functions.mod(x, 0.75) ** 3 + functions.mod(-x, 2),
    "arithmetic": lambda x: -(x - 2) * (x + 3) / (1 + x * x) + 7,
    "constant": lambda x: 5,
}


@pytest.mark.parametrize("name", FORMULAS)
@pytest.mark.parametrize("x", [0.5, 1.25, 1.875])
def test_a_stored_formula_and_its_derivatives(name, x):
    """In 70 digits against numerical derivatives, and compiled against that."""
    formula = FORMULAS[name]
    stored = np.array([9.0, 9.0, *program(formula)])
    kinds = {
        "curve": curve_value,
        "curve_slope": curve_slope,
        "curve_bend": curve_bend,
        "curve_twist": curve_twist,
    }
    with mpmath.workdps(70):
        for order, (kind, plain) in enumerate(kinds.items()):
            expected = mpmath.diff(lambda y: mpmath.mpf(1) * formula(y), mpmath.mpf(x), order)
            assert abs(plain(stored, 2, mpmath.mpf(x)) - expected) < 1e-25 * (1 + abs(expected))
            assert plain(stored, 2, x) == pytest.approx(float(expected), rel=1e-13, abs=1e-13)
            assert compiled_curve(kind)(stored, 2.0, x) == pytest.approx(
                float(expected), rel=1e-13, abs=1e-13
            )


@cache
def compiled_curve(kind):
    return njit(COMPILED[kind])


def test_the_slope_of_a_formula_by_a_complex_step():
    stored = program(FORMULAS["exp"])
    for x in (0.5, 1.25):
        assert curve_value(stored, 0, complex(x, STEP)).imag / STEP == pytest.approx(
            curve_slope(stored, 0, x)
        )
        assert curve_slope(stored, 0, complex(x, STEP)).imag / STEP == pytest.approx(curve_bend(stored, 0, x))


def test_every_operation_of_a_formula_is_tried():
    used = set()
    for formula in FORMULAS.values():
        used |= {int(code) for code in program(formula)[1::3]}
    assert used == set(CODES.values())


def test_formulas_that_cannot_be_stored_are_refused():
    with pytest.raises(TypeError, match="cannot use atan2"):
        program(lambda x: functions.atan2(x, 2))
    with pytest.raises(TypeError, match="must not branch"):
        program(lambda x: x if x > 0 else -x)
    with pytest.raises(ValueError, match=f"more than {STEPS}"):
        program(lambda x: sum(functions.sin(n * x) for n in range(1, STEPS)))


OF_OTHERS = ("maximum", "max", "atan2", "nearest", "hypot", "deg", "rad", "root")


def test_all_public_functions_are_tried():
    """Those that a formula of one variable cannot use are tried above, or by the elements of the tests."""
    assert set(functions.__all__) == {*FORMULAS, *OF_OTHERS} - {
        "arithmetic",
        "constant",
    }


@pytest.mark.parametrize("x", PLACES)
def test_bend_and_twist(x):
    cubic = by_hand(x)
    assert curve_bend(CURVE, AT, x) == pytest.approx(cubic.deriv(2)(x), rel=1e-13)
    assert curve_twist(CURVE, AT, x) == pytest.approx(cubic.deriv(3)(x), rel=1e-13)


@pytest.mark.parametrize("x", [-100.0, -30.0, -1e-9, 0.0, 1e-9, 0.3, 5.0, 18.0, 30.0, 100.0])
def test_the_slope_of_tanh_does_not_cancel(x):
    """1 - tanh² has no digits from x = 19 on; its own derivative -2 tanh sech² has all near zero, too."""
    from sarrus._jit.formulas.functions import sech2

    with mpmath.workdps(400):
        wanted = mpmath.sech(mpmath.mpf(x)) ** 2
        bend = -2 * mpmath.tanh(mpmath.mpf(x)) * wanted
    stored = np.array([9.0, 9.0, *program(functions.tanh)])
    for found in (sech2(x), COMPILED["sech2"](x), sech2(complex(x, STEP)).real, curve_slope(stored, 2, x)):
        assert found == pytest.approx(float(wanted), rel=1e-13)
    assert sech2(complex(x, STEP)).imag / STEP == pytest.approx(float(bend), rel=1e-13, abs=1e-15)
    assert curve_bend(stored, 2, x) == pytest.approx(float(bend), rel=1e-13, abs=1e-300)


def anomaly(mean):
    return functions.root(lambda u: u - KEPLER * functions.sin(u) - mean, mean)


def test_roots_of_equations():
    """For floats, complex steps and many digits, beside mpmath's own solver; arrays; what does not converge."""
    with mpmath.workdps(40):
        exact = mpmath.findroot(lambda u: u - KEPLER * mpmath.sin(u) - 1, 1)
        assert abs(anomaly(mpmath.mpf(1)) - exact) < 1e-38
    assert anomaly(1.0) == pytest.approx(float(exact), rel=2e-16)
    slope = 1 / (1 - KEPLER * math.cos(exact))
    assert anomaly(complex(1.0, STEP)).imag / STEP == pytest.approx(slope, rel=1e-14)
    assert math.isnan(functions.root(lambda u: 1 + u * u, 0.3))


def test_derivatives_of_a_recorded_root():
    """Of the implicit function up to the third order, beside Taylor coefficients in many digits; not by the start."""
    graph = Graph()
    mean, start = graph.input("mean"), graph.input("start")
    u = functions.root(lambda u: u - KEPLER * functions.sin(u) - mean, start)
    found = [u]
    for _ in range(3):
        found.append(jacobian(graph, [found[-1]], [mean])[0, 0])
    values = replay(graph, found, {("mean",): 1.0, ("start",): 0.5})
    with mpmath.workdps(40):
        exact = mpmath.taylor(anomaly, 1, 3)
    assert values == pytest.approx([float(c * math.factorial(n)) for n, c in enumerate(exact)], rel=1e-12)
    assert jacobian(graph, [u], [start])[0, 0] == 0


def test_equations_that_have_no_root_in_formulas():
    graph = Graph()
    x = graph.input("x")
    with pytest.raises(TypeError, match="smooth formula of its unknown"):
        functions.root(lambda u: abs(u) - x, 1.0)
    with pytest.raises(TypeError, match="does not depend on its unknown"):
        functions.root(lambda u: x * x, 1.0)
