"""Ranges of MJCF joints are soft stops, whose depth at rest is MuJoCo's."""

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

FILE = """<mujoco><option timestep="0.001"/><compiler angle="radian"/><worldbody><body>
  <joint name="j" {joint} {law}/><inertial pos="1 0 0" mass="2" diaginertia="0.1 0.1 0.1"/></body></worldbody></mujoco>
"""
JOINTS = {
    "hinge": 'axis="0 1 0" range="-1 0.4"',
    "hinge with reference": 'axis="0 1 0" range="-0.9 0.5" ref="0.1"',
    "slide": 'type="slide" axis="0 0 -1" range="-1 0.4"',
    "slide with margin": 'type="slide" axis="0 0 -1" range="-1 0.5" margin="0.1"',
}
LAWS = {
    "constant impedance": 'solimplimit="0.95 0.95 0.001"',
    "time constant": 'solreflimit="0.03 1.2" solimplimit="0.9 0.9 0.001"',
    "stiffness": 'solreflimit="-800 -60" solimplimit="0.8 0.8 0.001"',
}


def resting(path: Path) -> float:
    """Where MuJoCo's joint comes to rest, relative to the pose of the file."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for _ in range(5000):
        mujoco.mj_step(model, data)
    assert abs(data.qvel[0]) < 1e-9
    return float(data.qpos[0] - model.qpos0[0])


@pytest.mark.parametrize(
    ("joint", "law"), [*((one, "constant impedance") for one in JOINTS), *(("hinge", one) for one in LAWS)]
)
def test_a_stop_yields_by_as_much_as_in_mujoco(joint: str, law: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(FILE.format(joint=JOINTS[joint], law=LAWS[law]))
    robot = sr.load_mjcf(path, q0={"j": 0.4})
    assert [force.name for force in robot.forces] == ["j_stop"]
    rest = sr.equilibrium(sr.System(robot))
    assert rest.success, rest.message
    depth = resting(path) - 0.4
    assert depth > 1e-4
    name = "j.angle" if "hinge" in joint else "j.displacement"
    assert rest[name] - 0.4 == pytest.approx(depth, rel=1e-3)


def test_an_impact_comes_back_as_slowly_as_documented(tmp_path: Path) -> None:
    """1/damping is the largest speed of return; MuJoCo's critically damped limit returns nothing."""
    path = tmp_path / "model.xml"
    path.write_text(FILE.format(joint=JOINTS["slide"], law=""))
    run = sr.simulate(sr.System(sr.load_mjcf(path)), until=0.6)
    assert run.success, run.message
    assert run["j.displacement.rate"].max() > 2.5
    assert -1 / 40 < run["j.displacement.rate"].min() < -1 / 80
    assert np.max(run["j.displacement"]) < 0.41


def test_a_range_is_relative_to_the_pose_of_the_file(tmp_path: Path) -> None:
    """As coordinates are."""
    path = tmp_path / "model.xml"
    path.write_text(FILE.format(joint='axis="0 1 0" range="0.9 1.5" ref="1"', law=""))
    robot = sr.load_mjcf(path)
    assert robot.limits["j"].range() == pytest.approx((-0.1, 0.5))
    assert not any("outside of its limits" in note for note in robot.notes)
    assert any("outside of its limits" in note for note in sr.load_mjcf(path, q0={"j": 1.0}).notes)


def test_limits_are_left_out_on_request_and_by_flags(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    text = FILE.format(joint=JOINTS["slide"], law="")
    path.write_text(text)
    assert sr.load_mjcf(path, ignore=["limits"]).forces == ()
    assert sr.load_mjcf(path, ignore=["dynamics"]).forces != ()
    path.write_text(text.replace("<option", '<option><flag limit="disable"/></option><option'))
    assert sr.load_mjcf(path).forces == ()
    path.write_text(FILE.format(joint='type="ball" range="0 1"', law=""))
    assert any("1 limit of ball joints" in note for note in sr.load_mjcf(path).notes)


def test_a_time_constant_is_at_least_two_time_steps_as_in_mujoco(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"

    def stiffness(law: str) -> float:
        path.write_text(FILE.format(joint=JOINTS["slide"], law=law))
        return float(sr.load_mjcf(path).forces[0].stiffness)

    assert stiffness('solreflimit="0.0001 1"') == stiffness('solreflimit="0.002 1"')


@pytest.mark.parametrize("law", ["0.05 0", "0.05 -1", "-800 60", "0 1"])
def test_a_law_with_one_positive_number_is_the_default_as_in_mujoco(law: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"

    def stop(law: str) -> tuple[float, float]:
        path.write_text(FILE.format(joint=JOINTS["slide"], law=f'solreflimit="{law}"'))
        (force,) = sr.load_mjcf(path).forces
        return force.stiffness, force.damping

    assert stop(law) == stop("0.02 1")
    assert stop("0.05 1") != stop("0.02 1")


@pytest.mark.parametrize("law", ["0 0", "0 -60"])
def test_a_limit_without_stiffness_is_refused_by_name(law: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(FILE.format(joint=JOINTS["slide"], law=f'solreflimit="{law}"'))
    with pytest.raises(sr.ModelError, match=r'joint "j": has a contact or limit without stiffness.*ignore='):
        sr.load_mjcf(path)
    assert sr.load_mjcf(path, ignore=["limits"]).forces == ()
