"""Actuators of robots are inputs by name, beside MuJoCo."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

ROBOT = """<mujoco><compiler angle="radian"/><worldbody>
  <body name="arm" pos="0 0 1"><joint name="hinge" axis="0 1 0"/>
    <inertial pos="0.3 0 0" mass="1" diaginertia="0.01 0.02 0.03"/>
    <body name="forearm" pos="0.6 0 0"><joint name="elbow" axis="0 1 0"/>
      <inertial pos="0.2 0 0" mass="0.5" diaginertia="0.01 0.01 0.01"/></body></body></worldbody><actuator>
  <motor name="motor-1" joint="hinge" gear="3" ctrlrange="-4 4" ctrllimited="true"/>
  <position name="elbow" joint="elbow" kp="20" kv="1"/>
  <motor name="gain" joint="elbow" gear="0.5"/></actuator></mujoco>"""
INPUTS = ("motor_1", "elbow_control", "gain_control")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """The file of a robot with two joints."""
    (tmp_path / "arm.xml").write_text(ROBOT)
    return tmp_path / "arm.xml"


def mujoco_rates(path: Path, controls: Any, q: Any = (0, 0), v: Any = (0, 0)) -> Any:
    """Accelerations of the joints."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.ctrl[:] = q, v, controls
    mujoco.mj_forward(model, data)
    return np.array(data.qacc)


def test_actuators_are_inputs_by_name(path: Path) -> None:
    """One with the name of a joint, or of a parameter of its formula, ends with _control."""
    system = sr.System(sr.load_mjcf(path))
    assert tuple(system.inputs) == INPUTS
    assert all(one.is_set for one in system.inputs.values())
    for values in ((0.0, 0.0, 0.0), (1.5, 0.3, -2.0), (9.0, 0.0, 0.0)):
        run = sr.simulate(system, until=0.1, inputs=dict(zip(INPUTS, values, strict=True)))
        rates = [run.output(f"{joint}.angle", rate=True).values for joint in ("hinge", "elbow")]
        found = [np.polyfit(run.t[:9], rate[:9], 3)[-2] for rate in rates]
        assert found == pytest.approx(mujoco_rates(path, values), rel=1e-5, abs=1e-5)


def test_a_linearization_has_the_actuators_as_inputs(path: Path) -> None:
    system = sr.System(sr.load_mjcf(path))
    space = sr.linearize(system, sr.assemble(system), inputs=INPUTS)
    free = mujoco_rates(path, np.zeros(3))
    columns = [mujoco_rates(path, control) - free for control in np.eye(3)]
    rows = [space.states.index(f"{name}.angle.rate") for name in ("hinge", "elbow")]
    assert space.inputs == INPUTS
    assert space.B[rows].T == pytest.approx(np.array(columns), rel=1e-7)


def test_steppers_and_controllers_set_actuators(path: Path) -> None:
    system = sr.System(sr.load_mjcf(path))

    def servo(t: float, o: Any) -> dict[str, float]:
        return {"motor_1": -2.0 * o["hinge.angle"] - o["hinge.rate"], "gain_control": 0.1}

    run = sr.simulate(
        system,
        until=0.1,
        t_eval=[0.1],
        controllers=[sr.Controller(servo, period=0.01)],
        method=sr.Radau(rtol=1e-10),
    )
    stepper = sr.Stepper(
        system,
        step=0.01,
        inputs=["motor_1", "gain_control"],
        outputs=["hinge.angle", "hinge.rate"],
        method=sr.Radau(rtol=1e-10),
    )
    angle, rate = stepper.values
    for _ in range(10):
        angle, rate = stepper.advance([-2.0 * angle - rate, 0.1])
    assert [angle, rate] == pytest.approx([run["hinge.angle"][-1], run["hinge.rate"][-1]], rel=1e-7)


def test_controls_of_an_import_are_values_of_the_inputs(path: Path, tmp_path: Path) -> None:
    robot = sr.load_mjcf(path, controls={"motor-1": "0.3*sin(2*t)", "elbow": 0.2})
    inputs = {one.name: one.value for one in robot.forces if isinstance(one, sr.Input)}
    assert inputs == {"motor_1": "0.3*sin(2*t)", "elbow_control": 0.2, "gain_control": 0.0}
    run = sr.simulate(sr.System(robot), until=0.5, store="steps")
    gradient = sr.sensitivity(run, sr.Final("elbow.angle"), wrt=["elbow_control.value", "motor_1.value.1"])
    assert np.all(abs(gradient.matrix) > 1e-6)
    with pytest.warns(sr.SarrusWarning, match="names of merged links"):
        robot.save(tmp_path / "arm.yaml")
    again = sr.simulate(sr.System(sr.load(tmp_path / "arm.yaml")), until=0.5)
    assert np.array_equal(again.v, sr.simulate(sr.System(robot), until=0.5).v)
    with pytest.raises(sr.ModelError, match="control must be a number or a formula of t"):
        sr.load_mjcf(path, controls={"elbow": [1, 2]})
