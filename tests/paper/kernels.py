"""Sarrus' side of the comparisons with the paper, and small things that the sections share."""

from fractions import Fraction

import mpmath
import numpy as np

from sarrus.elements import OPERATORS
from sarrus.elements.evaluation import dense


def kernel(element, name, q, **operands):
    """A kernel's result as a vector or a dense matrix; of one row, as that row."""
    value = dense(element, OPERATORS[name], {"q": q, **operands})
    return value[0] if value.ndim == 2 and len(value) == 1 else value


def split(q):
    """r_i, p_i, r_j, p_j."""
    return q[:3], q[3:7], q[7:10], q[10:]


def zeros(*shape):
    return np.full(shape, 0, dtype=object)


def row(*blocks):
    """A row of blocks of matrices or of row vectors."""
    return np.concatenate(blocks, axis=-1)


# ------------------------------------------------------------------------------------------------- 70 digits

NEAR = (
    mpmath.mpf(10) ** -36
)  # two differences in a row with a step of 1e-12 leave 46 of 70 digits, products a few less
STEP = mpmath.mpf(10) ** -12


def digits(exact):
    """Fractions as numbers of 70 digits."""
    return np.array(
        [mpmath.mpf(Fraction(x).numerator) / Fraction(x).denominator for x in exact], dtype=object
    )


def slope(f, x, direction):
    """Derivative of f at x along a direction, by five points in 70 digits."""
    at = {k: f(x + k * STEP * direction) for k in (-2, -1, 1, 2)}
    return (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * STEP)


def slopes(f, x):
    """The same along every coordinate: the Jacobian."""
    unit = [digits([int(k == n) for k in range(len(x))]) for n in range(len(x))]
    return np.stack([np.asarray(slope(f, x, e), dtype=object) for e in unit], axis=-1)


def near(*values):
    """Whether all arrays agree to 36 digits."""
    first = np.asarray(values[0], dtype=object)
    return all(
        first.shape == np.shape(other)
        and np.max(abs(first - other), initial=0) <= NEAR * (1 + np.max(abs(first), initial=0))
        for other in values[1:]
    )
