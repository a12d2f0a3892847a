"""Exported files: a model and its file have the same constraints, and the same accelerations in random states."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.io.beside_mujoco import accelerations, compare_accelerations, mass_matrix

import sarrus as sr
from sarrus.cli import main
from sarrus.euler import A as rotation_matrix
from sarrus.io.export.urdf import roll_pitch_yaw

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

JOINTS: dict[str, Any] = {
    "revolute": lambda *ends: sr.Revolute("j", *ends, point=(0.3, 0.1, 0.9), axis=(1, 2, 2)),
    "translational": lambda *ends: sr.Translational("j", *ends, point=(0.3, 0.1, 0.9), axis=(1, 2, 2)),
    "cylindrical": lambda *ends: sr.Cylindrical("j", *ends, point=(0.3, 0.1, 0.9), axis=(1, 2, 2)),
    "planar": lambda *ends: sr.Planar("j", *ends, point=(0.3, 0.1, 0.9), axis=(1, 2, 2)),
    "cartesian": lambda *ends: sr.Cartesian("j", *ends, point=(0.3, 0.1, 0.9), axis=(1, 2, 2)),
    "universal": lambda *ends: sr.Universal(
        "j", *ends, point=(0.3, 0.1, 0.9), axis_i=(1, 0, 0), axis_j=(0, 0.6, 0.8)
    ),
    "spherical": lambda *ends: sr.Spherical("j", *ends, point=(0.3, 0.1, 0.9)),
    "on a line": lambda *ends: sr.PointOnLine("j", *ends, point=(0.3, 0.1, 0.9), axis=(1, 2, 2)),
    "on a plane": lambda *ends: sr.PointOnPlane("j", *ends, point=(0.3, 0.1, 0.9), axis=(1, 2, 2)),
    "fixed": lambda *ends: sr.Fixed("j", *ends, point=(0.3, 0.1, 0.9)),
}


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo leaves a log where it is run."""
    monkeypatch.chdir(tmp_path)


def body(name: str, position: Any, turn: Any = (0.9, 0.1, -0.2, 0.3)) -> sr.Body:
    p = np.array(turn) / np.linalg.norm(turn)
    inertia = ((0.3, 0.01, 0.02), (0.01, 0.4, 0.03), (0.02, 0.03, 0.5))
    return sr.Body(
        name, mass=2, inertia=inertia, position=position, orientation=p, center_of_mass=(0.1, 0.2, 0.3)
    )


def pendulum_with(joint: Any, *forces: Any, outward: bool = True) -> sr.Model:
    """A hinged body, and another one on it by a joint, from or to it."""
    a, b = body("a", (0.1, 0.2, 1.0)), body("b", (0.5, -0.2, 0.7), (0.7, 0.5, 0.1, -0.4))
    pin = sr.Revolute("pin", sr.ground, a, point=(0, 0, 1), axis=(0, 0.6, 0.8))
    ends = (a, b) if outward else (b, a)
    return sr.Model(
        "pair", [a, b], [pin, joint(*ends)], [force(a, b) for force in forces], gravity=(0, 1, -9.81)
    )


def same(model: sr.Model, path: Path, controls: dict[str, float] | None = None, gain: float = 1.0) -> None:
    """Compare the accelerations of a tree in random states with those of its file, in Sarrus and in MuJoCo.

    ``gain`` is the ratio of states to activations.
    """
    found = sr.load_mjcf(path, keep_fixed=True, controls=controls)
    system, other = sr.System(model), sr.System(found)
    space, rng = sr.JointSpace(other), np.random.default_rng(5)
    places = np.concatenate([np.r_[other.coordinates_of(name)] for name in system.bodies])
    for _ in range(3):
        theta = space.zero() + 0.3 * rng.uniform(-1, 1, space.width)
        q = space.q(theta)
        v = space.T(theta) @ rng.uniform(0.5, 2, space.freedoms)
        own = system.q0.copy(), np.zeros(system.nq)
        own[0][: len(places)], own[1][: len(places)] = q[places], v[places]
        for (place, *_), (there, *_) in zip(system.states.values(), other.states.values(), strict=True):
            v[there] = rng.uniform(-1, 1)
            own[1][place] = gain * v[there]
        assert abs(system.Phi(own[0])).max() < 1e-13
        assert abs(system.Phi_q(own[0]) @ own[1]).max() < 1e-12
        expected = accelerations(other, q, v)
        largest = max(abs(one).max() for one in expected.values())
        for name, one in accelerations(system, *own).items():
            np.testing.assert_allclose(one, expected[name], rtol=0, atol=1e-9 * largest, err_msg=name)
    compare_accelerations(path, controls)


@pytest.mark.parametrize("kind", JOINTS)
@pytest.mark.parametrize("outward", [True, False])
def test_a_tree_in_mjcf(kind: str, outward: bool, tmp_path: Path) -> None:
    model = pendulum_with(JOINTS[kind], outward=outward)
    sr.export(model, tmp_path / "model.xml")
    same(model, tmp_path / "model.xml")


PLACE = {"point": (0.3, 0.1, 0.9), "axis": (1, 2, 2)}
BACK = {"point": (0.3, 0.1, 0.9), "axis": (-1, -2, -2)}


def framed(a: sr.Body, b: sr.Body) -> dict[str, sr.Frame]:
    """The place as a frame on each body, the second 0.1 m further along the axis."""
    point, axis = np.array(PLACE["point"]), np.array(PLACE["axis"]) / 3
    places = (
        sr.Frame(sr.Point(a, point, "global"), z=axis),
        sr.Frame(sr.Point(b, point + 0.1 * axis, "global"), z=axis),
    )
    return dict(zip(("frame_i", "frame_j"), places, strict=True))


FORCES: dict[str, Any] = {
    "spring": ("revolute", lambda a, b: sr.RSDA("f", a, b, **PLACE, k=30, c=2, angle=0.4)),
    "spring from b to a": ("revolute", lambda a, b: sr.RSDA("f", b, a, **PLACE, k=30, c=2, angle=0.4)),
    "spring with the opposite axis": (
        "revolute",
        lambda a, b: sr.RSDA("f", a, b, **BACK, k=30, c=2, angle=0.4),
    ),
    "spring along": (
        "translational",
        lambda a, b: sr.Bushing(
            "f", **framed(a, b), stiffness=(0, 0, 30, 0, 0, 0), damping=(0, 0, 2, 0, 0, 0)
        ),
    ),
    "friction": ("revolute", lambda a, b: sr.AngleFriction("f", a, b, **PLACE, load=3, mu=0.2, radius=0.5)),
    "friction along": (
        "translational",
        lambda a, b: sr.DisplacementFriction("f", a, b, **PLACE, load=3, mu=0.2),
    ),
    "inertia": ("revolute", lambda a, b: sr.AngleInertia("f", a, b, **PLACE, inertia=0.7)),
    "spring of a ball": (
        "spherical",
        lambda a, b: sr.SphericalSpring("f", a, b, point=PLACE["point"], k=30, c=2),
    ),
    "inertia of a ball": ("spherical", lambda a, b: sr.SphericalInertia("f", a, b, inertia=0.7)),
    "inertia along": ("translational", lambda a, b: sr.DisplacementInertia("f", a, b, **PLACE, inertia=0.7)),
}


@pytest.mark.parametrize("case", FORCES)
@pytest.mark.parametrize("outward", [True, False])
def test_forces_of_joints_in_mjcf(case: str, outward: bool, tmp_path: Path) -> None:
    kind, force = FORCES[case]
    model = pendulum_with(JOINTS[kind], force, outward=outward)
    sr.export(model, tmp_path / "model.xml")
    same(model, tmp_path / "model.xml")


SERVO = "max(min(g*min(max(u, -0.2), 1) + 2 - 3*x - 0.5*rate, 9), -0.4)"
ACTUATORS: dict[str, Any] = {
    "motor": ("revolute", "0.7*u", {}),
    "servo with limits": ("revolute", SERVO, {"g": 4.0}),
    "force": ("translational", "4*(u - x) - 2*v", {}),
    "gain by the coordinate": ("revolute", "(2 + 3*x - rate)*u", {}),
    "lag": ("revolute", "3*lag", {"rate": "(u - lag)/0.3"}),
    "integral": ("translational", "3*lag - x", {"rate": "u"}),
    "constant": ("revolute", "0.7", {}),
    "limits twice": ("revolute", "max(-0.5, min(0.5, u))*(1 + x) - rate*max(-0.5, min(0.5, u))", {}),
    "lag of an input between limits": (
        "revolute",
        "3*lag",
        {"rate": "(max(-0.5, min(0.5, u)) - lag)/0.3"},
    ),
    "lag with a gain": ("revolute", "3*lag*(1 + x) + 1", {"rate": "(2*u - lag)/0.3"}),
    "FirstOrderLag": ("revolute", "3*lag", {"gain": -2.5}),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("case", ACTUATORS)
@pytest.mark.parametrize("outward", [True, False])
def test_actuators_in_mjcf(case: str, outward: bool, tmp_path: Path) -> None:
    """With the name of the input, and its value in a keyframe; in a position in which coordinates are not zero."""
    kind, value, more = ACTUATORS[case]
    make = sr.Torque if kind == "revolute" else sr.Force
    parts = [
        lambda a, b: make(
            "f", joint="j", value=value, parameters={k: v for k, v in more.items() if k != "rate"}
        )
    ]
    controls = {"u": 0.6} if case != "constant" else {}
    if controls:
        parts.append(lambda a, b: sr.Input("u", 0.6))
    if "rate" in more:
        parts.append(lambda a, b: sr.StateVariable("lag", rate=more["rate"], initial=0.2))
    if "gain" in more:
        parts.append(
            lambda a, b: sr.FirstOrderLag("lag", input="u", time=0.3, gain=more["gain"], initial=0.2)
        )
    place = framed_joint(kind)
    model = pendulum_with(place, *parts, outward=outward)
    sr.export(model, tmp_path / "model.xml")
    gain = {"lag with a gain": 2.0, "FirstOrderLag": -2.5}.get(case, 1.0)
    same(model, tmp_path / "model.xml", controls, gain)
    key = sr.load_mjcf(tmp_path / "model.xml").keyframes
    if controls:
        assert key["start"].controls == controls
    states = [0.2 / gain] if more.keys() & {"rate", "gain"} else []
    assert [*key["start"].states.values()] == states if key else not controls


def framed_joint(kind: str) -> Any:
    """A joint whose coordinate is 0.4 in the initial position."""
    make = {"revolute": sr.Revolute, "translational": sr.Translational}[kind]

    def joint(i: sr.Body, j: sr.Body) -> sr.Joint:
        point, axis = np.array(PLACE["point"]), np.array(PLACE["axis"]) / 3
        x = np.cross(axis, (1, 0, 0)) / np.linalg.norm(np.cross(axis, (1, 0, 0)))
        turned = np.cos(0.4) * x + np.sin(0.4) * np.cross(axis, x)
        frame_i = sr.Frame(sr.Point(i, point, "global"), x=x, z=axis)
        if kind == "revolute":
            return make(
                "j", frame_i=frame_i, frame_j=sr.Frame(sr.Point(j, point, "global"), x=turned, z=axis)
            )
        return make(
            "j", frame_i=frame_i, frame_j=sr.Frame(sr.Point(j, point + 0.4 * axis, "global"), x=x, z=axis)
        )

    return joint


LAG = sr.StateVariable("q", rate="(u - q)/0.1", initial=0.2)
DOUBLE = sr.StateVariable("q", rate="(2*max(-1, min(1, u)) - u - q)/0.1", initial=0.2)
WRONG_ACTUATORS = {
    **{
        value: ([sr.Torque("p", joint="j", value=value), sr.Input("u")], words)
        for value, words in {
            "max(-1, min(1, u)) + 2*u": "u between different limits",
            "u + max(-1, min(1, u))": "u between different limits",
            "u + 1000*max(0, x - 4)": "not linear",
            "u + 5*step(x, 10, 0, 11, 1)": "not linear",
            "min(u, 20) + 0*max(0, x - 10)": "not linear",
            "u + 1e-10*x*x": "not linear",
            "max(1, min(-1, u))": "moves no actuator",
        }.items()
    },
    "limits of a state": (
        [sr.Torque("p", joint="j", value="5*min(0.3, q)"), LAG, sr.Input("u")],
        "not linear",
    ),
    "limits of a rate": ([sr.Torque("p", joint="j", value="q"), DOUBLE, sr.Input("u")], "different limits"),
    "not linear": ([sr.Torque("p", joint="j", value="u^2"), sr.Input("u")], "linear"),
    "of an output": ([sr.Torque("p", joint="j", value="-pin.rate")], "depends on pin.rate"),
    "a function": ([sr.Torque("p", joint="j", value=lambda x: -x)], "function"),
    "shared input": ([*(sr.Torque(n, joint="j", value="u") for n in "qp"), sr.Input("u")], "second actuator"),
    "varying input": ([sr.Torque("f", joint="j", value="u"), sr.Input("u", "sin(t)")], "varies in time"),
    "idle input": ([sr.Input("u")], "moves no actuator"),
    "muscle": (
        [
            sr.Muscle("p", joints={"j": 0.1}, activation="q", peak_force=60.0, optimal_length=0.2),
            sr.MuscleActivation("q", input="u"),
            sr.Input("u"),
        ],
        "moves no actuator",
    ),
    "other lag": (
        [
            sr.Torque("f", joint="j", value="p"),
            sr.StateVariable("p", rate="u + 2*p", initial=0.0),
            sr.Input("u"),
        ],
        "other than a lag",
    ),
}


def ignored(error: Exception) -> list[str]:
    """The list that a message has for ``ignore=``."""
    return list(ast.literal_eval(str(error).partition("ignore=")[2].partition("]")[0] + "]"))


@pytest.mark.parametrize("case", WRONG_ACTUATORS)
def test_other_actuators_are_refused_by_name(case: str, tmp_path: Path) -> None:
    forces, words = WRONG_ACTUATORS[case]
    model = pendulum_with(JOINTS["revolute"])
    model = sr.Model("m", model.bodies, model.joints, forces)
    with pytest.raises(sr.ModelError, match=rf"the format has nothing for.*{words}.*ignore=") as told:
        sr.export(model, tmp_path / "model.xml")
    sr.export(model, tmp_path / "model.xml", ignore=ignored(told.value))


def test_other_formats_have_no_actuators(tmp_path: Path) -> None:
    model = pendulum_with(
        JOINTS["revolute"], lambda a, b: sr.Torque("f", joint="j", value="u"), lambda a, b: sr.Input("u")
    )
    for ending in ("urdf", "sdf"):
        with pytest.raises(sr.ModelError, match=r"no actuators \(f, u\)\.") as told:
            sr.export(model, tmp_path / f"model.{ending}")
        assert ignored(told.value) == ["f", "u"]
        sr.export(model, tmp_path / f"model.{ending}", ignore=["f", "u"])


OTHERS: dict[str, Any] = {
    "spring between points": lambda a, b: sr.TSDA(
        "f", a.point(0.1, 0, 0), b.point(0, 0.2, 0), k=30, c=2, length=0.3
    ),
    "force at a point": lambda a, b: sr.PointForce("f", b.point(0, 0.2, 0), (1, 2, 3)),
}


@pytest.mark.parametrize("case", OTHERS)
def test_other_forces_in_mjcf(case: str, tmp_path: Path) -> None:
    """Against MuJoCo at the start: no import has them all."""
    model = pendulum_with(JOINTS["revolute"], OTHERS[case])
    model = sr.Model(
        "m", model.bodies, model.joints, model.forces, model.gravity, rates={"pin": 0.7, "j": -1.2}
    )
    sr.export(model, tmp_path / "model.xml")
    check_start(model, tmp_path / "model.xml", 1e-9)


def test_a_constant_force_is_read_again(tmp_path: Path) -> None:
    model = pendulum_with(JOINTS["revolute"], OTHERS["force at a point"])
    sr.export(model, tmp_path / "model.xml")
    check_start(sr.load(tmp_path / "model.xml"), tmp_path / "model.xml", 1e-9)
    (force,) = (one for one in sr.load(tmp_path / "model.xml").forces if isinstance(one, sr.PointForce))
    assert (force.force, force.parameters, force.factor) == ((1, 2, 3), {"offset": 1.0}, "offset")


def check_start(model: sr.Model, path: Path, tolerance: float) -> None:
    """Compare the accelerations at the start with MuJoCo's."""
    system = sr.System(model)
    start = sr.assemble(system)
    found, compiled = accelerations(system, start.q, start.v), mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(compiled)
    if compiled.nkey:
        mujoco.mj_resetDataKeyframe(compiled, data, 0)
    mujoco.mj_forward(compiled, data)
    if compiled.neq:
        data.qacc[:] = rigid(compiled, data)
    mujoco.mj_rnePostConstraint(compiled, data)
    for name, acceleration in found.items():
        one, k = np.zeros(6), compiled.body(name).id
        mujoco.mj_objectAcceleration(compiled, data, mujoco.mjtObj.mjOBJ_XBODY, k, one, 0)
        expected = [*(one[3:] + compiled.opt.gravity), *one[:3]]
        np.testing.assert_allclose(acceleration, expected, atol=tolerance * max(1, abs(acceleration).max()))


def rigid(compiled: Any, data: Any) -> Any:
    """Accelerations at rest with equalities that are not elastic: M a + Jᵀλ = f, J a = 0 with MuJoCo's M, J and f."""
    assert not np.any(data.qvel)
    M, J = mass_matrix(compiled, data), data.efc_J.reshape(-1, compiled.nv)
    assert len(J) >= compiled.neq
    matrix = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    right = np.concatenate([data.qfrc_smooth, np.zeros(len(J))])
    return np.linalg.lstsq(matrix, right, rcond=None)[0][: compiled.nv]


def loop(closing: Any) -> sr.Model:
    """A four-bar linkage whose coupler and rocker are connected by a joint."""
    bars = [
        body(name, at)
        for name, at in (("crank", (0, 0, 0.5)), ("coupler", (0.7, 0, 1.1)), ("rocker", (1.5, 0, 0.6)))
    ]
    crank, coupler, rocker = bars
    joints = [
        sr.Revolute("a", sr.ground, crank, point=(0, 0, 0), axis=(0, 1, 0)),
        sr.Revolute("b", crank, coupler, point=(0, 0, 1), axis=(0, 1, 0)),
        sr.Revolute("c", sr.ground, rocker, point=(1.5, 0, 0), axis=(0, 1, 0)),
        closing(coupler, rocker),
    ]
    return sr.Model("loop", bars, joints, gravity=(1, 0, -9.81))


LOOPS: dict[str, Any] = {
    "spherical": lambda i, j: sr.Spherical("d", i, j, point=(1.5, 0, 1.2)),
    "revolute": lambda i, j: sr.Revolute("d", i, j, point=(1.5, 0, 1.2), axis=(0, 1, 0)),
    "rod": lambda i, j: sr.Distance("d", i.point(0.3, 0, 0), j.point(0, 0, 0.2)),
    "gear": lambda i, j: sr.Gear("d", "a", "c", -2),
}


@pytest.mark.parametrize("kind", LOOPS)
def test_loops_in_mjcf(kind: str, tmp_path: Path) -> None:
    """At rest, as MuJoCo's equalities leave out J̇ v."""
    model = loop(LOOPS[kind])
    sr.export(model, tmp_path / "model.xml")
    check_start(model, tmp_path / "model.xml", 1e-8)


def test_a_screw_in_mjcf(tmp_path: Path) -> None:
    nut = body("nut", (0.2, 0, 0))
    model = sr.Model(
        "m",
        [nut],
        [sr.Screw("s", sr.ground, nut, point=(0, 0, 0), axis=(0, 0, 1), pitch=0.5)],
        gravity=(0, 0, -9.81),
    )
    sr.export(model, tmp_path / "model.xml")
    check_start(model, tmp_path / "model.xml", 1e-8)


def test_shipped_mechanisms_move_alike_in_mujoco(tmp_path: Path) -> None:
    """The slider-crank, with its initial velocities, over a tenth of a second."""
    model = sr.load("slider_crank")
    sr.export(model, tmp_path / "model.xml")
    compiled = mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    data = mujoco.MjData(compiled)
    mujoco.mj_resetDataKeyframe(compiled, data, 0)
    for _ in range(100):
        mujoco.mj_step(compiled, data)
    run = sr.simulate(sr.System(model), until=0.1)
    for name in ("slider", "rod", "crank"):
        np.testing.assert_allclose(data.body(name).xpos, run[name].position[-1], atol=2e-3)


def test_massless_frames_are_joints_of_one_body(tmp_path: Path) -> None:
    """Two hinges with dampers are two joints and a frame in Sarrus, and two joints of a body in MJCF."""
    path = tmp_path / "given.xml"
    hinges = '<joint name="x" axis="1 0 0" damping="0.3"/>'
    hinges += (
        '<joint name="y" axis="0.3 0.8 0" pos="0 0 0.1" damping="0.2"/><geom type="box" size="0.1 0.2 0.3"/>'
    )
    path.write_text(f'<mujoco><worldbody><body name="b">{hinges}</body></worldbody></mujoco>')
    model = sr.load_mjcf(path)
    assert len(model.bodies) == 2
    sr.export(model, tmp_path / "model.xml")
    compare_accelerations(tmp_path / "model.xml")
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml")).nbody == 2


WRONG: dict[str, Any] = {
    "joint": lambda a, b: {"joints": [sr.ParallelAxes("p", a, b, axis=(0, 0, 1))]},
    "loop": lambda a, b: {"joints": [sr.PointOnLine("p", a, b, point=(0, 0, 0), axis=(0, 0, 1))]},
    "coupler": lambda a, b: {"joints": [sr.Coupler("p", "pin", "j.angle_j", 2.0)]},
    "force": lambda a, b: {"forces": [sr.ViscousDrag("p", b.point(0, 0, 0), c=1.0)]},
    "nonlinear spring": lambda a, b: {"forces": [sr.RSDA("p", sr.ground, a, **PIN, k="10 + x")]},
    "spring across": lambda a, b: {"forces": [sr.RSDA("p", a, b, point=(0, 0, 1), axis=(0, 0, 1), k=10)]},
    "muscle": lambda a, b: {
        "forces": [sr.Muscle("p", joints={"pin": 0.1}, activation=0.4, peak_force=60.0, optimal_length=0.2)]
    },
    "drag": lambda a, b: {
        "forces": [sr.EllipsoidDrag("p", b.frame((0, 0, 0)), (0.1, 0.1, 0.2), density=1.2)]
    },
    "tendon": lambda a, b: {
        "forces": [
            sr.Tendon(
                "p",
                [sr.ground.point(0, 0, 2), b.point(0, 0, 0)],
                around=[sr.Wrap(a.point(0, 0, 0), 0.1)],
                value="-3*x",
            )
        ]
    },
}
PIN = {"point": (0, 0, 1), "axis": (0, 0.6, 0.8)}


@pytest.mark.parametrize("case", WRONG)
def test_what_the_format_cannot_have_is_refused_by_name(case: str, tmp_path: Path) -> None:
    model = pendulum_with(JOINTS["universal"])
    more = {"joints": [], "forces": []} | WRONG[case](*model.bodies)
    model = sr.Model("m", model.bodies, [*model.joints, *more["joints"]], more["forces"])
    with pytest.raises(sr.ModelError, match=r"p: the format has nothing for.*ignore=\['p'\]"):
        sr.export(model, tmp_path / "model.xml")
    sr.export(model, tmp_path / "model.xml", ignore=["p"])


DRAGS = [lambda a, b, n=n: sr.ViscousDrag(n, b.point(0, 0, 0), c=1.0) for n in "dcef"]
MANY: dict[str, Any] = {
    "forces": ("xml", [*DRAGS, lambda a, b: sr.Torque("t", joint="pin", value="x^2")], "dceft"),
    "a joint and what drives it": (
        "sdf",
        [
            lambda a, b: sr.Torque("t", joint="j.angle", value="-3*x"),
            lambda a, b: sr.PointForce("p", b.point(0, 0, 0), force=(1, 0, 0)),
        ],
        "jtp",
    ),
}


@pytest.mark.filterwarnings("ignore:b.* no joint:sarrus.SarrusWarning")
@pytest.mark.parametrize("case", MANY)
def test_everything_that_a_format_lacks_is_in_one_message(case: str, tmp_path: Path) -> None:
    ending, forces, names = MANY[case]
    one = pendulum_with(JOINTS["cylindrical"], *forces)
    model = sr.Model("m", one.bodies, one.joints, one.forces, rates={"j.angle": 1.0} if "j" in names else {})
    with pytest.raises(sr.ModelError, match='model "m": the format has') as told:
        sr.export(model, tmp_path / f"model.{ending}")
    assert sorted(ignored(told.value)) == sorted(names)
    sr.export(model, tmp_path / f"model.{ending}", ignore=ignored(told.value))


INERTIAS = {
    "line": ('ixx="0.01" iyy="0.01" izz="0.01" ixy="0.01" ixz="0.01" iyz="0.01"', "positive eigenvalues"),
    "triangle": ('ixx="0.01" iyy="0.01" izz="0.03" ixy="0" ixz="0" iyz="0"', "A \\+ B >= C"),
}


@pytest.mark.parametrize("case", INERTIAS)
def test_inertias_that_mujoco_does_not_read_are_named(case: str, tmp_path: Path) -> None:
    """Some grippers have the same number in all places of an inertia, which is that of a line."""
    numbers, reason = INERTIAS[case]
    link = f'<link name="rod"><inertial><mass value="1"/><inertia {numbers}/></inertial></link>'
    joint = '<joint name="j" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="1 0 0"/></joint>'
    (tmp_path / "given.urdf").write_text(f'<robot name="m"><link name="base"/>{link}{joint}</robot>')
    model = sr.load_urdf(tmp_path / "given.urdf", inertia="given")
    with pytest.warns(sr.SarrusWarning, match="m: MuJoCo reads no file with a principal moment .* as of rod"):
        sr.export(model, tmp_path / "model.xml")
    with pytest.raises(ValueError, match=reason):
        mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    sr.export(model, tmp_path / "model.sdf")


def test_what_depends_on_a_part_that_is_ignored_is_named(tmp_path: Path) -> None:
    forces = [lambda a, b: sr.Torque("t", joint="j", value="u"), lambda a, b: sr.Input("u")]
    model = pendulum_with(JOINTS["revolute"], *forces)
    with pytest.raises(sr.ModelError, match="t: the format has nothing for a part that depends on") as told:
        sr.export(model, tmp_path / "model.xml", ignore=["u"])
    assert ignored(told.value) == ["u", "t"]


def test_misuse_is_refused(tmp_path: Path) -> None:
    model = pendulum_with(JOINTS["revolute"])
    with pytest.raises(sr.ModelError, match="must end in"):
        sr.export(model, tmp_path / "model.stl")
    with pytest.raises(sr.ModelError, match="no such part"):
        sr.export(model, tmp_path / "model.xml", ignore=["q"])


def test_saving_and_the_command_line_write_the_same_file(tmp_path: Path) -> None:
    model = sr.load("slider_crank")
    model.save(tmp_path / "saved.xml")
    assert main(["convert", "slider_crank", str(tmp_path / "converted.xml"), "--ignore", "spring"]) == 0
    assert main(["convert", "slider_crank", str(tmp_path / "exported.xml")]) == 0
    saved, exported, converted = (
        (tmp_path / f"{name}.xml").read_text() for name in ("saved", "exported", "converted")
    )
    assert saved == exported
    assert "spatial" in saved
    assert "spatial" not in converted


SIMPLE = ("revolute", "translational", "universal", "fixed")


@pytest.mark.parametrize("outward", [True, False])
@pytest.mark.parametrize("kind", JOINTS)
@pytest.mark.parametrize("ending", ["urdf", "sdf"])
def test_trees_in_other_formats(ending: str, kind: str, outward: bool, tmp_path: Path) -> None:
    """The mass matrix and the weights are those of the MJCF, in random positions."""
    damper = [lambda a, b: sr.RSDA("f", sr.ground, a, **PIN, k=0, c=2)]
    model = pendulum_with(JOINTS[kind], *damper, outward=outward)
    if ending == "sdf" and kind not in (*SIMPLE, "spherical"):
        with pytest.raises(
            sr.ModelError, match="j: the format has no joint with these motions, nor massless links"
        ):
            sr.export(model, tmp_path / "model.sdf")
        return
    sr.export(model, tmp_path / "model.xml")
    sr.export(model, tmp_path / f"model.{ending}")
    options = {"gravity": model.gravity}
    found, expected = sr.load(tmp_path / f"model.{ending}", **options), sr.load(tmp_path / "model.xml")
    spaces = [sr.JointSpace(sr.System(robot)) for robot in (found, expected)]
    if "ball" in kind or kind in (
        "spherical",
        "on a line",
        "on a plane",
    ):  # three rotations have other coordinates
        assert len({space.freedoms for space in spaces}) == 1
        return
    words = [[motion.name for motion in space.motions] for space in spaces]
    values = np.random.default_rng(4).uniform(-1, 1, len(words[0]))
    pairs = list(zip(spaces, words, strict=True))
    thetas = [space.pack(dict(zip(names, values, strict=True))) for space, names in pairs]
    orders = [[space.velocities_of[name].start for name in names] for space, names in pairs]
    M = [
        space.M(theta)[np.ix_(order, order)]
        for space, theta, order in zip(spaces, thetas, orders, strict=True)
    ]
    np.testing.assert_allclose(M[0], M[1], atol=1e-12)
    loads = []
    for space, theta, order in zip(spaces, thetas, orders, strict=True):
        T, rates = space.T(theta), np.zeros(space.freedoms)
        rates[order] = values
        loads.append((T.T @ space.system.Q(space.q(theta), T @ rates, 0.0))[order])
    np.testing.assert_allclose(loads[0], loads[1], atol=1e-11)


@pytest.mark.parametrize("kind", ["spherical", "revolute"])
def test_loops_in_sdf(kind: str, tmp_path: Path) -> None:
    model = loop(LOOPS[kind])
    sr.export(model, tmp_path / "model.sdf")
    found, expected = (sr.System(one) for one in (sr.load(tmp_path / "model.sdf"), model))
    assert abs(found.Phi(found.q0)).max() < 1e-12
    rest = 0 * found.q0
    accelerated = accelerations(found, found.q0, rest)
    for name, one in accelerations(expected, expected.q0, 0 * expected.q0).items():
        np.testing.assert_allclose(accelerated[name], one, atol=1e-9 * abs(one).max())


def test_what_other_formats_do_not_have_is_refused(tmp_path: Path) -> None:
    sprung = pendulum_with(JOINTS["revolute"], OTHERS["spring between points"])
    one = body("a", (0, 0, 0))
    lines = [sr.PointOnLine(n, sr.ground, one, point=(x, 0, 0), axis=(0, 1, 0)) for x, n in enumerate("cd")]
    looped = sr.Model("m", [one], lines)
    with pytest.raises(sr.ModelError, match="the format has nothing for a PointOnLine that closes a loop"):
        sr.export(looped, tmp_path / "model.urdf")
    for ending in ("urdf", "sdf"):
        with pytest.raises(sr.ModelError, match="f: the format has no springs between points"):
            sr.export(sprung, tmp_path / f"model.{ending}")
    bent = pendulum_with(JOINTS["revolute"], FORCES["spring"][1])
    with pytest.raises(
        sr.ModelError, match=r"f: the format has no stiffness of joints.*\['f'\], or export it as .xml"
    ):
        sr.export(bent, tmp_path / "model.urdf")
    moving = sr.Model("m", bent.bodies, bent.joints, rates={"pin": 1.0, "j": 0.0})
    with pytest.warns(sr.SarrusWarning, match="no initial velocities"):
        sr.export(moving, tmp_path / "model.urdf")


@pytest.mark.parametrize("kind", ["spherical", "revolute", "translational", "fixed", "universal", "planar"])
def test_loops_beside_a_urdf(kind: str, tmp_path: Path) -> None:
    """Their frames are on links, whose origins are at the joints; loading closes them where q0 is not zero, too."""
    model = loop(lambda i, j: JOINTS[kind](i, j))
    path = tmp_path / "loop.urdf"
    with pytest.warns(sr.SarrusWarning, match="the format has no loops; they are in") as told:
        sr.export(model, path)
    loops = tmp_path / "loop.loops.yaml"
    assert f"loops={str(loops)!r}" in str(told[0].message)
    found = sr.load_urdf(path, loops=loops, gravity=model.gravity)
    systems = [sr.System(model), sr.System(found)]
    if kind != "planar":
        sr.export(model, tmp_path / "loop.sdf")
        systems.append(sr.System(sr.load_sdf(tmp_path / "loop.sdf")))
    of = [positions_and_accelerations(system) for system in systems]
    for other in of[1:]:
        for name, (place, acceleration) in of[0].items():
            np.testing.assert_allclose(other[name][0], place, atol=1e-12)
            np.testing.assert_allclose(
                other[name][1], acceleration, atol=1e-8 * (1 + abs(acceleration).max())
            )


def positions_and_accelerations(system: sr.System) -> dict[str, Any]:
    """Of the centre of mass of each body, which no description moves, at the start."""
    start = sr.assemble(system)
    found = accelerations(system, start.q, start.v)
    result = {}
    for n, body in enumerate(system.model.bodies):
        center = np.array(body.mass_properties()[2])
        A = rotation_matrix(start.q[7 * n + 3 : 7 * n + 7])
        alpha = found[body.name][3:]  # at rest
        result[body.name] = (
            start.q[7 * n : 7 * n + 3] + A @ center,
            np.array([*(found[body.name][:3] + np.cross(alpha, A @ center)), *alpha]),
        )
    return result


def test_loops_of_a_urdf_move_with_their_links(tmp_path: Path) -> None:
    """Started from another angle, the loop is still that of the model."""
    model = loop(LOOPS["spherical"])
    with pytest.warns(sr.SarrusWarning, match="loops"):
        sr.export(model, tmp_path / "loop.urdf")
    found = sr.load_urdf(tmp_path / "loop.urdf", loops=tmp_path / "loop.loops.yaml", q0={"a": 0.2})
    with pytest.warns(sr.SarrusWarning, match="assembly changed"):
        start = sr.assemble(sr.System(found))
    assert start.success
    at = {name: start.q[7 * n : 7 * n + 7] for n, name in enumerate(sr.System(found).bodies)}
    tip = at["rocker"][:3] + rotation_matrix(at["rocker"][3:]) @ (0, 0, 1.2)
    assert np.linalg.norm(tip - (1.5, 0, 0)) == pytest.approx(1.2)


MESH = "v 0 0 0\nv 0.3 0 0\nv 0 0.2 0\nv 0 0 0.4\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
SHAPES = """<robot name="r"><link name="base"/><link name="a"><inertial><origin xyz="0 0 0.1"/><mass value="1"/>
  <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  <visual><origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/><geometry><mesh filename="meshes/m.obj" scale="1 2 3"/>
    </geometry>
    <material name="red"><color rgba="1 0 0 1"/></material></visual>
  <visual><geometry><box size="0.1 0.2 0.3"/></geometry></visual>
  <visual><geometry><cylinder radius="0.1" length="0.3"/></geometry></visual>
  <visual><geometry><sphere radius="0.1"/></geometry></visual></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="a"/><origin xyz="1 2 3"/></joint></robot>"""


@pytest.mark.parametrize("ending", ["xml", "sdf", "urdf"])
def test_shapes_are_exported_with_their_meshes(ending: str, tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "m.obj").write_text(MESH)
    (tmp_path / "given.urdf").write_text(SHAPES)
    model = sr.load_urdf(tmp_path / "given.urdf")
    sr.export(model, tmp_path / f"model.{ending}")
    found, expected = sr.load(tmp_path / f"model.{ending}").looks(), model.looks()
    assert len(found) == 4
    for look, other in zip(found, expected, strict=True):
        assert look[:2] == other[:2]
        np.testing.assert_allclose(look.size, other.size)
        np.testing.assert_allclose(look.pose.r, other.pose.r, atol=1e-7)
        np.testing.assert_allclose(look.pose.A, other.pose.A, atol=1e-7)
        assert look.file == other.file
    assert found[0].color == "#ff0000"


def test_shapes_of_the_ground_are_exported(tmp_path: Path) -> None:
    """In SDF as those of a link that is fixed to the world, whose name is free."""
    text = (
        SHAPES.replace(' scale="1 2 3"', "")
        .replace('"a"', '"shapes"')
        .replace('filename="meshes/', 'filename="')
    )
    ground = '<link name="base"><visual><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><geometry><box size="1 2 3"/></geometry>'
    text = text.replace('<link name="base"/>', f"{ground}</visual></link>")
    (tmp_path / "m.obj").write_text(MESH)
    (tmp_path / "given.urdf").write_text(text)
    model = sr.load_urdf(tmp_path / "given.urdf")
    for ending in ("xml", "sdf", "urdf"):
        sr.export(model, tmp_path / f"model.{ending}")
        again = sr.load(tmp_path / f"model.{ending}")
        assert [body.name for body in again.bodies] == ["shapes"]
        (look,) = (look for look in again.looks() if look.body == "ground")
        assert (look.shape, look.size) == ("box", (1, 2, 3))
        np.testing.assert_allclose(look.pose.r, (1, 2, 3), atol=1e-9)
        np.testing.assert_allclose(look.pose.A, model.looks()[0].pose.A, atol=1e-9)


@pytest.mark.parametrize("pitch", [0.3, np.pi / 2, 1.5707963, np.pi / 2 - 1e-11, -np.pi / 2 + 1e-13])
def test_angles_of_a_urdf_are_exact_near_a_pitch_of_a_right_angle(pitch: float) -> None:
    """Rounded numbers of files, as 1.5707963, leave roll and yaw with few digits, but not the rotation."""
    for roll, yaw in np.random.default_rng(1).uniform(-3, 3, (20, 2)):
        A = Rotation.from_euler("xyz", (roll, pitch, yaw)).as_matrix()
        again = Rotation.from_euler("xyz", roll_pitch_yaw(A)).as_matrix()
        np.testing.assert_allclose(again, A, rtol=0, atol=1e-15)


def test_shapes_of_no_size_are_left_out(tmp_path: Path) -> None:
    """MuJoCo reads no file with one; some robots have such a box at their base."""
    shape = '<visual><geometry><box size="0 0 0"/></geometry></visual>'
    text = SHAPES.replace('<link name="base"/>', f'<link name="base">{shape}</link>')
    (tmp_path / "m.obj").write_text(MESH)
    (tmp_path / "given.urdf").write_text(text)
    model = sr.load_urdf(tmp_path / "given.urdf", meshes="ignore")
    with pytest.warns(sr.SarrusWarning, match="r: shapes are not in the file, box.*size is zero"):
        sr.export(model, tmp_path / "model.xml")
    assert len(sr.load(tmp_path / "model.xml").looks()) == len(model.looks()) - 1


def test_shapes_without_a_place_are_named(tmp_path: Path) -> None:
    (tmp_path / "given.urdf").write_text(SHAPES)
    model = sr.load_urdf(tmp_path / "given.urdf")
    with pytest.warns(sr.SarrusWarning, match="r: shapes are not in the file, m.obj"):
        sr.export(model, tmp_path / "model.xml")
    assert len(sr.load(tmp_path / "model.xml").looks()) == 3


def test_capsules_of_a_urdf_are_cylinders_with_two_spheres(tmp_path: Path) -> None:
    """A URDF has no capsule; the ends are on the axis of the shape, half of its length from its centre."""
    text = SHAPES.replace('<box size="0.1 0.2 0.3"/>', '<capsule radius="0.1" length="0.4"/>').replace(
        "<visual><geometry><capsule",
        '<visual><origin xyz="1 2 3" rpy="0 1.5707963267948966 0"/><geometry><capsule',
    )
    mesh = text[text.index('<visual><origin xyz="0.1') : text.index('<visual><origin xyz="1 2')]
    (tmp_path / "given.urdf").write_text(text.replace(mesh, ""))
    model = sr.load_urdf(tmp_path / "given.urdf")
    sr.export(model, tmp_path / "model.urdf")
    assert "capsule" not in (tmp_path / "model.urdf").read_text()
    looks = sr.load_urdf(tmp_path / "model.urdf").looks()
    assert [look.shape for look in looks] == ["cylinder", "sphere", "sphere", "cylinder", "sphere"]
    center, tips = looks[0].pose.r, [look.pose.r for look in looks[1:3]]
    np.testing.assert_allclose(tips, [center - (0.2, 0, 0), center + (0.2, 0, 0)], atol=1e-9)
    assert [*looks[0].size, *looks[1].size] == [0.1, 0.4, 0.1]
    sr.export(model, tmp_path / "model.sdf")
    assert "capsule" in (tmp_path / "model.sdf").read_text()
