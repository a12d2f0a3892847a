"""Axes and angles of bodies, motion in body axes, and motion that is seen from another body."""

import csv
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

import sarrus as sr
from sarrus.cli import main

POINTS = (0.1, 0.2, 0.3), (0.0, 0.1, -0.2)
SEEN = "relative[a(0.1, 0.2, 0.3), b(0, 0.1, -0.2)]"
TIMES = np.linspace(0, 1, 201)


def system(k: float = 20.0, force: Any = None) -> sr.System:
    """Two free bodies that rotate, with a spring between them."""
    a = sr.Body(
        "a", 1.0, (0.1, 0.2, 0.25), (0.3, -0.1, 0.2), orientation=sr.AxisAngle((1, 2, -1), 0.7),
        velocity=(0.3, 0.1, -0.4), angular_velocity=(1, 2, 3),
    )  # fmt: skip
    b = sr.Body(
        "b", 2.0, (0.2, 0.3, 0.35), (-0.3, 0.5, 0.1), orientation=sr.AxisAngle((-1, 1, 2), 1.2),
        velocity=(-0.2, 0.5, 0.4), angular_velocity=(-2, 1, 0.5),
    )  # fmt: skip
    ends = a.point(*POINTS[0]), b.point(*POINTS[1])
    spring = (
        sr.TSDA("spring", *ends, k=k, length=0.3, c=0.5)
        if force is None
        else sr.Force("spring", *ends, value=force)
    )
    return sr.System(sr.Model("two", [a, b], [], [spring]))


@cache
def motion(k: float = 20.0, store: bool = False) -> sr.Trajectory:
    return sr.simulate(
        system(k), until=1.0, t_eval=TIMES, method=sr.Radau(rtol=1e-11), store="steps" if store else "samples"
    )


def matrices(run: sr.Trajectory, body: str) -> np.ndarray:
    e = np.array([run[f"{body}.e{n}"] for n in range(4)]).T
    return np.asarray(Rotation.from_quat(np.roll(e, -1, axis=1)).as_matrix())


def rotations(run: sr.Trajectory, part: str) -> np.ndarray:
    a = matrices(run, "a")
    return a if part == "a" else np.einsum("tki,tkj->tij", matrices(run, "b"), a)


@pytest.mark.parametrize("part", ["a", "relative[a, b]"])
def test_axes_and_angles_are_those_of_scipy(part: str) -> None:
    run = motion()
    found = rotations(run, part)
    for n, axis in enumerate("xyz"):
        assert np.allclose(run[f"{part}.axis_{axis}"], found[:, :, n], atol=1e-12)
    for axes in ("xyz", "zyx", "yzx", "xzy", "zxz", "xyx", "yzy", "zyz"):
        own = np.array([run[f"{part}.angles_{axes}.{n}"] for n in (1, 2, 3)]).T
        expected = Rotation.from_matrix(found).as_euler(axes.upper())
        assert np.allclose(np.exp(1j * own), np.exp(1j * expected), atol=1e-11)
    for n, word in enumerate(("yaw", "pitch", "roll"), 1):
        assert np.array_equal(run[f"{part}.{word}"], run[f"{part}.angles_zyx.{n}"])


@cache
def spinning() -> sr.System:
    return sr.System(sr.Model("top", [sr.Body("top", 1.0, (1, 1, 1), angular_velocity=(0, 0, 30))]))


def test_rotations_of_bodies_count_revolutions_however_far_apart_outputs_are() -> None:
    run = sr.simulate(spinning(), until=1.0, t_eval=[0.0, 1.0])
    assert np.allclose(run["top.rotation_z"], 30 * run.t, atol=1e-6)
    assert np.allclose(run["top.yaw"], np.angle(np.exp(30j * run.t)), atol=1e-6)
    assert np.allclose(run["relative[ground, top].yaw"], -run["top.yaw"], atol=1e-9)
    assert np.array_equal(run["top.rotation_x"], [0, 0])  # undefined about x is nothing that counts


def test_rotations_of_bodies_count_on_in_a_continued_and_in_a_saved_run(tmp_path: Path) -> None:
    begun = sr.simulate(spinning(), until=1.0, t_eval=[0.0, 1.0])
    run = sr.simulate(spinning(), begun.final, until=3.0, t_eval=[1.0, 3.0], save=tmp_path / "run")
    assert np.allclose(run["top.rotation_z"], 30 * run.t, atol=1e-5)
    assert np.array_equal(sr.load_run(tmp_path / "run")["top.rotation_z"], run["top.rotation_z"])


def test_rotations_of_bodies_count_in_kinematics() -> None:
    wheel = sr.Body("wheel", 1.0, (1, 1, 1))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    model = sr.Model("wheel", [wheel], [pin], drivers=[sr.AngleDriver("motor", "pin", "50*t")])
    run = sr.kinematics(sr.System(model), [0.0, 1.0])
    assert np.allclose(run["wheel.rotation_z"], 50 * run.t, atol=1e-9)


def test_motion_is_seen_from_another_body() -> None:
    run = motion()
    frame = matrices(run, "b")
    apart = run["a(0.1, 0.2, 0.3).position"] - run["b(0, 0.1, -0.2).position"]
    seen = np.einsum("tki,tk->ti", frame, apart)
    assert np.allclose(run[f"{SEEN}.position"], seen, atol=1e-12)
    assert np.allclose(run[f"{SEEN}.distance"], np.linalg.norm(apart, axis=1), atol=1e-12)
    assert np.allclose(run[f"{SEEN}.distance"], run["spring.length"], atol=1e-12)
    assert np.allclose(run[f"{SEEN}.distance.rate"], run["spring.rate"], atol=1e-11)
    spline, inner = make_interp_spline(run.t, seen, k=7), slice(15, -15)
    assert np.allclose(run[f"{SEEN}.velocity"][inner], spline(run.t, 1)[inner], atol=1e-6)
    assert np.allclose(run[f"{SEEN}.acceleration"][inner], spline(run.t, 2)[inner], atol=1e-4)
    w = np.einsum("tki,tk->ti", frame, run["a.angular_velocity"] - run["b.angular_velocity"])
    assert np.allclose(run[f"{SEEN}.angular_velocity"], w, atol=1e-12)
    own = np.einsum("tki,tk->ti", matrices(run, "a"), run["a(0.1, 0.2, 0.3).velocity"])
    assert np.allclose(run["a(0.1, 0.2, 0.3).velocity_body"], own, atol=1e-12)
    assert np.allclose(run["relative[a, ground(0, 0, 1)].z"], run["a.z"] - 1, atol=1e-12)
    assert run["b.acceleration_body.x"] == pytest.approx(
        np.einsum("tk,tk->t", frame[:, :, 0], run["b.acceleration"]), abs=1e-12
    )


WORDS = ("x", "distance", "distance.rate", "velocity.y", "acceleration.z", "angular_velocity.x", "axis_y.z", "yaw",
         "pitch", "roll", "angles_zxz.2")  # fmt: skip
NAMES = [
    *(f"{SEEN}.{word}" for word in WORDS),
    "a.velocity_body.x",
    "a.acceleration_body.y",
    "b.axis_x.z",
    "b.roll",
]


@pytest.mark.parametrize("method", ["direct", "adjoint"])
def test_derivatives_are_those_of_whole_runs(method: Any) -> None:
    found = sr.sensitivity(motion(store=True), NAMES, ["spring.k"], method=method)
    more, less = motion(20.0 + 1e-3), motion(20.0 - 1e-3)
    expected = [(more[name][-1] - less[name][-1]) / 2e-3 for name in NAMES]
    assert np.allclose(found.matrix[:, 0], expected, rtol=1e-5, atol=1e-8)


def test_a_force_may_depend_on_them() -> None:
    law = f"-20*({SEEN}.distance - 0.3) - 0.5*{SEEN}.distance.rate + 0*a.axis_x.z + 0*a.velocity_body.x"
    run = sr.simulate(system(force=law), until=1.0, t_eval=TIMES, method=sr.Radau(rtol=1e-11))
    assert np.allclose(run.q, motion().q, atol=1e-8)


def test_events_formulas_and_the_command_line_take_them(tmp_path: Path) -> None:
    middle = 0.5 * (motion()[f"{SEEN}.distance"].max() + motion()[f"{SEEN}.distance"].min())
    event = sr.Event(f"{SEEN}.distance - {middle}*relative[a, a].axis_x.x", terminal=True)
    run = sr.simulate(system(), until=1.0, events=[event])
    assert run.status == "event"
    assert run[f"{SEEN}.distance"][-1] == pytest.approx(middle, abs=1e-9)
    system().model.save(tmp_path / "two.yaml")
    command = [
        "run",
        str(tmp_path / "two.yaml"),
        "--until",
        "1",
        "--csv",
        str(tmp_path / "two.csv"),
        "--columns",
    ]
    assert main([*command, f"{SEEN}.distance", "a.yaw", "relative[a,b].roll"]) == 0
    with open(tmp_path / "two.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert len(rows[0]) == 4
    assert float(rows[-1][2]) == pytest.approx(motion()["a.yaw"][-1], abs=1e-6)
    for wrong in ("relative[a, c].x", "relative[a].x", "relative[a, b].q", "a.rol"):
        with pytest.raises(KeyError, match="has no output"):
            run[wrong]
