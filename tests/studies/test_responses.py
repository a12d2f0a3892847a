"""Responses as formulas."""

import numpy as np
import pytest

import sarrus as sr
from sarrus.model import SarrusError
from sarrus.studies.responses import Response, responses_of
from sarrus.studies.runs import Simulation
from sarrus.studies.source import Start

T = np.linspace(0, 2, 2001)
HISTORIES = {"slider.x": np.sin(T), "rod.x": T**2, "k": 3.0}


def value(formula: str) -> float:
    return Response("r", formula).value(None, T, HISTORIES.__getitem__)


@pytest.mark.parametrize(
    ("formula", "wanted"),
    [
        ("slider.x", np.sin(2)),
        ("final(rod.x)", 4.0),
        ("initial(rod.x) + 1", 1.0),
        ("at(rod.x, 500 ms)", 0.25),
        ("max(slider.x) - min(slider.x)", 1.0),
        ("mean(rod.x)", 4 / 3),
        ("rms(slider.x - rod.x)", np.sqrt(np.trapezoid((np.sin(T) - T**2) ** 2, T) / 2)),
        ("integral(abs(1 - rod.x))", 2 / 3 + 2 - 2 / 3),
        ("max(rod.x, 2) + 0*k", 4.0),
        ("max(max(slider.x, rod.x))", 4.0),
        ("k*2", 6.0),
        ("max(k)", 3.0),
    ],
)
def test_values(formula: str, wanted: float) -> None:
    assert value(formula) == pytest.approx(wanted, rel=2e-6)


def test_times_are_asked_for() -> None:
    assert Response("r", "at(a.x, 0.25) + max(at(b.x, 1))").times() == (0.25, 1.0)


@pytest.mark.parametrize(
    ("formula", "told"),
    [
        ("max(", "response 'r' holds a formula"),
        ("maximum(slider.x)", 'unknown function "maximum"'),
        ("integral(1, 2)", "calls integral with 2 arguments"),
        ("__import__('os')", "response 'r'"),
    ],
)
def test_wrong_formulas_are_told_at_once(formula: str, told: str) -> None:
    with pytest.raises(SarrusError, match=told.replace("(", r"\(")):
        Response("r", formula)


def test_what_is_no_number_is_an_error() -> None:
    with pytest.raises(SarrusError, match="'r' is nan, no finite number"):
        Response("r", "x").value(None, T, lambda name: np.nan)


def test_names_of_responses() -> None:
    found = responses_of(["max(slider.x)", np.linalg.norm])
    assert [one.name for one in found] == ["max(slider.x)", "norm"]


def test_only_what_responses_depend_on_is_computed() -> None:
    """Accelerations and multipliers stay uncomputed until a response reads a reaction."""
    system = sr.System(sr.load("slider_crank"))
    found = Simulation(until=0.5).found(system, Start(system.q0, system.v0), (), np.inf)
    run, whole = found.result, sr.simulate(system, until=0.5)
    np.testing.assert_allclose(found.lookup("slider.x"), whole["slider.x"], rtol=1e-12)
    assert "a" not in run.__dict__
    np.testing.assert_allclose(found.lookup("pin.force.x"), whole["pin.force.x"], rtol=1e-9, atol=1e-9)
    assert "a" in run.__dict__
