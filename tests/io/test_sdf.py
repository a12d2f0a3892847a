"""SDF: frames, joints, loops and models, against a URDF of the same mechanism, MuJoCo or closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.io.poses import link_poses, pose_difference

import sarrus as sr

INERTIA = "<inertia><ixx>0.3</ixx><iyy>0.4</iyy><izz>0.5</izz><ixy>0.01</ixy></inertia>"
INERTIAL = f"<inertial><pose>0.1 0.2 0.3 0.3 0 0</pose><mass>2</mass>{INERTIA}</inertial>"
FREEDOMS = {"fixed": 0, "revolute": 1, "continuous": 1, "prismatic": 1, "screw": 1, "universal": 2, "ball": 3}
AXES = "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>1 0 0</xyz></axis2>"


def loaded(folder: Path, inside: str, version: str = "1.9", **options: object) -> sr.Robot:
    path = folder / "model.sdf"
    path.write_text(f'<sdf version="{version}">{inside}</sdf>')
    return sr.load_sdf(path, **options)  # type: ignore[arg-type]


def link(name: str, inside: str = "", inertial: str = INERTIAL) -> str:
    return f'<link name="{name}">{inside}{inertial}</link>'


def joint(name: str, kind: str, parent: str, child: str, inside: str = "") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{inside}</joint>'
    )


def model(inside: str, attributes: str = "") -> str:
    return f'<model name="m"{attributes}>{inside}</model>'


def accelerations(robot: sr.Robot, rates: dict[str, float]) -> dict[str, float]:
    """Of the joints in the initial position, from M θ̈ + … = Q on the tangent space of the constraints."""
    system = sr.System(robot)
    start = sr.assemble(system, **({"rates": rates} if rates else {}))
    q, v = start.q, start.v
    M, J = system.M(q).toarray(), system.Phi_q(q).toarray()
    matrix = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    right = np.concatenate([system.Q(q, v) + system.S(q, v), system.gamma(q, v)])
    a = np.linalg.lstsq(matrix, right, rcond=None)[0][: system.nq].reshape(-1, 7)
    return {f"{name}.{axis}": a[n, k] for n, name in enumerate(system.bodies) for k, axis in enumerate("xyz")}


URDF = """\
<robot name="m"><link name="base"/>
<link name="a"><inertial><origin xyz="0.1 0.2 0.3" rpy="0.3 0 0"/><mass value="2"/>
  <inertia ixx="0.3" ixy="0.01" ixz="0" iyy="0.4" iyz="0" izz="0.5"/></inertial></link>
<link name="b"><inertial><origin xyz="0.1 0.2 0.3" rpy="0.3 0 0"/><mass value="2"/>
  <inertia ixx="0.3" ixy="0.01" ixz="0" iyy="0.4" iyz="0" izz="0.5"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="a"/>
  <origin xyz="1 2 3" rpy="0.3 -0.4 0.5"/><axis xyz="0 0.6 0.8"/><dynamics damping="0.3"/>
  <limit lower="-1" upper="1" effort="1" velocity="2"/></joint>
<joint name="k" type="prismatic"><parent link="a"/><child link="b"/>
  <origin xyz="0.5 0.6 0.7" rpy="0.1 0.2 0.3"/><axis xyz="1 0 0"/></joint>
</robot>
"""
DEGREES = " ".join(map(str, np.rad2deg([0.1, 0.2, 0.3])))
SAME = model(
    '<frame name="shoulder"><pose>1 2 3 0.3 -0.4 0.5</pose></frame>'
    + link("a", '<pose relative_to="shoulder"/>')
    + link(
        "b",
        f'<pose relative_to="a" degrees="true">0.5 0.6 0.7 {DEGREES}</pose>',
    )
    + joint(
        "j",
        "revolute",
        "world",
        "a",
        "<axis><xyz>0 0.6 0.8</xyz><dynamics><damping>0.3</damping></dynamics>"
        "<limit><lower>-1</lower><upper>1</upper><effort>1</effort><velocity>2</velocity></limit></axis>",
    )
    + joint("k", "prismatic", "a", "b", '<axis><xyz expressed_in="b">1 0 0</xyz></axis>')
)


@pytest.fixture
def urdf(tmp_path: Path) -> sr.Robot:
    (tmp_path / "m.urdf").write_text(URDF)
    return sr.load_urdf(tmp_path / "m.urdf", q0={"j": 0.3, "k": 0.2}, gravity=(0, 0, -9.8))


def test_a_tree_is_that_of_a_urdf(urdf: sr.Robot, tmp_path: Path) -> None:
    sdf = loaded(tmp_path, SAME, q0={"j": 0.3, "k": 0.2})
    found, expected = (sr.JointSpace(sr.System(robot)) for robot in (sdf, urdf))
    theta = found.pack({"j": 0.7, "k": -0.2})
    np.testing.assert_allclose(found.M(theta), expected.M(theta), atol=1e-13)
    poses = link_poses(urdf, expected, theta)
    for name, pose in link_poses(sdf, found, theta).items():
        assert pose_difference(pose, poses[name].r, poses[name].A) < 1e-14
    rates = {"j": 0.8, "k": -0.3}
    assert accelerations(sdf, rates) == pytest.approx(accelerations(urdf, rates), abs=1e-12)
    assert sdf.limits["j"] == urdf.limits["j"]


@pytest.mark.parametrize(
    ("limit", "start", "outside"),
    [
        ("<upper>-0.5</upper>", -2.0, False),
        ("<lower>0.5</lower>", 2.0, False),
        ("<lower>-1</lower>", 2.0, False),
        ("<lower>-1</lower>", -2.0, True),
        ("<lower>-1e16</lower><upper>1</upper>", -2.0, False),
        ("<effort>-1</effort><velocity>-1</velocity>", 2.0, False),
    ],
)
def test_an_end_that_is_not_given_is_no_limit(
    limit: str, start: float, outside: bool, tmp_path: Path
) -> None:
    """Unlike in a URDF, where it is zero."""
    axis = f"<axis><xyz>0 0 1</xyz><limit>{limit}</limit></axis>"
    text = model(link("a") + joint("j", "revolute", "world", "a", axis))
    robot = loaded(tmp_path, text, q0={"j": start})
    assert any("outside of its limits" in note for note in robot.notes) == outside
    assert robot.limits["j"][2:4] == (None, None)


@pytest.mark.parametrize("kind", FREEDOMS)
@pytest.mark.parametrize("outward", [True, False])
def test_a_joint_leaves_its_freedoms(kind: str, outward: bool, tmp_path: Path) -> None:
    """Also from the child, which is reached first, to the parent."""
    ends = ("a", "b") if outward else ("b", "a")
    parts = link("a") + link("b", "<pose>0.5 0 1 0.3 0.2 0.1</pose>")
    robot = loaded(
        tmp_path, model(parts + joint("first", "revolute", "world", "a", Z) + joint("j", kind, *ends, AXES))
    )
    system = sr.System(robot)
    assert system.nq - np.linalg.matrix_rank(system.Phi_q(system.q0).toarray()) == FREEDOMS[kind] + 1
    assert abs(system.Phi(system.q0)).max() < 1e-14


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "universal"])
def test_a_reversed_joint_has_the_same_coordinates(kind: str, tmp_path: Path) -> None:
    """A joint with exchanged ends and the opposite axes is the same one."""
    parts = link("a") + link("b", "<pose>0.5 0 1 0.3 0.2 0.1</pose>") + joint("first", "fixed", "world", "a")
    place = '<pose relative_to="b">0.1 0.2 0.3 0.4 0.5 0.6</pose>'
    swapped = "<axis><xyz>-1 0 0</xyz></axis><axis2><xyz>0 0 -1</xyz></axis2>"
    if kind != "universal":
        swapped = "<axis><xyz>0 0 -1</xyz></axis>"
    one, other = (
        loaded(tmp_path, model(parts + joint("j", kind, *ends, place + axes)))
        for ends, axes in ((("a", "b"), AXES), (("b", "a"), swapped))
    )
    spaces = [sr.JointSpace(sr.System(robot)) for robot in (one, other)]
    names = [{"j.1": 0.3, "j.2": 0.5}, {"j.2": 0.3, "j.1": 0.5}] if kind == "universal" else [{"j": 0.3}] * 2
    np.testing.assert_allclose(
        *(space.q(space.pack(v)) for space, v in zip(spaces, names, strict=True)), atol=1e-15
    )


def test_a_model_without_a_joint_to_the_world_is_free(tmp_path: Path) -> None:
    text = model(
        "<pose>0 0 2 0 0 0</pose>"
        + link("a", "<pose>1 0 0 0 0 0</pose>")
        + link("b")
        + joint("j", "ball", "a", "b")
    )
    free, fixed = loaded(tmp_path, text), loaded(tmp_path, text, base="fixed")
    assert [len(robot.bodies) for robot in (free, fixed)] == [2, 1]
    np.testing.assert_allclose(free.bodies[0].pose().r, [1, 0, 2])
    np.testing.assert_allclose(fixed.bodies[0].pose().r, [0, 0, 2])
    assert sr.System(free).nq - sr.System(free).m == 9


BAR = "<inertial><mass>1</mass><inertia><ixx>0.01</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>"
Z = "<axis><xyz>0 0 1</xyz></axis>"
FOUR_BAR = model(
    link("crank", "<pose>0 0 0 0 0 1.5707963267948966</pose>", BAR)
    + link("coupler", "<pose>0 2 0 0 0 0</pose>", BAR)
    + link("rocker", "<pose>3 0 0 0 0 1.5707963267948966</pose>", BAR)
    + joint("a", "revolute", "world", "crank", Z)
    + joint("b", "revolute", "crank", "coupler", Z)
    + joint("c", "revolute", "world", "rocker", Z)
    + joint("d", "revolute", "coupler", "rocker", '<pose relative_to="coupler">3 0 0 0 0 0</pose>' + Z)
)


def test_two_parents_close_a_loop(tmp_path: Path) -> None:
    """A parallelogram falls like one bar: its coupler moves without rotation."""
    robot = loaded(tmp_path, FOUR_BAR, gravity=(9.8, 0, 0))
    assert [one.name for one in robot.joints][-1] == "d"
    system = sr.System(robot)
    assert sr.mobility(system).degrees_of_freedom == 1
    inertia = (
        2 * 0.1 + 1 * 2**2
    )  # of crank and rocker about their ends, where their masses are, and of the coupler
    assert accelerations(robot, {})["coupler.x"] == pytest.approx(2**2 * 1 * 9.8 / inertia)


def test_a_screw(tmp_path: Path) -> None:
    """A nut of pitch h falls with m g / (m + J (2π/h)²), with a right-handed thread."""
    nut = link("nut", inertial="<inertial><mass>2</mass><inertia><izz>0.003</izz></inertia></inertial>")
    pitch = 0.1
    expected = -2 * 9.8 / (2 + 0.003 * (2 * np.pi / pitch) ** 2)
    for word in (
        f"<screw_thread_pitch>{pitch}</screw_thread_pitch>",
        f"<thread_pitch>{-2 * np.pi / pitch}</thread_pitch>",
    ):
        robot = loaded(tmp_path, model(nut + joint("j", "screw", "world", "nut", word + Z)))
        assert accelerations(robot, {})["nut.z"] == pytest.approx(expected, rel=1e-12)
        run = sr.simulate(sr.System(robot), until=0.1)
        assert run["j.angle"][-1] == pytest.approx(run["nut"].position[-1, 2] * 2 * np.pi / pitch, rel=1e-9)


@pytest.mark.parametrize("turned", [False, True])
def test_a_gearbox(turned: bool, tmp_path: Path) -> None:
    """θ_2 = -3 θ_1 about the axes of the gearbox, whichever axes the hinges have."""
    parts = link("a", inertial=BAR) + link("b", "<pose>1 0 0 0 0 0</pose>", BAR)
    axis = "<axis><xyz>0 0 -1</xyz></axis>" if turned else Z
    parts += joint("first", "revolute", "world", "a", axis) + joint("second", "revolute", "world", "b", Z)
    box = "<gearbox_ratio>3</gearbox_ratio><gearbox_reference_body>world</gearbox_reference_body>"
    parts += joint("box", "gearbox", "a", "b", box + Z + Z.replace("axis", "axis2"))
    (coupler,) = (one for one in loaded(tmp_path, model(parts)).joints if isinstance(one, sr.Coupler))
    assert coupler.name == "second_mimic"
    system = sr.System(loaded(tmp_path, model(parts), gravity=(0, 0, 0)))
    run = sr.simulate(system, sr.assemble(system, rates={"second": 3.0}), until=0.1)
    assert run["first.rate"][-1] == pytest.approx(1.0 if turned else -1.0)


def test_a_mimic_with_reference(tmp_path: Path) -> None:
    parts = link("a", inertial=BAR) + link("b", "<pose>1 0 0 0 0 0</pose>", BAR)
    mimic = '<mimic joint="first"><multiplier>2</multiplier><offset>0.3</offset><reference>0.1</reference></mimic>'
    parts += joint("first", "revolute", "world", "a", Z)
    parts += joint("second", "revolute", "world", "b", f"<axis><xyz>0 0 1</xyz>{mimic}</axis>")
    robot = loaded(tmp_path, model(parts), q0={"first": 0.5})
    assert robot.mimics["second"] == ("first", 2.0, pytest.approx(0.1), ())
    assert 2 * np.arctan2(*robot.bodies[1].pose().p[[3, 0]]) == pytest.approx(2 * (0.5 - 0.1) + 0.3)


def test_a_spring(tmp_path: Path) -> None:
    spring = (
        "<dynamics><spring_stiffness>5</spring_stiffness><spring_reference>0.2</spring_reference></dynamics>"
    )
    text = model(
        link("a", inertial=BAR)
        + joint("j", "revolute", "world", "a", f"<axis><xyz>0 0 1</xyz>{spring}</axis>")
    )
    system = sr.System(loaded(tmp_path, text, q0={"j": 0.0}))
    space = sr.JointSpace(system)
    assert space.T(space.zero()).T @ system.Q(system.q0, 0 * system.q0, 0.0) == pytest.approx([5 * 0.2])
    assert not loaded(tmp_path, text, ignore=["dynamics"]).forces


def test_axes_of_old_files_are_in_the_axes_of_the_model(tmp_path: Path) -> None:
    text = model(link("a", "<pose>0 0 0 0.5 0 0</pose>") + joint("j", "revolute", "world", "a", Z))
    old, new, newer = (
        loaded(tmp_path, text, version=version).joints[0] for version in ("1.4", "1.6", "1.11")
    )
    np.testing.assert_allclose(old.frame_i.z, [0, 0, 1], atol=1e-15)
    for one in (new, newer):
        np.testing.assert_allclose(one.frame_i.z, [0, -np.sin(0.5), np.cos(0.5)], atol=1e-15)


def test_nested_models(tmp_path: Path) -> None:
    inner = f'<model name="hand"><pose>0 0 1 0 0 0</pose>{link("palm")}{link("tip", "<pose>0 0 0.5 0 0 0</pose>")}'
    inner += joint("wrist", "revolute", "palm", "tip", Z) + "</model>"
    parts = (
        link("a") + inner + joint("j", "revolute", "world", "a", Z) + joint("k", "fixed", "a", "hand::palm")
    )
    robot = loaded(tmp_path, model(parts))
    assert set(robot.links) == {"a", "hand::palm", "hand::tip"}
    np.testing.assert_allclose(robot.link("hand::tip").pose().r, [0, 0, 1.5])
    assert [branch.motions[0].name for branch in robot.branches] == ["j", "hand::wrist"]


@pytest.mark.parametrize("merge", [False, True])
def test_included_models(merge: bool, tmp_path: Path) -> None:
    folder = tmp_path / "models" / "hand"
    folder.mkdir(parents=True)
    (folder / "model.config").write_text('<model><sdf version="1.9">hand.sdf</sdf></model>')
    (folder / "hand.sdf").write_text(
        f'<sdf version="1.9"><model name="hand">{link("palm")}{link("tip", "<pose>0 0 0.5 0 0 0</pose>")}'
        + joint("wrist", "revolute", "palm", "tip", Z)
        + "</model></sdf>"
    )
    include = (
        f'<include merge="{str(merge).lower()}"><uri>model://hand</uri><pose>0 0 1 0 0 0</pose></include>'
    )
    palm, tip = ("palm", "tip") if merge else ("hand::palm", "hand::tip")
    text = model(
        link("a") + include + joint("j", "revolute", "world", "a", Z) + joint("k", "fixed", "a", palm)
    )
    robot = loaded(tmp_path, text, search=[tmp_path / "models"])
    np.testing.assert_allclose(robot.link(tip).pose().r, [0, 0, 1.5])
    assert len(robot.bodies) == 2


@pytest.mark.parametrize("uri", ["file://{}/hand.sdf", "{}/hand.sdf", "model://../../elsewhere/hand.sdf"])
def test_models_outside_of_the_folder_are_not_included(uri: str, tmp_path: Path) -> None:
    folder, elsewhere = tmp_path / "home" / "model", tmp_path / "elsewhere"
    for place in (folder, elsewhere):
        place.mkdir(parents=True)
    (elsewhere / "hand.sdf").write_text(f'<sdf version="1.9"><model name="hand">{link("palm")}</model></sdf>')
    text = model(link("a") + f"<include><uri>{uri.format(elsewhere)}</uri></include>")
    with pytest.raises(
        sr.ModelError, match=r"outside of the folder of the model\. Name its folder in search"
    ):
        loaded(folder, text)
    assert len(loaded(folder, text, search=[elsewhere]).links) == 2


def test_a_placement_frame(tmp_path: Path) -> None:
    foot = "<frame name='foot'><pose>0 0 -1 0 0 0.5</pose></frame>"
    robot = loaded(tmp_path, model(f"<pose>3 0 0 0 0 0</pose>{foot}{link('a')}", ' placement_frame="foot"'))
    np.testing.assert_allclose(robot.bodies[0].pose().r, [3, 0, 1], atol=1e-15)


def test_a_world_of_models(tmp_path: Path) -> None:
    """Static models are the ground; the scenery of every world need not be there."""
    floor = f'<model name="floor"><static>true</static>{link("plane")}</model>'
    world = f'<world name="w"><gravity>0 0 -1.6</gravity><include><uri>model://sun</uri></include>{floor}{model(link("a"))}'
    world += joint("j", "revolute", "floor::plane", "m::a", Z) + "</world>"
    robot = loaded(tmp_path, world)
    assert [body.name for body in robot.bodies] == ["m__a"]
    assert robot.gravity == (0, 0, -1.6)
    assert robot.link("floor::plane").body is sr.ground
    assert any("sun" in note for note in robot.notes)


def test_a_link_without_gravity(tmp_path: Path) -> None:
    robot = loaded(tmp_path, model(link("a", "<gravity>false</gravity>")))
    assert accelerations(robot, {}) == pytest.approx({"a.x": 0, "a.y": 0, "a.z": 0}, abs=1e-12)


WRONG = {
    "type": (joint("j", "revolut", "world", "a", Z), "unknown type.*Did you mean"),
    "parent": (joint("j", "revolute", "b", "a", Z), 'no link or frame "b"'),
    "world as child": (joint("j", "revolute", "a", "world", Z), "Exchange parent and child"),
    "no axis": (joint("j", "revolute", "world", "a"), "has no <axis>"),
    "itself": (joint("j", "revolute", "a", "a", Z), "to itself"),
    "pose": (
        "<frame name='f'><pose>0 0 1</pose></frame>" + joint("j", "ball", "world", "f"),
        "must be 6 numbers",
    ),
    "circle": (
        "<frame name='f'><pose relative_to='g'/></frame><frame name='g'><pose relative_to='f'/></frame>"
        + joint("j", "ball", "world", "f"),
        "relative to itself",
    ),
    "include": ("<include><uri>model://nothing</uri></include>", r'not found.*ignore=\["includes"\]'),
    "gearbox": (
        joint(
            "j",
            "gearbox",
            "world",
            "a",
            "<gearbox_reference_body>a</gearbox_reference_body>" + Z + Z.replace("axis", "axis2"),
        ),
        "no hinge",
    ),
    "decay": (link("b", "<velocity_decay><linear>0.1</linear></velocity_decay>"), r"ignore=\['decay'\]"),
    "kinematic": (link("b", "<kinematic>true</kinematic>"), r"ignore=\['kinematic'\]"),
    "auto": (link("b", inertial='<inertial auto="true"/>'), "has no <collision>"),
    "auto with mass": (
        link("b", inertial='<inertial auto="true"><mass>1</mass></inertial>'),
        "Remove one of them",
    ),
    "auto of a mesh": (
        link("b", "<collision><geometry><mesh/></geometry></collision>", '<inertial auto="true"/>'),
        "has a mesh from which no inertia is computed",
    ),
}


SHAPES = {  # half of the height, and half axes of the elliptic section at z
    "<sphere><radius>0.3</radius></sphere>": (0.3, lambda z: 2 * [np.sqrt(0.09 - z * z)]),
    "<cylinder><radius>0.2</radius><length>0.8</length></cylinder>": (0.4, lambda z: 2 * [0.2 + 0 * z]),
    "<capsule><radius>0.2</radius><length>0.6</length></capsule>": (
        0.5,
        lambda z: 2 * [np.sqrt(0.04 - np.maximum(abs(z) - 0.3, 0) ** 2)],
    ),
    "<ellipsoid><radii>0.1 0.2 0.4</radii></ellipsoid>": (
        0.4,
        lambda z: [f * np.sqrt(1 - (z / 0.4) ** 2) for f in (0.1, 0.2)],
    ),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(
    ("of_link", "of_shape", "density"), [("", "", 1000.0), ("12", "", 12.0), ("12", "7", 7.0)]
)
def test_inertials_of_collision_shapes(
    shape: str, of_link: str, of_shape: str, density: float, tmp_path: Path
) -> None:
    """Mass and moments of the slices of a shape, beside a box of 0.5 m³ that is 1 m away along z."""

    def dense(value: str) -> str:
        return f"<density>{value}</density>" if value else ""

    half, section = SHAPES[shape]
    z, weights = np.polynomial.legendre.leggauss(2000)
    z, weights = half * z, half * weights
    a, b = section(z)
    area = density * np.pi * a * b * weights
    mass, moments = (
        area.sum(),
        [
            float(area @ (b * b / 4 + z * z)),
            float(area @ (a * a / 4 + z * z)),
            float(area @ (a * a + b * b)) / 4,
        ],
    )
    shapes = (
        f"<collision>{dense(of_shape)}<geometry>{shape}</geometry></collision>"
        f"<collision><pose>0 0 1 0 0 {np.pi / 2}</pose>{dense(of_shape)}"
        "<geometry><box><size>0.5 1 1</size></box></geometry></collision>"
    )
    robot = loaded(tmp_path, model(link("a", shapes, f'<inertial auto="true">{dense(of_link)}</inertial>')))
    (body,) = robot.bodies
    box = 0.5 * density
    center = box / (mass + box)
    shift = mass * center**2 + box * (1 - center) ** 2
    assert body.mass == pytest.approx(mass + box, rel=1e-4)
    assert np.asarray(body.center_of_mass) == pytest.approx([0, 0, center], abs=1e-4)
    turned = box / 12 * np.array([0.5**2 + 1, 1 + 1, 0.5**2 + 1])
    wanted = np.add(moments, turned) + [shift, shift, 0]
    assert np.diag(np.asarray(body.inertia)) == pytest.approx(wanted, rel=1e-4)


def test_a_universal_joint_without_axes_turns_about_x_and_y(tmp_path: Path) -> None:
    pose = "<pose>0 0 0.2 0.3 0.4 0.5</pose>"
    axes = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
    rates = {"j.angle_i": 0.3, "j.angle_j": 0.5}
    found = [
        accelerations(
            loaded(tmp_path, model(link("a") + joint("j", "universal", "world", "a", pose + own))), rates
        )
        for own in ("", axes)
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-12)


@pytest.mark.parametrize("case", WRONG)
def test_wrong_files_are_refused(case: str, tmp_path: Path) -> None:
    inside, words = WRONG[case]
    with pytest.raises(sr.ModelError, match=rf"model.sdf:1: .*{words}"):
        loaded(tmp_path, model(link("a") + inside))


def test_what_is_refused_can_be_ignored(tmp_path: Path) -> None:
    robot = loaded(tmp_path, model(link("a", "<kinematic>true</kinematic>")), ignore=["kinematic"])
    assert any("<kinematic>" in note for note in robot.notes)


def test_axes_of_balls_are_noted(tmp_path: Path) -> None:
    axis = "<axis><xyz>0 0 1</xyz><dynamics><damping>1</damping></dynamics></axis>"
    robot = loaded(tmp_path, model(link("a") + link("b") + joint("j", "ball", "a", "b", axis)))
    assert not robot.forces
    assert "axes of 1 ball or fixed joint are left out, with their dynamics and limits" in robot.notes


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_three_hinges_through_massless_links_are_those_of_mjcf(damping: float, tmp_path: Path) -> None:
    """A spherical joint, or three revolute ones if a hinge has a damper."""
    pytest.importorskip("mujoco")
    none = "<inertial><mass>0</mass><inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia></inertial>"
    whole = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
    links = link("p", inertial=none) + link("q", inertial=none) + link("a", inertial=whole)
    axes, hinges, written = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}, "", ""
    for (name, axis), parent, child in zip(axes.items(), ("world", "p", "q"), ("p", "q", "a"), strict=True):
        loss = damping if name == "y" else 0.0
        dynamics = f"<dynamics><damping>{loss}</damping></dynamics>"
        hinges += joint(name, "revolute", parent, child, f"<axis><xyz>{axis}</xyz>{dynamics}</axis>")
        written += f'<joint name="{name}" axis="{axis}" damping="{loss}"/>'
    inertial = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    path = tmp_path / "model.xml"
    path.write_text(f'<mujoco><worldbody><body name="a">{written}{inertial}</body></worldbody></mujoco>')
    robots = loaded(tmp_path, model(links + hinges)), sr.load_mjcf(path)
    found, expected = ([type(one).__name__ for one in robot.joints] for robot in robots)
    assert found == expected == (["Revolute"] * 3 if damping else ["Spherical"])
    assert [body.name for body in robots[0].bodies] == [body.name for body in robots[1].bodies]
