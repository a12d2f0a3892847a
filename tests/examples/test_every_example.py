"""Every example: its freedom, its assembly, its derivatives, and the first instants of its reference solution."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from tests.examples.problems import COLUMNS, FOLDER, columns_of, exactly, system

import sarrus as sr
from sarrus.cli import main

FREEDOMS = {
    "simple_pendulum": 2,  # and the ball's own spin
    "four_bars": 1,
    "andrews": 1,
    "bricard": 1,
    "governor": 4,
    "heavy_top": 3,
    "sundials_slider_crank": 1,
    "spatial_slider_crank_x": 1,
    "spatial_slider_crank_z": 1,
    "double_pendulum": 2,
    "double_pendulum_3d": 6,
    "free_body": 6,
    "car_axis": 4,  # two of them the wheels' own spin
}
CLOSED = 1e-14  # [m] of the numbers in the files: the joints are together as they stand there
DIGITS = 1e-8  # relative to 1 or the value: simulated with a tolerance of 1e-10

# Reference solutions by other programs at an early time, or in closed form.
EARLY: dict[str, tuple[float, dict[str, float]]] = {
    "simple_pendulum": (  # elliptic functions
        1.0,
        {
            "x": -0.9862917511318753,
            "y": -0.1650108531255412,
            "vx": -0.2969055159163158,
            "vy": 1.774643641112656,
        },
    ),
    "four_bars": (  # elliptic functions
        0.5,
        {"x": 0.695286633164, "y": 0.718732563436, "turning": 2.72730849428},
    ),
    "andrews": (
        0.005,
        {"beta": 0.211076385903, "theta": -0.201587170934, "gamma": 0.449115190012, "phi": 0.21025079793}
        | {"delta": 0.488743765462, "omega": -0.21025079793, "epsilon": 1.22586679403},
    ),
    "bricard": (
        0.5,
        {"x": 0.774717808039, "y": -0.979815047656, "z": -0.199906158953}
        | {"vx": -0.826939922805, "vy": 0.130707217016, "vz": -0.640645084376},
    ),
    "governor": (
        0.1,
        {"psi": 0.622106681403, "s": 0.52383647557, "alpha": 0.496173869076, "s_speed": 0.459271810436},
    ),
    "heavy_top": (
        0.02,
        {"x": 0.0919859532448, "y": 0.995741106127, "z": -0.00618336276032, "wx": 1.25943964539, "wy": 150.0}
        | {"e0": 0.0706143452623, "e1": 0.0457080611458, "e2": 0.996435731649, "e3": -0.00634193053347}
        | {"wz": 4.45364968056},
    ),
    "sundials_slider_crank": (1.0, {"q": 1.31542057088, "x": 1.00149180723, "q_speed": -0.50879297691}),
    "spatial_slider_crank_x": (0.2, {"x": 0.260545932689, "x_speed": 0.394902494524, "theta": 1.23092691845}),
    "spatial_slider_crank_z": (0.2, {"x": 0.26059043994, "x_speed": 0.395240720056, "theta": 1.23191680805}),
    "double_pendulum": (
        1.0,
        {"x": -0.569764210469, "y": -1.290546602590, "vx": -3.511984057911, "vy": 1.029854116170},
    ),
    "double_pendulum_3d": (
        0.5,
        {"x": 0.142166605581, "y": 0.218549448058, "z": -0.426643639366}
        | {"second_x": 0.434451884095, "second_y": 0.710487082545, "second_z": -1.01979038248}
        | {"second_e0": 0.854404759656, "second_e1": -0.209796235834, "second_e2": 0.148795524226}
        | {"second_e3": 0.451484150417},
    ),
    "free_body": (
        1.0,
        {"e0": -0.800979092266, "e1": 0.00673741556939, "e2": 0.598231099554, "e3": 0.0225089428961}
        | {"wx": -0.219622293889, "wy": 4.99518428569, "wz": 0.128236697781},
    ),
    "car_axis": (
        0.5,
        {
            "left_x": 0.0478878180617,
            "left_y": 0.497089687181,
            "right_x": 1.04357714998,
            "right_y": 0.404338653155,
        },
    ),
}


def test_no_example_is_forgotten() -> None:
    names = {path.stem for path in FOLDER.glob("*.yaml")} - {"spatial_slider_crank"}  # which others include
    assert names == set(FREEDOMS) == set(COLUMNS) == set(EARLY)


@pytest.mark.parametrize("name", FREEDOMS)
def test_it_is_assembled_as_it_stands(name: str) -> None:
    start = sr.assemble(system(name))
    assert start.success, start.message
    assert abs(start.q - system(name).q0).max() < CLOSED
    assert abs(start.v - system(name).v0).max() < 1e-12 * max(1.0, abs(start.v).max())


@pytest.mark.parametrize(("name", "freedom"), FREEDOMS.items())
def test_degrees_of_freedom(name: str, freedom: int) -> None:
    found = sr.mobility(system(name))
    assert (found.degrees_of_freedom, found.finite) == (freedom, freedom)
    assert found.redundant == (name == "bricard")


@pytest.mark.one_in(8)
@pytest.mark.parametrize(("name", "early"), EARLY.items())
def test_the_first_instants(name: str, early: tuple[float, dict[str, float]]) -> None:
    time, wanted = early
    run = exactly(name, time, np.array([time]))
    assert run.success, run.message
    columns = columns_of(name, run)
    assert {key: columns[key][-1] for key in wanted} == pytest.approx(wanted, rel=DIGITS, abs=DIGITS)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", FREEDOMS)
def test_every_derivative_is_checked(name: str) -> None:
    report = system(name).check_derivatives()
    assert report.ok, report


def test_a_model_is_checked_in_words_and_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drawing = tmp_path / "car_axis.png"  # it has a driver, and is flat
    assert main(["check", str(FOLDER / "car_axis.yaml"), "--draw", str(drawing)]) == 0
    told = capsys.readouterr().out
    assert "3 bodies: road, left, right; 1.001 kg in all" in told
    assert "1 driver, 1 equation:\n  1 angle: bumps" in told
    assert "4 degrees of freedom" in told
    assert drawing.stat().st_size > 10_000


def test_four_bars_in_python_are_those_of_the_file() -> None:
    example = runpy.run_path(str(FOLDER / "four_bars.py"))
    made, loaded = sr.System(example["four_bars"](2)), system("four_bars")
    order = [made.bodies.index(name) for name in loaded.bodies]
    for x, y in ((made.q0, loaded.q0), (made.v0, loaded.v0)):
        assert np.array_equal(x.reshape(-1, 7)[order], y.reshape(-1, 7))
    assert set(made.rows) == set(loaded.rows)
    assert sorted(made.b) == pytest.approx(sorted(loaded.b))
