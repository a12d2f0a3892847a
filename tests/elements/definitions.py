"""What the elements are, written down a second time from their definitions: Φ, the kinetic energy, virtual work.

Only the paper's A(p) is used; velocities and directions come from differences of it.
"""

import math

import mpmath
from tests.paper.paper import A, vec

from sarrus import elements as el


def _points(e, q):
    """P_i and P_j."""
    return q[:3] + A(q[3:7]) @ e.s_i, q[7:10] + A(q[10:]) @ e.s_j


def distance(e, q):
    P_i, P_j = _points(e, q)
    return vec((P_j - P_i) @ (P_j - P_i) - e.length**2)


def dot1(e, q):
    return vec((A(q[3:7]) @ e.a_i) @ (A(q[10:]) @ e.a_j))


def dot2(e, q):  # Eq. (88); the part of s_i is a constant of unit p
    return vec((A(q[3:7]) @ e.a_i) @ (q[7:10] + A(q[10:]) @ e.s_j - q[:3]) - e.a_i @ e.s_i)


def spherical(e, q):
    P_i, P_j = _points(e, q)
    return P_j - P_i


def normalization(e, q):
    return vec(q[3] ** 2 + q[4] ** 2 + q[5] ** 2 + q[6] ** 2 - 1)


CONSTRAINTS = {
    el.Distance: distance,
    el.Dot1: dot1,
    el.Dot2: dot2,
    el.Spherical: spherical,
    el.Normalization: normalization,
}


def center(e):
    """Centre of mass in the body."""
    return getattr(e, "center", vec(0, 0, 0))


INERTIAS = {el.RigidInertia: center, el.EccentricInertia: center}


# Forces: the work that the force at (q, v, t), held fixed, does up to a neighbouring place y.


def point_force(e, state):
    return lambda y: e.force @ (y[:3] + A(y[3:]) @ e.s)


def follower_force(e, state):
    F = A(state.operands["q"][3:]) @ e.force
    return lambda y: F @ (y[:3] + A(y[3:]) @ e.s)


def gravity(e, state):
    return lambda y: e.mass * (e.g @ y[:3])


def eccentric_gravity(e, state):
    return lambda y: e.mass * (e.g @ (y[:3] + A(y[3:]) @ e.center))


def _axial(X):
    """Twice the vector of the antisymmetric part."""
    return vec(X[2, 1] - X[1, 2], X[0, 2] - X[2, 0], X[1, 0] - X[0, 1])


def torque(e, state):
    start = A(state.operands["q"][3:])
    return lambda y: (e.torque @ _axial(A(y[3:]) @ start.T)) / 2


def body_torque(e, state):
    start = A(state.operands["q"][3:])
    return lambda y: (e.torque @ _axial(start.T @ A(y[3:]))) / 2


def tyre(e, state):
    def height(state):
        q = state.operands["q"]
        return (q[:3] + A(q[3:]) @ e.s)[2]

    sinking = state.difference(height, "q", state.operands["v"])
    F = e.k * (e.radius - (height(state) - e.road)) - e.c * sinking
    return lambda y: F * (y[:3] + A(y[3:]) @ e.s)[2]


def _length(e, q):
    P_i, P_j = _points(e, q)
    return mpmath.sqrt((P_j - P_i) @ (P_j - P_i))


def _length_and_rate(e, state):
    rate = state.difference(lambda s: _length(e, s.operands["q"]), "q", state.operands["v"])
    return _length(e, state.operands["q"]), rate


def tsda(e, state):
    length, rate = _length_and_rate(e, state)
    f = e.k * (length - e.length) + e.c * rate + e.force
    return lambda y: -f * _length(e, y)


def _curve(numbers, x):
    """A curve of two cubics."""
    _, first, second, _, *c = numbers
    u, c = (x - first, c[:4]) if x < second else (x - second, c[4:])
    return c[0] * u**3 + c[1] * u**2 + c[2] * u + c[3]


def nonlinear_tsda(e, state):
    length, rate = _length_and_rate(e, state)
    kappa, chi, phi = state.store[:12], state.store[12:24], state.store[24:]
    f = e.k * _curve(kappa, length) * (length - e.length)
    f = f + e.c * _curve(chi, rate) * rate + e.force * _curve(phi, state.operands["t"])
    return lambda y: -f * _length(e, y)


def rsda_angle(e, q):
    """Angle of f_j in the plane of f_i and g_i, without turns."""
    f_j, A_i = A(q[10:]) @ e.f_j, A(q[3:7])
    return mpmath.atan2((A_i @ e.g_i) @ f_j, (A_i @ e.f_i) @ f_j)


def rsda_turned(e, q):
    """The same, with whole turns added to come nearest to the reference."""
    angle = rsda_angle(e, q)
    turns = min(range(-50, 51), key=lambda n: abs(angle + 2 * math.pi * n - e.reference))
    return angle + 2 * math.pi * turns  # π of 16 digits, as everywhere else


def rsda(e, state):
    q, v = state.operands["q"], state.operands["v"]
    rate = state.difference(lambda s: rsda_angle(e, s.operands["q"]), "q", v)
    n = e.k * (rsda_turned(e, q) - e.angle) + e.c * rate + e.torque
    return lambda y: -n * rsda_angle(e, y)


FORCES = {
    el.PointForce: point_force,
    el.FollowerForce: follower_force,
    el.Gravity: gravity,
    el.EccentricGravity: eccentric_gravity,
    el.Torque: torque,
    el.BodyTorque: body_torque,
    el.Tyre: tyre,
    el.TSDA: tsda,
    el.NonlinearTSDA: nonlinear_tsda,
    el.RSDA: rsda,
}
ROTATIONAL = (el.Torque, el.BodyTorque, el.RSDA)  # their work is that of a rotation: unit p and pᵀδp = 0 only
