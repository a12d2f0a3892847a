"""Former options of simulations: they work as the present ones, with a warning that shows these."""

from __future__ import annotations

import inspect
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.dynamics import former_options

pytestmark = pytest.mark.filterwarnings("error::DeprecationWarning")
FLOOR = sr.Event("b.z", name="floor")
STEPS = {"t_eval": [0.1]}


@cache
def ball() -> sr.System:
    body = sr.Body("b", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 0.02), velocity=(1.0, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 1), body.point(0, 0, 0), k=20.0, length=0.5)
    return sr.System(sr.Model("ball", [body], forces=[spring], gravity=(0, 0, -9.81)))


def simulated(**given: Any) -> sr.Trajectory:
    return sr.simulate(ball(), until=0.1, t_eval=[0.05, 0.1], **given)


CASES: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "rtol": ({"rtol": 1e-5}, {"method": sr.Radau(rtol=1e-5)}, "Use method=sr.Radau(rtol=1e-05)."),
    "all of a method": (
        {"method": sr.HHT(-0.2), "atol": 1e-6, "max_step": 0.01, "first_step": 0.001, "corners": True},
        {"method": sr.HHT(-0.2, atol=1e-6, max_step=0.01, first_step=0.001)},
        "Use method=sr.HHT(atol=1e-06, max_step=0.01, first_step=0.001, alpha=-0.2).",
    ),
    "of a description": (
        {"method": sr.HHT().description, "rtol": 1e-5},
        {"method": sr.DescribedMethod(sr.HHT().description, rtol=1e-5)},
        "Use method=sr.DescribedMethod(description, rtol=1e-05).",
    ),
    "of a solver": (
        {"method": sr.ODE("RK45"), "rtol": 1e-5}, {"method": sr.ODE("RK45", rtol=1e-5)},
        "Use method=sr.ODE(rtol=1e-05, name='RK45').",
    ),
    "of a method by its name": ({"method": "hht", "rtol": 1e-5}, {"method": sr.HHT(rtol=1e-5)}, "sr.HHT("),
    "breakpoints": ({"breakpoints": [0.03]}, {"events": 0.03}, "Use events=[0.03]."),
    "breakpoints beside events": (
        {"breakpoints": np.array([0.03]), "events": FLOOR}, {"events": [FLOOR, 0.03]}, "Use events=[0.03]."
    ),
    "dense_output": ({"dense_output": True}, {"store": "dense"}, 'Use store="dense".'),
    "store_steps": ({"store_steps": True, "dense_output": False}, {"store": "steps"}, 'Use store="steps".'),
    "no steps": ({"store_steps": False}, {}, 'Use store="samples".'),
    "max_steps": ({"max_steps": 3}, {"limits": sr.Limits(steps=3)}, "Use limits=sr.Limits(steps=3)."),
    "time_limit": ({"time_limit": 50.0}, {"limits": sr.Limits(time=50.0)}, "Use limits=sr.Limits(time=50.0)."),
    "error": (
        {"error": {"b.z": 1e-5}}, {"limits": sr.Limits(errors={"b.z": 1e-5})},
        "Use limits=sr.Limits(errors={'b.z': 1e-05}).",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_every_former_option_of_a_run_works_and_warns(case: str) -> None:
    former, present, message = CASES[case]
    with pytest.warns(DeprecationWarning, match="deprecated") as seen:
        run = simulated(**former)
    assert message in str(seen[0].message)
    assert seen[0].filename == __file__
    other = simulated(**present)
    assert (run.status, run.nsteps, len(run.events)) == (other.status, other.nsteps, len(other.events))
    assert np.array_equal(run.q, other.q)
    assert type(run.sol) is type(other.sol)
    assert type(run.steps) is type(other.steps)


def test_every_former_option_has_a_case() -> None:
    given = {name for former, _, _ in CASES.values() for name in former} | {"overwrite"}
    assert {name for names in former_options.FORMER.values() for name in names} <= given
    assert len(inspect.signature(sr.simulate).parameters) == 12


def test_a_folder_that_is_overwritten(tmp_path: Path) -> None:
    simulated(save=tmp_path / "run")
    with pytest.warns(DeprecationWarning, match=r"overwrite= is deprecated\. Use save=sr\.Save\("):
        assert simulated(save=tmp_path / "run", overwrite=True).success
    with pytest.raises(FileExistsError, match=r"pass overwrite=True to sr\.Save"):
        simulated(save=tmp_path / "run")


def test_a_folder_that_is_not_given_or_described(tmp_path: Path) -> None:
    with pytest.warns(DeprecationWarning, match=r"Use save=sr\.Save\(folder, overwrite=True\)"):
        assert simulated(overwrite=True).success
    simulated(save=tmp_path / "run")
    with pytest.warns(DeprecationWarning, match=r"Use save=sr\.Save\("):
        assert simulated(save=sr.Save(tmp_path / "run"), overwrite=True).success


def test_the_default_method_of_a_stepper_remains() -> None:
    with pytest.warns(DeprecationWarning, match=r"Use method=sr\.Radau\(rtol=1e-06, max_step=0\.005\)"):
        former = sr.Stepper(ball(), step=0.01, outputs=["b.z"], max_step=0.005)
    present = sr.Stepper(ball(), step=0.01, outputs=["b.z"], method=sr.Radau(rtol=1e-6, max_step=0.005))
    assert [former.advance() for _ in range(5)] == [present.advance() for _ in range(5)]


PRECISE = {"until": 0.1, "rtol": 1e-5}
OTHERS: dict[str, Any] = {
    "optimize": lambda: sr.optimize(ball(), sr.Final("b.z"), ["spring.k"], iterations=1, **PRECISE),
    "fit": lambda: sr.fit(
        ball(), sr.Misfit("b.z", at=[0.05, 0.1], data=[0.0, -0.02]), ["spring.k"], iterations=1, **PRECISE
    ),
    "Problem": lambda: sr.Problem(ball(), sr.Final("b.z"), ["spring.k"], **PRECISE),
    "Simulation": lambda: sr.Simulation(**PRECISE),
    "Stepper": lambda: sr.Stepper(ball(), step=0.01, outputs=["b.z"], rtol=1e-5),
}


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.filterwarnings("ignore::sarrus.SarrusWarning")
def test_what_simulates_has_them_too(name: str) -> None:
    with pytest.warns(
        DeprecationWarning, match=r"rtol= is deprecated\. Use method=sr\.Radau\(rtol=1e-05\)"
    ) as seen:
        OTHERS[name]()
    assert seen[0].filename == __file__


def test_files_and_mappings_have_flat_keys_without_a_warning() -> None:
    from sarrus.studies.runs import run_of

    run = run_of({"type": "simulate", "until": 0.1, "rtol": 1e-5, "max_step": "1 ms", "method": "hht"})
    assert run == sr.Simulation(until=0.1, method=sr.HHT(rtol=1e-5, max_step=1e-3))
    default = run_of({"type": "simulate", "until": 0.1, "atol": 1e-5})
    assert default == run_of(default.described()) == sr.Simulation(until=0.1, method=sr.Radau(atol=1e-5))
    with pytest.raises(sr.SarrusError, match="unknown name"):
        run_of({"type": "simulate", "until": 0.1, "rtol": "small"})


def test_methods_are_values() -> None:
    kinds = {"position": "1 um", "orientation": 1e-8}
    assert hash(sr.Radau(atol=kinds)) == hash(sr.Radau(atol=dict(reversed(kinds.items()))))
    assert len({sr.Radau(atol=kinds), sr.Radau(atol=kinds), sr.Radau(rtol=[1e-9, 1e-8])}) == 2
    wrong: Any
    for wrong in (sr.Radau(), None):
        with pytest.raises(TypeError, match="DescribedMethod needs a Description, got"):
            sr.DescribedMethod(wrong)


def test_options_of_a_study_are_checked() -> None:
    wrong: Any = "all"
    with pytest.raises(ValueError, match='store must be "samples", "dense" or "steps", but is "all"'):
        sr.Simulation(until=0.1, store=wrong)
    with pytest.raises(TypeError, match="Name the others"):
        sr.Simulation(0.1, 10)  # type: ignore[misc]


def test_unknown_options_of_searches_name_what_was_called() -> None:
    for call in (sr.optimize, sr.fit):
        with pytest.raises(
            TypeError, match=f'^{call.__name__} has no argument "untl"\\. Did you mean "until"'
        ):
            call(ball(), sr.Final("b.z"), ["spring.k"], untl=0.1)  # type: ignore[operator]
    with pytest.raises(TypeError, match=r'^Problem has no argument "foo"\. Choose from system'):
        sr.Problem(ball(), sr.Final("b.z"), ["spring.k"], until=0.1, foo=3)  # type: ignore[call-arg]


def test_events_are_events_and_times() -> None:
    for wrong, message in (
        ("soon", "got str"),
        ([True], "got bool"),
        ([np.nan], "finite"),
        ({1: 2}, "got dict"),
    ):
        with pytest.raises((TypeError, ValueError), match=message):
            simulated(events=wrong)


def test_options_that_are_none_are_refused() -> None:
    for given, message in (
        ({"store": "all"}, 'store must be "samples", "dense" or "steps"'),
        ({"limits": 5.0}, r"limits must be sr\.Limits"),
        ({"limits": {"time": 5.0}}, r"limits must be sr\.Limits"),
        ({"save": 3}, "save must be the path"),
    ):
        with pytest.raises((TypeError, ValueError), match=message):
            simulated(**given)
    with pytest.raises(TypeError, match=r"no argument \"dense\""):
        simulated(dense=True)
