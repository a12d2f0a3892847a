"""The last output of a run is its last state, however it ends; against the free fall in closed form."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.dynamics.dense_output import sampler
from sarrus.analyses.dynamics.time_loop import recording, time_loop
from sarrus.functions import sqrt

G = 9.81
FLOOR = sr.Event("ball.z", direction=-1, terminal=True, name="floor")
STORES = [{}, {"store": "steps"}, {"store": "dense"}]


def falling(*forces: sr.Force) -> sr.System:
    return sr.System(sr.Model("drop", bodies=[BALL], forces=[*forces], gravity=(0, 0, -G)))


BALL = sr.Body("ball", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, 1.0))


def ends_in_its_last_state(run: sr.Trajectory) -> None:
    assert run.t[-1] == run.final.t
    assert np.all(np.diff(run.t) > 0)
    t = run.t[-1]
    assert run["ball.z"][-1] == pytest.approx(1 - G * t**2 / 2, abs=1e-9)
    assert run["ball.velocity.z"][-1] == pytest.approx(-G * t, abs=1e-8)
    assert np.asarray(run.kinetic_energy)[-1] == pytest.approx((G * t) ** 2 / 2, abs=1e-7)
    lengths = {
        len(getattr(run, n)) for n in ("t", "q", "v", "a", "lam", "violation", "memory", "revolutions")
    }
    assert lengths == {len(run.t)}


@pytest.mark.parametrize("times", [None, [0.0, 1.0, 2.0], [0.0, 0.1], [1.0], [np.sqrt(2 / G)]])
@pytest.mark.parametrize("store", STORES, ids=str)
def test_an_event_that_ends_the_run(times: list[float] | None, store: dict[str, str], tmp_path: Path) -> None:
    run = sr.simulate(falling(), until=2.0, events=FLOOR, t_eval=times, **store)
    plot, path = run.plot("ball.z").lines[0].get_xydata(), tmp_path / "ball.csv"
    run.to_csv(path, "ball.z")
    assert run.t[-1] == run.events[-1].t == pytest.approx(np.sqrt(2 / G), abs=1e-12)
    ends_in_its_last_state(run)
    assert np.array_equal(plot[-1], [run.t[-1], run["ball.z"][-1]])
    assert float(path.read_text().splitlines()[-1].split(",")[0]) == pytest.approx(run.t[-1], rel=1e-14)


def test_a_run_to_the_end_has_the_output_times_alone() -> None:
    assert sr.simulate(falling(), until=2.0, t_eval=[0.0, 0.5]).t.tolist() == [0.0, 0.5]


def test_a_force_that_fails_and_a_step_limit() -> None:
    root = sr.PointForce("thrust", BALL.point(0, 0, 0), (lambda t: 1e-15 * sqrt(0.5 - t), 0, 0))
    for run in (
        sr.simulate(falling(root), until=2.0, t_eval=[0.0, 2.0]),
        sr.simulate(
            falling(),
            until=2.0,
            t_eval=[0.0, 2.0],
            method=sr.Radau(max_step=0.01),
            limits=sr.Limits(steps=20),
        ),
    ):
        assert not run.success
        assert run.t[-1] > 0.1
        ends_in_its_last_state(run)


def stopped(t: float) -> None:
    if t > 0.3:
        raise KeyboardInterrupt


def late(t: float) -> None:
    if t > 0.3:
        raise time_loop.TimeLimit("the time limit of 1 s has passed")


@pytest.mark.parametrize("stop", [stopped, late])
@pytest.mark.parametrize("times", [None, [0.0, 1.0]])
def test_interrupted_runs_in_memory_and_in_a_folder(
    stop: Callable[[float], None], times: list[float] | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in (("PAUSE", 0.0), ("PATIENT", 0.0), ("WATCHED", 1), ("CHUNK", 1)):
        monkeypatch.setattr(time_loop if name in ("WATCHED", "CHUNK") else recording, name, value)
    given = {"until": 1.0, "method": sr.Radau(max_step=0.0137), "t_eval": times, "events": FLOOR}
    ends_in_its_last_state(sr.simulate(falling(), progress=stop, **given))
    cut = sr.simulate(falling(), progress=stop, save=tmp_path / "run", **given)
    again = sr.resume(tmp_path / "run", progress=stop)  # to its first step
    for run in (cut, again, sr.load_run(tmp_path / "run", falling())):
        assert run.status in ("stopped", "time limit")
        ends_in_its_last_state(run)
    plain, resumed = sr.simulate(falling(), **given), sr.resume(tmp_path / "run")
    for run in (resumed, sr.load_run(tmp_path / "run", falling())):
        ends_in_its_last_state(run)
        assert np.array_equal(run.t, plain.t)
        assert np.array_equal(np.asarray(run.a), plain.a)
    plain.save(tmp_path / "copy")
    ends_in_its_last_state(sr.load_run(tmp_path / "copy", falling()))


def unchanged(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return v


@pytest.mark.parametrize("stop", [stopped, late])
@pytest.mark.parametrize("events", [[], [sr.Event("ball.z - 0.4", name="low", reset=unchanged)]])
def test_runs_that_are_stopped_while_outputs_are_computed(
    stop: Callable[[float], None], events: list[sr.Event], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The outputs of the steps so far are those of the whole run; a run in a folder goes on to the same bits."""
    monkeypatch.setattr(sampler, "PORTION", 7)
    given = {"until": 0.4, "t_eval": np.linspace(0, 0.4, 401), "events": events, "store": "steps"}
    whole, cut = sr.simulate(falling(), **given), sr.simulate(falling(), progress=stop, **given)
    assert cut.status in ("stopped", "time limit")
    assert len(cut.t) > 300
    ends_in_its_last_state(cut)
    for name in ("t", "q", "v", "a", "kinetic_energy", "potential_energy"):
        assert np.array_equal(getattr(cut, name)[:-1], getattr(whole, name)[: len(cut.t) - 1])
    assert cut.steps.t[-1] == cut.t[-1]
    assert sr.simulate(falling(), save=tmp_path / "run", progress=stop, **given).status == cut.status
    resumed = sr.resume(tmp_path / "run", events=events)
    for name in ("t", "q", "v", "a", "kinetic_energy"):
        assert np.array_equal(np.asarray(getattr(resumed, name)), getattr(whole, name))


def test_a_study_of_runs_that_events_end_and_a_sequence_of_runs() -> None:
    first = sr.simulate(falling(), until=2.0, events=sr.Event("ball.z - 0.5", terminal=True))
    second = sr.simulate(falling(), first.final, until=2.0, events=FLOOR)
    assert second.t[0] == first.t[-1]
    ends_in_its_last_state(second)
    model = sr.Model("drop", bodies=[BALL], gravity=(0, 0, -G))
    table = sr.study(
        model, {"gravity.z": [-G, -2 * G]}, {"end": "final(ball.z)", "speed": "final(ball.velocity.z)"},
        analysis=lambda system: sr.simulate(system, until=2.0, events=FLOOR), workers=1,
    )  # fmt: skip
    assert np.allclose(table["end"], 0, atol=1e-12)
    assert np.allclose(table["speed"], [-np.sqrt(2 * G), -2 * np.sqrt(G)], atol=1e-9)
