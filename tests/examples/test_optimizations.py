"""The worked examples of optimization find what they should, and draw it."""

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.examples.problems import FOLDER

pytestmark = pytest.mark.slow


def of(script: str) -> dict[str, Any]:
    """What a script defines."""
    return runpy.run_path(str(FOLDER / f"{script}.py"))


def drawn(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir() if path.stat().st_size > 5000}


def test_optimal_spring(tmp_path: Path) -> None:
    """The least cost was published: k = 0.6826136, c = 1.3357019, 3.2227612."""
    script = of("optimal_spring")
    free, limited = script["main"](tmp_path, count=2)
    assert free.success
    assert free.x == pytest.approx([0.6826136, 1.3357019], abs=2e-5)
    assert free.value == pytest.approx(3.2227612, abs=5e-6)
    assert limited.success
    assert limited.constraints["largest pressure"] == pytest.approx(script["MOST"], abs=1e-5)
    assert limited.value > free.value
    assert drawn(tmp_path) == {"optimal_spring.png", "optimal_spring-convergence.png"}


def test_estimate_parameters(tmp_path: Path) -> None:
    script = of("estimate_parameters")
    found, every = script["main"](tmp_path)
    assert found.success
    assert 40 < found.value < 80  # half of the sum of 120 squares less 4
    assert not found.poor
    for name in found.names:
        low, high = found.interval(name)
        assert low < script["TRUE"][name] < high
        assert high - low < 0.05 * script["TRUE"][name]
    assert len(every.poor) == 1
    ratios = every.x[:3] / found.x[:3]
    assert np.ptp(ratios) < 0.05  # all masses and dampings grow together
    assert "not determined" in str(every)
    assert drawn(tmp_path) == {"estimate_parameters.png"}


def test_four_bar_synthesis(tmp_path: Path) -> None:
    """The places were those of a four-bar, which is found again."""
    script = of("four_bar_synthesis")
    found = script["main"](tmp_path)
    assert found.success
    assert found.value < 1e-6  # half of the sum of squares over 1 mm
    assert found.x == pytest.approx([*script["WANTED"].values()], abs=1e-5)
    assert drawn(tmp_path) == {"four_bar_synthesis.png"}


def test_torque_history(tmp_path: Path) -> None:
    script = of("torque_history")
    found = script["main"](tmp_path, iterations=20)
    assert len(found.names) == 120
    assert found.value < 3e-2 * found.value0
    angles = [found.run.joint(name).angle[-1] for name in ("shoulder", "elbow")]
    assert angles == pytest.approx(script["GOAL"], abs=0.2)
    assert drawn(tmp_path) == {"torque_history.png"}


def test_hmmwv_ride(tmp_path: Path) -> None:
    script = of("hmmwv_ride")
    free, limited = script["main"](tmp_path, iterations=10)
    assert len(free.names) == 14
    assert free.value < 0.25 * free.value0
    assert limited.value < 0.25 * limited.value0
    assert max(limited.constraints.values()) < script["MOST"] * 1.01
    assert drawn(tmp_path) == {"hmmwv_ride.png"}


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """Of twenty intervals from five noises, 95 %, give or take two."""
    script, held = of("estimate_parameters"), 0
    for seed in range(1, 6):
        found = script["estimate"](script["measurements"](seed), script["UNKNOWN"])
        held += sum(low < script["TRUE"][n] < high for n in found.names for low, high in [found.interval(n)])
    assert held >= 17


def test_tie_rod(tmp_path: Path) -> None:
    """The best inner joint leaves less than a hundredth of the toe; the first is the published suspension."""
    before, best, after = of("tie_rod")["main"](tmp_path)
    assert best.success
    assert np.degrees(before["toe"])[[0, -1]] == pytest.approx([-1.6482, 1.2708], abs=5e-5)
    assert abs(np.degrees(after["toe"])).max() < 0.005
    assert best.x == pytest.approx([0.225547, 0.102806], abs=2e-5)
    assert drawn(tmp_path) == {"tie_rod.png", "tie_rod-sheet.png"}


def test_lane_change(tmp_path: Path) -> None:
    """The car misses all cones, and its model and its motion are drawn."""
    result = of("lane_change")["main"](tmp_path)
    assert min(result[f"margin_{n}"] for n in (1, 2, 3)) > 0.05
    assert drawn(tmp_path) == {"lane_change.png", "lane_change-car.png", "lane_change.html"}


def test_a_tyre_from_measurements(tmp_path: Path) -> None:
    """Of 25 intervals, 95 % hold the true coefficient, give or take two; the residuals are the noise."""
    script = of("tyre_from_measurements")
    true, found = script["main"](tmp_path)
    held = [low < true.coefficients[n] < high for n in found.names for low, high in [found.interval(n)]]
    assert sum(held) >= 22
    for name, noise in script["NOISE"].items():
        assert np.sqrt(np.mean(found.residuals[name] ** 2)) == pytest.approx(noise, rel=0.05)
    assert drawn(tmp_path) == {"tyre_from_measurements.png"}
