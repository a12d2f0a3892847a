"""Derivatives of runs that start near a singular assembly have the digits that round-off of the start leaves."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest

import sarrus as sr

NAMES = ["R", "L", "X"]
BODY = """  {name}: {{mass: {mass}, inertia: [{inertia}, {inertia}, {inertia}], position: {position},
    orientation: {{axis: [0, 0, 1], angle: {angle!r}}}}}
"""
JOINT = """  {name}: {{type: {kind}, frames: [{{body: {i}, at: [{at_i}, 0, 0], {axis}: [{along}]}},
    {{body: {j}, at: [{at_j}, 0, 0], {axis}: [{along}]}}]}}
"""
JOINTS = [
    ("main", "revolute", "ground", "0", "crank", "-R/2"),
    ("pin", "revolute", "crank", "R/2", "rod", "-L/2"),
    ("wrist", "revolute", "rod", "L/2", "slider", "0"),
    ("guide", "translational", "ground", "0", "slider", "0"),
]


def slider_crank(folder: Path, distance: float, size: float = 1.0, gyration: float = 0.1) -> sr.System:
    """A crank of 0.1 m and a rod of 0.3 m, whose slider is this far from its outer dead centre [m]."""
    inertia = repr((gyration * size) ** 2)
    R, L, X = 0.1 * size, 0.3 * size, (0.4 - distance) * size
    turned = float(np.arccos(min(1.0, (R * R + X * X - L * L) / (2 * R * X))))
    pin = R * np.array([np.cos(turned), np.sin(turned), 0])
    rod, inclined = (0.5 * (pin + (X, 0, 0))).tolist(), float(np.arctan2(-pin[1], X - pin[0]))
    file = folder / "slider_crank.yaml"
    bodies = [
        ("crank", "m", (0.5 * pin).tolist(), turned),
        ("rod", "1", rod, inclined),
        ("slider", "1", "[X, 0, 0]", 0.0),
    ]
    lines = [f"name: slider-crank\nparameters: {{R: {R!r}, L: {L!r}, X: {X!r}, m: 1.0}}\nbodies:\n"]
    lines += [
        BODY.format(name=name, mass=m, inertia=inertia, position=at, angle=angle)
        for name, m, at, angle in bodies
    ]
    lines.append("joints:\n")
    for name, kind, i, at_i, j, at_j in JOINTS:
        along = "0, 0, 1" if kind == "revolute" else "1, 0, 0"
        lines.append(
            JOINT.format(name=name, kind=kind, i=i, at_i=at_i, j=j, at_j=at_j, axis="z", along=along)
        )
    file.write_text("".join(lines))
    return sr.System(sr.load(file))


def started(system: sr.System, **given: Any) -> sr.Trajectory:
    """A short run from the assembly."""
    return sr.simulate(system, sr.assemble(system, **given), until=1e-5, store="steps")


def reported(system: sr.System, analysis: Any, wrt: list[str]) -> tuple[Any, tuple[str, ...]]:
    """What an analysis finds for the height of the rod at the start, and its warnings."""
    run = started(system, fixed=["slider"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = analysis(run, sr.At("rod.y", time=0.0), wrt)
    return found, found.warnings


def height(R: mp.mpf, L: mp.mpf, X: mp.mpf) -> mp.mpf:
    """Of the middle of the rod."""
    c = (R * R + X * X - L * L) / (2 * R * X)
    return R * mp.sqrt(1 - c * c) / 2


ANALYSES = {
    "adjoint": sr.sensitivity,
    "direct": lambda *given: sr.sensitivity(*given, method="direct"),
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("size", [1.0, 1e-6, 1e3])
@pytest.mark.parametrize("distance", [1e-2, 1e-3, 1e-5, 1e-6, 1e-8])
@mp.workdps(40)
def test_the_digits_that_are_left_near_a_dead_centre(tmp_path: Path, distance: float, size: float) -> None:
    """In any unit: round-off over the distance."""
    system = slider_crank(tmp_path, distance, size)
    found, said = reported(system, sr.sensitivity, NAMES)
    values = [mp.mpf(system.model.parameters[name]) for name in NAMES]
    truth = np.array([float(mp.diff(height, values, tuple(int(n == k) for n in range(3)))) for k in range(3)])
    assert said == ()
    assert abs(found.matrix[0] / truth - 1).max() < max(1e-9, 3e-15 / distance)


def test_in_the_dead_centre_there_is_none(tmp_path: Path) -> None:
    system = slider_crank(tmp_path, 0.0)
    for analysis in ("adjoint", "direct"):
        found, said = reported(system, ANALYSES[analysis], [*NAMES, "m"])
        assert found.undefined == tuple(NAMES)
        assert "cannot follow a change of R, L, X, as in a dead centre" in said[0]
        assert len(said) == 1
        assert np.isfinite(found["m"])


def test_a_start_that_nothing_holds_has_none(tmp_path: Path) -> None:
    """The nearest assembly moves the slider: its derivatives are those of a smooth function."""
    run = started(slider_crank(tmp_path, 1e-8))
    assert sr.sensitivity(run, sr.At("rod.y", time=0.0), NAMES).warnings == ()
