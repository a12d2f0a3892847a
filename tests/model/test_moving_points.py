"""Points of the ground that move by formulas, in forces and joints, against SciPy and against moved bodies."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sarrus as sr
from sarrus.functions import cos

BLOCK = sr.Body("block", mass=2, inertia=(0.1, 0.1, 0.1), position=(0, 0, 0.5))
SLIDE = sr.Translational("slide", sr.ground, BLOCK, point=(0, 0, 0), axis=(0, 0, 1))
PATH = "0.02*(1 - cos(7*t))"


def rig(z: Any = PATH) -> sr.System:
    """A block on a spring and damper above a road that moves."""
    spring = sr.TSDA("spring", sr.ground.point(0, 0, z), BLOCK.point(0, 0, 0), k=200, c=3, length=0.6)
    return sr.System(sr.Model("rig", [BLOCK], [SLIDE], [spring], gravity=(0, 0, -9.81)))


def test_a_road_under_a_spring_against_scipy() -> None:
    def rates(t: float, y: Any) -> Any:
        road, speed = 0.02 * (1 - np.cos(7 * t)), 0.14 * np.sin(7 * t)
        return y[1], (-200 * (y[0] - road - 0.6) - 3 * (y[1] - speed)) / 2 - 9.81

    run = sr.simulate(rig(), until=1.0, store="steps")
    exact = solve_ivp(rates, (0, 1), (0.5, 0), rtol=1e-11, atol=1e-12).y[0, -1]
    assert run["block.z"][-1] == pytest.approx(exact, abs=2e-9)
    assert run["energy.kinetic"][-1] == pytest.approx(run["block.velocity.z"][-1] ** 2, rel=1e-12)
    assert not run.warnings
    size = "spring_point_i_motion.z.1"
    slope = sr.sensitivity(run, "block.z", [size])[size]
    low, high = (sr.simulate(rig(f"{d}*(1 - cos(7*t))"), until=1.0)["block.z"][-1] for d in (0.019, 0.021))
    assert slope == pytest.approx((high - low) / 0.002, rel=1e-6)  # linear in it


@pytest.mark.parametrize("z", [lambda t: 0.02 * (1 - cos(7 * t)), sr.parse_expression(PATH, ["t"])])
def test_functions_and_expressions(z: Any) -> None:
    given = sr.simulate(rig(z), until=0.2)["block.z"]
    assert np.allclose(given, sr.simulate(rig(), until=0.2)["block.z"], rtol=0, atol=1e-12)


def test_joints_on_a_shaker(tmp_path: Path) -> None:
    rod = sr.Body("rod", mass=1, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    pivot = ("0.1*sin(5*t)", 0, 0)
    joints = [
        sr.Revolute("pin", sr.ground, rod, point=pivot, axis=(0, 1, 0)),
        sr.Revolute(
            "pin",
            frame_i=sr.ground.frame(sr.ground.point(*pivot), z=(0, 1, 0)),
            frame_j=rod.frame((-0.5, 0, 0), z=(0, 1, 0)),
        ),
    ]
    ends = []
    for joint in joints:
        model = sr.Model("shaken", [rod], [joint], gravity=(0, 0, -9.81))
        run = sr.simulate(sr.System(model), until=0.5)
        assert run["rod(-0.5, 0, 0).x"] == pytest.approx(0.1 * np.sin(5 * run.t), abs=1e-9)
        ends.append(run["rod.x"])
        model.save(tmp_path / "shaken.yaml")
        again = sr.System(sr.load(tmp_path / "shaken.yaml"))
        assert np.array_equal(again.b, sr.System(model).b)
    assert np.allclose(*ends, rtol=0, atol=1e-8)


FILE = """\
# a rig
name: rig
gravity: [0, 0, -9.81]
parameters:
  amplitude: 20 mm  # of the road
  place: 0.3 m
points: {A: [0, 0, 0]}
bodies:
  block: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.5]}
  rod: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1.5, 0, 0]}
joints:
  slide: {type: translational, bodies: [ground, block], point: A, axis: [0, 0, 1]}
  pin: {type: revolute, bodies: [ground, rod], point: ["1 + amplitude*sin(5*t)", 0, 0], axis: [0, 1, 0]}
forces:
  spring:  # on the road
    type: tsda
    points: [{body: ground, at: [place, 0, "amplitude*(1 - cos(7*t))"]}, {body: block, at: [0, 0, 0]}]
    k: 200
    c: 3
    length: 0.6
"""


def in_file(folder: Path, text: str, **parameters: float) -> sr.System:
    """The rig of a file with this text."""
    file = folder / "rig.yaml"
    file.write_text(text)
    return sr.System(sr.load(file, parameters=parameters))


def test_points_of_a_file_move_as_those_of_python(tmp_path: Path) -> None:
    run = sr.simulate(in_file(tmp_path, FILE, place=0.0), until=0.5)
    assert run["block.z"][-1] == pytest.approx(sr.simulate(rig(), until=0.5)["block.z"][-1], abs=1e-9)
    assert run["rod(-0.5, 0, 0).x"] == pytest.approx(1 + 0.02 * np.sin(5 * run.t), abs=1e-9)


@pytest.mark.parametrize(("name", "step"), [("amplitude", 1e-4), ("place", 1e-3)])
def test_parameters_of_a_file_in_moving_points(tmp_path: Path, name: str, step: float) -> None:
    run = sr.simulate(system := in_file(tmp_path, FILE), until=0.5, store="steps")
    value = system.model.parameters[name]
    high, low = (
        sr.simulate(in_file(tmp_path, FILE, **{name: value + d}), until=0.5)["block.z"][-1]
        for d in (step, -step)
    )
    assert abs(high - low) > 1e-4
    assert sr.sensitivity(run, "block.z", [name])[name] == pytest.approx((high - low) / (2 * step), rel=1e-4)


def test_a_file_with_moving_points_is_saved_with_its_comments(tmp_path: Path) -> None:
    changed = in_file(tmp_path, FILE, amplitude=0.03)
    changed.model.save(tmp_path / "changed.yaml")
    assert (tmp_path / "changed.yaml").read_text() == FILE.replace("20 mm", "30 mm")
    assert np.array_equal(sr.System(sr.load(tmp_path / "changed.yaml")).b, changed.b)
    changed.model.save(tmp_path / "changed.json")
    assert np.array_equal(sr.System(sr.load(tmp_path / "changed.json")).b, changed.b)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        (
            "{body: block, at: [0, 0, 0]}",
            "{body: block, at: [0, 0, 't']}",
            r'point_j moves, but its body "block"',
        ),
        (
            '"amplitude*(1 - cos(7*t))"',
            '"sin(y)"',
            r'points\[0\].at\[2\] uses the unknown name "y". Choose from t',
        ),
        ('"amplitude*(1 - cos(7*t))"', '"2 kg * sin(t)"', r"points\[0\].at\[2\] expects m, but .* is in kg"),
        ("[ground, rod]", "[block, rod]", r"point moves, but none of its bodies is the ground"),
        ("[0, 0, 0.5]", "[0, 0, 't']", r'position\[2\] must be a number, but is "t"'),
    ],
)
def test_wrong_paths_of_a_file(tmp_path: Path, before: str, after: str, message: str) -> None:
    assert before in FILE
    with pytest.raises(sr.ModelError, match=rf"rig\.yaml:\d+: (body|joint|force) .*: {message}"):
        in_file(tmp_path, FILE.replace(before, after))


def test_parts_with_the_same_point_share_a_carrier() -> None:
    road = sr.ground.point(0, 0, PATH)
    ends = (road, BLOCK.point(0, 0, 0))
    springs = [sr.TSDA(f"spring_{n}", *ends, k=100, length=0.6) for n in (1, 2)]
    model = sr.Model("rig", [BLOCK], [SLIDE], springs)
    assert [one.name for one in model.bodies] == ["block", "spring_1_point_i"]
    assert sr.mobility(sr.System(model)).degrees_of_freedom == 1


@pytest.mark.parametrize(
    ("point", "message"),
    [
        (lambda: sr.ground.point(0, 0, "0.1*sin(x)"), r'"spring": point_i has the unknown name "x"'),
        (
            lambda: sr.ground.point(0, 0, "t*x"),
            r'"spring": point depends on|"spring": point has the unknown name "x"',
        ),
        (
            lambda: BLOCK.point(0, 0, "0.1*sin(t)"),
            r'"spring": point_i moves, but its body "block" is not the',
        ),
    ],
)
def test_wrong_paths_are_refused_by_name(point: Any, message: str) -> None:
    other = sr.Body("other", 1, (1, 1, 1))
    spring = sr.TSDA("spring", point(), other.point(0, 0, 1), k=1, length=1)
    with pytest.raises(sr.ModelError, match=message):
        sr.System(sr.Model("m", [BLOCK, other], forces=[spring]))
    with pytest.raises(sr.ModelError, match=r'"pin": point moves, but none of its bodies is the ground'):
        sr.System(
            sr.Model(
                "m", [BLOCK, other], [sr.Revolute("pin", BLOCK, other, point=(0, 0, "t"), axis=(0, 0, 1))]
            )
        )
