"""Gradients that other programs computed are reached, the error falling with the tolerance."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.sensitivity.designs import SPATIAL, SUNDIALS, spatial, sundials, sundials_crank
from tests.system.mechanisms import slider_crank

import sarrus as sr

FOLDER = Path(__file__).parent.parent / "reference"
PATHS = {
    "spring.length0": "spring.length",
    "gravity": "gravity.z",
    "theta0": "theta0",
}
RESPONSES = [
    sr.Final("slider.x"),
    sr.Integral(lambda o: o("slider.velocity.x") ** 2, name="int_xdot2"),
    sr.Final("pin.angle.rate"),
    sr.Final("slider.velocity.x"),
]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("until", ["1.0", "5.0"])
@pytest.mark.parametrize("method", ["adjoint", "direct"])
def test_the_spatial_slider_crank(until: str, method: str) -> None:
    told = json.loads((FOLDER / "slider_crank_gradients.json").read_text())
    names = [PATHS.get(name, name) for name in told["parameters"]]
    sign = np.where(np.array(names) == "gravity.z", -1.0, 1.0)
    wanted = np.array(told["cases"][until]["gradient"])
    errors = []
    for rtol in (1e-4, 1e-6, 1e-8):
        run = sr.simulate(
            slider_crank(),
            until=float(until),
            t_eval=[float(until)],
            method=sr.Radau(rtol=rtol, atol=rtol),
            store="steps",
        )
        found = sr.sensitivity(run, RESPONSES, names, design=SPATIAL, formula=spatial, method=method)
        errors.append(abs(found.matrix * sign - wanted).max() / abs(wanted).max())
    assert errors[0] > 5 * errors[1] > 25 * errors[2], errors
    assert errors[2] < 2e-4, errors


RUNS = [(sr.HHT(), 1e-8, 1e-4), (sr.Radau(), 1e-7, 1e-5), (sr.Radau(), 1e-9, 2e-7)]


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("method", "rtol", "reached"), RUNS)
def test_the_published_slider_crank_of_sundials(method: object, rtol: float, reached: float) -> None:
    """Its published gradient of the kinetic energy's integral: dG/dk = 0.33346, dG/dc = -0.36375."""
    told = json.loads((FOLDER / "S04_sundials_slider_crank.json").read_text())
    system, names = sundials_crank(), list(SUNDIALS)
    responses = {
        "x2_T": sr.Final("slider.x"),
        "G": sr.Integral("energy.kinetic"),
        "int_(x2-1)^2": sr.Integral(lambda o: (o("slider.x") - 1) ** 2),
        "w_T": sr.Final("bearing.angle.rate"),
    }
    run = sr.simulate(
        system, until=10.0, t_eval=[10.0], method=replace(method, rtol=rtol, atol=rtol), store="steps"
    )
    found = sr.sensitivity(run, list(responses.values()), names, design=SUNDIALS, formula=sundials)
    for row, name in enumerate(responses):
        assert found.values[row] == pytest.approx(told["psi"][name], rel=2 * reached)
        wanted = [told["grad"][name][parameter] for parameter in names]
        assert np.allclose(found.matrix[row], wanted, rtol=0, atol=reached * np.abs(wanted).max())


def test_a_body_that_turns_freely() -> None:
    told = json.loads((FOLDER / "S08_free_top.json").read_text())
    body = sr.Body("top", mass=1.0, inertia=(1.0, 2.5, 3.0), angular_velocity=(0.3, 2.0, 0.1))
    system = sr.System(sr.Model("top", bodies=[body]))
    names = [*(f"top.inertia.{a}{a}" for a in "xyz"), *(f"top.angular_velocity.{a}" for a in "xyz")]
    run = sr.simulate(system, until=5.0, t_eval=[5.0], method=sr.Radau(rtol=1e-8, atol=1e-8), store="steps")
    found = sr.sensitivity(run, [sr.Final(f"top.e{n}") for n in range(4)], names)
    wanted = np.array(
        [[told["grad"][f"e{n}"][p] for p in ("J1", "J2", "J3", "w1", "w2", "w3")] for n in range(4)]
    )
    assert np.allclose(found.matrix, wanted, rtol=0, atol=1e-4 * abs(wanted).max())
