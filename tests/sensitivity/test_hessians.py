"""Second derivatives: symmetric, those of differenced gradients, Taylor's remainder of order three, references."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.sensitivity.designs import SUNDIALS, sundials, sundials_crank
from tests.sensitivity.frozen import again, solved
from tests.sensitivity.test_all_elements import changes
from tests.sensitivity.test_all_elements import swung as all_swung
from tests.sensitivity.test_gradients import METHODS, RESPONSES, ROUGH
from tests.sensitivity.test_gradients import swung as alpha_swung
from tests.sensitivity.test_references import FOLDER
from tests.sensitivity.zoo import zoo
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.sensitivity.derivatives import differentiated
from sarrus.analyses.sensitivity.lagrangians.changes import change_at
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.responses.evaluation import Evaluation

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly

NAMES = [
    *(
        "spring.k",
        "rod.mass",
        "crank.inertia.xx",
        "spring.length",
        "gravity.z",
        "pin.point.y",
        "ball.point.z",
    ),
    *("crank.orientation.angle", "crank.angular_velocity.x", "slider.velocity.x", "spring.point_i.y"),
]
EVERY = METHODS | {"Radau": sr.Radau()}
DIRECTION = np.random.default_rng(0).normal(size=len(NAMES))


@cache
def swung(method: str) -> sr.Trajectory:
    if method in METHODS:
        return alpha_swung(method)
    run = sr.simulate(
        slider_crank(), until=0.8, method=replace(EVERY[method], rtol=2e-6, atol=1e-8), store="steps"
    )
    return solved(run, EVERY[method])


def moved(size: float, method: str) -> tuple[np.ndarray, np.ndarray]:
    """Responses and their gradients along the direction, with the same steps."""
    run = swung(method)
    at = Parameters(run.system, NAMES).values + size * DIRECTION
    system, steps = again(run.system, run.steps, EVERY[method], dict(zip(NAMES, at, strict=True)))
    parameters = Parameters(system, NAMES, start=steps.start)
    evaluation = Evaluation(system, steps, RESPONSES, parameters)
    found = differentiated(system, steps, RESPONSES, parameters, evaluation=evaluation)
    return evaluation.values, found.matrix


@pytest.mark.one_in(5)
@pytest.mark.parametrize("method", EVERY)
def test_products_are_those_of_differenced_gradients(method: str) -> None:
    e = 4e-3  # smaller changes leave more round-off, of "maximum" 2e-7 at 1e-3
    slopes = [(moved(x, method)[1] - moved(-x, method)[1]) / (2 * x) for x in (e, e / 2)]
    wanted = (4 * slopes[1] - slopes[0]) / 3
    for row, response in enumerate(RESPONSES):
        rough = 1e-5 if any(word in response.title for word in ROUGH) else 1e-7
        if "maximum" in response.title and method in METHODS:
            rough = (
                1e-3  # short steps have a polynomial each, and other samples show the extreme after a change
            )
        found = sr.hessian_product(swung(method), response, dict(zip(NAMES, DIRECTION, strict=True)))
        error = abs(found - wanted[row]).max() / abs(wanted[row]).max()
        assert error < rough, response.title


@pytest.mark.one_in(8)
@pytest.mark.parametrize("method", ["HHT", "Radau"])
@pytest.mark.parametrize("row", [0, 2, 3, 6, 9])
def test_hessians_are_symmetric(row: int, method: str) -> None:
    found = sr.hessian(swung(method), RESPONSES[row], NAMES[:5])
    assert found.asymmetry < 1e-11
    assert found["spring.k", "rod.mass"] == pytest.approx(found["rod.mass", "spring.k"])


def test_the_correction_of_a_start_has_second_derivatives() -> None:
    """A guess contradicts the constraints; the metric of the correction depends on the lever arms of the joints."""
    system, names = slider_crank(), ["pin.point.y", "ball.point.z", "slider.velocity.x", "rod.mass"]
    random, direction = np.random.default_rng(5), np.array([1.0, -0.7, 0.4, 0.5])
    guess = system.q0 + 0.1 * random.normal(size=system.nq), random.normal(size=system.nq)
    settings = {"store": "steps", "method": replace(EVERY["Radau"], rtol=1e-3, atol=1e-6)}
    run = sr.simulate(system, sr.assemble(system, *guess), until=2e-3, **settings)
    values, response = Parameters(system, names).values, sr.Final("slider.velocity.x")

    def slopes(size: float) -> np.ndarray:
        at = dict(zip(names, values + size * direction, strict=True))
        system, steps = again(run.system, run.steps, settings["method"], at, guess=guess)
        parameters = Parameters(system, names, start=steps.start)
        evaluation = Evaluation(system, steps, [response], parameters)
        return differentiated(system, steps, [response], parameters, evaluation=evaluation).matrix[0]

    wanted = [(slopes(e) - slopes(-e)) / (2 * e) for e in (4e-3, 2e-3)]
    found = sr.hessian_product(run, response, dict(zip(names, direction, strict=True)))
    assert found == pytest.approx((4 * wanted[1] - wanted[0]) / 3, rel=1e-6, abs=1e-8)
    assert sr.hessian(run, response, names).asymmetry < 1e-11


@pytest.mark.one_in(2)
@pytest.mark.parametrize("method", ["HHT", "Radau"])
def test_what_a_hessian_leaves_falls_with_the_cube(method: str) -> None:
    run, rest = swung(method), []
    gradient = sr.sensitivity(run, RESPONSES[:4], NAMES)
    bend = [
        sr.hessian_product(run, r, dict(zip(NAMES, DIRECTION, strict=True))) @ DIRECTION
        for r in RESPONSES[:4]
    ]
    for size in (4e-2, 2e-2, 1e-2):
        there = moved(size, method)[0][:4]
        model = gradient.values + size * gradient.matrix @ DIRECTION + 0.5 * size**2 * np.array(bend)
        rest.append(abs(there - model))
    slopes = np.log2(np.array(rest[:-1]) / np.array(rest[1:]))
    assert np.all(abs(slopes - 3) < 0.25), slopes


@pytest.mark.slow
def test_the_hessian_of_the_published_slider_crank() -> None:
    told = json.loads((FOLDER / "S04_sundials_slider_crank.json").read_text())
    wanted, names = np.array(told["hess_G"]), list(SUNDIALS)
    run = sr.simulate(
        sundials_crank(), until=10.0, t_eval=[10.0], method=sr.Radau(rtol=1e-7, atol=1e-7), store="steps"
    )
    found = sr.hessian(run, sr.Integral("energy.kinetic"), names, design=SUNDIALS, formula=sundials)
    assert found.asymmetry < 1e-9
    assert abs(found.matrix - wanted).max() < 2e-3 * abs(wanted).max()


def test_the_hessian_of_the_spatial_slider_crank() -> None:
    told = json.loads((FOLDER / "slider_crank_gradients.json").read_text())["hessian_of_response_2_T2"]
    wanted = np.array(told["value"])
    names = [{"spring.length0": "spring.length"}.get(name, name) for name in told["parameters"]]
    run = sr.simulate(
        slider_crank(), until=2.0, t_eval=[2.0], method=sr.Radau(rtol=1e-7, atol=1e-7), store="steps"
    )
    squared = sr.Integral(lambda o: o("slider.velocity.x") ** 2)
    found = sr.hessian(run, squared, names)
    assert abs(found.matrix - wanted).max() < 2e-3 * abs(wanted).max()


@pytest.mark.parametrize(("rtol", "limit"), [(1e-5, 1e-4), (1e-7, 2e-6), (1e-9, 5e-8)])
def test_with_radau_it_comes_near_to_that_of_the_motion(rtol: float, limit: float) -> None:
    told = json.loads((FOLDER / "slider_crank_gradients.json").read_text())["hessian_of_response_2_T2"]
    wanted = np.array(told["value"])
    names = [{"spring.length0": "spring.length"}.get(name, name) for name in told["parameters"]]
    settings = {"store": "steps", "method": sr.Radau(rtol=rtol, atol=rtol)}
    run = sr.simulate(slider_crank(), until=2.0, t_eval=[2.0], **settings)
    found = sr.hessian(run, sr.Integral(lambda o: o("slider.velocity.x") ** 2), names)
    assert found.asymmetry < 1e-12
    assert abs(found.matrix - wanted).max() < limit * abs(wanted).max()


@pytest.mark.slow
def test_second_derivatives_of_every_element() -> None:
    """The change of the contracted first derivatives, along a change of everything at once."""
    system, steps = zoo(), all_swung().steps
    random, m = np.random.default_rng(4), system.m
    db = 0.1 * changes(all_swung(), 1)[0][:, 0]
    state = {"q": steps.q[3], "v": steps.v[3], "a": steps.a[3]}
    dots = {name: random.normal(size=system.nq) for name in state}
    xi, lam, nu, lam_dot = (random.normal(size=n) for n in (system.nq, m, m, m))
    b, t = steps.b.copy(), 0.05
    b[steps.places] = steps.memory[3]

    def by_q_and_b(e: float) -> np.ndarray:
        q, v, a = (state[name] + e * dots[name] for name in ("q", "v", "a"))
        at, numbers = lam + e * lam_dot, b + e * db
        rows = system.Phi_qT_lam_q(q, at, t, b=numbers) + system.M_a_q(q, a, b=numbers)
        forces = system.Q_q(q, v, t, b=numbers) + system.S_q(q, v, b=numbers)
        by_b = [(system.Phi_b(q, t, b=numbers).T @ nu), system.Phi_qT_lam_b(q, at, t, b=numbers).T @ xi]
        by_b += [system.M_a_b(q, a, b=numbers).T @ xi, -(system.Q_b(q, v, t, b=numbers).T @ xi)]
        by_b += [-(system.S_b(q, v, b=numbers).T @ xi)]
        return np.concatenate([(rows - forces).T @ xi + system.Phi_q(q, t, b=numbers).T @ nu, sum(by_b)])

    given = state | {f"{name}_dot": dot for name, dot in dots.items()}
    change = change_at(system, "step", t, b, db, lam, nu, lam_dot, xi=xi, **given)
    slopes = [(by_q_and_b(e) - by_q_and_b(-e)) / (2 * e) for e in (1e-4, 5e-5)]
    wanted, nq = (4 * slopes[1] - slopes[0]) / 3, system.nq
    own = db[: system.nb] != 0
    assert abs(change.q - wanted[:nq]).max() < 1e-8 * abs(wanted[:nq]).max()
    assert abs(change.b[: system.nb][own] - wanted[nq:][own]).max() < 1e-8 * abs(wanted[nq:][own]).max()


def test_a_direction_must_name_known_numbers() -> None:
    with pytest.raises(ValueError, match="is not among the parameters"):
        sr.hessian_product(swung("HHT"), "slider.x", {"spring.c": 1.0}, ["spring.k"])
