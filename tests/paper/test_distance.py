"""Appendix A.3: the distance constraint, Eqs. (95) to (103). All exact and for any p; d_ji = -d_ij."""

import numpy as np
from tests.paper.kernels import kernel, row, split
from tests.paper.paper import I3, A, B, D, along, derivative, equal, rational

from sarrus.elements import Distance, Pair

q, beta, gamma, v = (rational(n, 14) for n in range(4))
s_i, s_j, C, lam = rational(10, 3), rational(11, 3), rational(12, 1)[0], rational(13, 1)
element = Distance(s_i, s_j, C)
_, p_i, _, p_j = split(q)
_, b2, _, b4 = split(beta)
_, g2, _, g4 = split(gamma)
w_i, v_i, w_j, v_j = split(v)
B_i, B_j, Bd_i, Bd_j = B(p_i, s_i), B(p_j, s_j), B(v_i, s_i), B(v_j, s_j)


def d_from(q):
    r_i, p_i, r_j, p_j = split(q)
    return r_j + A(p_j) @ s_j - r_i - A(p_i) @ s_i


d_ij = d_from(q)
d_ji = -d_ij


def Phi(q):
    return np.array([d_from(q) @ d_from(q) - C**2])


def printed_096(q):
    _, p_i, _, p_j = split(q)
    d_ij = d_from(q)
    d_ji = -d_ij
    return row(2 * d_ji, 2 * d_ji @ B(p_i, s_i), 2 * d_ij, 2 * d_ij @ B(p_j, s_j))


def test_eq_095_constraint():
    """Φ^ss = d_ijᵀ d_ij - C²."""
    assert equal(kernel(element, "Phi", q), Phi(q))


def test_eq_096_jacobian():
    """Φ_q."""
    assert equal(kernel(element, "Phi_q", q), printed_096(q), derivative(Phi, q)[0])


def along_d_ji(x, q=q):
    """Eqs. (97) and (98) as printed."""
    (x1, x2, x3, x4), (_, p_i, _, p_j) = split(x), split(q)
    return x1 + B(p_i, s_i) @ x2 - x3 - B(p_j, s_j) @ x4


def test_eq_097_mu():
    """μ, the derivative of d_ji along β."""
    assert equal(along_d_ji(beta), along(lambda q: -d_from(q), q, beta), -element.d_xi(*pairs(q, beta)))
    assert equal(kernel(element, "Phi_q_xi", q, xi=beta), [2 * d_ji @ along_d_ji(beta)])


def test_eq_098_eta():
    """η, the derivative of d_ji along γ."""
    assert equal(along_d_ji(gamma), along(lambda q: -d_from(q), q, gamma), -element.d_xi(*pairs(q, gamma)))
    assert equal(kernel(element, "Phi_q_xi", q, xi=gamma), [2 * d_ji @ along_d_ji(gamma)])


def pairs(*vectors):
    return [Pair(*split(x)) for x in vectors]


def printed_099(q):
    _, p_i, _, p_j = split(q)
    mu, d_ji = along_d_ji(beta, q), -d_from(q)
    by_p_i, by_p_j = mu @ B(p_i, s_i) + d_ji @ B(b2, s_i), mu @ B(p_j, s_j) + d_ji @ B(b4, s_j)
    return row(2 * mu, 2 * by_p_i, -2 * mu, -2 * by_p_j)


def test_eq_099_second_derivative():
    """(Φ_q β)_q."""
    expected = derivative(lambda q: printed_096(q) @ beta, q)
    assert equal(kernel(element, "Phi_q_xi_q", q, xi=beta), printed_099(q), expected)


def test_eq_100_third_derivative():
    """((Φ_q β)_q γ)_q with s_j' in its fourth block (erratum E3)."""
    mu, eta, chi = along_d_ji(beta), along_d_ji(gamma), B(b2, s_i) @ g2 - B(b4, s_j) @ g4
    by_p_i = 2 * eta @ B(b2, s_i) + 2 * mu @ B(g2, s_i) + 2 * chi @ B_i
    by_p_j = -2 * eta @ B(b4, s_j) - 2 * mu @ B(g4, s_j) - 2 * chi @ B_j
    right = row(2 * chi, by_p_i, -2 * chi, by_p_j)
    expected = derivative(lambda q: printed_099(q) @ gamma, q)
    assert equal(kernel(element, "Phi_q_xi_q_eta_q", q, xi=beta, eta=gamma), right, expected)


W = w_i - w_j + p_i @ Bd_i.T - p_j @ Bd_j.T  # the rate of d_ji, with the undotted p as printed
K_2 = Bd_i @ v_i - Bd_j @ v_j


def acceleration_term(q, v):
    _, v_i, _, v_j = split(v)
    rate, second = along_d_ji(v, q), B(v_i, s_i) @ v_i - B(v_j, s_j) @ v_j
    return np.array([2 * rate @ rate - 2 * d_from(q) @ second])


def test_eq_101_acceleration_term_to_q():
    """Derivative of (Φ_q q̇)_q q̇ with respect to q; with the opposite sign on the right-hand side (erratum E8)."""
    printed = row(2 * K_2, 4 * W @ Bd_i + 2 * K_2 @ B_i, -2 * K_2, -4 * W @ Bd_j - 2 * K_2 @ B_j)
    assert equal(kernel(element, "gamma", q, v=v), -acceleration_term(q, v))
    assert equal(kernel(element, "gamma_q", q, v=v), -printed)
    assert equal(printed, derivative(lambda q: acceleration_term(q, v), q)[0])


def test_eq_102_acceleration_term_to_velocity():
    """Derivative of (Φ_q q̇)_q q̇ with respect to q̇; with the opposite sign on the right-hand side (erratum E8)."""
    printed = row(4 * W, 4 * W @ B_i + 4 * d_ji @ Bd_i, -4 * W, -4 * W @ B_j - 4 * d_ji @ Bd_j)
    assert equal(kernel(element, "gamma_v", q, v=v), -printed)
    assert equal(printed, derivative(lambda v: acceleration_term(q, v), v)[0])


def test_eq_103_constraint_force_derivative():
    """(Φ_qᵀ λ)_q."""
    printed = np.block(
        [
            [I3, B_i, -I3, -B_j],
            [B_i.T, D(s_i, d_ji) + B_i.T @ B_i, -B_i.T, -B_i.T @ B_j],
            [-I3, -B_i, I3, B_j],
            [-B_j.T, -B_j.T @ B_i, B_j.T, D(s_j, d_ij) + B_j.T @ B_j],
        ]
    )
    expected = derivative(lambda q: lam[0] * printed_096(q), q)
    assert equal(kernel(element, "Phi_qT_lam_q", q, lam=lam), 2 * lam[0] * printed, expected)
