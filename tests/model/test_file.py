"""The model file: what it means, that YAML and JSON say the same, and its published schema."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import sarrus as sr
from sarrus.model import (
    RSDA,
    TSDA,
    AxisAngle,
    Body,
    Curve,
    Distance,
    Driver,
    EulerAngles,
    Fixed,
    Force,
    Joint,
    Model,
    ModelError,
    PointForce,
    Revolute,
    Spherical,
    Torque,
    Tyre,
    Universal,
    ground,
    load,
)
from sarrus.model.expansion.blueprint import Blueprint, blueprint
from sarrus.model.file import print_schema, schema_text

EVERYTHING = """\
$schema: schema.json
name: everything at once
description: One of each.
gravity: [0, 0, -1e1]
bodies:
  a: {mass: 010, inertia: [1, 1, 1], position: [1, 2, 3], orientation: {axis: [0, 1, 0], angle: 5e-1}}
  b:
    mass: 2
    inertia: {xx: 2, yy: 2, zz: 3, xy: .1}
    orientation: {angles: [0.1, 0.2, 0.3], sequence: zxz}
    center_of_mass: [0, 0, 0.1]
    velocity: [1, 0, 0]
    angular_velocity: [0, 0, 2]
  c:
    mass: 3
    inertia: [[1, 0, 0], [0, 1, 0.1], [0, 0.1, 1]]
    orientation: [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
  d: {mass: 4, inertia: [1, 1, 1], orientation: [0, 1, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, a], point: [0, 1, 0], axis: [0, 0, 2]}
  hook: {type: universal, bodies: [a, b], point: [0, 1, 0], axis_i: [1, 0, 0], axis_j: [0, 1, 0]}
  ball: {type: spherical, points: [{body: b, at: [1, 0, 0]}, {body: c, global: [0, 1, 0]}]}
  weld: {type: fixed, frames: [{body: c, at: [0, 0, 1]}, {body: d, global: [0, 0, 1], x: [0, 1, 0], z: [0, 0, 1]}]}
  rod: {type: distance, points: [{body: ground, at: [0, 0, 9]}, {body: d, at: [0, 0, 0]}]}
forces:
  spring: {type: tsda, points: [{body: a, at: [0, 0, 0]}, {body: b, at: [0, 0, 0]}], k: 5, length: 1, c: 2}
  bump:
    type: tsda
    points: [{body: a, at: [0, 0, 1]}, {body: b, at: [0, 0, 0]}]
    k: {table: [[0, 1], [1, 3], [2, 4]]}
    length: 1
  coil: {type: rsda, bodies: [ground, a], point: [0, 0, 0], axis: [0, 0, 1], k: 3, torque: 1}
  push: {type: point_force, point: {body: c, global: [0, 0, 0]}, force: [0, 0, 1], axes: body}
  twist: {type: torque, body: d, torque: [1, 0, 0]}
  wheel: {type: tyre, point: {body: d, at: [0, 0, 0]}, k: 10, c: 1, radius: 0.5}
"""


def in_python() -> Model:
    """Return the same model, said in Python."""
    a = Body("a", 10, (1, 1, 1), position=(1, 2, 3), orientation=AxisAngle((0, 1, 0), 0.5))
    b = Body(
        "b",
        2,
        {"xx": 2, "yy": 2, "zz": 3, "xy": 0.1},
        orientation=EulerAngles((0.1, 0.2, 0.3), "zxz"),
        center_of_mass=(0, 0, 0.1),
        velocity=(1, 0, 0),
        angular_velocity=(0, 0, 2),
    )
    c = Body(
        "c", 3, [[1.0, 0, 0], [0.0, 1, 0.1], [0, 0.1, 1]], orientation=[[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    )
    d = Body("d", 4, (1, 1, 1), orientation=(0, 1, 0, 0))
    weld = c.frame((0, 0, 1)), d.frame(d.global_point(0, 0, 1), x=(0, 1, 0), z=(0, 0, 1))
    joints = [
        Revolute("pin", ground, a, point=(0, 1, 0), axis=(0, 0, 2)),
        Universal("hook", a, b, point=(0, 1, 0), axis_i=(1, 0, 0), axis_j=(0, 1, 0)),
        Spherical("ball", point_i=b.point(1, 0, 0), point_j=c.global_point(0, 1, 0)),
        Fixed("weld", frame_i=weld[0], frame_j=weld[1]),
        Distance("rod", ground.point(0, 0, 9), d.point(0, 0, 0)),
    ]
    forces = [
        TSDA("spring", a.point(0, 0, 0), b.point(0, 0, 0), k=5, length=1, c=2),
        TSDA("bump", a.point(0, 0, 1), b.point(0, 0, 0), k=Curve.table([(0, 1), (1, 3), (2, 4)]), length=1),
        RSDA("coil", ground, a, point=(0, 0, 0), axis=(0, 0, 1), k=3, torque=1),
        PointForce("push", c.global_point(0, 0, 0), (0, 0, 1), axes="body"),
        Torque("twist", d, (1, 0, 0)),
        Tyre("wheel", d.point(0, 0, 0), k=10, c=1, radius=0.5),
    ]
    return Model("everything at once", [a, b, c, d], joints, forces, gravity=(0, 0, -10))


def as_json(text: str) -> str:
    """Return the same file as JSON."""
    data: dict[str, Any] = yaml.safe_load(
        text.replace("1e1", "10.0").replace("010", "10").replace("5e-1", "0.5")
    )
    return json.dumps(data, indent=2)


def same(one: Blueprint, other: Blueprint) -> bool:
    """Return whether two blueprints agree in every bit."""
    arrays = np.array_equal(one.q, other.q) and np.array_equal(one.v, other.v)
    return arrays and (one.name, one.bodies, one.placed) == (other.name, other.bodies, other.placed)


def test_yaml_json_and_python_say_the_same(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(EVERYTHING, encoding="utf-8-sig")
    (tmp_path / "m.json").write_text(as_json(EVERYTHING))
    plans = [blueprint(load(tmp_path / name)) for name in ("m.yaml", "m.json")]
    assert all(same(plan, blueprint(in_python())) for plan in plans)


def test_a_change_of_any_number_changes_the_blueprint(tmp_path: Path) -> None:
    """Guards the test above: every number in the file counts."""
    (tmp_path / "m.yaml").write_text(EVERYTHING)
    plan = blueprint(load(tmp_path / "m.yaml"))
    for old, new in [
        ("mass: 010", "mass: 11"),
        ("angle: 5e-1", "angle: 0.6"),
        ("[1, 3]", "[1, 3.1]"),
        ("k: 3", "k: 4"),
    ]:
        (tmp_path / "m.yaml").write_text(EVERYTHING.replace(old, new))
        assert not same(plan, blueprint(load(tmp_path / "m.yaml")))


def test_a_model_knows_where_its_parts_stand(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(EVERYTHING)
    model = load(tmp_path / "m.yaml")
    assert model.where("b") == f"{tmp_path / 'm.yaml'}:7"
    assert model.where("weld") == f"{tmp_path / 'm.yaml'}:23"
    assert model.where("nothing") == ""
    assert in_python().where("b") == ""


@pytest.mark.parametrize(
    ("word", "value"),
    [("1e-3", 1e-3), ("1E+3", 1e3), ("010", 10.0), (".5", 0.5), ("5.", 5.0), ("+1", 1.0), ("1.5e2", 150.0)],
)
def test_numbers_are_those_of_yaml_1_2(word: str, value: float, tmp_path: Path) -> None:
    text = EVERYTHING.replace("gravity: [0, 0, -1e1]", f"gravity: [0, 0, {word}]")
    (tmp_path / "m.yaml").write_text(text)
    assert load(tmp_path / "m.yaml").gravity[2] == value


@pytest.mark.parametrize("name", ["on", "yes", "1e", "Fahrzeug Ü", "12:30", "'7'", "2026-11-21"])
def test_texts_stay_texts(name: str, tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(EVERYTHING.replace("everything at once", name), encoding="utf-8")
    assert load(tmp_path / "m.yaml").name == name.strip("'")


def test_json_texts_keep_their_escapes(tmp_path: Path) -> None:
    text = as_json(EVERYTHING).replace("everything at once", r"\u00e9\ud83d\ude00\/ \"x\"")
    (tmp_path / "m.json").write_text(text.replace("  ", "\t"))
    assert load(tmp_path / "m.json").name == 'é😀/ "x"'


def test_a_single_field_keeps_its_name(tmp_path: Path) -> None:
    """The knife edge has a `body_i` without a `body_j`, so its key is not `bodies`."""
    plate, sled = (sr.Body(name, mass=1, inertia=(1, 1, 1)) for name in ("plate", "sled"))
    edge = sr.KnifeEdge("edge", sled.point(0, 0, 0), axis=(0, 1, 0), body_i=plate)
    sr.Model("sledge", [plate, sled], [edge]).save(tmp_path / "m.yaml")
    assert "body_i: plate" in (tmp_path / "m.yaml").read_text()
    (read,) = load(tmp_path / "m.yaml").joints
    assert isinstance(read, sr.KnifeEdge)
    assert read.body_i.name == "plate"


def test_the_published_schema_is_up_to_date(capsys: pytest.CaptureFixture[str]) -> None:
    file = Path(str(files("sarrus.model.file").joinpath("schema.json")))
    published = file.read_text(encoding="utf-8")
    if published != schema_text():
        program = (
            "from sarrus.model.file import print_schema; print_schema()"  # without the kinds of other tests
        )
        fresh = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True).stdout
        file.write_bytes(fresh)
        pytest.fail(f"{file} was out of date. It was written anew: commit it.")
    print_schema()
    assert capsys.readouterr().out == published


def test_the_schema_names_every_kind_and_allows_no_other_key() -> None:
    definitions = json.loads(schema_text())["$defs"]
    kinds = {
        one["properties"]["type"]["const"] for one in definitions.values() if "type" in one["properties"]
    }
    assert kinds >= {"revolute", "distance", "tsda", "rsda", "point_force", "torque", "tyre"}
    assert all(one["additionalProperties"] is False for one in definitions.values())


def test_a_new_force_is_one_class(tmp_path: Path) -> None:
    script = tmp_path / "wind.py"
    script.write_text(WIND)
    (tmp_path / "m.yaml").write_text(EVERYTHING + "  gust: {type: side_wind, body: a, speed: 3}\n")
    (tmp_path / "bad.yaml").write_text(EVERYTHING + "  gust: {type: side_wind, body: a, sped: 3}\n")
    command = [sys.executable, str(script), str(tmp_path / "m.yaml"), str(tmp_path / "bad.yaml")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[0] == "PointForce (1,) ((0.0, 0.0, 0.0), (0.0, 9.0, 0.0)) gust wind"
    assert 'force "gust": has no key "sped". Did you mean "speed"?' in done.stdout.splitlines()[1]


WIND = """
from __future__ import annotations

import sys
from dataclasses import dataclass

from sarrus import elements
from sarrus.model import Force, ModelError, load
from sarrus.model.expansion.blueprint import blueprint
from sarrus.model.primitive import Primitive
from sarrus.model.geometry.points import Solid


@dataclass(frozen=True, eq=False)
class SideWind(Force):
    '''A steady side wind.'''

    body: Solid
    speed: float

    def primitives(self, poses):
        values = ((0.0, 0.0, 0.0), (0.0, self.speed**2, 0.0))
        yield Primitive(elements.PointForce, (self.body.name,), values, "wind")


last = blueprint(load(sys.argv[1])).placed[-1]
print(last.element.__name__, *last[1:])
try:
    load(sys.argv[2])
except ModelError as error:
    print(error)
"""


def test_importing_the_model_layer_loads_nothing_heavy() -> None:
    code = (
        "import sys, sarrus.model; print(*sorted({'numba', 'scipy', 'pydantic', 'yaml'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_python_models_are_refused_by_name_too() -> None:
    body = Body("rod", 1.0, (1, 1, 1))
    wrong = {
        "model: gravity must have 3 numbers, but has 1. Give three numbers in m/s², such as (0, 0, -9.81).": Model(
            "m", [body], gravity=(1,)
        ),
        "model: has no bodies. Give at least one.": Model("m", []),
        'body "rod": the name "rod" is taken by another of the bodies. Rename one of them.': Model(
            "m", [body, body]
        ),
        'model: name must be a text on one line, but is "a\\nb". Name it.': Model("a\nb", [body]),
        'joint "rod": is among the joints, but its type is Body. Move it to bodies.': Model(
            "m", [body], [body]
        ),  # type: ignore[list-item]
        'joint "": is among the joints, but its type is int. List only Joint objects there.': Model(
            "m", [body], [3]
        ),  # type: ignore[list-item]
    }
    for told, model in wrong.items():
        with pytest.raises(ModelError) as caught:
            blueprint(model)
        assert str(caught.value) == told


def test_a_body_can_be_exchanged_for_one_of_its_name() -> None:
    rod = Body("rod", 1.0, (1, 1, 1), position=(1, 0, 0))
    pin = Revolute("pin", ground, rod, point=(0, 0, 0), axis=(0, 0, 1))
    other = Body("rod", 2.0, (1, 1, 1), position=(0, 1, 0))
    assert blueprint(Model("m", [other], [pin])).placed[0].values[1] == (0, -1, 0)


GUIDE = Path(__file__).parents[2].joinpath("docs", "model-file.md").read_text(encoding="utf-8")
EXAMPLES = [block.split("```")[0] for block in GUIDE.split("```yaml\n")[1:]]


def example(start: str, folder: Path) -> Model:
    """Return the model of the guide's example that begins like this; all are written, for includes."""
    for block in EXAMPLES:
        name = block.splitlines()[0].removeprefix("# ")
        if name.endswith(".yaml"):
            (folder / name).write_text(block, encoding="utf-8")
    block = next(block for block in EXAMPLES if start in block)
    (folder / "example.yaml").write_text(block, encoding="utf-8")
    return load(folder / "example.yaml")


def test_the_examples_of_the_guide_are_right(tmp_path: Path) -> None:
    assert len(EXAMPLES) == 12
    first = example("name: slider-crank", tmp_path)
    assert [body.name for body in first.bodies] == ["crank", "slider"]
    assert tuple(first.gravity) == (0, 0, -9.81)
    assert [driver.name for driver in example("name: driven wheels", tmp_path).drivers] == ["motor"]
    for kind in (*Joint.kinds, *Driver.kinds, *Force.kinds):
        assert f"| `{kind}` |" in GUIDE


def test_the_guides_formulas_are_right(tmp_path: Path, largest_phi: Callable[[Blueprint], float]) -> None:
    model = example("name: crank and rod", tmp_path)
    assert model.bodies[1].mass == 1.6
    assert model.parameters["rod_length"] == pytest.approx(0.6)
    assert np.hypot(
        *np.subtract(model.formulas.points["C"], model.formulas.points["B"])[1:]
    ) == pytest.approx(0.6)
    assert largest_phi(blueprint(model)) < 1e-15
    assert model.forces[0].length == pytest.approx(0.597)  # type: ignore[attr-defined]
    assert model.formulas.derivatives("tilt")["bodies", "crank", "orientation", "angle"] == 1


def test_the_guides_car_has_two_axles(tmp_path: Path) -> None:
    model = example("name: car", tmp_path)
    assert [body.name for body in model.bodies] == ["chassis", "front_beam", "rear_beam"]
    assert [body.mass for body in model.bodies] == [900, 30, 40]
    assert [next(iter(body.position)) for body in model.bodies[1:]] == [1.5, -1.5]
    assert list(model.parameters) == ["wheelbase", "front_x", "front_load", "rear_x", "rear_load"]


def test_the_guides_balls_are_copies(tmp_path: Path) -> None:
    assert [body.mass for body in example("name: three balls", tmp_path).bodies] == [2, 2, 3]


DRIVEN = """\
name: driven
bodies:
  a: {mass: 1, inertia: [1, 1, 1]}
  b: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}
  c: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, a], point: [0, 0, 0], axis: [0, 0, 1]}
  bolt: {type: screw, bodies: [ground, b], point: [1, 0, 0], axis: [0, 0, 1], pitch: 2 mm}
  table: {type: planar, bodies: [ground, c], point: [2, 0, 0], axis: [0, 0, 1]}
  line: {type: point_on_line, bodies: [a, c], point: [2, 0, 0], axis: [1, 0, 0]}
  plane: {type: point_on_plane, bodies: [a, c], point: [2, 0, 0], axis: [1, 0, 0]}
  along: {type: parallel_axes, bodies: [a, b], axis: [1, 0, 0]}
  lean: {type: constant_angle, bodies: [a, b], axis_i: [1, 0, 0], axis_j: [0, 1, 1], angle: 80 deg}
  arm: {type: revolute_spherical, points: [{body: a, at: [0, 0, 0]}, {body: b, at: [0, 0, 0]}], axis: [0, 0, 1]}
  link: {type: revolute_revolute, points: [{body: a, at: [0, 0, 0]}, {body: c, at: [0, 0, 0]}], axis_i: [0, 0, 1]}
  gear: {type: gear, joints: [pin, bolt], ratio: -2}
  rack: {type: rack_and_pinion, rack: bolt, pinion: pin, radius: 5 cm, offset: 1}
  pull: {type: coupler, joints: [table.displacement_x, pin], ratio: 3}
drivers:
  motor: {type: angle, joint: pin, motion: 2*pi*t}
  feed: {type: displacement, joint: table.displacement_y, motion: {table: [[0, 0], [1, 2 cm], [3, 0]]}}
  jack: {type: distance, points: [{body: a, at: [0, 0, 0]}, {body: b, at: [0, 0, 0]}], motion: 1 m + 10 mm * sin(t)}
  path: {type: point, point: {body: c, at: [0, 0, 1]}, x: t^2, z: 1}
  hold: {type: coordinate, body: b, coordinate: e1, motion: 0}
"""


def test_joints_couplings_and_drivers_in_yaml_and_python(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(DRIVEN)
    found, model = load(tmp_path / "m.yaml"), driven()
    for one, other in zip(blueprint(found).placed, blueprint(model).placed, strict=True):
        assert (one.element, one.bodies, one.owner, one.label) == (other[0], other[1], other[3], other[4])
        for value, expected in zip(one.values, other.values, strict=True):
            at = 0.7 if callable(value) else None
            np.testing.assert_allclose(
                value if at is None else value(at), expected if at is None else expected(at)
            )
    assert found.where("feed") == f"{tmp_path / 'm.yaml'}:21"


def driven() -> Model:
    """Return the same model, said in Python."""
    a, b, c = (Body(name, 1, (1, 1, 1), position=(x, 0, 0)) for x, name in enumerate("abc"))
    at = {body.name: body.point(0, 0, 0) for body in (a, b, c)}
    joints = [
        Revolute("pin", ground, a, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Screw("bolt", ground, b, point=(1, 0, 0), axis=(0, 0, 1), pitch=0.002),
        sr.Planar("table", ground, c, point=(2, 0, 0), axis=(0, 0, 1)),
        sr.PointOnLine("line", a, c, point=(2, 0, 0), axis=(1, 0, 0)),
        sr.PointOnPlane("plane", a, c, point=(2, 0, 0), axis=(1, 0, 0)),
        sr.ParallelAxes("along", a, b, axis=(1, 0, 0)),
        sr.ConstantAngle("lean", a, b, axis_i=(1, 0, 0), axis_j=(0, 1, 1), angle=np.deg2rad(80)),
        sr.RevoluteSpherical("arm", at["a"], at["b"], axis=(0, 0, 1)),
        sr.RevoluteRevolute("link", at["a"], at["c"], axis_i=(0, 0, 1)),
        sr.Gear("gear", "pin", "bolt", ratio=-2),
        sr.RackAndPinion("rack", "bolt", "pin", radius=0.05, offset=1),
        sr.Coupler("pull", "table.displacement_x", "pin", ratio=3),
    ]
    drivers = [
        sr.AngleDriver("motor", "pin", lambda t: 2 * np.pi * t),
        sr.DisplacementDriver("feed", "table.displacement_y", [(0, 0), (1, 0.02), (3, 0)]),
        sr.DistanceDriver("jack", at["a"], at["b"], "1 + 0.01*sin(t)"),
        sr.PointDriver("path", c.point(0, 0, 1), x=lambda t: t * t, z=1.0),
        sr.CoordinateDriver("hold", b, "e1", 0.0),
    ]
    return Model("driven", [a, b, c], joints, drivers=drivers)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("joint: pin, motion: 2*pi*t", "joint: pni, motion: t", ':20: driver "motor": there is no joint "pni". Did'),
        ("motion: 2*pi*t", "motion: 2*pi*x", ':20: driver "motor": motion '),
        ("motion: 2*pi*t", "moton: 2*pi*t", ':20: driver "motor": has no key "moton". Did you mean "motion"?'),
        ("motion: 2*pi*t", "motion: 2 m * t", ':20: driver "motor": motion '),
        ("motion: 2*pi*t", "motion: .nan", ':20: driver "motor": motion must be a finite number'),
        ("motion: 2*pi*t", "motion: [1, 2]", ':20: driver "motor": motion must be a number'),
        ("type: angle, joint: pin", "type: angel, joint: pin", ':20: driver "motor": has the unknown type "angel"'),
        (
            "joint: table.displacement_y",
            "joint: table",
            ':21: driver "feed": joint "table" has more than one displacement',
        ),
        ("[[0, 0], [1, 2 cm], [3, 0]]", "[[0, 0]]", ':21: driver "feed": motion.table must have at least 2 entries'),
        ("x: t^2, z: 1", "y:", ':23: driver "path": y must be a number'),
        ("coordinate: e1", "coordinate: e9", ':24: driver "hold": coordinate must be one of x, y, z, e0, e1, e2, e3'),
        ("joints: [pin, bolt]", "joints: [pin]", ':16: joint "gear": joints must have 2 entries, but has 1'),
        ("joints: [pin, bolt]", "joints: [pin, gear]", ':16: joint "gear": joint "gear" has no angle'),
        ("joints: [pin, bolt]", "joints: [pin, 3]", ':16: joint "gear": joints[1] must be a text, but is 3.0'),
        ("ratio: -2", "ratio: 0", ':16: joint "gear": ratio must not be 0'),
        ("pitch: 2 mm", "pitch: 2 kg", ':8: joint "bolt": pitch '),
        ("rack: bolt", "rack: pin", ':17: joint "rack": joint "pin" has no displacement'),
        ("  motor: {", "  pin: {", ':20: driver "pin": the name "pin" is taken by another of the joints'),
    ],
)  # fmt: skip
def test_wrong_drivers_and_couplings_are_refused_with_line_and_part(
    old: str, new: str, told: str, tmp_path: Path
) -> None:
    assert old in DRIVEN
    (tmp_path / "m.yaml").write_text(DRIVEN.replace(old, new, 1))
    with pytest.raises(ModelError) as caught:
        load(tmp_path / "m.yaml")
    assert told in str(caught.value)


WRONG = {  # a part of a message, what is replaced in the file, and by what
    "mass must be greater than 0": ("mass: 1", "mass: -1"),
    'there is no body "crnk"': ("[ground, crank]", "[ground, crnk]"),
    'has no key "lenght"': ("length: 5", "lenght: 5"),
    'but "3 m" is in m': ("mass: 1", "mass: 3 m"),
    'uses the unknown name "lenght"': ("mass: 1", "mass: 2*lenght"),
}
SMALL = """name: small
parameters: {length: 2}
bodies:
  crank: {mass: 1, inertia: [1, 1, 1]}
joints:
  pin: {type: revolute, bodies: [ground, crank], point: [0, 0, 0], axis: [0, 0, 1]}
forces:
  spring: {type: tsda, points: [{body: ground, at: [1, 0, 0]}, {body: crank, at: [0, 0, 0]}], k: 1, length: 5}
"""


@pytest.mark.parametrize("part", WRONG)
def test_the_messages_of_the_guide(part: str, tmp_path: Path) -> None:
    """Each line of the guide is the message of such a mistake, but for the file, the line and the name of the part."""
    (tmp_path / "crank.yaml").write_text(SMALL.replace(*WRONG[part]), encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        blueprint(load(tmp_path / "crank.yaml"))
    (line,) = [line for line in GUIDE.splitlines() if line.startswith("crank.yaml:") and part in line]
    shown = line.split(": ", 2)[2].removesuffix(" (and 2 more)")
    assert str(caught.value).split(": ", 2)[2].removesuffix(" (and 1 more)") == shown
