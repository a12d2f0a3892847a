"""Appendix B: the rotational spring-damper-actuator, Eqs. (104) to (116), in 70 digits.

The state: unit Euler parameters with tangent velocities, and a revolute joint that is satisfied. `torque` is the
definition, Eq. (106) with the angle of erratum E11; its derivatives are taken by differences.
"""

import math
from fractions import Fraction
from functools import cache

import mpmath
import numpy as np
import pytest
from tests.paper.kernels import digits, kernel, near, row, slope, slopes, split, zeros
from tests.paper.paper import A, B, G, bar, rational, tangent, unit

from sarrus.elements import RSDA

PI_16 = mpmath.mpf(math.pi)  # turns are counted in the π of floating point numbers

EXACT_P_I, EXACT_P_J = unit(1), unit(2)
p_i, p_j = digits(EXACT_P_I), digits(EXACT_P_J)
v_i, v_j = digits(tangent(3, EXACT_P_I)), digits(tangent(4, EXACT_P_J))
q = np.concatenate([digits(rational(5, 3)), p_i, digits(rational(6, 3)), p_j])
v = np.concatenate([digits(rational(7, 3)), v_i, digits(rational(8, 3)), v_j])
frame = A(unit(9))
f_i, g_i, h_i = (digits(frame[:, n]) for n in range(3))
turn = A(EXACT_P_J).T @ A(EXACT_P_I)
f_j = digits(turn @ (Fraction(3, 5) * frame[:, 0] + Fraction(4, 5) * frame[:, 1]))
h_j = digits(turn @ frame[:, 2])
k, c, N = (mpmath.mpf(n) / 7 for n in (30, 8, -19))
t, TURNS = mpmath.mpf(0), 2
element = RSDA(f_i, g_i, h_i, f_j, h_j, k, c, t, N, 2 * PI_16 * TURNS)


def angle(q):
    _, p_i, _, p_j = split(q)
    u, w, z = A(p_i) @ f_i, A(p_i) @ g_i, A(p_j) @ f_j
    return mpmath.atan2(w @ z, u @ z)


def torque(q, v):
    return k * (angle(q) + 2 * PI_16 * TURNS) + c * slope(angle, q, v) + N


@cache
def n_q():
    return slopes(lambda q: torque(q, v), q)


@cache
def n_v():
    return slopes(lambda v: torque(q, v), v)


n = torque(q, v)
W_I, W_J = 2 * G(p_i).T @ h_i, -2 * G(p_j).T @ h_j
Q = kernel(element, "Q", q, v=v, t=t)
Q_q = kernel(element, "Q_q", q, v=v, t=t)
Q_v = kernel(element, "Q_v", q, v=v, t=t)
OWN_I, OWN_J = row(zeros(4, 3), bar(h_i), zeros(4, 7)), row(zeros(4, 10), bar(h_j))
KERNEL_N_Q = W_I @ (Q_q[3:7] - 2 * n * OWN_I) / (W_I @ W_I)  # n_q as the kernel has it
KERNEL_N_V = W_I @ Q_v[3:7] / (W_I @ W_I)

u, w, z = A(p_i) @ f_i, A(p_i) @ g_i, A(p_j) @ f_j
cos, sin = u @ z, w @ z
X, B_j = cos * B(p_i, g_i) - sin * B(p_i, f_i), B(p_j, f_j)


def test_eq_104_force_on_body_i():
    """Q_i = [0; 2 n G_iᵀ h_i']."""
    assert near(Q[:7], np.concatenate([zeros(3), 2 * n * G(p_i).T @ h_i]))


def test_eq_105_force_on_body_j():
    """Q_j = -[0; 2 n G_jᵀ h_j']; with Q_i the virtual work of n, for tangent δp."""
    assert near(Q[7:], -np.concatenate([zeros(3), 2 * n * G(p_j).T @ h_j]))
    delta = np.concatenate(
        [zeros(3), digits(tangent(20, EXACT_P_I)), zeros(3), digits(tangent(21, EXACT_P_J))]
    )
    assert near(Q @ delta, -n * slope(angle, q, delta))


def test_eq_106_torque():
    """n = k (θ + 2π n_rev) + c θ̇ + N."""
    assert near(W_I @ Q[3:7] / (W_I @ W_I), n)


def test_eq_107_derivative_to_q():
    """Q_q of both bodies from n_q, exact for any direction."""
    assert near(Q_q[3:7], 2 * np.outer(G(p_i).T @ h_i, n_q()) + 2 * n * OWN_I)
    assert near(Q_q[10:], -2 * np.outer(G(p_j).T @ h_j, n_q()) - 2 * n * OWN_J)


def test_eq_108_derivative_to_velocity():
    """Q_q̇ of both bodies from n_q̇."""
    assert near(Q_v[3:7], 2 * np.outer(G(p_i).T @ h_i, n_v()))
    assert near(Q_v[10:], -2 * np.outer(G(p_j).T @ h_j, n_v()))


@pytest.mark.parametrize("r", [slice(0, 3), slice(7, 10)], ids=["r_i", "r_j"])
def test_eq_109_111_113_115_no_derivative_to_positions(r):
    """n does not depend on r_i, r_j and their rates."""
    assert near(KERNEL_N_Q[r], n_q()[r], zeros(3))
    assert near(KERNEL_N_V[r], n_v()[r], zeros(3))
    assert not np.any(Q_q[:, r])
    assert not np.any(Q_v[:, r])
    assert not np.any(Q_q[r])
    assert not np.any(Q_v[r])


def equal_for_tangents(printed, p, exact_p, columns):
    """The printed derivative, the kernel's and the differences agree along tangents, but not along p (erratum E6)."""
    for seed in range(4):
        direction = digits(tangent(30 + seed, exact_p))
        assert near(printed @ direction, KERNEL_N_Q[columns] @ direction, n_q()[columns] @ direction)
    assert near(KERNEL_N_Q[columns], n_q()[columns])
    assert not near(printed @ p, n_q()[columns] @ p)


def test_eq_110_torque_to_p_i():
    """n_p_i for tangent directions."""
    damping = v_j @ B_j.T @ X + cos * z @ B(v_i, g_i) - sin * z @ B(v_i, f_i)
    equal_for_tangents(k * z @ X + c * damping, p_i, EXACT_P_I, slice(3, 7))


def test_eq_112_torque_to_p_j():
    """n_p_j for tangent directions, with the transpose and body j in the last terms (errata E4, E5)."""
    axis = cos * w - sin * u
    damping = v_i @ X.T @ B_j + cos * w @ B(v_j, f_j) - sin * u @ B(v_j, f_j)
    equal_for_tangents(k * axis @ B_j + c * damping, p_j, EXACT_P_J, slice(10, 14))


def scaled_by_rho(q):
    """θ_q times ρ = cos² + sin², what Eqs. (114) and (116) give, at any q."""
    _, p_i, _, p_j = split(q)
    u, w, z = A(p_i) @ f_i, A(p_i) @ g_i, A(p_j) @ f_j
    cos, sin = u @ z, w @ z
    by_p_i = z @ (cos * B(p_i, g_i) - sin * B(p_i, f_i))
    return by_p_i, (cos * w - sin * u) @ B(p_j, f_j), cos**2 + sin**2


def test_eq_114_torque_to_rate_of_p_i():
    """n_ṗ_i, for every direction, on unit p with the joint satisfied; else a factor is missing (erratum E6)."""
    assert near(KERNEL_N_V[3:7], n_v()[3:7], c * z @ X)
    off = np.concatenate([q[:3], p_i * 2, q[7:]])
    found = kernel(element, "Q_v", off, v=v, t=t)[3:7, 3:7]
    by_p_i, _, rho = scaled_by_rho(off)
    assert not near(rho, 1)
    assert near(found, np.outer(2 * W_I, c * by_p_i / rho))


def test_eq_116_torque_to_rate_of_p_j():
    """n_ṗ_j, for every direction, on unit p with the joint satisfied; else a factor is missing (erratum E6)."""
    assert near(KERNEL_N_V[10:], n_v()[10:], c * (cos * w - sin * u) @ B_j)
    off = np.concatenate([q[:3], p_i * 2, q[7:]])
    found = kernel(element, "Q_v", off, v=v, t=t)[10:, 10:]
    _, by_p_j, rho = scaled_by_rho(off)
    assert near(found, np.outer(W_J, c * by_p_j / rho))
