"""Errors of derivatives by checkpoints are those of runs whose steps are all stored."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.accuracy.test_change_errors import pushed
from tests.accuracy.test_derivative_errors import thrown
from tests.accuracy.test_equivalent_change import EVENTS, pendulum

import sarrus as sr
from sarrus.analyses.sensitivity import long_errors, long_run
from sarrus.analyses.sensitivity.accuracy.derivatives.equivalent_change import moved_along
from sarrus.analyses.sensitivity.accuracy.derivatives.growth import RelativeErrors
from sarrus.analyses.sensitivity.derivatives import differentiated
from sarrus.analyses.sensitivity.events.chains import chain_of
from sarrus.analyses.sensitivity.long_gradient import LongGradient
from sarrus.analyses.sensitivity.moved_run import LongChanges, MovedRun
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.responses.evaluation import Evaluation
from sarrus.analyses.sensitivity.responses.responses import Response
from sarrus.results import Pieces, StepsTaken

NAMES = ["a.mass", "b.mass"]


@pytest.fixture
def estimates(monkeypatch: pytest.MonkeyPatch) -> list[RelativeErrors]:
    """Relative errors of the derivatives of all responses, of long runs in short stretches."""
    monkeypatch.setattr(long_run, "FIRST", 60)
    found, errors = list[RelativeErrors](), long_errors.LongErrors._errors

    def noted(self: long_errors.LongErrors) -> RelativeErrors:
        found.append(errors(self))
        return found[-1]

    monkeypatch.setattr(long_errors.LongErrors, "_errors", noted)
    return found


LATE = [
    ((0.7, 1.6), 5.0, 1e-4, "none"),
    *(
        pytest.param(*case, marks=pytest.mark.slow) for case in [
            ((0.7, 1.6), 20.0, 1e-9, "none"), ((0.7, 1.6), 25.0, 1e-9, "none"), ((1.2, 0.5), 29.0, 1e-11, "none"),
            ((1.2, 0.5), 30.0, 1e-11, "none"), ((0.7, 1.6), 12.0, 1e-9, "new velocities"),
        ]
    ),
]  # fmt: skip


@pytest.mark.filterwarnings("ignore:.*(derivatives have|errors have grown)")
@pytest.mark.parametrize(("lengths", "until", "rtol", "events"), LATE)
def test_late_in_chaos(
    lengths: tuple[float, ...], until: float, rtol: float, events: str, estimates: list[RelativeErrors]
) -> None:
    """The derivatives have errors of up to 20 %, and the same estimate as if all steps were stored."""
    system, given = pendulum(*lengths), {"until": until, "events": EVENTS[events]}
    runs = [sr.simulate(system, rtol=own, store_steps=True, **given) for own in (1e-13, rtol)]
    truth, stored = (sr.sensitivity(run, "b.x", NAMES, error=True) for run in runs)
    found = sr.sensitivity_by_checkpoints(system, "b.x", NAMES, rtol=rtol, **given)
    error = np.linalg.norm(found.matrix - truth.matrix) / np.linalg.norm(truth.matrix)
    (estimate,) = estimates[0].values
    assert estimate == pytest.approx(stored.relative_errors[0], rel=0.05)
    assert error / 3 < estimate < 3 * error
    assert found.warnings or rtol < 1e-4  # the errors of some runs are small enough for none
    assert found.warnings == tuple(one for one in stored.warnings if "derivatives" in one)


RESPONSES: list[Response] = [
    sr.Final("b.y"), sr.Peak("b.x"), sr.Integral("energy.kinetic"), sr.At("pin_a.force.x", time=1.7),
    sr.Final("pin_b.angle"),
]  # fmt: skip


@pytest.mark.one_in(6)
@pytest.mark.filterwarnings("ignore:.*derivatives have")
@pytest.mark.parametrize("events", EVENTS)
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()])
def test_a_long_run_moves_as_one_whose_steps_are_stored(
    method: Any, events: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In stretches so short that states depend on nodes before them, with outputs that are no sums of samples."""
    moved, weighed, every = list[np.ndarray](), list[np.ndarray](), np.eye(len(NAMES))
    monkeypatch.setattr(long_run, "FIRST", 7)
    system, given = (
        pendulum(1.2, 0.5),
        {"method": method, "rtol": 1e-6, "events": EVENTS[events], "until": 3.0},
    )
    wanted = RESPONSES[:3] if events == "end" else RESPONSES

    def checked(errors: long_errors.LongErrors) -> None:
        run, parameters = errors._run, errors._parameters
        direction = parameters.along((np.array([0.3, -0.2]) * parameters.values)[:, None])
        changes = LongChanges(run, direction, errors._own.event_matrices, lambda t: None)
        there = LongGradient(MovedRun(changes), errors._responses, parameters).swept()
        moved.append((there.matrix - errors.found.matrix) / changes.small)
        weighed.append(errors.weighed(parameters.along(every)))

    monkeypatch.setattr(long_errors.LongErrors, "warn", checked)
    found = sr.sensitivity_by_checkpoints(system, wanted, NAMES, **given)
    run = sr.simulate(system, store_steps=True, **given)
    steps = run.steps
    assert isinstance(steps, StepsTaken | Pieces)
    parameters = Parameters(system, NAMES, start=steps.start)
    chain, along = chain_of(system, steps), np.array([0.3, -0.2]) * parameters.values
    there, small = moved_along(chain, parameters, along)
    after = differentiated(system, there, wanted, parameters).matrix
    before = differentiated(system, steps, wanted, parameters).matrix
    exact = (after - before) / small
    by_states = Evaluation(system, steps, wanted, parameters).gradients()[0]
    assert weighed[0] == pytest.approx(chain.weighed(by_states, *parameters.along(every)), rel=1e-5)
    assert found.matrix == pytest.approx(before, rel=1e-5)
    assert moved[0] == pytest.approx(exact, rel=1e-3, abs=1e-3 * abs(exact).max(axis=1).min())


@pytest.mark.filterwarnings("ignore:.*derivatives have")
def test_steps_that_do_not_suit_changes_and_small_derivatives_warn(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Both warnings of a run whose steps are stored, in several stretches."""
    monkeypatch.setattr(long_run, "FIRST", 40)
    system, given = pushed(4.0), {"until": 4.0, "method": sr.HHT(), "rtol": 1e-4}
    stored = sr.sensitivity(sr.simulate(system, store_steps=True, **given), "m.x", ["s.length"])
    found = sr.sensitivity_by_checkpoints(system, "m.x", ["s.length"], **given)
    for cause in ("not its changes by parameters", "errors of the states add up over the run"):
        assert any(cause in message for message in stored.warnings)
    assert found.warnings == stored.warnings


@pytest.mark.filterwarnings("ignore:.*derivatives have")
def test_errors_through_contacts(estimates: list[RelativeErrors]) -> None:
    system, given = thrown(), {"until": 0.9, "method": sr.HHT()}
    names = ["floor.stiffness", "floor.damping", "b.mass"]
    run = sr.simulate(system, store_steps=True, **given)
    found = sr.sensitivity_by_checkpoints(system, "b.z", names, **given)
    assert found.warnings == sr.sensitivity(run, "b.z", names).warnings != ()
    sr.sensitivity_by_checkpoints(system, "b.z", names[:1], **given)
    stored = sr.sensitivity(run, "b.z", names[:1], error=True)
    assert estimates[1].values == pytest.approx(stored.relative_errors, rel=1e-2)


@pytest.mark.one_in(6)
@pytest.mark.filterwarnings("ignore:.*derivatives have")
@pytest.mark.parametrize("events", ["none", "new velocities"])
@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau(), sr.GeneralizedAlpha(step=0.01)])
def test_errors_that_are_asked_for(method: Any, events: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of values, with the errors of samples, and of derivatives; in several stretches."""
    monkeypatch.setattr(long_run, "FIRST", 60)
    system = pendulum(1.2, 0.5)
    given = {"method": method, "rtol": 1e-5, "events": EVENTS[events], "until": 2.0}
    wanted = [*RESPONSES, sr.Peak("b.velocity.y"), sr.Peak("b.x", "smooth peak", sharpness=20.0)]
    stored = sr.sensitivity(sr.simulate(system, store_steps=True, **given), wanted, NAMES, error=True)
    found = sr.sensitivity_by_checkpoints(system, wanted, NAMES, error=True, **given)
    for one, other in zip(found.errors, stored.errors, strict=True):
        assert (one.response, one.value) == (other.response, pytest.approx(other.value, rel=1e-8))
        assert one.estimate == pytest.approx(other.estimate, rel=0.05, abs=0.01 * other.spread)
        assert one.spread == pytest.approx(other.spread, rel=0.05)
        assert one.round_off == pytest.approx(other.round_off, rel=0.05)
    assert found.relative_errors == pytest.approx(stored.relative_errors, rel=0.05)
    assert found.warnings == stored.warnings
