"""Numbers of tables and formulas: their gradients forward and backward, and those of differenced simulations."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.sensitivity.frozen import again, differenced, solved
from tests.sensitivity.zoo import zoo

import sarrus as sr
from sarrus.analyses.sensitivity.derivatives import differentiated
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.model.written import with_numbers, written_numbers
from sarrus.system.curves.curve_derivatives import CurveDerivatives
from sarrus.system.operators.element_values import memory_places

# Derivatives by HHT and generalized-α are compared with differences of the same steps, not with the exact motion
pytestmark = []

FORCE = [[0, 1], [0.3, 2], [0.5, 1.5], [0.8, 2], [1.2, 0.5]]
LAW = [[-1, -12], [0.5, 5], [1.5, 20], [2.5, 45]]
RESPONSES = [
    sr.Final("tip.x"),
    sr.Final("tip.velocity.y"),
    sr.Integral(lambda o: o("tip.x") ** 2, name="square"),
    sr.Final("elbow.force.x"),
    sr.At("motor.multiplier.1", time=0.4),
]
ARM = """
name: arm
parameters: {size: 0.1, rate: 3, push: 2}
bodies:
  arm: {mass: 1, inertia: [1, 1, 1], position: [0.5, 0, 0]}
  tip: {mass: 0.7, inertia: [0.1, 0.2, 0.3], position: [1.5, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, arm], point: [0, 0, 0], axis: [0, 0, 1]}
  elbow: {type: revolute, bodies: [arm, tip], point: [1, 0, 0], axis: [0, 0, 1]}
drivers:
  motor: {type: angle, joint: pin, motion: "2*t + size*sin(rate*t)^2"}
forces:
  load: {type: point_force, point: {body: tip, at: [0, 0, 0]}, force: [1, 2, 3],
         factor: {table: [[0, "push/2"], [0.5, 2], [1.2, 1]]}}
  spring: {type: tsda, points: [{body: tip, at: [0, 0, 0]}, {body: ground, at: [0.2, 1.5, 0.1]}],
           k: "5 N/m * x + 100 N/m^3 * size*x^3", length: 0.7, c: 3}
"""


def arm() -> sr.Model:
    """Two links: the first is driven by a formula, at the second pull a table over time and one over length."""
    body, tip = (
        sr.Body("arm", mass=1, inertia=(1, 1, 1), position=(0.5, 0, 0)),
        sr.Body("tip", mass=0.7, inertia=(0.1, 0.2, 0.3), position=(1.5, 0, 0)),
    )
    pin = sr.Revolute("pin", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    elbow = sr.Revolute("elbow", body, tip, point=(1, 0, 0), axis=(0, 0, 1))
    load = sr.PointForce("load", tip.point(0, 0, 0), force=(1, 2, 3), factor=FORCE)
    ends = tip.point(0.1, 0, 0), sr.ground.point(0.2, 1.5, 0.1)
    return sr.Model(
        "arm", bodies=[body, tip], joints=[pin, elbow], gravity=(0, -9.81, 0),
        drivers=[sr.AngleDriver("motor", "pin.angle", "2*t + 0.1*sin(3*t)**2")],
        forces=[load, sr.TSDA("spring", *ends, k=LAW, c=3, length=0.7)],
    )  # fmt: skip


MOTION = [f"motor.motion.{n}" for n in (1, 2, 3)]
NAMES = [*MOTION, *(f"load.factor.{n}.y" for n in range(1, 6)), *(f"spring.k.{n}.y" for n in range(1, 5))]


METHODS = {"HHT": sr.HHT(), "Radau": sr.Radau()}


@cache
def swung(method: str = "HHT") -> sr.Trajectory:
    settings = {"store": "steps", "method": replace(METHODS[method], rtol=1e-5, atol=1e-7)}
    return solved(sr.simulate(sr.System(arm()), until=1.0, t_eval=[1.0], **settings), METHODS[method])


@cache
def found(way: str, method: str = "HHT") -> np.ndarray:
    return sr.sensitivity(swung(method), RESPONSES, NAMES, method=way).matrix


def test_they_are_numbers_of_the_model() -> None:
    known = written_numbers(arm())
    assert [name for name in known if name in NAMES] == NAMES
    assert known["motor.motion.3"] == 3
    assert known["load.factor.5.y"] == 0.5
    changed = with_numbers(arm(), {"motor.motion.2": 0.2, "load.factor.1.y": 7.0})
    assert written_numbers(changed)["motor.motion.2"] == 0.2
    assert written_numbers(changed)["load.factor.1.y"] == 7.0


@pytest.mark.parametrize("method", METHODS)
def test_forward_and_backward_agree(method: str) -> None:
    scale = abs(found("adjoint", method)).max(axis=1, keepdims=True)
    assert np.all(abs(found("direct", method) - found("adjoint", method)) < 1e-10 * scale)


def test_changes_of_the_step_size_remove_defects() -> None:
    assert np.count_nonzero(swung().steps.removed) > 5


@pytest.mark.one_in(8)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", NAMES)
def test_gradients_are_those_of_differenced_simulations(name: str, method: str) -> None:
    wanted = differenced(swung(method), RESPONSES, name, 1e-3, METHODS[method])
    own = found("adjoint", method)
    limits = np.array([1e-9, 1e-9, 1e-9, 1e-7, 1e-7]) * abs(own).max(axis=1)
    assert np.all(abs(own[:, NAMES.index(name)] - wanted) < limits)


def test_parameters_of_a_file_that_stand_in_functions(tmp_path: Path) -> None:
    """A parameter in a motion, in a table and in a law: those of a file that has another number there."""
    names, columns = ["size", "rate", "push"], []
    (tmp_path / "arm.yaml").write_text(ARM)
    run = sr.simulate(
        sr.System(sr.load(tmp_path / "arm.yaml")),
        until=0.5,
        method=sr.Radau(rtol=1e-6, atol=1e-8),
        store="steps",
    )
    gradient = sr.sensitivity(run, RESPONSES[:3], names)
    assert abs(gradient.matrix).max(axis=0).min() > 1e-3

    def values(name: str, value: float) -> np.ndarray:
        other = sr.System(sr.load(tmp_path / "arm.yaml", parameters={name: value}))
        return sr.Problem(other, RESPONSES[:3], [], until=0.5, method=sr.Radau(rtol=1e-9, atol=1e-11)).values(
            []
        )

    for name, value in zip(names, (0.1, 3.0, 2.0), strict=True):
        columns.append((values(name, value + 1e-3) - values(name, value - 1e-3)) / 2e-3)
    assert gradient.matrix == pytest.approx(np.array(columns).T, rel=2e-3, abs=1e-5)


def test_the_change_of_an_operator_at_one_time() -> None:
    """Q is linear in the values of a table: the difference is exact."""
    system, rest = sr.System(arm()), np.zeros(14)
    t = 0.4
    moved = sr.System(with_numbers(arm(), {"load.factor.3.y": 2.5}))
    wanted = moved.Q(system.q0, rest, t) - system.Q(system.q0, rest, t)
    matrix = CurveDerivatives(system).matrix("Q", system.b, t, q=system.q0, v=rest)
    assert matrix @ (moved.b - system.b) == pytest.approx(wanted, rel=1e-12, abs=1e-12)


def test_the_change_of_an_operator_at_many_times_is_that_at_each() -> None:
    """Also where elements remember something else at every time; forward and backward."""
    system, draw = zoo(), np.random.default_rng(8).normal
    assert len(memory_places(system.populations)) > 0
    t, q, v = np.linspace(0, 1, 3), system.q0 + 0.1 * draw(size=(3, system.nq)), draw(size=(3, system.nq))
    memory = {int(place): draw(size=3) for place in memory_places(system.populations)}
    of, db = CurveDerivatives(system), np.zeros((len(system.b), 2))
    db[system.nb :] = draw(size=(len(system.b) - system.nb, 2))
    entries = of("Q", system.b, memory, q=q, v=v, t=t)
    along, total, weights = entries.along(db, system.nq), 0.0, draw(size=(3, system.nq, 2))
    for n in range(3):
        b = system.b.copy()
        b[[*memory]] = [values[n] for values in memory.values()]
        matrix = of.matrix("Q", b, float(t[n]), q=q[n], v=v[n])
        assert along[n] == pytest.approx(matrix @ db, rel=1e-10, abs=1e-10)
        total = total + matrix.T @ weights[n]
    assert entries.gradient(weights, of.width) == pytest.approx(total, rel=1e-10, abs=1e-10)


EVERYTHING = [*NAMES, "spring.c", "tip.mass", "spring.length"]
DIRECTION = 0.3 * np.random.default_rng(0).normal(size=len(EVERYTHING))


def differenced_gradients(
    run: sr.Trajectory, responses: list, names: list, direction: np.ndarray, method
) -> np.ndarray:
    """Richardson's extrapolation of differences of exact gradients along a direction (r, p)."""
    at = Parameters(run.system, names).values

    def gradient(e: float) -> np.ndarray:
        system, steps = again(
            run.system, run.steps, method, dict(zip(names, at + e * direction, strict=True))
        )
        return differentiated(system, steps, responses, Parameters(system, names, start=steps.start)).matrix

    slopes = [(gradient(e) - gradient(-e)) / (2 * e) for e in (4e-3, 2e-3)]
    return (4 * slopes[1] - slopes[0]) / 3


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_hessians_by_tables_and_formulas_are_those_of_differenced_gradients(method: str) -> None:
    run = swung(method)
    wanted = differenced_gradients(run, RESPONSES, EVERYTHING, DIRECTION, METHODS[method])
    for response, row in zip(RESPONSES, wanted, strict=True):
        found = sr.hessian(run, response, EVERYTHING)
        assert found.asymmetry < 1e-11  # Radau's multipliers have round-off of 1e-12 in some steps
        assert found.matrix @ DIRECTION == pytest.approx(row, rel=0, abs=1e-7 * abs(row).max())


@pytest.mark.one_in(2)
@pytest.mark.parametrize("method", METHODS)
def test_laws_that_are_not_linear_in_their_constants(method: str) -> None:
    """In forces, and in outputs that are made of the same laws, as the energy stored in a spring."""
    bob = sr.Body("bob", mass=1, inertia=(0.1, 0.2, 0.3), position=(0, 0, -1), velocity=(0.3, 0, 0))
    laws = {"k": "20*x*exp(0.5*x) + 30*x^3/(1.5 + x^2)", "c": "0.3*x*(1 + 0.2*x^2)"}
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), bob.point(0, 0, 0.1), length=0.7, **laws)
    system = sr.System(sr.Model("hung", bodies=[bob], forces=[spring], gravity=(0, 0, -9.81)))
    settings = {"store": "steps", "method": replace(METHODS[method], rtol=1e-6, atol=1e-8)}
    run = sr.simulate(system, until=0.4, **settings)
    responses = [sr.Final("energy.potential"), sr.Integral("spring.tension"), sr.Final("bob.velocity.z")]
    names = [name for name in written_numbers(system.model) if name.startswith(("spring.k", "spring.c"))]
    direction = 0.3 * np.random.default_rng(1).normal(size=len(names))
    wanted = differenced_gradients(run, responses, names, direction, METHODS[method])
    for response, row in zip(responses, wanted, strict=True):
        found = sr.hessian(run, response, names)
        assert found.asymmetry < 1e-13
        assert found.matrix @ direction == pytest.approx(row, rel=0, abs=1e-9 * abs(row).max())


@pytest.mark.parametrize("method", METHODS)
def test_a_mass_under_forces_of_a_table_and_a_formula(method: str) -> None:
    """The speed a (exp(c t) - 1)/(c m) after a force a exp(c t): closed forms."""
    ball = sr.Body("ball", mass=2, inertia=(1, 1, 1), position=(1, 0, 0))
    law = sr.PointForce("push", ball.point(0, 0, 0), force=(0, 1, 0), factor="1.5*exp(0.8*t)")
    system = sr.System(sr.Model("pushed", bodies=[ball], forces=[law]))
    run = sr.simulate(
        system, until=1.0, store="steps", method=replace(METHODS[method], rtol=1e-9, atol=1e-11)
    )
    a, c, m = 1.5, 0.8, 2.0
    found = sr.hessian(run, "ball.velocity.y", ["push.factor.1", "push.factor.2", "ball.mass"]).matrix
    area, slope = (np.exp(c) - 1) / c, np.exp(c) / c - (np.exp(c) - 1) / c**2  # of exp(c t), and by c
    bend = np.exp(c) / c - 2 * np.exp(c) / c**2 + 2 * (np.exp(c) - 1) / c**3
    wanted = [
        [0, slope / m, -area / m**2],
        [slope / m, a * bend / m, -a * slope / m**2],
        [-area / m**2, -a * slope / m**2, 2 * a * area / m**3],
    ]
    assert found == pytest.approx(np.array(wanted), rel=1e-8 if method == "Radau" else 1e-5, abs=1e-9)


def test_formulas_that_cancel_have_more_constants_than_steps() -> None:
    """Derivatives by their constants were added to those by the next law's: y = ½ a t³/3! and z = ½ c t²/2."""
    body = sr.Body("m", mass=2, inertia=(1, 1, 1))
    load = sr.PointForce("load", body.point(0, 0, 0), ("(sin(2*t) + cos(3*t) + 4*sin(5*t))*0", "3*t", 0))
    system = sr.System(sr.Model("pushed", bodies=[body], forces=[load]))
    run = sr.simulate(system, until=1.0, store="steps", method=sr.Radau(max_step=0.05))
    found = sr.sensitivity(run, ["m.x", "m.y", "m.z"], "load.force")
    wave = (1 - np.sin(2) / 2) / 2 + (1 - np.cos(3)) / 9 + 4 * (1 - np.sin(5) / 5) / 5
    wanted = np.zeros((3, len(found.names)))
    for row, (name, value) in enumerate({"x.5": wave / 2, "y.1": 1 / 12, "z": 1 / 4}.items()):
        wanted[row, found.names.index(f"load.force.{name}")] = value
    assert found.matrix == pytest.approx(wanted, rel=1e-5, abs=1e-12)
