"""Derivatives of runs with Radau: forward, backward, differences with the same steps, references."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.prescribed_steps import run_of
from tests.sensitivity.designs import SUNDIALS, sundials, sundials_crank
from tests.sensitivity.frozen import differenced, solved
from tests.sensitivity.test_all_elements import KINDS, changes, disagreement
from tests.sensitivity.test_gradients import RESPONSES
from tests.sensitivity.zoo import zoo
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.sensitivity.run_chain import RunChain
from sarrus.analyses.sensitivity.steps.matrix import OperationMatrix
from sarrus.analyses.sensitivity.steps.record import STEP, Occurrences, Record
from sarrus.analyses.sensitivity.steps.sweep import ORDERS, Sweep
from sarrus.model.written import with_numbers

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly

FOLDER = Path(__file__).parent.parent / "reference"
EXAMPLES = Path(__file__).parents[2] / "examples"
NAMES = [
    "rod.inertia.yy",
    "spring.c",
    "spring.length",
    "pin.point.y",
    "crank.angular_velocity.x",
    "gravity.z",
]


@cache
def swung() -> sr.Trajectory:
    run = sr.simulate(
        slider_crank(), until=0.8, t_eval=[0.8], method=sr.Radau(rtol=2.6e-6, atol=1e-8), store="steps"
    )
    return solved(run, sr.Radau())


@cache
def adjoint() -> sr.Gradient:
    return sr.sensitivity(swung(), RESPONSES)


def test_forward_and_backward_agree_for_every_number_of_the_model() -> None:
    direct = sr.sensitivity(swung(), RESPONSES, method="direct")
    scale = abs(direct.matrix).max(axis=1, keepdims=True)
    assert np.all(scale > 0)
    assert abs(direct.matrix - adjoint().matrix).max() < 1e-8
    assert np.all(abs(direct.matrix - adjoint().matrix) < 1e-11 * scale)


def test_gradients_of_coarse_runs_are_those_of_the_very_number_too() -> None:
    """However large the tolerances are."""
    run = solved(
        sr.simulate(
            slider_crank(),
            until=0.8,
            t_eval=[0.8],
            method=sr.Radau(rtol=1e-2, atol=1e-3, max_step=0.05),
            store="steps",
        ),
        sr.Radau(),
    )
    found, name = sr.sensitivity(run, RESPONSES), "rod.inertia.yy"
    scale = np.maximum(abs(found.matrix).max(axis=1), 1e-3)
    assert np.all(abs(found[name] - differenced(run, RESPONSES, name, 2e-3, sr.Radau())) < 1e-9 * scale)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", NAMES)
def test_gradients_are_those_of_differenced_simulations(name: str) -> None:
    wanted = differenced(swung(), RESPONSES, name, 2e-3, sr.Radau())
    scale = np.maximum(abs(adjoint().matrix).max(axis=1), 1e-3)
    assert np.all(abs(adjoint()[name] - wanted) < 1e-9 * scale)


@cache
def zoo_run() -> sr.Trajectory:
    return solved(
        run_of(
            sr.Radau(),
            zoo(),
            sr.assemble(zoo()),
            np.array([0.0, 0.1]),
            rtol=1e-5,
            atol=1e-6,
            store_steps=True,
        ),
        sr.Radau(),
    )


@pytest.mark.slow
def test_forward_and_backward_agree_for_every_number_of_every_element() -> None:
    assert disagreement(zoo_run(), KINDS) < 1e-10


@pytest.mark.slow
def test_derivatives_of_every_element_are_those_of_differenced_simulations() -> None:
    system, steps = zoo(), zoo_run().steps
    db, dq, dv = changes(zoo_run(), 1)
    found, start = RunChain(system, steps).along(db, dq, dv), steps.start

    def moved(e: float) -> object:
        other = sr.System(with_numbers(system.model, {}))
        other.b[:] = system.b + e * db[:, 0]
        begin = sr.assemble(other, start.asked.q + e * dq[:, 0], start.asked.v + e * dv[:, 0])
        settings = {"rtol": steps.rtol, "atol": steps.atol, "store_steps": True, "given": steps.h}
        return run_of(sr.Radau(), other, begin, np.array([0.0, 0.1]), **settings).steps

    e = 2e-4
    ends = {d: moved(d) for d in (e, -e, e / 2, -e / 2)}
    for kind in KINDS:
        coarse, fine = ((getattr(ends[d], kind) - getattr(ends[-d], kind)) / (2 * d) for d in (e, e / 2))
        wanted = (4 * fine - coarse) / 3
        assert abs(getattr(found, kind)[:, :, 0] - wanted).max() < 1e-7 * abs(wanted).max(), kind


def test_a_linkage_with_equations_that_others_imply() -> None:
    system = sr.System(sr.load(EXAMPLES / "bricard.yaml"))
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-6, atol=1e-7)}
    run = sr.simulate(system, until=0.5, t_eval=[0.5], **settings)
    assert np.any(run.steps.left_out)
    responses = [sr.Final("rod_1.x"), sr.Integral("energy.kinetic"), sr.At("rod_1.acceleration.z", time=0.3)]
    direct, back = (sr.sensitivity(run, responses, method=way) for way in ("direct", "adjoint"))
    scale = np.nanmax(abs(direct.matrix))  # numbers that would close the linkage otherwise have no derivative
    assert np.allclose(direct.matrix, back.matrix, rtol=0, atol=1e-11 * scale, equal_nan=True)
    assert np.all(np.isfinite(back["rod_1.mass"]))
    assert np.allclose(
        back["rod_1.mass"], differenced(run, responses, "rod_1.mass", 1e-3, sr.Radau()), rtol=1e-7
    )


def test_gradients_approach_those_of_continuous_time_at_order_five() -> None:
    system = slider_crank()
    names, until = ["spring.k", "crank.mass", "crank.angular_velocity.x"], 0.4

    def at(count: int) -> np.ndarray:
        lengths = np.full(count, until / count)
        settings = {"rtol": 1e-9, "atol": 1e-9, "store_steps": True, "given": lengths}
        run = run_of(sr.Radau(), system, sr.assemble(system), np.array([0.0, until]), **settings)
        return sr.sensitivity(run, ["slider.x", "slider.velocity.x"], names).matrix

    exact = at(160)
    errors = [abs(at(count) - exact).max() for count in (10, 20, 40)]
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(abs(slopes - 5) < 0.5), (errors, slopes)


def test_the_published_slider_crank_of_sundials_to_many_digits() -> None:
    told = json.loads((FOLDER / "S04_sundials_slider_crank.json").read_text())
    names, responses = list(SUNDIALS), {"x2_T": sr.Final("slider.x"), "w_T": sr.Final("bearing.angle.rate")}
    wanted = np.array([[told["grad"][name][parameter] for parameter in names] for name in responses])
    errors = []
    for rtol in (1e-7, 1e-9, 1e-11):
        settings = {"store": "steps", "method": sr.Radau(rtol=rtol, atol=rtol)}
        run = sr.simulate(sundials_crank(), until=10.0, t_eval=[10.0], **settings)
        found = sr.sensitivity(run, list(responses.values()), names, design=SUNDIALS, formula=sundials)
        errors.append(abs(found.matrix - wanted).max() / abs(wanted).max())
    assert errors[0] > 5 * errors[1] > 25 * errors[2], errors
    assert errors[2] < 2e-9, errors


def test_the_pivots_of_one_stage_serve_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where one of them is zero there is an order of their own, with the same derivatives."""
    wanted = sr.sensitivity(swung(), sr.Final("slider.x"))
    monkeypatch.setattr(OperationMatrix, "_in_order_of_one", lambda self: None)
    monkeypatch.delitem(ORDERS, swung().steps)
    found = sr.sensitivity(swung(), sr.Final("slider.x"))
    assert not np.array_equal(found.matrix, wanted.matrix)
    assert found.matrix == pytest.approx(wanted.matrix, abs=1e-12 * abs(wanted.matrix).max())


def test_the_factors_of_the_vehicle_are_few(monkeypatch: pytest.MonkeyPatch) -> None:
    system = sr.System(sr.load(mechanisms.path("hmmwv")))
    run = sr.simulate(system, until=0.01, method=sr.Radau(), store="steps")
    sweep = Sweep(Record(system, run.steps), 1)

    def factors(operation: Occurrences) -> int:
        return len(sweep._pivots(STEP, operation, 0).pattern.rows)

    record = sweep.record
    few = [factors(one) for one in (record.operations[STEP], record.typical()[STEP][0])]
    monkeypatch.setattr(OperationMatrix, "_in_order_of_one", lambda self: None)
    assert max(few) < 0.5 * factors(record.operations[STEP])
