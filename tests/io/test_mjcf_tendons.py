"""Tendons of MJCF and what acts on them: accelerations in random states against MuJoCo's."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.io.beside_mujoco import at, compare_accelerations, mass_matrix, random_configuration

import sarrus as sr
from sarrus.model.tape import value_of
from sarrus.outputs import Outputs
from sarrus.outputs.recording import States

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

FILE = """<mujoco><compiler angle="radian"/><worldbody><site name="w" pos="0.1 0.2 2" euler="2 3 4"/>
  <body name="a" euler="1 2 3"><joint name="x" axis="1 2 3" ref="0.2"/>
    <site name="a1" pos="0.1 0 0.3"/><site name="a2" pos="0.2 0 0.4"/>
    <geom type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1"/>
    <body name="b" pos="0 0 2" euler="50 0 10"><joint name="y" type="slide" axis="1 1 0" ref="0.1"/>
      <joint name="z" axis="1 1 0"/><site name="b1" pos="0.3 0 0.5" euler="0.1 0.2 0.3"/>
      <geom type="box" size="0.1 0.2 0.3" pos="0.1 0.2 1"/></body></body>
  </worldbody><tendon>{tendon}</tendon><equality>{equality}</equality><actuator>{actuator}</actuator></mujoco>
"""
FIXED = (
    '<fixed name="t" {all}><joint joint="x" coef="0.5"/><joint joint="y" coef="-2"/><joint joint="z" coef="0.3"/>'
    "</fixed>"
)
SPATIAL = (
    '<spatial name="t" {all}><site site="w"/><site site="a1"/><site site="a2"/><site site="b1"/></spatial>'
)
PULLEYS = (
    '<spatial name="t" {all}><site site="w"/><site site="a1"/><pulley divisor="2"/><site site="a2"/><site site="b1"/>'
    '<pulley divisor="3"/><site site="w"/><site site="b1"/></spatial>'
)
PATHS = {"fixed": FIXED, "spatial": SPATIAL, "pulleys": PULLEYS}
SHAPE = '<geom name="g" type="{kind}" size="0.5 1" pos="0.1 0.1 1.1" euler="0.3 0.2 0.1"/>'
SIDES = {"shorter": "", "side": "0.9 0.3 1", "through": "0.2 0.1 1.2"}


def output_at(system: sr.System, q: Any, v: Any, name: str) -> float:
    """An output in one state."""
    states = States(np.zeros(1), q[None], v[None], 0 * q[None], lambda: np.zeros((1, system.m)))
    return float(np.ravel(value_of(Outputs(system, states, system.b, {}.get)(name)))[0])


FORCES = {
    "spring": 'stiffness="30" springlength="0.3"',
    "spring at rest": 'stiffness="30"',
    "dead band": 'stiffness="30" springlength="-0.2 1.5"',
    "all": 'stiffness="30" springlength="0.3" damping="4" frictionloss="3"',
    "cubic": 'stiffness="30 -20 9" springlength="-0.2 1.5" damping="4 3 0.5"',
    "cube alone": 'stiffness="0 0 9" damping="0 3"',
}


def written(folder: Path, path: str, given: str = "", equality: str = "", actuator: str = "") -> Path:
    file = folder / "model.xml"
    tendon = PATHS[path].format(all=given) if path else ""
    file.write_text(FILE.format(tendon=tendon, equality=equality, actuator=actuator))
    return file


@pytest.mark.parametrize("given", FORCES)
@pytest.mark.parametrize("path", PATHS)
def test_forces_of_tendons(path: str, given: str, tmp_path: Path) -> None:
    compare_accelerations(written(tmp_path, path, FORCES[given]))


ACTUATORS = {
    "motor": '<motor name="m" tendon="t" gear="3"/>',
    "position": '<position name="m" tendon="t" kp="20" kv="3" gear="2"/>',
    "affine gain": '<general name="m" tendon="t" gear="1.5" gaintype="affine" gainprm="2 3 -1" biastype="affine" '
    'biasprm="1 2 3"/>',
    "affine gain of a joint": '<general name="m" joint="x" gear="1.5" gaintype="affine" gainprm="2 3 -1"/>',
    "filter": '<general name="m" joint="x" dyntype="filter" dynprm="0.1" gainprm="7"/>',
    "integrator": '<general name="m" tendon="t" dyntype="integrator" gainprm="7" biastype="affine" biasprm="0 -7 -1"/>',
    "intvelocity": '<intvelocity name="m" joint="y" kp="30" actrange="-3 3"/>',
    "filtered position": '<position name="m" joint="z" kp="30" kv="2" timeconst="0.2" inheritrange="0"/>',
    "site": '<motor name="m" site="b1" gear="1 2 3 -2 0.5 1"/>',
    "constant at a site": '<general name="m" site="b1" gear="1 2 3 -2 0.5 1" gainprm="2" '
    'biastype="affine" biasprm="3"/>',
    "axes of the world": '<motor name="m" site="b1" refsite="w" gear="1 2 3 -2 0.5 1"/>',
    "constant in axes of the world": '<general name="m" site="b1" refsite="w" gear="1 2 3 -2 0.5 1" gainprm="0" '
    'biastype="affine" biasprm="3"/>',
    "torque of a site": '<motor name="m" site="b1" gear="0 0 0 -2 0.5 1" ctrlrange="-0.5 0.5"/>',
}


@pytest.mark.parametrize("actuator", ACTUATORS)
def test_actuators(actuator: str, tmp_path: Path) -> None:
    path = written(tmp_path, "fixed", actuator=ACTUATORS[actuator])
    compare_accelerations(path, {"m": 0.7})


def test_a_limited_force_of_a_joint(tmp_path: Path) -> None:
    path = written(
        tmp_path, "", actuator='<position name="m" joint="x" kp="90" forcerange="-9 3" gear="-2"/>'
    )
    path.write_text(path.read_text().replace('ref="0.2"', 'ref="0.2" actuatorfrcrange="-1.5 4"'))
    compare_accelerations(path, {"m": 0.7})


def test_a_limited_force_of_a_tendon(tmp_path: Path) -> None:
    limits = 'actuatorfrcrange="-1.5 4"'
    path = written(tmp_path, "fixed", limits, actuator='<position name="m" tendon="t" kp="90" gear="-2"/>')
    compare_accelerations(path, {"m": 0.7})


@pytest.mark.one_in(4)
@pytest.mark.parametrize("actuator", ["filter", "intvelocity", "integrator"])
def test_activations_over_time(actuator: str, tmp_path: Path) -> None:
    path = written(tmp_path, "fixed", actuator=ACTUATORS[actuator])
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep, model.opt.integrator = 1e-3, mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.5
    for _ in range(500):
        mujoco.mj_step(model, data)
    run = sr.simulate(sr.System(sr.load_mjcf(path, controls={"m": 1.5})), until=0.5)
    assert run["m_activation"][-1] == pytest.approx(data.act[0], rel=1e-6)
    for name, place in (("x.angle", 0), ("y.displacement", 1)):
        assert run[name][-1] == pytest.approx(data.qpos[place] - model.qpos0[place], abs=1e-5)


def test_an_integrator_stops_at_its_limit(tmp_path: Path) -> None:
    path = written(tmp_path, "", actuator='<intvelocity name="m" joint="y" kp="30" actrange="-1 0.3"/>')
    run = sr.simulate(sr.System(sr.load_mjcf(path, controls={"m": "step(t, 0.5, 1, 0.6, -1)"})), until=0.8)
    state = run["m_activation"]
    assert state.max() == pytest.approx(0.3, abs=1e-3)
    assert state[-1] == pytest.approx(0.3 - 0.23125, abs=1e-3)  # by the integral of u since it was zero


def test_a_limit_of_a_tendon_yields_as_in_mujoco(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(
        """<mujoco><option timestep="0.001"/><default><tendon solimplimit="0.9 0.9 0.001"/></default><worldbody>
        <body><joint name="j" type="slide" axis="0 0 -1"/><geom size="0.1"/></body></worldbody><tendon>
        <fixed name="t" range="-9 0.8"><joint joint="j" coef="2"/></fixed></tendon></mujoco>"""
    )
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for _ in range(4000):
        mujoco.mj_step(model, data)
    rest = sr.equilibrium(sr.System(sr.load_mjcf(path, q0={"j": 0.4})))
    assert rest.success, rest.message
    assert rest["j.displacement"] - 0.4 == pytest.approx(data.qpos[0] - 0.4, rel=1e-3)
    assert rest["j.displacement"] > 0.4 + 1e-4


@pytest.mark.parametrize(("first", "word"), [("x", "angle"), ("y", "displacement")])
def test_a_polynomial_of_a_joint(first: str, word: str, tmp_path: Path) -> None:
    """The joints y and z are one, cylindrical, of the name y."""
    joint = f'<joint joint1="{first}" joint2="z" polycoef="0.1 2 -0.3 0.05 0.01"/>'
    robot = sr.load_mjcf(written(tmp_path, "", equality=joint), q0={"z": 0.4})
    start = sr.assemble(sr.System(robot), rates={"y.angle": 0.3})
    system = sr.System(robot)
    follower, leader = system.joint(first)[word], system.joint("y")["angle"]
    goal = 0.1 + 2 * 0.4 - 0.3 * 0.16 + 0.05 * 0.064 + 0.01 * 0.0256
    assert leader.value(start.q) == pytest.approx(0.4, abs=1e-9)
    assert follower.value(start.q) == pytest.approx(goal)
    slope = 2 - 0.6 * 0.4 + 0.15 * 0.16 + 0.04 * 0.064
    assert follower.rate(start.q, start.v) == pytest.approx(0.3 * slope)


def test_a_joint_held_at_a_value(tmp_path: Path) -> None:
    robot = sr.load_mjcf(written(tmp_path, "", equality='<joint joint1="y" polycoef="0.3 0 0 0 0"/>'))
    assert sr.mobility(sr.System(robot)).degrees_of_freedom == 2


TENDONS = {
    "held": (
        '<fixed name="t"><joint joint="x" coef="0.5"/><joint joint="y" coef="-2"/></fixed>',
        "0.1 5 6 7 8",
        "",
    ),
    "polynomial": (
        '<fixed name="t"><joint joint="x" coef="0.5"/><joint joint="y" coef="-2"/></fixed>'
        '<fixed name="s"><joint joint="z" coef="1.5"/></fixed>',
        "0.1 0.5 -0.2 0.1 0.05",
        'tendon2="s"',
    ),
    "rod": ('<spatial name="t"><site site="w"/><site site="b1"/></spatial>', "0.02 0 0 0 0", ""),
}


@pytest.mark.filterwarnings("ignore:.*assembly changed")  # the file does not satisfy them
@pytest.mark.parametrize("name", TENDONS)
def test_equalities_of_tendons(name: str, tmp_path: Path) -> None:
    """Where the assembly closes them, MuJoCo's residual vanishes, and the speeds are those that it allows."""
    tendon, factors, more = TENDONS[name]
    equality = f'<tendon tendon1="t" {more} polycoef="{factors}"/>'
    path = tmp_path / "model.xml"
    path.write_text(FILE.format(tendon=tendon, equality=equality, actuator=""))
    robot = sr.load_mjcf(path, q0={"x": 0.2, "z": 0.3}, ignore=["limits"])
    system = sr.System(robot)
    start = sr.assemble(system, rates={"x.angle": 0.5, "y.angle": -0.3})
    assert start.success, start.message
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    joints = [system.joint("x")["angle"], system.joint("y")["displacement"], system.joint("y")["angle"]]
    data.qpos[:] = [one.value(start.q) for one in joints] + model.qpos0
    data.qvel[:] = [one.rate(start.q, start.v) for one in joints]
    mujoco.mj_forward(model, data)
    assert abs(data.efc_pos[0]) < 1e-10
    assert abs(data.efc_vel[0]) < 1e-10
    assert abs(data.efc_J[0]).max() > 0.1


def around(folder: Path, kind: str, side: str, given: str, more: str = "", actuator: str = "") -> Path:
    """A tendon from the world around a shape of the first body to the second one."""
    wrap = '<geom geom="g" sidesite="side"/>' if SIDES[side] else '<geom geom="g"/>'
    tendon = f'<spatial name="t" {given}><site site="w"/>{wrap}<site site="b1"/>{more}</spatial>'
    shape = SHAPE.format(kind=kind) + (f'<site name="side" pos="{SIDES[side]}"/>' if SIDES[side] else "")
    file = folder / "model.xml"
    text = FILE.format(tendon=tendon, equality="", actuator=actuator)
    file.write_text(text.replace("<geom type", f"{shape}<geom type", 1))
    return file


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_tendons_around_shapes(kind: str, side: str, tmp_path: Path) -> None:
    """Without friction, which sticks in MuJoCo; its point of a path through a shape has a tolerance of 1e-6."""
    path = around(tmp_path, kind, side, 'stiffness="30" springlength="0.3" damping="4"')
    compare_accelerations(path, states=20, rtol=1e-7 if side == "through" else 1e-9)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_rates_of_tendons_around_shapes(kind: str, side: str, tmp_path: Path) -> None:
    path = around(tmp_path, kind, side, 'stiffness="30"')
    system, model = sr.System(sr.load_mjcf(path)), mujoco.MjModel.from_xml_path(str(path))
    space, rng, touching = sr.JointSpace(system), np.random.default_rng(5), 0
    for _ in range(20):
        theta, qpos, order = random_configuration(space, model, rng)
        rates, data = rng.normal(size=space.freedoms), mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = qpos, rates[order]
        mujoco.mj_forward(model, data)
        q, v = space.q(theta), space.T(theta) @ rates
        found = [output_at(system, q, v, f"t.{name}") for name in ("length", "rate")]
        expected = [data.ten_length[0], data.ten_velocity[0]]
        np.testing.assert_allclose(found, expected, atol=1e-6 if side == "through" else 1e-10)
        touching += data.ten_wrapnum[0] > 2
    assert 3 < touching


@pytest.mark.parametrize("side", ["", 'sidesite="side"'])
def test_a_symmetric_pulley(side: str, tmp_path: Path) -> None:
    """Both ends and the axis are on one line."""
    path = tmp_path / "model.xml"
    path.write_text(
        f"""<mujoco><option gravity="0 0 0"/><worldbody><site name="w" pos="-1 0 0"/><site name="side" pos="0 0.3 0"/>
        <geom name="g" type="cylinder" size="0.2 0.1"/><body pos="1 0 0"><joint name="x" type="slide" axis="0 1 0"/>
        <geom size="0.1"/><site name="s"/></body></worldbody><tendon><spatial name="t" stiffness="4" springlength="0">
        <site site="w"/><geom geom="g" {side}/><site site="s"/></spatial></tendon></mujoco>"""
    )
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    system = sr.System(sr.load_mjcf(path))
    found = system.forward_dynamics(system.q0, np.zeros(system.nq)).a[1]
    assert found == pytest.approx(data.qacc[0], rel=1e-12)
    assert abs(found) > 0.3


def test_a_motor_of_a_tendon_with_pulleys_and_shapes(tmp_path: Path) -> None:
    more = '<pulley divisor="3"/><site site="a1"/><geom geom="g" sidesite="side"/><site site="b1"/>'
    motor = '<position name="m" tendon="t" kp="20" kv="3" gear="2"/>'
    compare_accelerations(around(tmp_path, "cylinder", "side", "", more, motor), {"m": 0.7})


@pytest.mark.parametrize("name", PATHS)
def test_armature_of_tendons(name: str, tmp_path: Path) -> None:
    compare_accelerations(written(tmp_path, name, 'armature="3" stiffness="30"'))


def test_armature_of_a_tendon_between_trees(tmp_path: Path) -> None:
    """M is that of the joints and m l_qᵀ l_q; MuJoCo leaves out the entries of different trees."""
    path = tmp_path / "model.xml"
    trees = [
        f'<body pos="{x} 0 0"><joint axis="0 1 0.2"/><geom size="0.1" pos="0 0 -1"/><site name="{x}" pos="0 0.1 -1"/>'
        "</body>"
        for x in range(2)
    ]
    tendon = '<tendon><spatial armature="4"><site site="0"/><site site="1"/></spatial></tendon>'
    path.write_text(f"<mujoco><worldbody>{''.join(trees)}</worldbody>{tendon}</mujoco>")
    space, model = sr.JointSpace(sr.System(sr.load_mjcf(path))), mujoco.MjModel.from_xml_path(str(path))
    theta, qpos, _ = random_configuration(space, model, np.random.default_rng(2))
    model.tendon_armature[:] = 0
    data, l_q = at(model, qpos), np.zeros(2)
    for n, column in enumerate(np.eye(2)):
        data.qvel[:] = column
        mujoco.mj_forward(model, data)
        l_q[n] = data.ten_velocity[0]
    expected = mass_matrix(model, data) + 4 * np.outer(l_q, l_q)
    assert abs(expected[0, 1]) > 0.1
    np.testing.assert_allclose(space.M(theta), expected, atol=1e-12)


@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_a_side_site_of_another_body(kind: str, tmp_path: Path) -> None:
    """It moves relative to the shape, and decides in each state whether the tendon goes around or through."""
    path = around(tmp_path, kind, "side", 'stiffness="30" springlength="0.3" damping="4"')
    text = path.read_text().replace('type="slide" axis="1 1 0"', 'type="slide" axis="1 1 0" range="-1 1"')
    text = text.replace('<site name="b1"', '<site name="other" pos="-0.1 0.3 -0.8"/><site name="b1"')
    path.write_text(text.replace('sidesite="side"', 'sidesite="other"'))
    compare_accelerations(path, states=30, rtol=1e-7)


def test_a_side_site_of_the_world(tmp_path: Path) -> None:
    path = around(tmp_path, "cylinder", "side", 'stiffness="30" springlength="0.3"')
    path.write_text(path.read_text().replace('sidesite="side"', 'sidesite="w"'))
    compare_accelerations(path, states=20)


def test_everything_at_once(tmp_path: Path) -> None:
    """Springs, dampers, friction and armature of joints, a tendon, gravcomp and three actuators with limits and lag."""
    tendon = SPATIAL.format(all=FORCES["all"])
    actuator = (
        '<general name="m" joint="x" dyntype="filter" dynprm="0.1" gainprm="7" forcerange="-3 3"/>'
        '<position name="p" joint="y" kp="20" kv="3" ctrlrange="-0.1 0.1"/><motor name="q" tendon="t" gear="2"/>'
    )
    path = tmp_path / "model.xml"
    text = FILE.format(tendon=tendon, equality="", actuator=actuator).replace(
        "<body ", '<body gravcomp="0.3" '
    )
    joint = 'stiffness="3" springref="0.3" damping="0.7" frictionloss="0.4" armature="0.05"'
    path.write_text(text.replace("<worldbody>", f"<default><joint {joint}/></default><worldbody>"))
    compare_accelerations(path, {"m": 0.7, "p": 0.5, "q": -0.4})


FORMULAS = {
    "polynomial of a joint": {"equality": '<joint joint1="y" joint2="x" polycoef="0.1 0.3 0.5 0 0"/>'},
    "sum": {"equality": '<tendon tendon1="t" polycoef="0.1 0 0 0 0"/>', "path": "fixed"},
}


@pytest.mark.filterwarnings("ignore:.*assembly changed")
@pytest.mark.one_in(4)
@pytest.mark.parametrize("case", FORMULAS)
def test_hyphens_and_spaces_in_names_are_no_operators(case: str, tmp_path: Path) -> None:
    path = written(tmp_path, **{"path": "", **FORMULAS[case]})
    runs = [sr.simulate(sr.System(sr.load_mjcf(path)), until=0.01)]
    text = path.read_text()
    for name in "xyz":
        for word in ("name", "joint", "joint1", "joint2"):
            text = text.replace(f' {word}="{name}"', f' {word}="arm-{name} 1"')
    path.write_text(text)
    robot = sr.load_mjcf(path)
    assert any("arm-" in part.name for part in (*robot.joints, *robot.forces))
    runs.append(sr.simulate(sr.System(robot), until=0.01))
    np.testing.assert_allclose(runs[0].q, runs[1].q, atol=1e-12)


def test_a_spring_with_one_length_has_no_corner(tmp_path: Path) -> None:
    """Steps would end at it wherever the spring has its length, for each of many tendons."""
    text = (
        '<mujoco><worldbody><body><joint name="j"/><geom size="0.1"/></body></worldbody><tendon><fixed name="t" '
        'stiffness="4" springlength="{}"><joint joint="j" coef="2"/></fixed></tendon></mujoco>'
    )
    for given, expected in (("0.3", "- stiffness*(x - longest)"), ("0.1 0.3", "min(x - shortest, 0)")):
        (tmp_path / "t.xml").write_text(text.format(given))
        (force,) = (one for one in sr.load_mjcf(tmp_path / "t.xml").forces if isinstance(one, sr.Tendon))
        assert expected in str(force.value)


def test_a_limit_of_a_stationary_length_is_a_stop_with_a_note(tmp_path: Path) -> None:
    """The slide moves across the tendon: MuJoCo has no inertia along it in the pose of the file."""
    path = tmp_path / "model.xml"
    path.write_text(
        """<mujoco><option gravity="5 0 0"/><worldbody><site name="w" pos="0 0 1"/>
        <body><joint name="x" type="slide" axis="1 0 0"/><geom size="0.1"/><site name="s"/></body></worldbody>
        <tendon><spatial name="t" range="0 1.2"><site site="w"/><site site="s"/></spatial></tendon></mujoco>"""
    )
    robot = sr.load_mjcf(path, q0={"x": 0.7})
    assert any("1 inertia along limited tendons whose length is stationary" in note for note in robot.notes)
    rest = sr.equilibrium(sr.System(robot))
    assert rest.success, rest.message
    slope = np.sqrt(1 - 1 / 1.2**2)  # of the length; the stop has m/(1 - 0.95)/0.02²
    assert rest["t.length"] - 1.2 == pytest.approx(5 / slope * 0.05 * 0.02**2, rel=0.01)
    assert sr.load_mjcf(path, ignore=["limits"]).forces == ()
