"""A wrong model file is refused by one sentence: file, line, part, what is wrong, remedy."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import pytest

from sarrus.model import ModelError, load

MODEL = """\
name: pendulum
gravity: [0, 0, -9.81]
bodies:
  rod:
    mass: 2.0
    inertia: [1.0, 1.0, 0.5]
    position: [0, 1, 0]
    orientation: [1, 0, 0, 0]
  bob:
    mass: 1.0
    inertia: {xx: 1.0, yy: 1.0, zz: 0.5}
    position: [0, 4, 0]
joints:
  pin:
    type: revolute
    bodies: [ground, rod]
    point: [0, 0, 0]
    axis: [1, 0, 0]
  cross:
    type: universal
    bodies: [rod, bob]
    point: [0, 2, 0]
    axis_i: [1, 0, 0]
    axis_j: [0, 0, 1]
  stay:
    type: distance
    points:
      - {body: bob, at: [0, 1, 0]}
      - {body: ground, global: [0, 9, 0]}
    length: 4.0
forces:
  spring:
    type: tsda
    points:
      - {body: rod, at: [0, 0, 0]}
      - {body: ground, at: [0, 9, 0]}
    k: 10.0
    length: 5.0
  push:
    type: point_force
    point: {body: rod, at: [0, 1, 0]}
    force: [0, 0, 5]
    axes: body
  wheel:
    type: tyre
    point: {body: bob, at: [0, 0, 0]}
    k: 1000.0
    c: 10.0
    radius: 0.5
"""


class Wrong(NamedTuple):
    """One edit of the model above, and what the error must say."""

    old: str
    new: str
    line: int
    part: str
    phrase: str


ROD, BOB, PIN, CROSS, STAY = 'body "rod"', 'body "bob"', 'joint "pin"', 'joint "cross"', 'joint "stay"'
SPRING, PUSH, WHEEL = 'force "spring"', 'force "push"', 'force "wheel"'
DEEP = "[" * 70 + "]" * 70
TURNED = "[[1, 0, 0], [0, 1, 0], [0, 0, -1]]"

EDITS = [
    # bodies: numbers
    Wrong("mass: 2.0", "mass: -1.0", 5, ROD, "mass must be greater than 0, but is -1.0; give the mass in kg"),
    Wrong("mass: 2.0", "mass: 0", 5, ROD, "mass must be greater than 0, but is 0.0; give the mass in kg"),
    Wrong("mass: 2.0", "mass: .nan", 5, ROD, "mass must be a finite number, but is nan; check its size"),
    Wrong("mass: 2.0", "mass: -.inf", 5, ROD, "mass must be a finite number, but is -inf; check its size"),
    Wrong("mass: 2.0", "mass: 1e999", 5, ROD, "mass must be a finite number, but is inf; check its size"),
    Wrong("mass: 2.0", "mass: " + "9" * 5000, 5, ROD, "mass must be a finite number, but is inf; check"),
    Wrong(
        "mass: 2.0", "mass: two", 5, ROD, 'mass must be a number, but is "two"; write it as in 1.5e-3, 20 mm'
    ),
    Wrong("mass: 2.0", 'mass: "2.0"', 5, ROD, 'mass must be a number, but is "2.0"; write it without quotes'),
    Wrong("mass: 2.0", "mass: 2 m", 5, ROD, 'mass expects kg, but "2 m" is in m; give it in kg, or leave'),
    Wrong("mass: 2.0", "mass: 0x10", 5, ROD, 'mass has the unknown unit "x10"; choose from'),
    Wrong("mass: 2.0", "mass: 1_000", 5, ROD, 'mass has the unknown unit "_000"; choose from'),
    Wrong("mass: 2.0", "mass: 1:30", 5, ROD, 'mass holds ":", which no formula has; check "1:30"'),
    Wrong("mass: 2.0", "mass: true", 5, ROD, "mass must be a number, but is true; write it as in"),
    Wrong("mass: 2.0", "mass: on", 5, ROD, 'mass must be a number, but is "on"; write it as in'),
    Wrong("mass: 2.0", "mass:", 5, ROD, "mass must be a number, but is empty; write it as in"),
    Wrong("mass: 2.0", "mass: [2.0]", 5, ROD, "mass must be a number, but is a list; write it as in"),
    Wrong("mass: 2.0", "mass: {kg: 2}", 5, ROD, "mass must be a number, but is a mapping; write it as in"),
    Wrong("    mass: 2.0\n", "", 4, ROD, "mass is missing; add it"),
    # bodies: inertia
    Wrong(
        "[1.0, 1.0, 0.5]", "[1.0, 1.0, 2.5]", 6, ROD, "breaks the triangle inequality, its principal moments"
    ),
    Wrong(
        "[1.0, 1.0, 0.5]", "[1.0, 1.0, -0.5]", 6, ROD, "must be positive definite, but its principal moments"
    ),
    Wrong("[1.0, 1.0, 0.5]", "[0, 0, 0]", 6, ROD, "must be positive definite, but its principal moments"),
    Wrong(
        "zz: 0.5}", "zz: 0.5, xy: 2}", 11, BOB, "must be positive definite, but its principal moments are -1"
    ),
    Wrong("[1.0, 1.0, 0.5]", "[[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]", 6, ROD, "inertia must be symmetric, but"),
    Wrong(
        "[1.0, 1.0, 0.5]", "[[1, 0, 0], [0, 1, 0]]", 6, ROD, "inertia must have 3 entries, but has 2; give 3"
    ),
    Wrong("[1.0, 1.0, 0.5]", "[[1, 0], [0, 1], [0, 0]]", 6, ROD, "inertia[0] must have 3 entries, but has 2"),
    Wrong("[1.0, 1.0, 0.5]", "[1.0, 1.0]", 6, ROD, "inertia must have 3 entries, but has 2; give 3"),
    Wrong("[1.0, 1.0, 0.5]", "1.0", 6, ROD, "is 1.0; write it in brackets, as in [1, 1, 1]"),
    Wrong("zz: 0.5}", "zz: 0.5, yx: 0}", 11, BOB, 'inertia has no key "yx"; choose from xx, yy, zz,'),
    Wrong(", zz: 0.5}", "}", 11, BOB, "inertia.zz is missing; add it"),
    # bodies: pose
    Wrong(
        "[1, 0, 0, 0]",
        "[1, 0.1, 0, 0]",
        8,
        ROD,
        "unit Euler parameters, but their length is 1.00498756; give",
    ),
    Wrong("[1, 0, 0, 0]", "[0, 0, 0, 0]", 8, ROD, "unit Euler parameters, but their length is 0; give four"),
    Wrong("[1, 0, 0, 0]", "[1, 0, 0]", 8, ROD, "orientation must have 4 entries, but has 3; give 4"),
    Wrong(
        "[1, 0, 0, 0]", "[1e308, 1e308, 0, 0]", 8, ROD, "orientation is too large, it is 1e+308; give four"
    ),
    Wrong(
        "[1, 0, 0, 0]", TURNED, 8, ROD, "right-handed rotation matrix, but its determinant is -1; turn one"
    ),
    Wrong(
        "[1, 0, 0, 0]",
        "[[1, 0, 0], [0, 2, 0], [0, 0, 1]]",
        8,
        ROD,
        "are not perpendicular unit vectors; give",
    ),
    Wrong(
        "[1, 0, 0, 0]", "{axis: [0, 0, 0], angle: 1}", 8, ROD, "orientation axis has zero length; give three"
    ),
    Wrong("[1, 0, 0, 0]", "{axis: [0, 0, 1]}", 8, ROD, "orientation.angle is missing; add it"),
    Wrong("[1, 0, 0, 0]", "{axes: [0, 0, 1], angle: 1}", 8, ROD, 'has no key "axes"; did you mean "axis"?'),
    Wrong(
        "[1, 0, 0, 0]", "{angles: [1, 2, 3], sequence: xxy}", 8, ROD, 'like "xyz" or "zxz", but is "xxy"; no'
    ),
    Wrong(
        "position: [0, 1, 0]", "position: [0, 1]", 7, ROD, "position must have 3 entries, but has 2; give 3"
    ),
    Wrong(
        "position: [0, 1, 0]", "position: [0, 1, .inf]", 7, ROD, "position[2] must be a finite number, but"
    ),
    Wrong("position: [0, 1, 0]", "position: 0 1 0", 7, ROD, 'has the unknown point "0 1 0"; define it'),
    Wrong("position: [0, 1, 0]", "positon: [0, 1, 0]", 7, ROD, 'no key "positon"; did you mean "position"?'),
    Wrong(
        "position: [0, 1, 0]", "velocity: {x: 1}", 7, ROD, "velocity must be a list, but is a mapping; write"
    ),
    # keys and names
    Wrong(
        "    mass: 1.0\n",
        "    mass: 1.0\n    mass: 2.0\n",
        11,
        BOB,
        'the key "mass" is given twice, the first',
    ),
    Wrong(
        "  bob:\n", "  rod:\n", 9, ROD, 'the key "rod" is given twice, the first time on line 4; remove one'
    ),
    Wrong("  spring:\n", "  pin:\n", 32, 'force "pin"', "is taken by another of the joints; rename one"),
    Wrong("  cross:\n", "  ground:\n", 19, 'joint "ground"', "is taken by the ground; rename one of them"),
    Wrong(
        "  wheel:\n",
        "  left wheel:\n",
        44,
        'force "left wheel"',
        'starting with a letter, but is "left wheel"; r',
    ),
    Wrong("  wheel:\n", "  7:\n", 44, 'force "7"', "its name must be letters, digits, _ and -, starting"),
    Wrong("name: pendulum\n", 'name: ""\n', 1, "model", "name must be a text on one line"),
    Wrong("name: pendulum", "name: 5", 1, "model", "name must be a text, but is 5.0; put it in quotes"),
    Wrong("name: pendulum", "name: ''", 1, "model", 'name must be a text on one line, but is ""; name it'),
    Wrong(
        "name: pendulum", 'name: "a\\nb"', 1, "model", r'name must be a text on one line, but is "a\nb"; name'
    ),
    Wrong("forces:", "force:", 31, "model", 'has no key "force"; did you mean "forces"?'),
    Wrong(
        "gravity: [0, 0, -9.81]", "gravity: -9.81", 2, "model", "gravity must be a list, but is -9.81; write"
    ),
    # joints
    Wrong("bodies: [ground, rod]", "bodies: [ground, rd]", 16, PIN, 'no body "rd"; did you mean "rod"?'),
    Wrong(
        "bodies: [ground, rod]", "bodies: [ground, pin]", 16, PIN, 'no body "pin"; choose from ground, rod'
    ),
    Wrong(
        "bodies: [ground, rod]", "bodies: [rod, rod]", 16, PIN, 'connects "rod" to itself; name two different'
    ),
    Wrong("bodies: [ground, rod]", "bodies: [rod]", 16, PIN, "bodies must have 2 entries, but has 1; give 2"),
    Wrong(
        "bodies: [ground, rod]",
        "bodies: rod",
        16,
        PIN,
        'bodies must be a list, but is "rod"; write two names in',
    ),
    Wrong(
        "bodies: [ground, rod]",
        "bodies: [ground, 1]",
        16,
        PIN,
        "bodies[1] must be a text, but is 1.0; put it",
    ),
    Wrong(
        "    bodies: [ground, rod]\n", "", 14, PIN, "its bodies are missing; name the two bodies it connects"
    ),
    Wrong("    axis: [1, 0, 0]", "    axis: [0, 0, 0]", 18, PIN, "axis has zero length; give three numbers"),
    Wrong("    axis: [1, 0, 0]", "    axis: [1, 0]", 18, PIN, "axis must have 3 entries, but has 2; give 3"),
    Wrong("    axis: [1, 0, 0]", "    axs: [1, 0, 0]", 18, PIN, 'has no key "axs"; did you mean "axis"?'),
    Wrong("    axis: [1, 0, 0]\n", "", 14, PIN, "axis is missing; give point and axis in global axes, or"),
    Wrong("    axis: [1, 0, 0]", "    frames: []", 18, PIN, "frames must have 2 entries, but has 0; give 2"),
    Wrong("type: revolute", "type: revolut", 15, PIN, 'unknown type "revolut"; did you mean "revolute"?'),
    Wrong("    type: revolute\n", "", 14, PIN, "type is missing; add it, as in type: revolute"),
    Wrong("type: revolute", "type: 3", 15, PIN, "unknown type"),
    Wrong("type: revolute", "type: [revolute]", 15, PIN, "unknown type"),
    Wrong(
        "axis_j: [0, 0, 1]", "axis_j: [1, 0, 1]", 23, CROSS, "must be perpendicular, but the cosine between"
    ),
    Wrong("axis_j: [0, 0, 1]", "axis_j: [0, 0, 0]", 24, CROSS, "axis_j has zero length; give three numbers"),
    Wrong(
        "global: [0, 9, 0]", "global: [0, 5, 0]", 28, STAY, "its two points coincide; move one of them, or"
    ),
    Wrong("length: 4.0", "length: 0", 30, STAY, "length must be greater than 0, but is 0.0; give the length"),
    Wrong(
        "length: 4.0", "length: -4", 30, STAY, "length must be greater than 0, but is -4.0; give the length"
    ),
    Wrong("length: 4.0", "length:", 30, STAY, "length must be a number, but is empty; write it as in"),
    Wrong(
        "{body: ground, global: [0, 9, 0]}",
        "{body: bob, at: [0, 9, 0]}",
        29,
        STAY,
        'connects "bob" to itself',
    ),
    Wrong(
        "{body: bob, at: [0, 1, 0]}",
        "{body: bb, at: [0, 1, 0]}",
        28,
        STAY,
        'no body "bb"; did you mean "bob"',
    ),
    Wrong("global: [0, 9, 0]}", "globl: [0, 9, 0]}", 29, STAY, 'no key "globl"; did you mean "global"?'),
    Wrong(", global: [0, 9, 0]}", "}", 29, STAY, "must have one of the keys at and global; give at"),
    Wrong(
        "global: [0, 9, 0]}",
        "global: [0, 9, 0], at: [0, 0, 0]}",
        29,
        STAY,
        "one of the keys at and global; give",
    ),
    Wrong(
        "{body: ground, global: [0, 9, 0]}",
        "ground",
        29,
        STAY,
        'points[1] must be a mapping, but is "ground"',
    ),
    # forces
    Wrong(
        "at: [0, 9, 0]}", "at: [0, 1, 0]}", 35, SPRING, "has zero length, its two points coincide in the ini"
    ),
    Wrong(
        "{body: ground, at: [0, 9, 0]}", "{body: rod, at: [0, 9, 0]}", 36, SPRING, 'connects "rod" to itself'
    ),
    Wrong("    k: 10.0", "    k: stiff", 37, SPRING, 'k must be a number, but is "stiff"; write it as in'),
    Wrong(
        "    k: 10.0",
        "    k: {table: [[1, 2]]}",
        37,
        SPRING,
        "must have at least 2 entries, but has 1; give at",
    ),
    Wrong(
        "    k: 10.0",
        "    k: {table: [[1, 2], [1, 3]]}",
        37,
        SPRING,
        "must have rising x, but 1.0 follows 1.0; s",
    ),
    Wrong(
        "    k: 10.0",
        "    k: {tabel: [[1, 2], [2, 3]]}",
        37,
        SPRING,
        'has no key "tabel"; did you mean "table"?',
    ),
    Wrong("    k: 10.0", "    k: {table: [[1, 2], [2]]}", 37, SPRING, "k.table[1] must have"),
    Wrong(
        "length: 5.0", "length: -5.0", 38, SPRING, "length must not be negative, but is -5.0; give the free"
    ),
    Wrong("    length: 5.0\n", "", 32, SPRING, "length is missing; add it"),
    Wrong("force: [0, 0, 5]", "force: 5", 42, PUSH, "force must be a list, but is 5.0; write it in brackets"),
    Wrong(
        "{body: rod, at: [0, 1, 0]}",
        "{body: ground, at: [0, 1, 0]}",
        41,
        PUSH,
        "acts on the ground, which does",
    ),
    Wrong(
        "axes: body",
        "axes: bodi",
        43,
        PUSH,
        'must be one of body, global, but is "bodi"; did you mean "body"?',
    ),
    Wrong(
        "radius: 0.5", "radius: 0", 49, WHEEL, "radius must be greater than 0, but is 0.0; give the unloaded"
    ),
    # YAML
    Wrong(
        "mass: 2.0", "mass: *m", 5, ROD, 'uses the alias "*m", but there is no anchor &m above it; write the'
    ),
    Wrong(
        "  rod:\n", "  rod: &loop\n    <<: *loop\n", 5, ROD, 'uses the alias "*loop" inside of its own anchor'
    ),
    Wrong("mass: 2.0", "mass: &m 2.0\n    *m : 3", 6, ROD, "has an alias (*) as key; write the key out"),
    Wrong("mass: 2.0", "<<: 2.0", 5, ROD, "has a merge key (<<) that is no mapping; give an alias of one"),
    Wrong(
        "mass: 2.0", "<<: [{mass: 2}, 3]", 5, ROD, "has a merge key (<<) that is no mapping; give an alias"
    ),
    Wrong("mass: 2.0", "<<: {mas: 2}", 5, ROD, 'has no key "mas"; did you mean "mass"?'),
    Wrong("mass: 2.0", "mass: !!float 2", 5, ROD, "uses a tag (!), which a model file may not; remove it"),
    Wrong(
        "mass: 2.0", "mass: !!python/object/apply:os.getcwd []", 5, ROD, "uses a tag (!), which a model file"
    ),
    Wrong(
        "mass: 2.0", "? [a, b]\n    : 1", 5, ROD, "has a key that is a list or a mapping; use a plain word"
    ),
    Wrong(
        "position: [0, 1, 0]", f"position: {DEEP}", 7, ROD, "is nested deeper than 64 levels; remove brackets"
    ),
    Wrong(
        "position: [0, 1, 0]", "position: " + "[" * 200_000, 7, ROD, "is nested deeper than 64 levels; remove"
    ),
    Wrong("position: [0, 1, 0]", "position: [0, 1, 0", 8, "model", "is not valid YAML,"),
    Wrong(
        "    mass: 2.0",
        "\tmass: 2.0",
        5,
        "model",
        "is not valid YAML, found character '\\t' that cannot start",
    ),
    Wrong("mass: 2.0", 'mass: "2.0', 50, "model", "is not valid YAML, found unexpected end of stream; check"),
    Wrong(
        "mass: 2.0", "mass: 2.0 \x07", 5, "model", "holds a control character that YAML does not allow; rem"
    ),
    Wrong("joints:", "---\njoints:", 13, "model", "a second document starts with ---; keep one model in a"),
]


def check(error: ModelError, file: str, wrong: Wrong) -> None:
    """Assert that a message is one sentence with file, line, part, phrase and remedy."""
    told = str(error)
    assert told.startswith(f"{file}:{wrong.line}: {wrong.part}: "), told
    assert wrong.phrase in told
    check_sentence(told)


def check_sentence(told: str) -> None:
    """Assert that a message is one line, one sentence, and has a remedy after a semicolon."""
    assert told.isprintable()
    assert ". " not in told
    assert len(told) < 320
    assert len(told.split("; ", 1)[1]) > 5


def test_the_model_without_an_edit_is_right(tmp_path: Path) -> None:
    (tmp_path / "right.yaml").write_text(MODEL)
    assert load(tmp_path / "right.yaml").name == "pendulum"


@pytest.mark.parametrize("wrong", EDITS, ids=lambda wrong: f"{wrong.line}:{wrong.new.strip()[:30]}")
def test_an_edit_is_refused(wrong: Wrong, tmp_path: Path) -> None:
    file = tmp_path / "wrong.yaml"
    assert wrong.old in MODEL
    file.write_text(MODEL.replace(wrong.old, wrong.new, 1), encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        load(file)
    check(caught.value, str(file), wrong)


NOT_YAML = [
    ("", "is empty; give at least a name and bodies"),
    (" \n\n", "is empty; give at least a name and bodies"),
    ("# only a comment\n", "is empty; give at least a name and bodies"),
    ("just a word", 'must be a mapping, but is "just a word"; give keys'),
    ("- a\n- b\n", "must be a mapping, but is a list; give keys"),
    ("name: a\nbodies:\n", "bodies must be a mapping, but is empty; give keys"),
    ("name: a\nbodies: {}\n", "has no bodies; give at least one"),
    ("name: a\nbodies: [rod]\n", "bodies must be a mapping, but is a list; give keys"),
    ("name: a\nbodies: {rod: 3}\n", 'body "rod": must be a mapping, but is 3.0; give keys'),
    ("name: a\n", "bodies is missing; add it"),
    ("%YAML 9.9\n---\n", "is not valid YAML"),
    ("a: b: c\n", "is not valid YAML"),
    ("a: @b\n", "is not valid YAML"),
    ("&a [*a, *a]\n", 'uses the alias "*a" inside of its own anchor'),
    ("{" * 200_000, "has a key that is a list or a mapping; use a plain word as key"),
    ("- " * 100_000, "is nested deeper than 64 levels"),
    ("\n".join(" " * n + "a:" for n in range(200)), "is nested deeper than 64 levels"),
]


@pytest.mark.parametrize(("text", "phrase"), NOT_YAML, ids=lambda text: text[:20])
def test_a_text_that_is_no_model_is_refused(text: str, phrase: str, tmp_path: Path) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(text)
    with pytest.raises(ModelError) as caught:
        load(file)
    assert phrase in str(caught.value)
    assert str(caught.value).startswith(str(file))
    check_sentence(str(caught.value))


BYTES = [
    ("m.yaml", b"\x7fELF\x02\x01\x01\x00\x00", "is binary, not text; give a YAML or JSON file in UTF-8"),
    ("m.yaml", "name: é".encode("utf-16"), "is binary, not text; give a YAML or JSON file in UTF-8"),
    ("m.yaml", "name: x\nnote: é".encode("latin-1"), "m.yaml:2: is not UTF-8 text; save it as UTF-8"),
    ("m.json", b"", "is empty; give at least a name and bodies"),
    ("m.toml", b"name = 'x'", "must end in .yaml, .yml, .json; rename it"),
    ("m", b"name: x", "must end in .yaml, .yml, .json; rename it"),
    ("m.yaml", b" " * (16 * 2**20 + 1), "is larger than 16 MB; build such a model in Python"),
]


@pytest.mark.parametrize(("name", "content", "phrase"), BYTES, ids=range(len(BYTES)))
def test_a_file_that_is_no_text_is_refused(name: str, content: bytes, phrase: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ModelError) as caught:
        load(tmp_path / name)
    assert phrase in str(caught.value)
    check_sentence(str(caught.value))


def test_a_path_that_is_no_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.yaml").mkdir()
    phrases = {
        "none.yaml": "does not exist; check the path",
        "folder.yaml": "is a directory; give the path of a file in it",
        "a\0b.yaml": "cannot be read, embedded null",
        "a" * 5000 + ".yaml": "cannot be read, file name too long; check the path",
        "none.yaml/m.yaml": "does not exist; check the path",
    }
    for name, phrase in phrases.items():
        with pytest.raises(ModelError, match=phrase):
            load(f"{tmp_path}/{name}")


def as_json() -> str:
    """Return a small model as JSON, one entry on a line."""
    rod = {"mass": 2.0, "inertia": [1, 1, 1]}
    pin = {"type": "spherical", "bodies": ["ground", "rod"], "point": [0, 0, 0]}
    return json.dumps({"name": "a", "bodies": {"rod": rod}, "joints": {"pin": pin}}, indent=1)


JSON_EDITS = [
    Wrong(
        '"mass": 2.0', '"mass": -2', 5, ROD, "mass must be greater than 0, but is -2.0; give the mass in kg"
    ),
    Wrong('"mass": 2.0', '"mass": NaN', 5, ROD, "mass must be a finite number, but is nan; check its size"),
    Wrong('"mass": 2.0', '"mass": -Infinity', 5, ROD, "mass must be a finite number, but is -inf; check its"),
    Wrong('"mass": 2.0', '"mass": 1e999', 5, ROD, "mass must be a finite number, but is inf; check its size"),
    Wrong(
        '"mass": 2.0', '"mass": 010', 5, "model", "is not valid JSON, a value is missing or not valid; check"
    ),
    Wrong(
        '"mass": 2.0', '"mass": +1', 5, "model", "is not valid JSON, a value is missing or not valid; check"
    ),
    Wrong(
        '"mass": 2.0', '"mass": 1.', 5, "model", "is not valid JSON, a value is missing or not valid; check"
    ),
    Wrong('"mass": 2.0', '"mass": null', 5, ROD, "mass must be a number, but is empty; write it as in"),
    Wrong('"mass": 2.0', '"mass": "2"', 5, ROD, 'mass must be a number, but is "2"; write it without quotes'),
    Wrong(
        '"mass": 2.0',
        '"mass": 1, "mass": 2',
        5,
        ROD,
        'the key "mass" is given twice, the first time on line 5',
    ),
    Wrong(
        '"mass": 2.0', "mass: 2.0", 5, "model", "is not valid JSON, a text in double quotes is missing; check"
    ),
    Wrong('"mass": 2.0,', '"mass": 2.0', 6, "model", 'is not valid JSON, a "," is missing; check commas'),
    Wrong('"mass": 2.0', '"mass" 2.0', 5, "model", 'is not valid JSON, a ":" is missing; check commas'),
    Wrong(
        '"mass": 2.0', '"mass": 2.0 // kg', 5, "model", 'is not valid JSON, a "," is missing; check commas'
    ),
    Wrong(
        '"mass": 2.0', '"mass": ' + "[" * 200_000, 5, ROD, "is nested deeper than 64 levels; remove brackets"
    ),
    Wrong('"name": "a"', '"name": "a', 2, "model", "is not valid JSON, invalid control character"),
    Wrong('"name": "a"', r'"name": "\ud800"', 2, "model", "name must be a text on one line, but is"),
    Wrong('"name": "a"', r'"name": "\q"', 2, "model", "is not valid JSON, invalid \\escape"),
    Wrong('"rod"\n', '"rd"\n', 18, 'joint "pin"', 'there is no body "rd"; did you mean "rod"?'),
]


def test_the_json_model_without_an_edit_is_right(tmp_path: Path) -> None:
    (tmp_path / "right.json").write_text(as_json())
    assert load(tmp_path / "right.json").where("pin") == f"{tmp_path / 'right.json'}:14"


@pytest.mark.parametrize("wrong", JSON_EDITS, ids=lambda wrong: wrong.new.strip()[:30])
def test_a_json_edit_is_refused(wrong: Wrong, tmp_path: Path) -> None:
    file = tmp_path / "wrong.json"
    assert wrong.old in as_json()
    file.write_text(as_json().replace(wrong.old, wrong.new, 1))
    with pytest.raises(ModelError) as caught:
        load(file)
    check(caught.value, str(file), wrong)


@pytest.mark.parametrize("text", ["{} {}", "[", "{", '{"a"', '{"a": }', "nope", "'a'", "[1,]"])
def test_broken_json_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "wrong.json").write_text(text)
    with pytest.raises(ModelError, match="is not valid JSON"):
        load(tmp_path / "wrong.json")


def test_the_first_of_several_errors_says_how_many_follow(tmp_path: Path) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(
        MODEL.replace("mass: 2.0", "mass: x").replace("length: 5.0", "lenght: 5").replace("c: 10.0", "")
    )
    with pytest.raises(ModelError, match=r'body "rod": mass must be .* \(and 2 more\)$'):
        load(file)
    file.write_text(MODEL.replace("mass: 2.0", "mass: -2").replace("mass: 1.0", "mass: -1"))
    with pytest.raises(ModelError, match=r'body "rod": mass must be .* \(and 1 more\)$'):
        load(file)


def test_no_damage_to_a_file_gives_another_exception(tmp_path: Path) -> None:
    """Cut the file at every place, and put every sign of YAML everywhere on a line of each kind."""
    file = tmp_path / "damaged.yaml"
    damaged = [MODEL[:n] for n in range(0, len(MODEL), 7)]
    damaged += [
        MODEL[:n] + sign + MODEL[n:] for n in range(3, len(MODEL), 23) for sign in "[]{}:,-?!&*#|>%@`'\"\t\0"
    ]
    for text in damaged:
        file.write_text(text)
        try:
            load(file)
        except ModelError as error:
            check_sentence(str(error))
