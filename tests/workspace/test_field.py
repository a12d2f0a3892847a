"""Manipulability, solutions and orientations on a grid, beside closed forms."""

import csv
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from scipy.io import netcdf_file

import sarrus as sr
from sarrus.cli.verbs.workspace import QUANTITIES
from sarrus.results.maps.workspace_field import Quantity

from .mechanisms import arm_2r_both_elbows, five_bar, platform_haug


@pytest.fixture(scope="module")
def arm() -> sr.WorkspaceField:
    system, output, limits = arm_2r_both_elbows()
    found = sr.workspace(system, output, limits=limits, verify=False)
    return sr.workspace_field(found, ("q1", "q2"), cells=30)


def elbow(field: sr.WorkspaceField) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y and the cosine of the second angle of an arm of 1 m and 0.7 m."""
    x, y = np.meshgrid(field.x, field.y)
    return x, y, (x * x + y * y - 1.49) / 1.4


def test_manipulability_of_an_arm(arm: sr.WorkspaceField) -> None:
    """L1 L2 sin q2, and the ratio of the singular values of J."""
    _, _, c = elbow(arm)
    inside = np.isfinite(arm.values["manipulability"])
    s = np.sqrt(1 - c[inside] ** 2)
    assert arm.values["manipulability"][inside] == pytest.approx(0.7 * s, abs=1e-9)
    a = np.array(
        [[-0.7 * s, 1 + 0.7 * c[inside]], [-0.7 * s, 0.7 * c[inside]]]
    )  # along the first link and across
    sizes = np.linalg.svd(a.transpose(2, 1, 0), compute_uv=False)
    assert arm.values["conditioning"][inside] == pytest.approx(sizes[:, 1] / sizes[:, 0], abs=1e-9)


def test_solutions_of_an_arm(arm: sr.WorkspaceField) -> None:
    """Both elbows where the limits allow it."""
    x, y, c = elbow(arm)
    count = np.zeros_like(x)
    for side in (1, -1):
        q2 = side * np.arccos(np.clip(c, -1, 1))
        q1 = np.arctan2(y, x) - np.arctan2(0.7 * np.sin(q2), 1 + 0.7 * np.cos(q2))
        q1 = (q1 + np.pi) % (2 * np.pi) - np.pi
        count += (abs(c) < 1) & (abs(q1) <= np.pi / 2) & (abs(q2) <= 2 * np.pi / 3)
    assert set(np.unique(count)) == {0, 1, 2}
    assert np.array_equal(np.nan_to_num(arm.values["solutions"]), count)
    assert arm.missed == 0


@pytest.mark.slow
def test_a_five_bar_has_four_solutions() -> None:
    """Two for each crank; J from (P - B_i)·dP = (P - B_i)·dB_i, of the best and the worst of them."""
    system, output, limits = five_bar()
    found = sr.workspace(system, output, limits=limits, verify=False)
    field = sr.workspace_field(found, ("a1", "a2"), cells=14)
    inside = np.isfinite(field.values["solutions"])
    assert np.unique(field.values["solutions"][inside]).tolist() == [4]
    assert field.positions == 4 * inside.sum()
    sizes = []
    for u in np.stack(np.meshgrid(field.x, field.y), axis=-1)[inside]:
        for one in crank_ends(-1, u):
            for other in crank_ends(1, u):
                rods = np.array([u - one, u - other])
                moved = [rods[0] @ (-one[1], one[0] + 1), rods[1] @ (-other[1], other[0] - 1)]
                sizes.append(np.linalg.svd(np.linalg.solve(rods, np.diag(moved)), compute_uv=False))
    large, small = np.array(sizes).T.reshape(2, -1, 4)
    for name, numbers in (("conditioning", small / large), ("manipulability", small * large)):
        assert field.values[name][inside] == pytest.approx(numbers.max(axis=1), rel=1e-6)
        assert field.values[f"worst_{name}"][inside] == pytest.approx(numbers.min(axis=1), rel=1e-6)


def crank_ends(pivot: float, u: np.ndarray) -> list[np.ndarray]:
    """The ends of a crank of 1.2 m at (pivot, 0) that are 1.5 m from a place."""
    d = u - (pivot, 0)
    away = float(np.linalg.norm(d))
    along = (away**2 + 1.2**2 - 1.5**2) / (2 * away)
    across = (1.2**2 - along**2) ** 0.5 * np.array([-d[1], d[0]]) / away
    return [(pivot, 0) + along * d / away + side * across for side in (1, -1)]


@pytest.mark.slow
def test_range_of_orientation_of_a_platform() -> None:
    """All angles at which three lengths keep their limits, by trying them."""
    system, output, legs = platform_haug()
    found = sr.workspace(system, output, limits=legs, verify=False)
    field = sr.workspace_field(found, turn="platform.rotation_z", cells=20)
    inside = np.isfinite(field.values["turn"])
    x, y = (a[inside][:, None] for a in np.meshgrid(field.x, field.y))
    phi = 2 * np.pi * np.arange(50_000) / 50_000
    c, s = np.cos(phi), np.sin(phi)
    d = np.hypot(x - c + 1, y - s), np.hypot(x - c - 1, y - s), np.hypot(x + c - 2, y + s)
    ok = np.all(
        [(low <= one) & (one <= high) for one, (low, high) in zip(d, legs.values(), strict=True)], axis=0
    )
    assert inside.sum() > 70
    assert field.missed == 0
    assert field.values["turn"][inside] == pytest.approx(2 * np.pi * ok.mean(axis=1), abs=1e-3)


def test_picture(arm: sr.WorkspaceField) -> None:
    """Whole numbers have a colour each; colours end at the boundary, barriers are drawn."""
    axes = arm.plot("solutions")
    (image,) = axes.collections
    assert image.get_clip_path() is not None
    assert "solutions of the inverse kinematics" in axes.get_title(loc="left")
    bar = axes.figure.axes[1]
    assert bar.get_yticks().tolist() == [1, 2]
    drawn = [curve for curve in arm.workspace.curves if curve.kind != "crossable" and not curve.again]
    assert len(axes.get_lines()) == len(drawn)
    assert "conditioning" in arm.plot().get_title(loc="left")
    with pytest.raises(sr.SarrusError, match=r"turn was not computed. Choose from solutions, manip"):
        arm.plot("turn")


def test_tables(arm: sr.WorkspaceField, tmp_path: Path) -> None:
    arm.to_csv(tmp_path / "arm.csv")
    with (tmp_path / "arm.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    inside = np.isfinite(arm.values["solutions"])
    assert [float(row["conditioning"]) for row in rows] == arm.values["conditioning"][inside].tolist()
    assert [float(row[arm.workspace.outputs[0]]) for row in rows] == np.meshgrid(arm.x, arm.y)[0][
        inside
    ].tolist()
    arm.to_netcdf(tmp_path / "arm.nc")
    with netcdf_file(str(tmp_path / "arm.nc"), mmap=False) as file:
        written = file.variables["solutions"][:]
        assert file.variables["x"].units == b"m"
    assert np.array_equal(written, arm.values["solutions"], equal_nan=True)


def test_the_shell_offers_what_there_is() -> None:
    assert QUANTITIES == get_args(Quantity)


def test_report(arm: sr.WorkspaceField) -> None:
    assert "Solutions of the inverse kinematics: from 1 to 2, median 2." in str(arm)


@pytest.mark.parametrize(
    ("inputs", "options", "told"),
    [
        (("q1",), {}, "2 degrees of freedom, but 1 input is given. Give as many"),
        ((), {"turn": "link_2.rotation_z"}, "no rotation is free while"),
        ((), {"cells": 0}, "cells must be 1 at least"),
        ((), {"cells": 1}, "no cell's centre lies inside. Give more cells"),
    ],
)
def test_misuse(
    arm: sr.WorkspaceField, inputs: tuple[str, ...], options: dict[str, object], told: str
) -> None:
    with pytest.raises(sr.SarrusError, match=told):
        sr.workspace_field(arm.workspace, inputs, **options)
    with pytest.raises(ValueError, match="starts must be 1 at least"):
        sr.workspace_field(arm.workspace, starts=-1)


def test_endless_solutions_are_refused() -> None:
    system, output, legs = platform_haug()
    found = sr.workspace(system, output, limits=legs, verify=False)
    with pytest.raises(sr.SarrusError, match=r"infinitely many solutions at every place. Name its inputs"):
        sr.workspace_field(found)
    with pytest.raises(sr.SarrusError, match=r"\.x: is no angle. Pass the name"):
        sr.workspace_field(found, turn="platform(1, 0, 0).x")


def test_no_field_where_nothing_is_reached(arm: sr.WorkspaceField) -> None:
    with pytest.raises(sr.SarrusError, match="nothing can be reached, so there is no field"):
        sr.workspace_field(replace(arm.workspace, components=()))
