"""Coefficients of tyres from measurements: what is recovered, and what is wrong with measurements."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sarrus as sr

TRUE = sr.load_tyre("passenger_car")
ALPHA = np.radians(np.linspace(-10, 10, 31))
SWEEP: dict[str, Any] = {"alpha": np.tile(ALPHA, 2), "load": np.repeat((2500.0, 5500.0), 31)}
MEASURED = SWEEP | {"F_y": TRUE.forces(SWEEP)["F_y"]}
NAMES = ("PDY1", "PDY2", "PKY1", "PHY1")


def start(factor: float = 0.8) -> sr.io.TyreFile:
    moved = {name: factor * TRUE.coefficients[name] for name in NAMES}
    return sr.io.TyreFile("start", {**TRUE.coefficients, **moved})


def test_exact_measurements_give_the_coefficients_back() -> None:
    for sigma in (None, {"F_y": 10.0}):
        found = start().fit(MEASURED, NAMES, sigma=sigma)
        for name in NAMES:
            assert found.tyre.coefficients[name] == pytest.approx(TRUE.coefficients[name], rel=1e-8)
        assert abs(found.residuals["F_y"]).max() < 1e-5
    assert found.interval("PDY1")[1] - TRUE.coefficients["PDY1"] > 1e-4
    assert "PKY1" in str(found)


def test_intervals_are_those_of_linear_least_squares() -> None:
    """LMUY-like coefficients on which forces depend linearly: the covariance is σ² (XᵀX)⁻¹."""
    given = {**TRUE.coefficients, "RVY1": 0.01, "RVY4": 0.0}
    tyre, slips = (
        sr.io.TyreFile("tyre", given),
        {"kappa": np.linspace(-0.2, 0.2, 15), "load": np.full(15, 4500.0)},
    )
    base = tyre.forces(slips)["F_y"]
    X = (sr.io.TyreFile("tyre", given | {"RVY1": 1.01}).forces(slips)["F_y"] - base)[:, None]
    noisy = base + np.random.default_rng(0).normal(0, 5.0, 15)
    found = tyre.fit(slips | {"F_y": noisy}, ["RVY1"], sigma={"F_y": 5.0})
    step = np.linalg.lstsq(X, noisy - base, rcond=None)[0][0]
    assert found.tyre.coefficients["RVY1"] == pytest.approx(0.01 + step, rel=1e-9)
    assert found.covariance[0, 0] == pytest.approx(25.0 / float((X.T @ X)[0, 0]), rel=1e-9)


def test_one_name() -> None:
    found = start().fit(MEASURED, "PDY1")
    assert found.names == ("PDY1",)


def test_bounds_are_kept() -> None:
    found = start().fit(MEASURED, NAMES, bounds={"PDY1": (0.5, 1.0)})
    assert found.tyre.coefficients["PDY1"] == pytest.approx(1.0, abs=1e-6)


def test_forces_of_the_other_sign_have_a_warning() -> None:
    with pytest.warns(sr.SarrusWarning, match="F_y of measured has the opposite sign: ISO has"):
        start().fit(MEASURED | {"F_y": -MEASURED["F_y"]}, ["PDY1"])


def test_errors_of_forces_name_their_own_argument() -> None:
    for wrong in ({"alpha": [4.0]}, {"alpha": ["5 deg"]}, {"Fy": [1.0]}, {"alpha": [np.nan]}):
        with pytest.raises(sr.ModelError, match="slips") as error:
            TRUE.forces({"load": [4e3]} | wrong)
        assert "measured" not in str(error.value)


def test_rows_outside_of_the_ranges_of_the_tyre_are_counted() -> None:
    """At the ends of the ranges there is no message; without limits in the file those of the Magic Formula count."""
    narrow = {"ALPMIN": ALPHA[2], "ALPMAX": ALPHA[28], "FZMAX": 5000.0}
    tyre = sr.io.TyreFile("narrow", {**TRUE.coefficients, **narrow})
    with pytest.warns(sr.SarrusWarning) as caught:
        tyre.fit(MEASURED, ["PDY1"])
    messages = [str(one.message) for one in caught]
    assert [message.partition(",")[0] for message in messages] == [
        "measured: 8 of 62 rows have alpha outside of -0.151262 to 0.151262",
        "measured: 31 of 62 rows have load outside of 100 to 5000",
    ]
    assert messages[0].endswith("Remove these rows, or change ALPMIN and ALPMAX.")


WRONG: list[tuple[dict[str, Any], dict[str, Any], str]] = [
    ({"F_y": ["none"] * 62}, {}, 'measured must have numbers in "F_y". Remove texts.'),
    ({"F_y": np.full(62, np.nan)}, {}, 'values in "F_y" that are not finite'),
    ({"Fy": np.ones(62)}, {}, 'unknown column "Fy". Did you mean "F_y"'),
    ({"kappa": np.ones(3)}, {}, "must be lists of the same length"),
    ({"alpha": np.full(62, 4.0)}, {}, "alpha in row 0 of measured is 4. Give angles in rad"),
    ({"load": np.full(62, -4e3)}, {}, "load in row 0 of measured is -4000. Give the load in N, positive"),
    (
        {"speed": np.zeros(62)},
        {},
        "speed in row 0 of measured is 0. Give the speed in m/s, positive forwards",
    ),
    ({"load": None}, {}, "measured needs the column load"),
    ({"F_y": None}, {}, "measured needs at least one of the columns F_x, F_y"),
    ({}, {"wrt": ["PDY7"]}, 'wrt has the unknown name "PDY7"'),
    ({}, {"wrt": []}, "wrt is empty. Name the coefficients to estimate, such as"),
    ({}, {"wrt": ["PDY1", "PKY1", "PDY1"]}, 'wrt has "PDY1" more than once. Name each coefficient once.'),
    ({}, {"wrt": ["PKY1", "LKY"]}, "the measurements do not determine PKY1, LKY. Remove one"),
    ({}, {"wrt": ["PDY1", "PKX1"]}, "the measurements do not determine PKX1"),
    ({}, {"sigma": {"F_x": 1.0}}, 'sigma has the unknown name "F_x"'),
    ({}, {"sigma": {"F_y": 0.0}}, "sigma must have a positive number for each of F_y"),
    ({}, {"bounds": {"PKX1": (0, 1)}}, 'bounds has the unknown name "PKX1"'),
    ({}, {"bounds": {"PDY1": (2.0, 3.0)}}, "PDY1 starts at 0.848, which is not within its bounds 2 and 3"),
]


@pytest.mark.parametrize(("columns", "options", "message"), WRONG)
def test_wrong_measurements(columns: dict[str, Any], options: dict[str, Any], message: str) -> None:
    measured = {name: column for name, column in (MEASURED | columns).items() if column is not None}
    given = {"wrt": NAMES} | options
    with pytest.raises(sr.ModelError) as error:
        start().fit(measured, **given)
    assert message in str(error.value)
