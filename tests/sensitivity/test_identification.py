"""The quarter car's suspension from its measured motion: the misfit's gradient, and the numbers that made the data."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.sensitivity.cases import quarter_car
from tests.sensitivity.test_references import FOLDER

import sarrus as sr

TOLD = json.loads((FOLDER / "S11_quarter_car_ident.json").read_text())
NAMES = {"ks": "strut.k", "cs": "strut.c", "kt": "tyre.k"}
TRUE = [TOLD["p_true"][name] for name in NAMES]
MISFIT = sr.Misfit(
    lambda o: o("chassis.z") - 1,
    at=tuple(0.02 * np.arange(1, 101)),
    data=tuple(TOLD["data"]),
    sigma=1e-3,
    name="misfit",
)


@pytest.mark.parametrize(("method", "reached"), [(sr.HHT(), 2e-3), (sr.Radau(), 1e-7)])
def test_the_gradient_of_the_misfit(method: object, reached: float) -> None:
    wanted, errors = np.array([TOLD["grad"][name] for name in NAMES]), []
    for tolerance in (1e-6, 1e-8):
        settings = {"method": replace(method, rtol=tolerance, atol=1e-2 * tolerance), "store": "steps"}
        run = sr.simulate(quarter_car(), until=2.0, t_eval=[2.0], **settings)
        found = sr.sensitivity(run, MISFIT, list(NAMES.values()))
        errors.append(abs(found.matrix[0] / wanted - 1).max())
    assert found.values[0] == pytest.approx(TOLD["J"], rel=reached)
    assert errors[0] > 8 * errors[1], errors
    assert errors[1] < reached, errors


@pytest.mark.slow
@pytest.mark.parametrize(("method", "reached"), [(sr.HHT(), 1e-3), (sr.Radau(), 1e-6)])
def test_gauss_newton_finds_the_numbers_that_made_the_data(method: object, reached: float) -> None:
    """What remains is the error of the simulations; it falls with their tolerance."""
    errors = []
    for tolerance in (1e-6, 1e-8):
        settings = {"method": replace(method, rtol=tolerance, atol=1e-2 * tolerance)}
        found = sr.fit(quarter_car(), MISFIT, list(NAMES.values()), **settings)
        assert found.success, found.message
        errors.append(abs(found.x / TRUE - 1).max())
    assert errors[0] > 8 * errors[1], errors
    assert errors[1] < reached, errors


def test_jacobians_of_the_residuals() -> None:
    """JᵀJ as the reference has it, by which Gauss and Newton step."""
    settings = {"method": sr.Radau(rtol=1e-7, atol=1e-9)}
    p = sr.Problem(quarter_car(), MISFIT, list(NAMES.values()), until=2.0, **settings)
    rows = p.at(p.x0).signals()[1][0] / MISFIT.sigma
    wanted = np.array(TOLD["gauss_newton"])
    size = np.sqrt(np.diag(wanted))
    assert abs((rows.T @ rows - wanted) / np.outer(size, size)).max() < 2e-3
