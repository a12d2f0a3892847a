"""The paper's experiments: differences fall with the perturbation down to round-off; exact beats differenced by far."""

import numpy as np
import pytest
from benchmarks.paper import (
    STEPS,
    Difference,
    Experiment,
    consistent_state,
    differences_of,
    experiment,
    paper_tables,
)
from tests.jit.mixed import mixed_system, part_of
from tests.system.mechanisms import hmmwv, slider_crank

from sarrus.elements import Element
from sarrus.model import Force, Joint

AT_BEST = 1e-9  # relative error of a central difference at its best step: round-off
AIMS = {  # over central differences, on a quiet machine
    "slider_crank": {"kinematic": 25, "force": 8, "inertia": 12},
    "hmmwv": {"kinematic": 90, "force": 30, "inertia": 60},
}
BUSY = 0.5  # share of the aim that must be reached while other work disturbs the times
MECHANISMS = {"slider_crank": slider_crank, "hmmwv": hmmwv}


@pytest.fixture(scope="module", params=[pytest.param(name, marks=pytest.mark.slow) for name in MECHANISMS])
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def found(name: str) -> Experiment:
    return experiment(MECHANISMS[name]())


def fall_with_the_step(errors: list[float], operator: str) -> None:
    first = next(n for n, error in enumerate(errors) if error < 0.01)
    for step in range(first + 1, 5):
        assert errors[step] == pytest.approx(0.1 * errors[step - 1], rel=0.3), (operator, STEPS[step])


def test_differences_of_one_operator() -> None:
    """The whole experiment compiles kernels that no other test needs."""
    state = consistent_state(slider_crank(), seed=1)
    fall_with_the_step(differences_of(slider_crank(), "Phi_q", "forward", state), "Phi_q")
    assert min(differences_of(slider_crank(), "Phi_q", "central", state)) < AT_BEST


def test_forward_differences_fall_with_the_step(found: Experiment) -> None:
    for operator, errors in found.differences["forward"].items():
        if errors[0] >= 1e-10:  # otherwise linear in what is varied: no error but round-off
            fall_with_the_step(errors, operator)


def test_the_best_central_difference_agrees(found: Experiment) -> None:
    for operator, errors in found.differences["central"].items():
        assert min(errors) < AT_BEST, operator


def test_exact_is_faster_as_aimed(name: str, found: Experiment) -> None:
    for group, aim in AIMS[name].items():
        assert found.times[group].speedup > BUSY * aim, group


def test_plans_that_are_equal_have_one_time(found: Experiment) -> None:
    for group in ("force", "inertia"):
        assert found.times[group].shared == found.times[group].separate
    assert found.times["kinematic"].shared != found.times["kinematic"].separate


def test_tables(found: Experiment) -> None:
    text = paper_tables([found, found], STEPS)
    for number in range(1, 7):
        assert f"Table {number}." in text
    lines = [line.split() for line in text.splitlines()]
    row = next(line for line in lines if line[:1] == ["kinematic"])
    times = found.times["kinematic"]
    assert row[1] == f"{1e6 * times.exact:.3f}"
    assert row[-2:] == [f"{times.speedup:.0f}", f"{times.speedup_forward:.0f}"]
    assert sum(line[:1] == ["1e-08"] for line in lines) == 4


@pytest.mark.slow
def test_users_elements_are_differenced_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not only the built-in ones: the elements of the tests' own stand for a user's."""
    monkeypatch.setattr(Joint, "kinds", dict(Joint.kinds))
    monkeypatch.setattr(Force, "kinds", dict(Force.kinds))
    before = dict(Element.registry)
    system = mixed_system(part_of(Joint), part_of(Force))
    random = np.random.default_rng(0)
    state = {key: random.normal(size=system.nq) for key in ("q", "v")} | {"t": 0.7}
    (columns,) = Difference(system, ("Q",), "v", "central", state)(1e-5)
    exact = system.Q_v(**state).toarray()
    assert abs(columns.T - exact).max() < 1e-6 * abs(exact).max()
    assert Element.registry == before
