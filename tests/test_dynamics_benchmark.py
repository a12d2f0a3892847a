"""The benchmark of simulations: what Exudyn is told of a model, and what is made of the runs of both codes."""

import importlib
import json
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import sarrus as sr

BENCHMARKS = Path(__file__).resolve().parent.parent / "benchmarks"


@pytest.fixture
def load(monkeypatch: pytest.MonkeyPatch) -> Any:
    for folder in (BENCHMARKS, BENCHMARKS.parent / "examples"):
        monkeypatch.syspath_prepend(str(folder))

    def loaded(name: str) -> ModuleType:
        return importlib.import_module(name)

    return loaded


def run(seconds: float, error: float) -> dict[str, float]:
    return {"seconds": seconds, "error": error}


def test_ratios_have_names(load: Any) -> None:
    """Of two numbers of steps, the median and the least; and the quickest of our runs that is as good as theirs."""
    rows = [
        {
            "steps": 100,
            "sarrus": run(1.0, 2e-4),
            "exudyn": run(2.0, 1e-4),
            "exudyn_as_it_comes": run(3.0, 1e-4),
        },
        {
            "steps": 200,
            "sarrus": run(2.0, 5e-5),
            "exudyn": run(8.0, 2e-5),
            "exudyn_as_it_comes": run(8.0, 2e-5),
        },
    ]
    alone = [run(0.5, 9e-5), run(1.0, 1e-6), run(4.0, 1e-9)]
    one = {"problem": "top", "reference_to": 1e-9, "equal_steps": rows, "sarrus_alone": alone}
    chains = [{"microseconds_a_step_and_body": 2.0}, {"microseconds_a_step_and_body": 3.0}]
    assert load("dynamics").ratios([one], chains) == {
        "top_step_for_step": 3.0,
        "top_step_for_step_least": 2.0,
        "top_step_for_step_as_it_comes_least": 3.0,
        "top_same_error": 8.0,
        "top_same_error_least": 4.0,
        "chain_step_and_body_growth": 1.5,
    }


def test_without_a_run_that_is_as_good_the_ratio_is_nothing(load: Any) -> None:
    assert load("dynamics").same_error(run(1.0, 1e-9), [run(0.1, 1e-8)]) == 0.0


def test_a_looser_newton_counts_only_if_the_end_stays(load: Any) -> None:
    runs = load("dynamics_runs")
    tight = runs.Run(3.0, 10, 1e-4, "tight", np.array([0.0, 0.0, 0.0]))
    loose = runs.Run(2.0, 10, 1e-4, "loose", np.array([5e-7, 0.0, 0.0]))
    lucky = runs.Run(1.0, 10, 1e-9, "lucky", np.array([1e-4, 0.0, 0.0]))
    assert runs.as_good([(tight, None), (loose, None), (lucky, None)])[0] is loose


def test_exudyn_is_told_the_vehicle(load: Any) -> None:
    """All bodies, joints and forces, in numbers that JSON can hold; the bump is told in its own way."""
    problem = load("dynamics_problems").hmmwv()
    told = load("exudyn_told").Told(problem.system, problem.start, problem.points, problem.others).data
    assert len(told["bodies"]) == 14
    kinds = [part["type"] for part in json.loads(json.dumps(told))["forces"]]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {"tsda": 8, "tyre": 4, "bump": 2}
    whole = {"spherical": 3, "distance": 1}
    fixed = sum(sum(joint.get("fixed", ())) + whole.get(joint["type"], 0) for joint in told["joints"])
    assert fixed == 73
    assert all(body["velocity"] == pytest.approx([5, 0, 0]) for body in told["bodies"])


def test_exudyn_is_told_the_car(load: Any) -> None:
    """Bodies, springs, tyres, bars and the rack; tyres start as they do in Sarrus, with R_e Ω = V."""
    beside = load("vehicles_beside")
    system = beside.coasting()
    start = sr.rolling_start(system, 20.0)
    told = json.loads(json.dumps(beside.told(system, start).data))
    assert [body["velocity"] == pytest.approx([20, 0, 0]) for body in told["bodies"]] == [True] * 14
    kinds = [part["type"] for part in told["forces"]]
    assert {kind: kinds.count(kind) for kind in kinds} == {
        "tsda": 4,
        "rolling_tyre": 4,
        "bar": 2,
        "steered": 1,
    }
    places = {body["name"]: np.array(body["position"]) for body in told["bodies"]}
    for tyre in (part for part in told["forces"] if part["type"] == "rolling_tyre"):
        height = places[tyre["body"]][2] + tyre["values"][0][2]
        assert tyre["coefficients"]["UNLOADED_RADIUS"] > 20.0 / tyre["start"][2] > height
        assert len(tyre["values"]) == 8


def test_the_bump_is_that_of_the_road(load: Any) -> None:
    """Its force is that of the tyre on a road that rises and falls: k h + c ḣ, ḣ by a difference."""
    bump = load("dynamics_problems").Bump(k=3e5, c=7e3, height=0.06, begins=0.87, takes=0.4)
    t, d = 0.87 + 0.4 * 0.3, 1e-6
    heights = [0.06 * np.sin(np.pi * (x - 0.87) / 0.4) ** 4 for x in (t - d, t, t + d)]
    assert bump.force(t) == pytest.approx(
        3e5 * heights[1] + 7e3 * (heights[2] - heights[0]) / (2 * d), rel=1e-7
    )
    assert bump.force(0.8) == bump.force(1.3) == 0
