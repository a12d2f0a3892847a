"""Whether a reaction is determined, or a choice among redundant joints, against counts of equations by hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.analyses.test_invariant_reactions import NAMES, WAYS, cupboard

import sarrus as sr
from sarrus.cli import main

HEIGHTS = {"low": 0.3, "high": 1.7}


def door(kind: type[sr.Joint], tilt: float = 0.0) -> sr.System:
    """A door on two joints in line with z, or with an axis that is tilted about x by an angle."""
    turned = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    leaf = sr.Body("leaf", 20, (2, 1, 1.5), position=tuple(turned @ (0.4, 0, 1)))
    axis = {"axis": tuple(turned[:, 2])} if kind is sr.Revolute else {}
    joints = [
        kind(name, sr.ground, leaf, point=tuple(turned @ (0, 0, height)), **axis)
        for name, height in HEIGHTS.items()
    ]
    return sr.System(sr.Model("door", [leaf], joints, gravity=(0.0, 0.0, -9.81)))


def test_balls_share_along_their_line_only() -> None:
    """Equal and opposite forces along the line through both do nothing; across it, moments decide."""
    run = sr.simulate(door(sr.Spherical), until=0.1, t_eval=[0, 0.1])
    shared = {axis: run.output(f"low.force.{axis}").shared for axis in "xyz"}
    assert shared == {"x": (), "y": (), "z": ("low", "high")}
    assert run.output("low.torque.x").shared == run.output("leaf.acceleration.z").shared == ()
    sentence = "shared by low and high: the joints are redundant, and this is the share of least norm."
    assert str(run.reaction("high")).splitlines()[1] == sentence
    assert str(run.output("high.force.z")).splitlines()[1] == sentence
    assert "shared" not in str(run.output("high.force.x"))
    assert run["low.force.z"] + run["high.force.z"] == pytest.approx(20 * 9.81)


def test_tilted_line() -> None:
    """The line has a component along y as well."""
    run = sr.simulate(door(sr.Spherical, 0.3), until=0.1, t_eval=[0, 0.1])
    shared = [run.output(f"low.force.{axis}").shared for axis in "xyz"]
    assert shared == [(), ("low", "high"), ("low", "high")]


def test_hinges_share_everything_but_the_moment_about_their_axis() -> None:
    """Each hinge alone would hold the door."""
    rest = sr.equilibrium(door(sr.Revolute), stable=False)
    found = rest.reaction("low")
    assert found.shared == ("low", "high")
    assert "shared by low and high" in str(found)
    point, force, torque, axes = found  # as of `System.reaction`
    assert force == pytest.approx(rest["low.force"])
    run = sr.simulate(door(sr.Revolute), until=0.1)
    assert [run.output(f"low.torque.{axis}").shared for axis in "xyz"] == [
        ("low", "high"),
        ("low", "high"),
        (),
    ]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("way", ["millimetres", "other units", "order"])
def test_pairs_of_a_cupboard(way: str) -> None:
    """Hinges, rails and doubled balls in series: what one pair shares does not load the next."""
    system = cupboard(WAYS[way])
    rest = sr.simulate(system, until=1e-3, t_eval=[0, 1e-3])
    for pair in NAMES.values():
        for joint in pair:
            assert {*rest.reaction(joint).shared} == {*pair}


def test_formulas() -> None:
    """The load of both balls is determined, the ratio of their shares is not."""
    run = sr.simulate(door(sr.Spherical), until=0.1, t_eval=[0, 0.1])
    assert run.output("low.force.z + high.force.z").shared == ()
    assert run.output("low.force.z / high.force.z").shared == ("low", "high")


def four_bar(kinds: list[type[sr.Joint]]) -> sr.System:
    """A planar four-bar about y, in the plane y = 0."""
    points = np.array([[0, 0, 0], [0.2, 0, 0.4], [1.1, 0, 0.9], [1.2, 0, 0]])
    bars = [
        sr.Body(f"bar_{n}", 1, (0.1, 0.1, 0.1), position=tuple((points[n] + points[n + 1]) / 2))
        for n in range(3)
    ]
    joints = [
        kind(f"pin_{n}", i, j, point=tuple(points[n]), **({"axis": (0, 1, 0)} if kind is sr.Revolute else {}))
        for n, (kind, i, j) in enumerate(zip(kinds, [sr.ground, *bars], [*bars, sr.ground], strict=True))
    ]
    return sr.System(sr.Model("four bar", bars, joints, gravity=(0.0, 0.0, -9.81)))


def test_four_bars() -> None:
    """In space, four hinges share what acts out of the plane; with balls at the coupler all is determined."""
    R, S = sr.Revolute, sr.Spherical
    run = sr.simulate(four_bar([R, R, R, R]), until=0.05)
    pins = tuple(f"pin_{n}" for n in range(4))
    assert [run.output(f"pin_1.force.{axis}").shared for axis in "xyz"] == [(), pins, ()]
    assert [run.output(f"pin_1.torque.{axis}").shared for axis in "xyz"] == [pins, (), pins]
    run = sr.simulate(four_bar([R, S, S, R]), until=0.05)
    for name in pins:
        assert run.reaction(name).shared == ()
        assert "shared" not in str(run.reaction(name))
    assert run.reaction("pin_0").joint == "pin_0"


def test_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The table of reactions ends with the sentence."""
    both = door(sr.Revolute).model
    for model, said in ((both, True), (replace(both, joints=both.joints[:1]), False)):
        model.save(file := tmp_path / "door.yaml")
        assert main(["statics", str(file), "--nearest"]) == 0
        assert ("reactions shared by low and high: " in capsys.readouterr().out) == said


@pytest.mark.filterwarnings("ignore:m2. m1 drives h")
def test_two_motors() -> None:
    """Two drivers of one hinge share its torque; the hinge itself is determined."""
    arm = sr.Body("arm", 1, (1, 1, 1), position=(1, 0, 0))
    hinge = sr.Revolute("h", sr.ground, arm, point=(0, 0, 0), axis=(0, 1, 0))
    motors = [sr.AngleDriver(name, "h", "0") for name in ("m1", "m2")]
    run = sr.kinematics(sr.System(sr.Model("arm", [arm], [hinge], drivers=motors)), [0.0, 0.1])
    assert run.reaction("m1").shared == ("m1", "m2")
    assert run.reaction("h").shared == ()
