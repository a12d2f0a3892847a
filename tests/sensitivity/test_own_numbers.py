"""Responses that read a number of the model themselves, whatever the number follows from."""

import numpy as np
import pytest
from tests.sensitivity.cases import spatial_slider_crank

import sarrus as sr

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly

CASE = spatial_slider_crank()
SETTINGS = {"method": sr.Radau(rtol=1e-4, atol=1e-5)}
FILE = """
name: mass on a spring
parameters: {softness: 0.1 m/N, stiffness: 1/softness}
bodies:
  mass: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}
forces:
  spring:
    type: tsda
    points: [{body: ground, at: [0, 0, 0]}, {body: mass, at: [0, 0, 0]}]
    k: stiffness
    length: 0.8 m
"""


def stretched(number: str, name: str = "") -> sr.Integral:
    return sr.Integral(lambda o: o.parameter(number) * o("spring.length") ** 3, name=name or number)


RESPONSES = [stretched(number) for number in ("l0", "spring.length", "spring[tsda].length")]


@pytest.mark.parametrize("method", ["adjoint", "direct"])
def test_a_number_that_follows_from_the_design(method: str) -> None:
    run = CASE.run(until=0.5, t_eval=[0.5], **SETTINGS)
    named = {"design": CASE.design, "formula": CASE.formula, "method": method}
    found = sr.sensitivity(run, RESPONSES, ["k", "l0"], **named).matrix
    by_itself = sr.sensitivity(run, RESPONSES[1:], ["spring.k", "spring.length"], method=method).matrix
    for other in (*found[1:], *by_itself):
        assert other == pytest.approx(found[0], rel=1e-10)
    least = sr.sensitivity(run, sr.Integral(lambda o: o("spring.length") ** 3), ["spring.length"])
    assert found[0, 1] == pytest.approx(least.values[0] + 5.0 * least.matrix[0, 0], rel=1e-10)


def test_second_derivatives_go_the_same_way() -> None:
    run = CASE.run(until=0.5, t_eval=[0.5], **SETTINGS)
    named = {"design": {"root": np.sqrt(5.0)}, "formula": lambda d: {"spring.length": d["root"] ** 2}}
    found, other = (
        sr.hessian(run, sr.Integral(of), ["root"], **named).matrix
        for of in (
            lambda o: o.parameter("root") ** 2 * o("spring.length"),
            lambda o: o.parameter("spring.length") * o("spring.length"),
        )
    )
    assert other == pytest.approx(found, rel=1e-10)


def test_products_of_a_problem_go_the_same_way() -> None:
    named = {"design": dict(CASE.design), "formula": CASE.formula}
    p = sr.Problem(CASE.system, RESPONSES[:2], ["k", "l0"], until=0.3, **named, **SETTINGS)
    rows = p.gradient(p.x0).matrix
    assert rows[1] == pytest.approx(rows[0], rel=1e-10)
    assert p.jvp(p.x0, np.array([0.3, 1.0])) == pytest.approx(rows @ [0.3, 1.0], rel=1e-9)
    assert p.vjp(p.x0, np.array([0.3, 1.0])) == pytest.approx(rows.T @ [0.3, 1.0], rel=1e-9)


def test_a_parameter_of_a_file_that_follows_from_another(tmp_path: object) -> None:
    path = tmp_path / "spring.yaml"
    path.write_text(FILE)
    system = sr.System(sr.load(path))
    run = sr.simulate(system, until=0.5, t_eval=[0.5], store="steps", **SETTINGS)
    responses = [
        sr.Integral(lambda o: o("spring.length") / o.parameter("softness"), name="softness"),
        sr.Integral(lambda o: o("spring.length") * o.parameter("stiffness"), name="stiffness"),
        sr.Integral(lambda o: o("spring.length") * o.parameter("spring.k"), name="spring.k"),
    ]
    found = sr.sensitivity(run, responses, ["softness"]).matrix
    assert found[1:] == pytest.approx(np.tile(found[0], (2, 1)), rel=1e-10)


def test_without_numbers_responses_have_values_alone() -> None:
    found = sr.sensitivity(CASE.run(until=0.1, t_eval=[0.1], **SETTINGS), RESPONSES[1:], [])
    assert found.matrix.shape == (2, 0)
    assert found.values[0] == pytest.approx(found.values[1])
