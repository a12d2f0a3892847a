"""Estimated errors of responses against true ones, on motions with closed forms."""

from __future__ import annotations

import subprocess
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.equations.block_matrix import PlacedMatrix
from sarrus.analyses.sensitivity import error_estimates
from sarrus.analyses.sensitivity.steps import record

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from accuracy_problems import PROBLEMS, Problem
from accuracy_problems.problem import KINDS, as_column

SMOOTH = (
    "spring, 20 s",
    "spring, 10 krad/s",
    "spring, 1 km",
    "spring, damped",
    "two masses",
    "hardening spring",
    "hanging mass",
    "harmonic load near resonance",
    "foot of the spring is shaken",
    "pendulum, from the horizontal",
    "pendulum of 1 mm",
    "spherical pendulum",
)
LARGE = 0.01  # of the largest error: estimates of smaller ones need not have any digits
WEIGHED = 0.1  # of the spread, beside estimates by exact adjoints: also of unstable motions
DIGITS = 1e-3  # of an estimate alone, whose adjoints are no more exact than that
COSTS = (
    "shipped slider-crank",
    "example: heavy top",
    "chain of four rods",
    "example: governor",
    "example: Bricard's mechanism",
    "example: Andrews' squeezer",
    "free body, about its middle axis",
    "vehicle that drives and steers",
    "stick and slip",
    "driven rotor",
    "ball that slides, then rolls",
    "bouncing ball, impacts",
    "double pendulum, calm",
    "example: double pendulum in space",
    "spring, stiff and undamped",
)
PAIRS = 60  # of estimates and gradients at most, taken in turn: the least times differ less than single ones
SPREAD = 1.15  # of the ratio: 1.10 where gradients have few parameters, since forces are evaluated within steps, too
JUMPING = ("load switched on and off", "pulse of 20 ms, free mass", "load by a table")


def problem_of(name: str) -> Problem:
    return next(one for one in PROBLEMS if one.name == name)


def effectivities(name: str, field: str = "estimate", **settings: Any) -> dict[str, float]:
    """Estimated over true error of each output at the end, but for those that happen to be right."""
    problem = problem_of(name)
    (system, start), known = problem.make(), problem.solution()
    run = sr.simulate(
        system, start, until=problem.until, t_eval=known.t, store="steps", events=problem.events, **settings
    )
    kinds = [kind for kind in ("positions", "velocities", "reactions") if kind in problem.read]
    names = [one for kind in kinds for one in problem.read[kind]]
    truth = np.concatenate([getattr(known, kind)[-1] for kind in kinds])
    found = run.error(names)
    true = np.array([one.value for one in found]) - truth
    large = abs(true) > LARGE * abs(true).max()
    return {
        one.response: getattr(one, field) / (error if field == "estimate" else abs(error))
        for one, error, on in zip(found, true, large, strict=True)
        if on
    }


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_motions(name: str) -> None:
    found = effectivities(name, method=sr.Radau(rtol=1e-4, atol=1e-6))
    assert found
    for response, effectivity in found.items():
        assert 0.3 < effectivity < 3, (response, effectivity)


@pytest.mark.filterwarnings("ignore:.*spline through the table")  # it overshoots next to jumps
@pytest.mark.parametrize("name", JUMPING)
def test_loads_that_jump(name: str) -> None:
    for response, effectivity in effectivities(name, method=sr.Radau()).items():
        assert 0.1 < effectivity < 10, (response, effectivity)


@pytest.mark.filterwarnings("ignore:.*spline through the table")
@pytest.mark.parametrize(
    ("name", "smooth"),
    [("spring, thrown", True), ("example: double pendulum", True), ("load switched on and off", False)],
)
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()])
def test_ends_of_steps_are_points_of_the_rule(
    name: str, smooth: bool, method: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where forces do not jump there: the estimates of Gauss's rule. At ends with jumps, they were 262 times these."""
    run, names = stored(name, method)
    found = run.error(names)
    monkeypatch.setattr(error_estimates, "_jumps", lambda *_: True)
    for one, inside in zip(found, run.error(names), strict=True):
        assert one.error == pytest.approx(inside.error, rel=0.05)
        assert (one.error == inside.error) is not smooth


@pytest.mark.parametrize("name", ["driven rotor", "driven slider-crank"])
def test_prescribed_motions_have_small_errors(name: str) -> None:
    """Constraints undo the defect of each step; what is left is the error of the rule with a linear adjoint."""
    run, names = stored(name)
    for one in run.error(names):
        assert 0 < one.error < 1e-5, one


def test_errors_of_stiff_steps_are_not_underestimated() -> None:
    """The last steps are 30 time constants of the creeping mass long, where the adjoint is not linear.

    Their contributions have both signs, and cancel or not depending on round-off.
    """
    for response, effectivity in effectivities("stick and slip", "spread").items():
        assert 0.3 < effectivity < 100, (response, effectivity)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    "method", [sr.HHT(), sr.HHT(stabilized=True), sr.GeneralizedAlpha(), sr.GeneralizedAlpha(stabilized=True)]
)
@pytest.mark.parametrize("name", ["pendulum of 1 mm", "spring, damped", "double pendulum, wild for 3 s"])
def test_methods_of_order_two(name: str, method: Any) -> None:
    for response, effectivity in effectivities(name, method=method).items():
        assert 0.25 < effectivity < 4, (response, effectivity)


def pendulum(**settings: Any) -> sr.Trajectory:
    system, start = problem_of("pendulum, from the horizontal").make()
    return sr.simulate(system, start, until=2.0, store="steps", **settings)


def test_responses_over_the_whole_run() -> None:
    responses = [sr.Integral("bob.x"), sr.Maximum("pin.angle.rate"), sr.At("bob.z", time=1.0)]
    exact = pendulum(method=sr.Radau(rtol=1e-11, atol=1e-12)).error(responses)
    for method in (sr.Radau(), sr.HHT()):
        for one, true in zip(pendulum(method=method).error(responses), exact, strict=True):
            assert 0.3 < one.estimate / (one.value - true.value) < 3, one


def test_through_impacts() -> None:
    """A ball on a soft spring is dropped from 1 m and bounces; compared with a run of far smaller tolerances."""
    ball = sr.Body("ball", 1.0, (1e-3,) * 3, position=(0, 0, 1.0))
    spring = sr.TSDA("spring", sr.ground.point(0.5, 0, 3), ball.point(0, 0, 0), k=2.0, length=1.0)
    system = sr.System(sr.Model("bouncing", [ball], [], [spring], gravity=(0, 0, -9.81)))
    bounce = sr.Event("ball.z", direction=-1, reset=sr.Impact(0.8), name="bounce")
    cases = ((sr.Radau(), 1e-4), (sr.HHT(), 1e-5), (sr.Radau(), 1e-12))
    runs = [
        sr.simulate(
            system,
            until=2.5,
            events=bounce,
            store="steps",
            method=replace(method, rtol=rtol, atol=rtol / 100),
        )
        for method, rtol in cases
    ]
    names = ["ball.z", "ball.velocity.z", sr.AtEvent("t", event="bounce", number=2)]
    for run in runs[:2]:
        for one, true in zip(run.error(names), runs[-1].error(names), strict=True):
            assert 0.1 < one.estimate / (one.value - true.value) < 10, one


def test_value_beside_derivatives() -> None:
    run = pendulum(method=sr.Radau())
    alone = run.error("pin.angle")
    for method in ("adjoint", "direct"):
        found = sr.sensitivity(run, "pin.angle", ["bob.mass"], method=method, error=True)
        assert found.errors[0].estimate == pytest.approx(alone.estimate, rel=DIGITS)
        assert str(alone) in found.summary()
    second = sr.hessian(run, "pin.angle", ["bob.mass"], error=True)
    assert second.error is not None
    assert second.error.estimate == pytest.approx(alone.estimate, rel=DIGITS)
    assert "±" in str(alone)
    assert 4 < alone.digits < 12


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    "name",
    [
        "spherical pendulum",
        "chain of four rods",
        "dropped ball, hard",
        "bouncing ball, impacts",
        "free body, fast",
    ],
)
def test_estimates_alone_weigh_with_adjoints_of_some_digits(name: str) -> None:
    """Beside a gradient adjoints are exact; alone the stages of a step are solved for to some digits."""
    run, names = stored(name)
    alone, beside = run.error(names), sr.sensitivity(run, names, error=True).errors
    assert len(alone) > 1
    for one, other in zip(alone, beside, strict=True):
        assert abs(one.estimate - other.estimate) <= WEIGHED * other.spread


def test_errors_of_adjoints_do_not_add_up_in_long_runs() -> None:
    """A flywheel of 80 revolutions: nothing restores its angle, and the adjoint sums its errors twice."""
    system, _ = problem_of("flywheel, to 10 000 rad/s").make()
    run, names, until = sr.simulate(system, until=0.7, store="steps"), ["pin.angle", "pin.angle.rate"], 0.7
    truth = (1000.0 * until**2, 2000.0 * until)
    alone, beside = run.error(names), sr.sensitivity(run, names, error=True).errors
    for one, other, exact in zip(alone, beside, truth, strict=True):
        assert abs(one.estimate - other.estimate) <= DIGITS * other.spread
        assert one.estimate / (one.value - exact) == pytest.approx(1.0, abs=0.01)


def test_adjoints_of_all_stretches_share_one_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors add up through events, too: what is left in a step depends on the steps of the whole run."""
    run, names = stored("bouncing ball, impacts")
    counts, limit = list[int](), record.error_of_adjoints
    monkeypatch.setattr(record, "error_of_adjoints", lambda steps: (counts.append(steps), limit(steps))[1])
    run.error(names)
    assert len(counts) > 1
    assert set(counts) == {len(run.steps)}


def test_pivots_are_chosen_once_for_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of states between nodes, where most of the time of short runs with stiff steps would go."""
    run, names = stored("stick and slip")
    counts, choose = [0], PlacedMatrix.choose_pivots
    monkeypatch.setattr(
        PlacedMatrix, "choose_pivots", lambda own: (counts.append(counts.pop() + 1), choose(own))[1]
    )
    first = run.error(names[0])
    assert counts.pop() > 0
    counts.append(0)
    again = run.error(names[0])
    assert counts == [0]
    assert again.error == pytest.approx(first.error, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", COSTS)
def test_an_estimate_costs_about_a_gradient(name: str) -> None:
    """Processor time, the least of calls taken in turn until it shows."""
    run, names = stored(name)
    least = {True: np.inf, False: np.inf}
    for pair in range(PAIRS):
        for alone in least:
            begun = time.process_time()
            run.error(names[0]) if alone else sr.sensitivity(run, names[0])
            least[alone] = min(least[alone], time.process_time() - begun)
        if pair >= 9 and least[True] <= SPREAD * least[False]:
            return
    assert least[True] <= SPREAD * least[False]


def stored(name: str, method: Any = None) -> tuple[sr.Trajectory, list[str]]:
    """A run with stored steps, and the outputs that are known."""
    problem = problem_of(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        system, start = problem.make()
        run = sr.simulate(
            system, start, until=problem.until, method=method, events=problem.events, store="steps"
        )
    columns = [as_column(one) for kind in KINDS if kind in problem.read for one in problem.read[kind]]
    return run, list(dict.fromkeys(name for column in columns for name in column.outputs))


def test_an_error_is_never_zero() -> None:
    """A free fall is exact but for round-off."""
    ball = sr.Body("ball", 1.0, (1e-3,) * 3, position=(0, 0, 1.0))
    system = sr.System(sr.Model("fall", [ball], [], [], gravity=(0, 0, -9.81)))
    found = sr.simulate(system, until=1.0, store="steps", method=sr.Radau()).error("ball.z")
    assert found.error > 0
    assert abs(found.value - (1 - 9.81 / 2)) <= 100 * found.error
    assert found.error < 1e-13


def test_errors_are_the_first_thing_that_a_process_asks_for() -> None:
    """Analyses are imported when they are first used: that of errors is found by a run."""
    program = """
import sarrus as sr
body = sr.Body("b", mass=1.0, inertia=(1, 1, 1))
slide = sr.Translational("s", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
system = sr.System(sr.Model("m", [body], [slide], gravity=(0, 0, -9.81)))
print(sr.simulate(system, until=0.1, store="steps").error("b.z").response)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert "b.z" in done.stdout


def test_the_benchmark_prints_the_cost_of_an_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of `run.error` over that of a gradient, where other calls of the processor add to both."""
    import effectivity

    clock, calls = [0.0], [0]

    def spends(seconds: float) -> Any:
        def call(*_: object) -> None:
            calls[0] += 1
            clock[0] += seconds + 0.1 * (calls[0] % 3 > 0)

        return call

    class Run:
        error = staticmethod(spends(3.0))

    monkeypatch.setattr(effectivity.time, "process_time", lambda: clock[0])
    monkeypatch.setattr(effectivity.sr, "sensitivity", spends(4.0))
    assert effectivity._cost(Run(), "x") == pytest.approx(0.75)
