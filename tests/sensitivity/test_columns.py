"""Columns swept forward side by side are those of single ones, however many, and wherever pivots are renewed."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from tests.prescribed_steps import run_of
from tests.sensitivity.test_all_elements import KINDS, changes, even
from tests.sensitivity.test_events import STOP, pendulum
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.sensitivity.chain.chain import Nodes
from sarrus.analyses.sensitivity.run_chain import RunChain
from sarrus.analyses.sensitivity.steps import sweep
from sarrus.linalg.columns_loop import COLUMNS

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly

MANY = 2 * COLUMNS + 3  # no multiple of a panel


@cache
def swung() -> sr.Trajectory:
    """Twenty steps of the slider-crank."""
    settings = {"rtol": 1e-4, "atol": 1e-5, "store_steps": True, "given": np.full(20, 0.01)}
    return run_of(sr.HHT(), slider_crank(), sr.assemble(slider_crank()), np.array([0.0, 0.2]), **settings)


@cache
def everything() -> sr.Trajectory:
    """Twenty steps of a mechanism with all elements."""
    return even(1)


runs = pytest.mark.parametrize("run", [swung, pytest.param(everything, marks=pytest.mark.slow)])


@cache
def struck(method: sr.HHT | sr.Radau) -> sr.Trajectory:
    """A pendulum that hits a stop, again and again."""
    return sr.simulate(pendulum(), until=2.2, method=method, events=STOP, store="steps")


def random_nodes(run: sr.Trajectory, responses: int) -> Nodes:
    """Gradients of responses, half of them zero."""
    bars, random = Nodes.zeros(run.steps, responses), np.random.default_rng(7)
    for x in (bars.q, bars.v, bars.a, bars.lam, bars.shift):
        x[:] = random.normal(size=x.shape) * (random.random(x.shape) < 0.5)
    return bars


def moved(run: sr.Trajectory, columns: int) -> tuple[RunChain, list[np.ndarray]]:
    """The chain of a run, and random changes, some of which are nothing or touch a single number."""
    db, dq, dv = changes(run, columns)
    if columns > 2:
        db[:, 1], dq[:, 1], dv[:, 1] = 0, 0, 0
        db[np.arange(len(db)) != np.flatnonzero(db[:, 2])[5], 2] = 0
    return RunChain(run.system, run.steps), [db, dq, dv]


@pytest.mark.parametrize("columns", [2, COLUMNS, MANY])
@runs
def test_each_column_is_that_of_a_sweep_of_its_own(run: Callable[[], sr.Trajectory], columns: int) -> None:
    chain, every = moved(run(), columns)
    found = chain.along(*every)
    for c in {0, 1, 2, columns - 1} & set(range(columns)):
        own = chain.along(*(x[:, c : c + 1] for x in every))
        for kind, limit in zip(KINDS, (1e-14, 1e-11, 1e-9, 1e-9), strict=True):  # round-off over h and h²
            gap = abs(getattr(found, kind)[..., c] - getattr(own, kind)[..., 0])
            assert gap.max() <= limit * abs(getattr(own, kind)).max(), (c, kind)


@pytest.mark.slow
def test_so_it_is_with_radau() -> None:
    run = sr.simulate(even(2).system, until=0.05, method=sr.Radau(), store="steps")
    chain, every = moved(run, MANY)
    found = chain.along(*every)
    for c in (0, 1, MANY - 1):
        own = chain.along(*(x[:, c : c + 1] for x in every))
        for kind in KINDS:
            gap = abs(getattr(found, kind)[..., c] - getattr(own, kind)[..., 0])
            assert gap.max() <= 1e-9 * abs(getattr(own, kind)).max(), (c, kind)


@pytest.mark.parametrize("columns", [1, COLUMNS, MANY])
@pytest.mark.parametrize("responses", [1, 5])
@runs
def test_responses_change_as_the_states_that_are_kept_tell(
    run: Callable[[], sr.Trajectory], columns: int, responses: int
) -> None:
    (chain, every), bars = moved(run(), columns), random_nodes(run(), responses)
    wanted = bars.inner(chain.along(*every))
    assert abs(chain.weighed(bars, *every) - wanted).max() < 1e-13 * abs(wanted).max()


@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()])
def test_they_do_over_events(method: sr.HHT | sr.Radau) -> None:
    run = struck(method)
    assert len(run.steps.event_steps) > 1
    (chain, every), bars = moved(run, MANY), random_nodes(run, 2)
    wanted = bars.inner(chain.along(*every))
    assert abs(chain.weighed(bars, *every) - wanted).max() < 1e-10 * abs(wanted).max()


@pytest.mark.slow
def test_a_panel_that_made_its_step_waits_where_another_needs_new_pivots(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Solutions are trusted more and more, so that some panel is the first to fail."""
    run, done, choose = everything(), [], sweep.Sweep._choose_pivots
    (chain, every), bars = moved(run, MANY), random_nodes(run, 2)
    wanted = chain.weighed(bars, *every)

    def counted(self: sweep.Sweep, *args: object) -> object:
        done.append(int(self._work.done[0]))
        return choose(self, *args)

    monkeypatch.setattr(sweep.Sweep, "_choose_pivots", counted)
    for trusted in np.geomspace(1e-30, 1e-18, 30):
        monkeypatch.setattr(sweep, "TRUSTED", (trusted, 1e-3))
        assert abs(chain.weighed(bars, *every) - wanted).max() < 1e-9 * abs(wanted).max()
    assert {0, 1} <= set(done)
