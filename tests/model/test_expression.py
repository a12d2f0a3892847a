"""Formulas: what they mean, for which numbers, their exact derivatives, and what is refused."""

from __future__ import annotations

import math
import subprocess
import sys
from contextlib import suppress
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sarrus._jit.formulas.expression import Graph
from sarrus.model import ModelError
from sarrus.model.expression import FUNCTIONS, Expression, Name, Number, parse, parse_expression
from sarrus.model.expression.units import fits, powers_of, unit_of, unit_text
from sarrus.model.laws.curve import Formula

VALUES = [
    ("2", 2.0),
    ("1 + 2*3", 7.0),
    ("(1 + 2)*3", 9.0),
    ("2 - 3 - 4", -5.0),
    ("2/4/2", 0.25),
    ("-2**2", -4.0),
    ("(-2)**2", 4.0),
    ("2**-1", 0.5),
    ("2**3**2", 512.0),
    ("2^3", 8.0),
    ("--2", 2.0),
    ("${2*x} + ${x}", 9.0),
    ("2·x", 6.0),
    ("x**0.5", math.sqrt(3.0)),
    ("pi/2", math.pi / 2),
    ("1e3 + .5 + 5.", 1005.5),
    ("sin(x)**2 + cos(x)**2", 1.0),
    ("tan(x)", math.tan(3)),
    ("asin(0.5) + acos(0.5)", math.pi / 2),
    ("atan(1) - atan2(1, 1)", 0.0),
    ("exp(log(x))", 3.0),
    ("sqrt(x*x) - abs(-x)", 0.0),
    ("hypot(x, 4)", 5.0),
    ("min(x, 1, 2) + max(x, 9, 4)", 10.0),
    ("deg(pi) + rad(180)", 180 + math.pi),
    ("step(x, 0, 1, 2, 5)", 5.0),
    ("step(x, 4, 1, 5, 5)", 1.0),
    ("step(x, 2, 0, 4, 10)", 5.0),
    ("step(x, 2, 1, 6, 3)", 1 + 2 * (3 / 16 - 2 / 64)),
    ("'left-arm'.length*2", 14.0),
]
ENV = {"x": 3.0, "left-arm.length": 7.0}


@pytest.mark.parametrize(("text", "value"), VALUES)
def test_a_formula_has_its_value(text: str, value: float) -> None:
    assert parse(text).value(ENV) == pytest.approx(value, abs=1e-15)


@pytest.mark.parametrize("text", [text for text, _ in VALUES if "'" not in text])
def test_a_formula_is_the_same_when_it_is_printed_and_read(text: str) -> None:
    tree = parse(text)
    assert parse(str(tree)).value(ENV) == tree.value(ENV)
    assert str(parse(str(tree))) == str(tree)


UNITS = [
    ("20 mm", 0.02, "m"),
    ("9 mm", 0.009, "m"),
    ("30 deg", math.radians(30), "rad"),
    ("90°", math.pi / 2, "rad"),
    ("2.5 kN/m", 2500.0, "N/m"),
    ("9.81 m/s^2", 9.81, "m/s^2"),
    ("9.81 m s^-2", 9.81, "m/s^2"),
    ("3 N m/rad", 3.0, "N m/rad"),
    ("3 N*m", 3.0, "N m"),
    ("3 Nm", 3.0, "N m"),
    ("3 Nmm/deg", 0.003 * 180 / math.pi, "N m/rad"),
    ("2 g*cm^2", 2e-7, "kg m^2"),
    ("60 rpm", 2 * math.pi, "rad/s"),
    ("1 in", 0.0254, "m"),
    ("1 lbf", 4.4482216152605, "N"),
    ("2*x + 3 mm", 6.003, "m"),
    ("2 m / 4 s", 0.5, "m/s"),
    ("sqrt(4 m^2)", 2.0, "m"),
    ("(2 m)**2", 4.0, "m^2"),
    ("100 N * cos(60 deg)", 50.0, "N"),
]


@pytest.mark.parametrize(("text", "value", "unit"), UNITS)
def test_units_are_converted_and_known(text: str, value: float, unit: str) -> None:
    tree = parse(text)
    assert tree.value(ENV) == pytest.approx(value, rel=1e-15)
    assert fits(unit_of(tree, {"x": powers_of("m")}), unit)
    assert not fits(unit_of(tree, {"x": powers_of("m")}), "kg s")


def test_a_number_in_millimetres_is_rounded_once() -> None:
    for n in range(1, 2000):
        assert parse(f"{n} mm").value() == n / 1000


def test_units_of_names_are_used() -> None:
    tree = parse("f*l/2 + 3 N m")
    known = {"f": powers_of("N"), "l": powers_of("m")}
    assert unit_text(unit_of(tree, known) or {}) == "kg m^2 s^-2"
    assert unit_of(parse("f*l"), {"f": powers_of("N"), "l": None}) is None


DIFFERENTIABLE = [
    "x + 2*y - x*y",
    "x/y/(x + 3)",
    "x**3 - y**-2",
    "x**y",
    "-x**2",
    "sin(x*y)",
    "cos(x)/tan(y)",
    "asin(x/9) + acos(y/9) + atan(x*y)",
    "atan2(x, y)",
    "sqrt(x*x + y*y) - hypot(x, 2*y)",
    "exp(-x)*log(y)",
    "abs(x - y)",
    "sign(x - y)*x*y + sign(y - x)",
    "min(x, y) + max(x*y, 1) + min(x, y, 9)",
    "deg(x) + rad(y)",
    "tanh(x*y)/y + tanh(x)",
    "mod(x*x*y, y) + x*floor(3*x*y)",
    "step(x - y)*x",
    "step(x, 0, y, 5, 3*y)",
    "step(1.5, x, y, 4*y, 3)",
    "step(x*y, -1, 0, 1, 9)",
    "step(step(x, 0, 0, 9, 1), 0, 0, 1, y)",
]
STEP = 1e-30


@pytest.mark.parametrize("text", DIFFERENTIABLE)
@pytest.mark.parametrize("name", ["x", "y"])
def test_derivatives_are_exact(text: str, name: str) -> None:
    """First and second derivatives against the complex step, which is exact to round-off."""
    tree: Expression = parse(text)
    for _ in range(2):
        at = {"x": 1.25, "y": 0.75}
        moved = {**at, name: complex(at[name], STEP)}
        expected = complex(tree.value(moved)).imag / STEP
        tree = tree.derivative(name)
        assert tree.value(at) == pytest.approx(expected, rel=1e-13, abs=1e-13)


def test_every_function_is_among_the_differentiable_ones() -> None:
    assert all(any(f"{name}(" in text for text in DIFFERENTIABLE) for name in FUNCTIONS)


def test_a_step_is_smooth_where_it_begins_and_ends() -> None:
    step = parse_expression("step(t, 1, 0, 2, 5)", ["t"])
    rate, bend = step.derivative("t"), step.derivative("t").derivative("t")
    assert [step.value({"t": t}) for t in (0.0, 1.0, 1.5, 2.0, 3.0)] == [0, 0, 2.5, 5, 5]
    assert [rate.value({"t": t}) for t in (0.0, 1.0, 1.5, 2.0, 3.0)] == [0, 0, 7.5, 0, 0]
    assert [bend.value({"t": t}) for t in (0.0, 1.25, 1.5, 1.75, 3.0)] == [0, 15, 0, -15, 0]


def test_derivatives_of_long_and_nested_formulas_stay_small() -> None:
    nested = "t"
    for _ in range(40):
        nested = f"step({nested}, 0, 0, 1, 1)"
    tree = parse(nested).derivative("t")
    assert len(list(tree.nodes())) < 3000
    assert math.isfinite(tree.value({"t": 0.5}))
    long = parse("+".join(["t"] * 2000))
    assert long.derivative("t").value({"t": 1.0}) == 2000
    assert len(str(long)) > 4000


def test_formulas_take_any_kind_of_number() -> None:
    polynomial = parse("(x + 1)**3/2 - 2*x")
    assert polynomial.value({"x": Fraction(1, 3)}) == Fraction(64, 54) - Fraction(2, 3)
    smooth = parse("sin(x)*exp(-x) + atan2(x, 2) + sqrt(x)**3 + max(x, 0)")
    with mpmath.workdps(40):
        assert float(smooth.value({"x": mpmath.mpf(2)})) == pytest.approx(smooth.value({"x": 2.0}), rel=1e-15)
    many = parse("step(x, 0, 0, 2, 1) + abs(x) + min(x, 1)").value({"x": np.array([-1.0, 1.0, 3.0])})
    np.testing.assert_allclose(many, [0 + 1 - 1, 0.5 + 1 + 1, 1 + 3 + 1])


class Recorded:
    """A number that writes down what is done with it, by methods named as the functions are."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __getattr__(self, name: str) -> Any:
        if name not in ("sin", "max", "select"):
            raise AttributeError(name)
        return lambda *others: Recorded(f"{name}({', '.join(map(str, (self, *others)))})")

    def __mul__(self, other: object) -> Recorded:
        return Recorded(f"{self}*{other}")

    def __add__(self, other: object) -> Recorded:
        return Recorded(f"{self}+{other}")

    __radd__, __rmul__ = __add__, __mul__

    def __str__(self) -> str:
        return self.text


def test_numbers_with_methods_of_their_own_are_asked() -> None:
    t = Recorded("t")
    assert str(parse("3*sin(t)").value({"t": t})) == "sin(t)*3"
    assert str(parse("max(0, t)").value({"t": t})) == "max(t*0+0, t)"
    assert str(parse("t**3").value({"t": t})) == "t*t*t"
    with pytest.raises(TypeError, match="have no method cos"):
        parse("cos(t)").value({"t": t})


def test_formulas_can_be_recorded_for_compilation() -> None:
    graph = Graph()
    tree = parse("3*sqrt(t) + t**2*sin(2*t) + step(t, 0, 0, 1, 1) + atan2(1, t)*abs(t) + t**1.5")
    for formula in (tree, tree.derivative("t"), tree.derivative("t").derivative("t")):
        formula.value({"t": graph.input("t")})
    assert {node.op for node in graph.nodes} >= {"sqrt", "sin", "mul", "add", "positive", "atan2"}


def test_a_recorded_formula_is_the_formula() -> None:
    tree = parse("3*sqrt(t) + step(t, 0, 0, 3, 1) + min(t, 2)*max(t, 1) - abs(t - 5) + t**1.5")
    law = Formula(lambda t: tree.value({"t": t}))
    assert len(law.numbers()) > 10
    assert law(1.7) == tree.value({"t": 1.7})


def test_arithmetic_on_formulas_gives_formulas() -> None:
    x = Name("x")
    tree = (2 * x + 1) / x - 3 + x**2 - (-x)
    assert tree.value({"x": 2.0}) == 2.5 - 3 + 4 + 2
    assert tree.names() == ("x",)
    assert tree.replaced({"x": Number(2.0)}).value() == tree.value({"x": 2.0})


WRONG = [
    ("", "a number or a name is missing"),
    ("1 +", "a number or a name is missing"),
    ("* 2", 'a number or a name is missing before "*"'),
    ("(1", '")" is missing'),
    ("${1", '"}" is missing'),
    ("1)", '")" is out of place'),
    ("2 3", '"3" is out of place'),
    ("sin 2", '"2" is out of place'),
    ("sinn(2)", 'calls the unknown function "sinn". Did you mean "sin"?'),
    ("sin()", "a number or a name is missing"),
    ("sin(1, 2)", "calls sin with 2 arguments. Give it 1"),
    ("step(1, 2)", "calls step with 2 arguments. Give it 5"),
    ("min(1)", "calls min with 1 arguments. Give it 2"),
    ("tt + 1", 'has the unknown name "tt". Did you mean "t"?'),
    ("a.", "a name after a point is missing"),
    ("3 nan", 'has the unknown unit "nan". Choose from m, mm'),
    ("3 ''", '"" is out of place'),
    ("3 kgg", 'has the unknown unit "kgg". Did you mean "kg"?'),
    ("3 m^x", "the power of a unit is no whole number"),
    ("3 m^1.5", "the power of a unit is no whole number"),
    ("3 m^999", "the power of a unit is no whole number"),
    ("3 degC", 'has the unit "degC", which does not start at zero. Convert it'),
    ("1; 2", 'holds ";", which no formula has'),
    ("t if t else 1", '"if" is out of place'),
    ("t.__class__", 'has the unknown name "t.__class__"'),
    ("__import__('os')", 'calls the unknown function "__import__"'),
    ("lambda: 1", 'holds ":", which no formula has'),
    ("[1]", 'holds "[", which no formula has'),
    ("(" * 60, "more than 48 levels of brackets"),
    ("-" * 60 + "1", "more than 48 levels of brackets"),
    ("1+" * 3000, "more than 4000 characters"),
]


@pytest.mark.parametrize(("text", "phrase"), WRONG, ids=lambda text: text[:20])
def test_what_is_no_formula_is_refused_in_one_sentence(text: str, phrase: str) -> None:
    with pytest.raises(ModelError) as caught:
        parse_expression(text, ["t"])
    assert phrase in str(caught.value)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("text", "phrase"),
    [
        ("1/(x - x)", 'holds "1/(x - x)", which divides by zero. Change its numbers'),
        ("0**-1", "has no real value there"),
        ("sqrt(-x)", 'holds "sqrt(-x)", which has no real value there'),
        ("(-x)**0.5", "has no real value there"),
        ("log(0)", "has no real value there"),
        ("exp(1000*x)", "is too large"),
        ("10**400", "is too large"),
        ("9**9**9**9", "is too large"),
        ("y", '"y" has no value'),
    ],
)
def test_what_has_no_value_is_refused_in_one_sentence(text: str, phrase: str) -> None:
    with pytest.raises(ModelError, match=r"\. [A-Z]") as caught:
        parse(text).value({"x": 3.0})
    assert phrase in str(caught.value)


@pytest.mark.parametrize(
    ("text", "phrase"),
    [
        ("2 m + 3 kg", '"2 m + 3 kg" combines m and kg. Convert one of them'),
        ("max(1 m, 1 s)", "combines m and s"),
        ("sin(2 m)", "takes a plain number or an angle, but is given m"),
        ("step(1 s, 0 m, 1, 2 m, 1)", "combines s and m"),
    ],
)
def test_units_that_do_not_match_are_refused(text: str, phrase: str) -> None:
    with pytest.raises(ModelError) as caught:
        unit_of(parse(text), {})
    assert phrase in str(caught.value)


@given(st.text(alphabet="0123456789.+-*/^()${},'etxmkgs \n°", max_size=30))
def test_no_text_gives_another_exception(text: str) -> None:
    with suppress(ModelError):
        parse_expression(text, ["t", "x"]).value({"t": 1.0, "x": 2.0})


def test_pint_is_imported_only_for_units() -> None:
    code = (
        "import sys; from sarrus.model.expression import parse; parse('2*x + sin(3)');"
        "print('pint' in sys.modules); parse('2 mm'); print('pint' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "True"]
