"""Pictures and tables of workspaces."""

import csv
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

from .mechanisms import arm_3r


@pytest.fixture(scope="module")
def arm() -> sr.Workspace:
    system, output, limits = arm_3r()
    return sr.workspace(system, output, limits=limits, verify=False)


def test_picture(arm: sr.Workspace) -> None:
    """All curves, each kind once in the legend, arrows on barriers, the mechanism in the number of positions wanted."""
    axes = arm.plot(ghosts=2)
    ghosts = [line for line in axes.get_lines() if line.get_marker() == "o"]
    assert len(ghosts) == 2 * 3
    assert len(axes.get_lines()) - len(ghosts) == len([curve for curve in arm.curves if not curve.again])
    assert len(axes.get_legend().get_texts()) == 3
    assert len(axes.texts) > len(arm.of_kind("barrier"))


def test_table(arm: sr.Workspace, tmp_path: Path) -> None:
    arm.to_csv(tmp_path / "arm.csv")
    with (tmp_path / "arm.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(curve.u) for curve in arm.curves)
    x = np.array([[float(row["link_3.x"]), float(row["link_3.y"])] for row in rows])
    assert np.array_equal(x, np.concatenate([curve.u for curve in arm.curves]))


def test_report(arm: sr.Workspace) -> None:
    told = str(arm)
    for words in (
        "31.4975",
        "in one part",
        "Barriers inside",
        "singularity",
        "q2.angle lowest",
        "not tested",
    ):
        assert words in told
