"""MJCF: bodies, joints, loops and what is left out, against the numbers that MuJoCo itself computes."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from tests.io.beside_mujoco import EXACT, at, compare, compare_accelerations, random_configuration

import sarrus as sr
from sarrus.io.mjcf.loads.actuators import actuators_of

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")


FOUR_BAR = """\
<mujoco model="four-bar">
  <option gravity="0 0 -3.71"/>
  <worldbody>
    <body name="crank"><joint name="a" axis="0 1 0"/>
      <geom type="capsule" size="0.05" fromto="0 0 0 0 0 2"/>
      <body name="coupler" pos="0 0 2"><joint name="b" axis="0 1 0"/>
        <geom type="capsule" size="0.05" fromto="0 0 0 3 0 0"/>
        <body name="tip" pos="3 0 0" euler="0 0 40"/></body></body>
    <body name="rocker" pos="3 0 0"><joint name="c" axis="0 1 0"/>
      <geom type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1" euler="10 20 30"/></body>
  </worldbody>
  <equality><{loop} name="closing" body1="tip" body2="rocker"{more}/></equality>
</mujoco>
"""
KINDS = {
    "hinges": '<joint name="x" axis="1 0 0"/><joint name="y" axis="0 1 0"/><joint name="z" axis="0 0 1"/>',
    "crossed hinges": '<joint name="x" axis="1 0 0"/><joint name="y" axis="0 1 0"/>',
    "hinge beside the origin": '<joint name="x" axis="1 1 0" pos="0.1 0.2 0.3"/>',
    "hinge with reference": '<joint name="x" axis="1 1 0" pos="0.1 0.2 0.3" ref="30"/>',
    "slide": '<joint name="x" type="slide" axis="1 1 0"/>',
    "screwlike": '<joint name="x" type="slide" axis="1 1 0"/><joint name="y" axis="1 1 0"/>',
    "skew hinges": '<joint name="x" axis="1 0 0"/><joint name="y" axis="0.3 0.8 0" pos="0 0 0.1"/>',
    "two slides": '<joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 1"/>',
    "slide and hinge across it": '<joint name="x" type="slide" axis="1 0 0"/><joint name="y" axis="0 1 0"/>',
    "slide and ball": '<joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="ball"/>',
    "hinge, slide, hinge": '<joint name="x" axis="1 0 0"/><joint name="y" type="slide" axis="0 0 1"/>'
    '<joint name="z" axis="0 1 0"/>',
    "plane": '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/>'
    '<joint name="y" axis="0 1 0"/>',
    "ball": '<joint name="x" type="ball" pos="0.1 0.2 0.3"/>',
    "free": '<freejoint name="x"/>',
    "six": "".join(f'<joint name="s{a}" type="slide" axis="{a}"/>' for a in ("1 0 0", "0 1 0", "0 0 1"))
    + "".join(f'<joint name="t{a}" axis="{a}"/>' for a in ("1 0 0", "0 1 0", "0 0 1")),
}


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo leaves a log where it is run."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("kind", KINDS)
def test_a_body_with_joints(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    box = '<geom type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1" euler="10 20 30"/>'
    inner = f'<body name="b" pos="0 0 2" euler="50 0 10">{KINDS[kind]}{box}</body>'
    outer = (
        inner
        if kind == "free"
        else f'<body name="a" euler="1 2 3"><joint name="arm" axis="1 2 3"/>{box}{inner}</body>'
    )
    path.write_text(f"<mujoco><worldbody>{outer}</worldbody></mujoco>")
    compare(path)
    space = sr.JointSpace(sr.System(sr.load_mjcf(path)))
    system, theta = space.system, space.zero() + np.random.default_rng(4).uniform(-1, 1, space.width)
    assert system.nq - system.m == space.freedoms
    assert abs(system.Phi(space.q(theta))).max() < 1e-14
    assert abs(system.Phi_q(space.q(theta)) @ space.T(theta)).max() < 1e-14


def four_bar(tmp_path: Path, loop: str, more: str) -> Path:
    path = tmp_path / "four_bar.xml"
    path.write_text(FOUR_BAR.format(loop=loop, more=more))
    return path


def test_connect_closes_a_loop_as_in_mujoco(tmp_path: Path) -> None:
    path = four_bar(tmp_path, "connect", ' anchor="0.1 0.2 0.3"')
    robot, model = sr.load_mjcf(path), mujoco.MjModel.from_xml_path(str(path))
    space, rng = sr.JointSpace(sr.System(robot)), np.random.default_rng(5)
    system = space.system
    assert tuple(robot.gravity) == (0, 0, -3.71)
    assert abs(system.Phi(system.q0)).max() < 1e-14
    for _ in range(10):
        theta, qpos, _ = random_configuration(space, model, rng)
        gap = system.Phi(space.q(theta))[system.rows["closing"]]
        apart = at(model, qpos).efc_pos[:3]
        assert min(abs(gap - apart).max(), abs(gap + apart).max()) < EXACT
    assert np.linalg.matrix_rank(system.Phi_q(system.q0).toarray()) == system.nq - 1


LOOPS = {
    "connect": ' anchor="0.1 0.2 0.3"',
    "weld": ' anchor="0.1 0.2 0.3"',
    "weld with a pose": ' anchor="0.1 0.2 0.3" relpose="0 0 -2 0.9 0.1 0.2 0.3"',
}


@pytest.mark.filterwarnings("ignore:.*assembly changed")  # the file draws the loop open
@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("sites", [False, True])
def test_a_loop_blocks_what_it_blocks_in_mujoco(name: str, sites: bool, tmp_path: Path) -> None:
    """Two free bodies and a loop: where it is closed, its equations have the row space of MuJoCo's."""
    kind, more = name.split()[0], "" if sites else LOOPS[name]
    ends = 'site1="s" site2="t"' if sites else 'body1="a" body2="b"'
    bodies = "".join(
        f'<body name="{body}" pos="{k} 0.1 0.2" euler="{k}0 20 30"><freejoint name="f{k}"/><geom size="0.1 0.2 0.3" '
        f'type="box"/><site name="{site}" pos="{k} 0 1" euler="0 {k}0 5"/></body>'
        for k, (body, site) in enumerate(("as", "bt"), 1)
    )
    path = tmp_path / "pair.xml"
    path.write_text(
        f"<mujoco><worldbody>{bodies}</worldbody><equality><{kind} {ends}{more}/></equality></mujoco>"
    )
    system = sr.System(sr.load_mjcf(path))
    start, model = sr.assemble(system), mujoco.MjModel.from_xml_path(str(path))
    assert start.success, start.message
    data = at(model, start.q)
    assert abs(data.efc_pos).max() < EXACT
    T = sr.JointSpace(system).T(start.q)  # all is free, so q is θ
    (loop,) = system.rows.values()
    ours, theirs = (system.Phi_q(start.q) @ T)[loop], data.efc_J.reshape(-1, 12)
    count = 3 if kind == "connect" else 6
    assert np.linalg.matrix_rank(ours) == np.linalg.matrix_rank(theirs) == count
    assert np.linalg.matrix_rank(np.vstack([ours, theirs]), tol=1e-8) == count


def test_a_closed_loop_falls(tmp_path: Path) -> None:
    path = four_bar(tmp_path, "connect", ' anchor="0 0 0"')
    system = sr.System(sr.load_mjcf(path, q0={"a": 0.3, "b": -0.3, "c": 0.3}))
    start = sr.assemble(system)
    assert start.success, start.message


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(
        '<mujoco><worldbody><body name="b"><joint name="j" damping="1" armature="0.1" stiffness="2" range="0 90"/>'
        '<geom size="1"/><site name="s"/></body></worldbody><actuator><motor site="s"/></actuator>'
        '<sensor><touch site="s"/></sensor></mujoco>'
    )
    robot = sr.load_mjcf(path)
    assert any("1 touch sensor of a body" in note for note in robot.notes)
    assert robot.limits["j"].upper == pytest.approx(np.pi / 2)


EFFORTS = {
    "hinge": '<joint name="x" axis="1 2 0" pos="0.1 0 0" {all}/>',
    "slide": '<joint name="x" type="slide" axis="1 2 0" {all}/>',
    "slide and hinge along it": '<joint name="x" type="slide" axis="-1 2 0" {all}/>'
    '<joint name="y" axis="1 -2 0" {all}/>',
    "crossed hinges": '<joint name="x" axis="1 0 0" {all}/><joint name="y" axis="0 1 0" {all}/>',
    "three hinges": '<joint name="x" {all}/><joint name="y" axis="0 1 0" {all}/><joint name="z" axis="1 1 0" {all}/>',
    "plane": '<joint name="x" type="slide" axis="1 0 0" {all}/><joint name="z" type="slide" {all}/>'
    '<joint name="y" axis="0 1 0" {all}/>',
}
ALL = 'stiffness="3" springref="0.3" ref="0.1" damping="0.7" frictionloss="0.4" armature="0.05"'
FLAGS = ("", "gravity", "spring", "damper", "frictionloss", "constraint")


@pytest.mark.parametrize("flag", FLAGS)
@pytest.mark.parametrize("kind", EFFORTS)
def test_springs_dampers_friction_and_armature(kind: str, flag: str, tmp_path: Path) -> None:
    box = '<geom type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1" euler="10 20 30"/>'
    inner = f'<body name="b" pos="0 0 2" euler="50 0 10">{EFFORTS[kind].format(all=ALL)}{box}</body>'
    outer = f'<body name="a" gravcomp="0.3"><joint name="arm" axis="1 2 3" {ALL}/>{box}{inner}</body>'
    option = f'<option><flag {flag}="disable"/></option>' if flag else ""
    path = tmp_path / "model.xml"
    text = f'<compiler angle="radian"/>{option}<worldbody>{outer}</worldbody>'
    path.write_text(f"<mujoco>{text}</mujoco>")
    compare_accelerations(path)


def test_a_weld_within_a_body_has_no_effect(tmp_path: Path) -> None:
    """As of two bodies that do not move: MuJoCo accepts it, too."""
    box = '<geom type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1"/>'
    bodies = f'<body name="a"><joint/>{box}<body name="b">{box}</body></body><body name="c" pos="0 0 4">{box}</body>'
    welds = '<weld body1="a" body2="b"/><weld body1="c"/><connect body1="a" body2="c" anchor="0 0 0"/>'
    path = tmp_path / "model.xml"
    path.write_text(f"<mujoco><worldbody>{bodies}</worldbody><equality>{welds}</equality></mujoco>")
    assert [type(joint) for joint in sr.load_mjcf(path).joints] == [sr.Revolute, sr.Spherical]


@pytest.mark.parametrize("given", ["stiffness", "damping", "frictionloss", "armature", "all"])
def test_dynamics_of_balls(given: str, tmp_path: Path) -> None:
    """On the ground, between two bodies, and with a slide; with the orientation of the file not that of the parent."""
    values = {"stiffness": 3.0, "damping": 0.7, "frictionloss": 0.2, "armature": 0.05}
    more = " ".join(f'{name}="{value}"' for name, value in values.items() if given in (name, "all"))
    box = '<geom type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1" euler="10 20 30"/>'
    slide = '<joint name="s" type="slide" axis="1 0 0" damping="0.1"/>'
    inner = f'<body name="lower" pos="0 0 2" euler="50 -20 70">{slide}<joint name="x" type="ball" {more}/>{box}</body>'
    ball = f'<joint name="y" type="ball" {more} pos="0.1 0 0"/>'
    outer = f'<body name="upper-arm" euler="20 30 -40">{ball}{box}{inner}</body>'
    path = tmp_path / "model.xml"
    path.write_text(f"<mujoco><worldbody>{outer}</worldbody></mujoco>")
    compare_accelerations(path)


def test_a_spring_of_a_free_body_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    box = '<geom type="box" size="0.1 0.2 0.3"/>'
    path.write_text(
        f'<mujoco><worldbody><body><joint name="x" type="free" stiffness="1"/>{box}</body></worldbody></mujoco>'
    )
    with pytest.raises(
        sr.ModelError, match=r'joint "x": only damping, friction and armature.*free body.*ignore='
    ):
        sr.load_mjcf(path)


@pytest.mark.skipif(not hasattr(mujoco.MjModel, "actuator_ctrladr"), reason="one control per actuator")
def test_an_actuator_with_several_controls_moves_those_of_the_others(tmp_path: Path) -> None:
    """The limits and the keyframe of the motor are in the fourth place."""
    body = '<body name="{0}"><joint name="{0}" type="{1}"/><geom type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1"/></body>'
    orientation = '<orientation name="o" joint="u" kp="0"/>'
    motor = '<motor name="m" joint="w" gear="2" ctrlrange="-0.5 0.25"/>'
    key = '<keyframe><key name="home" ctrl="0.1 0.2 0.3 0.15"/></keyframe>'
    path = tmp_path / "model.xml"
    path.write_text(
        f"<mujoco><worldbody>{body.format('u', 'ball')}{body.format('w', 'hinge')}</worldbody>"
        f"<actuator>{orientation}{motor}</actuator>{key}</mujoco>"
    )
    found = actuators_of(mujoco.MjModel.from_xml_path(str(path)))["m"]
    assert found.gain == 2.0
    assert found.controls == (-0.5, 0.25)
    robot = sr.load_mjcf(path, ignore=["actuators", "contacts"])
    assert robot.keyframes["home"].controls["m"] == 0.15


ACTUATORS = {
    "motor": '<motor name="m" joint="x" gear="3"/>',
    "motor with limits": '<motor name="m" joint="x" gear="-3" ctrlrange="-0.5 0.5" forcerange="-9 0.1"/>',
    "position": '<position name="m" joint="x" kp="20" kv="3" gear="2"/>',
    "position with limits": '<position name="m" joint="x" kp="20" dampratio="1" forcerange="-2 1"/>',
    "velocity": '<velocity name="m" joint="x" kv="4"/>',
    "general": '<general name="m" joint="x" gainprm="5" biastype="affine" biasprm="1 -2 -3" gear="1.5"/>',
}


@pytest.mark.parametrize("kind", ["hinge", "slide", "slide and hinge along it", "crossed hinges"])
@pytest.mark.parametrize("actuator", ACTUATORS)
def test_actuators_of_joints(actuator: str, kind: str, tmp_path: Path) -> None:
    box = '<geom type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1" euler="10 20 30"/>'
    body = f'<body name="b" euler="50 0 10">{EFFORTS[kind].format(all=ALL)}{box}</body>'
    path = tmp_path / "model.xml"
    path.write_text(
        f'<mujoco><compiler angle="radian"/><worldbody>{body}</worldbody>'
        f"<actuator>{ACTUATORS[actuator]}</actuator></mujoco>"
    )
    for control in (0.0, 0.7):
        compare_accelerations(path, {"m": control})


def test_a_servo_follows_its_control(tmp_path: Path) -> None:
    """J θ̈ = kp (a t − θ) − kv θ̇ lags behind a ramp by kv a / kp, and a gradient knows its gain."""
    path = tmp_path / "model.xml"
    joint = '<joint name="x" armature="0.1"/><inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>'
    path.write_text(
        f'<mujoco><worldbody><body name="b">{joint}</body></worldbody>'
        '<actuator><position name="servo" joint="x" kp="80" kv="8"/></actuator></mujoco>'
    )
    run = sr.simulate(sr.System(sr.load_mjcf(path, controls={"servo": "0.5*t"})), until=4.0, store="steps")
    assert run.joint("x").angle[-1] == pytest.approx(0.5 * 4 - 8 * 0.5 / 80, abs=1e-6)
    gradient = sr.sensitivity(run, sr.Final("x.angle"), ["servo_force.parameters.kv"])
    assert gradient["servo_force.parameters.kv"] == pytest.approx(-0.5 / 80, rel=1e-4)


def test_motors_with_states_and_unknown_controls_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    motor = '<actuator><dcmotor name="m" joint="j" motorconst="2" resistance="1"/></actuator>'
    path.write_text(f"<mujoco><worldbody>{ONE}</worldbody>{motor}</mujoco>")
    with pytest.raises(sr.ModelError, match="1 actuator that acts without a control"):
        sr.load_mjcf(path)
    assert sr.load_mjcf(path, ignore=["actuators"]).forces == ()
    with pytest.raises(sr.ModelError, match="controls cannot have"):
        sr.load_mjcf(path, ignore=["actuators"], controls={"n": 1.0})


def test_a_body_whose_weight_is_compensated_is_at_rest(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    body = ONE.replace('name="b"', 'name="b" gravcomp="1"').replace("size", 'pos="1 0 0" size')
    path.write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    run = sr.simulate(sr.System(sr.load_mjcf(path)), until=1.0)
    assert abs(run.v).max() < 1e-12


@pytest.mark.parametrize(
    "given", ['damping="0.7"', 'armature="1.3"', 'armature="1.3" frictionloss="0.4" damping="0.2"']
)
def test_dynamics_of_a_free_body_are_those_of_mujoco(given: str, tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    free, box = f'<joint name="x" type="free" {given}/>', '<geom type="box" size="1 2 3" pos="1 2 3"/>'
    body = f'<body name="a-1" pos="1 2 3" euler="10 20 30">{free}{box}</body>'
    path.write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    compare_accelerations(path)


ONE = '<body name="b"><joint name="j"/><geom size="1"/></body>'
PAIR = ONE + '<body name="c"><joint name="k"/><geom size="1"/></body>'


def test_elements_without_a_name_take_no_name_of_others(tmp_path: Path) -> None:
    """The first joint has no name, the second is called as the first would be; so are bodies."""
    path = tmp_path / "model.xml"
    inner = '<body name="body1" pos="0 0 1"><joint name="joint0" axis="0 1 0"/><geom size="0.1"/></body>'
    path.write_text(
        f'<mujoco><worldbody><body><joint axis="1 0 0"/><geom size="0.1"/>{inner}</body></worldbody></mujoco>'
    )
    robot = sr.load_mjcf(path)
    assert [body.name for body in robot.bodies] == ["body1_", "body1"]
    assert [joint.name for joint in robot.joints] == ["joint0_", "joint0"]


def test_a_joint_that_follows_another_is_coupled(tmp_path: Path) -> None:
    path = tmp_path / "pair.xml"
    equality = '<equality><joint joint1="j" joint2="k" polycoef="0.1 2 0 0 0"/></equality>'
    path.write_text(f"<mujoco><worldbody>{PAIR}</worldbody>{equality}</mujoco>")
    system = sr.System(sr.load_mjcf(path, q0={"k": 0.2}))
    assert sr.mobility(system).degrees_of_freedom == 1
    start = sr.assemble(system, rates={"k": 0.3})
    follower, leader = system.joint("j")["angle"], system.joint("k")["angle"]
    assert [one.value(start.q) for one in (leader, follower)] == pytest.approx([0.2, 0.5])
    assert [one.rate(start.q, start.v) for one in (leader, follower)] == pytest.approx([0.3, 0.6])


MALFORMED = {
    "no XML": ("<mujoco>", "is not well-formed XML, no element found"),
    "unknown element": ("<mujoco><worldbody><bdy/></worldbody></mujoco>", "cannot be read by MuJoCo"),
    "nothing moves": ("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>", "nothing in it moves"),
}


@pytest.mark.parametrize("name", MALFORMED)
def test_a_wrong_file_is_refused(name: str, tmp_path: Path) -> None:
    text, words = MALFORMED[name]
    path = tmp_path / "model.xml"
    path.write_text(text)
    with pytest.raises(sr.ModelError) as error:
        sr.load_mjcf(path)
    assert words in str(error.value)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


GYMNASIUM = (
    "ant",
    "half_cheetah",
    "hopper",
    "humanoid",
    "inverted_double_pendulum",
    "swimmer",
    "walker2d_v5",
)


@pytest.mark.one_in(4)
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", GYMNASIUM)
def test_models_of_gymnasium(name: str) -> None:
    found = find_spec("gymnasium")
    if found is None or found.origin is None:
        pytest.skip("gymnasium is not installed")
    compare(Path(found.origin).parent / "envs/mujoco/assets" / f"{name}.xml", poses=100)
    compare_accelerations(Path(found.origin).parent / "envs/mujoco/assets" / f"{name}.xml")
