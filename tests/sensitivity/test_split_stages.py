"""Adjoints of methods whose stages are split: by iteration with factors of the size of one stage."""

from typing import Any

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.sensitivity.steps import record
from sarrus.analyses.sensitivity.steps.record import STEP, Occurrences
from sarrus.analyses.sensitivity.steps.sweep import Sweep

RESPONSES = [sr.Final("slider.x"), sr.Integral("energy.kinetic")]


def swung() -> sr.Trajectory:
    settings = {"rtol": 1e-6, "atol": 1e-8, "store_steps": True, "method": sr.Radau()}
    return sr.simulate(slider_crank(), until=0.8, t_eval=[0.8], **settings)


def close(found: sr.Gradient, wanted: sr.Gradient, tolerance: float) -> bool:
    scale = abs(wanted.matrix).max(axis=1, keepdims=True)
    return bool(np.all(abs(found.matrix - wanted.matrix) < tolerance * scale))


@pytest.fixture
def chosen(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """For each order of pivots that is chosen for a step, whether its stages are split."""
    found, choose = list[bool](), Sweep._pivots

    def watched(self: Sweep, op: int, *given: Any, **named: Any) -> Any:
        made = choose(self, op, *given, **named)
        found.extend([made.split is not None] if op == STEP else [])
        return made

    monkeypatch.setattr(Sweep, "_pivots", watched)
    return found


@pytest.fixture
def always(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stages of small systems are split, too."""
    monkeypatch.setattr(record, "SPLIT_FROM", 0)


def test_a_single_column_forward_agrees_with_the_adjoint(always: None, chosen: list[bool]) -> None:
    found = sr.sensitivity(swung(), RESPONSES, ["spring.k"], method="direct")
    assert chosen == [True]
    wanted = sr.sensitivity(swung(), RESPONSES)["spring.k"]
    assert np.all(abs(found["spring.k"] - wanted) < 1e-10 * abs(wanted))


def test_the_gradient_is_that_of_the_exact_equations(always: None, chosen: list[bool]) -> None:
    """The direct method factors the matrix of all stages."""
    found = sr.sensitivity(swung(), RESPONSES)
    assert chosen == [True]
    assert close(found, sr.sensitivity(swung(), RESPONSES, method="direct"), 1e-10)


def test_solutions_that_do_not_converge_are_replaced(
    always: None, chosen: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With wrong factors: new ones are tried, then the matrix of all stages is factored."""
    weights = Occurrences.split_weights
    monkeypatch.setattr(Occurrences, "split_weights", lambda self, split: 0.4 * weights(self, split))
    found = sr.sensitivity(swung(), RESPONSES)
    assert chosen == [True, True, False]
    assert close(found, sr.sensitivity(swung(), RESPONSES, method="direct"), 1e-10)


def test_the_vehicle_is_solved_by_iteration(chosen: list[bool]) -> None:
    system = sr.System(sr.load(mechanisms.path("hmmwv")))
    run = sr.simulate(system, until=0.1, method=sr.Radau(), store_steps=True)
    given = run, sr.Integral("chassis.z"), ["chassis.mass", "gravity.z"]
    found = sr.sensitivity(*given)
    assert chosen == [True]
    assert close(found, sr.sensitivity(*given, method="direct"), 1e-10)
