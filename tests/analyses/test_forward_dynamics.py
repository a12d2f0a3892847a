"""Forward dynamics as a function: against dense solutions, and its derivatives against differences of the function."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numba import njit
from tests.analyses.least_reactions import least
from tests.analyses.test_linearization import cart_pole, four_bar

import sarrus as sr
from sarrus.analyses.position.coordinate_set import of_names
from sarrus.model.written import with_numbers, written_numbers


def dense(system: sr.System, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """a and the shortest λ by singular values."""
    M, J = system.M(q).toarray(), system.Phi_q(q).toarray()
    K = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    right = np.concatenate([system.Q(q, v, 0.0) + system.S(q, v), system.gamma(q, v)])
    a = np.linalg.lstsq(K, right, rcond=1e-11)[0][: len(q)]
    return a, least(system, q, right[: len(q)] - M @ a)


def test_a_loop_with_redundant_constraints() -> None:
    system = four_bar()
    for rate in (3.0, -1.0):
        start = sr.assemble(system, rates={"a": rate})
        a, lam = dense(system, start.q, start.v)
        found = system.forward_dynamics(start.q, start.v)
        assert found.a == pytest.approx(a, abs=1e-9 * abs(a).max())
        assert found.lam == pytest.approx(lam, abs=1e-9 * abs(lam).max())


def test_derivatives_are_those_of_the_function() -> None:
    system = sr.System(sr.load("slider_crank"))
    start = sr.assemble(system, rates={"pin": 2.0})
    check(system, start.q, start.v, {})
    system = cart_pole()
    q = system.q0 + 0.02 * np.cos(np.arange(14.0))  # off the constraints, too
    check(system, q, np.sin(np.arange(14.0)), {"u": 3.0})


def loaded() -> sr.System:
    """A four-bar with weights across its plane, which three redundant equations bear, too."""
    return sr.System(replace(four_bar().model, gravity=(0, -9.0, -5.0)))


def test_multipliers_of_redundant_constraints_along_their_motion() -> None:
    """Derivatives by the angle and its rate, of the reported multipliers of assembled states."""
    system, h = loaded(), 1e-3
    assert system.forward_dynamics(system.q0, system.v0).lam.shape == (system.m,)
    plant = sr.linearize(system, sr.assemble(system, rates={"a": 2.0}), coordinates=["a.angle"])
    found = system.forward_dynamics.derivatives(plant.q, plant.v)
    moved = found.lam_q @ plant.q_x + found.lam_v @ plant.v_x

    def reported(change: np.ndarray) -> np.ndarray:
        q, v = moved_to(system, plant, "a.angle", change)
        return dense(system, q, v)[1]

    for k, e in enumerate(np.eye(2)):
        f = [reported(n * h * e) for n in (-2, -1, 1, 2)]
        wanted = (f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h)
        assert moved[:, k] == pytest.approx(wanted, abs=1e-7 * abs(wanted).max())


def moved_to(
    system: sr.System, plant: sr.StateSpace, name: str, change: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The state whose coordinate and rate have changed, by Newton's method."""
    of, q, none = of_names(system, (name,)), plant.q + plant.q_x @ change, np.zeros(system.nq)
    for _ in range(6):
        rows = np.vstack([system.Phi_q(q).toarray(), of.gradients(q)])
        gap = np.concatenate([system.Phi(q), of.values(q, none)[0] - plant.x0[0] - change[0]])
        q = q - np.linalg.lstsq(rows, gap, rcond=1e-9)[0]
    rows = np.vstack([system.Phi_q(q).toarray(), of.gradients(q)])
    right = np.append(np.zeros(system.m), plant.x0[1] + change[1])
    return q, np.linalg.lstsq(rows, right, rcond=1e-9)[0]


@pytest.mark.parametrize("redundant", [False, True])
def test_derivatives_by_parameters(redundant: bool) -> None:
    """Differences of the function of b, and of systems of other parameters, at constant q and v."""
    system = loaded() if redundant else sr.System(sr.load("slider_crank"))
    joint, names = (
        ("a", ["coupler.mass", "a.point.x"])
        if redundant
        else ("pin", ["spring.k", "rod.mass", "ball.point.x"])
    )
    start, f = sr.assemble(system, rates={joint: 2.0}), system.forward_dynamics
    found = f.derivatives(start.q, start.v, wrt=names)
    alone = f.derivatives(start.q, start.v, b=system.b, wrt=system.parameter_names[0])
    assert alone.a_b.shape == (system.nq, 1)
    own = written_numbers(system.model)
    for k, name in enumerate(names):
        h = 1e-3 * (own[name] or 1.0)
        others = [sr.System(with_numbers(system.model, {name: own[name] + n * h})).b for n in (-2, -1, 1, 2)]
        near = [np.concatenate(f(start.q, start.v, b=b)) for b in others]
        wanted = (near[0] - 8 * near[1] + 8 * near[2] - near[3]) / (12 * h)
        exact = np.concatenate([found.a_b[:, k], found.lam_b[:, k]])
        assert exact == pytest.approx(wanted, abs=1e-8 * abs(wanted).max())
    with pytest.raises(sr.SarrusError, match=r"is no parameter of an element. Leave out b"):
        f.derivatives(start.q, start.v, b=system.b, wrt=names)
    place = system.parameter_names[0]
    same = (
        f.derivatives(start.q, start.v, b=system.b, wrt=[place]),
        f.derivatives(start.q, start.v, wrt=[place]),
    )
    assert np.array_equal(same[0].a_b, same[1].a_b)


def test_the_acceleration_of_a_pendulum_bends_in_closed_form() -> None:
    """θ̈ = -(m g r sin θ + c θ̇² - u cos θ)/J: second derivatives by θ, θ̇ and u."""
    m, r, J, g, c = 2.0, 0.5, 0.2 + 2.0 * 0.25, 9.81, 0.3
    arm = sr.Body("arm", mass=m, inertia=(0.1, 0.15, 0.2), position=(0, -r, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 0, 1))
    law = sr.Torque("law", "pin", value=f"u*cos(pin.angle) - {c}*pin.rate**2")
    system = sr.System(sr.Model("arm", [arm], [pin], [sr.Input("u", 0.7), law], gravity=(0, -g, 0)))
    plant = sr.linearize(system, sr.assemble(system, rates={"pin": 1.5}), outputs=["arm.x"])
    theta = plant.x0[0]
    sin, cos = np.sin(theta), np.cos(theta)
    found = sr.state_hessian(plant, {"pin.angle.rate": J})
    exact = [[m * g * r * sin - 0.7 * cos, 0, -sin], [0, -2 * c, 0], [-sin, 0, 0]]
    assert found == pytest.approx(np.array(exact), abs=1e-11)
    x = sr.state_hessian(plant, {"arm.x": 1.0})
    assert x[0, 0] == pytest.approx(-r * sin, abs=1e-12)
    with pytest.raises(sr.SarrusError, match=r"no state and no output is named slider\.x"):
        sr.state_hessian(plant, {"slider.x": 1.0})
    with pytest.raises(TypeError, match="weights must be numbers by name"):
        sr.state_hessian(plant, "arm.x")


def test_second_derivatives_in_a_loop_are_differences_of_first_ones() -> None:
    system, h = sr.System(sr.load("slider_crank")), 1e-3
    outputs = ["slider.x", "pin.force.z"]
    start = sr.assemble(system, rates={"pin": 2.0})
    plant = sr.linearize(system, start, coordinates=["pin.angle"], outputs=outputs)
    weights = {"pin.angle.rate": 1.3, "slider.x": -2.0, "pin.force.z": 0.01}
    found = sr.state_hessian(plant, weights)
    assert found == pytest.approx(found.T, abs=1e-11 * abs(found).max())

    def slopes(change: np.ndarray) -> np.ndarray:
        near = sr.linearize(
            system, *moved_to(system, plant, "pin.angle", change), coordinates=["pin.angle"], outputs=outputs
        )
        return 1.3 * near.A[1] - 2.0 * near.C[0] + 0.01 * near.C[1]

    for k, e in enumerate(np.eye(2)):
        f = [slopes(n * h * e) for n in (-2, -1, 1, 2)]
        wanted = (f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h)
        assert found[k] == pytest.approx(wanted, abs=1e-8 * abs(found).max())


def test_matrices_in_independent_coordinates() -> None:
    """Those of a linearization, in a loop with redundant constraints and with first-order states and inputs."""
    system = loaded()
    start = sr.assemble(system, rates={"a": 2.0})
    function = system.forward_dynamics.in_coordinates(["a.angle"])
    for _ in range(2):
        A, B, _ = function(start.q, start.v)
        plant = sr.linearize(system, start, coordinates=["a.angle"])
        assert np.hstack([A, B]) == pytest.approx(np.hstack([plant.A, plant.B]), abs=1e-10)
    assert (function.states, function.inputs) == (plant.states, plant.inputs)
    with pytest.raises(sr.SarrusError, match="1 degrees of freedom need as many coordinates"):
        system.forward_dynamics.in_coordinates(["a.angle", "b.angle"])(start.q, start.v)
    cart = cart_pole()
    plant = sr.linearize(cart, cart.q0, np.zeros(14))
    function = cart.forward_dynamics.in_coordinates(plant.states[:2])
    with pytest.raises(sr.SarrusError, match="call the function with a state first"):
        _ = function.data
    found = function(cart.q0, np.zeros(14))
    assert found.every == pytest.approx(np.hstack([plant.A, plant.B]), abs=1e-12)
    force, data, b, q, v = function.function, function.data, cart.b.copy(), cart.q0.copy(), np.zeros(14)
    b[cart.parameter_names.index("cart[inertia].mass")] *= 2
    wanted = function(q, v, b=b).every

    @njit
    def call(data: Any, b: Any, q: Any, v: Any) -> Any:
        return force(data, 1e-3, b, 0.0, q, v)

    function.matrices[:] = 0.0
    assert call(data, b, q, v)[1] == -1
    assert np.array_equal(function.matrices, wanted)
    assert abs(wanted - found.every).max() > 0.1


def check(system: sr.System, q: np.ndarray, v: np.ndarray, u: dict[str, float]) -> None:
    f, h, weights = system.forward_dynamics, 1e-3, {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    found = f.derivatives(q, v, u=u)
    assert np.array_equal(found.a, f(q, v, u=u).a)

    def slopes(value: Any, size: int) -> np.ndarray:
        return np.array(
            [
                sum(
                    w * (np.concatenate(value(k * h * e)) - np.concatenate(value(-k * h * e)))
                    for k, w in weights.items()
                )
                / h
                for e in np.eye(size)
            ]
        ).T

    by_q, by_v = slopes(lambda d: f(q + d, v, u=u), len(q)), slopes(lambda d: f(q, v + d, u=u), len(q))
    for exact, wanted in (((found.a_q, found.lam_q), by_q), ((found.a_v, found.lam_v), by_v)):
        assert np.concatenate(exact) == pytest.approx(wanted, abs=1e-8 * abs(wanted).max())
    if u:
        by_u = slopes(lambda d: f(q, v, u={"u": u["u"] + d[0]}), 1)
        assert np.concatenate([found.a_u, found.lam_u]) == pytest.approx(by_u, abs=1e-9 * abs(by_u).max())


def test_numba_code_calls_it_and_other_parameters_are_arguments() -> None:
    system = cart_pole()
    f, q, v = system.forward_dynamics, system.q0.copy(), np.zeros(14)
    assert f(q, v, u={"u": 5.0}).a[0] == pytest.approx(sr.linearize(system, q, v).B[2, 0] * 5.0)
    b = system.b.copy()
    b[system.parameter_names.index("cart[inertia].mass")] *= 2
    a, lam = np.zeros(14), np.zeros(system.m)
    force, data = f.function, f.data

    @njit
    def call(data: Any, b: Any, q: Any, v: Any, a: Any, lam: Any) -> Any:
        return force(data, 1e-3, b, 0.0, q, v, a, lam)

    assert call(data, b, q, v, a, lam) > 1e-3
    assert np.array_equal(a, f(q, v, b=b).a)
    assert system.with_memory(np.zeros(0)).forward_dynamics is f
    nq, names = system.nq, ["cart[inertia].mass"]
    b[f.places("u")], v[9] = 5.0, 0.3
    exact = f.derivatives(q, v, b=b, wrt=names)
    slopes, more = f.differentiated(names).function, f.differentiated(names).data
    found = np.zeros((nq + system.m, 2 * nq + 3))

    @njit
    def both(more: Any, b: Any, q: Any, v: Any, found: Any) -> Any:
        return slopes(more, 1e-3, b, 0.0, q, v, found)

    assert both(more, b, q, v, found) > 1e-3
    parts = exact.a[:, None], exact.a_q, exact.a_v, exact.a_u, exact.a_b
    assert np.array_equal(found[:nq], np.hstack(parts))
    assert abs(exact.a_u).max() > 0.1 < abs(exact.a_b).max()


def test_wrong_calls_are_refused() -> None:
    system = cart_pole()
    with pytest.raises(sr.SarrusError, match="call the function with a state first"):
        _ = system.forward_dynamics.data
    with pytest.raises(ValueError, match=r"v must have shape \(14,\)"):
        system.forward_dynamics(system.q0, np.zeros(3))
    with pytest.raises(sr.SarrusError, match='no input "w"'):
        system.forward_dynamics(system.q0, np.zeros(14), u={"w": 1.0})
    varying = system.with_inputs({"u": "3*t"})
    with pytest.raises(sr.SarrusError, match="the input u varies with time"):
        varying.forward_dynamics(system.q0, np.zeros(14), u={"u": 1.0})
    unset = sr.System(sr.Model("unset", [sr.Body("b", mass=1, inertia=(1, 1, 1))], forces=[sr.Input("u")]))
    with pytest.raises(sr.SarrusError, match="the input u is not set"):
        unset.forward_dynamics(unset.q0, unset.v0)
    assert np.all(np.isfinite(unset.forward_dynamics(unset.q0, unset.v0, u={"u": 1.0}).a))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"u": {"u": None}}, "u must be a number, got None"),
        ({"u": {"u": [1, 2]}}, "u must be a number"),
        ({"u": {"u": "six"}}, "u must be a number"),
        ({"u": {"u": np.nan}}, "u must be finite"),
        ({"u": [6.0]}, "u must be values of inputs by name"),
        ({"t": None}, "t must be a number"),
        ({"q": np.ones(14) * 1j}, "q must be real numbers"),
        ({"q": np.full(14, np.nan)}, "q must be finite"),
        ({"v": np.full(14, np.inf)}, "v must be finite"),
        ({"b": True}, "the input u is not set"),
    ],
)
def test_no_result_of_what_is_no_state(given: dict[str, Any], message: str) -> None:
    system = sr.System(replace(cart_pole().model, forces=[sr.Input("u"), *cart_pole().model.forces[1:]]))
    if "b" in given:
        given = {"b": system.b}
    f, all_of = system.forward_dynamics, {"q": system.q0, "v": np.zeros(14), "u": {"u": 1.0}} | given
    if "b" in given:
        del all_of["u"]
    for function in (f, f.derivatives, f.in_coordinates(["slide.displacement", "pin.angle"])):
        with pytest.raises((sr.SarrusError, TypeError, ValueError), match=message):
            function(**all_of)


def test_compiled_code_returns_no_trust_where_there_is_no_solution() -> None:
    """With an input that is not set, and in a singular configuration with pivots of another."""
    system = sr.System(replace(cart_pole().model, forces=[sr.Input("u"), *cart_pole().model.forces[1:]]))
    f, v, out = system.forward_dynamics, np.zeros(14), (np.zeros(14), np.zeros(system.m))
    f(system.q0, v, u={"u": 1.0})
    assert np.isnan(system.b).any()
    assert f.function(f.data, 1e-3, system.b, 0.0, system.q0, v, *out) == -1
    matrices = f.in_coordinates(["slide.displacement", "pin.angle"])
    matrices(system.q0, v, u={"u": 1.0})
    assert matrices.function(matrices.data, 1e-3, system.b, 0.0, system.q0, v)[0] == -1
    four, at = parallelogram()
    f, v = four.forward_dynamics, np.zeros(21)
    f(at(0.9), v)
    assert f.function(f.data, 1e-3, four.b, 0.0, at(0.0), v, np.zeros(21), np.zeros(23)) == 0
    with pytest.raises(sr.SarrusError, match="no unique solution"):
        f(at(0.0), v)


def test_compiled_code_refuses_arguments_of_other_sizes() -> None:
    """It would read and write beyond their ends; and weights of multipliers of redundant constraints."""
    (system, at), v = parallelogram(), np.zeros(21)
    f, q, b = system.forward_dynamics, at(0.9), system.b
    matrices = f.in_coordinates(["j.angle"])
    f(q, v), f.derivatives(q, v), matrices(q, v), matrices.rates(q, v), matrices.hessian(q, v, [0, 1.0])

    def trust(of: Any, *given: np.ndarray, b: np.ndarray = b) -> float:
        return float(np.ravel(of.function(of.data, 1e-9, b, 0.0, *given))[0])

    a, lam, w, H = np.zeros(21), np.zeros(23), np.array([0, 1.0, *np.zeros(23)]), np.zeros((2, 2))
    every, short = np.zeros((44, 43)), np.zeros(3)
    good = [
        (f, q, v, a, lam),
        (f.differentiated(), q, v, every),
        (matrices, q, v),
        (matrices.rates, q, v, w[:2]),
    ]
    good += [(matrices.hessian, q, v, w, H)]
    for of, *given in good:
        assert trust(of, *given) > 0.01
        for k, one in enumerate(given):
            wrong = np.zeros((1, 1)) if one.ndim == 2 else short
            assert trust(of, *given[:k], wrong, *given[k + 1 :]) == -1
    assert trust(matrices.hessian, q, v, w, H, b=short) == -1
    assert trust(matrices.hessian, q, v, w + 1.0, H) == -1
    with pytest.raises(sr.SarrusError, match="second derivatives of multipliers are not unique"):
        matrices.hessian(q, v, w + 1.0)
    slider = sr.System(sr.load("slider_crank"))
    f, q, v, w = (
        slider.forward_dynamics.hessian,
        slider.q0,
        np.zeros(slider.nq),
        np.zeros(slider.nq + slider.m),
    )
    H = f(q, v, w)
    assert trust(f, q, v, w, H, b=slider.b) > 0.01
    for weights, out, numbers in ((w[:-1], H, slider.b), (w, H[:-1], slider.b), (w, H, slider.b[:-1])):
        assert trust(f, q, v, weights, out, b=numbers) == -1


def test_parameters_are_named_once() -> None:
    system = cart_pole()
    for names in (["cart.mass", "cart.mass"], ["cart.position.x", "cart.position"]):
        with pytest.raises(sr.SarrusError, match=rf"wrt has {names[0]} twice"):
            system.forward_dynamics.differentiated(names)
        with pytest.raises(sr.SarrusError, match=rf"wrt has {names[0]} twice"):
            system.forward_dynamics.in_coordinates(["slide.displacement", "pin.angle"], names)
    for wrong in (None, 3):
        with pytest.raises(TypeError, match="wrt must be names of parameters"):
            system.forward_dynamics.derivatives(system.q0, np.zeros(14), wrt=wrong)


def test_results_are_not_changed_by_later_calls() -> None:
    system = cart_pole()
    f, q, other = system.forward_dynamics, system.q0.copy(), np.sin(np.arange(14.0))
    a_q, matrices = f.derivatives(q, np.zeros(14)).a_q, f.in_coordinates(["slide.displacement", "pin.angle"])
    before, A = a_q.copy(), matrices(q, np.zeros(14)).A
    first = A.copy()
    for _ in range(3):
        assert abs(f.derivatives(q, other).a_q - before).max() > 1.0
        assert abs(matrices(q, f(q, other).a).A - first).max() > 1e-3
    assert np.array_equal(a_q, before)
    assert np.array_equal(A, first)


def parallelogram() -> tuple[sr.System, Callable[[float], np.ndarray]]:
    """Three redundant equations, and a fourth where all bars are on one line; with q by the angle of its cranks."""
    A, D, up = np.zeros(3), np.array([2.0, 0, 0]), np.array([0, 1.0, 0])
    ends = {"a": (A, A + up), "b": (A + up, D + up), "c": (D + up, D)}
    bars = [sr.Body(n, 1.0, (0.1, 0.1, 0.1), position=np.mean(at, axis=0)) for n, at in ends.items()]
    pairs = zip(
        ("j", "k", "l", "m"), (sr.ground, *bars), (*bars, sr.ground), (A, A + up, D + up, D), strict=True
    )
    pins = [sr.Revolute(name, i, j, point=at, axis=(0, 0, 1)) for name, i, j, at in pairs]
    system = sr.System(sr.Model("parallelogram", bars, pins, gravity=(0, -9.81, 0)))

    def at(angle: float) -> np.ndarray:
        turned, along = (angle - np.pi / 2) / 2, np.array([np.cos(angle), np.sin(angle), 0])
        crank = [np.cos(turned), 0, 0, np.sin(turned)]
        return np.concatenate([along / 2, crank, D / 2 + along, [1, 0, 0, 0], D + along / 2, crank])

    return system, at


def test_a_singular_configuration_is_refused_and_leaves_no_choice_of_equations_behind() -> None:
    """Cranks m = 1, J = 0.1 at angle θ: (2 (J + m/4) + m) θ'' = -2 m g cos(θ) from rest."""
    system, at = parallelogram()
    f, v, angle = system.forward_dynamics, np.zeros(system.nq), 0.9
    matrices = f.in_coordinates(["j.angle"])
    for function in (
        f,
        f.derivatives,
        matrices,
        matrices.rates,
        lambda q, v: matrices.hessian(q, v, [0, 1.0]),
    ):
        with pytest.raises(sr.SarrusError, match="no unique solution"):
            function(at(0.0), v)
    exact = -2 * 9.81 / 1.7 * np.cos(angle)
    assert f(at(angle), v).a[0] == pytest.approx(-0.5 * np.sin(angle) * exact, rel=1e-12)
    assert matrices.rates(at(angle), v) == pytest.approx([0.0, exact], abs=1e-10)
    assert matrices(at(angle), v).A[1, 0] == pytest.approx(-exact * np.tan(angle), rel=1e-10)
    assert matrices.hessian(at(angle), v, [0, 1.0])[0, 0] == pytest.approx(-exact, rel=1e-9)


def test_independent_equations_of_a_rough_state_do_not_last() -> None:
    """Off the constraints, fewer equations depend on others."""
    system, at = parallelogram()
    f, q, v = system.forward_dynamics, at(0.9), np.zeros(system.nq)
    f(q + 1e-3 * np.cos(np.arange(system.nq)), v)
    for found, exact in zip(f(q, v), dense(system, q, v), strict=True):
        assert found == pytest.approx(exact, abs=1e-9 * abs(exact).max())


@pytest.mark.slow
def test_data_of_compiled_functions_owns_its_arrays() -> None:
    """Of a function that has chosen other pivots, or is gone; and no longer than the data exists."""
    system, at = parallelogram()
    q, v, b, f = at(0.9), np.zeros(21), system.b.copy(), system.forward_dynamics
    matrices, one, wanted = f.in_coordinates(["j.angle"]), f.differentiated("a.mass"), f(q, v).a
    A, every, parts = matrices(q, v).A, one(q, v).every, (f, one, matrices, matrices.hessian, matrices.rates)
    matrices.rates(q, v), matrices.hessian(q, v, [0, 1.0])
    calls, array = [(x.function, x.data[:].copy()) for x in parts], matrices.matrices
    a, same, rates, H = np.zeros(21), np.zeros_like(every), np.zeros(2), np.zeros((2, 2))
    others = (a, np.zeros(23)), (same,), (), (np.array([0, 1.0, *np.zeros(23)]), H), (rates,)
    assert f.order.arrays
    alive = [weakref.ref(x) for x in (f.order.arrays.values, matrices._plan._matrix.values, one)]
    f._differentiated.clear()
    del matrices, one, parts
    assert f.order.choose(b, 0.0, q, True)
    f(q, v)
    gc.collect()
    assert [x() is None for x in alive] == [False, False, True]
    for (function, data), more in zip(calls, others, strict=True):
        function(data, 1e-3, b, 0.0, q, v, *more)
    for found, exact in ((a, wanted), (same[:21], every[:21]), (array[:, :2], A), (rates[1], -H[0, 0])):
        assert found == pytest.approx(exact)
    del calls, data
    gc.collect()
    assert [x() is None for x in alive] == [True] * 3


MOVING = [
    "spring.k",
    "rod.mass",
    "pin.point.y",
    "ball.point.z",
    "guide.axis.y",
    "cross.axis_i.x",
    "guide.axis.z",
    "spring.point_j.x",
]


def linkage(**values: float) -> sr.System:
    """A slider-crank with a motor and a lag; parameters move its joints, inertia and forces."""
    model = sr.load("slider_crank")
    motor, lag = (
        sr.Torque("motor", "pin", value="u - 0.2*w"),
        sr.StateVariable("w", rate="pin.rate - 3*w", initial=0.4),
    )
    whole = sr.Model("linkage", model.bodies, model.joints, [*model.forces, sr.Input("u", 3.0), motor, lag])
    return sr.System(with_numbers(whole, values))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("coordinate", ["pin.angle", "guide.displacement", "cross.angle_i"])
def test_rates_by_parameters_in_independent_coordinates(coordinate: str) -> None:
    """At constant coordinates, rates and states, against mechanisms with other parameters, of the same coordinates."""
    system = linkage()
    start, place = sr.assemble(system, rates={"pin": 2.0}), system.states["w"].place
    f = system.forward_dynamics.in_coordinates([coordinate], MOVING)
    E, plant = f(start.q, start.v).E, sr.linearize(system, start, coordinates=[coordinate])
    own = written_numbers(system.model)

    def rates(name: str, change: float) -> np.ndarray:
        other = linkage(**{name: own[name] + change})
        q, v = moved_to(other, plant, coordinate, np.zeros(3))
        v[place] = start.v[place]
        return other.forward_dynamics.in_coordinates([coordinate]).rates(q, v)

    assert f.rates(start.q, start.v) == pytest.approx(rates("spring.k", 0.0), abs=1e-9)
    assert f.rates(start.q, start.v)[2] == pytest.approx(2.0 - 3 * 0.4)
    for k, name in enumerate(f.parameters):
        near = [rates(name, n * 1e-3) for n in (-2, -1, 1, 2)]
        wanted = (near[0] - 8 * near[1] + 8 * near[2] - near[3]) / (12 * 1e-3)
        assert E[:, k] == pytest.approx(wanted, abs=1e-8 * max(1.0, abs(wanted).max())), name
    assert np.count_nonzero(abs(E[1]) > 1e-4) >= len(MOVING) - 1


def test_tables_are_differentiated_from_python_alone() -> None:
    """By values of a table, against differences; compiled code is refused, as are coordinates that are no joints'."""
    arm = sr.Body("arm", mass=2.0, inertia=(0.1, 0.15, 0.2), position=(0, -0.5, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 0, 1))
    law = sr.Torque("law", "pin", value=[(-1, 2.0), (0, 0.5), (1, -3.0), (2, 1.0)], over="pin.angle")
    spring = sr.TSDA("spring", sr.ground.point(0.3, 0, 0), arm.point(0, -1, 0), k=1.0, length=0.1)
    model = sr.Model("arm", [arm], [pin], [law, spring])
    system, names = sr.System(model), ["law.value.2.y", "arm.mass"]
    start, f = sr.assemble(system, rates={"pin": 1.5}), system.forward_dynamics
    found, own = f.derivatives(start.q, start.v, wrt=names), written_numbers(model)
    for k, name in enumerate(names):
        near = []
        for h in (-1e-3, 1e-3):
            other = sr.System(with_numbers(model, {name: own[name] + h}))
            near.append(np.concatenate(other.forward_dynamics(start.q, start.v)))
        wanted = (near[1] - near[0]) / 2e-3
        exact = np.concatenate([found.a_b[:, k], found.lam_b[:, k]])
        assert exact == pytest.approx(wanted, abs=1e-6 * abs(wanted).max())
    assert abs(found.a_b[:, 0]).max() > 0.1
    with pytest.raises(sr.SarrusError, match=r"law\.value\.2\.y changes a table or formula"):
        _ = f.differentiated(names).data
    with pytest.raises(
        sr.SarrusError, match=r"law\.value\.2\.y changes a table .* not compiled\. Leave it out"
    ):
        _ = f.differentiated(names).hessian
    with pytest.raises(sr.SarrusError, match=r"law\.value\.2\.y changes a table or formula"):
        f.in_coordinates(["pin.angle"], names)
    with pytest.raises(sr.SarrusError, match=r"not supported in the coordinate spring\.length"):
        f.in_coordinates(["spring.length"], ["arm.mass"])
    with pytest.raises(sr.SarrusError, match=r"is no parameter of an element. Leave out b"):
        f.in_coordinates(["pin.angle"], ["arm.mass"])(start.q, start.v, b=system.b)
