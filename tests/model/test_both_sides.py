"""Left and right sides: parts of one side with their mirror images about the plane y = 0."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.outputs.every_kind import system as every_kind

import sarrus as sr
from sarrus.model.expansion.blueprint import blueprint
from sarrus.model.file.save import first_difference
from sarrus.model.mirror_image import Image
from sarrus.model.written import written_numbers

MIRRORED = np.array([1, -1, 1, 1, -1, 1, -1])  # coordinates r and p of a body
ODD = {"lift", "course"}  # parts of the model with every kind that have no mirror image
AXLE = """\
name: axle
gravity: [0, 0, -9.81]
hardpoints:
  unit: mm
  lower_front: [-106, 240, 65.4]
  lower_rear: [116, 240, 25.6]
  lower_ball: [-12.5, 562, -60]
  upper_front: [-184, 240, 206.3]
  upper_rear: [167.4, 240, 135]
  upper_ball: [28.3, 538, 80]
  damper_eye: [-7.8, 431, 30]
  damper_top: [52.3, 263, 362]
  rod_outer: [58, 526.8, 11.8]
  rod_inner: [75, 230.2, 108.9]
  wheel: [0, 650, 0]
bodies:
  chassis: {mass: 800, inertia: [200, 800, 900], position: [0.5, 0, 0.3]}
  rack: {mass: 5, inertia: [1, 1, 1], position: [rod_inner.x, 0, rod_inner.z]}
joints:
  guide: {type: translational, bodies: [chassis, rack], point: [0, 0, 0], axis: [0, 1, 0]}
left:
  bodies:
    lower: {mass: 3, inertia: {xx: 0.1, yy: 0.1, zz: 0.1, xy: 0.01}, position: lower_ball, center_of_mass: [0, -0.1, 0]}
    upper: {mass: 2, inertia: [0.1, 0.1, 0.1], position: upper_ball, orientation: {axis: [1, 2, 3], angle: 0.3}}
    knuckle: {mass: 20, inertia: [0.5, 0.8, 0.5], position: wheel}
  joints:
    lower_arm: {type: revolute, bodies: [chassis, lower], point: lower_front, axis: [lower_front, lower_rear]}
    upper_arm: {type: revolute, bodies: [chassis, upper], point: upper_front, axis: [upper_front, upper_rear]}
    lower_joint: {type: spherical, bodies: [lower, knuckle], point: lower_ball}
    upper_joint: {type: spherical, bodies: [upper, knuckle], point: upper_ball}
    tie_rod: {type: distance, points: [rack.rod_inner, knuckle.rod_outer]}
  forces:
    damper: {type: tsda, points: [chassis.damper_top, lower.damper_eye], k: 90 kN/m, c: 3000, length: 360 mm}
    tyre: {type: tyre, point: knuckle.wheel, k: 200 kN/m, c: 100, radius: 0.3, road: -0.3}
    stop: {type: torque, joint: lower_arm, value: "-2*lower_arm.angle - 3*damper.rate"}
"""


def loaded(folder: Path, text: str = AXLE) -> sr.Model:
    (folder / "axle.yaml").write_text(text, encoding="utf-8")
    return sr.load(folder / "axle.yaml")


def test_a_double_wishbone_axle_is_symmetric(tmp_path: Path) -> None:
    model = loaded(tmp_path)
    assert len(model.bodies) == 8
    assert [one.name for one in model.joints][1::5] == ["lower_arm_left", "lower_arm_right"]
    run = sr.simulate(sr.System(model), until=0.1, store="steps")
    for name in ("lower", "upper", "knuckle"):
        left, right = run[f"{name}_left"], run[f"{name}_right"]
        assert right.position == pytest.approx(left.position * [1, -1, 1], abs=1e-14)
        assert right.euler == pytest.approx(left.euler * [1, -1, 1, -1], abs=1e-14)
    assert run["lower_arm_right.angle"] == pytest.approx(run["lower_arm_left.angle"], abs=1e-13)
    assert run["lower_arm_left.angle"][-1] > 0.01
    names = ["lower_ball", "rod_inner", "lower_rear"]
    left, right = (sr.sensitivity(run, f"knuckle_{side}.y", names).matrix for side in ("left", "right"))
    assert right == pytest.approx(-left, abs=1e-11)
    assert np.abs(left).max() > 0.01


def test_a_coordinate_moves_both_sides(tmp_path: Path) -> None:
    model = loaded(tmp_path)
    before, after = (written_numbers(one) for one in (model, model.with_parameters({"lower_ball.y": 0.572})))
    changed = {name: after[name] - before[name] for name in after if after[name] != before[name]}
    names = ("lower_{}.position.y", "lower_joint_{}.point.y")
    expected = {
        name.format(side): sign * 0.01 for name in names for side, sign in (("left", 1), ("right", -1))
    }
    assert changed == pytest.approx(expected, abs=1e-12)


def test_the_file_and_python_give_the_same_axle(tmp_path: Path) -> None:
    model = loaded(tmp_path)
    own = {
        section: [one for one in parts if one.name.endswith("_left")]
        for section, parts in model.sections().items()
    }
    parts = [one for section in own.values() for one in section]
    image = Image({one.name: one.name.replace("left", "right") for one in parts})
    image.add(parts)
    others = [image(one) for one in parts]
    known = {one.name: one for section in model.sections().values() for one in section}
    shown = {one.name: repr(known[one.name]) for one in others}
    assert shown == {one.name: repr(one) for one in others}
    replace(model, origin=None).save(tmp_path / "whole.yaml")
    assert first_difference(model, sr.load(tmp_path / "whole.yaml")) == ""
    model.with_parameters({"lower_ball.y": 0.572}).save(tmp_path / "moved.yaml")
    assert (tmp_path / "moved.yaml").read_text(encoding="utf-8") == AXLE.replace("562", "572")


def test_sides_of_included_files(tmp_path: Path) -> None:
    (tmp_path / "side.yaml").write_text(
        AXLE.replace("left:", "right:").replace("240,", "-240,"), encoding="utf-8"
    )
    text = "name: car\ninclude:\n- {file: side.yaml, prefix: front_}\n- {file: side.yaml, prefix: rear_}\n"
    (tmp_path / "car.yaml").write_text(text, encoding="utf-8")
    model = sr.load(tmp_path / "car.yaml")
    names = [body.name for body in model.bodies]
    assert len(names) == 16
    assert {"front_knuckle_left", "rear_knuckle_right", "rear_rack"} <= {*names}
    joints = {joint.name: joint for joint in model.joints}
    left: Any = joints["rear_lower_arm_left"]
    right: Any = joints["rear_lower_arm_right"]
    assert left.body_j.name == "rear_lower_left"
    assert right.point[1] == -0.24 == -left.point[1]


@dataclass(frozen=True)
class Sides:
    """Every part that can be mirrored, on both sides."""

    system: sr.System
    names: list[str]

    def state(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Mirrored positions and velocities near the initial ones; states are the same on both sides."""
        q, v = self.system.q0.copy(), self.system.v0.copy()
        for name in self.names:
            left, right = (self.system.coordinates_of(f"{name}_{side}") for side in ("left", "right"))
            assert q[right] == pytest.approx(MIRRORED * q[left], abs=1e-14)
            q[left] += 0.05 * rng.standard_normal(7)
            q[left][3:] /= np.linalg.norm(q[left][3:])
            v[left] = rng.standard_normal(7)
            v[left][3:] -= q[left][3:] * (q[left][3:] @ v[left][3:])
            q[right], v[right] = MIRRORED * q[left], MIRRORED * v[left]
        return q, v


@cache
def sides() -> Sides:
    model = every_kind().model
    parts = [one for own in model.sections().values() for one in own if one.name not in ODD]
    rows = np.random.default_rng(1).standard_normal((6, 6))
    a, b = model.bodies[:2]
    mount = {"stiffness": rows @ rows.T, "damping": 0.1 * rows @ rows.T, "preload": rows[0]}
    parts.append(
        sr.Bushing(
            "pad", frame_i=a.frame((0.1, 0.2, 0.3), z=(1, 2, 2)), frame_j=b.frame((0, 0.1, 0)), **mount
        )
    )
    tyre = {"radius": 0.6, "k": 40.0, "c_kappa": 50.0, "c_alpha": 30.0, "mu_max": 0.9}
    parts.append(sr.FialaTyre("fiala", b.point(0.1, 0.2, 0.3), axis=(0.1, 1, 0.2), road=-0.4, **tyre))
    terms = sr.load_tyre("passenger_car").coefficients
    parts.append(sr.MagicFormulaTyre("magic", b.point(0.1, 0.2, 0.3), coefficients=terms, road=-0.2))
    empty = sr.Model("both sides", [], gravity=(0.3, 0, -2.0))
    both = empty.adding(*sr.both_sides(*parts))
    return Sides(sr.System(both), [body.name for body in model.bodies])


def test_forces_and_constraints_of_every_kind_are_mirrored() -> None:
    rng = np.random.default_rng(4)
    system = sides().system
    for _ in range(3):
        q, v = sides().state(rng)
        forces = system.Q(q, v, 0.1)
        for name in sides().names:
            left, right = (forces[system.coordinates_of(f"{name}_{side}")] for side in ("left", "right"))
            assert right == pytest.approx(MIRRORED * left, rel=1e-9, abs=1e-9), name
        residuals = system.Phi(q, 0.1)
        for name, rows in system.rows.items():
            if name.endswith("_left"):
                other = residuals[system.rows[name.replace("_left", "_right")]]
                assert np.abs(other) == pytest.approx(np.abs(residuals[rows]), abs=1e-12), name


def test_the_image_of_an_image_is_the_part() -> None:
    model = every_kind().model
    parts = [one for own in model.sections().values() for one in own if one.name not in ODD]
    there = Image({one.name: f"{one.name}_image" for one in parts})
    there.add(parts)
    images = [there(one) for one in parts]
    back = Image({image.name: one.name for image, one in zip(images, parts, strict=True)})
    back.add(images)
    again = sr.Model("again", [], gravity=(0.3, 0, -2.0)).adding(*(back(one) for one in images))
    first = sr.Model("again", [], gravity=(0.3, 0, -2.0)).adding(*parts)
    one, other = (blueprint(model) for model in (first, again))
    assert other.q == pytest.approx(one.q, abs=1e-15)
    assert sr.System(again).b == pytest.approx(sr.System(first).b, abs=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("left:\n", "left: 5\nright:\n", "left must be a mapping, but is 5"),
        (
            "left:\n  bodies",
            "left:\n  body",
            'axle.yaml:22: model: left has no key "body". Did you mean "bodies"?',
        ),
        ("  rack: {", "  upper_right: {", 'body "upper": has the part "upper", but there is "upper_right"'),
        (
            "damper.rate",
            "knuckle.y",
            '"knuckle_left.y" has another value there. Write the parts of both sides',
        ),
        ("point: lower_ball}", "point: 5}", 'joint "lower_joint_left": point must be a list'),
        ("lower_arm.angle", "uper_arm.angle", "uper_arm"),
        (
            "lower_arm.angle",
            "lower_arm_right.angle",
            'reads "lower_arm_right.angle" of the other side. Write the parts of both sides',
        ),
    ],
)
def test_messages_of_files(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in AXLE
    text = AXLE.replace(old, new).replace("rack.rod", "upper_right.rod" if "rack" in old else "rack.rod")
    with pytest.raises(sr.ModelError) as error:
        sr.System(loaded(tmp_path, text))
    assert message in str(error.value)


def test_what_has_no_mirror_image() -> None:
    body = sr.Body("body", 1, (1, 1, 1), position=(0, 1, 0))
    hinge = sr.Cylindrical("hinge", sr.ground, body, (0, 1, 0), (0, 0, 1))
    lift = sr.CoordinateDriver("lift", body, "z", "t")
    turn = sr.AngleDriver("turn", "hinge", "t")
    path = sr.PointDriver("path", body.point(0, 0, 0), y=lambda t: t)
    for part, message in (
        (lift, 'lift": has no mirror image, because its class does not declare that of coordinate'),
        (turn, 'turn": has no mirror image, because "hinge" has another value there'),
        (path, 'path": y has no mirror image. Give a formula as a text'),
    ):
        with pytest.raises(sr.ModelError, match=message):
            sr.both_sides(body, hinge, part)
    with pytest.raises(sr.ModelError, match='given must be "left" or "right", but is "up"'):
        sr.both_sides(body, given="up")  # type: ignore[arg-type]


def mirrored(*parts: Any, beside: tuple[Any, ...] = ()) -> sr.Model:
    """The model of a body and other parts on both sides."""
    body = sr.Body("arm", 2, (0.1, 0.2, 0.3), position=(0.1, 0.7, 0.2))
    return sr.Model("sides", [], gravity=(0, 0, -9.81)).adding(
        *beside, *sr.both_sides(body, *(one(body) for one in parts), beside=beside)
    )


def assert_symmetric(model: sr.Model) -> None:
    """The bodies move in mirror images, and they move."""
    run = sr.simulate(sr.System(model), until=0.2, store="steps")
    left, right = run["arm_left"], run["arm_right"]
    assert right.position == pytest.approx(left.position * [1, -1, 1], abs=1e-12)
    assert right.euler == pytest.approx(left.euler * [1, -1, 1, -1], abs=1e-12)
    assert np.ptp(left.euler, axis=0).max() > 1e-3


HARDPOINTS = {"front": (0.3, 0.35, 0.1), "rear": (-0.4, 0.31, 0.25)}
ROWS = np.diag([1e3, 2e3, 3e3, 10, 20, 30]) + np.diag([300, 0, 0, 0, 4], 1) + np.diag([300, 0, 0, 0, 4], -1)


def test_a_frame_with_one_axis_of_hardpoints_is_refused() -> None:
    points = sr.Hardpoints(HARDPOINTS)

    def bushing(**axes: Any) -> Any:
        end = sr.ground.frame((0.1, 0.7, 0.2), **axes)
        return lambda arm: sr.Bushing(
            "pad", frame_i=end, frame_j=arm.frame((0, 0.1, 0)), stiffness=ROWS.tolist()
        )

    for one, other in ("zx", "xz"):
        with pytest.raises(
            sr.ModelError, match=rf"has a formula in {one}, and no {other}. Give {other}, too"
        ):
            mirrored(bushing(**{one: (points.front, points.rear)}))
    assert_symmetric(mirrored(bushing(x=(0.3, 0.6, 0.2))))
    assert_symmetric(mirrored(bushing(z=(0.3, 0.6, 0.2))))


@pytest.mark.parametrize("axes", [{"x": (0.3, 0.6, 0.2)}, {"z": (0.3, 0.6, 0.2)}, {}])
def test_angles_between_frames(axes: dict[str, Any]) -> None:
    def frames(arm: sr.Body) -> dict[str, Any]:
        return {
            "frame_i": sr.ground.frame((0.1, 0.7, 0.2), **axes),
            "frame_j": arm.frame((0, 0, 0), **axes),
        }

    model = mirrored(
        lambda arm: sr.Revolute("hinge", **frames(arm)),
        lambda arm: sr.RSDA("spring", **frames(arm), k=30, angle=0.5),
    )
    assert_symmetric(model)


RACK = sr.Body("rack", 1, (0.1, 0.1, 0.1))


def guide(axis: tuple[float, ...], kind: Any = sr.Translational) -> tuple[Any, ...]:
    return RACK, kind("guide", sr.ground, RACK, (0, 0, 0), axis)


def pin(arm: sr.Body) -> sr.Revolute:
    return sr.Revolute("pin", sr.ground, arm, (0.1, 0.2, 0.2), (0, 0, 1))


def test_what_reads_parts_in_the_middle() -> None:
    parts = pin, lambda _: sr.RackAndPinion("steer", "guide", "pin", 0.1)
    other = '"guide" has another value there'
    with pytest.raises(sr.ModelError, match=other):
        mirrored(*parts, beside=guide((0, 1, 0)))
    with pytest.raises(sr.ModelError, match=other):
        mirrored(*parts, beside=guide((1, 1e-3, 0)))
    with pytest.raises(
        sr.ModelError, match=r'reads "guide" of a part that is not given. Give the part in beside'
    ):
        mirrored(*parts)
    assert_symmetric(
        mirrored(
            *parts, beside=(*guide((1, 0, 2)), sr.PointForce("push", RACK.point(0, 0, 0), force=(3.0, 0, 0)))
        )
    )
    gear = pin, lambda _: sr.Gear("turn", "guide", "pin", 2.0)
    mirrored(*gear, beside=guide((0, 2, 0), sr.Revolute))
    with pytest.raises(sr.ModelError, match=other):
        mirrored(*gear, beside=guide((0, 0, 1), sr.Revolute))


@pytest.mark.parametrize(
    ("text", "even"),
    [
        ("-100*rack.z", True),
        ("-100*rack.y", False),
        ("pull.output", True),
        ("push.output", False),
        ("slow.output", False),
        ("spring.length", False),
        ("command", True),
    ],
)
def test_outputs_of_parts_in_the_middle(text: str, even: bool) -> None:
    beside = (
        *guide((0, 1, 0)),
        sr.Input("command", 1.0),
        sr.PID("pull", input="command - rack.x", kp=1.0),
        sr.PID("push", input="command - slow.output", kp=1.0),
        sr.FirstOrderLag("slow", input="guide.displacement", time=0.1),
        sr.TSDA("spring", sr.ground.point(0, 0.3, 0), RACK.point(0, 0, 0), k=1.0, length=0.3),
    )

    def force(arm: sr.Body) -> sr.PointForce:
        return sr.PointForce("load", arm.point(0, 0, 0), force=("0", text, "0"))

    if even:
        mirrored(force, beside=beside)
    else:
        with pytest.raises(sr.ModelError, match=r"has another value there"):
            mirrored(force, beside=beside)
        with pytest.raises(sr.ModelError, match=r"is not given"):
            mirrored(force)


def test_a_file_with_a_pinion_on_a_central_rack(tmp_path: Path) -> None:
    steer = "    steer: {type: rack_and_pinion, rack: guide, pinion: lower_arm, radius: 0.1}\n  forces:\n"
    text = AXLE.replace("  forces:\n", steer)
    with pytest.raises(sr.ModelError, match=r'joint "steer_left": .*"guide" has another value there'):
        loaded(tmp_path, text)
    assert len(loaded(tmp_path, text.replace("axis: [0, 1, 0]", "axis: [1, 0, 0]")).bodies) == 8


def test_coordinates_of_a_tendon(tmp_path: Path) -> None:
    def tendon(name: str) -> Any:
        return lambda _: sr.Tendon("cable", joints={name: 0.2}, value=20)

    def hinge(arm: sr.Body) -> sr.Cylindrical:
        return sr.Cylindrical("hinge", sr.ground, arm, (0.1, 0.3, 0.2), (1, 0.2, 0.3))

    with pytest.raises(sr.ModelError, match=r'"hinge.angle" has another value there'):
        mirrored(hinge, tendon("hinge.angle"))
    assert_symmetric(mirrored(hinge, tendon("hinge.displacement")))
    text = AXLE + "    cable: {type: tendon, joints: {lower_arm: 0.2, guide.displacement: 0}, value: 20}\n"
    model = loaded(tmp_path, text.replace(", guide.displacement: 0", ""))
    found = [one.joints for one in model.forces if isinstance(one, sr.Tendon)]
    assert found == [{"lower_arm_left": 0.2}, {"lower_arm_right": 0.2}]
    with pytest.raises(sr.ModelError, match=r'"guide.displacement" has another value there'):
        loaded(tmp_path, text)


def test_displacements_of_cylindrical_joints_are_even() -> None:
    def hinge(arm: sr.Body) -> sr.Cylindrical:
        return sr.Cylindrical("hinge", sr.ground, arm, (0.1, 0.3, 0.2), (1, 0.2, 0.3))

    assert_symmetric(mirrored(hinge, lambda _: sr.DisplacementDriver("ram", "hinge", "0.1*sin(3*t)")))
    assert_symmetric(mirrored(hinge, lambda _: sr.Force("load", joint="hinge", value="3 - x")))
    with pytest.raises(sr.ModelError, match=r'"hinge" has another value there'):
        mirrored(hinge, lambda _: sr.Torque("load", joint="hinge", value="3"))


def test_new_values_at_loading_are_those_of_with_parameters(tmp_path: Path) -> None:
    model = loaded(tmp_path)
    for new in ({"damper_left.c": 3.0}, {"damper_right.c": 4.0}, {"lower_left.mass": 5.0}):
        other = sr.load(tmp_path / "axle.yaml", parameters=new)
        assert written_numbers(other) == written_numbers(model.with_parameters(new))
        ((name, value),) = new.items()
        assert written_numbers(other)[name] == value
        twin = name.replace("left", "other").replace("right", "left").replace("other", "right")
        assert written_numbers(other)[twin] == written_numbers(model)[twin] != value


def test_a_moving_point_of_a_side(tmp_path: Path) -> None:
    text = """\
name: moving
parameters: {speed: 0.2}
hardpoints:
  ball: [0.1, 0.7, 0.2]
bodies: {}
left:
  bodies:
    arm: {mass: 2, inertia: [0.1, 0.2, 0.3], position: ball, angular_velocity: [1, 0.2, 0.3]}
  joints:
    ball_joint: {type: spherical, bodies: [ground, arm], point: [ball.x, ball.y + speed*t, "0.2 + 0.1*t"]}
"""
    model = loaded(tmp_path, text)
    assert_symmetric(model)
    assert_symmetric(model.with_parameters({"speed": 0.4}))
    path: Any = ("0.1*t", 0, 0)
    with pytest.raises(sr.ModelError, match=r'"ball": has a moving point, which both_sides cannot mirror'):
        mirrored(lambda arm: sr.Spherical("ball", sr.ground, arm, path))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("damper", "mm", 'force "mm": the name "mm" of a part is also that of a unit, which the side uses'),
        (
            "damper",
            "t",
            'force "t": the name "t" of a part is also that of a variable or function of formulas',
        ),
        ("damper:", "wheel:", 'force "wheel": the name "wheel" of a part is also that of a hardpoint'),
        (
            'knuckle_load"',
            'damper"',
            'force "load": its parameter "damper" has the name of a part. Rename the part',
        ),
    ],
)
def test_names_with_two_meanings(tmp_path: Path, old: str, new: str, message: str) -> None:
    load = '    load: {type: torque, joint: lower_arm, value: 3, parameters: {"knuckle_load": 3}}\n'
    text = (AXLE + load).replace(old, new) if "load" in old else AXLE.replace(old, new)
    with pytest.raises(sr.ModelError) as error:
        loaded(tmp_path, text)
    assert message in str(error.value)


def test_what_both_sides_does_not_take() -> None:
    body: Any
    for body, message in (
        ("arm", 'both_sides takes bodies, joints, drivers and forces, but got "arm"'),
        ([RACK], "both_sides takes bodies, joints, drivers and forces, but got a list"),
        (sr.Body("x", 1, (1, 1, 1)), 'may not have the name "x", which formulas use for something else'),
    ):
        with pytest.raises(sr.ModelError, match=message):
            sr.both_sides(body)
    load = sr.Torque("load", RACK, parameters={"rack": 3.0}, torque=("1", "0", "0"))
    with pytest.raises(
        sr.ModelError, match=r'its parameter "rack" has the name of a part. Rename one of them'
    ):
        sr.both_sides(RACK, load)
