"""The page on workspaces runs as it stands, in an empty folder."""

import re
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "workspace.md"


def test_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("agg")
    names = {"__name__": "__main__"}
    for block in re.findall(
        r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    ):
        exec(compile(block.replace("cells=40", "cells=8"), PAGE.name, "exec"), names)
    plt.close("all")
    told = capsys.readouterr().out
    assert "arm: the map is not complete. Go on with it" in told
    assert "Range of orientation link_3.rotation_z [rad]" in told
    assert names["wider"].success
    assert names["lost"].success
    assert {file.name for file in tmp_path.iterdir()} == {
        "arm.png",
        "arm.csv",
        "conditioning.png",
        "field.csv",
    }
