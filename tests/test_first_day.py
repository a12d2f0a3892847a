"""Messages and prints that the first day with the program depends on."""

import numpy as np
import pytest

import sarrus as sr
from sarrus.cli import main

ARM = sr.Body("arm", mass=2.0, inertia=(1, 1, 1), position=(1, 0, 0))
PIN = sr.Revolute("pin", sr.ground, ARM, point=(0, 0, 0), axis=(0, 0, 1))
FIRST = sr.AngleDriver("first", "pin", "3*t")


def driven(*more: sr.Driver) -> sr.Trajectory:
    return sr.kinematics(sr.System(sr.Model("m", [ARM], [PIN], drivers=[FIRST, *more])), until=1.0, steps=4)


def test_outputs_of_a_part_by_subscript() -> None:
    run = driven()
    assert np.array_equal(run["arm"]["x"], run["arm.x"])
    assert np.array_equal(run["arm"]["velocity"], run["arm"].velocity)
    assert np.array_equal(run["pin"]["force.x"], run["pin.force.x"])
    with pytest.raises(KeyError, match="Did you mean"):
        run["arm"]["xx"]


def test_a_reaction_is_printed_with_its_size() -> None:
    """The centripetal force of 2 kg at 1 m with 3 rad/s is 18 N."""
    text = str(driven().reaction("pin"))
    assert text.startswith("reaction of pin at 5 times: force up to 18 N, torque up to ")


@pytest.mark.filterwarnings("ignore:second")
def test_drivers_that_contradict_each_other_are_named() -> None:
    """Two motions of one angle: the mechanism cannot move at all, so it does not lock at some time."""
    run = driven(sr.AngleDriver("second", "pin", "2*t"))
    assert run.status == "not assembled"
    assert "at t = 0 s no velocity satisfies all equations; missed: second" in run.message
    assert "in 0 steps" not in run.summary()
    assert driven(sr.AngleDriver("second", "pin", "3*t")).success


def test_names_of_other_programs_and_of_analyses() -> None:
    with pytest.raises(AttributeError, match=r"sr\.AngleDriver or sr\.DisplacementDriver with a motion"):
        _ = sr.VelocityDriver
    with pytest.raises(AttributeError, match=r"sr\.FormulaCoupler on a curve"):
        _ = sr.Rail
    system = sr.System(sr.Model("m", [ARM], [PIN]))
    with pytest.raises(AttributeError, match=r"sarrus\.animate\(run, \.\.\.\)"):
        system.animate()
    with pytest.raises(AttributeError, match=r"sarrus\.simulate\(system, \.\.\.\)"):
        system.simulate()
    with pytest.raises(AttributeError, match='Did you mean "simulate"'):
        system.simulat()


def test_options_that_only_look_alike_are_not_suggested(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "slider_crank", "--until", "1", "--out", "x.png"]) == 2
    assert "--plot" not in capsys.readouterr().err
    assert main(["run", "slider_crank", "--until", "1", "--colunms", "x"]) == 2
    assert 'Did you mean "--columns"?' in capsys.readouterr().err
