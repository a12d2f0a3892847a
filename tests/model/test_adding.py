"""`Model.adding` takes every kind of part, and refuses what is none."""

from pathlib import Path

import pytest

import sarrus as sr

ARM = sr.Body("arm", mass=1.0, inertia=(1, 1, 1))
PARTS = (
    sr.Body("tool", mass=2.0, inertia=(1, 1, 1)),
    sr.Fixed("grip", ARM, sr.Body("tool", mass=2.0, inertia=(1, 1, 1)), point=(0, 0, 0)),
    sr.AngleDriver("motor", "pin", "2*t"),
    sr.Torque("load", ARM, (0, 0, 1)),
)
MODEL = sr.Model(
    "m", [ARM], [sr.Revolute("pin", sr.ground, ARM, point=(0, 0, 0), axis=(0, 0, 1))], outputs={"u": "arm.x"}
)


def test_every_kind_of_part_is_added() -> None:
    more = MODEL.adding(*PARTS)
    assert [part.name for own in more.sections().values() for part in own] == [
        "arm",
        "tool",
        "pin",
        "grip",
        "motor",
        "load",
    ]
    assert more.outputs == MODEL.outputs
    assert len(sr.System(more).rows) == 3


def test_a_robot_takes_drivers_and_bodies_too(tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    path.write_text(
        '<robot name="r"><link name="base"/><link name="arm"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="pin" type="continuous"><parent link="base"/><child link="arm"/>'
        '<axis xyz="0 0 1"/></joint></robot>'
    )
    robot = sr.load(path).adding(PARTS[2], PARTS[0])
    assert type(robot) is type(sr.load(path))
    assert [part.name for part in robot.drivers] == ["motor"]
    assert robot.bodies[-1].name == "tool"


@pytest.mark.parametrize("wrong", ["nonsense", 3, None, [ARM], sr.Body])
def test_what_is_no_part_is_refused(wrong: object) -> None:
    with pytest.raises(TypeError, match="adding: each part must be a body, joint, driver or force, got"):
        MODEL.adding(PARTS[0], wrong)
