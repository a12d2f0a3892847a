"""Forward dynamics as a function: against dense solutions, and its derivatives against differences of the function."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit
from tests.analyses.test_linearization import cart_pole, four_bar

import sarrus as sr


def dense(system: sr.System, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """a and the shortest λ by singular values."""
    M, J = system.M(q).toarray(), system.Phi_q(q).toarray()
    K = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    right = np.concatenate([system.Q(q, v, 0.0) + system.S(q, v), system.gamma(q, v)])
    a = np.linalg.lstsq(K, right, rcond=1e-11)[0][: len(q)]
    return a, np.linalg.pinv(J.T, rcond=1e-9) @ (right[: len(q)] - M @ a)


def test_a_loop_with_redundant_constraints() -> None:
    system = four_bar()
    for rate in (3.0, -1.0):
        start = sr.assemble(system, rates={"a": rate})
        a, lam = dense(system, start.q, start.v)
        found = system.forward_dynamics(start.q, start.v)
        assert found.a == pytest.approx(a, abs=1e-9 * abs(a).max())
        assert found.lam == pytest.approx(lam, abs=1e-9 * abs(lam).max())
    assert system.forward_dynamics.derivatives(start.q, start.v).lam_q is None


def test_derivatives_are_those_of_the_function() -> None:
    system = sr.System(sr.load("slider_crank"))
    start = sr.assemble(system, rates={"pin": 2.0})
    check(system, start.q, start.v, {})
    system = cart_pole()
    q = system.q0 + 0.02 * np.cos(np.arange(14.0))  # off the constraints, too
    check(system, q, np.sin(np.arange(14.0)), {"u": 3.0})


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
