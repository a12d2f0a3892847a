"""The benchmarks run, and say what the documentation says that they do; their times are nobody's business here."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

FOLDER = Path(__file__).resolve().parent.parent / "benchmarks"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("gcc") is None, reason="the benchmarks need gcc"),
]


def figures(script: str, *options: str) -> dict[str, Any]:
    """What a benchmark prints with --json."""
    command = [sys.executable, str(FOLDER / script), "--json", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_derivatives() -> None:
    """Sarrus and its twin in C compute the same numbers."""
    found = figures("derivatives.py", "--quick", "--rounds", "2", "--without", "casadi", "jax")
    for mechanism in ("slider_crank", "hmmwv"):
        for group in ("kinematic", "force", "inertia"):
            assert found[f"{mechanism}.{group}.c_error"] < 1e-12
            assert found[f"{mechanism}.{group}.sarrus_us"] > 0
            assert found[f"{mechanism}.{group}.sarrus_over_c"] > 0


def test_chain() -> None:
    found = figures("chain.py", "--quick", "--sizes", "5", "20", "--repeats", "1")
    assert found
    assert all(value >= 0 for name, value in found.items() if "evaluation" in name)


def test_allocation() -> None:
    found = figures("allocation.py", "--calls", "1000")
    for group in ("kinematic", "force", "inertia"):
        assert found[f"{group}.strange_calls"] == []
        assert found[f"{group}.mallocs_compiled"] == found[f"{group}.numba_allocations"] == 0


def test_sensitivities_beside_differences() -> None:
    """The known gradient is met backwards and by differences."""
    for row in figures("sensitivity_beside.py", "--quick"):
        assert row["gradient_error"] < 0.05, row
        assert 0 < row["run_s"] < row["run_and_gradient_s"]


def test_workspace() -> None:
    """Maps are right, pass their tests, and take far fewer kinematic solutions than grids."""
    found = figures("workspace.py", "--repeats", "1")
    for name in ("arm_3r", "five_bar", "platform", "platform_with_legs"):
        assert found[f"{name}.area_error"] < 1e-6
        assert found[f"{name}.tests_passed"]
    assert found["platform.grid_solutions_over_ours"] > 100
    assert found["platform.grid_error_over_ours"] > 10


def test_studies() -> None:
    """Workers compute the same numbers."""
    found = figures("studies.py", "--cases", "10", "--repeats", "1")
    assert found["all_succeeded"]
    assert found["same_numbers"]
    assert found["speedup"] > 0


def test_vehicles() -> None:
    """A lane change of the car, with the derivatives of three responses by all of its parameters."""
    found = figures("vehicles.py", "--quick")
    assert found["bodies"] == 14
    assert min(found["parameters"], found["steps"]) > 100
    assert found["gradient"].keys() == {"final", "integral", "maximum"}
    assert all(
        value > 0 for value in (found["real_time"], found["hht_real_time"], *found["gradient"].values())
    )


def test_first_uses_are_timed() -> None:
    (found,) = figures("start.py", "--warm", "simulate").values()
    assert 0 < found["warm_cpu_s"]
    assert 0 < found["warm_s"]


def test_linear_solvers_agree() -> None:
    found = figures("linear.py", "--quick")
    for mechanism in ("slider_crank", "hmmwv"):
        for solver in ("ours", "superlu", "lapack"):
            assert found[f"{mechanism}.{solver}.error"] < 1e-8
            assert found[f"{mechanism}.{solver}.again"] > 0


def test_stiffness_does_not_set_the_steps() -> None:
    found = figures("stiff.py", "--quick")
    for method in ("HHT", "alpha"):
        steps = [found[f"bushing.{k}.{method}.steps"] for k in ("1e+05", "1e+07", "1e+09")]
        assert max(steps) < 1.3 * min(steps)


def test_flat_four_bars_are_gone_over_by_every_method() -> None:
    found = figures("flat.py", "--quick")
    for method in ("HHT", "Radau", "DOP853"):
        assert found[f"1.1e-08.{method}.error"] < 0.2 * found[f"1.1e-06.{method}.error"]
    assert found["1.1e-08.HHT.error"] < 2 * found["1.1e-08.pendulum.error"]


def test_energy_drifts_less_with_smaller_tolerances() -> None:
    found = figures("drift.py", "--quick")
    for method in ("HHT", "Radau", "DOP853"):
        assert found[f"simple_pendulum.1e-08.{method}"] < 0.2 * found[f"simple_pendulum.1e-06.{method}"]
    assert found["free_body.100s.1e-08.momentum"] < 1e-6
    plain, stabilized = (
        found[f"slider_crank.1e-06.trapezoidal{kind}.multipliers"] for kind in ("", ".stabilized")
    )
    assert stabilized < 0.01 * plain


def test_a_step_of_radau_costs_more_than_one_of_hht_and_is_longer() -> None:
    found = figures("steps.py", "--quick")
    for name in ("hmmwv", "four_bars_40"):
        assert found[f"{name}.1e-06.radau.steps"] < found[f"{name}.1e-06.hht.steps"]
        assert found[f"{name}.1e-06.ratio"] > 1


def test_sensitivity() -> None:
    found = figures("sensitivity.py", "--quick")
    for method in ("hht", "radau"):
        # all numbers of parts, without those of velocities that a model leaves out
        assert found[f"hmmwv.{method}.parameters"] == 489
        assert 0 < found[f"hmmwv.{method}.direct_ratio_per_parameter"] < 0.5
    assert found["sundials_crank.gradient_error"] < 5e-3


def test_everyday_calls() -> None:
    """Each has a first and a later time, and derivatives are ratios to the run."""
    found = figures("calls.py", "--quick", "--only", "slider_crank")
    for name in ("System", "assemble", "simulate.radau", "equilibrium", "linearize", "workspace_range"):
        assert 0 < found[f"slider_crank.{name}.later_ms"]
    for method in ("hht", "radau"):
        for name in ("final", "integral", "maximum", "error"):
            assert 0 < found[f"slider_crank.{method}.{name}.later_ratio"]


def test_dynamics() -> None:
    """Without Exudyn: all problems run, to their references, and the chains are measured."""
    found = figures("dynamics.py", "--quick")
    for one in found["problems"]:
        assert all(np.isfinite(row["sarrus"]["seconds"]) for row in one["equal_steps"])
        assert one["reference_to"] < 1e-6
        assert min(run["error"] for run in one["sarrus_alone"]) < 1e-3
    assert [chain["bodies"] for chain in found["chains"]] == [100, 1000]
    assert {"hmmwv_share_of_python", "chain_step_and_body_growth"} <= set(found["ratios"])
