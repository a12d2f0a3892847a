"""Section 5: inertia and gyroscopic terms, Eqs. (51) to (58), with the factors 4 and 8 of Eq. (5). All exact, any p."""

import numpy as np
from tests.paper.kernels import kernel, zeros
from tests.paper.paper import I3, G, bar, derivative, equal, rational, tilde

from sarrus import euler
from sarrus.elements import RigidInertia

q, v, a = rational(1, 7), rational(2, 7), rational(3, 7)
p, p_dot, p_ddot, x = q[3:], v[3:], a[3:], rational(4, 3)
xx, yy, zz, xy, xz, yz = entries = rational(5, 6)
J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
mass = rational(6, 1)[0]
element = RigidInertia(mass, entries)


def test_eq_051_rotational_inertia():
    """GᵀJ'G p̈ written out; four times in M a."""
    e0, e = p[0], p[1:]
    left = np.vstack([-e[None, :], tilde(e) + e0 * I3])
    right = np.hstack([-e[:, None], -tilde(e) + e0 * I3])
    printed = left @ J @ right @ p_ddot
    assert equal(printed, G(p).T @ J @ G(p) @ p_ddot)
    assert equal(kernel(element, "M_a", q, a=a), np.concatenate([mass * a[:3], 4 * printed]))


def test_eq_052_G_is_antisymmetric_in_its_arguments():
    """G(p_i) p_j = -G(p_j) p_i."""
    assert equal(euler.G(p) @ p_dot, -euler.G(p_dot) @ p, G(p) @ p_dot)


def test_eq_053_derivative_of_G_p():
    """Derivative of G(p_i) p_j with respect to p_i."""
    assert equal(-euler.G(p_dot), derivative(lambda p: euler.G(p) @ p_dot, p))


def test_eq_054_derivative_of_G_transposed():
    """Derivative of Gᵀ(p) x with respect to p is x̄."""
    assert equal(euler.bar(x), derivative(lambda p: G(p).T @ x, p))


def test_eq_055_bar():
    """x̄ written out; its lower right block is -x̃."""
    printed = np.vstack([np.concatenate([[0], -x]), np.hstack([x[:, None], -tilde(x)])])
    assert equal(euler.bar(x), printed, bar(x))


def only_p(block):
    result = zeros(7, 7)
    result[3:, 3:] = block
    return result


def test_eq_056_inertia_derivative():
    """(GᵀJ'G p̈)_p; four times in (M a)_q (erratum E12)."""
    printed = -G(p).T @ J @ G(p_ddot) + bar(J @ G(p) @ p_ddot)
    assert equal(printed, derivative(lambda p: G(p).T @ J @ G(p) @ p_ddot, p))
    assert equal(kernel(element, "M_a_q", q, a=a), only_p(4 * printed))


def gyroscopic(p, p_dot):
    return G(p_dot).T @ J @ G(p_dot) @ p


def test_eq_057_gyroscopic_derivative_to_p():
    """(Gᵀ(ṗ)J'G(ṗ) p)_p; eight times in S_q (erratum E12)."""
    printed = G(p_dot).T @ J @ G(p_dot)
    assert equal(printed, derivative(lambda p: gyroscopic(p, p_dot), p))
    assert equal(kernel(element, "S", q, v=v), np.concatenate([[0] * 3, 8 * gyroscopic(p, p_dot)]))
    assert equal(kernel(element, "S_q", q, v=v), only_p(8 * printed))


def test_eq_058_gyroscopic_derivative_to_velocity():
    """(Gᵀ(ṗ)J'G(ṗ) p)_ṗ with its first sign corrected (erratum E1); eight times in S_v."""
    right = -G(p_dot).T @ J @ G(p) + bar(J @ G(p_dot) @ p)
    assert equal(right, derivative(lambda p_dot: gyroscopic(p, p_dot), p_dot))
    assert equal(kernel(element, "S_v", q, v=v), only_p(8 * right))
