"""The bar of a run, and tables of what it gave."""

from pathlib import Path

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.progress import Bar, duration


def test_the_bar_tells_simulated_time_and_time_to_go() -> None:
    bar = Bar(10.0)
    bar(2.5)
    assert bar.line(3.0).endswith("2.5 of 10 s, 9 s to go")
    assert bar.line(3.0).count("█") == 7
    assert [duration(x) for x in (0.213, 12.3, 185.0, 7800.0)] == [
        "0.21 s",
        "12 s",
        "3 min 5 s",
        "2 h 10 min",
    ]


def test_a_run_in_a_pipe_leaves_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    sr.simulate(slider_crank(), until=0.5, progress=True)
    *first, last = capsys.readouterr().err.splitlines()
    assert "simulated 0.5 of 0.5 s in" in last
    assert all("compiling" in line for line in first)  # with an empty cache


def test_derivatives_and_films_show_their_progress(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = sr.simulate(slider_crank(), until=0.05, t_eval=[0.0, 0.05], store="steps")
    sr.sensitivity(run, "slider.x", ["spring.k"], progress=True)
    assert "differentiated 2 of 2 stages" in capsys.readouterr().err
    seen: list[float] = []
    sr.hessian(run, "slider.x", ["spring.k", "rod.mass"], progress=seen.append)
    assert seen == [0, 1, 2]
    sr.animate(run, tmp_path / "film.gif", speed=0.2, progress=True)
    assert "pictures in" in capsys.readouterr().err
    sr.animate(run, tmp_path / "film.gif", speed=0.2)
    assert "pictures" not in capsys.readouterr().err  # without a terminal a bar must be asked for

    def stop(number: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sr.animate(run, tmp_path / "cut.gif", speed=0.2, progress=stop)
    with pytest.raises(KeyboardInterrupt):
        sr.hessian(run, "slider.x", ["spring.k"], progress=stop)


def test_tables(tmp_path: Path) -> None:
    run = sr.simulate(slider_crank(), until=0.1, t_eval=[0.0, 0.1])
    frame = run.to_frame()
    assert (frame.index.name, list(frame.index)) == ("t [s]", [0.0, 0.1])
    assert np.array_equal(frame["slider.x [m]"], run.coordinate("slider.x"))
    run.to_parquet(tmp_path / "run.parquet")
    import pandas as pd

    assert pd.read_parquet(tmp_path / "run.parquet").equals(frame)


def test_a_gradient_by_checkpoints_shows_both_ways_and_obeys_its_limit() -> None:
    seen: list[float] = []
    found = by_checkpoints(slider_crank(), "slider.x", ["spring.k"], until=0.2, progress=seen.append)
    assert found.matrix.shape == (1, 1)
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(0.4)
    assert any(t <= 0.2 for t in seen)
    with pytest.raises(ValueError, match="time limit of"):
        by_checkpoints(slider_crank(), "slider.x", ["spring.k"], until=2.0, time_limit=1e-4)
