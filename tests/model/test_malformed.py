"""A wrong model file is refused by one sentence: file, line, part, what is wrong, remedy."""

from __future__ import annotations

import json
import re
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
    Wrong("mass: 2.0", "mass: -1.0", 5, ROD, "mass must be greater than 0, but is -1.0. Give the mass in kg"),
    Wrong("mass: 2.0", "mass: 0", 5, ROD, "mass must be greater than 0, but is 0.0. Give the mass in kg"),
    Wrong("mass: 2.0", "mass: .nan", 5, ROD, "mass must be a finite number, but is nan. Check its size"),
    Wrong("mass: 2.0", "mass: -.inf", 5, ROD, "mass must be a finite number, but is -inf. Check its size"),
    Wrong("mass: 2.0", "mass: 1e999", 5, ROD, "mass must be a finite number, but is inf. Check its size"),
    Wrong("mass: 2.0", "mass: " + "9" * 5000, 5, ROD, "mass must be a finite number, but is inf. Check"),
    Wrong(
        "mass: 2.0", "mass: two", 5, ROD, 'mass must be a number, but is "two". Write it as in 1.5e-3, 20 mm'
    ),
    Wrong("mass: 2.0", 'mass: "2.0"', 5, ROD, 'mass must be a number, but is "2.0". Write it without quotes'),
    Wrong("mass: 2.0", "mass: 2 m", 5, ROD, 'mass expects kg, but "2 m" is in m. Give it in kg, or omit'),
    Wrong("mass: 2.0", "mass: 0x10", 5, ROD, 'mass has the unknown unit "x10". Choose from'),
    Wrong("mass: 2.0", "mass: 1_000", 5, ROD, 'mass has the unknown unit "_000". Choose from'),
    Wrong("mass: 2.0", "mass: 1:30", 5, ROD, 'mass holds ":", which no formula has. Check "1:30"'),
    Wrong("mass: 2.0", "mass: true", 5, ROD, "mass must be a number, but is true. Write it as in"),
    Wrong("mass: 2.0", "mass: on", 5, ROD, 'mass must be a number, but is "on". Write it as in'),
    Wrong("mass: 2.0", "mass:", 5, ROD, "mass must be a number, but is empty. Write it as in"),
    Wrong("mass: 2.0", "mass: [2.0]", 5, ROD, "mass must be a number, but is a list. Write it as in"),
    Wrong("mass: 2.0", "mass: {kg: 2}", 5, ROD, "mass must be a number, but is a mapping. Write it as in"),
    Wrong("    mass: 2.0\n", "", 4, ROD, "mass is missing. Add it"),
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
        "[1.0, 1.0, 0.5]", "[[1, 0, 0], [0, 1, 0]]", 6, ROD, "inertia must have 3 entries, but has 2. Give 3"
    ),
    Wrong("[1.0, 1.0, 0.5]", "[[1, 0], [0, 1], [0, 0]]", 6, ROD, "inertia[0] must have 3 entries, but has 2"),
    Wrong("[1.0, 1.0, 0.5]", "[1.0, 1.0]", 6, ROD, "inertia must have 3 entries, but has 2. Give 3"),
    Wrong("[1.0, 1.0, 0.5]", "1.0", 6, ROD, "is 1.0. Write it in brackets, as in [1, 1, 1]"),
    Wrong("zz: 0.5}", "zz: 0.5, yx: 0}", 11, BOB, 'inertia has no key "yx". Choose from xx, yy, zz,'),
    Wrong(", zz: 0.5}", "}", 11, BOB, "inertia.zz is missing. Add it"),
    # bodies: pose
    Wrong(
        "[1, 0, 0, 0]",
        "[1, 0.1, 0, 0]",
        8,
        ROD,
        "unit Euler parameters, but their length is 1.00498756. Give",
    ),
    Wrong("[1, 0, 0, 0]", "[0, 0, 0, 0]", 8, ROD, "unit Euler parameters, but their length is 0. Give four"),
    Wrong("[1, 0, 0, 0]", "[1, 0, 0]", 8, ROD, "orientation must have 4 entries, but has 3. Give 4"),
    Wrong(
        "[1, 0, 0, 0]", "[1e308, 1e308, 0, 0]", 8, ROD, "orientation is too large, it is 1e+308. Give four"
    ),
    Wrong(
        "[1, 0, 0, 0]", TURNED, 8, ROD, "right-handed rotation matrix, but its determinant is -1. Reverse one"
    ),
    Wrong(
        "[1, 0, 0, 0]",
        "[[1, 0, 0], [0, 2, 0], [0, 0, 1]]",
        8,
        ROD,
        "are not perpendicular unit vectors. Give",
    ),
    Wrong(
        "[1, 0, 0, 0]", "{axis: [0, 0, 0], angle: 1}", 8, ROD, "orientation axis has zero length. Give three"
    ),
    Wrong("[1, 0, 0, 0]", "{axis: [0, 0, 1]}", 8, ROD, "orientation.angle is missing. Add it"),
    Wrong("[1, 0, 0, 0]", "{axes: [0, 0, 1], angle: 1}", 8, ROD, 'has no key "axes". Did you mean "axis"?'),
    Wrong(
        "[1, 0, 0, 0]",
        "{angles: [1, 2, 3], sequence: xxy}",
        8,
        ROD,
        'like "xyz" or "zxz", but is "xxy". Let no',
    ),
    Wrong(
        "position: [0, 1, 0]", "position: [0, 1]", 7, ROD, "position must have 3 entries, but has 2. Give 3"
    ),
    Wrong(
        "position: [0, 1, 0]", "position: [0, 1, .inf]", 7, ROD, "position[2] must be a finite number, but"
    ),
    Wrong("position: [0, 1, 0]", "position: 0 1 0", 7, ROD, 'has the unknown point "0 1 0". Define it'),
    Wrong("position: [0, 1, 0]", "positon: [0, 1, 0]", 7, ROD, 'no key "positon". Did you mean "position"?'),
    Wrong(
        "position: [0, 1, 0]", "velocity: {x: 1}", 7, ROD, "velocity must be a list, but is a mapping. Write"
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
        "  bob:\n", "  rod:\n", 9, ROD, 'the key "rod" is given twice, the first time on line 4. Remove one'
    ),
    Wrong("  spring:\n", "  pin:\n", 32, 'force "pin"', "is taken by another of the joints. Rename one"),
    Wrong("  cross:\n", "  ground:\n", 19, 'joint "ground"', "is taken by the ground. Rename one of them"),
    Wrong(
        "  wheel:\n",
        "  left wheel:\n",
        44,
        'force "left wheel"',
        'starting with a letter, but is "left wheel". R',
    ),
    Wrong("  wheel:\n", "  7:\n", 44, 'force "7"', "its name must be letters, digits, _ and -, starting"),
    Wrong("name: pendulum\n", 'name: ""\n', 1, "model", "name must be a text on one line"),
    Wrong("name: pendulum", "name: 5", 1, "model", "name must be a text, but is 5.0. Put it in quotes"),
    Wrong("name: pendulum", "name: ''", 1, "model", 'name must be a text on one line, but is "". Name it'),
    Wrong(
        "name: pendulum", 'name: "a\\nb"', 1, "model", r'name must be a text on one line, but is "a\nb". Name'
    ),
    Wrong("forces:", "force:", 31, "model", 'has no key "force". Did you mean "forces"?'),
    Wrong(
        "gravity: [0, 0, -9.81]", "gravity: -9.81", 2, "model", "gravity must be a list, but is -9.81. Write"
    ),
    # joints
    Wrong("bodies: [ground, rod]", "bodies: [ground, rd]", 16, PIN, 'no body "rd". Did you mean "rod"?'),
    Wrong(
        "bodies: [ground, rod]", "bodies: [ground, pin]", 16, PIN, 'no body "pin". Choose from ground, rod'
    ),
    Wrong(
        "bodies: [ground, rod]", "bodies: [rod, rod]", 16, PIN, 'connects "rod" to itself. Name two different'
    ),
    Wrong("bodies: [ground, rod]", "bodies: [rod]", 16, PIN, "bodies must have 2 entries, but has 1. Give 2"),
    Wrong(
        "bodies: [ground, rod]",
        "bodies: rod",
        16,
        PIN,
        'bodies must be a list, but is "rod". Write two names in',
    ),
    Wrong(
        "bodies: [ground, rod]",
        "bodies: [ground, 1]",
        16,
        PIN,
        "bodies[1] must be a text, but is 1.0. Put it",
    ),
    Wrong(
        "    bodies: [ground, rod]\n", "", 14, PIN, "its bodies are missing. Name the two bodies it connects"
    ),
    Wrong("    axis: [1, 0, 0]", "    axis: [0, 0, 0]", 18, PIN, "axis has zero length. Give three numbers"),
    Wrong("    axis: [1, 0, 0]", "    axis: [1, 0]", 18, PIN, "axis must have 3 entries, but has 2. Give 3"),
    Wrong("    axis: [1, 0, 0]", "    axs: [1, 0, 0]", 18, PIN, 'has no key "axs". Did you mean "axis"?'),
    Wrong("    axis: [1, 0, 0]\n", "", 14, PIN, "axis is missing. Give point and axis in global axes, or"),
    Wrong("    axis: [1, 0, 0]", "    frames: []", 18, PIN, "frames must have 2 entries, but has 0. Give 2"),
    Wrong("type: revolute", "type: revolut", 15, PIN, 'unknown type "revolut". Did you mean "revolute"?'),
    Wrong("    type: revolute\n", "", 14, PIN, "type is missing. Add it, as in type: revolute"),
    Wrong("type: revolute", "type: 3", 15, PIN, "unknown type"),
    Wrong("type: revolute", "type: [revolute]", 15, PIN, "unknown type"),
    Wrong(
        "axis_j: [0, 0, 1]", "axis_j: [1, 0, 1]", 23, CROSS, "must be perpendicular, but the cosine between"
    ),
    Wrong("axis_j: [0, 0, 1]", "axis_j: [0, 0, 0]", 24, CROSS, "axis_j has zero length. Give three numbers"),
    Wrong(
        "global: [0, 9, 0]", "global: [0, 5, 0]", 28, STAY, "its two points coincide. Move one of them, or"
    ),
    Wrong("length: 4.0", "length: 0", 30, STAY, "length must be greater than 0, but is 0.0. Give the length"),
    Wrong(
        "length: 4.0", "length: -4", 30, STAY, "length must be greater than 0, but is -4.0. Give the length"
    ),
    Wrong("length: 4.0", "length:", 30, STAY, "length must be a number, but is empty. Write it as in"),
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
        'no body "bb". Did you mean "bob"',
    ),
    Wrong("global: [0, 9, 0]}", "globl: [0, 9, 0]}", 29, STAY, 'no key "globl". Did you mean "global"?'),
    Wrong(", global: [0, 9, 0]}", "}", 29, STAY, "must have one of the keys at and global. Give at"),
    Wrong(
        "global: [0, 9, 0]}",
        "global: [0, 9, 0], at: [0, 0, 0]}",
        29,
        STAY,
        "one of the keys at and global. Give",
    ),
    Wrong(
        "{body: ground, global: [0, 9, 0]}",
        "ground",
        29,
        STAY,
        'points[1] must be a point of a body, but is "ground"',
    ),
    # forces
    Wrong(
        "at: [0, 9, 0]}", "at: [0, 1, 0]}", 35, SPRING, "has zero length, its two points coincide in the des"
    ),
    Wrong(
        "{body: ground, at: [0, 9, 0]}", "{body: rod, at: [0, 9, 0]}", 36, SPRING, 'connects "rod" to itself'
    ),
    Wrong("    k: 10.0", "    k: stiff", 37, SPRING, 'k must be a number, but is "stiff". Write it as in'),
    Wrong(
        "    k: 10.0",
        "    k: {table: [[1, 2]]}",
        37,
        SPRING,
        "must have at least 2 entries, but has 1. Give at",
    ),
    Wrong(
        "    k: 10.0",
        "    k: {table: [[1, 2], [1, 3]]}",
        37,
        SPRING,
        "must have rising x, but 1.0 follows 1.0. S",
    ),
    Wrong(
        "    k: 10.0",
        "    k: {tabel: [[1, 2], [2, 3]]}",
        37,
        SPRING,
        'has no key "tabel". Did you mean "table"?',
    ),
    Wrong("    k: 10.0", "    k: {table: [[1, 2], [2]]}", 37, SPRING, "k.table[1] must have"),
    Wrong(
        "length: 5.0", "length: -5.0", 38, SPRING, "length must not be negative, but is -5.0. Give the free"
    ),
    Wrong("    length: 5.0\n", "", 32, SPRING, "length is missing. Add it"),
    Wrong("force: [0, 0, 5]", "force: 5", 42, PUSH, "force must be a list, but is 5.0. Write it in brackets"),
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
        'must be one of body, global, but is "bodi". Did you mean "body"?',
    ),
    Wrong(
        "radius: 0.5", "radius: 0", 49, WHEEL, "radius must be greater than 0, but is 0.0. Give the unloaded"
    ),
    # YAML
    Wrong(
        "mass: 2.0", "mass: *m", 5, ROD, 'uses the alias "*m", but there is no anchor &m above it. Write the'
    ),
    Wrong(
        "  rod:\n", "  rod: &loop\n    <<: *loop\n", 5, ROD, 'uses the alias "*loop" inside of its own anchor'
    ),
    Wrong("mass: 2.0", "mass: &m 2.0\n    *m : 3", 6, ROD, "has an alias (*) as key. Write the key out"),
    Wrong("mass: 2.0", "<<: 2.0", 5, ROD, "has a merge key (<<) that is no mapping. Give an alias of one"),
    Wrong(
        "mass: 2.0", "<<: [{mass: 2}, 3]", 5, ROD, "has a merge key (<<) that is no mapping. Give an alias"
    ),
    Wrong("mass: 2.0", "<<: {mas: 2}", 5, ROD, 'has no key "mas". Did you mean "mass"?'),
    Wrong("mass: 2.0", "mass: !!float 2", 5, ROD, "uses a tag (!), which a model file may not. Remove it"),
    Wrong(
        "mass: 2.0", "mass: !!python/object/apply:os.getcwd []", 5, ROD, "uses a tag (!), which a model file"
    ),
    Wrong(
        "mass: 2.0", "? [a, b]\n    : 1", 5, ROD, "has a key that is a list or a mapping. Use a plain word"
    ),
    Wrong(
        "position: [0, 1, 0]", f"position: {DEEP}", 7, ROD, "is nested deeper than 64 levels. Remove brackets"
    ),
    Wrong(
        "position: [0, 1, 0]", "position: " + "[" * 200_000, 7, ROD, "is nested deeper than 64 levels. Remove"
    ),
    Wrong("position: [0, 1, 0]", "position: [0, 1, 0", 8, "model", "is not valid YAML,"),
    Wrong(
        "    mass: 2.0",
        "\tmass: 2.0",
        5,
        "model",
        "is not valid YAML, found character '\\t' that cannot start",
    ),
    Wrong("mass: 2.0", 'mass: "2.0', 50, "model", "is not valid YAML, found unexpected end of stream. Check"),
    Wrong(
        "mass: 2.0", "mass: 2.0 \x07", 5, "model", "holds a control character that YAML does not allow. Rem"
    ),
    Wrong("joints:", "---\njoints:", 13, "model", "a second document starts with ---. Keep one model in a"),
]


def check(error: ModelError, file: str, wrong: Wrong) -> None:
    """Assert that a message has the shape of all, with file, line, part, phrase and remedy."""
    told = str(error)
    assert told.startswith(f"{file}:{wrong.line}: {wrong.part}: "), told
    assert wrong.phrase in told
    check_message(told)


def check_message(told: str) -> None:
    """Assert that a message is one line, and has a remedy in a second sentence."""
    assert told.isprintable()
    assert len(told) < 320
    assert len(re.split(r"\. (?=[A-Z])", told, maxsplit=1)[1]) > 5


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
    ("", "is empty. Give at least a name and bodies"),
    (" \n\n", "is empty. Give at least a name and bodies"),
    ("# only a comment\n", "is empty. Give at least a name and bodies"),
    ("just a word", 'must be a mapping, but is "just a word". Give keys'),
    ("- a\n- b\n", "must be a mapping, but is a list. Give keys"),
    ("name: a\nbodies:\n", "bodies must be a mapping, but is empty. Give keys"),
    ("name: a\nbodies: {}\n", "has no bodies. Give at least one"),
    ("name: a\nbodies: [rod]\n", "bodies must be a mapping, but is a list. Give keys"),
    ("name: a\nbodies: {rod: 3}\n", 'body "rod": must be a mapping, but is 3.0. Give keys'),
    ("name: a\n", "bodies is missing. Add it"),
    ("%YAML 9.9\n---\n", "is not valid YAML"),
    ("a: b: c\n", "is not valid YAML"),
    ("a: @b\n", "is not valid YAML"),
    ("&a [*a, *a]\n", 'uses the alias "*a" inside of its own anchor'),
    ("{" * 200_000, "has a key that is a list or a mapping. Use a plain word as key"),
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
    check_message(str(caught.value))


BYTES = [
    ("m.yaml", b"\x7fELF\x02\x01\x01\x00\x00", "is binary, not text. Give a YAML or JSON file in UTF-8"),
    ("m.yaml", "name: é".encode("utf-16"), "is UTF-16 text. Save it as UTF-8"),
    ("m.yaml", "name: x\nnote: é".encode("latin-1"), "m.yaml:2: is not UTF-8 text. Save it as UTF-8"),
    ("m.json", b"", "is empty. Give at least a name and bodies"),
    (
        "m.toml",
        b"name = 'x'",
        "must end in .yaml, .yml, .json as a model file, or be a URDF, SDF or MJCF. Rename it",
    ),
    ("m", b"name: x", "bodies is missing. Add it"),
    ("m.yaml", b"\x1f\x8b\x08\x00", "is compressed by gzip. Unpack it first"),
    (
        "m.yaml",
        b"\xef\xbb\xbf<?xml version='1.0'?>\n<!-- a --> <a/>",
        "is XML, not a model file. Read a URDF",
    ),
    ("m.yaml", b" " * (16 * 2**20 + 1), "is larger than 16 MB. Build such a model in Python"),
]


@pytest.mark.parametrize(("name", "content", "phrase"), BYTES, ids=range(len(BYTES)))
def test_a_file_that_is_no_text_is_refused(name: str, content: bytes, phrase: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ModelError) as caught:
        load(tmp_path / name)
    assert phrase in str(caught.value)
    check_message(str(caught.value))


def test_a_path_that_is_no_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.yaml").mkdir()
    phrases = {
        "none.yaml": "does not exist. Check the path",
        "folder.yaml": "is a directory. Give the path of a file in it",
        "a\0b.yaml": "path contains a NUL character",
        "a" * 5000 + ".yaml": "cannot be read, file name too long. Check the path",
        "none.yaml/m.yaml": "does not exist. Check the path",
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
        '"mass": 2.0', '"mass": -2', 5, ROD, "mass must be greater than 0, but is -2.0. Give the mass in kg"
    ),
    Wrong('"mass": 2.0', '"mass": NaN', 5, ROD, "mass must be a finite number, but is nan. Check its size"),
    Wrong('"mass": 2.0', '"mass": -Infinity', 5, ROD, "mass must be a finite number, but is -inf. Check its"),
    Wrong('"mass": 2.0', '"mass": 1e999', 5, ROD, "mass must be a finite number, but is inf. Check its size"),
    Wrong(
        '"mass": 2.0', '"mass": 010', 5, "model", "is not valid JSON, expecting ',' delimiter. Check commas"
    ),
    Wrong('"mass": 2.0', '"mass": +1', 5, "model", "is not valid JSON, expecting value. Check commas"),
    Wrong(
        '"mass": 2.0', '"mass": 1.', 5, "model", "is not valid JSON, expecting ',' delimiter. Check commas"
    ),
    Wrong('"mass": 2.0', '"mass": null', 5, ROD, "mass must be a number, but is empty. Write it as in"),
    Wrong('"mass": 2.0', '"mass": "2"', 5, ROD, 'mass must be a number, but is "2". Write it without quotes'),
    Wrong(
        '"mass": 2.0',
        '"mass": 1, "mass": 2',
        5,
        ROD,
        'the key "mass" is given twice, the first time on line 5',
    ),
    Wrong(
        '"mass": 2.0',
        "mass: 2.0",
        5,
        "model",
        "is not valid JSON, expecting property name enclosed in double",
    ),
    Wrong(
        '"mass": 2.0,', '"mass": 2.0', 6, "model", "is not valid JSON, expecting ',' delimiter. Check commas"
    ),
    Wrong(
        '"mass": 2.0', '"mass" 2.0', 5, "model", "is not valid JSON, expecting ':' delimiter. Check commas"
    ),
    Wrong(
        '"mass": 2.0',
        '"mass": 2.0 // kg',
        5,
        "model",
        "is not valid JSON, expecting ',' delimiter. Check commas",
    ),
    Wrong(
        '"mass": 2.0', '"mass": ' + "[" * 200_000, 5, ROD, "is nested deeper than 64 levels. Remove brackets"
    ),
    Wrong('"name": "a"', '"name": "a', 2, "model", "is not valid JSON, invalid control character"),
    Wrong('"name": "a"', r'"name": "\ud800"', 2, "model", "name must be a text on one line, but is"),
    Wrong('"name": "a"', r'"name": "\q"', 2, "model", "is not valid JSON, invalid \\escape"),
    Wrong('"rod"\n', '"rd"\n', 18, 'joint "pin"', 'there is no body "rd". Did you mean "rod"?'),
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
            check_message(str(error).replace(str(tmp_path), "folder"))
