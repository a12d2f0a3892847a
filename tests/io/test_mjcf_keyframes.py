"""Keyframes of MJCF as starts: positions, velocities and activations against MuJoCo's."""

from pathlib import Path

import numpy as np
import pytest
from tests.io.poses import pose_difference

import sarrus as sr

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

FILE = """<mujoco><compiler angle="radian"/><worldbody>
  <body name="a" pos="1 2 3"><freejoint name="f"/><geom type="box" size="0.1 0.2 0.3"/>
    <body name="b" pos="0 0 2" euler="50 0 10"><joint name="y" type="slide" axis="1 1 0" ref="0.1"/><joint name="z"/>
      <geom type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1"/>
      <body name="c" pos="0 0 2"><joint name="w" type="ball"/><geom type="box" size="0.1 0.2 0.3"/></body></body></body>
  </worldbody><actuator><general name="m" joint="y" dyntype="filter" dynprm="0.1"/></actuator>
  <keyframe><key name="home" time="0.5" qpos="0.3 0.2 0.1 0.8 0.6 0 0 0.4 {angle} 0.6 0 0.8 0"
    qvel="1 2 3 0.1 0.2 0.3 0.4 -0.5 0.7 0.8 0.9" act="0.3" ctrl="0.6"/></keyframe></mujoco>
"""


def test_a_keyframe_is_a_start(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(FILE.format(angle=-0.7))
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    robot = sr.load_mjcf(path, ignore=["contacts"])
    controls = robot.keyframes["home"].controls
    assert controls == {"m": 0.6}
    robot = sr.load_mjcf(path, ignore=["contacts"], controls=controls)
    run = sr.simulate(sr.System(robot), robot.start("home"), until=0.6, t_eval=[0.5, 0.6])
    assert run["m_activation"][0] == 0.3
    assert run["m_activation"][1] == pytest.approx(0.6 - 0.3 / np.e, rel=1e-6)
    for k, name in enumerate("abc", 1):
        place, velocity = run[name], np.zeros(6)
        pose = sr.Body(name, 1, (1, 1, 1), place.position[0], run.q[0, 7 * _at(run, name) + 3 :][:4]).pose()
        assert pose_difference(pose, data.xpos[k], data.xmat[k].reshape(3, 3)) < 1e-12
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, k, velocity, 0)
        np.testing.assert_allclose(run[f"{name}.velocity"][0], velocity[3:], atol=1e-12)
        np.testing.assert_allclose(run[f"{name}.angular_velocity"][0], velocity[:3], atol=1e-12)


def _at(run: sr.Trajectory, name: str) -> int:
    return list(run.system.bodies).index(name)


def test_keyframes_that_cannot_start(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(FILE.format(angle=4))
    robot = sr.load_mjcf(path)
    with pytest.raises(sr.ModelError, match=r'there is no keyframe "hme"\. Did you mean "home"'):
        robot.start("hme")
    with pytest.raises(sr.ModelError, match=r'keyframe "home": rotates "z" by more than half a revolution'):
        robot.start("home")(sr.System(robot))
