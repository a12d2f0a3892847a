"""Appendix A.1: the DOT-1 constraint, Eqs. (80) to (86). All exact and for any p."""

import numpy as np
from tests.paper.kernels import kernel, row, split, zeros
from tests.paper.paper import A, B, D, derivative, equal, rational

from sarrus.elements import Dot1

q, beta, gamma, v = (rational(n, 14) for n in range(4))
a_i, a_j, lam = rational(10, 3), rational(11, 3), rational(12, 1)
element = Dot1(a_i, a_j)
_, p_i, _, p_j = split(q)
_, b2, _, b4 = split(beta)
_, g2, _, g4 = split(gamma)
_, v_i, _, v_j = split(v)
s_i, s_j, B_i, B_j = A(p_i) @ a_i, A(p_j) @ a_j, B(p_i, a_i), B(p_j, a_j)
Bd_i, Bd_j, O = B(v_i, a_i), B(v_j, a_j), zeros(3)


def Phi(q):
    _, p_i, _, p_j = split(q)
    return np.array([(A(p_i) @ a_i) @ (A(p_j) @ a_j)])


def printed_081(q):
    _, p_i, _, p_j = split(q)
    s_i, s_j = A(p_i) @ a_i, A(p_j) @ a_j
    return row(O, s_j @ B(p_i, a_i), O, s_i @ B(p_j, a_j))


def test_eq_080_constraint():
    """Φ^d1 = s_iᵀ s_j."""
    assert equal(kernel(element, "Phi", q), [s_i @ s_j])


def test_eq_081_jacobian():
    """Φ_q."""
    assert equal(kernel(element, "Phi_q", q), printed_081(q), derivative(Phi, q)[0])


def printed_082(q):
    _, p_i, _, p_j = split(q)
    s_i, s_j, B_i, B_j = A(p_i) @ a_i, A(p_j) @ a_j, B(p_i, a_i), B(p_j, a_j)
    return row(O, s_j @ B(b2, a_i) + b4 @ B_j.T @ B_i, O, s_i @ B(b4, a_j) + b2 @ B_i.T @ B_j)


def test_eq_082_second_derivative():
    """(Φ_q β)_q."""
    expected = derivative(lambda q: printed_081(q) @ beta, q)
    assert equal(kernel(element, "Phi_q_xi_q", q, xi=beta), printed_082(q), expected)


def test_eq_083_third_derivative():
    """((Φ_q β)_q γ)_q."""
    by_i = b4 @ B_j.T @ B(g2, a_i) + g4 @ B(b4, a_j).T @ B_i + g4 @ B_j.T @ B(b2, a_i)
    by_j = g2 @ B_i.T @ B(b4, a_j) + g2 @ B(b2, a_i).T @ B_j + b2 @ B_i.T @ B(g4, a_j)
    expected = derivative(lambda q: printed_082(q) @ gamma, q)
    assert equal(kernel(element, "Phi_q_xi_q_eta_q", q, xi=beta, eta=gamma), row(O, by_i, O, by_j), expected)


def acceleration_term(q, v):
    _, p_i, _, p_j = split(q)
    _, v_i, _, v_j = split(v)
    a, b = B(v_i, a_i) @ v_i, B(v_j, a_j) @ v_j
    mixed = 2 * (B(p_i, a_i) @ v_i) @ (B(p_j, a_j) @ v_j)
    return np.array([(A(p_j) @ a_j) @ a + mixed + (A(p_i) @ a_i) @ b])


def test_eq_084_acceleration_term_to_q():
    """Derivative of (Φ_q q̇)_q q̇ with respect to q; with the opposite sign on the right-hand side (erratum E8)."""
    printed = row(O, v_j @ (2 * B_j.T @ Bd_i + Bd_j.T @ B_i), O, v_i @ (2 * B_i.T @ Bd_j + Bd_i.T @ B_j))
    assert equal(kernel(element, "gamma", q, v=v), -acceleration_term(q, v))
    assert equal(kernel(element, "gamma_q", q, v=v), -printed)
    assert equal(printed, derivative(lambda q: acceleration_term(q, v), q)[0])


def test_eq_085_acceleration_term_to_velocity():
    """Derivative of (Φ_q q̇)_q q̇ with respect to q̇; with the opposite sign on the right-hand side (erratum E8)."""
    by_i, by_j = 2 * s_j @ Bd_i + 2 * v_j @ B_j.T @ B_i, 2 * s_i @ Bd_j + 2 * v_i @ B_i.T @ B_j
    printed = row(O, by_i, O, by_j)
    assert equal(kernel(element, "gamma_v", q, v=v), -printed)
    assert equal(printed, derivative(lambda v: acceleration_term(q, v), v)[0])


def test_eq_086_constraint_force_derivative():
    """(Φ_qᵀ λ)_q."""
    printed = zeros(14, 14)
    printed[3:7, 3:7], printed[3:7, 10:] = D(a_i, s_j), B_i.T @ B_j
    printed[10:, 3:7], printed[10:, 10:] = B_j.T @ B_i, D(a_j, s_i)
    expected = derivative(lambda q: lam[0] * printed_081(q), q)
    assert equal(kernel(element, "Phi_qT_lam_q", q, lam=lam), lam[0] * printed, expected)
