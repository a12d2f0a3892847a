"""Runs that are saved as they go, killed, gone on with, repeated and read."""

import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.time_loop import recording
from sarrus.analyses.dynamics.time_loop import time_loop as march
from sarrus.results.saving.saved import checkpoint

METHODS = {"HHT": sr.HHT(), "Radau": sr.Radau(), "ODE": sr.ODE()}
TIMES = np.linspace(0, 20, 5001)


def options(method: str, rtol: float = 1e-9) -> dict:
    return {"until": 20.0, "t_eval": TIMES, "method": replace(METHODS[method], rtol=rtol, atol=1e-11)}


@pytest.mark.parametrize("method", METHODS)
def test_a_saved_run_is_the_run(method: str, tmp_path: Path) -> None:
    given = {**options(method, 1e-6), "until": 1.0, "t_eval": np.linspace(0, 1, 333)}
    plain = sr.simulate(slider_crank(), **given)
    sr.simulate(slider_crank(), save=tmp_path / "run.sarrus", **given)
    saved = sr.load_run(tmp_path / "run.sarrus")
    for name in ("t", "q", "v", "a", "lam", "violation", "velocity_violation", "kinetic_energy", "history"):
        assert np.array_equal(np.asarray(getattr(saved, name)), getattr(plain, name), equal_nan=True), name
    assert (saved.status, saved.nsteps, saved.nfev, saved.njev) == (
        "finished",
        plain.nsteps,
        plain.nfev,
        plain.njev,
    )
    assert np.array_equal(saved["slider"].position, plain["slider"].position)
    joint = next(iter(plain.system.rows))
    assert np.array_equal(saved.reaction(joint).force, plain.reaction(joint).force)
    again = sr.repeat(tmp_path / "run.sarrus")
    assert np.array_equal(again.q, plain.q)


def slowly(t: float) -> None:
    """Leave the parent time to see how far the run has come."""
    time.sleep(0.05)


CHILD = """
import sys
import tests.analyses.test_saving as here
import sarrus as sr
here.recording.PAUSE = here.recording.PATIENT = 0.0
sr.simulate(here.slider_crank(), save=sys.argv[2], progress=here.slowly, **here.options(sys.argv[1]))
"""


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_a_killed_run_is_gone_on_with_to_the_same_bits(method: str, tmp_path: Path) -> None:
    folder = tmp_path / "run.sarrus"
    child = subprocess.Popen(
        [sys.executable, "-c", CHILD, method, str(folder)], cwd=Path(__file__).parents[2]
    )
    try:
        until = time.monotonic() + 120
        while not _has_come_far(folder) and time.monotonic() < until and child.poll() is None:
            time.sleep(0.01)
    finally:
        child.kill()
        child.wait()
    cut = sr.load_run(folder)
    assert cut.status == "cut short"
    assert 0 < len(cut.t) < len(TIMES)
    plain = sr.simulate(slider_crank(), **options(method))
    assert np.array_equal(np.asarray(cut.q)[:-1], plain.q[: len(cut.t) - 1])
    resumed = sr.resume(folder)
    assert resumed.success, resumed.message
    for name in ("t", "q", "v", "a", "lam", "history"):
        assert np.array_equal(np.asarray(getattr(resumed, name)), getattr(plain, name), equal_nan=True), name
    assert (resumed.nsteps, resumed.nfev, resumed.njev) == (plain.nsteps, plain.nfev, plain.njev)


def _has_come_far(folder: Path) -> bool:
    try:
        return int(checkpoint(folder)["record._written"]) > 0
    except (FileNotFoundError, KeyError):
        return False


@pytest.mark.slow
def test_a_run_that_was_stopped_is_gone_on_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "PAUSE", 0.0)
    monkeypatch.setattr(recording, "PATIENT", 0.0)

    def stop(t: float) -> None:
        if t > 5.0:
            raise KeyboardInterrupt

    floor = sr.Event("slider.x - 4.0", name="middle")
    given = {**options("HHT", 1e-5), "events": floor}
    cut = sr.simulate(slider_crank(), save=tmp_path / "r", progress=stop, **given)
    assert cut.status == "stopped"
    assert 4.0 < cut.t[-1] < 20
    resumed, plain = sr.resume(tmp_path / "r"), sr.simulate(slider_crank(), **given)
    assert np.array_equal(np.asarray(resumed.q), plain.q)
    assert [e.t for e in resumed.events] == [e.t for e in plain.events]
    assert len(plain.events) > len(cut.events) > 0


def _in_parts(
    folder: Path, monkeypatch: pytest.MonkeyPatch, system: sr.System, after: float, **given: object
) -> sr.Trajectory:
    """A run that is stopped after a time, and gone on with."""
    for name, value in (("PAUSE", 0.0), ("PATIENT", 0.0), ("WATCHED", 1)):
        monkeypatch.setattr(march if name == "WATCHED" else recording, name, value)

    def stop(t: float) -> None:
        if t > after:
            raise KeyboardInterrupt

    assert sr.simulate(system, save=folder, progress=stop, **given).status == "stopped"
    return sr.resume(folder)


def test_turns_of_an_events_angle_are_gone_on_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wound = sr.Event("pin.angle^2 + 20*slider.x - 98", direction=-1, terminal=True)
    given = {"until": 3.0, "t_eval": [0.0], "events": wound, "method": sr.Radau(rtol=1e-4)}
    plain = sr.simulate(slider_crank(), **given)
    resumed = _in_parts(tmp_path / "r", monkeypatch, slider_crank(), 1.2, **given)
    assert resumed.status == plain.status == "event"
    assert [e.t for e in resumed.events] == [e.t for e in plain.events]


def test_a_run_that_is_stopped_as_an_event_ends_it_ends_there_when_gone_on_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = {"until": 3.0, "t_eval": [0.0, 3.0], "events": sr.Event("slider.x - 4.1", terminal=True)}
    plain = sr.simulate(slider_crank(), **given)
    assert plain.status == "event"
    resumed = _in_parts(tmp_path / "r", monkeypatch, slider_crank(), plain.events[0].t - 1e-9, **given)
    assert resumed.status == "event"
    assert [e.t for e in resumed.events] == [e.t for e in plain.events]


def test_events_at_the_same_time_happen_once_when_gone_on_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    balls = [sr.Body(n, mass=1, inertia=(1, 1, 1), position=(x, 0, 1)) for x, n in enumerate(("one", "two"))]
    floor = [sr.Event(f"{b.name}.z", reset=sr.Impact(0.8)) for b in balls]
    system = sr.System(sr.Model("balls", bodies=balls, gravity=(0, 0, -9.81)))
    given = {"until": 0.6, "t_eval": [0.6], "events": floor}
    plain = sr.simulate(system, **given)
    resumed = _in_parts(tmp_path / "r", monkeypatch, system, 0.4, **given)
    assert [(e.name, e.t) for e in resumed.events] == [(e.name, e.t) for e in plain.events]
    assert len(plain.events) == 2


def test_arrays_are_read_by_what_is_indexed(tmp_path: Path) -> None:
    run = sr.simulate(slider_crank(), until=1.0, save=tmp_path / "r", t_eval=np.linspace(0, 1, 101))
    q = np.asarray(run.q)
    for key in (
        5,
        -1,
        slice(3, 60, 7),
        (slice(None), 2),
        (slice(90, None), slice(0, 3)),
        (7, 3),
        [3, 4],
        slice(5, 0, -1),
    ):
        assert np.array_equal(run.q[key], q[key]), key
    assert run.q.shape == q.shape == (101, 21)


def test_the_folder_describes_itself(tmp_path: Path) -> None:
    sr.simulate(slider_crank(), until=0.1, save=tmp_path / "r", t_eval=[0.0, 0.1])
    about = json.loads((tmp_path / "r" / "zarr.json").read_text())["attributes"]
    assert about["bodies"] == list(slider_crank().bodies)
    assert {"sarrus", "numpy", "numba", "python", "method", "until"} <= set(about)
    axes = json.loads((tmp_path / "r" / "q" / "zarr.json").read_text())["dimension_names"]
    assert axes == ["time", "coordinate"]


def test_what_cannot_be_saved_is_told(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("irreplaceable")
    with pytest.raises(FileExistsError, match="is there and is no saved run"):
        sr.simulate(slider_crank(), until=1.0, save=tmp_path / "mine")
    with pytest.raises(FileNotFoundError):
        sr.load_run(tmp_path / "none")
    sr.simulate(slider_crank(), until=0.1, save=tmp_path / "r", events=sr.Event(lambda t, q, v: t - 1))
    with pytest.raises(ValueError, match="does not contain <lambda> of its events"):
        sr.resume(tmp_path / "r")


@pytest.mark.parametrize("method", ["HHT", "Radau"])
def test_the_whole_motion_and_the_steps_are_gone_on_with(
    method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A quarter of the steps, then the rest: derivatives and states between are those of a run in one go."""
    monkeypatch.setattr(recording, "PAUSE", 0.0)
    monkeypatch.setattr(recording, "PATIENT", 0.0)
    monkeypatch.setattr(march, "CHUNK", 40)

    def stop(t: float) -> None:
        if t > 0.5:
            raise KeyboardInterrupt

    given = {
        "until": 2.0,
        "t_eval": [1.0, 2.0],
        "method": replace(METHODS[method], rtol=1e-7),
        "store": "steps",
    }
    plain, folder = sr.simulate(slider_crank(), **given), tmp_path / "r"
    assert sr.simulate(slider_crank(), save=folder, progress=stop, **given).status == "stopped"
    resumed, opened = sr.resume(folder), sr.resume(folder)
    cost = sr.At("slider.x", time=1.0)
    wanted = sr.sensitivity(plain, cost, wrt=["rod.mass"])["rod.mass"]
    for run in (resumed, opened):
        assert np.array_equal(run.sol(0.77).lam, plain.sol(0.77).lam)
        assert np.array_equal(run.steps.q, plain.steps.q)
        assert np.array_equal(sr.sensitivity(run, cost, wrt=["rod.mass"])["rod.mass"], wanted)
    assert len(plain.steps.t) > 70
