"""Files within files, anchors, aliases and merge keys."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.patience import within

from sarrus.model import Model, ModelError, load
from sarrus.model.expansion.blueprint import blueprint

HUB = """\
parameters: {d: 10 mm}
bodies:
  bolt: {mass: d * 10 kg/m, inertia: [1, 1, 1], position: [0, y, 0]}
joints:
  nut: {type: fixed, bodies: [bolt, wheel], point: C}
"""
WHEEL = """\
name: a wheel
gravity: [0, 0, -1]
include: [{file: parts/hub.yaml, prefix: h_}]
parameters:
  y: 1
  r: 0.3 m
points: {C: [0, y, r]}
bodies:
  wheel: {mass: h_bolt.mass*3, inertia: [1, 1, 1], position: C}
joints:
  axle: {type: revolute, bodies: [chassis, wheel], point: C, axis: [0, 1, 0]}
forces:
  tyre: {type: tyre, point: {body: wheel, at: [0, 0, 0]}, k: 1, c: 1, radius: r}
  push: {type: point_force, point: {body: wheel, at: [0, 0, 0]}, force: [0, 0, chassis.mass * 1 m/s^2], axes: body}
"""
CAR = """\
name: car
parameters: {track: 2 m}
include:
  - {file: wheel.yaml, prefix: left_, parameters: {y: track/2}}
  - {file: wheel.yaml, prefix: right_, parameters: {y: -track/2, r: 310 mm}}
bodies:
  chassis: {mass: 100, inertia: [1, 1, 1]}
"""


def written(folder: Path, *, car: str = CAR, wheel: str = WHEEL, hub: str = HUB) -> Model:
    """Return the model of three files."""
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "parts" / "hub.yaml").write_text(hub)
    (folder / "wheel.yaml").write_text(wheel)
    (folder / "car.yaml").write_text(car)
    return load(folder / "car.yaml")


def test_a_file_can_be_included_twice(tmp_path: Path) -> None:
    car = written(tmp_path)
    assert [body.name for body in car.bodies] == [
        "chassis",
        *("left_wheel", "left_h_bolt", "right_wheel", "right_h_bolt"),
    ]
    assert [list(body.position) for body in car.bodies[1:]] == [
        *([0, 1, 0.3], [0, 1, 0], [0, -1, 0.31], [0, -1, 0]),
    ]
    axle, nut = car.joints[0], car.joints[1]
    assert [(axle.body_i.name, axle.body_j.name), (nut.body_i.name, nut.body_j.name)] == [  # type: ignore[attr-defined]
        ("chassis", "left_wheel"),
        ("left_h_bolt", "left_wheel"),
    ]
    assert car.bodies[1].mass == pytest.approx(0.3)
    assert (car.name, list(car.gravity)) == ("car", [0, 0, 0])
    assert list(car.forces[1].force) == [0, 0, 100]  # type: ignore[attr-defined]


def test_parts_remember_the_file_that_they_stand_in(tmp_path: Path) -> None:
    car = written(tmp_path)
    assert car.where("left_tyre") == f"{tmp_path / 'wheel.yaml'}:13"
    assert car.where("right_h_bolt") == f"{tmp_path / 'parts' / 'hub.yaml'}:3"
    assert car.where("chassis") == f"{tmp_path / 'car.yaml'}:7"


def test_derivatives_go_through_includes(tmp_path: Path) -> None:
    rates = written(tmp_path).formulas.derivatives("track")
    assert rates["bodies", "left_wheel", "position", 1] == 0.5
    assert rates["joints", "right_h_nut", "point", 1] == -0.5


def test_a_file_without_a_prefix_shares_its_names(tmp_path: Path) -> None:
    car = written(tmp_path, car=CAR.split("  - {file")[0] + "  - wheel.yaml\n" + CAR[CAR.index("bodies:") :])
    assert [part.name for part in car.joints] == ["axle", "h_nut"]
    assert car.parameters["y"] == 1


@pytest.mark.parametrize("given", ["{size: {r: 0.5 m}}", "{size.r: 0.5 m}"])
def test_one_parameter_of_a_group_can_be_given(given: str, tmp_path: Path) -> None:
    (tmp_path / "ball.yaml").write_text(
        "parameters: {size: {r: 1 m, h: 2 m}}\n"
        "bodies:\n  ball: {mass: 1, inertia: [1, 1, 1], position: [size.r, size.h, 0]}\n"
    )
    (tmp_path / "two.yaml").write_text(
        f"name: two balls\ninclude:\n  - {{file: ball.yaml, prefix: small_, parameters: {given}}}\n"
        "  - {file: ball.yaml, prefix: big_}\n"
    )
    small, big = load(tmp_path / "two.yaml").bodies
    assert [list(small.position), list(big.position)] == [[0.5, 2, 0], [1, 2, 0]]


WRONG = [
    ("car", "y: track/2", "y.z: track/2", "car.yaml:4", 'gives the unknown parameter "y.z". Choose from y'),
    (
        "wheel",
        "radius: r",
        "radius: q",
        "wheel.yaml:13",
        'force "left_tyre": radius must be a number, but is',
    ),
    (
        "wheel",
        "mass: h_",
        "mas: h_",
        "wheel.yaml:9",
        'body "left_wheel": has no key "mas". Did you mean "mass"',
    ),
    (
        "wheel",
        "chassis, w",
        "chasis, w",
        "wheel.yaml:11",
        'joint "left_axle": there is no body "chasis". Did you',
    ),
    ("wheel", "radius: r", "radius: -r", "wheel.yaml:13", 'force "left_tyre": radius must be greater than 0'),
    ("wheel", "y: 1", "y: 1/0", "wheel.yaml:11", ""),
    ("wheel", "bodies:", "bodie:", "wheel.yaml:8", 'model: has no key "bodie". Did you mean "bodies"?'),
    ("wheel", "  y: 1\n", "  y: 1\n  y: 2\n", "wheel.yaml:6", 'parameter "y": the key "y" is given twice'),
    (
        "wheel",
        "parts/hub",
        "car",
        "wheel.yaml:3",
        "includes itself, car.yaml includes wheel.yaml includes car",
    ),
    (
        "wheel",
        "parts/hub.yaml",
        "parts/nut.yaml",
        "wheel.yaml:3",
        'includes "nut.yaml", which is no file. Check',
    ),
    (
        "wheel",
        "[{file: parts/hub.yaml, prefix: h_}]",
        "3",
        "wheel.yaml:3",
        "include must be a list, but is 3.0",
    ),
    (
        "hub",
        "d * 10",
        "e * 10",
        "hub.yaml:3",
        'body "left_h_bolt": mass uses the unknown name "e". Choose from',
    ),
    ("hub", "10 mm", "10 kg", "hub.yaml:3", 'body "left_h_bolt": mass expects kg, but "d * 10 kg/m" is in'),
    ("hub", HUB, "", "hub.yaml", ": is empty. Give at least"),
    ("hub", HUB, "[]", "hub.yaml:1", "model: must be a mapping. Give keys and values"),
    ("hub", HUB, "bodies: [1]", "hub.yaml:1", "model: bodies must be a mapping. Give keys and values"),
    ("hub", HUB, "a: [", "hub.yaml:1", "model: is not valid YAML"),
    (
        "car",
        "y: -track",
        "yy: -track",
        "car.yaml:5",
        'model: gives the unknown parameter "yy". Did you mean "y"',
    ),
    (
        "car",
        "-track/2",
        "-trac/2",
        "car.yaml:5",
        'parameter "right_y": uses the unknown name "trac". Did you',
    ),
    ("car", "right_", "left_", "car.yaml:5", 'model: brings a second body "left_wheel". Give it a prefix'),
    ("car", "right_", "3_", "car.yaml:5", "include[1].prefix must be letters, digits and _, starting with a"),
    (
        "car",
        "prefix: right_",
        "prefx: right_",
        "car.yaml:5",
        'include[1] has no key "prefx". Did you mean "prefix"',
    ),
    (
        "car",
        "file: wheel.yaml, prefix: right_",
        "prefix: right_",
        "car.yaml:5",
        "include[1].file is missing. Add",
    ),
    ("car", "bodies:", "bodies: 3\nx:", "car.yaml:6", "bodies must be a mapping. Give keys and values"),
]


@pytest.mark.parametrize(("file", "old", "new", "where", "phrase"), WRONG, ids=lambda v: str(v)[:20])
def test_what_is_wrong_names_the_right_file(
    file: str, old: str, new: str, where: str, phrase: str, tmp_path: Path
) -> None:
    texts = {"car": CAR, "wheel": WHEEL, "hub": HUB}
    assert old in texts[file]
    if not phrase:  # a value that every include replaces is never asked for
        assert written(tmp_path, **{file: texts[file].replace(old, new, 1)}).name == "car"
        return
    with pytest.raises(ModelError) as caught:
        written(tmp_path, **{file: texts[file].replace(old, new, 1)})
    told = str(caught.value)
    assert Path(told.split(": ")[0]).name == where, told
    assert phrase in told
    assert told.isprintable()


SECRET = "root:$6$hash: [1, 2"


@pytest.mark.parametrize("name", ["{}/shadow", "../elsewhere/shadow", "parts/../../elsewhere/shadow", "link"])
def test_files_outside_of_the_folder_are_not_included_and_not_quoted(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, elsewhere = tmp_path / "model", tmp_path / "elsewhere"
    (folder / "parts").mkdir(parents=True)
    elsewhere.mkdir()
    (elsewhere / "shadow").write_text(SECRET)
    (folder / "link").symlink_to(elsewhere / "shadow")
    (folder / "m.yaml").write_text(f"name: m\ninclude: ['{name.format(elsewhere)}']\n")
    with pytest.raises(
        ModelError, match=r"m\.yaml:2: .* is outside of the folder of the model\. Move"
    ) as caught:
        load(folder / "m.yaml")
    assert "hash" not in str(caught.value)
    (elsewhere / "shadow").write_text("bodies: {a: {mass: 1, inertia: [1, 1, 1]}}")
    monkeypatch.setenv("SARRUS_MESH_PATH", str(elsewhere))
    assert [body.name for body in load(folder / "m.yaml").bodies] == ["a"]


def test_included_files_may_include_files_of_folders_above_them(tmp_path: Path) -> None:
    (tmp_path / "parts" / "deep").mkdir(parents=True)
    (tmp_path / "m.yaml").write_text("name: m\ninclude: [parts/deep/one.yaml]\n")
    (tmp_path / "parts" / "deep" / "one.yaml").write_text("include: [../../other.yaml]\n")
    (tmp_path / "other.yaml").write_text("bodies: {a: {mass: 1, inertia: [1, 1, 1]}}")
    assert [body.name for body in load(tmp_path / "m.yaml").bodies] == ["a"]


@pytest.mark.parametrize("name", ["a\0b.yaml", "a" * 5000, "a/" * 3000 + "b.yaml"])
def test_names_that_no_file_can_have(name: str, tmp_path: Path) -> None:
    (tmp_path / "m.json").write_text(json.dumps({"name": "m", "include": [name]}))
    with pytest.raises(ModelError, match=r"which is no file. Check"):
        load(tmp_path / "m.json")


def test_files_that_include_each_other_twice_are_no_bomb(tmp_path: Path) -> None:
    for n in range(14):
        twice = f"include: [{{file: m{n + 1}.yaml, prefix: a_}}, {{file: m{n + 1}.yaml, prefix: b_}}]\n"
        (tmp_path / f"m{n}.yaml").write_text("name: bomb\n" + twice)
    (tmp_path / "m14.yaml").write_text("bodies: {a: {mass: 1, inertia: [1, 1, 1]}}\n")
    with (
        within(20),
        pytest.raises(ModelError, match=r"includes more than 500 files or 16 levels. Join some of them"),
    ):
        load(tmp_path / "m0.yaml")


ALIASES = """\
name: aliases
bodies:
  a: &rod {mass: &m 2.0, inertia: &J [1, 1, 1]}
  b: *rod
  c:
    <<: *rod
    mass: 3
  d:
    <<: [{mass: 4}, *rod]
    position: [*m, 0, 0]
  e: {mass: *m, inertia: *J}
"""


def test_aliases_and_merge_keys_are_copies(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(ALIASES)
    model = load(tmp_path / "m.yaml")
    assert [body.mass for body in model.bodies] == [2, 2, 3, 4, 2]
    assert all(list(body.inertia) == [1, 1, 1] for body in model.bodies)
    assert list(model.bodies[3].position) == [2, 0, 0]


@pytest.mark.parametrize(
    ("old", "new", "line", "phrase"),
    [
        (
            "&m 2.0",
            "&m -2.0",
            3,
            'body "a": mass must be greater than 0, but is -2.0. Give the mass in kg. (and',
        ),
        ("*rod\n    mass: 3", "*rod\n    mas: 3", 7, 'body "c": has no key "mas". Did you mean "mass"?'),
        (
            "b: *rod",
            "b: *rd",
            4,
            'body "b": uses the alias "*rd", but there is no anchor &rd above it. Did you',
        ),
        (
            "b: *rod",
            "b: &x [*x]",
            4,
            'body "b": uses the alias "*x" inside of its own anchor. Write the value',
        ),
        (
            "<<: *rod\n    mass",
            "<<: 3\n    mass",
            6,
            'body "c": has a merge key (<<) that is no mapping. Give',
        ),
        (
            "<<: *rod\n    mass",
            "<<: []\n    mass",
            6,
            'body "c": has a merge key (<<) that is no mapping. Give',
        ),
        (
            "<<: *rod\n    mass",
            "<<: *rod\n    <<: *rod\n    mass",
            7,
            'body "c": the key "<<" is given twice',
        ),
        (
            "<<: *rod\n    mass",
            "<<: *J\n    mass",
            6,
            'body "c": has a merge key (<<) that is no mapping. Give',
        ),
        ("mass: *m", "*m : 3", 11, 'body "e": has an alias (*) as key. Write the key out'),
    ],
)
def test_wrong_aliases_are_refused(old: str, new: str, line: int, phrase: str, tmp_path: Path) -> None:
    assert old in ALIASES
    (tmp_path / "m.yaml").write_text(ALIASES.replace(old, new, 1))
    with pytest.raises(ModelError) as caught:
        load(tmp_path / "m.yaml")
    assert str(caught.value).startswith(f"{tmp_path / 'm.yaml'}:{line}: {phrase}"), str(caught.value)


def test_aliases_are_no_bomb(tmp_path: Path) -> None:
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 60)]
    (tmp_path / "m.yaml").write_text("\n".join(lines))
    aliases = r"m.yaml:6: model: copies more than 500000 entries by its aliases"
    with within(20), pytest.raises(ModelError, match=aliases):
        load(tmp_path / "m.yaml")


def test_aliases_do_not_nest_deeper_than_a_file_may(tmp_path: Path) -> None:
    lines = ["a0: &a0 [1]", *(f"a{n}: &a{n} [*a{n - 1}]" for n in range(1, 100))]
    (tmp_path / "m.yaml").write_text("\n".join(lines))
    with pytest.raises(ModelError, match="is nested deeper than 64 levels"):
        load(tmp_path / "m.yaml")


CORNER = """
parameters: {stiffness: 100}
hardpoints: {unit: mm, ball: [0, 500, -100]}
left:
  bodies: {arm: {mass: 1, inertia: [1, 1, 1], position: ball}}
  joints: {pin: {type: revolute, bodies: [ground, arm], point: ball, axis: [1, 0, 0]}}
  forces: {spring: {type: tsda, points: [{body: ground, at: [0, 0.5, 0]}, arm.ball], k: stiffness, length: 0.1}}
"""


def with_corner(folder: Path, include: str) -> Model:
    (folder / "corner.yaml").write_text(CORNER)
    main = folder / "car.yaml"
    main.write_text(f"name: car\nparameters: {{depth: 0.3}}\ninclude: [{{file: corner.yaml, {include}}}]\n")
    return load(main)


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ("{ball.z: -60 mm}", (0, 0.5, -0.06)),
        ("{ball.z: -depth}", (0, 0.5, -0.3)),
        ("{ball: [0.1, 0.4, -0.2]}", (0.1, 0.4, -0.2)),
        ("{ball: {x: 5 mm, z: 0}}", (0.005, 0.5, 0)),
    ],
)
def test_an_including_file_moves_hardpoints(given: str, wanted: tuple[float, ...], tmp_path: Path) -> None:
    found = with_corner(tmp_path, f"prefix: front_, parameters: {given}")
    assert found.hardpoints["front_ball"] == pytest.approx(wanted, abs=1e-15)
    arms = {body.name: body.position for body in found.bodies}
    assert arms["front_arm_right"] == pytest.approx((wanted[0], -wanted[1], wanted[2]), abs=1e-15)


@pytest.mark.parametrize(
    ("include", "phrase"),
    [
        ("parameters: {ball.w: 1}", 'gives "ball.w", which is no coordinate of a hardpoint. Give ball.x'),
        ("parameters: {ball: [1, 2]}", 'gives "ball", which is no coordinate'),
        ("parameters: {bal.z: 1}", 'gives the unknown parameter "bal.z". Did you mean "ball"'),
        ("without: [sprig]", 'leaves out "sprig", which that file does not have. Did you mean "spring_left'),
        ("without: spring", "include[0].without must be a list"),
    ],
)
def test_wrong_includes_of_hardpoints_are_refused(include: str, phrase: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        with_corner(tmp_path, include)
    assert phrase in str(caught.value), str(caught.value)
    assert f"{tmp_path / 'car.yaml'}:3" in str(caught.value)


def test_parts_of_an_included_file_are_left_out(tmp_path: Path) -> None:
    whole = with_corner(tmp_path, "prefix: front_")
    assert {force.name for force in whole.forces} == {"front_spring_left", "front_spring_right"}
    assert not with_corner(tmp_path, "prefix: front_, without: [spring]").forces
    assert not with_corner(tmp_path, "without: [spring_left]").forces


PART = """\
name: part
parameters: {length: 0.3, heavy: 1, half: heavy/2, crank: {r: 1, m: 2}}
hardpoints: {ball: [1, 2, 3]}
bodies:
  rod: {mass: half, inertia: [1, 1, crank.r]}
  bob:
    mass: 1
    inertia: [1, 1, 1]
    position: [0, length, ball.z]
"""
VALUES = [
    ("length: 3 N", 'main.yaml:5, used in part.yaml:9: body "a_bob": position[1] expects m'),
    ("heavy: -1", 'main.yaml:5, used in part.yaml:5: body "a_rod": mass must be greater than 0, but is -0.5'),
    ("crank: {r: 1 N}", 'main.yaml:5, used in part.yaml:5: body "a_rod": inertia[2] expects kg m^2'),
    ("crank.r: -1", 'main.yaml:5, used in part.yaml:5: body "a_rod": inertia must be positive definite'),
    ("crank: {m: x}", 'main.yaml:5: parameter "a_crank": m must be a number, but is "x"'),
    ("ball.z: 3 N", 'main.yaml:5: hardpoint "a_ball": [2] expects m, but "3 N"'),
    ("ball: [1, x, 3]", 'main.yaml:5: hardpoint "a_ball": [1] must be a number, but is "x"'),
    ("lenth: 3", 'main.yaml:5: model: gives the unknown parameter "lenth". Did you mean "length"'),
    ("ball.w: 3", 'main.yaml:5: model: gives "ball.w", which is no coordinate'),
]


@pytest.mark.parametrize(("value", "message"), VALUES)
def test_errors_of_values_name_the_line_that_gives_them(tmp_path: Path, value: str, message: str) -> None:
    (tmp_path / "part.yaml").write_text(PART)
    main = tmp_path / "main.yaml"
    main.write_text(
        f"name: main\ninclude:\n  - file: part.yaml\n    parameters:\n      {value}\n    prefix: a_\n"
    )
    with pytest.raises(ModelError) as error:
        blueprint(load(main))
    assert str(error.value).replace(f"{tmp_path}/", "").startswith(message)


def test_errors_of_entries_without_such_values_have_their_own_line(tmp_path: Path) -> None:
    (tmp_path / "part.yaml").write_text(
        PART.replace("mass: 1\n", "mass: 1 m\n").replace("ball: [1, ", "ball: [x, ")
    )
    main = tmp_path / "main.yaml"
    main.write_text("name: main\ninclude:\n  - {file: part.yaml, parameters: {ball.z: 1, heavy: 2}}\n")
    with pytest.raises(ModelError) as error:
        load(main)
    assert 'part.yaml:3: hardpoint "ball": [0] must be a number' in str(error.value)
    assert "used in" not in str(error.value)
    (tmp_path / "part.yaml").write_text(PART.replace("mass: 1\n", "mass: 1 m\n"))
    with pytest.raises(ModelError) as error:
        load(main)
    assert 'part.yaml:7: body "bob": mass expects kg' in str(error.value)
    assert "used in" not in str(error.value)
