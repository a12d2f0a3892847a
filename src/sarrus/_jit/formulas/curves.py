"""Functions of one variable that are stored among a system's numbers: pieces of cubics, or a formula.

Cubics: the count n of pieces, n + 1 knots, then 4 coefficients a piece, highest power of (x - knot) first; n + 1/2 in
place of n means that they repeat with the period from the first knot to the last. A formula:
-n, then n steps (operation, first, second), each computing one number from earlier ones; its first three
derivatives are carried along, so a formula's slope is exact. Both run compiled and in plain Python, on any numbers.
"""

from __future__ import annotations

from typing import Any

from .functions import acos, asin, atan, cos, exp, log, nearest, real, sin, sqrt, tan, tanh

STEPS = 200  # most steps of a formula
OPERATIONS = ("constant", "input", "add", "sub", "mul", "div", "neg", "sqrt", "sin", "cos", "tan", "asin", "acos",
              "atan", "exp", "log", "tanh", "positive", "nearest")  # fmt: skip
CODES = {name: code for code, name in enumerate(OPERATIONS)}
(CONSTANT, INPUT, ADD, SUB, MUL, DIV, NEG, SQRT, SIN, COS, TAN, ASIN, ACOS, ATAN, EXP, LOG, TANH,
 POSITIVE, NEAREST) = range(len(OPERATIONS))  # fmt: skip


def _work() -> Any:
    """Memory for a formula's values in plain Python."""
    return [0.0] * (4 * STEPS)


def interval(numbers: Any, first: Any, count: Any, x: Any) -> Any:
    """Index of the interval between `count` knots in which x is, the first or the last one beyond them."""
    low, high = 0, count - 2
    while low < high:
        middle = (low + high) // 2
        if real(x) >= real(numbers[first + 1 + middle]):
            low = middle + 1
        else:
            high = middle
    return low


def _cubic(numbers: Any, at: Any, x: Any, order: Any) -> Any:
    """A cubic piece's value (order 0) or derivative (1, 2, 3) at x."""
    count = int(real(numbers[at]))
    if real(numbers[at]) > count:
        period = numbers[at + 1 + count] - numbers[at + 1]
        x = x - period * nearest((x - numbers[at + 1]) / period - 0.5)
    k = interval(numbers, at + 1, count + 1, x)
    c = at + 2 + count + 4 * k
    u = x - numbers[at + 1 + k]
    if order == 0:
        return ((numbers[c] * u + numbers[c + 1]) * u + numbers[c + 2]) * u + numbers[c + 3]
    if order == 1:
        return (3.0 * numbers[c] * u + 2.0 * numbers[c + 1]) * u + numbers[c + 2]
    if order == 2:
        return 6.0 * numbers[c] * u + 2.0 * numbers[c + 1]
    return 6.0 * numbers[c] + 0.0 * u


def _chain(f: Any, f1: Any, f2: Any, f3: Any, u1: Any, u2: Any, u3: Any) -> Any:
    """f(u) and its first three derivatives, of those of f and of u."""
    return f, f1 * u1, f1 * u2 + f2 * u1 * u1, f1 * u3 + 3.0 * f2 * u1 * u2 + f3 * u1 * u1 * u1


def _elementary_step(code: Any, u: Any, u1: Any, u2: Any, u3: Any) -> Any:
    """One step of a formula with one argument."""
    if code == SQRT:
        root = sqrt(u)
        return _chain(root, 0.5 / root, -0.25 / (root * u), 0.375 / (root * u * u), u1, u2, u3)
    if code == SIN:
        return _chain(sin(u), cos(u), -sin(u), -cos(u), u1, u2, u3)
    if code == COS:
        return _chain(cos(u), -sin(u), -cos(u), sin(u), u1, u2, u3)
    if code == TAN:
        value = tan(u)
        slope = 1.0 + value * value
        return _chain(value, slope, 2.0 * value * slope, (6.0 * slope - 4.0) * slope, u1, u2, u3)
    if code in (ASIN, ACOS):
        w = 1.0 - u * u
        value = asin(u) if code == ASIN else acos(u)
        slope = (1.0 if code == ASIN else -1.0) / sqrt(w)
        return _chain(value, slope, u * slope / w, (1.0 + 2.0 * u * u) * slope / (w * w), u1, u2, u3)
    if code == ATAN:
        slope = 1.0 / (1.0 + u * u)
        third = (6.0 * u * u - 2.0) * slope * slope * slope
        return _chain(atan(u), slope, -2.0 * u * slope * slope, third, u1, u2, u3)
    if code == EXP:
        return _chain(exp(u), exp(u), exp(u), exp(u), u1, u2, u3)
    if code == LOG:
        return _chain(log(u), 1.0 / u, -1.0 / (u * u), 2.0 / (u * u * u), u1, u2, u3)
    if code == TANH:
        value = tanh(u)
        e = exp(-2.0 * u if real(u) > 0.0 else 2.0 * u)
        slope = 4.0 * e / ((1.0 + e) * (1.0 + e))  # 1 - value², without its cancellation
        third = (6.0 * value * value - 2.0) * slope
        return _chain(value, slope, -2.0 * value * slope, third, u1, u2, u3)
    if code == POSITIVE:
        step = 1.0 if real(u) > 0.0 else 0.0
        return step + 0.0 * u, 0.0 * u, 0.0 * u, 0.0 * u
    if code == NEAREST:
        return nearest(u) + 0.0 * u, 0.0 * u, 0.0 * u, 0.0 * u
    return -u, -u1, -u2, -u3


def _binary_step(code: Any, u: Any, u1: Any, u2: Any, u3: Any, w: Any, w1: Any, w2: Any, w3: Any) -> Any:
    """One step of a formula with two arguments."""
    if code == ADD:
        return u + w, u1 + w1, u2 + w2, u3 + w3
    if code == SUB:
        return u - w, u1 - w1, u2 - w2, u3 - w3
    if code == MUL:
        third = u3 * w + 3.0 * (u2 * w1 + u1 * w2) + u * w3
        return u * w, u1 * w + u * w1, u2 * w + 2.0 * u1 * w1 + u * w2, third
    ratio = u / w
    slope = (u1 - ratio * w1) / w
    bend = (u2 - 2.0 * slope * w1 - ratio * w2) / w
    return ratio, slope, bend, (u3 - 3.0 * (bend * w1 + slope * w2) - ratio * w3) / w


def _formula(numbers: Any, at: Any, x: Any, order: Any) -> Any:
    """A formula's value (order 0) or derivative (1, 2, 3) at x."""
    count, work = -int(real(numbers[at])), _work()
    for k in range(count):
        step = at + 1 + 3 * k
        code, first = int(real(numbers[step])), numbers[step + 1]
        if code == CONSTANT:
            value, slope, bend, third = first + 0.0 * x, 0.0 * x, 0.0 * x, 0.0 * x
        elif code == INPUT:
            value, slope, bend, third = x, 1.0 + 0.0 * x, 0.0 * x, 0.0 * x
        else:
            i, j = 4 * int(real(first)), 4 * int(real(numbers[step + 2]))
            u, u1, u2, u3 = work[i], work[i + 1], work[i + 2], work[i + 3]
            if code >= NEG:
                value, slope, bend, third = _elementary_step(code, u, u1, u2, u3)
            else:
                w, w1, w2, w3 = work[j], work[j + 1], work[j + 2], work[j + 3]
                value, slope, bend, third = _binary_step(code, u, u1, u2, u3, w, w1, w2, w3)
        work[4 * k], work[4 * k + 1], work[4 * k + 2], work[4 * k + 3] = value, slope, bend, third
    return work[4 * (count - 1) + order]


def _evaluate(numbers: Any, at: Any, x: Any, order: Any) -> Any:
    if real(numbers[at]) > 0.0:
        return _cubic(numbers, at, x, order)
    return _formula(numbers, at, x, order)


def curve_value(numbers: Any, at: Any, x: Any) -> Any:
    """Value at x of the curve stored at ``numbers[at:]``."""
    return _evaluate(numbers, at, x, 0)


def curve_slope(numbers: Any, at: Any, x: Any) -> Any:
    """Its first derivative."""
    return _evaluate(numbers, at, x, 1)


def curve_bend(numbers: Any, at: Any, x: Any) -> Any:
    """Its second derivative."""
    return _evaluate(numbers, at, x, 2)


def curve_twist(numbers: Any, at: Any, x: Any) -> Any:
    """Its third derivative."""
    return _evaluate(numbers, at, x, 3)
