"""Rough guesses: every body moved and turned by given amounts in random directions."""

import numpy as np

import sarrus as sr


def rough(
    system: sr.System, random: np.random.Generator, metres: float = 0.5, degrees: float = 40.0
) -> np.ndarray:
    """The model's coordinates (nq,), each body moved by `metres` and turned by `degrees`."""
    q = system.q0.reshape(-1, 7).copy()
    for body in q:
        body[:3] += metres * unit(random)
        half = np.radians(degrees) / 2
        body[3:] = product(np.array([np.cos(half), *(np.sin(half) * unit(random))]), body[3:])
    return q.reshape(-1)


def unit(random: np.random.Generator) -> np.ndarray:
    direction = random.normal(size=3)
    return direction / np.linalg.norm(direction)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Hamilton's product, scalar first."""
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])
