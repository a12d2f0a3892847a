"""Stored steps of saved runs with events and corners: derivatives are those of the run in memory, to the last bit."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.sensitivity.test_corners import ball

import sarrus as sr
from sarrus.analyses.dynamics.time_loop import recording


def slower(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A reset in Python."""
    return 0.9 * v


def falling() -> sr.System:
    body = sr.Body("b", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, 1), velocity=(1, 0, -0.5))
    drag = sr.PointForce("drag", body.point(0, 0, 0), (1, 0, 0), factor=-0.1)
    return sr.System(sr.Model("ball", [body], forces=[drag], gravity=(0, 0, -9.81)))


BOUNCE = sr.Event("b.z", direction=-1, reset=sr.Impact(0.8), name="bounce")
CASES: dict[str, tuple[Any, dict[str, Any], list[str]]] = {
    "impacts": (falling, {"events": BOUNCE, "until": 1.5}, ["b.mass", "bounce.restitution"]),
    "reset, and an end": (
        falling,
        {
            "events": [
                sr.Event("b.x - 0.2", reset=slower, name="gate"),
                sr.Event("b.z", terminal=True, name="end"),
            ],
            "until": 1.5,
        },
        ["b.mass", "b.position.z"],
    ),
    "corners": (ball, {"until": 0.5}, ["b.mass", "floor.stiffness"]),
    "corners, HHT": (ball, {"until": 0.5, "method": sr.HHT()}, ["b.mass", "floor.stiffness"]),
}


def numbers(run: sr.Trajectory, names: list[str]) -> list[float]:
    """Derivatives, an estimate of an error, and the times of all stored nodes."""
    assert run.steps is not None
    found = sr.sensitivity(run, [sr.Final("b.z"), sr.Integral("b.x")], names).matrix
    return [*found.ravel(), run.error("b.z").error, *run.steps.t]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("case", CASES)
def test_saved_runs_have_the_derivatives_of_those_in_memory(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also when continued after an interruption between events, with a mark after every chunk of steps."""
    monkeypatch.setattr(recording, "PAUSE", 0.0)
    monkeypatch.setattr(recording, "PATIENT", 0.0)
    system, settings, names = CASES[case]
    whole = sr.simulate(system(), store="steps", **settings)
    wanted = numbers(whole, names)
    assert len(whole.steps.event_steps) > 1
    first = whole.steps.event_steps[0].t

    def interrupt(t: float) -> None:
        if t >= first:
            raise KeyboardInterrupt

    folder = tmp_path / "whole"
    saved = sr.simulate(system(), store="steps", save=folder, **settings)
    cut = sr.simulate(system(), store="steps", save=tmp_path / "cut", progress=interrupt, **settings)
    assert cut.status == "stopped"
    assert 0 < len(cut.steps) < len(whole.steps)
    how = {"events": settings["events"]} if "reset" in case else {}  # one has a Python function
    continued = sr.resume(tmp_path / "cut", **how)
    for run in (
        saved,
        sr.resume(folder, **how),
        sr.repeat(folder, **how),
        continued,
        sr.resume(tmp_path / "cut", **how),
    ):
        assert run.status == whole.status
        np.testing.assert_array_equal(numbers(run, names), wanted)
    second = [sr.hessian(run, sr.Final("b.z"), names).matrix for run in (continued, whole)]
    np.testing.assert_array_equal(*second)


def test_functions_of_events_are_passed_again(tmp_path: Path) -> None:
    """Also lambdas; the message names what is missing, and other events are refused."""
    event = sr.Event(lambda t, q, v: q[2], reset=lambda t, q, v: -0.5 * v, name="bounce")
    folder = tmp_path / "run"
    run = sr.simulate(falling(), until=0.6, events=event, store="steps", save=folder)
    whole = sr.simulate(falling(), until=0.6, events=event, store="steps")
    assert len(run.events) == 1
    for again in (run, sr.resume(folder, events=event), sr.repeat(folder, events=[event])):
        found, wanted = (sr.sensitivity(one, sr.Final("b.z"), ["b.mass"]).matrix for one in (again, whole))
        np.testing.assert_array_equal(found, wanted)
        assert sr.verify(again).agree
    with pytest.raises(
        sr.SarrusError, match=r"run: does not contain <lambda> of its events.* Pass events= again"
    ):
        sr.resume(folder)
    with pytest.raises(sr.SarrusError, match=r"run: was computed with other events\. Pass those of the run"):
        sr.resume(folder, events=replace(event, direction=-1))
    with pytest.raises(ValueError, match=r"stored in .*run\. Open it with"):
        sr.sensitivity(sr.load_run(folder, falling()), "b.z", ["b.mass"])


def test_a_method_of_the_user_is_passed_again(tmp_path: Path) -> None:
    given = {"until": 0.3, "save": tmp_path / "run"}
    method = sr.HHT().description
    run = sr.simulate(falling(), method=method, **given)
    with pytest.raises(sr.SarrusError, match=r"run: does not contain Description of its method"):
        sr.repeat(tmp_path / "run")
    assert np.array_equal(sr.repeat(tmp_path / "run", method=method).q, np.asarray(run.q))
    with pytest.raises(sr.SarrusError, match="computed with other method"):
        sr.repeat(tmp_path / "run", method=sr.HHT())


def test_a_system_that_files_cannot_describe_is_passed_again(tmp_path: Path) -> None:
    """As one with a Python function of outputs; a system with other parameters is refused."""

    def blown(mass: float = 1.0) -> sr.System:
        body = sr.Body("b", mass=mass, inertia=(0.1, 0.1, 0.1))
        slide = sr.Translational("slide", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
        gust = sr.Force("gust", joint="slide", value=lambda o: 3.0 - o("b.x"))
        return sr.System(sr.Model("b", [body], [slide], [gust]))

    run = sr.simulate(blown(), until=0.3, save=tmp_path / "run")
    with pytest.raises(sr.SarrusError, match=r"does not contain its model .*Pass the same system, as in"):
        sr.repeat(tmp_path / "run")
    again = sr.repeat(tmp_path / "run", system=blown())
    assert np.array_equal(again.q, np.asarray(run.q))
    with pytest.raises(sr.SarrusError, match="another system than b, whose parameters differ"):
        sr.repeat(tmp_path / "run", system=blown(2.0))
    assert sr.load_run(tmp_path / "run").system is None


def test_a_loaded_run_names_the_folder_that_holds_its_steps(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    sr.simulate(falling(), until=0.1, store="steps", save=folder)
    for run in (sr.load_run(folder), sr.load_run(folder, falling())):
        with pytest.raises(
            ValueError, match=r"steps of the run, which are stored in .*run\. Open it with"
        ) as wrong:
            sr.sensitivity(run, "b.z", ["b.mass"])
        assert str(wrong.value).endswith(f"sarrus.resume({str(folder)!r}).")
    assert sr.sensitivity(sr.resume(folder), "b.z", ["b.position.z"]).matrix == pytest.approx(1.0)
    run = sr.simulate(falling(), until=0.1, save=tmp_path / "without")
    run.save(tmp_path / "later")
    for name in ("without", "later"):
        remedy = rf"are not in .*{name}\. Repeat it by simulate\(\.\.\., store='steps', save=folder\), and open it by"
        for ask in (lambda one: sr.sensitivity(one, "b.z", ["b.mass"]), lambda one: one.error("b.z")):
            with pytest.raises(ValueError, match=remedy):
                ask(sr.load_run(tmp_path / name, falling()))
