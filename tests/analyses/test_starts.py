"""Every analysis takes every kind of start, and refuses misuse with the right call in its message."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.analyses.test_states import wheel
from tests.sensitivity.checkpoints import by_checkpoints

import sarrus as sr


def hanging() -> sr.System:
    """A pendulum drawn 20 degrees from its rest."""
    angle = np.radians(20)
    at = (0.5 * np.sin(angle), 0.0, -0.5 * np.cos(angle))
    rod = sr.Body("rod", 2.0, (0.2, 0.2, 0.2), position=at)
    pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 1, 0))
    return sr.System(sr.Model("pendulum", [rod], [pin], gravity=(0, 0, -9.81)))


SYSTEM = hanging()


@cache
def rest() -> sr.Equilibrium:
    return sr.equilibrium(SYSTEM)


STARTS: dict[str, Callable[[], Any]] = {
    "equilibrium": rest,
    "assembly": lambda: sr.assemble(SYSTEM, rest().q, np.zeros(7)),
    "state": lambda: sr.State(0.0, rest().q, np.zeros(7), np.zeros(7), rest().lam),
    "coordinates": lambda: rest().q,
    "list": lambda: rest().q.tolist(),
}


@pytest.mark.parametrize("kind", STARTS)
def test_all_analyses_take_all_kinds_of_starts(kind: str) -> None:
    start = STARTS[kind]()
    frequency = np.sqrt(2.0 * 9.81 * 0.5 / (0.2 + 2.0 * 0.25)) / (2 * np.pi)
    assert sr.modes(SYSTEM, start).frequencies == pytest.approx([frequency])
    A = sr.linearize(SYSTEM, start).A
    assert np.sort(np.linalg.eigvals(A).imag)[-1] / (2 * np.pi) == pytest.approx(frequency)
    assert sr.mobility(SYSTEM, start).degrees_of_freedom == 1
    assert sr.equilibrium(SYSTEM, start).q == pytest.approx(rest().q, abs=1e-9)
    run = sr.simulate(SYSTEM, start, until=0.5)
    assert np.ptp(np.asarray(run.q), axis=0).max() < 1e-6
    found = by_checkpoints(SYSTEM, sr.Final("rod.z"), ["rod.mass"], until=0.1, start=start)
    assert found.value == pytest.approx(rest().q[2], abs=1e-6)


def test_a_start_has_its_time_in_kinematics_and_statics() -> None:
    driven = sr.System(replace(SYSTEM.model, drivers=[sr.AngleDriver("drive", "pin", "t")]))
    start = sr.assemble(driven, t=2.0)
    assert sr.equilibrium(driven, start).t == 2.0
    run = sr.kinematics(driven, [2.0, 2.5], start)
    assert run.success, run.message
    assert run.q[0] == pytest.approx(start.q)
    assert run.coordinate("rod.z")[0] == pytest.approx(-0.5 * np.cos(np.radians(20) + 2.0)) or (
        run.coordinate("rod.z")[0] == pytest.approx(-0.5 * np.cos(np.radians(20) - 2.0))
    )


def test_linearization_about_a_wound_state_has_the_torque_of_all_its_revolutions() -> None:
    """The spring's torque at rest at 16 revolutions, divided by the inertia, is what `unsteady` reports."""
    system = wheel()
    rates = sr.assemble(system, rates={"pin": 10.0})
    run = sr.simulate(
        system, rates, until=5 * np.pi, t_eval=[5 * np.pi], method=sr.Radau(rtol=1e-9, atol=1e-11)
    )
    assert run.final is not None
    assert run.final.memory[0] == pytest.approx(100.0, abs=1e-4)
    found = sr.linearize(system, run.final._replace(v=np.zeros(7)))
    angle = 100.0
    p_dot_dot = 0.5 * 0.01 * angle * np.array([-np.sin(angle / 2), 0, 0, np.cos(angle / 2)])
    assert found.unsteady == pytest.approx(abs(p_dot_dot).max(), rel=1e-4)


CALLS: dict[str, Any] = {
    "simulate": lambda x: sr.simulate(x, until=1.0),
    "equilibrium": sr.equilibrium,
    "modes": lambda x: sr.modes(x, rest()),
    "linearize": lambda x: sr.linearize(x, rest()),
    "mobility": sr.mobility,
    "kinematics": lambda x: sr.kinematics(x, [0.0, 1.0]),
    "assemble": sr.assemble,
    "optimize": lambda x: sr.optimize(x, sr.Final("rod.z"), ["rod.mass"], until=1.0),
    "fit": lambda x: sr.fit(x, [sr.Misfit("rod.z", at=[0.1], data=[0.0])], ["rod.mass"]),
    "inverse_dynamics": lambda x: sr.inverse_dynamics(x, sr.simulate(SYSTEM, until=0.1)),
    "singularities": lambda x: sr.singularities(x, sr.simulate(SYSTEM, until=0.1)),
    "workspace": lambda x: sr.workspace(x, ["rod.x", "rod.z"]),
    "workspace_range": lambda x: sr.workspace_range(x, "rod.x"),
    "workspace_volume": lambda x: sr.workspace_volume(x, ["rod.x", "rod.y", "rod.z"]),
    "input_singularities": lambda x: sr.input_singularities(x, ["rod.x"], ["pin"]),
    "dexterity": lambda x: sr.dexterity(x, rest().q, ["rod.x"], ["pin"]),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_model_in_the_place_of_a_system_is_refused_with_the_right_call(name: str) -> None:
    with pytest.raises(
        TypeError, match=rf"{name} needs a System, got a Model. Call sr.{name}\(sr.System\(model\), ...\)"
    ):
        CALLS[name](SYSTEM.model)
    with pytest.raises(TypeError, match=rf"{name} needs a System, got nothing"):
        CALLS[name](None)


@cache
def wrong() -> dict[str, Any]:
    state, assembly = STARTS["state"](), STARTS["assembly"]()
    return {
        "system": SYSTEM,
        "text": "rest",
        "run": sr.simulate(SYSTEM, until=0.1),
        "nan": np.where(np.arange(7) == 2, np.nan, rest().q),
        "short": np.zeros(3),
        "mapping": {"rod.z": 1.0},
        "bad state": state._replace(v=np.full(7, np.inf)),
        "bad assembly": replace(assembly, q=np.full(7, np.nan)),
    }


WRONG: dict[str, tuple[type[Exception], str]] = {
    "system": (
        TypeError,
        "a start must be an Assembly, a State, an Equilibrium or coordinates, got a System",
    ),
    "text": (TypeError, "got a str"),
    "run": (TypeError, r"Give run.final or run.state\(t\) of pendulum"),
    "nan": (ValueError, "q must be 7 finite numbers, but rod.r.z is nan"),
    "short": (ValueError, r"q must be 7 finite numbers, the coordinates of pendulum, got shape \(3,\)"),
    "mapping": (ValueError, "start: there is no key 'rod.z'. Give rates, equilibrium, run or t"),
    "bad state": (ValueError, "but rod.r.x is inf"),
    "bad assembly": (ValueError, "but rod.r.x is nan"),
}


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize(
    "analysis", ["simulate", "modes", "linearize", "mobility", "equilibrium", "kinematics"]
)
def test_what_is_no_start_is_refused(name: str, analysis: str) -> None:
    given, (error, message) = wrong()[name], WRONG[name]
    calls: dict[str, Any] = {
        "simulate": lambda: sr.simulate(SYSTEM, given, until=1.0),
        "modes": lambda: sr.modes(SYSTEM, given),
        "linearize": lambda: sr.linearize(SYSTEM, given),
        "mobility": lambda: sr.mobility(SYSTEM, given),
        "equilibrium": lambda: sr.equilibrium(SYSTEM, given),
        "kinematics": lambda: sr.kinematics(SYSTEM, [0.0, 1.0], given),
    }
    with pytest.raises(error, match=message):
        calls[analysis]()


def test_states_off_the_constraints_are_projected_with_a_warning() -> None:
    """Momentum of the rod alone, along and across the circle: across it nothing is left."""
    state = STARTS["state"]()
    skew = state._replace(v=np.array([1.0, 0, 3.0, 0, 0, 0, 0]))
    with pytest.warns(sr.SarrusWarning, match=r"rod: velocity \(1, 0, 3\) became"):
        run = sr.simulate(SYSTEM, skew, until=0.01)
    assert abs(run.velocity_violation[0]) < 1e-9
    with pytest.warns(sr.SarrusWarning, match="rod: velocity"):
        sr.simulate(SYSTEM, replace(STARTS["assembly"](), v=skew.v), until=0.01)
    with pytest.raises(sr.StrictError), sr.strict():
        sr.simulate(SYSTEM, skew, until=0.01)
    moved = rest().q + np.array([0.1, 0, 0, 0, 0, 0, 0])
    with pytest.warns(sr.SarrusWarning, match="rod: position"):
        sr.simulate(SYSTEM, moved, until=0.01)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sr.simulate(SYSTEM, sr.simulate(SYSTEM, until=0.3).final, until=0.6)


@pytest.mark.parametrize("until", [np.nan, np.inf, 0.0, -1.0, 1e-300, 5e-324])
def test_an_end_that_is_none_is_refused(until: float) -> None:
    with pytest.raises(ValueError, match=r"until must be a (positive time in s|finite number), but is"):
        sr.simulate(SYSTEM, until=until)


@pytest.mark.parametrize("times", [[np.nan], [0.1, np.nan], [np.inf], [], [0.2, 0.1], [[0.1]]])
def test_times_that_are_none_are_refused(times: Any) -> None:
    with pytest.raises(
        ValueError, match=r"t_eval must be (rising times between the start at 0 s|finite numbers)"
    ):
        sr.simulate(SYSTEM, until=1.0, t_eval=times)


BAD: dict[str, Any] = {
    "alpha nan": lambda: sr.HHT(np.nan),
    "alpha 0.5": lambda: sr.HHT(0.5),
    "step nan": lambda: sr.HHT(step=np.nan),
    "step 0": lambda: sr.GeneralizedAlpha(step=0.0),
    "rho nan": lambda: sr.GeneralizedAlpha(np.nan),
    "rho 2": lambda: sr.GeneralizedAlpha(2.0),
    "restitution nan": lambda: sr.Impact(np.nan),
    "restitution 5": lambda: sr.Impact(5),
    "restitution -0.1": lambda: sr.Impact(-0.1),
}


@pytest.mark.parametrize("name", BAD)
def test_numbers_of_methods_and_impacts_are_checked(name: str) -> None:
    with pytest.raises(ValueError, match=r"must (be|lie)"):
        BAD[name]()


def test_an_event_function_that_returns_nan_ends_the_run() -> None:
    def height(t: float, q: np.ndarray, v: np.ndarray) -> float:
        return float(np.sqrt(0.1 - t)) if t < 0.1 else np.nan

    run = sr.simulate(SYSTEM, until=0.5, events=sr.Event(height))
    assert not run.success
    assert run.status == "event undefined"
    assert "the event height has no value at t = 0.1" in run.message
