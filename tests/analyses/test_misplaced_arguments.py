"""Arguments of a near kind are refused by a message with the right call."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr


@pytest.fixture(scope="module")
def pendulum() -> sr.System:
    """An arm on a pin."""
    arm = sr.Body("arm", mass=1, inertia=(1, 1, 1), position=(1, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.System(sr.Model("pendulum", [arm], [pin]))


def test_the_class_of_an_analysis_is_not_one(pendulum: sr.System) -> None:
    with pytest.raises(
        sr.SarrusError, match=r"Simulation is a class. Give its options: Simulation\(\.\.\.\)"
    ):
        sr.study(pendulum.model, {"arm.mass": [1, 2]}, {"x": "arm.x"}, analysis=sr.Simulation)


@pytest.mark.parametrize("given", [sr.Final("arm.x"), [sr.Final("arm.x")], [], 3])
def test_only_measurements_are_fitted(pendulum: sr.System, given: object) -> None:
    with pytest.raises(TypeError, match=r"fit needs one or several Misfit, .*sr\.Misfit\(output"):
        sr.fit(pendulum, given, ["arm.mass"], until=0.1)  # type: ignore[arg-type]


def test_reactions_need_whole_states(pendulum: sr.System) -> None:
    with pytest.raises(ValueError, match=r"lam must have shape \(6,\), got \(1,\)\."):
        pendulum.reaction("pin", pendulum.q0, [1.0])
    with pytest.raises(ValueError, match=r"q must have shape \(7,\), got \(3,\)\."):
        pendulum.reaction("pin", np.zeros(3), np.zeros(6))


def test_a_saved_run_names_the_call_that_gives_its_joints(pendulum: sr.System, tmp_path: Path) -> None:
    folder = tmp_path / "run.sarrus"
    sr.simulate(pendulum, until=0.1, save=folder)
    assert sr.load_run(folder).joint("pin").angle[-1] == 0
    saved = replace(
        sr.load_run(folder), system=None, joints=None
    )  # as where a file cannot describe the model
    for ask in (saved.joint, saved.reaction):
        with pytest.raises((KeyError, ValueError), match=r"sarrus\.load_run\(folder, system\)"):
            ask("pin")
    assert sr.load_run(folder, pendulum).joint("pin").angle[-1] == 0
