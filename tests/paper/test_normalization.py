"""Section 4.2: the normalization of Euler parameters, Eqs. (45) to (50). All exact and for any p."""

import numpy as np
from tests.paper.kernels import kernel, row, zeros
from tests.paper.paper import I4, along, derivative, equal, rational, unit

from sarrus.elements import Normalization

q, beta, v, lam = rational(1, 7), rational(2, 7), rational(3, 7), rational(4, 1)
element = Normalization()
O3 = zeros(3)


def Phi(q):
    return np.array([q[3:] @ q[3:] - 1])


def test_eq_045_constraint():
    """Φ^P = pᵀp - 1."""
    assert equal(kernel(element, "Phi", q), Phi(q))
    assert equal(kernel(element, "Phi", np.concatenate([q[:3], unit(5)])), [0])


def test_eq_046_jacobian():
    """Φ^P_q."""
    assert equal(kernel(element, "Phi_q", q), row(O3, 2 * q[3:]), derivative(Phi, q)[0])


def test_eq_047_second_derivative():
    """(Φ^P_q β)_q."""
    expected = derivative(lambda q: along(Phi, q, beta), q)[0]
    assert equal(kernel(element, "Phi_q_xi_q", q, xi=beta), row(O3, 2 * beta[3:]), expected)


def test_eq_048_constraint_force_derivative():
    """(Φ^P_qᵀ λ)_q."""
    printed = zeros(7, 7)
    printed[3:, 3:] = 2 * lam[0] * I4
    expected = derivative(lambda q: lam @ derivative(Phi, q), q)
    assert equal(kernel(element, "Phi_qT_lam_q", q, lam=lam), printed, expected)


def test_eq_049_acceleration_term_to_q():
    """Derivative of (Φ^P_q q̇)_q q̇ with respect to q: zero; γ = -2 ṗᵀṗ."""
    assert equal(kernel(element, "gamma_q", q, v=v), zeros(7))
    assert equal(kernel(element, "gamma", q, v=v), [-2 * (v[3:] @ v[3:])])


def test_eq_050_acceleration_term_to_velocity():
    """Derivative of (Φ^P_q q̇)_q q̇ with respect to q̇; with the opposite sign on the right-hand side (erratum E8)."""
    printed = row(O3, 4 * v[3:])
    assert equal(kernel(element, "gamma_v", q, v=v), -printed)
    assert equal(printed, derivative(lambda v: np.array([2 * (v[3:] @ v[3:])]), v)[0])
