"""Muscles of MJCF: accelerations and rates of activations in random states against MuJoCo's."""

from pathlib import Path

import numpy as np
import pytest
from tests.io.beside_mujoco import compare_accelerations, random_configuration
from tests.io.test_mjcf_tendons import PATHS, around, output_at, written

import sarrus as sr

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

RANGE = 'lengthrange="0.4 3"'
MUSCLES = {
    "tendon": f'<muscle name="m" tendon="t" force="40" {RANGE}/>',
    "peak force by its scale": f'<muscle name="m" tendon="t" scale="30" {RANGE} tausmooth="0.4"/>',
    "joint": '<muscle name="m" joint="y" gear="-2" force="40" lengthrange="-3 3" vmax="3" ctrlrange="0.1 0.5"/>',
    "all": f'<muscle name="m" tendon="t" gear="1.5" {RANGE} force="20" range="0.5 1.5" lmin="0.3" lmax="1.8" vmax="4" '
    'fpmax="0.8" fvmax="1.4" timeconst="0.02 0.07"/>',
    "gain alone": f'<general name="m" tendon="t" {RANGE} gaintype="muscle" gainprm="0.5 1.5 40 1 0.3 1.8 4 0.8 1.4"/>',
    "filter": f'<general name="m" tendon="t" {RANGE} dyntype="filter" dynprm="0.1" gaintype="muscle" '
    'gainprm="0.5 1.5 40 1 0.3 1.8 4 0.8 1.4" biastype="muscle" biasprm="0.5 1.5 40 1 0.3 1.8 4 0.8 1.4"/>',
    "dynamics alone": '<general name="m" joint="x" dyntype="muscle" dynprm="0.01 0.04 0" gainprm="7" biastype="affine" '
    'biasprm="1 2 3"/>',
}


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("name", MUSCLES)
def test_accelerations(name: str, path: str, tmp_path: Path) -> None:
    compare_accelerations(written(tmp_path, path, actuator=MUSCLES[name]), {"m": 0.7}, states=10)


def test_a_muscle_around_a_shape(tmp_path: Path) -> None:
    path = around(tmp_path, "cylinder", "side", "", actuator=MUSCLES["all"])
    compare_accelerations(path, {"m": 0.7}, states=20)


@pytest.mark.parametrize("name", ["tendon", "peak force by its scale", "joint", "dynamics alone"])
def test_rates_of_activations(name: str, tmp_path: Path) -> None:
    path = written(tmp_path, "spatial", actuator=MUSCLES[name])
    model, rng = mujoco.MjModel.from_xml_path(str(path)), np.random.default_rng(4)
    for control in (-0.2, 0.3, 0.7, 1.4):
        system = sr.System(sr.load_mjcf(path, controls={"m": control}))
        space, data = sr.JointSpace(system), mujoco.MjData(model)
        theta, data.qpos[:], _ = random_configuration(space, model, rng)
        q, v = space.q(theta), np.zeros(system.nq)
        data.ctrl[0], data.act[0] = control, rng.uniform(-0.2, 1.2)
        mujoco.mj_forward(model, data)
        v[system.states["m_activation"][0]] = data.act[0]
        rate = output_at(system, q, v, "m_activation.rate")
        assert rate == pytest.approx(data.act_dot[0], rel=1e-12)


def stepped(path: Path, control: float, steps: int) -> mujoco.MjData:
    """MuJoCo's state after steps of 0.5 ms with a held control."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep, model.opt.integrator = 5e-4, mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    data.ctrl[0] = control
    for _ in range(steps):
        mujoco.mj_step(model, data)
    return data


@pytest.mark.slow
def test_a_contraction_over_time(tmp_path: Path) -> None:
    path = written(tmp_path, "spatial", 'damping="3"', actuator=MUSCLES["all"])
    data = stepped(path, 0.9, 600)
    run = sr.simulate(
        sr.System(sr.load_mjcf(path, controls={"m": 0.9})), until=0.3, method=sr.Radau(rtol=1e-8)
    )
    assert run["m_activation"][-1] == pytest.approx(data.act[0], rel=1e-4)
    assert run["m_force.length"][-1] == pytest.approx(1.5 * data.ten_length[0], rel=1e-4)
    assert run["m_force.tension"][-1] == pytest.approx(-data.actuator_force[0], rel=1e-3)


def test_a_held_control_over_a_second(tmp_path: Path) -> None:
    path = written(tmp_path, "spatial", 'damping="3"', actuator=MUSCLES["tendon"])
    data = stepped(path, 0.5, 2000)
    run = sr.simulate(sr.System(sr.load_mjcf(path, controls={"m": 0.5})), until=1.0)
    assert run.t[-1] == 1.0
    assert run["m_activation"][-1] == pytest.approx(data.act[0], rel=1e-6)
    assert run["m_force.length"][-1] == pytest.approx(data.ten_length[0], rel=1e-3)


def test_computed_length_ranges_are_those_of_mujoco(tmp_path: Path) -> None:
    """MuJoCo computes them when it compiles the file: from them follow the lengths of the muscle and its tendon."""
    path = written(tmp_path, "", actuator='<muscle name="m" joint="y" force="9"/>')
    path.write_text(path.read_text().replace('name="y"', 'name="y" range="-0.4 0.9"'))
    robot = sr.load_mjcf(path, ignore=["limits"])
    first, last = mujoco.MjModel.from_xml_path(str(path)).actuator_lengthrange[0]
    muscle = next(part for part in robot.forces if isinstance(part, sr.Muscle))
    assert (first, last) == pytest.approx((-0.4, 0.9), abs=0.02)
    assert muscle.optimal_length == pytest.approx((last - first) / 0.3)
    assert muscle.tendon_length + 0.1 == pytest.approx(first - 0.75 * muscle.optimal_length)  # x is 0.1 less
    compare_accelerations(path, {"m": 0.6})


def test_a_force_by_the_scale_of_a_stationary_length(tmp_path: Path) -> None:
    """Its tendon is along the line through the hinge: a unit force does not accelerate it."""
    path = tmp_path / "stationary.xml"
    path.write_text(
        '<mujoco><worldbody><site name="top" pos="0 0 2"/><body><joint axis="0 1 0"/><geom size="0.1" pos="0 0 1"/>'
        '<site name="tip" pos="0 0 0.5"/></body></worldbody><tendon><spatial name="t"><site site="top"/>'
        '<site site="tip"/></spatial></tendon><actuator><muscle name="m" tendon="t" lengthrange="0.2 2"/></actuator>'
        "</mujoco>"
    )
    with pytest.raises(sr.ModelError, match=r"1 muscle with a force that follows from scale, .* \(m\)"):
        sr.load_mjcf(path)
    assert not sr.load_mjcf(path, ignore=["actuators"]).forces
    path.write_text(path.read_text().replace("lengthrange", 'force="3" lengthrange'))
    assert any(isinstance(part, sr.Muscle) and part.peak_force == 3 for part in sr.load_mjcf(path).forces)


UNSUPPORTED = {
    "limited force": f'<muscle name="m" tendon="t" force="40" {RANGE} forcerange="-1 1"/>',
    "another bias": MUSCLES["filter"].replace('biasprm="0.5 1.5 40', 'biasprm="0.5 1.5 50'),
    "no lengthening": MUSCLES["filter"].replace("0.8 1.4", "0.8 1"),
    "no lengthening, no bias": MUSCLES["gain alone"].replace("0.8 1.4", "0.8 1"),
    "limited activation": '<general name="m" joint="x" dyntype="muscle" dynprm="0.01 0.04 0" actrange="0 0.5" '
    'biastype="affine" biasprm="1 2 3"/>',
}


REASONS = {
    "limited force": r"1 muscle with a limited force \(forcerange\)",
    "another bias": "1 muscle with a bias other than that of its gain",
    "no lengthening": "1 muscle with fvmax of 1 or less",
    "no lengthening, no bias": "1 muscle with fvmax of 1 or less",
    "limited activation": "1 actuator that acts without a control",
}


@pytest.mark.parametrize("name", UNSUPPORTED)
def test_other_muscles_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(sr.ModelError, match=REASONS[name]):
        sr.load_mjcf(written(tmp_path, "spatial", actuator=UNSUPPORTED[name]))
