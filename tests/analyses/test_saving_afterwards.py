"""Runs that are saved after their end, by `run.save`."""

from pathlib import Path

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr

STORED = (
    "t",
    "q",
    "v",
    "a",
    "lam",
    "violation",
    "velocity_violation",
    "kinetic_energy",
    "history",
    "revolutions",
)


def test_a_run_is_read_as_it_was(tmp_path: Path) -> None:
    floor = sr.Event("slider.x - 4.5", name="gate")
    run = sr.simulate(slider_crank(), until=1.0, events=floor)
    assert run.events
    run.save(tmp_path / "run.sarrus")
    again = sr.load_run(tmp_path / "run.sarrus")
    for name in STORED:
        assert np.array_equal(np.asarray(getattr(again, name)), getattr(run, name)), name
    assert [(one.name, one.t) for one in again.events] == [(one.name, one.t) for one in run.events]
    assert (again.message, again.nsteps, again.status) == (run.message, run.nsteps, run.status)
    assert np.array_equal(again["spring.tension"], run["spring.tension"])
    on = sr.simulate(slider_crank(), {"run": str(tmp_path / "run.sarrus")}, until=1.2)
    assert on.t[0] == 1.0
    assert np.array_equal(on.q[0], run.final.q)


def test_what_it_does_not_contain_is_refused(tmp_path: Path) -> None:
    run = sr.simulate(slider_crank(), until=0.1)
    run.save(tmp_path / "run.sarrus")
    for use in (sr.resume, sr.repeat):
        with pytest.raises(ValueError, match=r"saved after the run"):
            use(tmp_path / "run.sarrus")
    with pytest.raises(FileExistsError, match=r"finished run.*overwrite=True"):
        run.save(tmp_path / "run.sarrus")
    run.save(tmp_path / "run.sarrus", overwrite=True)
    sr.load_run(tmp_path / "run.sarrus").save(tmp_path / "other.sarrus")
    assert np.array_equal(sr.load_run(tmp_path / "other.sarrus")["spring.tension"], run["spring.tension"])


def test_arrays_of_a_saved_run_calculate_as_arrays_do(tmp_path: Path) -> None:
    run = sr.simulate(slider_crank(), until=0.1)
    run.save(tmp_path / "run")
    q = sr.load_run(tmp_path / "run").q
    assert np.array_equal(1000 * q - q.T.copy().T / 2, 1000 * run.q - run.q / 2)
    assert np.sum(q) == run.q.sum() == q.sum()
    sr.load_run(tmp_path / "run").animate(tmp_path / "page.html")
    with pytest.raises(AttributeError):
        q.mean_of  # noqa: B018
