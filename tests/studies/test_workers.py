"""Where a study is run, how it shows its progress, and how it ends before its last case."""

import signal
from pathlib import Path
from typing import Any

import pytest
from tests.patience import within_by_the_clock
from tests.studies import own

import sarrus as sr
from sarrus.model import Model
from sarrus.studies import Simulation, open_study, study
from sarrus.studies.conduct import IMPORT, chosen_workers

MANY = {"spring.k": [5.0 + n for n in range(32)]}


def test_processes_are_used_where_they_pay() -> None:
    short = chosen_workers(loading=1.0, each=0.1, cases=30, processors=2)
    assert short.workers == 1  # 3 s here; two processes take longer to start
    assert "in this process" in short.reason
    long = chosen_workers(loading=1.0, each=10.0, cases=30, processors=4)
    assert long.workers == 4
    assert chosen_workers(loading=0.0, each=10.0, cases=2, processors=8).workers == 2
    none = chosen_workers(loading=0.0, each=0.0, cases=0, processors=8)
    assert (none.workers, none.reason) == (1, "in this process: no cases are left")
    assert chosen_workers(loading=0.0, each=1e9, cases=1, processors=8).workers == 1
    assert chosen_workers(loading=0.0, each=1e9, cases=9, processors=1).workers == 1


def test_short_cases_stay_in_this_process(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sarrus.studies.pool.available", lambda: 2)
    study(model, {"spring.k": [5.0]}, "slider.x", analysis=Simulation(until=0.02, steps=5), workers=1)
    with within_by_the_clock(2 * IMPORT):
        found = study(model, MANY, "slider.x", analysis=Simulation(until=0.02, steps=5))
    assert found.success.all()
    assert "in this process" in found.execution


def test_progress_is_a_bar_or_a_function(model: Model, capsys: pytest.CaptureFixture[str]) -> None:
    study(model, MANY, {"k": "k"}, analysis=own.quick, progress=True)
    assert "ran 32 of 32 cases" in capsys.readouterr().err
    seen: list[float] = []
    study(model, MANY, {"k": "k"}, analysis=own.quick, progress=seen.append)
    assert seen == [*range(1, 33)]
    study(model, MANY, {"k": "k"}, analysis=own.quick, progress=False)
    with pytest.raises(TypeError, match="progress must be True"):
        study(model, MANY, {"k": "k"}, analysis=own.quick, progress=5)  # type: ignore[arg-type]


@pytest.mark.parametrize("workers", [1, 2])
def test_a_time_limit_keeps_the_cases_that_are_done(model: Model, tmp_path: Path, workers: int) -> None:
    asked: dict[str, Any] = {"analysis": own.slow, "folder": tmp_path, "workers": workers}
    cases = {"spring.k": [5.0 + n for n in range(400)]}
    with pytest.warns(sr.SarrusWarning, match="time limit of .* has passed. .* of 400 cases are done"):
        found = study(model, cases, {"k": "k"}, total_time_limit=1.0 if workers == 1 else 8.0, **asked)
    assert found.status == "time limit"
    assert found.success.sum() < 400
    assert found.success.sum() > 0 or workers > 1
    assert not found.failures  # no case is called failed because the study ended
    with pytest.warns(sr.SarrusWarning, match="of 400 cases are done"):
        assert open_study(tmp_path).success.sum() == found.success.sum()


def test_a_long_case_is_cut_short_and_has_no_outcome(model: Model) -> None:
    with pytest.warns(sr.SarrusWarning, match="time limit"):
        found = study(
            model,
            {"spring.k": [5.0, 6.0]},
            "slider.x",
            analysis=Simulation(until=1e4, method=sr.HHT(step=1e-3)),
            total_time_limit=1.0,
        )
    assert found.messages == ("", "")


def test_ctrl_c_keeps_the_cases_that_are_done(model: Model) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have started the tests without it
    with pytest.warns(sr.SarrusWarning, match="stopped by the user. 2 of 4 cases"):
        found = study(
            model, {"spring.k": [5.0, 6.0, 13.0, 14.0]}, {"k": "k"}, analysis=own.interrupts, workers=1
        )
    assert found.status == "stopped"
    assert found["k"][:2].tolist() == [5.0, 6.0]
