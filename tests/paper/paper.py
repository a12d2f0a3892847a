"""The paper's toolbox in its printed form, written from the paper alone: nothing of Sarrus is used here.

Everything works on exact numbers. `derivative` is exact for polynomials of degree at most four, and says so if the
degree is higher.
"""

from fractions import Fraction

import mpmath
import numpy as np

mpmath.mp.dps = 70  # digits, for what has a root or an angle in it
I3, I4 = np.eye(3, dtype=int), np.eye(4, dtype=int)


def vec(*numbers):
    """A vector of exact numbers (object array)."""
    return np.array(numbers, dtype=object)


def tilde(e):  # Eq. (8)
    return np.array([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]], dtype=object)


def A(p):  # Eq. (9)
    e0, e = p[0], p[1:]
    return (2 * e0**2 - 1) * I3 + 2 * (np.outer(e, e) + e0 * tilde(e))


def B_hat(p, a):  # Eq. (14)
    e0, e = p[0], p[1:]
    turn = e0 * I3 + tilde(e)
    return np.column_stack([turn @ a, np.outer(e, a) - turn @ tilde(a)])


def B(p, a):  # Eq. (15)
    return 2 * (np.outer(a, p) + B_hat(p, a))


def D(a, y):  # Eq. (25), first form
    corner = np.array([[2 * (a @ y)]], dtype=object)
    return 2 * np.block([[corner, (a @ tilde(y))[None, :]], [(tilde(a) @ y)[:, None], _lower_right(a, y)]])


def _lower_right(a, y):
    return (a @ y) * I3 + np.outer(a, y) + tilde(a) @ tilde(y)


def G(p):  # Eq. (51), second factor
    return np.column_stack([-p[1:], -tilde(p[1:]) + p[0] * I3])


def bar(x):  # Eq. (55)
    corner = np.zeros((1, 1), dtype=object)
    return np.block([[corner, -x[None, :]], [x[:, None], -tilde(x)]])


def rational(seed, *shape):
    """Random fractions, none of them zero."""
    whole = np.random.default_rng(seed).integers(-12, 12, shape) * 2 + 1
    return np.vectorize(lambda n: Fraction(int(n), 5), otypes=[object])(whole)


def unit(seed):
    """Random Euler parameters of length exactly one: the square of a quaternion over the square of its length."""
    y = rational(seed, 4)
    square = np.concatenate([[y[0] ** 2 - y[1:] @ y[1:]], 2 * y[0] * y[1:]])
    p = square / (y @ y)
    assert p @ p == 1
    return p


def tangent(seed, p):
    """A random direction with pᵀδp = 0, for unit p."""
    y = rational(seed, len(p))
    return y - (y @ p) * p


def along(f, x, direction):
    """Derivative of f at x along a direction; exact for degree at most four in the step, which is checked."""
    at = {k: f(x + k * direction) for k in (-3, -2, -1, 0, 1, 2)}
    fifth = at[2] - 5 * at[1] + 10 * at[0] - 10 * at[-1] + 5 * at[-2] - at[-3]
    assert np.all(fifth == 0), "the degree is above four: five points do not give the derivative"
    return (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / Fraction(12)


def derivative(f, x):
    """Jacobian of f at x, column by column; exact for degree at most four."""
    columns = [along(f, x, np.array([Fraction(int(k == n)) for k in range(len(x))])) for n in range(len(x))]
    return np.stack(columns, axis=-1)


def equal(*values):
    """Whether all arrays are the same, exactly."""
    first = np.asarray(values[0], dtype=object)
    return all(first.shape == np.shape(other) and np.all(first == other) for other in values[1:])
