"""Outputs of a run are computed when somebody looks at them, with the bits of a run that is looked at at once."""

import copy
import pickle
import tracemalloc
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.analyses.linkages import Z, chain, door

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.dynamics.dense_output import sampler
from sarrus.functions import sqrt
from sarrus.results.motion.trajectory import COLUMNS, COMPUTED, ENERGIES, LAST

G = 9.81
POSITIONS = set(COMPUTED) - {*LAST, "revolutions", "final"}  # what positions of bodies need


def four_bar() -> sr.System:
    return chain("four-bar", np.array([[0, 0, 0], [0, 1, 0], [3, 1.5, 0], [3, 0, 0.0]]), np.tile(Z, (4, 1)))


def bouncing() -> tuple[sr.System, dict[str, Any]]:
    ball = sr.Body("ball", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, 1))
    floor = sr.Event("ball.z", name="floor", direction=-1, reset=sr.Impact(0.8))
    return sr.System(sr.Model("bouncing", bodies=[ball], gravity=(0, 0, -G))), {"events": floor}


CASES: dict[str, Callable[[], tuple[sr.System, dict[str, Any]]]] = {
    "loop": lambda: (four_bar(), {}),
    "redundant": lambda: (door(), {}),
    "impacts": bouncing,
    "order two": lambda: (four_bar(), {"method": sr.HHT()}),
    "ode": lambda: (four_bar(), {"method": sr.ODE()}),
    "ended": lambda: (four_bar(), {"events": sr.Event("t - 0.41", terminal=True)}),
    "stopped": lambda: (four_bar(), {"limits": sr.Limits(steps=20)}),
    "few outputs": lambda: (four_bar(), {"t_eval": [0.3, 1.0], "method": sr.Radau(max_step=1e-3)}),
}


def computed(run: sr.Trajectory) -> set[str]:
    return set(COMPUTED) & set(vars(run))


def same(run: sr.Trajectory, other: sr.Trajectory) -> bool:
    arrays = all(np.array_equal(getattr(run, name), getattr(other, name)) for name in COLUMNS)
    return arrays and (run.message, run.singular, run.warnings) == (
        other.message,
        other.singular,
        other.warnings,
    )


@pytest.mark.parametrize("case", CASES)
def test_outputs_have_the_same_bits_in_whatever_order_one_looks(case: str) -> None:
    system, options = CASES[case]()
    runs = [sr.simulate(system, until=1.0, **options) for _ in range(4)]
    assert computed(runs[0]) == set()
    assert len(runs[0].a) == len(runs[0].t)  # all at once
    assert computed(runs[0]) == set(COMPUTED)
    assert np.array_equal(runs[1].v, runs[0].v)
    assert computed(runs[1]) == POSITIONS
    with pytest.raises(ValueError, match="read-only"):
        runs[2].q[:] = 0.0
    assert np.array_equal(runs[2].lam, runs[0].lam)
    assert np.array_equal(runs[2].q, runs[0].q)
    assert same(runs[1], runs[0])
    assert runs[3].final is not None
    assert runs[0].final is not None
    assert np.array_equal(runs[3].final.q, runs[0].final.q)


@pytest.mark.parametrize("loose", [False, True])
def test_many_outputs_within_a_step_are_those_of_few(loose: bool) -> None:
    """Interpolated between projected states where that is as accurate, otherwise projected one by one."""
    system = sr.System(sr.load(mechanisms.path("slider_crank")))
    times, method = np.linspace(0.0, 2.0, 3001), sr.Radau(rtol=0.1, atol=0.1) if loose else sr.Radau()
    many, few = (sr.simulate(system, until=2.0, t_eval=t, method=method) for t in (times, times[::30]))
    for name in ("q", "v", "a"):
        wanted = getattr(few, name)
        assert getattr(many, name)[::30] == pytest.approx(wanted, abs=1e-11 * abs(wanted).max())
    assert max(many.violation.max(), few.violation.max()) < 1e-11
    assert max(many.velocity_violation.max(), few.velocity_violation.max()) < 1e-11
    one_by_one = np.all(many.q[::30] == few.q, axis=1).mean()
    assert (one_by_one > 0.9) == loose


def test_positions_and_what_is_made_of_them_need_no_accelerations() -> None:
    run = sr.simulate(four_bar(), until=1.0)
    for look in (lambda: run["rod_1"].position, lambda: run["rod_1.x"]):
        assert len(np.shape(look())) <= 2
        assert computed(run) == POSITIONS
    for look in (lambda: run["rod_2.velocity.x"], lambda: run["hinge_1.angle"],
                 lambda: run.output("rod_1.x*rod_2.x", rate=False), lambda: run.joint("hinge_1").angle):  # fmt: skip
        assert len(np.shape(look())) <= 2
        assert computed(run) == POSITIONS | {"revolutions"}
    assert run["rod_1"].acceleration.shape == (1001, 3)
    assert computed(run) == set(COMPUTED)


@pytest.mark.parametrize("looked", [None, "q", "a"])
@pytest.mark.parametrize("other", [copy.copy, copy.deepcopy, lambda run: pickle.loads(pickle.dumps(run))])
def test_copies_and_pickles_have_all_outputs(other: Callable[[Any], Any], looked: str | None) -> None:
    system = four_bar()
    whole, run = sr.simulate(system, until=1.0), sr.simulate(system, until=1.0)
    if looked:
        getattr(run, looked)
    copied = other(run)
    assert computed(copied) == set(COMPUTED)
    assert same(copied, whole)
    assert same(run, whole)


def test_a_run_that_is_an_argument_is_not_looked_at() -> None:
    run = sr.simulate(four_bar(), until=1.0, store="steps")
    assert sr.sensitivity(run, sr.Final("rod_1.x"), ["rod_1.mass"]).values.shape == (1,)
    assert run.error(sr.Final("rod_1.x")) is not None
    assert not computed(run)
    with pytest.raises(AttributeError, match="no attribute 'qq'"):
        getattr(run, "qq")  # noqa: B009
    assert not computed(run)


def test_a_saved_run_has_the_same_bits(tmp_path: Path) -> None:
    system = four_bar()
    run, saved = sr.simulate(system, until=1.0), sr.simulate(system, until=1.0, save=tmp_path / "run")
    assert computed(saved) == set(COMPUTED)
    run.save(tmp_path / "later")
    for one in (saved, sr.load_run(tmp_path / "later", system)):
        assert all(np.array_equal(getattr(one, name), getattr(run, name)) for name in COLUMNS)


def test_two_threads_look_at_a_run() -> None:
    system = four_bar()
    whole = sr.simulate(system, until=1.0).lam
    for _ in range(5):
        run = sr.simulate(system, until=1.0)
        with ThreadPoolExecutor(4) as pool:
            found = list(pool.map(lambda name, run=run: getattr(run, name), ("q", "lam", "v", "message")))
        assert np.array_equal(found[1], whole)
        assert len(found[0]) == len(found[2]) == len(run.t)


@pytest.mark.parametrize("looked", [None, "q"])
def test_a_look_may_be_interrupted(looked: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    system, options = CASES["redundant"]()
    whole, run = sr.simulate(system, until=1.0, **options), sr.simulate(system, until=1.0, **options)
    if looked:
        getattr(run, looked)
    with monkeypatch.context() as patch:

        def interrupted(*_: Any) -> Any:
            raise KeyboardInterrupt

        patch.setattr(sampler.Sampler, "energies", interrupted)
        with pytest.raises(KeyboardInterrupt):
            run.a  # noqa: B018
    assert same(run, whole)


def test_steps_that_wait_need_little_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a run of many steps for each output few wait, and ten times as many steps need no more memory."""
    ball = sr.Body("ball", mass=1.0, inertia=(1, 1, 1), angular_velocity=(1, 2, 3))
    system, peaks = sr.System(sr.Model("ball", bodies=[ball])), []
    for steps in (2_000, 20_000):
        tracemalloc.start()
        run = sr.simulate(
            system, until=steps * 1e-3, method=sr.Radau(max_step=1e-3), t_eval=[0.0, steps * 1e-3]
        )
        peaks.append(tracemalloc.get_traced_memory()[1] - run.history.nbytes)
        tracemalloc.stop()
        assert run.nsteps >= steps
    assert peaks[1] < peaks[0] + 20_000 * 5 * 8  # the history once more, where its parts are joined


def test_what_is_needed_for_outputs_goes_with_them() -> None:
    run = sr.simulate(four_bar(), until=1.0)
    assert run._later is not None
    assert run.message.startswith("reached the end")
    assert run._later is None


def push(t: float) -> float:
    return sqrt((t - 0.5) ** 2 - 1e-18)


def thrown() -> sr.System:
    """A load that is not a number at an output time, and finite at all steps."""
    ball = sr.Body("ball", mass=1.0, inertia=(1, 1, 1))
    thrust = sr.PointForce("thrust", ball.point(0, 0, 0), (0, 0, push))
    return sr.System(sr.Model("thrown", bodies=[ball], forces=[thrust]))


def test_a_warning_about_outputs_is_issued_once_at_the_line_that_looks() -> None:
    run = sr.simulate(thrown(), until=1.0)
    other = run.changed(call=None)
    with pytest.warns(sr.SarrusWarning, match="not finite") as told:
        str(run)
    assert [one.filename for one in told] == [__file__]
    assert len(run.warnings) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert other.a is run.a
        assert other.warnings == run.warnings


@pytest.mark.filterwarnings("ignore:invalid value")
def test_an_analysis_does_not_report_the_warnings_of_the_run_that_it_is_given() -> None:
    run = sr.simulate(thrown(), until=1.0)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", sr.SarrusWarning)
        with sr.strict():
            sr.verify(run, "ball.z")
        assert np.isnan(run.a).any()
    assert any("not finite" in str(one.message) for one in told)
    assert len(run.warnings) == 1


def test_a_run_can_be_read_where_warnings_are_errors() -> None:
    run = sr.simulate(thrown(), until=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(sr.SarrusWarning, match="not finite"):
            run.a  # noqa: B018
        assert np.isnan(run.a).any()
        assert len(pickle.loads(pickle.dumps(run)).warnings) == 1


def test_strict_runs_compute_their_outputs() -> None:
    with pytest.raises(sr.StrictError, match="not finite"), sr.strict():
        sr.simulate(thrown(), until=1.0)


def test_fields_that_wait_are_listed_and_may_be_replaced() -> None:
    run = sr.simulate(four_bar(), until=1.0)
    assert set(COMPUTED) < set(dir(run))
    assert not computed(run)
    zeros = dict.fromkeys(("q", "v", "a", "lam"), np.zeros(3)) | {"message": "mine", "singular": ()}
    changed = replace(run, **zeros, **dict.fromkeys(ENERGIES, np.zeros(3)))
    assert (changed.message, changed.q.shape) == ("mine", (3,))


def test_positions_that_were_looked_at_are_stored_twice_at_most() -> None:
    run = sr.simulate(four_bar(), until=1.0, t_eval=np.linspace(0, 1, 20_001))
    tracemalloc.start()
    own = sum(getattr(run, name).nbytes for name in set(COLUMNS[1:]) - set(LAST))
    assert tracemalloc.get_traced_memory()[0] < 2.1 * own
    tracemalloc.stop()


def test_an_error_within_late_outputs_is_not_reported_as_a_missing_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run = sr.simulate(four_bar(), until=1.0)
    monkeypatch.delattr(sampler.Sampler, "fill")
    with pytest.raises(RuntimeError, match=r": q could not be computed: .*has no attribute 'fill'"):
        run.q.sum()
