"""Derivatives of runs that start near a singular assembly have a warning with the digits that are left."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.position.assembly_derivatives import AssemblyDerivatives
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.parameters.singular_start import singular_start

MESSAGE = (
    r"close to a dead centre .* about (\d+) digits, .* only for relative changes of parameters below (\S+)\."
)
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
    return sr.simulate(system, sr.assemble(system, **given), until=1e-5, store_steps=True)


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
    "hessian": sr.hessian,
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("size", [1.0, 1e-6, 1e3])
@pytest.mark.parametrize("distance", [1e-2, 1e-3, 1e-5, 1e-6, 1e-8])
@mp.workdps(40)
def test_the_digits_that_are_left_near_a_dead_centre(tmp_path: Path, distance: float, size: float) -> None:
    """Derivatives are as exact as the warning says, and describe changes of the size that it says, in any unit."""
    system = slider_crank(tmp_path, distance, size)
    found, said = reported(system, sr.sensitivity, NAMES)
    values = [mp.mpf(system.model.parameters[name]) for name in NAMES]
    truth = np.array([float(mp.diff(height, values, tuple(int(n == k) for n in range(3)))) for k in range(3)])
    error = abs(found.matrix[0] / truth - 1).max()
    if distance > 1e-4:
        assert said == ()
        assert error < 1e-9
        return
    (message,) = said
    digits, share = (float(x) for x in re.search(MESSAGE, message).groups())  # type: ignore[union-attr]
    assert error < 10.0 ** -(digits - 1)
    assert digits == pytest.approx(np.log10(distance / 1e-16), abs=1.5)
    gone = values[1] * mp.mpf(
        share
    )  # a change of this size of the rod's length is the end of the first derivative
    change = float((height(values[0], values[1] + gone, values[2]) - height(*values)) / gone)
    assert change != pytest.approx(truth[1], rel=0.1)
    slight = gone / 1000
    change = float((height(values[0], values[1] + slight, values[2]) - height(*values)) / slight)
    assert change == pytest.approx(truth[1], rel=0.1)


def test_equations_that_are_taken_for_dependent_ones_are_said(tmp_path: Path) -> None:
    """Moments of inertia in wrong units compare displacements with rotations wrongly: derivatives are off by 100 %."""
    system = slider_crank(tmp_path, 1e-8, 1e-6, gyration=1e5)
    _, said = reported(system, sr.sensitivity, NAMES)
    assert any("derivatives by what moves it have no correct digit" in one for one in said)


@pytest.mark.parametrize("analysis", ANALYSES)
def test_every_derivative_has_the_warning(tmp_path: Path, analysis: str) -> None:
    system = slider_crank(tmp_path, 1e-6)
    assert re.search(MESSAGE, reported(system, ANALYSES[analysis], NAMES)[1][0])
    assert reported(system, ANALYSES[analysis], ["m"])[1] == ()


def test_states_and_products_have_it_too(tmp_path: Path) -> None:
    run = started(slider_crank(tmp_path, 1e-6), fixed=["slider"])
    with pytest.warns(sr.SarrusWarning, match=MESSAGE):
        sr.state_derivatives(run, NAMES)
    with pytest.warns(sr.SarrusWarning, match=MESSAGE):
        sr.hessian_product(run, "rod.y", {"R": 1.0})


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


def test_a_rate_that_can_hardly_be_given(tmp_path: Path) -> None:
    """The speed of the crank is that of the slider over the sine of an angle."""
    for distance, expected in ((1e-3, False), (1e-5, True), (1e-8, True)):
        run = started(slider_crank(tmp_path, distance), rates={"slider.x": 0.1})
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            said = sr.sensitivity(run, sr.At("rod.y", time=0.0)).warnings
        assert any("slider.x cannot be given" in one for one in said) == expected


@pytest.mark.parametrize("name", mechanisms.names())
def test_ordinary_mechanisms_have_no_warning(name: str) -> None:
    system = sr.System(sr.load(mechanisms.path(name)))
    held: list[dict[str, Any]] = [{}, {"fixed": [system.model.bodies[0].name]}]
    for given in held:
        start = sr.assemble(system, **given)
        if start.success:
            parameters = Parameters(system, None, start=start)
            assert list(singular_start(parameters, start, AssemblyDerivatives(system, start))) == []
