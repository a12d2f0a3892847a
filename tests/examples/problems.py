"""The examples: how each is loaded, and how the columns of its reference solution are read from a motion."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

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


class Column(NamedTuple):
    """A quantity of a reference solution: a constant, and outputs with their factors."""

    outputs: dict[str, float]
    start: float = 0.0

    def of(self, run: sr.Trajectory) -> Array:
        """Its values in a motion."""
        return self.start + sum(k * run.output(name).values for name, k in self.outputs.items())


Columns = dict[str, Column]


@cache
def system(name: str) -> sr.System:
    return sr.System(sr.load(FOLDER / f"{name}.yaml"))


def exactly(name: str, until: float, times: Array | None = None) -> sr.Trajectory:
    """The motion to about ten digits."""
    method = sr.ODE("DOP853")
    return sr.simulate(
        system(name), until=until, t_eval=times, method=replace(method, rtol=1e-10, atol=1e-12)
    )


def instant(name: str) -> sr.Trajectory:
    """The state at the start, with accelerations and multipliers."""
    return exactly(name, 1e-6, np.array([0.0]))


def _xyz(start: str, output: str, factor: float = 1.0) -> Columns:
    return {f"{start}{x}": Column({f"{output}.{x}": factor}) for x in "xyz"}


def _euler(start: str, body: str) -> Columns:
    return {f"{start}{n}": Column({f"{body}.e{n}": 1.0}) for n in range(4)}


def _between(start: str, first: str, second: str) -> Columns:
    """Twice the way from one point to another."""
    return {f"{start}{x}": Column({f"{first}.{x}": -2.0, f"{second}.{x}": 2.0}) for x in "xyz"}


def _alone(**columns: str) -> Columns:
    return {name: Column({output: 1.0}) for name, output in columns.items()}


SPATIAL = _alone(x="slider.x", x_speed="slider.velocity.x", theta="pin.angle")
COLUMNS: dict[str, Columns] = {
    "simple_pendulum": _xyz("", "ball") | _xyz("v", "ball.velocity"),
    "four_bars": _xyz("", "upright_0", 2.0)
    | {"turning": Column({"upright_0.angular_velocity_body.z": -1.0})},
    "andrews": {name: Column({f"{name}.angle": 1.0}, start) for name, start in ANDREWS.items()},
    # the point P3, at which the second rod ends
    "bricard": _between("", "rod_1", "rod_2") | _between("v", "rod_1.velocity", "rod_2.velocity"),
    "governor": _alone(psi="bearing.angle", s="slider.z", s_speed="slider.velocity.z")
    | {"alpha": Column({"hinge_right.angle": 1.0}, np.pi / 6)},
    "heavy_top": _xyz("", "top") | _euler("e", "top") | _xyz("w", "top.angular_velocity_body"),
    "sundials_slider_crank": {"q": Column({"pivot.angle": 1.0}, np.pi / 2)}
    | _alone(x="rod.x", q_speed="crank.angular_velocity_body.z"),
    "spatial_slider_crank_x": SPATIAL,
    "spatial_slider_crank_z": SPATIAL,
    "double_pendulum": _xyz("", "two") | _xyz("v", "two.velocity"),
    "double_pendulum_3d": _xyz("", "one") | _xyz("second_", "two") | _euler("second_e", "two"),
    "free_body": _euler("e", "body") | _xyz("w", "body.angular_velocity_body"),
    "car_axis": _xyz("left_", "left") | _xyz("right_", "right"),
}


def columns_of(name: str, run: sr.Trajectory) -> dict[str, Array]:
    """All columns of an example in a motion."""
    return {column: own.of(run) for column, own in COLUMNS[name].items()}
