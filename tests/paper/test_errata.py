"""Each erratum of docs/errata.md that can be computed: the printed form fails, the right form holds.

This file imports nothing of Sarrus: the toolbox below is written from the definitions, Eqs. (8), (9), (14),
(15), (25), (51) and (55). States are rational, and polynomials of degree at most four are differentiated
exactly, so that most comparisons are of equality. Where a root or an angle enters, derivatives are taken by a
complex step.
"""

from fractions import Fraction

import numpy as np
import pytest

MACHINE = 1e-12  # a complex step has no truncation error; some hundred operations round
I3, I4 = np.eye(3, dtype=int), np.eye(4, dtype=int)
J = np.array([[5, 1, -1], [1, 6, 2], [-1, 2, 7]])


def tilde(x):
    return np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])


def A(p):
    e = p[1:]
    return (2 * p[0] * p[0] - 1) * I3 + 2 * (np.outer(e, e) + p[0] * tilde(e))


def B(p, s):
    T = p[0] * I3 + tilde(p[1:])
    return 2 * (np.outer(s, p) + np.column_stack([T @ s, np.outer(p[1:], s) - T @ tilde(s)]))


def D(s, y):
    w = np.cross(s, y)[:, None]
    return 2 * np.block([[np.array([[2 * (s @ y)]]), w.T], [w, np.outer(s, y) + np.outer(y, s)]])


def G(p):
    return np.column_stack([-p[1:], -tilde(p[1:]) + p[0] * I3])


def bar(x):
    return np.block([[np.zeros((1, 1), dtype=int), -x[None, :]], [x[:, None], -tilde(x)]])


def jacobian(f, x):
    """Exact for polynomials of degree at most four in rational numbers: five points a unit apart."""
    columns = []
    for k in range(len(x)):
        e = np.array([Fraction(int(i == k)) for i in range(len(x))])
        columns.append((8 * (f(x + e) - f(x - e)) - (f(x + 2 * e) - f(x - 2 * e))) / Fraction(12))
    return np.array(columns).T


def complex_step(f, x, direction):
    return np.imag(f(x + 1e-200j * direction)) / 1e-200


def rational(seed, n):
    return np.array([Fraction(int(k), 7) for k in np.random.default_rng(seed).integers(-20, 20, n) * 2 + 1])


def split(x):
    return x[:3], x[3:7], x[7:10], x[10:14]


def d_ij(x, s_i, s_j):
    r_i, p_i, r_j, p_j = split(x)
    return r_j + A(p_j) @ s_j - r_i - A(p_i) @ s_i


def test_E1_sign_in_eq_58():
    p, p_dot = rational(1, 4), rational(2, 4)
    exact = jacobian(lambda y: G(y).T @ J @ G(y) @ p, p_dot)
    first, second = G(p_dot).T @ J @ G(p), bar(J @ G(p_dot) @ p)
    assert (exact == -first + second).all()
    assert not (exact == first + second).all()


@pytest.mark.parametrize("stiffening", [0.0, 2.0])
def test_E2_transpose_in_eq_79_and_E13_force_laws(stiffening):
    """A spring with k(l) = k + stiffening l, whose f_l takes the place of k in Eqs. (68) to (72)."""
    rng = np.random.default_rng(3)
    x, v, s_i, s_j, t = (rng.normal(size=n) for n in (14, 14, 3, 3, 14))
    k, c, l0 = 10.0, 1.5, 0.7

    def force(x, v):
        d = d_ij(x, s_i, s_j)
        rate = v[7:10] + B(x[10:], s_j) @ v[10:] - v[:3] - B(x[3:7], s_i) @ v[3:7]
        length = np.sqrt(d @ d)
        return (k + stiffening * length) * (length - l0) + c * (d @ rate) / length, d, rate, length

    def on_p_i(x, v):
        f, d, _, length = force(x, v)
        return f / length * (B(x[3:7], s_i).T @ d)

    f, d, rate, length = force(x, v)
    B_i, B_j, Bd_i, Bd_j = (B(y, s) for y, s in ((x[3:7], s_i), (x[10:], s_j), (v[3:7], s_i), (v[10:], s_j)))
    d_q = np.hstack([-I3, -B_i, I3, B_j])
    Q_v = c * B_i.T @ np.outer(d, d) / length**2 @ d_q  # Eq. (79) with the transpose
    assert np.allclose(Q_v @ t, complex_step(lambda v: on_p_i(x, v), v, t), rtol=MACHINE, atol=MACHINE)
    with pytest.raises(ValueError, match="mismatch"):
        B_i @ np.outer(d, d)  # as printed

    def Q_q(k_or_f_l):
        l_rate = d @ rate / length
        N_1 = (k_or_f_l - f / length - c * l_rate / length) * np.outer(d, d) / length**2
        N_1 = N_1 + c * np.outer(d, rate) / length**2 + f / length * I3
        N_2 = c * np.outer(d, d) / length**2
        blocks = [-N_1, -N_1 @ B_i - N_2 @ Bd_i, N_1, N_1 @ B_j + N_2 @ Bd_j]
        corner = np.hstack([np.zeros((4, 3)), f / length * D(s_i, d), np.zeros((4, 7))])
        return B_i.T @ np.hstack(blocks) + corner  # Eq. (72)

    exact = complex_step(lambda x: on_p_i(x, v), x, t)
    f_l = k + stiffening * length + stiffening * (length - l0)
    assert np.allclose(Q_q(f_l) @ t, exact, rtol=MACHINE, atol=MACHINE * 100)
    assert np.allclose(Q_q(k) @ t, exact) == (stiffening == 0)


def test_E3_point_in_eq_100():
    x, xi, eta, s_i, s_j = (rational(s, n) for s, n in ((4, 14), (5, 14), (6, 14), (7, 3), (8, 3)))

    def Phi_q(x):
        d = d_ij(x, s_i, s_j)
        return np.concatenate([-2 * d, -2 * d @ B(x[3:7], s_i), 2 * d, 2 * d @ B(x[10:], s_j)])  # Eq. (96)

    def Phi_q_xi(x):
        return Phi_q(x) @ xi

    def Phi_q_xi_eta(x):
        return np.array([jacobian(lambda y: np.array([Phi_q_xi(y)]), x)[0] @ eta])

    _, p_i, _, p_j = split(x)
    # Eqs. (97), (98)
    along = [y[:3] + B(p_i, s_i) @ y[3:7] - y[7:10] - B(p_j, s_j) @ y[10:] for y in (xi, eta)]
    chi = B(xi[3:7], s_i) @ eta[3:7] - B(xi[10:], s_j) @ eta[10:]
    exact = jacobian(Phi_q_xi_eta, x)[0, 10:]

    def fourth_block(s):
        return -2 * along[1] @ B(xi[10:], s) - 2 * along[0] @ B(eta[10:], s_j) - 2 * chi @ B(p_j, s_j)

    assert (fourth_block(s_j) == exact).all()
    assert not (fourth_block(s_i) == exact).all()


@pytest.fixture
def rsda():
    """A revolute joint that is satisfied: unit Euler parameters, f_j normal to h_i, tangent velocities."""
    rng = np.random.default_rng(9)
    p_i, p_j = (y / np.linalg.norm(y) for y in rng.normal(size=(2, 4)))
    v_i, v_j = (y - (y @ p) * p for y, p in zip(rng.normal(size=(2, 4)), (p_i, p_j), strict=True))
    f, g, h = np.linalg.qr(rng.normal(size=(3, 3)))[0].T
    h = np.cross(f, g)
    f_j = A(p_j).T @ A(p_i) @ (np.cos(0.6) * f + np.sin(0.6) * g)
    return p_i, p_j, v_i, v_j, f, g, h, f_j


def torque(y, v, f, g, f_j, k, c):
    """n = k theta + c theta_dot, from theta = atan(s/c) itself."""
    (p_i, p_j), (v_i, v_j) = (y[:4], y[4:]), (v[:4], v[4:])
    u, w, z = A(p_i) @ f, A(p_i) @ g, A(p_j) @ f_j
    cos, sin = u @ z, w @ z
    cos_dot = (B(p_i, f) @ v_i) @ z + u @ (B(p_j, f_j) @ v_j)
    sin_dot = (B(p_i, g) @ v_i) @ z + w @ (B(p_j, f_j) @ v_j)
    return k * np.arctan(sin / cos) + c * (cos * sin_dot - sin * cos_dot) / (cos * cos + sin * sin)


def test_E4_E5_E6_torque_derivatives_in_eqs_110_and_112(rsda):
    p_i, p_j, v_i, v_j, f, g, h, f_j = rsda
    y, v, k, c = np.concatenate([p_i, p_j]), np.concatenate([v_i, v_j]), 3.0, 0.8
    u, w, z = A(p_i) @ f, A(p_i) @ g, A(p_j) @ f_j
    cos, sin = u @ z, w @ z
    X, B_j = cos * B(p_i, g) - sin * B(p_i, f), B(p_j, f_j)

    n_p_i = k * z @ X + c * (v_j @ B_j.T @ X + z @ (cos * B(v_i, g) - sin * B(v_i, f)))  # Eq. (110)
    ours = k * (cos * w - sin * u) @ B_j + c * (v_i @ X.T @ B_j + (cos * w - sin * u) @ B(v_j, f_j))
    printed = ours - c * (cos * w - sin * u) @ B(v_j, f_j) + c * (cos * w @ B(v_i, g) - sin * u @ B(v_i, f))
    with pytest.raises(ValueError, match="mismatch"):
        v_i @ X @ B_j  # E5: no transpose, as printed

    def exact(direction):
        return complex_step(lambda y: torque(y, v, f, g, f_j, k, c), y, direction)

    for seed in range(5):
        t_i, t_j = np.random.default_rng(seed).normal(size=(2, 4))
        t_i, t_j, zero = t_i - (t_i @ p_i) * p_i, t_j - (t_j @ p_j) * p_j, np.zeros(4)
        assert np.isclose(n_p_i @ t_i, exact(np.r_[t_i, zero]), rtol=0, atol=100 * MACHINE)
        assert np.isclose(ours @ t_j, exact(np.r_[zero, t_j]), rtol=0, atol=100 * MACHINE)
        assert not np.isclose(printed @ t_j, exact(np.r_[zero, t_j]), rtol=0, atol=1e-3)  # E4
    assert not np.isclose(n_p_i @ p_i, exact(np.r_[p_i, zero]), rtol=0, atol=1e-3)  # E6: not tangent


def test_E7_the_reduced_dot_2_is_another_function():
    """Eqs. (87) and (88) differ by a multiple of p^T p - 1; on it their gradients differ along p_i."""
    s_i, s_j, a_i, x = rational(10, 3), rational(11, 3), rational(12, 3), rational(13, 14)
    p = x[3:7] = np.array([Fraction(k, 11) for k in (1, 2, 4, 10)])
    assert p @ p == 1

    def full(x):
        return np.array([(A(x[3:7]) @ a_i) @ d_ij(x, s_i, s_j)])

    def reduced(x):
        r_i, p_i, r_j, p_j = split(x)
        return np.array([(A(p_i) @ a_i) @ (r_j + A(p_j) @ s_j - r_i) - s_i @ a_i])

    assert full(x) == reduced(x)
    assert full(2 * x) != reduced(2 * x)
    kappa = 4 * (a_i @ s_i) * (1 + p[0] ** 2 - p[1:] @ p[1:]) + 8 * (a_i @ p[1:]) * (s_i @ p[1:])
    difference = (jacobian(full, x) - jacobian(reduced, x))[0]
    assert kappa != 0
    assert (difference == np.concatenate([[0] * 3, -kappa * p, [0] * 7])).all()


def test_E8_sign_of_the_acceleration_terms():
    """Along q + v t, the second derivative of Phi is Eq. (41); so Phi_q a must be its negative."""
    x, v, s_i, s_j = (rational(s, n) for s, n in ((14, 14), (15, 14), (16, 3), (17, 3)))
    f = [d_ij(x + k * v, s_i, s_j) for k in (-1, 0, 1)]
    second = f[0] - 2 * f[1] + f[2]  # exact: Phi is quadratic
    assert (second == -B(v[3:7], s_i) @ v[3:7] + B(v[10:], s_j) @ v[10:]).all()


def test_E11_the_angle_turns_with_the_relative_angular_velocity(rsda):
    p_i, p_j, v_i, v_j, f, g, h, f_j = rsda
    rate = torque(np.concatenate([p_i, p_j]), np.concatenate([v_i, v_j]), f, g, f_j, k=0, c=1)
    omega_i, omega_j = 2 * A(p_i) @ G(p_i) @ v_i, 2 * A(p_j) @ G(p_j) @ v_j
    assert np.isclose(rate, (A(p_i) @ h) @ (omega_j - omega_i), rtol=0, atol=100 * MACHINE)


def test_E12_factors_of_inertia():
    """Eq. (56) enters (M a)_q four times, Eqs. (57) and (58) enter S_q and S_v eight times."""
    p, y = rational(18, 4), rational(19, 4)
    M_a = jacobian(lambda p: 4 * G(p).T @ J @ G(p) @ y, p)
    assert (M_a == 4 * (-G(p).T @ J @ G(y) + bar(J @ G(p) @ y))).all()
    S = 8 * G(y).T @ J @ G(y) @ p

    def kinetic_energy(z):  # z = [p; p_dot], Eq. (5): S = T_p - (T_p_dot)_p p_dot
        return np.array([2 * z[4:] @ G(z[:4]).T @ J @ G(z[:4]) @ z[4:]])

    def T_p_dot(p):
        return jacobian(lambda y: kinetic_energy(np.concatenate([p, y])), y)[0]

    T_p = jacobian(lambda p: kinetic_energy(np.concatenate([p, y])), p)[0]
    assert (S == T_p - jacobian(T_p_dot, p) @ y).all()


def test_E14_the_pair_of_torques_balances_only_if_the_axes_agree(rsda):
    p_i, p_j, *_, h, _ = rsda
    n, h_j = 1.7, np.array([0.0, 0.6, 0.8])
    Q_i, Q_j = 2 * n * G(p_i).T @ h, -2 * n * G(p_j).T @ h_j
    moments = [A(p) @ (G(p) @ Q) / 2 for p, Q in ((p_i, Q_i), (p_j, Q_j))]
    assert np.allclose(sum(moments), n * (A(p_i) @ h - A(p_j) @ h_j), rtol=0, atol=MACHINE)
