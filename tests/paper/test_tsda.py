"""Section 6.1: the translational spring-damper-actuator, Eqs. (59) to (79), in 70 digits and for any p.

`f` and its derivatives are taken from the definitions by differences; the paper's formulas for them, and the kernels,
are held against these.
"""

from functools import cache

import mpmath
import numpy as np
from tests.paper.kernels import digits, kernel, near, row, slope, slopes, split, zeros
from tests.paper.paper import I3, A, B, D, rational

from sarrus.elements import TSDA

q, v, delta = (digits(rational(n, 14)) for n in range(3))
s_i, s_j = digits(rational(10, 3)), digits(rational(11, 3))
k, c, l0, F = (mpmath.mpf(n) / 7 for n in (65, 9, 11, -23))
element = TSDA(s_i, s_j, k, c, l0, F)
t = mpmath.mpf(0)
_, p_i, _, p_j = split(q)
w_i, v_i, w_j, v_j = split(v)
B_i, B_j, Bd_i, Bd_j = B(p_i, s_i), B(p_j, s_j), B(v_i, s_i), B(v_j, s_j)
D_Q = row(-I3, -B_i, I3, B_j)
O34 = zeros(3, 4)


def d_of(q):
    r_i, p_i, r_j, p_j = split(q)
    return r_j + A(p_j) @ s_j - r_i - A(p_i) @ s_i


def length(q):
    return mpmath.sqrt(d_of(q) @ d_of(q))


def rate(q, v):
    return slope(length, q, v)


def force(q, v):
    return k * (length(q) - l0) + c * rate(q, v) + F


def f_over_l(q, v):
    return force(q, v) / length(q)


d, l, l_dot, f = d_of(q), length(q), rate(q, v), force(q, v)
d_dot = slope(d_of, q, v)
Q = kernel(element, "Q", q, v=v, t=t)
Q_q = kernel(element, "Q_q", q, v=v, t=t)
Q_v = kernel(element, "Q_v", q, v=v, t=t)
F_Q, N_Q = Q_q[:3], Q_q[3:7]  # the rows of the force and of the torque on body i
F_V, N_V = Q_v[:3], Q_v[3:7]


def test_eq_059_virtual_work():
    """δW = -f δl."""
    assert near(Q @ delta, -f * slope(length, q, delta))


def test_eq_060_force_law():
    """f = k (l - l0) + c l̇ + F."""
    assert near(Q[:3] @ d / l, element.law(l, l_dot, t).f, k * (l - l0) + c * l_dot + F)


def test_eq_061_length():
    """l² = d_ijᵀ d_ij."""
    spring = TSDA(s_i, s_j, mpmath.mpf(1), 0 * t, 0 * t, 0 * t)  # f = l
    assert near((kernel(spring, "Q", q, v=v, t=t)[:3] @ d / l) ** 2, d @ d)


def test_eq_062_variation_of_length():
    """δl."""
    dr_i, dp_i, dr_j, dp_j = split(delta)
    printed = d / l @ (dr_j + B_j @ dp_j - dr_i - B_i @ dp_i)
    assert near(printed, slope(length, q, delta), -(Q @ delta) / f)


def test_eq_063_generalized_forces():
    """Q_i and Q_j."""
    printed = np.concatenate([f / l * d, f / l * (B_i.T @ d), -f / l * d, -f / l * (B_j.T @ d)])
    assert near(Q, printed)


@cache
def f_over_l_q():
    return slopes(lambda q: f_over_l(q, v), q)


def test_eq_064_force_derivative():
    """Derivative of the force on body i with respect to q, by the product rule."""
    assert near(F_Q, np.outer(d, f_over_l_q()) + f / l * D_Q)


def test_eq_065_torque_derivative():
    """Derivative of the torque on body i with respect to q, by the product rule."""
    B_d_q = slopes(lambda q: B(q[3:7], s_i).T @ d_of(q), q)
    assert near(N_Q, np.outer(B_i.T @ d, f_over_l_q()) + f / l * B_d_q)


CURVATURE = row(zeros(4, 3), D(s_i, d), zeros(4, 7))


def test_eq_066_derivative_of_B_d():
    """(B_iᵀ d_ij)_q."""
    assert near(element.curvature(d)[1, 1], -D(s_i, d))
    assert near(B_i.T @ D_Q + CURVATURE, slopes(lambda q: B(q[3:7], s_i).T @ d_of(q), q))


def test_eq_067_torque_derivative_from_the_force():
    """Derivative of the torque on body i from that of the force; opposite sign on body j."""
    assert near(N_Q, B_i.T @ F_Q + f / l * CURVATURE)
    curvature_j = row(zeros(4, 10), D(s_j, d))
    assert near(Q_q[7:10], -F_Q)
    assert near(Q_q[10:], -B_j.T @ F_Q - f / l * curvature_j)


def test_eq_068_derivative_of_f_over_l():
    """(f / l)_q from l l_q and l l̇_q."""
    l_l_q = d @ D_Q
    l_rate_q = d @ row(zeros(3, 3), -Bd_i, zeros(3, 3), Bd_j) + (d_dot - l_dot / l * d) @ D_Q
    assert near(l_l_q, l * slopes(length, q))
    assert near(l_rate_q, l * slopes(lambda q: rate(q, v), q))
    of_sarrus = d @ (F_Q - f / l * D_Q) / l**2
    assert near(((k - f / l) * l_l_q + c * l_rate_q) / l**2, f_over_l_q(), of_sarrus)


N_1 = (k - f / l - c * l_dot / l) * np.outer(d, d) / l**2 + c * np.outer(d, d_dot) / l**2 + f / l * I3
N_2 = c * np.outer(d, d) / l**2


def test_eq_069_N_1():
    """N_1: minus the derivative of the force on body j with respect to its position."""
    assert near(F_Q[:, 7:10], N_1, slopes(lambda q: f_over_l(q, v) * d_of(q), q)[:, 7:10])


def test_eq_070_N_2():
    """N_2: the derivative of the force with respect to the other body's velocity."""
    assert near(F_V[:, 7:10], N_2)


PRINTED_071 = row(-N_1, -N_1 @ B_i - N_2 @ Bd_i, N_1, N_1 @ B_j + N_2 @ Bd_j)


def test_eq_071_force_derivative_written_out():
    """Derivative of the force on body i with respect to q, block by block."""
    assert near(F_Q, PRINTED_071)


def test_eq_072_torque_derivative_written_out():
    """Derivative of the torque on body i with respect to q, block by block."""
    by_p_i = -B_i.T @ (N_1 @ B_i + N_2 @ Bd_i) + f / l * D(s_i, d)
    assert near(N_Q, row(-B_i.T @ N_1, by_p_i, B_i.T @ N_1, B_i.T @ (N_1 @ B_j + N_2 @ Bd_j)))


@cache
def f_over_l_v():
    return slopes(lambda v: f_over_l(q, v), v)


def test_eq_073_force_to_velocity():
    """Derivative of the force on body i with respect to q̇."""
    assert near(F_V, np.outer(d, f_over_l_v()))


def test_eq_074_torque_to_velocity():
    """Derivative of the torque on body i with respect to q̇ from that of the force; opposite sign on body j."""
    assert near(N_V, B_i.T @ F_V)
    assert near(Q_v[7:], np.concatenate([-F_V, -B_j.T @ F_V]))


def test_eq_075_f_over_l_to_velocity():
    """(f / l)_q̇ = (c / l) l̇_q̇."""
    assert near(f_over_l_v(), c / l * slopes(lambda v: rate(q, v), v), d @ F_V / l**2)


def test_eq_076_rate_of_length():
    """l̇, with the undotted p as printed."""
    printed = d / l @ (w_j + B(v_j, s_j) @ p_j - w_i - B(v_i, s_i) @ p_i)
    damper = TSDA(s_i, s_j, 0 * t, mpmath.mpf(1), 0 * t, 0 * t)  # f = l̇
    assert near(printed, l_dot, kernel(damper, "Q", q, v=v, t=t)[:3] @ d / l)


PRINTED_077 = d / l @ D_Q


def test_eq_077_rate_of_length_to_velocity():
    """l̇_q̇."""
    assert near(PRINTED_077, slopes(lambda v: rate(q, v), v), d @ F_V / (c * l))


def test_eq_078_force_to_velocity_written_out():
    """Derivative of the force on body i with respect to q̇, block by block."""
    assert near(F_V, c * np.outer(d, d) / l**2 @ D_Q)


def test_eq_079_torque_to_velocity_written_out():
    """Derivative of the torque on body i with respect to q̇, block by block, with Bᵀ (erratum E2)."""
    assert near(N_V, c * B_i.T @ np.outer(d, d) / l**2 @ D_Q)
