"""What the elements are, written down a second time from their definitions: Φ, the kinetic energy, virtual work.

Only the paper's A(p) is used; velocities and directions come from differences of it.
"""

import math

import mpmath
import numpy as np
from tests.elements.states import SURFACE
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


def displacement(e, q):
    return dot2(e, q) - e.displacement


def _motion(e):
    """The value of a driver's function of time."""
    return _curve(e.motion.numbers[12 * (e.motion.at // 12) :][:12], e.t)


def displacement_driver(e, q):
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


def heading(e, q):
    x, y = (_displacement(a, e.s_i, e.s_j, q) for a in (e.f_i, e.g_i))
    return vec(_turned(mpmath.atan2(y, x), e.reference) - e.angle)


def screw(e, q):
    displacement = (A(q[3:7]) @ e.h_i) @ (q[7:10] + A(q[10:]) @ e.s_j - q[:3]) - e.h_i @ e.s_i
    theta = _turned(_angle(e.f_i, e.g_i, e.f_j, q), e.angle + (displacement - e.displacement) / e.lead)
    return vec(displacement - e.displacement - e.lead * (theta - e.angle))


def _displacement(a, s_i, s_j, q):  # as in `dot2`
    return (A(q[3:7]) @ a) @ (q[7:10] + A(q[10:]) @ s_j - q[:3]) - a @ s_i


def angle_angle(e, q):
    first = _turned(_angle(e.f_i, e.g_i, e.f_j, q[:14]), e.reference)
    second = _turned(_angle(e.f_k, e.g_k, e.f_l, q[14:]), e.ratio * first + e.offset)
    return vec(second - e.ratio * first - e.offset)


def displacement_angle(e, q):
    displacement = _displacement(e.a_i, e.s_i, e.s_j, q[:14]) - e.offset
    return vec(displacement - e.ratio * _turned(_angle(e.f_k, e.g_k, e.f_l, q[14:]), displacement / e.ratio))


def displacement_displacement(e, q):
    first, second = _displacement(e.a_i, e.s_i, e.s_j, q[:14]), _displacement(e.a_k, e.s_k, e.s_l, q[14:])
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
    el.Heading: heading,
    el.Normalization: normalization,
    el.Screw: screw,
    el.Spherical: spherical,
    el.Displacement: displacement,
    el.DisplacementAngle: displacement_angle,
    el.DisplacementDriver: displacement_driver,
    el.DisplacementDisplacement: displacement_displacement,
}


def center(e):
    """Centre of mass in the body."""
    return getattr(e, "center", vec(0, 0, 0))


INERTIAS = {el.RigidInertia: center, el.EccentricInertia: center}
JOINT_INERTIAS = {  # the coordinate, by (e, q)
    el.AngleInertia: lambda e, q: _angle(e.f_i, e.g_i, e.f_j, q),
    el.DisplacementInertia: lambda e, q: _displacement(e.h_i, e.s_i, e.s_j, q),
}


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


def moment(stored, a, b):
    """The integral from a to b of a stored curve of two cubics, times x - a."""
    _, first, middle, _, *c = stored.numbers[int(stored.at) :][:12]

    def until(x, knot, cubic):  # of (x - knot + knot - a) times the cubic in u = x - knot
        u, d = x - knot, knot - a
        terms = ((cubic[3 - n] * (u ** (n + 2) / (n + 2) + d * u ** (n + 1) / (n + 1))) for n in range(4))
        return sum(terms)

    low, high = (until, first, c[:4]), (until, middle, c[4:])
    of = [high if x.real >= middle.real else low for x in (a, b)]
    ends = (
        [(a, of[0]), (b, of[1])]
        if of[0] is of[1]
        else [(a, of[0]), (middle, of[0]), (middle, of[1]), (b, of[1])]
    )
    values = [f(x, knot, cubic) for x, (f, knot, cubic) in ends]
    return sum(upper - lower for lower, upper in zip(values[::2], values[1::2], strict=True))


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


def nonlinear_rsda(e, state):
    q, v = state.operands["q"], state.operands["v"]
    angle, rate = rsda_turned(e, q), state.difference(lambda s: rsda_angle(e, s.operands["q"]), "q", v)
    kappa, chi, phi = state.store[:12], state.store[12:24], state.store[24:]
    n = e.k * _curve(kappa, angle) * (angle - e.angle) + e.c * _curve(chi, rate) * rate
    n = n + e.torque * _curve(phi, state.operands["t"])
    return lambda y: -n * rsda_angle(e, y)


def _deformation(e, q):
    """Translation and rotation vector φ n of body j as seen in frame i, from n sin φ in the rotation matrix."""
    P_i, P_j = _points(e, q)
    frame_i = A(q[3:7]) @ np.array([e.f_i, e.g_i, e.h_i]).T
    across = _axial(A(q[10:]) @ (A(q[3:7]) @ A(np.array([e.e_0, *e.e]))).T) / 2
    sine = mpmath.sqrt(across @ across)
    return np.concatenate([frame_i.T @ (P_j - P_i), frame_i.T @ (across * (mpmath.asin(sine) / sine))])


def bushing(e, state):
    rate = state.difference(lambda s: _deformation(e, s.operands["q"]), "q", state.operands["v"])
    F = e.K.reshape(6, 6) @ _deformation(e, state.operands["q"]) + e.C.reshape(6, 6) @ rate - e.preload
    return lambda y: -(F @ _deformation(e, y))


def _varied(given, state):
    return vec(*(g * _curve(state.store[12 * n :][:12], state.operands["t"]) for n, g in enumerate(given)))


def varying_force(e, state):
    return lambda y: _varied(e.force, state) @ (y[:3] + A(y[3:]) @ e.s)


def varying_follower_force(e, state):
    F = A(state.operands["q"][3:]) @ _varied(e.force, state)
    return lambda y: F @ (y[:3] + A(y[3:]) @ e.s)


def varying_torque(e, state):
    start = A(state.operands["q"][3:])
    return lambda y: (_varied(e.torque, state) @ _axial(A(y[3:]) @ start.T)) / 2


def varying_body_torque(e, state):
    start = A(state.operands["q"][3:])
    return lambda y: (_varied(e.torque, state) @ _axial(start.T @ A(y[3:]))) / 2


def rounded(x, width):
    """The ramp max(x, 0), rounded: the integral of a cubic step from -width/2 to width/2."""
    if x <= -width / 2:
        return 0 * x
    if x >= width / 2:
        return x
    u = x / width + mpmath.mpf(1) / 2
    return width * (u**3 - u**4 / 2)


def step(x, width):
    """The step 0, 1, made a cubic from -width/2 to width/2."""
    u = min(max(x / width + mpmath.mpf(1) / 2, 0), 1)
    return 3 * u**2 - 2 * u**3


def normal_force(e, depth, rate):
    """Hunt and Crossley, rounded."""
    return e.k * rounded(depth, e.width) ** e.exponent * rounded(1 + e.damping * rate, mpmath.mpf(1) / 4)


def friction(e, u):
    """Stribeck, regularized."""
    mu = e.mu + (e.mu_static - e.mu) / mpmath.exp((u / e.stribeck) ** 2)
    return e.load * mu * mpmath.tanh(u / e.creep) + e.viscous * u


def _hermite(u, width, left, right):
    """The cubic with a value and a slope at either end."""
    (z_0, s_0), (z_1, s_1) = left, right
    chord = (z_1 - z_0) / width
    return z_0 + u * (
        s_0 + u * ((3 * chord - 2 * s_0 - s_1) / width + u * (s_0 + s_1 - 2 * chord) / width**2)
    )


def _surface(numbers, x, y):
    """A surface of 3 x 3 points, continued by its tangents."""

    def along(knots, x, nodes):
        if not knots[0] <= x <= knots[-1]:
            at, (z, slope) = (knots[0], nodes[0]) if x < knots[0] else (knots[-1], nodes[-1])
            return z + slope * (x - at)
        k = int(x > knots[1])
        return _hermite(x - knots[k], knots[k + 1] - knots[k], *nodes[k : k + 2])

    in_x, in_y, nodes = numbers[2:5], numbers[5:8], np.reshape([*map(mpmath.mpf, numbers[8:])], (3, 3, 2, 2))
    lines = [[along(in_y, y, [node[:, at] for node in line]) for at in (0, 1)] for line in nodes]
    return along(in_x, x, lines)


def _tyre_depth(e, q, height, bump):
    P = q[:3] + A(q[3:]) @ e.s
    return e.radius - (P[2] - (e.road + height(P) + bump))


def road_tyre(e, state):
    """The road's height under the wheel changes as the wheel moves and as time passes."""
    bump, profile = state.store[:12], state.store[12:24]
    return _on_road(e, state, lambda P: _curve(profile, P[0]), bump)


def surface_tyre(e, state):
    """The road's height under the wheel depends on both of its horizontal coordinates."""
    return _on_road(e, state, lambda P: _surface(state.store[-len(SURFACE) :], P[0], P[1]), state.store[:12])


def _on_road(e, state, height, bump):
    q = state.operands["q"]

    def depth(q, t):
        return _tyre_depth(e, q, height, _curve(bump, t))

    t, one = state.operands["t"], state.operands["t"] ** 0
    rate = state.difference(lambda s: depth(s.operands["q"], t), "q", state.operands["v"])
    rate = rate + state.difference(lambda s: depth(q, s.operands["t"]), "t", one)
    F = step(depth(q, t), e.width) * rounded(e.k * depth(q, t) + e.c * rate, e.k * e.width)
    return lambda y: F * (y[:3] + A(y[3:]) @ e.s)[2]


def _stop(coordinate):
    """A stop on a coordinate (e, q)."""

    def stop(e, state):
        x = coordinate(e, state.operands["q"])
        rate = state.difference(lambda s: coordinate(e, s.operands["q"]), "q", state.operands["v"])
        f = e.sign * normal_force(e, e.sign * (x - e.limit), e.sign * rate)
        return lambda y: -f * coordinate(e, y)

    return stop


def _stop_displacement(e, q):
    P_i, P_j = _points(e, q)
    return (A(q[3:7]) @ e.h_i) @ (P_j - P_i)


def _reduced_displacement(e, q):
    """The same on unit p, as Eq. (88) has it."""
    return (A(q[3:7]) @ e.h_i) @ (q[7:10] + A(q[10:]) @ e.s_j - q[:3]) - e.h_i @ e.s_i


def displacement_friction(e, state):
    def displacement(q):
        return (A(q[3:7]) @ e.h_i) @ (q[7:10] + A(q[10:]) @ e.s_j - q[:3])

    f = friction(e, state.difference(lambda s: displacement(s.operands["q"]), "q", state.operands["v"]))
    return lambda y: -f * displacement(y)


def _spin(state, first):
    """Angular velocity in global axes, of ȦAᵀ."""
    turned = state.difference(lambda s: A(s.operands["q"][first : first + 4]), "q", state.operands["v"])
    return _axial(turned @ A(state.operands["q"][first : first + 4]).T) / 2


def angle_friction(e, state):
    q = state.operands["q"]
    A_i, A_j = A(q[3:7]), A(q[10:])
    h = A_i @ e.h_i
    T = e.radius * friction(e, e.radius * (h @ (_spin(state, 10) - _spin(state, 3)))) * h
    return lambda y: T @ (_axial(A(y[3:7]) @ A_i.T) - _axial(A(y[10:]) @ A_j.T)) / 2


def sphere_depth(e, q):
    """How far the sphere is in the plane, of unit normal."""
    P_i, P_j = _points(e, q)
    return e.radius - (A(q[10:]) @ e.n_j) @ (P_i - P_j)


def sphere_contact(e, state):
    """The force acts on the two material points that are where the sphere is deepest in the plane."""
    q = state.operands["q"]
    A_i, A_j = A(q[3:7]), A(q[10:])
    n = A_j @ e.n_j
    deepest = q[:3] + A_i @ e.s_i - e.radius * n
    s_i, s_j = A_i.T @ (deepest - q[:3]), A_j.T @ (deepest - q[7:10])

    def apart(y):
        return y[:3] + A(y[3:7]) @ s_i - y[7:10] - A(y[10:]) @ s_j

    u = state.difference(lambda s: apart(s.operands["q"]), "q", state.operands["v"])
    N = normal_force(e, sphere_depth(e, q), -(u @ n))
    u = u - (u @ n) * n
    F = N * n - e.mu * N * u / mpmath.sqrt(u @ u + e.creep**2)
    return lambda y: F @ apart(y)


def drag(e, state):
    def point(q):
        return q[:3] + A(q[3:]) @ e.s

    u = state.difference(lambda s: point(s.operands["q"]), "q", state.operands["v"]) - e.wind
    F = -e.c * mpmath.sqrt(u @ u + e.creep**2) * u
    return lambda y: F @ point(y)


def viscous_drag(e, state):
    def point(q):
        return q[:3] + A(q[3:]) @ e.s

    F = -e.c * state.difference(lambda s: point(s.operands["q"]), "q", state.operands["v"])
    T, start = -e.c_turn * _spin(state, 3), A(state.operands["q"][3:])
    return lambda y: F @ point(y) + T @ _axial(A(y[3:]) @ start.T) / 2


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
    el.NonlinearRSDA: nonlinear_rsda,
    el.Bushing: bushing,
    el.VaryingForce: varying_force,
    el.VaryingFollowerForce: varying_follower_force,
    el.VaryingTorque: varying_torque,
    el.VaryingBodyTorque: varying_body_torque,
    el.RoadTyre: road_tyre,
    el.SurfaceTyre: surface_tyre,
    el.LengthStop: _stop(_length),
    el.DisplacementStop: _stop(_stop_displacement),
    el.AngleStop: _stop(rsda_turned),
    el.AngleFriction: angle_friction,
    el.DisplacementFriction: displacement_friction,
    el.SphereContact: sphere_contact,
    el.Drag: drag,
    el.ViscousDrag: viscous_drag,
}
# Their work is that of a rotation, or measured by DOT-2 in its reduced form: on unit p, for pᵀδp = 0, only.
ROTATIONAL = (
    el.Torque, el.BodyTorque, el.RSDA, el.NonlinearRSDA, el.Bushing, el.VaryingTorque, el.VaryingBodyTorque,
    el.AngleStop, el.DisplacementStop, el.AngleFriction, el.DisplacementFriction, el.SphereContact, el.ViscousDrag,
)  # fmt: skip
ON_A_HINGE = (el.RSDA, el.NonlinearRSDA, el.AngleStop)
DEPTHS = {  # of contacts: the field that moves the depth, and the depth by (e, q, t)
    el.LengthStop: ("limit", lambda e, q, t: e.sign * (_length(e, q) - e.limit)),
    el.DisplacementStop: ("limit", lambda e, q, t: e.sign * (_reduced_displacement(e, q) - e.limit)),
    el.AngleStop: ("limit", lambda e, q, t: e.sign * (rsda_turned(e, q) - e.limit)),
    el.SphereContact: ("radius", lambda e, q, t: sphere_depth(e, q)),
    el.RoadTyre: ("radius", lambda e, q, t: _tyre_depth(e, q, lambda P: e.profile(P[0]), e.bump(t))),
    el.SurfaceTyre: ("radius", lambda e, q, t: _tyre_depth(e, q, lambda P: e.surface(*P[:2]), e.bump(t))),
}
