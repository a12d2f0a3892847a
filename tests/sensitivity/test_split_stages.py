"""Adjoints of methods whose stages are split: by iteration with factors of the size of one stage."""

from typing import Any

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus import mechanisms
from sarrus._jit.linking.link import link
from sarrus.analyses.sensitivity.steps import record
from sarrus.analyses.sensitivity.steps.record import STEP, Occurrences
from sarrus.analyses.sensitivity.steps.split_loop import correct
from sarrus.analyses.sensitivity.steps.sweep import Sweep

RESPONSES = [sr.Final("slider.x"), sr.Integral("energy.kinetic")]


def swung() -> sr.Trajectory:
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-6, atol=1e-8)}
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


def test_singular_split_stages_are_replaced(
    always: None, chosen: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the real matrix has no pivots, that of all stages is factored from the start."""
    weights = Occurrences.split_weights
    monkeypatch.setattr(Occurrences, "split_weights", lambda self, split: 0.0 * weights(self, split))
    found = sr.sensitivity(swung(), RESPONSES)
    assert chosen == [False]
    assert close(found, sr.sensitivity(swung(), RESPONSES, method="direct"), 1e-10)


def test_the_vehicle_is_solved_by_iteration(chosen: list[bool]) -> None:
    system = sr.System(sr.load(mechanisms.path("hmmwv")))
    run = sr.simulate(system, until=0.1, method=sr.Radau(), store="steps")
    given = run, sr.Integral("chassis.z"), ["chassis.mass", "gravity.z"]
    found = sr.sensitivity(*given)
    assert chosen == [True]
    assert close(found, sr.sensitivity(*given, method="direct"), 1e-10)


def chain(links: int) -> sr.System:
    bodies, joints = list[sr.Body](), list[sr.Spherical]()
    for n in range(links):
        bodies.append(sr.Body(f"b{n}", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(n + 0.5, 0, 0)))
        joints.append(sr.Spherical(f"j{n}", bodies[n - 1] if n else sr.ground, bodies[n], point=(n, 0, 0)))
    ends = sr.Point(sr.ground, [links, 0, 1]), sr.Point(bodies[-1], [0.5, 0, 0])
    spring = sr.TSDA("s", *ends, k=30.0, c=0.3, length=0.5)
    return sr.System(sr.Model("chain", bodies=bodies, joints=joints, forces=[spring]))


def test_a_small_first_correction_is_no_proof(always: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first correction may be small and the next contract slowly."""
    run = sr.simulate(chain(10), until=1.5, method=sr.Radau(rtol=1e-2), store="steps")
    given = run, sr.Final("b9.z"), ["s.k", "s.c", "b3.mass"]
    found = sr.sensitivity(*given)
    monkeypatch.setattr(record, "SPLIT_FROM", 10**9)
    assert np.allclose(found.matrix, sr.sensitivity(*given).matrix, rtol=5e-12, atol=0.0)


def test_each_column_converges_by_its_own_size() -> None:
    """A column 1e13 times as large, as of another unit, has converged; the other has not."""
    solution, change = np.array([[1e13, 1.0], [1e12, 2.0]]), np.array([[1e-3, 4e-6], [1e-3, 0.0]])
    before = np.array([1e-8, 1e-4])
    assert np.isclose(link(correct)(change, solution, before), 2e-6**2 / 1e-4)
    assert np.allclose(before, [1e-16, 2e-6], rtol=1e-12, atol=0.0)
    assert solution[0, 1] == 1.0 + 4e-6
