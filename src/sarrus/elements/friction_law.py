"""Dry friction over the sliding speed, after Stribeck, regularized: creep far below a given speed, no sticking.

    F = N [μ + (μ_s - μ) exp(-(u/u_s)²)] tanh(u/u_0) + c u

N is the normal load, μ the coefficient of sliding and μ_s that of sticking friction, u_s the speed over which one
falls to the other (Stribeck), u_0 the speed of regularization, c a viscous coefficient. |u| ≪ u_0
represents sticking.
"""

from __future__ import annotations

from typing import Any

from .._jit.functions import exp, tanh


def friction_force(
    u: Any, load: Any, mu: Any, mu_static: Any, stribeck: Any, creep: Any, viscous: Any
) -> Any:
    """F, see above; it acts against u."""
    ratio = u / stribeck
    return load * (mu + (mu_static - mu) * exp(-ratio * ratio)) * tanh(u / creep) + viscous * u
