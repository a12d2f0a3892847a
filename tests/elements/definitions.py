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


def constant_angle(e, q):
    return dot1(e, q) - e.cosine


def travel(e, q):
    return dot2(e, q) - e.travel


def _motion(e):
    """The value of a driver's function of time."""
    return _curve(e.motion.numbers[12 * (e.motion.at // 12) :][:12], e.t)


def travel_driver(e, q):
    return dot2(e, q) - e.scale * _motion(e)


def distance_driver(e, q):
    P_i, P_j = _points(e, q)
    return vec((P_j - P_i) @ (P_j - P_i) - (e.length * _motion(e)) ** 2)


def coordinate_driver(e, q):
    return vec(e.by_r @ q[:3] + e.by_e0 * q[3] + e.by_e @ q[4:] - e.scale * _motion(e))


def _angle(f_i, g_i, f_j, q):
    """Angle of f_j in the plane of f_i and g_i, without turns; q of two bodies."""
    a, A_i = A(q[10:]) @ f_j, A(q[3:7])
    return mpmath.atan2((A_i @ g_i) @ a, (A_i @ f_i) @ a)


def _turned(angle, near):
    """An angle with the whole turns that bring it nearest to another one; π of 16 digits, as everywhere else."""
    return angle + 2 * math.pi * min(range(-99, 100), key=lambda n: abs(angle + 2 * math.pi * n - near))


def angle(e, q):
    return vec(_turned(_angle(e.f_i, e.g_i, e.f_j, q), e.reference) - e.angle)


def angle_driver(e, q):
    goal = e.scale * _motion(e)
    return vec(_turned(_angle(e.f_i, e.g_i, e.f_j, q), goal) - goal)


def screw(e, q):
    travel = (A(q[3:7]) @ e.h_i) @ (q[7:10] + A(q[10:]) @ e.s_j - q[:3]) - e.h_i @ e.s_i
    theta = _turned(_angle(e.f_i, e.g_i, e.f_j, q), e.angle + (travel - e.travel) / e.lead)
    return vec(travel - e.travel - e.lead * (theta - e.angle))


def _travel(a, s_i, s_j, q):  # as in `dot2`
    return (A(q[3:7]) @ a) @ (q[7:10] + A(q[10:]) @ s_j - q[:3]) - a @ s_i


def angle_angle(e, q):
    first = _turned(_angle(e.f_i, e.g_i, e.f_j, q[:14]), e.reference)
    second = _turned(_angle(e.f_k, e.g_k, e.f_l, q[14:]), e.ratio * first + e.offset)
    return vec(second - e.ratio * first - e.offset)


def travel_angle(e, q):
    travel = _travel(e.a_i, e.s_i, e.s_j, q[:14]) - e.offset
    return vec(travel - e.ratio * _turned(_angle(e.f_k, e.g_k, e.f_l, q[14:]), travel / e.ratio))


def travel_travel(e, q):
    first, second = _travel(e.a_i, e.s_i, e.s_j, q[:14]), _travel(e.a_k, e.s_k, e.s_l, q[14:])
    return vec(second - e.ratio * first - e.offset)


CONSTRAINTS = {
    el.Angle: angle,
    el.AngleAngle: angle_angle,
    el.AngleDriver: angle_driver,
    el.ConstantAngle: constant_angle,
    el.CoordinateDriver: coordinate_driver,
    el.Distance: distance,
    el.DistanceDriver: distance_driver,
    el.Dot1: dot1,
    el.Dot2: dot2,
    el.Normalization: normalization,
    el.Screw: screw,
    el.Spherical: spherical,
    el.Travel: travel,
    el.TravelAngle: travel_angle,
    el.TravelDriver: travel_driver,
    el.TravelTravel: travel_travel,
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
