"""Section 4.1: the spherical constraint, Eqs. (34) to (44). All exact and for any p."""

import numpy as np
from tests.paper.kernels import kernel, row, split, zeros
from tests.paper.paper import I3, A, B, D, along, derivative, equal, rational

from sarrus.elements import Spherical

q, beta, gamma, v = (rational(n, 14) for n in range(4))
s_i, s_j, lam = (rational(n, 3) for n in range(10, 13))
element = Spherical(s_i, s_j)
_, p_i, _, p_j = split(q)
_, b2, _, b4 = split(beta)
_, g2, _, g4 = split(gamma)
_, v_i, _, v_j = split(v)
B_i, B_j, O3, O4 = B(p_i, s_i), B(p_j, s_j), zeros(3, 3), zeros(3, 4)


def Phi(q):
    r_i, p_i, r_j, p_j = split(q)
    return r_j + A(p_j) @ s_j - r_i - A(p_i) @ s_i


def test_eq_034_partial_derivatives():
    """Derivatives with respect to r_i, p_i, r_j, p_j."""
    expected = derivative(Phi, q)
    for printed, columns in (
        (-I3, slice(0, 3)),
        (-B_i, slice(3, 7)),
        (I3, slice(7, 10)),
        (B_j, slice(10, 14)),
    ):
        assert equal(kernel(element, "Phi_q", q)[:, columns], printed, expected[:, columns])


def test_eq_035_jacobian():
    """Φ_q."""
    assert equal(kernel(element, "Phi_q", q), row(-I3, -B_i, I3, B_j))


def test_eq_036_along_beta():
    """Φ_q β."""
    printed = -beta[:3] - B_i @ b2 + beta[7:10] + B_j @ b4
    assert equal(kernel(element, "Phi_q_xi", q, xi=beta), printed)


def test_eq_037_along_beta_with_exchanged_arguments():
    """Φ_q β with p and β exchanged by Eq. (18)."""
    printed = -beta[:3] - B(b2, s_i) @ p_i + beta[7:10] + B(b4, s_j) @ p_j
    assert equal(kernel(element, "Phi_q_xi", q, xi=beta), printed)


PRINTED_038 = row(O3, -B(b2, s_i), O3, B(b4, s_j))


def test_eq_038_second_derivative():
    """(Φ_q β)_q."""
    expected = derivative(lambda q: along(Phi, q, beta), q)
    assert equal(kernel(element, "Phi_q_xi_q", q, xi=beta), PRINTED_038, expected)


def test_eq_039_second_derivative_along_gamma():
    """(Φ_q β)_q γ."""
    printed = -B(b2, s_i) @ g2 + B(b4, s_j) @ g4
    assert equal(kernel(element, "Phi_q_xi_q", q, xi=beta) @ gamma, printed)


def test_eq_040_third_derivative():
    """((Φ_q β)_q γ)_q = 0."""
    assert equal(kernel(element, "Phi_q_xi_q_eta_q", q, xi=beta, eta=gamma), zeros(3, 14))
    assert equal(derivative(lambda q: kernel(element, "Phi_q_xi_q", q, xi=beta) @ gamma, q), zeros(3, 14))


def printed_041(v):
    _, v_i, _, v_j = split(v)
    return -B(v_i, s_i) @ v_i + B(v_j, s_j) @ v_j


def test_eq_041_acceleration_term():
    """(Φ_q q̇)_q q̇; the right-hand side γ of Eq. (4) is its negative, also in Eq. (42) (erratum E8)."""
    assert equal(kernel(element, "gamma", q, v=v), -printed_041(v))
    assert equal(kernel(element, "gamma_q", q, v=v), zeros(3, 14))


def test_eq_042_acceleration_term_to_velocity():
    """Derivative of (Φ_q q̇)_q q̇ with respect to q̇."""
    printed = row(O3, -2 * B(v_i, s_i), O3, 2 * B(v_j, s_j))
    assert equal(kernel(element, "gamma_v", q, v=v), -printed, -derivative(printed_041, v))


def printed_043(q):
    _, p_i, _, p_j = split(q)
    return np.concatenate([-lam, -B(p_i, s_i).T @ lam, lam, B(p_j, s_j).T @ lam])


def test_eq_043_constraint_force():
    """Φ_qᵀ λ."""
    assert equal(kernel(element, "Phi_qT_lam", q, lam=lam), printed_043(q))


def test_eq_044_constraint_force_derivative():
    """(Φ_qᵀ λ)_q."""
    printed = zeros(14, 14)
    printed[3:7, 3:7], printed[10:, 10:] = -D(s_i, lam), D(s_j, lam)
    assert equal(kernel(element, "Phi_qT_lam_q", q, lam=lam), printed, derivative(printed_043, q))
