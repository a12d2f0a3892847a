"""Appendix A.2: the DOT-2 constraint, Eqs. (87) to (94): derivatives of the reduced form (88), exact and for any p."""

import numpy as np
from tests.paper.kernels import kernel, row, split, zeros
from tests.paper.paper import A, B, D, derivative, equal, rational, unit

from sarrus.elements import Dot2

q, beta, gamma, v = (rational(n, 14) for n in range(4))
a, s_i, s_j, lam = rational(10, 3), rational(11, 3), rational(12, 3), rational(13, 1)
element = Dot2(a, s_i, s_j)
r_i, p_i, r_j, p_j = split(q)
b1, b2, b3, b4 = split(beta)
g1, g2, g3, g4 = split(gamma)
w_i, v_i, w_j, v_j = split(v)  # rates of r_i, p_i, r_j, p_j
a_i, h, Ba_i, B_j = A(p_i) @ a, r_j + A(p_j) @ s_j - r_i, B(p_i, a), B(p_j, s_j)
Bad_i, Bd_j = B(v_i, a), B(v_j, s_j)


def full(q):
    r_i, p_i, r_j, p_j = split(q)
    return np.array([(A(p_i) @ a) @ (r_j + A(p_j) @ s_j - r_i - A(p_i) @ s_i)])


def reduced(q):
    r_i, p_i, r_j, p_j = split(q)
    return np.array([(r_j + A(p_j) @ s_j - r_i) @ (A(p_i) @ a) - s_i @ a])


def printed_089(q):
    r_i, p_i, r_j, p_j = split(q)
    a_i, point_i = A(p_i) @ a, A(p_i) @ s_i
    d_ij = r_j + A(p_j) @ s_j - r_i - point_i
    return row(-a_i, (d_ij + point_i) @ B(p_i, a), a_i, a_i @ B(p_j, s_j))


def test_eq_087_constraint():
    """Φ^d2 = a_iᵀ d_ij: equal to the reduced form (88) on unit p only (erratum E7)."""
    on_sphere = np.concatenate([r_i, unit(20), r_j, unit(21)])
    assert equal(kernel(element, "Phi", on_sphere), full(on_sphere))
    assert not equal(kernel(element, "Phi", q), full(q))


def test_eq_088_reduced_constraint():
    """Φ^d2 = (d_ij + s_i)ᵀ a_i - s_i'ᵀ a_i', for any p."""
    assert equal(kernel(element, "Phi", q), reduced(q))


def test_eq_089_jacobian():
    """Φ_q of the reduced form."""
    assert equal(kernel(element, "Phi_q", q), printed_089(q), derivative(reduced, q)[0])


def printed_090(q):
    r_i, p_i, r_j, p_j = split(q)
    a_i, h, Ba_i, B_j = A(p_i) @ a, r_j + A(p_j) @ s_j - r_i, B(p_i, a), B(p_j, s_j)
    turn = b2 @ Ba_i.T
    by_p_i = (B_j @ b4 + b3 - b1) @ Ba_i + h @ B(b2, a)
    return row(-turn, by_p_i, turn, turn @ B_j + a_i @ B(b4, s_j))


def test_eq_090_second_derivative():
    """(Φ_q β)_q."""
    expected = derivative(lambda q: printed_089(q) @ beta, q)
    assert equal(kernel(element, "Phi_q_xi_q", q, xi=beta), printed_090(q), expected)


def test_eq_091_third_derivative():
    """((Φ_q β)_q γ)_q."""
    turn = g2 @ B(b2, a).T
    by_p_i = (B_j @ b4 + b3 - b1) @ B(g2, a) + (B_j @ g4 + g3 - g1) @ B(b2, a) + g4 @ B(b4, s_j).T @ Ba_i
    by_p_j = turn @ B_j + g2 @ Ba_i.T @ B(b4, s_j) + b2 @ Ba_i.T @ B(g4, s_j)
    printed = row(-turn, by_p_i, turn, by_p_j)
    expected = derivative(lambda q: printed_090(q) @ gamma, q)
    assert equal(kernel(element, "Phi_q_xi_q_eta_q", q, xi=beta, eta=gamma), printed, expected)


def acceleration_term(q, v):
    r_i, p_i, r_j, p_j = split(q)
    w_i, v_i, w_j, v_j = split(v)
    a_i, h, Ba_i, B_j = A(p_i) @ a, r_j + A(p_j) @ s_j - r_i, B(p_i, a), B(p_j, s_j)
    mixed = 2 * (Ba_i @ v_i) @ (w_j - w_i + B_j @ v_j)
    return np.array([h @ B(v_i, a) @ v_i + mixed + a_i @ B(v_j, s_j) @ v_j])


def test_eq_092_acceleration_term_to_q():
    """Derivative of (Φ_q q̇)_q q̇ with respect to q; with the opposite sign on the right-hand side (erratum E8)."""
    turn = v_i @ Bad_i.T
    by_p_i = 2 * (B_j @ v_j + w_j - w_i) @ Bad_i + v_j @ Bd_j.T @ Ba_i
    printed = row(-turn, by_p_i, turn, turn @ B_j + 2 * v_i @ Ba_i.T @ Bd_j)
    assert equal(kernel(element, "gamma", q, v=v), -acceleration_term(q, v))
    assert equal(kernel(element, "gamma_q", q, v=v), -printed)
    assert equal(printed, derivative(lambda q: acceleration_term(q, v), q)[0])


def test_eq_093_acceleration_term_to_velocity():
    """Derivative of (Φ_q q̇)_q q̇ with respect to q̇; with the opposite sign on the right-hand side (erratum E8)."""
    turn = 2 * v_i @ Ba_i.T
    by_p_i = 2 * (B_j @ v_j + w_j - w_i) @ Ba_i + 2 * h @ Bad_i
    printed = row(-turn, by_p_i, turn, turn @ B_j + 2 * a_i @ Bd_j)
    assert equal(kernel(element, "gamma_v", q, v=v), -printed)
    assert equal(printed, derivative(lambda v: acceleration_term(q, v), v)[0])


def test_eq_094_constraint_force_derivative():
    """(Φ_qᵀ λ)_q."""
    O33, O34, O43 = zeros(3, 3), zeros(3, 4), zeros(4, 3)
    printed = np.block(
        [
            [O33, -Ba_i, O33, O34],
            [-Ba_i.T, D(a, h), Ba_i.T, Ba_i.T @ B_j],
            [O33, Ba_i, O33, O34],
            [O43, B_j.T @ Ba_i, O43, D(s_j, a_i)],
        ]
    )
    expected = derivative(lambda q: lam[0] * printed_089(q), q)
    assert equal(kernel(element, "Phi_qT_lam_q", q, lam=lam), lam[0] * printed, expected)
