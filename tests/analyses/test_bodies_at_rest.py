"""Velocities of bodies at rest are round-off, without digits of their own; values that are not finite are failures."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.test_large_systems import chain

import sarrus as sr
from sarrus.analyses.dynamics.dense_output import sample_loop
from sarrus.analyses.dynamics.dense_output import sampler as sampler_module
from sarrus.analyses.dynamics.dense_output.sample_loop import Samples
from sarrus.analyses.dynamics.dense_output.sampler import Sampler, samples_at
from sarrus.analyses.dynamics.time_loop import nearness
from sarrus.analyses.redundancy.redundant_constraints import Independence
from sarrus.functions import sqrt

SCALES = [1.0, 1e-10, 1e-26, 1e-100, 1e-200, 1e-300, 1e-310, 1e-320]
RESTING = replace(chain(10), gravity=(0, 0, 0))
FREE = sr.Model(
    "free", [sr.Body(f"b{k}", mass=1.0, inertia=(1, 2, 2.5), position=(k, 0.3, 0.7)) for k in range(4)]
)


@pytest.mark.parametrize("model", [RESTING, FREE], ids=lambda model: model.name)
@pytest.mark.parametrize(
    "method", [sr.Radau(), sr.HHT(), sr.ODE("DOP853")], ids=lambda one: type(one).__name__
)
def test_bodies_at_rest_have_no_accelerations(model: sr.Model, method: Any) -> None:
    """Positions are those of the start to round-off, of 1 m: so are velocities and accelerations."""
    run = sr.simulate(sr.System(model), until=1.0, method=method)
    assert run.success, run.message
    assert not run.warnings
    for found in (run.q - run.q[0], run.v, run.a, run.lam):
        assert abs(found).max(initial=0.0) < 1e-12


def against(system: sr.System) -> np.ndarray:
    """Rates with M v + Φ_qᵀσ = 0, Φ_q v = μ: the least change to Φ_q v = 0, in the metric of M, takes all of them."""
    M, G = system.M(system.q0).toarray(), system.Phi_q(system.q0, 0.0).toarray()
    right = np.append(np.zeros(system.nq), np.random.default_rng(1).normal(size=system.m))
    return np.linalg.solve(np.block([[M, G.T], [G, np.zeros((system.m, system.m))]]), right)[: system.nq]


def settled(system: sr.System, v: np.ndarray) -> Samples:
    """One state made consistent, which must be possible."""
    sampler = Sampler(system, Independence(system, system.q0), system.b)
    found = sampler.state_at(0.0, system.q0, v, np.zeros(0))
    assert not np.isinf(found.growth).any()
    return found


@pytest.mark.parametrize("model", [RESTING, FREE], ids=lambda model: model.name)
def test_velocities_against_all_constraints_vanish_whatever_their_size(model: sr.Model) -> None:
    system = sr.System(model)
    for scale in SCALES:
        found = settled(system, scale * against(system))
        assert np.all(np.isfinite(found.a))
        assert abs(found.v).max() <= max(1e-11 * scale, 1e-310)


@pytest.mark.slow
def test_such_velocities_are_corrected_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """And looked at once more: what is left, 1e-16 of them, is not corrected on and on, down to the smallest number."""
    looks = []

    def seen(*args: Any) -> Any:
        looks.append(args[-1])
        return correct(*args)

    correct = sample_loop.correct
    monkeypatch.setattr(sample_loop, "correct", seen)
    monkeypatch.setattr(sampler_module, "link", lambda function: function)
    system = sr.System(replace(chain(1), gravity=(0, 0, 0)))
    settled(system, 1e-26 * against(system))
    assert looks.count(1) == 2


@pytest.mark.filterwarnings("ignore:chain. assembly changed")
@pytest.mark.parametrize("scale", SCALES)
def test_velocities_of_any_size_are_assembled(scale: float) -> None:
    system = sr.System(RESTING)
    start = sr.assemble(system, v=scale * np.random.default_rng(1).normal(size=system.nq))
    assert start.success, start.message
    assert abs(system.Phi_q(start.q) @ start.v).max() < 1e-12 * scale + 1e-320


@pytest.mark.parametrize("scale", SCALES)
def test_a_start_may_be_ever_so_slow(scale: float) -> None:
    system = sr.System(FREE)
    v = np.zeros(system.nq)
    v[:3] = 1.0, -2.0, 3.0
    run = sr.simulate(system, sr.assemble(system, v=scale * v), until=1.0)
    assert run.success, run.message
    assert np.allclose(run.v, scale * v, rtol=1e-6, atol=1e-12)  # round-off of positions over a step


@pytest.mark.parametrize("saved", [False, True], ids=["in memory", "saved"])
def test_values_that_are_not_finite_are_warned_of_where_they_are_computed(
    saved: bool, tmp_path: Path
) -> None:
    """A force that is no number within 1 ns around an output time, where no step ends."""
    ball = sr.Body("ball", mass=1.0, inertia=(1, 1, 1))
    root = sr.PointForce("thrust", ball.point(0, 0, 0), (0, 0, lambda t: sqrt((t - 0.5) ** 2 - 1e-18)))
    system = sr.System(sr.Model("falling", [ball], forces=[root]))
    save = tmp_path / "r" if saved else None
    with pytest.warns(sr.SarrusWarning, match="not finite at 1 of the output times, the first t = 0.5 s"):
        run = (found := sr.simulate(system, until=1.0, save=save)) and found.at(found.t)
    assert np.flatnonzero(np.isnan(run.a).any(axis=1)).tolist() == [500]
    for one in (run, sr.load_run(tmp_path / "r", system)) if saved else (run,):
        assert "not finite at 1 of the output times" in one.warnings[0]
    assert sr.simulate(system, until=1.0, t_eval=[0.3, 0.7]).success


@pytest.mark.parametrize(("rows", "undefined"), [(["pin.x"], [5.0]), ([], [2.0, 3.0, 5.0])])
def test_a_singular_configuration_explains_only_the_states_near_it(
    rows: list[str], undefined: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """An approach, at 2 and 3 s, goes on from one portion of the output times to the next, and in a continued run."""
    monkeypatch.setattr(nearness, "redundant_rows", lambda *_: rows)
    system = sr.System(FREE)
    first = Independence(system, system.q0)
    watch = nearness.Nearness(system, first)
    for times in ([0.0, 1.0, 2.0], [3.0, 4.0, 5.0]):
        samples = samples_at(system, np.array(times))
        samples.growth[:] = [np.inf if t in (2.0, 3.0) else 1.0 for t in times]
        samples.a[np.isin(times, (2.0, 3.0, 5.0))] = np.nan
        watch.look(samples)
        state, watch = watch.state(), nearness.Nearness(system, first)
        watch.resume(state)
    assert bool(watch.message()) == bool(rows)
    assert sorted(watch.undefined) == undefined
    assert (
        f"at {len(undefined)} of the output times, the first t = {undefined[0]:g} s"
        in watch.undefined_message()
    )
