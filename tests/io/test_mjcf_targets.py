"""Welds and connects to bodies that a program moves are springs, which yield as much as MuJoCo's equalities."""

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

FILE = """<mujoco><option timestep="0.001" gravity="1 2 -9.81"/><worldbody>
  <body name="target" mocap="true" pos="0.1 0.2 0.3" euler="10 20 30"/>
  <body name="goal" mocap="true" pos="0.11 0.2 0.9" euler="2 0 0"><site name="there"/></body>
  <body name="arm"><joint name="x" axis="0 1 0" damping="1"/><geom type="box" size="0.1 0.1 0.4" pos="0 0 0.4"/>
    <body name="hand" pos="0 0 0.8"><joint name="b" type="ball" damping="1"/><site name="here" pos="0.1 0.2 0.1"/>
      <geom type="box" size="0.1 0.2 0.1" pos="0.1 0.1 0.2"/></body></body></worldbody>
  <equality>{}</equality><sensor><force name="f" site="here"/></sensor></mujoco>
"""
EQUALITIES = {
    "weld": '<weld body1="target" body2="hand" solref="0.02 1" solimp="0.9 0.9 0.001"/>',
    "weld from the hand": '<weld body1="hand" body2="target" solref="-900 -70" solimp="0.8 0.8 0.001"/>',
    "weld with a scale": '<weld body1="target" body2="hand" torquescale="0.7" solimp="0.9 0.9 0.001"/>',
    "weld of sites": '<weld site1="there" site2="here" solref="0.02 1" solimp="0.9 0.9 0.001"/>',
    "connect": '<connect body1="target" body2="hand" anchor="0 0 0.8" solimp="0.9 0.9 0.001"/>',
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("case", EQUALITIES)
def test_a_target_yields_as_in_mujoco(case: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(FILE.format(EQUALITIES[case]))
    robot = sr.load_mjcf(path, ignore=["contacts"])
    assert len(robot.joints) == 2
    assert any("1 motion of bodies that a program moves" in note for note in robot.notes)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for _ in range(20_000):
        mujoco.mj_step(model, data)
    assert abs(data.qvel).max() < 1e-6
    system = sr.System(robot)
    run = sr.simulate(system, until=20.0, method=sr.Radau(rtol=1e-6))
    for name in system.bodies:
        body, found = data.body(name), run[name]
        np.testing.assert_allclose(found.position[-1], body.xpos, atol=1e-6)
        turned = abs(run.q[-1][system.coordinates_of(name)][3:] @ body.xquat)
        assert turned == pytest.approx(1, abs=1e-9)
    sensed = [run[f"f.{axis}"][-1] for axis in "xyz"]
    np.testing.assert_allclose(sensed, data.sensordata, atol=1e-3 * 9.81 * robot.bodies[1].mass)
