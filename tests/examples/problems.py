"""The examples: how each is loaded, and how the columns of its reference solution are read from a motion."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

import sarrus as sr
from sarrus.algebra import Array

FOLDER = Path(__file__).parents[2] / "examples"
ANDREWS = {
    "beta": -0.0617138900142764496,
    "theta": 0.0,
    "gamma": 0.455279819163070380,
    "phi": 0.222668390165885885,
    "delta": 0.487364979543842550,
    "omega": -0.222668390165885885,
    "epsilon": 1.23054744454982119,
}

Columns = dict[str, Array]


@cache
def system(name: str) -> sr.System:
    return sr.System(sr.load(FOLDER / f"{name}.yaml"))


def exactly(name: str, until: float, times: Array | None = None) -> sr.Trajectory:
    """The motion to about ten digits."""
    method = sr.ODE("DOP853")
    return sr.simulate(system(name), until=until, t_eval=times, method=method, rtol=1e-10, atol=1e-12)


def instant(name: str) -> sr.Trajectory:
    """The state at the start, with accelerations and multipliers."""
    return exactly(name, 1e-6, np.array([0.0]))


def pendulum(run: sr.Trajectory) -> Columns:
    ball = run["ball"]
    return _xyz("", ball.position) | _xyz("v", ball.velocity)


def four_bars(run: sr.Trajectory) -> Columns:
    bar = run["upright_0"]
    return {
        "x": 2 * bar.position[:, 0],
        "y": 2 * bar.position[:, 1],
        "turning": -bar.angular_velocity_body[:, 2],
    }


def andrews(run: sr.Trajectory) -> Columns:
    return {name: start + run.joint(name).angle for name, start in ANDREWS.items()}


def bricard(run: sr.Trajectory) -> Columns:
    """The point P3, at which the second rod ends, and its velocity."""
    one, two = run["rod_1"], run["rod_2"]
    return _xyz("", 2 * (two.position - one.position)) | _xyz("v", 2 * (two.velocity - one.velocity))


def governor(run: sr.Trajectory) -> Columns:
    return {
        "psi": run.joint("bearing").angle,
        "s": run["slider"].position[:, 2],
        "alpha": np.pi / 6 + run.joint("hinge_right").angle,
        "s_speed": run["slider"].velocity[:, 2],
    }


def heavy_top(run: sr.Trajectory) -> Columns:
    top = run["top"]
    return _xyz("", top.position) | _numbered("e", top.euler) | _xyz("w", top.angular_velocity_body)


def sundials(run: sr.Trajectory) -> Columns:
    angle = np.pi / 2 + run.joint("pivot").angle
    return {"q": angle, "x": run["rod"].position[:, 0], "q_speed": run["crank"].angular_velocity_body[:, 2]}


def spatial(run: sr.Trajectory) -> Columns:
    slider, turn = run["slider"], run.joint("pin").angle
    return {"x": slider.position[:, 0], "x_speed": slider.velocity[:, 0], "theta": turn}


def double_pendulum(run: sr.Trajectory) -> Columns:
    return _xyz("", run["two"].position) | _xyz("v", run["two"].velocity)


def double_pendulum_3d(run: sr.Trajectory) -> Columns:
    one, two = run["one"], run["two"]
    return _xyz("", one.position) | _xyz("second_", two.position) | _numbered("second_e", two.euler)


def free_body(run: sr.Trajectory) -> Columns:
    return _numbered("e", run["body"].euler) | _xyz("w", run["body"].angular_velocity_body)


def car_axis(run: sr.Trajectory) -> Columns:
    return _xyz("left_", run["left"].position) | _xyz("right_", run["right"].position)


def _xyz(start: str, values: Array) -> Columns:
    return {f"{start}{letter}": values[:, n] for n, letter in enumerate("xyz")}


def _numbered(start: str, values: Array) -> Columns:
    return {f"{start}{n}": values[:, n] for n in range(4)}


COLUMNS: dict[str, Callable[[sr.Trajectory], Columns]] = {
    "simple_pendulum": pendulum,
    "four_bars": four_bars,
    "andrews": andrews,
    "bricard": bricard,
    "governor": governor,
    "heavy_top": heavy_top,
    "sundials_slider_crank": sundials,
    "spatial_slider_crank_x": spatial,
    "spatial_slider_crank_z": spatial,
    "double_pendulum": double_pendulum,
    "double_pendulum_3d": double_pendulum_3d,
    "free_body": free_body,
    "car_axis": car_axis,
}
