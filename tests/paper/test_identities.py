"""Section 2: Euler parameters and their identities, Eqs. (9) to (25), against `sarrus.euler`. All exact.

They are identities in four free numbers p; only the orthonormality of A needs |p| = 1.
"""

import numpy as np
from tests.paper.paper import I3, I4, A, B_hat, D, along, derivative, equal, rational, tilde, unit

from sarrus import euler

p, p_j, a, gamma = rational(1, 4), rational(2, 4), rational(3, 3), rational(4, 3)
e0, e = p[0], p[1:]


def column(x):
    return x[:, None]


def test_eq_009_orientation():
    """The orientation matrix A; orthonormal on unit p only."""
    assert equal(euler.A(p), A(p), (2 * e0**2 - 1) * I3 + 2 * (np.outer(e, e) + e0 * tilde(e)))
    u = unit(5)
    assert equal(euler.A(u).T @ euler.A(u), I3)
    assert not equal(euler.A(p).T @ euler.A(p), I3)


def test_eq_010_vector_of_a_body_in_global_axes():
    """a = A a', written out."""
    assert equal(euler.rotate(p, a), (2 * e0**2 - 1) * a + 2 * (e * (e @ a) + e0 * (tilde(e) @ a)), A(p) @ a)


def test_eq_011_derivative_to_e0():
    """Derivative of A a' with respect to e0."""
    printed = 4 * e0 * a - 2 * tilde(a) @ e
    assert equal(euler.B(p, a)[:, 0], printed, derivative(lambda p: A(p) @ a, p)[:, 0])


def test_eq_012_derivative_to_e():
    """Derivative of A a' with respect to e."""
    first = 2 * ((e @ a) * I3 + np.outer(e, a) - e0 * tilde(a))
    second = 2 * (np.outer(a, e) + np.outer(e, a) - (e0 * I3 + tilde(e)) @ tilde(a))
    assert equal(euler.B(p, a)[:, 1:], first, second, derivative(lambda p: A(p) @ a, p)[:, 1:])


def test_eq_013_derivative_to_p():
    """Derivative of A a' with respect to p, both parts together."""
    turn = e0 * I3 + tilde(e)
    printed = 2 * (np.outer(a, p) + np.hstack([column(turn @ a), np.outer(e, a) - turn @ tilde(a)]))
    assert equal(euler.B(p, a), printed)


def test_eq_014_B_hat():
    """B̂: half the derivative of the homogeneous part (A - (pᵀp - 1) I) a'."""
    homogeneous = derivative(lambda p: (A(p) - (p @ p - 1) * I3) @ a, p)
    assert equal(2 * B_hat(p, a), homogeneous)
    assert equal(euler.B(p, a) - 2 * np.outer(a, p), homogeneous)


def test_eq_015_B():
    """B = 2 (a' pᵀ + B̂)."""
    assert equal(euler.B(p, a), 2 * (np.outer(a, p) + B_hat(p, a)))


def test_eq_016_B_is_the_derivative():
    """Derivative of A(p) a' with respect to p is B(p, a')."""
    assert equal(euler.B(p, a), derivative(lambda p: euler.A(p) @ a, p))


def test_eq_017_B_hat_is_symmetric_in_its_arguments():
    """B̂(p_i, a') p_j = B̂(p_j, a') p_i, with the steps between."""
    (i0, i), (j0, j) = (p[0], p[1:]), (p_j[0], p_j[1:])
    turn_i, turn_j = i0 * I3 + tilde(i), j0 * I3 + tilde(j)
    first = turn_i @ a * j0 + i * (a @ j) - turn_i @ tilde(a) @ j
    second = turn_j @ a * i0 - j0 * tilde(a) @ i + i * (j @ a) + tilde(i) @ tilde(j) @ a
    third = turn_j @ a * i0 + j * (a @ i) - turn_j @ tilde(a) @ i
    of_sarrus = (euler.B(p, a) / 2 - np.outer(a, p)) @ p_j
    assert equal(B_hat(p, a) @ p_j, of_sarrus, first, second, third, B_hat(p_j, a) @ p)


def test_eq_018_B_is_symmetric_in_its_arguments():
    """B(p_i, a') p_j = B(p_j, a') p_i."""
    assert equal(euler.B(p, a) @ p_j, euler.B(p_j, a) @ p)


def test_eq_019_derivative_of_B_p():
    """Derivative of B(p_i, a') p_j with respect to p_i is B(p_j, a')."""
    assert equal(euler.B(p_j, a), derivative(lambda p: euler.B(p, a) @ p_j, p))


def printed_020(p):
    e0, e = p[0], p[1:]
    turn = e0 * I3 - tilde(e)
    return np.concatenate([[a @ turn @ gamma], (np.outer(a, e) + tilde(a) @ turn) @ gamma])


def test_eq_020_B_hat_transposed():
    """B̂ᵀγ."""
    assert equal(B_hat(p, a).T @ gamma, printed_020(p), (euler.B(p, a) / 2 - np.outer(a, p)).T @ gamma)


PRINTED_021 = np.concatenate([[a @ gamma], tilde(a) @ gamma])
PRINTED_022 = np.vstack([(a @ tilde(gamma))[None, :], np.outer(a, gamma) + tilde(a) @ tilde(gamma)])


def half_D_without_p():
    """The derivative of B̂ᵀγ as Sarrus has it: half of D, without the part of a' pᵀ."""
    return euler.D(a, gamma) / 2 - (a @ gamma) * I4


def test_eq_021_derivative_of_B_hat_transposed_to_e0():
    """Derivative of B̂ᵀγ with respect to e0."""
    assert equal(PRINTED_021, derivative(printed_020, p)[:, 0], half_D_without_p()[:, 0])


def test_eq_022_derivative_of_B_hat_transposed_to_e():
    """Derivative of B̂ᵀγ with respect to e."""
    assert equal(PRINTED_022, derivative(printed_020, p)[:, 1:], half_D_without_p()[:, 1:])


def test_eq_023_derivative_of_B_hat_transposed_to_p():
    """Derivative of B̂ᵀγ with respect to p, both parts together."""
    printed = np.hstack([column(PRINTED_021), PRINTED_022])
    assert equal(printed, derivative(lambda p: B_hat(p, a).T @ gamma, p))
    assert equal(printed, half_D_without_p())


def test_eq_024_D_is_the_derivative():
    """Derivative of Bᵀ(p, a') γ with respect to p is D(a', γ); the factor 2 holds for both terms."""
    split = 2 * (derivative(lambda p: p * (a @ gamma), p) + derivative(printed_020, p))
    assert equal(euler.D(a, gamma), split, derivative(lambda p: euler.B(p, a).T @ gamma, p))


def test_eq_025_D():
    """D written out, in both forms; symmetric, and linear in each argument."""
    corner, upper, left = np.array([[2 * (a @ gamma)]]), (a @ tilde(gamma))[None, :], column(tilde(a) @ gamma)
    twist = tilde(a) @ tilde(gamma)
    first = 2 * np.block([[corner, upper], [left, (a @ gamma) * I3 + np.outer(a, gamma) + twist]])
    second = 2 * np.block([[corner, upper], [left, twist + tilde(gamma) @ tilde(a) + 2 * (a @ gamma) * I3]])
    assert equal(euler.D(a, gamma), first, second, D(a, gamma), first.T)
    assert equal(along(lambda p: euler.B(p, a).T @ gamma, p, p_j), euler.D(a, gamma) @ p_j)
    assert not equal(euler.D(a, gamma), euler.D(gamma, a))
