"""Functions of two variables that are stored among a system's numbers: bicubic in each cell of a grid.

Stored are the numbers n and m of the rising knots in x and in y, these knots, and then z, z_x, z_y and z_xy of each
node, nodes of equal x one after another. Within a cell, the function is the Hermite interpolant of its four nodes;
beyond the grid, in each variable, it is continued by its tangent. It runs compiled and in plain Python, on any numbers.
"""

from __future__ import annotations

from typing import Any

from .curves import interval
from .functions import real

HIGHEST = 3  # order of a derivative, in both variables together, that kernels may call
NODE = 4  # numbers of a node


def surface_name(i: int, j: int) -> str:
    """The operation ∂ⁱ⁺ʲz/∂xⁱ∂yʲ."""
    return f"surface_{i}{j}"


ORDERS = {surface_name(i, n - i): (i, n - i) for n in range(HIGHEST + 2) for i in range(n + 1)}


def hermite(u: Any, width: Any, order: Any) -> Any:
    """Factors of value and slope at the left and at the right end of an interval, for a derivative at u from the left.

    They are those of the cubic with these values and slopes; zero from the fourth derivative on.
    """
    s = u / width
    if order == 0:
        rise = s * s * (3.0 - 2.0 * s)
        return 1.0 - rise, u * (1.0 - s) * (1.0 - s), rise, u * s * (s - 1.0)
    if order == 1:
        rate = 6.0 * s * (1.0 - s) / width
        return -rate, 1.0 + s * (3.0 * s - 4.0), rate, s * (3.0 * s - 2.0)
    if order == 2:
        bend = (6.0 - 12.0 * s) / (width * width)
        return -bend, (6.0 * s - 4.0) / width, bend, (6.0 * s - 2.0) / width
    zero = 0.0 * s
    if order == 3:
        twist, end = (12.0 + zero) / (width * width * width), (6.0 + zero) / (width * width)
        return twist, end, -twist, end
    return zero, zero, zero, zero


def _factors(numbers: Any, first: Any, k: Any, count: Any, x: Any, order: Any) -> Any:
    """Factors of the values and slopes at the knots k and k + 1, see `hermite`; those of a tangent beyond the ends."""
    left, right = numbers[first + k], numbers[first + k + 1]
    zero = 0.0 * x
    if real(x) < real(left) or real(x) > real(right):
        before = real(x) < real(left)
        distance = x - left if before else x - right
        value = 1.0 + zero if order == 0 else zero
        slope = distance if order == 0 else (1.0 + zero if order == 1 else zero)
        return (value, slope, zero, zero) if before else (zero, zero, value, slope)
    return hermite(x - left, right - left, order)


def surface_value(numbers: Any, at: Any, x: Any, y: Any, i: Any, j: Any) -> Any:
    """∂ⁱ⁺ʲz/∂xⁱ∂yʲ at (x, y) of the surface stored at ``numbers[at:]``."""
    n, m = int(real(numbers[at])), int(real(numbers[at + 1]))
    in_x, in_y = at + 2, at + 2 + n
    k, h = interval(numbers, in_x, n, x), interval(numbers, in_y, m, y)
    a0, a1, a2, a3 = _factors(numbers, in_x, k, n, x, i)
    b0, b1, b2, b3 = _factors(numbers, in_y, h, m, y, j)
    c = in_y + m + NODE * (k * m + h)
    d = c + NODE * m
    left = b0 * (a0 * numbers[c] + a1 * numbers[c + 1]) + b1 * (a0 * numbers[c + 2] + a1 * numbers[c + 3])
    left = (
        left
        + b2 * (a0 * numbers[c + 4] + a1 * numbers[c + 5])
        + b3 * (a0 * numbers[c + 6] + a1 * numbers[c + 7])
    )
    right = b0 * (a2 * numbers[d] + a3 * numbers[d + 1]) + b1 * (a2 * numbers[d + 2] + a3 * numbers[d + 3])
    right = (
        right
        + b2 * (a2 * numbers[d + 4] + a3 * numbers[d + 5])
        + b3 * (a2 * numbers[d + 6] + a3 * numbers[d + 7])
    )
    return left + right
