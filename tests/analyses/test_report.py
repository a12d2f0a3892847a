"""The bar of a run, and tables of what it gave."""

import re
from pathlib import Path

import numpy as np
import pytest
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
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "simulated 0.5 of 0.5 s in" in told


def test_tables(tmp_path: Path) -> None:
    run = sr.simulate(slider_crank(), until=0.1, t_eval=[0.0, 0.1])
    frame = run.to_frame()
    assert list(frame.columns[:2]) == ["t", run.coordinate_names[0]]
    assert np.array_equal(frame["slider.r.x"], run.coordinate("slider.x"))
    run.to_parquet(tmp_path / "run.parquet")
    import pandas as pd

    assert pd.read_parquet(tmp_path / "run.parquet").equals(frame)


def test_the_code_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    guide = (Path(__file__).parents[2] / "docs" / "how-to" / "simulate.md").read_text(encoding="utf-8")
    code = "\n".join(re.findall(r"```python\n(.*?)```", guide, flags=re.DOTALL))
    exec(compile(code, "simulate.md", "exec"), {})
    told = capsys.readouterr().out
    assert "finished reached the end" in told
    assert "event" in told
    assert "(1001, 21)" in told
