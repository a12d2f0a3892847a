"""Hardpoints: named points of which each coordinate is one parameter, in files and in Python."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.model.expansion.blueprint import Blueprint, blueprint
from sarrus.model.file.save import first_difference
from sarrus.model.written import written_numbers

CORNER = """\
name: corner
gravity: [0, 0, -9.81]
hardpoints:
  unit: mm
  lower_front: [-106, 240, 65.4]
  lower_rear: [116, 240, 25.6]
  lower_ball: [-12.5, 562, -60]
  damper_top: [52.3, 263, 362]
  damper_eye: [-8, 431, 30]
  wheel: [0, "650 mm", "lower_ball.z/2 + 30 mm"]
bodies:
  arm: {mass: 3, inertia: [0.1, 0.1, 0.1], position: lower_front, center_of_mass: [0, 0.1, 0]}
  knuckle: {mass: 20, inertia: [0.5, 0.8, 0.5], position: wheel}
joints:
  hinge: {type: revolute, bodies: [ground, arm], point: lower_front, axis: [lower_front, lower_rear]}
  ball: {type: spherical, bodies: [arm, knuckle], point: lower_ball}
  rod: {type: distance, points: [ground.damper_top, knuckle.wheel]}
forces:
  damper: {type: tsda, points: [{body: ground, at: damper_top}, arm.damper_eye], k: 30000, length: 380 mm}
  bump: {type: point_force, point: knuckle.wheel, force: [0, 0, "1 N/m * wheel.y"]}
"""
POINTS = {
    "lower_front": (-106, 240, 65.4),
    "lower_rear": (116, 240, 25.6),
    "lower_ball": (-12.5, 562, -60),
    "damper_top": (52.3, 263, 362),
    "damper_eye": (-8, 431, 30),
    "wheel": (0, 650, 0),
}


def loaded(folder: Path, text: str = CORNER, **parameters: Any) -> sr.Model:
    (folder / "corner.yaml").write_text(text, encoding="utf-8")
    return sr.load(folder / "corner.yaml", parameters=parameters or None)


def in_python(points: Any) -> sr.Model:
    """The model of the file above."""
    p = points
    arm = sr.Body("arm", 3, (0.1, 0.1, 0.1), position=p["lower_front"], center_of_mass=(0, 0.1, 0))
    knuckle = sr.Body("knuckle", 20, (0.5, 0.8, 0.5), position=p["wheel"])
    eye, top, centre = (
        body.global_point(*p[name])
        for body, name in ((arm, "damper_eye"), (sr.ground, "damper_top"), (knuckle, "wheel"))
    )
    joints = [
        sr.Revolute("hinge", sr.ground, arm, p["lower_front"], axis=(p["lower_front"], p["lower_rear"])),
        sr.Spherical("ball", arm, knuckle, p["lower_ball"]),
        sr.Distance("rod", top, centre),
    ]
    forces = [sr.TSDA("damper", top, eye, 30000, 0.38), sr.PointForce("bump", centre, (0, 0, 0.65))]
    return sr.Model("corner", [arm, knuckle], joints, forces, (0, 0, -9.81))


def values(plan: Blueprint) -> list[float]:
    return [float(x) for placed in plan.placed for value in placed.values for x in np.ravel(value)]


def test_files_and_python_give_the_same_model_as_plain_numbers(tmp_path: Path) -> None:
    plain = in_python({name: np.array(place) / 1000 for name, place in POINTS.items()})
    for model in (loaded(tmp_path), in_python(sr.Hardpoints(POINTS, unit="mm"))):
        plan = blueprint(model)
        assert plan.q == pytest.approx(blueprint(plain).q, abs=1e-15)
        assert values(plan) == pytest.approx(values(blueprint(plain)), abs=1e-15)
        assert [*model.hardpoints] == [*POINTS]
        assert model.hardpoints["lower_ball"] == pytest.approx((-0.0125, 0.562, -0.06))
        assert model.parameters["damper_eye.y"] == pytest.approx(0.431)


def test_a_coordinate_moves_all_that_uses_it(tmp_path: Path) -> None:
    for model in (loaded(tmp_path), in_python(sr.Hardpoints(POINTS, unit="mm"))):
        moved = model.with_parameters({"lower_front.z": 0.07})
        before, after = written_numbers(model), written_numbers(moved)
        changed = {name: after[name] - before[name] for name in after if after[name] != before[name]}
        expected = {"arm.position.z": 0.0046, "hinge.point.z": 0.0046, "hinge.axis.z": -0.0046}
        assert changed == pytest.approx(expected)
        assert moved.hardpoints["lower_front"][2] == 0.07


def test_other_values_may_have_units(tmp_path: Path) -> None:
    model = loaded(tmp_path)
    moved = model.with_parameters({"lower_front.z": "70 mm", "damper.k": "31 N/mm"})
    assert written_numbers(moved) == written_numbers(
        model.with_parameters({"lower_front.z": 0.07, "damper.k": 31e3})
    )
    for name, text, unit in (("lower_front.z", "3 kg", "m"), ("damper.k", "31 N", "N/m")):
        with pytest.raises(sr.ModelError, match=f"{name} must be in {unit}, or another unit of that kind"):
            model.with_parameters({name: text})


def test_a_coordinate_may_follow_from_others(tmp_path: Path) -> None:
    model = loaded(tmp_path)
    assert model.hardpoints["wheel"][2] == pytest.approx(0)
    assert model.with_parameters({"lower_ball.z": -0.07}).hardpoints["wheel"][2] == pytest.approx(-0.005)
    assert loaded(tmp_path, **{"lower_ball.z": "-80 mm"}).hardpoints["wheel"][2] == pytest.approx(-0.01)


def test_vectors_of_hardpoints(tmp_path: Path) -> None:
    p = sr.Hardpoints({"a": ("1 in", 0, 2), "b": (3, 4, 5)})
    assert repr(p) == "Hardpoints(a, b)"
    assert repr(2 * p.b - p["a"] / 2 + (1, 1, 1) - (-p.a)) == "Hardpoint(7.0127, 9, 12)"
    assert repr((1, 1, 1) - p.b) == "Hardpoint(-2, -3, -4)"
    body = sr.Body("body", 1, (1, 1, 1), position=np.array((p.a + p.b) / 2))
    model = sr.Model("m", [body])
    assert model.with_parameters({"a.y": 2.0}).bodies[0].position[1] == 3.0  # although it was zero
    with pytest.raises(KeyError, match='there is no hardpoint "c"'):
        p["c"]
    with pytest.raises(AttributeError, match="there is no hardpoint"):
        _ = p.c
    assert pickle.loads(pickle.dumps(model)).hardpoints == model.hardpoints


@pytest.mark.parametrize("change", [False, True])
def test_models_with_hardpoints_are_saved(tmp_path: Path, change: bool) -> None:
    for n, model in enumerate((loaded(tmp_path), in_python(sr.Hardpoints(POINTS, unit="mm")))):
        saved = model.with_parameters({"lower_ball.z": -0.061}) if change else model
        replace(saved, origin=None).save(tmp_path / f"saved_{n}.yaml")
        again = sr.load(tmp_path / f"saved_{n}.yaml")
        assert first_difference(saved, again) == ""
        assert again.hardpoints == saved.hardpoints
        text = (tmp_path / f"saved_{n}.yaml").read_text(encoding="utf-8")
        assert f"lower_ball: [-12.5, 562, -{61 if change else 60}]" in text
        assert "axis: [lower_front, lower_rear]" in text
        assert "{body: arm, global: damper_eye}" in text


def test_a_moved_hardpoint_is_written_into_the_file(tmp_path: Path) -> None:
    loaded(tmp_path).with_parameters({"lower_ball.y": 0.5634}).save(tmp_path / "moved.yaml")
    assert (tmp_path / "moved.yaml").read_text(encoding="utf-8") == CORNER.replace("562", "563.4")


def test_hardpoints_of_included_files(tmp_path: Path) -> None:
    loaded(tmp_path)
    text = "name: car\ninclude:\n- {file: corner.yaml, prefix: front_}\n"
    text += "hardpoints: {lower_ball: [0, 0, 0]}\nbodies:\n  box: {mass: 1, inertia: [1, 1, 1], position: lower_ball}\n"
    (tmp_path / "car.yaml").write_text(text, encoding="utf-8")
    model = sr.load(tmp_path / "car.yaml")
    assert [*model.hardpoints] == ["lower_ball", *(f"front_{name}" for name in POINTS)]
    changed = model.with_parameters({"front_lower_ball.x": 0.5})
    assert changed.joints[1].point[0] == 0.5  # type: ignore[attr-defined]
    assert changed.bodies[0].position[0] == 0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("point: lower_ball", "point: lower_bal", 'corner.yaml:16: joint "ball": point has the unknown point "lower_b'),
        ("arm.damper_eye", "arm.damper_ey", 'Did you mean "damper_eye"?'),
        ("arm.damper_eye", "ar.damper_eye", 'there is no body "ar"'),
        ("-60]", "-60, 1]", 'corner.yaml:7: hardpoint "lower_ball": must be three coordinates, got 4'),
        ("-60]", "-60 kg]", "expects m"),
        ("lower_rear: [116, 240, 25.6]", "lower_rear: [-106, 240, 65.4]", 'axis is through "lower_front" and'),
        ("lower_front, lower_rear]", "lower_front, lower_rea]", 'the unknown point "lower_rea"'),
        ("unit: mm", "unit: kg", 'corner.yaml:4: model: the unit of hardpoints must be one of length, got "kg"'),
        ("unit: mm", "2nd: [1, 2, 3]", "its name must be letters, digits and _"),
        ("unit: mm", "pi: [1, 2, 3]", 'has the name "pi", which has a meaning of its own'),
        ("unit: mm", "arm: [1, 2, 3]", 'hardpoint "arm": the name "arm" is taken by another of the bodies'),
        ("joints:", "parameters: {wheel: {x: 1}}\njoints:", 'hardpoint "wheel": the name "wheel" is also that of a'),
        ("joints:", "points: {wheel: [0, 0, 0]}\njoints:", 'hardpoint "wheel": the name "wheel" is also that of a'),
    ],
)  # fmt: skip
def test_messages_of_files(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in CORNER
    with pytest.raises(sr.ModelError) as error:
        loaded(tmp_path, CORNER.replace(old, new))
    assert message in str(error.value)


def test_messages_in_python() -> None:
    wrong: Any
    for wrong, message in (
        ({"a": (1, 2)}, 'hardpoint "a": must be three coordinates, got 2 numbers'),
        ({"a": (1, 2, "3 kg")}, 'hardpoint "a": z must be in m, or another unit of that kind, got "3 kg"'),
        ({"a": (1, float("nan"), 3)}, 'hardpoint "a": y must be a finite number'),
        ({"a b": (1, 2, 3)}, "its name must be letters"),
        ({"t": (1, 2, 3)}, 'hardpoint "t": has the name "t", which has a meaning of its own. Rename it'),
        ({"pi": (1, 2, 3)}, 'has the name "pi", which has a meaning of its own'),
        ({"unit": (1, 2, 3)}, 'has the name "unit", which has a meaning of its own'),
        ([1], "hardpoints must be a mapping"),
    ):
        with pytest.raises(sr.ModelError, match=message):
            sr.Hardpoints(wrong)
    a, b = (sr.Hardpoints({"P": (0, 0, z)}) for z in (1, 2))
    two = [sr.Body(f"b{n}", 1, (1, 1, 1), position=p.P) for n, p in enumerate((a, b))]
    with pytest.raises(sr.ModelError, match=r'two values of "P\.z", 1 and 2\. Use one table of hardpoints'):
        sr.System(sr.Model("m", two))
    with pytest.raises(sr.ModelError, match='hardpoint "P": the name "P" is taken by another of the bodies'):
        sr.System(sr.Model("m", [sr.Body("P", 1, (1, 1, 1), position=a.P)]))
    hinge = sr.Revolute("hinge", sr.ground, two[0], point=a.P, axis=(a.P, a.P))
    with pytest.raises(sr.ModelError, match=r"axis is through two equal points\. Move one of them"):
        sr.System(sr.Model("m", two[:1], [hinge]))


def test_a_model_that_was_right_is_checked_again_when_its_parts_are_others() -> None:
    one, other = (sr.Body(f"b{z}", 1, (1, 1, 1), position=sr.Hardpoints({"P": (0, 0, z)}).P) for z in (1, 2))
    bodies = [one]
    model = sr.Model("m", bodies)
    bodies.append(other)
    assert sr.System(model).model.bodies == (one,)
    for again in (model, copy.copy(model), copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
        sr.System(again)
        object.__setattr__(again, "bodies", (*again.bodies, other))
        with pytest.raises(sr.ModelError, match=r'two values of "P\.z", 1 and 2'):
            sr.System(again)


def test_a_part_that_is_replaced_no_longer_follows() -> None:
    p = sr.Hardpoints({"wheel": (100, 700, 200)}, unit="mm")
    model = sr.Model("m", [sr.Body("a", 1, (1, 1, 1), position=p.wheel)])
    other = replace(model, bodies=[sr.Body("a", 1, (1, 1, 1), position=(9, 0.7, 9))])
    changed = other.with_parameters({"wheel.x": 0.5, "wheel.y": 0.6}).bodies[0].position
    assert [*changed] == [9, 0.6, 9]


def test_parts_with_another_value_than_the_model_are_refused(tmp_path: Path) -> None:
    p = sr.Hardpoints({"wheel": (100, 700, 200)}, unit="mm")
    model = sr.Model("m", [sr.Body("a", 1, (1, 1, 1), position=p.wheel)])
    changed = model.with_parameters({"wheel.x": 0.5})
    sr.System(changed)
    wrong = changed.adding(sr.Spherical("j", sr.ground, changed.bodies[0], p.wheel))
    with pytest.raises(sr.ModelError, match=r'two values of "wheel.x", 0.5 and 0.1\. Use one table'):
        sr.System(wrong)
    model.save(tmp_path / "m.yaml")
    read = sr.load(tmp_path / "m.yaml")
    q = sr.Hardpoints({"wheel": (100, 700, 201)}, unit="mm")
    sr.System(read.adding(sr.Spherical("j", sr.ground, read.bodies[0], p.wheel)))
    for part in (
        sr.Spherical("j", sr.ground, read.bodies[0], q.wheel),
        sr.TSDA(
            "s", sr.Point(sr.ground, (0, 0, 0)), sr.Point(read.bodies[0], (0, 0, 0)), k=q.wheel.z, length=1
        ),
    ):
        with pytest.raises(sr.ModelError, match=r'two values of "wheel.z", 0.2 and 0.201'):
            sr.System(read.adding(part))


def test_one_number_of_a_law_is_changed_by_its_own_name() -> None:
    p = sr.Hardpoints({"wheel": (100, 700, 200)}, unit="mm")
    body = sr.Body("a", 1, (1, 1, 1))
    spring = sr.TSDA(
        "s", sr.Point(sr.ground, (0, 0, 1)), sr.Point(body, (0, 0, 0)), k=50 * p.wheel.x, length=1
    )
    changed = sr.Model("m", [body], [], [spring]).with_parameters({"s.k.2": 0.3})
    sr.System(changed)
    assert written_numbers(changed)["s.k.2"] == 0.3
