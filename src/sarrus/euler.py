"""Euler parameters p = [e0; e] and the identities that every derivative is made of, one equation per function.

All of them are polynomials that hold for any p in R⁴, not only for unit p; the equation numbers are those of
R. Serban and E. J. Haug, "Analytical Derivatives for Multibody System Analyses". Lengths in any unit, p without unit.
"""

from __future__ import annotations

from .algebra import I3, Array, column, cross, outer, row, single, skew, stack


def A(p: Array) -> Array:
    """Body axes to global axes (3x3). Eq. (9): A = (2 e0² - 1) I + 2 (e eᵀ + e0 ẽ)."""
    e, d0, d = p[1:], 2 * p[0], 2 * p[1:]
    return (d0 * p[0] - 1) * I3 + outer(d, e) + p[0] * skew(d)


def rotate(p: Array, a: Array) -> Array:
    """A(p) a for a vector a fixed in the body (3,). Eq. (10)."""
    e0, e, d = p[0], p[1:], 2 * p[1:]
    return (2 * e0 * e0 - 1) * a + (d @ a) * e + e0 * cross(d, a)


def B(p: Array, a: Array) -> Array:
    """Derivative of A(p) a to p (3x4). Eqs. (13), (15), (16): B = 2 (a pᵀ + B̂(p, a)), here with ẽã = a eᵀ - (e·a) I:

    B = 2 [2 e0 a + e x a,  e aᵀ - e0 ã + (e·a) I].
    """
    d0, d = 2 * p[0], 2 * p[1:]
    return stack([[column(2 * d0 * a + cross(d, a)), outer(d, a) - d0 * skew(a) + (d @ a) * I3]])


def D(a: Array, x: Array) -> Array:
    """Derivative of Bᵀ(p, a) x to p (4x4, symmetric). Eqs. (24), (25): 2 [2 a·x, (a x x)ᵀ; a x x, a xᵀ + x aᵀ]."""
    d = 2 * a
    c = cross(d, x)
    return stack([[single(2 * (d @ x)), row(c)], [column(c), outer(d, x) + outer(x, d)]])


def G(p: Array) -> Array:
    """The matrix G = [-e, -ẽ + e0 I] (3x4): angular velocity in body axes is 2 G(p) ṗ."""
    return stack([[column(-p[1:]), p[0] * I3 - skew(p[1:])]])


def E(p: Array) -> Array:
    """The matrix E = [-e, ẽ + e0 I] (3x4): angular velocity in global axes is 2 E(p) ṗ."""
    return stack([[column(-p[1:]), p[0] * I3 + skew(p[1:])]])


def bar(x: Array) -> Array:
    """Derivative of Gᵀ(p) x to p (4x4, antisymmetric). Eqs. (54), (55)."""
    return stack([[single(0), row(-x)], [column(x), -skew(x)]])


def bar_E(x: Array) -> Array:
    """Derivative of Eᵀ(p) x to p (4x4, antisymmetric); as `bar`, for global axes."""
    return stack([[single(0), row(-x)], [column(x), skew(x)]])


def C(p: Array, b: Array) -> Array:
    """Derivative of B(p, a) b to a (3x3), symmetric in p and b: 2 [(p·b) I + (e0 I + ẽ)(b0 I + b̃) + e bᵀ]."""
    e0, e, b0, be = p[0], p[1:], b[0], b[1:]
    return 2 * ((p @ b) * I3 + (e0 * I3 + skew(e)) @ (b0 * I3 + skew(be)) + outer(e, be))


def K(p: Array, x: Array) -> Array:
    """Derivative of Bᵀ(p, a) x to a (4x3)."""
    e0, e = p[0], p[1:]
    lower = -e0 * skew(x) + (x @ e) * I3 + outer(x, e)
    return 2 * stack([[row(2 * e0 * x + cross(x, e))], [lower]])
