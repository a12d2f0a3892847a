"""Added masses and moments of inertia of an ellipsoid in an ideal fluid. H. Lamb, Hydrodynamics, 6th ed., §§ 114, 115.

With semi-axes a, b, c, the volume V and α = abc ∫₀^∞ dl / ((a² + l)^(3/2) (b² + l)^(1/2) (c² + l)^(1/2)),

    m₁ = ρ V α / (2 - α),    I₁ = ρ V / 5 (b² - c²)² (γ - β) / (2 (b² - c²) + (b² + c²) (β - γ)),

and likewise for the other axes, with β and γ for b and c in the place of a.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from ...quantity import Vec3

ROUNDS = 30  # of which each makes the rest of the integral four times smaller


def added_masses(semiaxes: Vec3, density: float) -> tuple[Vec3, Vec3]:
    """Return masses [kg] along the axes and moments of inertia [kg m²] about them."""
    a, b, c = semiaxes
    mass = density * 4 / 3 * pi * a * b * c
    alpha, beta, gamma = _factor(a, b, c), _factor(b, c, a), _factor(c, a, b)
    masses = tuple(mass * one / (2 - one) for one in (alpha, beta, gamma))
    pairs = (b, c, beta, gamma), (c, a, gamma, alpha), (a, b, alpha, beta)
    return masses, tuple(mass / 5 * _square_of_radius(*pair) for pair in pairs)


def _factor(a: Any, b: Any, c: Any) -> Any:
    """α, which is 2/3 abc R_D(b², c², a²); R_D by duplication, B. C. Carlson, Numer. Algorithms 10 (1995) 13-26."""
    x, y, z, total = b * b, c * c, a * a, 0.0
    for n in range(ROUNDS):
        roots = np.sqrt(x), np.sqrt(y), np.sqrt(z)
        step = roots[0] * roots[1] + roots[1] * roots[2] + roots[2] * roots[0]
        total = total + 3 * 0.25**n / (roots[2] * (z + step))
        x, y, z = (x + step) / 4, (y + step) / 4, (z + step) / 4
    return 2 / 3 * a * b * c * (total + 0.25**ROUNDS * ((x + y + 3 * z) / 5) ** -1.5)


def _square_of_radius(b: Any, c: Any, beta: Any, gamma: Any) -> Any:
    """5 I₁ / (ρ V); it and its gradient vanish where b = c."""
    difference = b * b - c * c
    if difference == 0:
        return 0.0
    return difference**2 * (gamma - beta) / (2 * difference + (b * b + c * c) * (beta - gamma))
