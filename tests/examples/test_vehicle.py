"""The vehicle of examples/hmmwv_bump.py: it settles, feels the bump under its left wheels only, and can be steered."""

import runpy
from typing import Any

import numpy as np
import pytest
from tests.examples.problems import FOLDER


@pytest.fixture(scope="module")
def example() -> dict[str, Any]:
    return runpy.run_path(str(FOLDER / "hmmwv_bump.py"))


def test_it_settles_where_it_rests(example: dict[str, Any]) -> None:
    run = example["settle"]()
    assert run.success, run.message
    assert run["chassis"].position[-1, 2] == pytest.approx(0.76427807917, abs=1e-4)
    loads = example["loads"](run)
    assert loads["front_left"][0] == 0  # in the air
    assert loads["front_left"][-1] == pytest.approx(6533.3, rel=1e-3)
    assert loads["rear_right"][-1] == pytest.approx(6106.5, rel=1e-3)


def test_the_bump_lifts_the_left_side(example: dict[str, Any]) -> None:
    run = example["over_the_bump"]()
    assert run.success, run.message
    attitude, loads = example["angles"](run, "chassis"), example["loads"](run)
    assert np.max(attitude["roll"]) > 0.3
    peaks = {name: run.t[np.argmax(force)] for name, force in loads.items()}
    x = {name: run[f"knuckle_{name}"].position[0, 0] for name in loads}
    for side in ("front_left", "rear_left"):
        assert abs(x[side] + 5.0 * peaks[side] - 7.0) < 0.7  # the load is greatest on the rise to the crest
        assert loads[side].max() > 1.3 * loads[side][0]


def test_the_rack_steers_both_front_wheels(example: dict[str, Any]) -> None:
    run = example["steered"]()
    assert run.success, run.message
    rack = run.joint("rack").displacement
    for side in ("left", "right"):
        turned = example["angles"](run, f"knuckle_front_{side}")["yaw"]
        assert np.corrcoef(rack, turned)[0, 1] < -0.99
        assert 35 < np.ptp(turned) < 50
