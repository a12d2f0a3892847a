"""A wrong force in a model file is refused by one sentence: file, line, part, what is wrong, remedy."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.model.test_malformed import Wrong, check

from sarrus.model import ModelError, load

MODEL = """\
name: forces
bodies:
  a: {mass: 1.0, inertia: [1, 1, 1]}
  b: {mass: 1.0, inertia: [1, 1, 1], position: [0, 0, 1]}
forces:
  mount:
    type: bushing
    bodies: [a, b]
    point: [0, 0, 0]
    stiffness: [1, 2, 3, 4, 5, 6]
    damping: [[1,0,0,0,0,0], [0,1,0,0,0,0], [0,0,1,0,0,0], [0,0,0,1,0,0], [0,0,0,0,1,0], [0,0,0,0,0,1]]
    preload: [0, 0, 9, 0, 0, 0]
  rope:
    type: length_stop
    points: [{body: a, at: [0, 0, 0]}, {body: b, at: [0, 0, 0]}]
    stiffness: 1e5
    exponent: 1.5
    upper: 2.0
  end:
    type: displacement_stop
    frames: [{body: a, at: [0, 0, 0]}, {body: b, at: [0, 0, 0]}]
    stiffness: 1e5
    damping: 0.2
    lower: -1.0
    upper: 1.0
  latch: {type: angle_stop, bodies: [a, b], point: [0, 0, 0], axis: [0, 0, 1], stiffness: 10, lower: 0.5}
  floor:
    type: sphere_contact
    center: {body: a, at: [0, 0, 0]}
    plane: {body: ground, at: [0, 0, -1], z: [0, 0, 1]}
    stiffness: 1e5
    radius: 0.1
    mu: 0.3
    creep: 1e-3
  pin: {type: angle_friction, bodies: [a, b], point: [0, 0, 0], axis: [0, 0, 1], radius: 0.01, load: 5, mu: 0.2}
  rail: {type: displacement_friction, bodies: [a, b], point: [0,0,0], axis: [0,0,1], load: 5, mu: 0.2, mu_static: 0.3}
  air: {type: drag, point: {body: a, at: [0, 0, 0]}, c: 0.3, wind: [1, 0, 0]}
  oil: {type: viscous_drag, point: {body: a, at: [0, 0, 0]}, c: 0.4, c_turn: 0.1}
  wheel:
    type: road_tyre
    point: {body: a, at: [0, 0, 0]}
    k: 1000.0
    c: 10.0
    radius: 0.5
    road: {table: [[0, 0], [1, 0.1], [2, 0]]}
    bump: 0.05
  push:
    type: point_force
    point: {body: a, at: [0, 0, 0]}
    force: [1, {table: [[0, 0], [1, 1]]}, 0]
  twist:
    type: torque
    body: a
    torque: [1, 0, 0]
    factor: {table: [[0, 0], [1, 1]]}
  coil:
    type: rsda
    bodies: [a, b]
    point: [0, 0, 0]
    axis: [0, 0, 1]
    k: {table: [[-1, 5], [0, 4], [1, 5]]}
"""

MOUNT, ROPE, END, LATCH = 'force "mount"', 'force "rope"', 'force "end"', 'force "latch"'
FLOOR, PIN, RAIL, AIR, OIL = 'force "floor"', 'force "pin"', 'force "rail"', 'force "air"', 'force "oil"'
WHEEL, PUSH, TWIST, COIL = 'force "wheel"', 'force "push"', 'force "twist"', 'force "coil"'

EDITS = [
    Wrong("[1, 2, 3, 4, 5, 6]", "[1, 2, 3]", 10, MOUNT, "stiffness must have 6 entries, but has 3. Give 6"),
    Wrong(
        "[1, 2, 3, 4, 5, 6]",
        "[[1, 2, 3, 4, 5, 6]]",
        10,
        MOUNT,
        "stiffness must have 6 entries, but has 1. Give 6",
    ),
    Wrong("[[1,0,0,0,0,0]", "[[1,0,0,0,0]", 11, MOUNT, "damping[0] must have 6 entries, but has 5. Give 6"),
    Wrong("    stiffness: [1, 2, 3, 4, 5, 6]\n", "", 6, MOUNT, "stiffness is missing. Add it"),
    Wrong("[0, 0, 9, 0, 0, 0]", "[0, 0, 9]", 12, MOUNT, "preload must have 6 entries, but has 3. Give 6"),
    Wrong("[0, 0, 9, 0, 0, 0]", "[0, 0, x, 0, 0, 0]", 12, MOUNT, 'preload[2] must be a number, but is "x"'),
    Wrong("upper: 2.0", "upper: .nan", 18, ROPE, "upper must be a finite number, but is nan"),
    Wrong("    upper: 2.0\n", "", 13, ROPE, "has no limit. Give lower, upper or both"),
    Wrong(
        "exponent: 1.5",
        "exponent: 0.5",
        17,
        ROPE,
        "exponent must be at least 1, but is 0.5. Give 1 for a linear",
    ),
    Wrong(
        "stiffness: 1e5\n    exponent",
        "stiffness: 0\n    exponent",
        16,
        ROPE,
        "stiffness must be greater than 0, but is 0.0",
    ),
    Wrong(
        "{body: b, at: [0, 0, 0]}]\n    stiffness: 1e5\n    exp",
        "{body: b, at: [0, 0, -1]}]\n    stiffness: 1e5\n    exp",
        15,
        ROPE,
        "has zero length",
    ),
    Wrong(
        "lower: -1.0",
        "lower: 1.5",
        24,
        END,
        "has a lower limit that is not below the upper one. Exchange them",
    ),
    Wrong(
        "damping: 0.2", "damping: -0.2", 23, END, "damping must not be negative, but is -0.2. Give it in s/m"
    ),
    Wrong(
        "damping: 0.2",
        "rounding: 0",
        23,
        END,
        "rounding must be greater than 0, but is 0.0. Give a small depth",
    ),
    Wrong("lower: 0.5}", "uper: 0.5}", 26, LATCH, 'has no key "uper". Did you mean "upper"?'),
    Wrong("body: ground, at: [0, 0, -1]", "body: a, at: [0, 0, -1]", 30, FLOOR, 'connects "a" to itself'),
    Wrong("z: [0, 0, 1]}", "z: [0, 0, 0]}", 30, FLOOR, "plane has zero length"),
    Wrong("radius: 0.1", "radius: -0.1", 32, FLOOR, "radius must not be negative, but is -0.1"),
    Wrong("mu: 0.3\n", "mu: -1\n", 33, FLOOR, "mu must not be negative, but is -1.0. Give the coefficient"),
    Wrong(
        "creep: 1e-3", "creep: 0", 34, FLOOR, "creep must be greater than 0, but is 0.0. Give a small speed"
    ),
    Wrong(
        "radius: 0.01",
        "radius: 0",
        35,
        PIN,
        "radius must be greater than 0, but is 0.0. Give the pin's radius",
    ),
    Wrong(
        "load: 5, mu: 0.2}",
        "load: -5, mu: 0.2}",
        35,
        PIN,
        "load must not be negative, but is -5.0. Give the normal",
    ),
    Wrong("mu_static: 0.3", "mu_static: -0.3", 36, RAIL, "mu_static must not be negative, but is -0.3"),
    Wrong("mu_static: 0.3", "stribeck: 0", 36, RAIL, "stribeck must be greater than 0, but is 0.0"),
    Wrong(", c: 0.3", ", c: -0.3", 37, AIR, "c must not be negative, but is -0.3. Give it in N s²/m²"),
    Wrong("wind: [1, 0, 0]", "wind: [1, 0]", 37, AIR, "wind must have 3 entries, but has 2. Give 3"),
    Wrong(
        "body: a, at: [0, 0, 0]}, c: 0.4",
        "body: ground, at: [0, 0, 0]}, c: 0.4",
        38,
        OIL,
        "acts on the ground, which does not move",
    ),
    Wrong("c_turn: 0.1", "c_turn: -0.1", 38, OIL, "c_turn must not be negative, but is -0.1"),
    Wrong("k: 1000.0", "k: 0", 42, WHEEL, "k must be greater than 0, but is 0.0. Give the stiffness in N/m"),
    Wrong("[2, 0]]}", "[1, 0]]}", 45, WHEEL, "table must have rising x, but 1.0 follows 1.0"),
    Wrong("bump: 0.05", "bump: high", 46, WHEEL, 'bump must be a number, but is "high"'),
    Wrong(
        "force: [1, {table: [[0, 0], [1, 1]]}, 0]",
        "force: [1, 0]",
        50,
        PUSH,
        "force must have 3 entries, but has 2",
    ),
    Wrong(
        "force: [1, {table: [[0, 0], [1, 1]]}, 0]",
        "force: [1, {tabel: []}, 0]",
        50,
        PUSH,
        'force[1] has no key "tabel"',
    ),
    Wrong(
        "torque: [1, 0, 0]",
        "torque: [{table: [[0, 0], [1, 1]]}, 0, 0]",
        55,
        TWIST,
        "has both a factor and components of its torque that vary",
    ),
    Wrong("{table: [[-1, 5]", "{table: [[1, 5]", 61, COIL, "table must have rising x, but 0.0 follows 1.0"),
]


def test_the_model_without_an_edit_is_right(tmp_path: Path) -> None:
    (tmp_path / "right.yaml").write_text(MODEL)
    assert len(load(tmp_path / "right.yaml").forces) == 13


@pytest.mark.parametrize("wrong", EDITS, ids=lambda wrong: f"{wrong.line}-{wrong.new[:20]}")
def test_an_edit_is_refused(wrong: Wrong, tmp_path: Path) -> None:
    file = tmp_path / "wrong.yaml"
    assert wrong.old in MODEL
    file.write_text(MODEL.replace(wrong.old, wrong.new, 1))
    with pytest.raises(ModelError) as caught:
        load(file)
    check(caught.value, str(file), wrong)
