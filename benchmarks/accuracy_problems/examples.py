"""The examples and shipped mechanisms, beside solutions of other programs (tests/reference/README.md)."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import sarrus as sr
from sarrus import mechanisms
from sarrus.algebra import Array
from sarrus.functions import positive, sin

from .problem import ROOT, Column, Known, Problem, motion  # isort: skip
from tests.examples.problems import COLUMNS, FOLDER

REFERENCE = ROOT / "tests" / "reference"


def _is_rate(column: str) -> bool:
    return column.endswith("_speed") or column[0] in "vw" or column == "turning"


def _known(file: str, columns: list[str], until: float, t: Array) -> Known:
    """A table's rows up to the end of the motion."""
    table = np.genfromtxt(REFERENCE / f"{file}.csv", delimiter=",", names=True)
    table = table[table["t"] <= until * (1 + 1e-12)]
    return _kinds(table["t"], {name: table[name] for name in columns})


def _kinds(t: Array, columns: dict[str, Array]) -> Known:
    rates = [values for name, values in columns.items() if _is_rate(name)]
    places = [values for name, values in columns.items() if not _is_rate(name)]
    return Known(t, np.stack(places, axis=1), np.stack(rates, axis=1) if rates else None)


def example(file: str, title: str, until: float) -> Problem:
    """One of `examples/`, with the columns that its table shares with what tests read of its motion."""
    header = (REFERENCE / f"{file}.csv").read_text().split("\n", 1)[0].split(",")[1:]
    columns = [name for name in header if name in NAMES[file]]

    def make() -> tuple[sr.System, Any]:
        return sr.System(sr.load(FOLDER / f"{file}.yaml")), None

    read: dict[str, list[str | Column]] = {"positions": [], "velocities": []}
    for name in columns:
        read["velocities" if _is_rate(name) else "positions"].append(COLUMNS[file][name])
    return Problem(
        title, make, until, partial(_known, file, columns, until), {k: x for k, x in read.items() if x}
    )


NAMES = {
    "simple_pendulum": {"x", "y", "vx", "vy"},
    "four_bars": {"x", "y"},
    "andrews": {"beta", "theta", "gamma", "phi", "delta", "omega", "epsilon"},
    "bricard": {"x", "y", "z", "vx", "vy", "vz"},
    "governor": {"psi", "s", "alpha", "s_speed"},
    "heavy_top": {"x", "y", "z", "e0", "e1", "e2", "e3", "wx", "wy", "wz"},
    "sundials_slider_crank": {"q", "x", "q_speed"},
    "spatial_slider_crank_x": {"x", "x_speed"},
    "spatial_slider_crank_z": {"x", "x_speed"},
    "double_pendulum": {"x", "y", "vx", "vy"},
    "double_pendulum_3d": {"x", "y", "z", "second_x", "second_y", "second_z"},
    "free_body": {"e0", "e1", "e2", "e3", "wx", "wy", "wz"},
    "car_axis": {"left_x", "left_y", "right_x", "right_y"},
}


SLIDER_CRANK: dict[str, list[str | Column]] = {
    "positions": ["slider.x", Column({"pin.angle": 1.0}, 0.5)],
    "velocities": ["slider.velocity.x", "pin.angle.rate"],
}
CHASSIS = motion("chassis.x", "chassis.y", "chassis.z")


def known_slider_crank(t: Array) -> Known:
    table = np.genfromtxt(REFERENCE / "spatial_slidercrank_paper.csv", delimiter=",", names=True)
    places = np.stack([table["x_slider"], table["theta_crank"]], axis=1)
    return Known(table["t"], places, np.stack([table["v_slider"], table["omega_crank"]], axis=1))


def make_slider_crank() -> tuple[sr.System, Any]:
    return sr.System(sr.load(mechanisms.path("slider_crank"))), None


def known_vehicle(file: str, t: Array) -> Known:
    table = np.genfromtxt(REFERENCE / file, delimiter=",", names=True)
    places, rates = (np.stack([table[f"{v}{x}"] for x in "xyz"], axis=1) for v in ("", "v"))
    return Known(table["t"], places, rates)


def make_vehicle() -> tuple[sr.System, Any]:
    """It drives and steers as one rigid body at first."""
    system = sr.System(sr.load(mechanisms.path("hmmwv")))
    v0, w = np.array([5.0, 0, -0.3]), np.array([0.2, 0.1, 0.05])
    q, v = system.q0.reshape(-1, 7), np.zeros((len(system.bodies), 7))
    v[:, :3] = v0 + np.cross(w, q[:, :3] - q[0, :3])
    v[:, 3] = -0.5 * q[:, 4:] @ w
    v[:, 4:] = 0.5 * (q[:, 3:4] * w + np.cross(w, q[:, 4:]))
    return system, sr.assemble(system, system.q0, v.reshape(-1))


def wave(start: float) -> Callable[[float], float]:
    return lambda t: (
        0.06 * sin(np.pi * (t - start) / 0.4) ** 4 * positive(t - start) * positive(start + 0.4 - t)
    )


def make_bump() -> tuple[sr.System, Any]:
    """Tyres that may lift off, over a bump under the left wheels."""
    model = sr.load(mechanisms.path("hmmwv"))
    bumps = {"tyre_front_left": wave(0.2), "tyre_rear_left": wave(0.55)}
    forces = [
        sr.RoadTyre(f.name, f.point, f.k, f.c, f.radius, bump=bumps.get(f.name, 0.0))
        if isinstance(f, sr.Tyre)
        else f
        for f in model.forces
    ]
    return sr.System(dataclasses.replace(model, forces=forces)), None


EXAMPLES: tuple[Problem, ...] = (
    example("simple_pendulum", "example: simple pendulum", 10.0),
    example("four_bars", "example: two four-bars through their flat position", 10.0),
    example("andrews", "example: Andrews' squeezer", 0.05),
    example("bricard", "example: Bricard's mechanism", 10.0),
    example("governor", "example: governor", 10.0),
    example("heavy_top", "example: heavy top", 2.0),
    example("sundials_slider_crank", "example: planar slider-crank", 10.0),
    example("spatial_slider_crank_x", "example: spatial slider-crank, x", 5.0),
    example("spatial_slider_crank_z", "example: spatial slider-crank, z", 5.0),
    example("double_pendulum", "example: double pendulum", 10.0),
    example("double_pendulum_3d", "example: double pendulum in space", 5.0),
    example("free_body", "example: free body", 20.0),
    example("car_axis", "example: car axis", 3.0),
    Problem("shipped slider-crank", make_slider_crank, 10.0, known_slider_crank, SLIDER_CRANK),
    Problem(
        "vehicle that drives and steers",
        make_vehicle,
        2.0,
        partial(known_vehicle, "hmmwv_T1.csv"),
        CHASSIS,
        exact=1e-7,
    ),
    Problem(
        "vehicle over a bump",
        make_bump,
        2.0,
        partial(known_vehicle, "hmmwv_T2.csv"),
        CHASSIS,
        smooth=False,
        exact=1e-6,
    ),
)
