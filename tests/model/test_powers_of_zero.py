"""Powers and roots of what may stay zero, as of max(0, x): laws of contact, and flow over an edge."""

from __future__ import annotations

from math import gamma
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus import functions
from sarrus._jit.formulas.differentiate import jacobian
from sarrus._jit.formulas.expression import Graph
from sarrus._jit.formulas.replay import replay

K = 200.0


def ball(*force: Any) -> sr.System:
    """A mass of 1 kg that moves with 1 m/s in all directions against these forces."""
    body = sr.Body("m", 1.0, (0.1,) * 3, velocity=(1, 1, 1))
    return sr.System(sr.Model("contact", [body], forces=[sr.PointForce("f", body.point(0, 0, 0), force)]))


def test_laws_of_contact_return_the_energy() -> None:
    """The law of Hertz in two forms and a root, reached at x = 0.4 to 0.6 m. Hertz's depth is (1.25 v²/k)^0.4.

    Slopes of the root are infinite where the contact ends, and second slopes of the power 1.5. For a power p, the
    contact takes a time T in proportion to k^-n, n = 1/(p + 1), and the place is then T + const.
    """
    system = ball(
        f"-{K}*max(0, m.x - 0.5)^1.5",
        f"-{K}*sqrt(max(0, m.y - 0.4))",
        f"-{K}*max(0, m.z - 0.6)*sqrt(max(0, m.z - 0.6))",
    )
    run = sr.simulate(system, until=1.5, store="steps")
    assert run.status == "finished"
    for axis, power in zip("xyz", (1.5, 0.5, 1.5), strict=True):
        assert run[f"m.velocity.{axis}"][-1] == pytest.approx(-1.0, abs=1e-6)
        n, of_power = 1 / (power + 1), [f"f.force.{axis}.1"]
        depth = ((power + 1) / (2 * K)) ** n
        time = 2 * depth * np.sqrt(np.pi) * gamma(1 + n) / gamma(0.5 + n)
        found = sr.sensitivity(run, f"m.{axis}", of_power)
        assert found.matrix == pytest.approx(-n * time / K, rel=1e-4)
        with pytest.warns(sr.SarrusWarning, match="f: its force begins or ends with an infinite curvature"):
            sr.hessian(run, f"m.{axis}", of_power)
    deepest, depth = sr.Maximum("m.x"), (1.25 / K) ** 0.4
    found = sr.sensitivity(run, deepest, ["f.force.x.1"])
    assert found.values == pytest.approx(0.5 + depth, abs=1e-7)
    assert abs(found.matrix) == pytest.approx(0.4 * depth / K, rel=1e-5)


@pytest.mark.parametrize("exponent", [1.5, 1.2, 2.5, 0.5, 0.3])
def test_derivatives_are_zero_where_the_base_stays_zero(exponent: float) -> None:
    graph = Graph()
    x = graph.input("x")
    law = functions.maximum(0, x - 1) ** exponent
    derivatives = [law]
    for _ in range(3):
        derivatives.append(jacobian(graph, [derivatives[-1]], [x])[0, 0])
    value, *rest = replay(graph, derivatives, {("x",): 0.5})
    assert value == pytest.approx(0.0, abs=1e-25)
    assert rest == [0.0, 0.0, 0.0]
    factors = [np.prod(exponent - np.arange(n)) for n in range(4)]
    exact = [factor * 0.25 ** (exponent - n) for n, factor in enumerate(factors)]
    assert replay(graph, derivatives, {("x",): 1.25}) == pytest.approx(exact, rel=1e-12)


def test_derivatives_that_do_not_exist_are_no_small_numbers() -> None:
    """Of x^1.5 at zero: the slope is zero, the second derivative infinite. Of a root the slope is."""
    graph = Graph()
    x = graph.input("x")
    slope = jacobian(graph, [x**1.5], [x])[0, 0]
    bend = jacobian(graph, [slope], [x])[0, 0]
    values = replay(graph, [slope, bend], {("x",): 0.0})
    assert values[0] == pytest.approx(0.0, abs=1e-40)
    assert values[1] > 1e40
    with pytest.raises(ZeroDivisionError):
        replay(graph, [jacobian(graph, [x**0.5], [x])[0, 0]], {("x",): 0.0})


def test_powers_are_no_jumps() -> None:
    """A sign that jumps is refused also beside a power, in functions."""
    with pytest.raises(sr.ModelError, match="has a sign"):
        ball(lambda o: functions.sign(o("m.x")) * (1 + functions.maximum(0, o("m.x")) ** 1.5), 0, 0)
