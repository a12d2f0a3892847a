"""The car of the package: its suspension on the rig, and what its manoeuvres need."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import sarrus as sr
from sarrus.studies.suspension import read_suspension_file

OTHER = {"front": "rear", "rear": "front"}
SHARE = {"front": 0.68, "rear": 0.32}


@cache
def axle(name: str) -> sr.Suspension:
    """An axle on the rig, with the other one and the chassis fixed."""
    system = sr.System(sr.load("car"))
    parts = ("lower_arm", "upper_arm", "upright")
    fixed = ["chassis", *(f"{part}_{OTHER[name]}_{side}" for part in parts for side in ("left", "right"))]
    x, y, z = np.array([float(one) for one in system.model.hardpoints[f"{name}_wheel"]])
    corners = {
        side: sr.Corner(
            f"upright_{name}_{side}",
            (x, sign * y, z),
            (x, sign * (y - 0.1), z),
            0.29,
            kingpin=(f"lower_ball_{name}_{side}", f"upper_ball_{name}_{side}"),
            spring=f"spring_{name}_{side}",
        )
        for side, sign in (("left", 1.0), ("right", -1.0))
    }
    vehicle = sr.Vehicle(wheelbase=2.6, cg_height=0.55, brake_share=SHARE[name], tyre_stiffness=210e3)
    steering = {"steering": "rack_guide"} if name == "front" else {}
    held = [] if steering else ["rack"]
    return sr.suspension(system, **corners, fixed=[*fixed, *held], forward="x", vehicle=vehicle, **steering)


def slope(name: str, of: str) -> float:
    """In bump [deg/mm]."""
    return float(np.degrees(axle(of).at(name, slope=True)) * 1e-3)


def test_the_axles_are_those_of_a_passenger_car() -> None:
    """Front wheels toe out in bump and rear ones in: roll understeer. Usual ranges of the others."""
    assert -0.01 < slope("toe", "front") < 0 < slope("toe", "rear") < 0.01
    for name in ("front", "rear"):
        found = axle(name)
        assert -0.04 < slope("camber", name) < -0.02
        assert 0.03 < found.at("roll_centre_height") < 0.12
        assert 17e3 < found.compliance()["wheel_rate"] < 30e3
        against = found.at("roll_camber", sweep="roll", side="right")
        assert 0.3 < abs(against) < 0.7  # deg/deg
    assert 10 < axle("front").at("anti_dive") < 40
    assert 10 < axle("rear").at("anti_lift") < 40
    assert 3 < np.degrees(axle("front").at("caster")) < 7
    assert 0.01 < axle("front").at("caster_trail") < 0.03


def test_the_section_rig_of_the_file_is_the_front_axle() -> None:
    """Its corner is given by hardpoints, that of these tests by coordinates."""
    found = read_suspension_file("car", sr.load).analysed()
    assert found.success, found.message
    for name in ("toe", "camber", "scrub_radius", "roll_centre_height", "anti_dive", "spring_ratio"):
        assert found[name] == pytest.approx(axle("front")[name], rel=1e-9, abs=1e-12)
    moved = found.sensitivity("scrub_radius", wrt=["front_wheel.y"])
    assert moved.matrix == pytest.approx(
        1.0, rel=1e-9
    )  # A moves with the wheel, and the steering axis does not


def test_both_sides_are_mirror_images() -> None:
    found = axle("front")
    for name in ("toe", "camber", "caster", "scrub_radius"):
        assert found.curve(name, "bump", "left") == pytest.approx(
            found.curve(name, "bump", "right"), abs=1e-12
        )


def test_the_wheel_rate_is_that_of_the_spring_without_a_load() -> None:
    """k (dl/dz)² plus the force of the spring times the change of this ratio."""
    found, spring = (
        axle("rear"),
        next(one for one in axle("rear").rig.system.model.forces if one.name == "spring_rear_left"),
    )
    ratio, change = found.at("spring_ratio"), found.at("spring_ratio", slope=True)
    top, arm = (
        np.array([float(x) for x in found.rig.system.model.hardpoints[f"rear_spring_{end}"]])
        for end in ("top", "arm")
    )
    force = spring.k * (np.linalg.norm(top - arm) - spring.length)
    assert found.compliance()["wheel_rate"] == pytest.approx(spring.k * ratio**2 + force * change, rel=0.05)
