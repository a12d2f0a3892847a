"""What the rig refuses: arguments, vehicles, springs, names, and entries of files; each with a message."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import nan
from pathlib import Path

import pytest
from tests.vehicles.published import RADIUS, V23, corner, metres, model
from tests.vehicles.test_rig import axle, sided

import sarrus as sr
from sarrus import mechanisms
from sarrus.cli import main

RACK = {"steering": "rack", "steps": 1, "forward": "-x"}


def wheel(**changes: object) -> sr.Corner:
    return replace(corner(V23, RADIUS["V23"]), **changes)


@cache
def system() -> sr.System:
    return sr.System(model(V23, rack=True))


@cache
def plain() -> sr.Suspension:
    return sr.suspension(system(), right=wheel(), **RACK)


@cache
def virtual() -> sr.Suspension:
    """Only the sweep of the virtual kingpin."""
    return sr.suspension(system(), right=wheel(kingpin=None), bump=None, **RACK)


def refusal(message: str, call: Callable[[], object]) -> None:
    with pytest.raises((sr.SarrusError, TypeError)) as caught:
        call()
    assert message in str(caught.value)


VEHICLES = {
    "wheelbase must be greater than 0": {"wheelbase": -1.0},
    "wheelbase must be a finite number": {"wheelbase": nan},
    "brake_share must be between 0 and 1": {"brake_share": 81},
    "tyre_stiffness must be greater than 0": {"tyre_stiffness": -2e4},
    "inboard_brakes must be True or False": {"inboard_brakes": "no"},
}


@pytest.mark.parametrize("message", VEHICLES)
def test_wrong_vehicles(message: str) -> None:
    refusal(message, lambda: sr.Vehicle(**VEHICLES[message]))


def test_an_axle_that_does_not_brake() -> None:
    """A share of 0 is a share: its anti-dive is 0."""
    vehicle = sr.Vehicle(wheelbase=2.5, cg_height=0.5, brake_share=0.0)
    assert sr.suspension(system(), right=wheel(), vehicle=vehicle, **RACK).at("anti_dive") == 0.0


ARGUMENTS = {
    "bump must have 2 numbers, but has 0": {"bump": ()},
    "bump must have 2 numbers, but has 1": {"bump": (0.05,)},
    "bump must be a list of numbers": {"bump": 0.05},
    "bump must be in m": {"bump": ("-50 N", "50 mm")},
    "there is no sweep. Give limits": {"bump": None},
    "vehicle must be a vehicle": {"vehicle": {}},
    "fixed must be a list of names": {"fixed": "knuckle"},
    "right must be a corner": {"right": "knuckle"},
    "radius must be in m": {"right": wheel(radius="0.3 kg")},
    "radius must be a finite number": {"right": wheel(radius=float("inf"))},
    "kingpin must be two points": {"right": wheel(kingpin=5)},
    "bump: 50 m is more than the diameter of a wheel, 0.5588 m": {"bump": (-50, 50)},
    "steer: 60 m is more than the diameter": {"steer": (-60, 20)},
    "carrier must be a name": {"right": wheel(carrier=5)},
    "bearing: there is no joint coordinate": {"right": wheel(bearing="hub")},
}


@pytest.mark.parametrize("message", ARGUMENTS)
def test_wrong_arguments(message: str) -> None:
    refusal(message, lambda: sr.suspension(system(), **{"right": wheel(), **RACK, **ARGUMENTS[message]}))


def test_lengths_and_angles_as_texts() -> None:
    """Of a radius and of all sweeps; a shaft steers by an angle."""
    found = sr.suspension(
        system(), right=wheel(radius="279.4 mm"), bump=("-30 mm", "3 cm"), steer=("-5 mm", 0.01), **RACK
    )
    assert found.x() == pytest.approx([-0.03, 0.0, 0.03], abs=1e-15)
    assert found.x("steer") == pytest.approx([-0.005, 0.0, 0.01], abs=1e-15)
    assert found.at("scrub_radius") == pytest.approx(plain().at("scrub_radius"), rel=1e-12)
    rolled = sr.suspension(
        axle(), sided("left"), sided("right"), steering="rack", steps=1, bump=None, roll=("-20 mm", "20 mm")
    )
    assert rolled.x("roll") == pytest.approx([-0.02, 0.0, 0.02], abs=1e-15)
    refusal("steer must be in m", lambda: sr.suspension(system(), right=wheel(), steer=("-5 deg", 0), **RACK))


def wishbones() -> sr.Model:
    return sr.load(mechanisms.path("double_wishbone"))


LINKED = sr.Corner("knuckle", "wheel", "spindle", 0.3, kingpin=("lower_ball", "upper_ball"), spring="spring")


def test_parts_with_the_names_of_points_of_the_rig() -> None:
    """All parts that the rig adds have names of their own, also in the analysis of compliance."""
    words = ["centre", "spindle", "lower", "upper", "pad", "load", "moment", "on_road", "on_hub", "aligning"]
    model = wishbones()
    at = model.bodies[0].point(0, 0, 0)
    named = [f"{word}_{side}" for word in (*words, "x", "y", "Fx", "steer") for side in ("left", "right")]
    marked = [sr.PointForce(name, at, (0.0, 0.0, 0.0)) for name in (*named, "steering_of_rig")]
    both = (
        sr.suspension(sr.System(one), LINKED, LINKED, steering="rack", steps=1)
        for one in (model, replace(model, forces=[*model.forces, *marked]))
    )
    expected, found = both
    assert found["toe"] == pytest.approx(expected["toe"], abs=1e-12)
    soft, known = found.compliance(), expected.compliance()
    assert soft["lateral_force_steer"] == pytest.approx(known["lateral_force_steer"], rel=1e-9)


def test_hardpoints_on_both_sides() -> None:
    """The joint is at the given point of the left side, and its image is on the right."""
    y = float(wishbones().hardpoints["lower_ball"][1])
    wrong = sr.System(wishbones().with_parameters({"lower_ball.y": -y}))
    for side in ("left", "right"):
        refusal(
            f'{side}: its hardpoints are on both sides of y = 0: "wheel" at',
            lambda side=side: sr.suspension(wrong, **{side: LINKED}, steering="rack", steps=1),
        )


def test_one_wheel_of_two() -> None:
    """The carrier of the other side is free: the message names it, and to fix it is sufficient."""
    one = sr.System(wishbones())
    refusal(
        'that stand still with fixed=["knuckle_right"], the joint',
        lambda: sr.suspension(one, left=LINKED, steering="rack", steps=1),
    )
    found = sr.suspension(one, left=LINKED, steering="rack", steps=1, fixed=["knuckle_right"])
    assert found.success


def test_displacements_that_are_no_numbers() -> None:
    refusal("must be a finite number", lambda: plain().at("toe", nan))
    refusal("must be a finite number", lambda: plain().compliance(nan))
    refusal('"cm" is out of place', lambda: plain().at("toe", "two cm"))
    refusal("kg", lambda: plain().at("toe", "20 kg"))


def test_wrong_names() -> None:
    result = plain()
    refusal("there is no name of a characteristic", lambda: result.sensitivity([]))
    refusal(
        "ride_steer is the slope of toe in bump, not in steer", lambda: result.at("ride_steer", sweep="steer")
    )
    refusal("there is no 'tow'. Did you mean", lambda: result.plot("bump", "tow"))
    refusal("there is no left wheel", lambda: result.table("bump", "left"))
    soft = result.compliance()
    refusal("there is no left wheel", lambda: soft.value("wheel_rate", "left"))


def test_one_parameter() -> None:
    """Its name need not be in a list."""
    soft = plain().compliance()
    assert soft.sensitivity("wheel_rate", wrt="spring.k").names == ("spring.k",)


def test_a_kingpin_of_a_name_and_coordinates() -> None:
    mixed = wheel(kingpin=("lower_ball", metres(V23)["upper_ball"]))
    found = sr.suspension(system(), right=mixed, **RACK)
    assert found["caster"] == pytest.approx(plain()["caster"], rel=1e-12)


def test_slopes_in_a_plot() -> None:
    (axes,) = plain().plot("bump", "ride_steer")
    assert axes.get_ylabel().endswith("[deg/mm]")


def test_only_a_virtual_kingpin(tmp_path: Path) -> None:
    """It is printed, written and drawn as other sweeps."""
    result = virtual()
    assert "caster" in str(result)
    assert "kingpin" in result.table("kingpin")
    result.to_csv(tmp_path / "axis.csv", "kingpin")
    assert len((tmp_path / "axis.csv").read_text().splitlines()) == 2
    assert len(result.plot("kingpin")) == len(result.names("kingpin"))


def test_springs_need_a_length() -> None:
    push = sr.PointForce("push", system().model.bodies[0].point(0, 0, 0), (0.0, 0.0, 1.0))
    pushed = sr.System(replace(system().model, forces=[*system().model.forces, push]))
    refusal(
        'spring names the force "push", which has no length',
        lambda: sr.suspension(pushed, right=wheel(spring="push"), **RACK),
    )


def test_both_corners_need_the_spring() -> None:
    """A ratio is left out if one of two corners has no spring; without limits of roll, the message asks for them."""
    springs = replace(sided("left"), spring="spring_left"), sided("right")
    result = sr.suspension(axle(), *springs, steering="rack", steps=1, roll=None)
    assert "spring_ratio" not in result.names()
    refusal("spring_ratio needs spring. Name it", lambda: result.curve("spring_ratio", side="right"))
    assert "toe" in str(result)
    refusal("Give limits, roll=(-0.03, 0.03)", lambda: result.table("roll"))


def test_forces_that_use_tyres() -> None:
    """The message states that the rig removes them."""
    whole = system().model
    body = next(one for one in whole.bodies if one.name == "knuckle")
    tyre = sr.Tyre("tyre", body.point(0, 0, 0), radius=0.3, k=2e5, c=100.0)
    push = sr.PointForce("push", body.point(0, 0, 0), ("0*t", "0*t", "tyre.compression"))
    rolling = sr.System(replace(whole, forces=[*whole.forces, tyre, push]))
    refusal(
        "The rig has no tyres, drivelines of wheels and controllers (tyre)",
        lambda: sr.suspension(rolling, right=wheel(), **RACK),
    )
    taken = sr.PointForce("rig_centre_right", body.point(0, 0, 0), (0.0, 0.0, 0.0))
    other = sr.System(replace(whole, forces=[*whole.forces, tyre, taken]))
    with pytest.raises(sr.SarrusError, match=r"rig_centre_right.* is taken") as caught:
        sr.suspension(other, right=wheel(), **RACK)
    assert "The rig has no tyres" not in str(caught.value)


FILE = """
model: corner.json
wheels:
  right: {carrier: knuckle, centre: [0, 650 mm, 0], spindle: [0, 551.87 mm, 0], radius: 279.4 mm,
    kingpin: [lower_ball, upper_ball], spring: spring}
forward: -x
steering: rack
fixed: []
bump: [-50 mm, 50 mm]
steps: 2
"""
ENTRIES = {
    ("steps: 2", "steps:"): "wrong.yaml:10: rig, steps: must be a whole number",
    ("steps: 2", "steps: abc"): "wrong.yaml:10: rig, steps: must be a whole number",
    ("steps: 2", "steps: 2.7"): "wrong.yaml:10: rig, steps: must be a whole number",
    ("steps: 2", "steps: true"): "wrong.yaml:10: rig, steps: must be a whole number",
    ("steps: 2", "steps: 0"): "wrong.yaml:10: rig, steps: must be a whole number",
    ("279.4 mm", "null"): "wrong.yaml:4: rig, wheels.right: the value must be a number",
    ("279.4 mm", "[1, 2]"): "wrong.yaml:4: rig, wheels.right: the value must be a number",
    ("279.4 mm", "true"): "wrong.yaml:4: rig, wheels.right: the value must be a number",
    ("[lower_ball, upper_ball]", "5"): "wrong.yaml:4: rig, wheels.right: right: kingpin must be two points",
    ("[0, 650 mm, 0]", "[0, 650 mm]"): "wrong.yaml:4: rig, wheels.right: right: centre must be three numbers",
    ("-50 mm, 50 mm", "-50 mm, null"): "wrong.yaml:9: rig, bump: the value must be a number",
    ("fixed: []", "fixed: knuckle"): "wrong.yaml:8: rig, fixed: must be a list of names",
    ("fixed: []", "fixed: [nob]"): "wrong.yaml:8: rig, fixed: the model has no body 'nob'",
    ("forward: -x", "forward: 5"): "wrong.yaml:6: rig, forward: must be one of x, -x",
    ("steps: 2", "steer: [-20 N, 20 N]"): "wrong.yaml:10: rig, steer: must be in m",
    ("steps: 2", "steer: [-20 deg, 20 deg]"): "wrong.yaml:10: rig, steer: must be in m",
    ("steps: 2", "vehicle: {inboard_brakes: 'no'}"): "wrong.yaml:10: rig, vehicle: vehicle: inboard_brakes must be",
    ("-50 mm, 50 mm", "10 mm, 50 mm"): "wrong.yaml: bump: the limits must be on both sides of 0",
}  # fmt: skip


@pytest.mark.parametrize("change", ENTRIES, ids=lambda change: change[1])
def test_wrong_files(
    change: tuple[str, str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    system().model.save(tmp_path / "corner.json")
    assert change[0] in FILE
    (tmp_path / "wrong.yaml").write_text(FILE.replace(*change))
    assert main(["suspension", "wrong.yaml"]) == 2
    assert ENTRIES[change] in capsys.readouterr().err
