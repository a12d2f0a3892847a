"""Laws of contact and dry friction, with corners rounded by a polynomial.

A rounded law is twice continuously differentiable, and exact outside a band of the given width.

Contact, after Hunt and Crossley, with the depth δ (negative: apart), its rate δ̇, stiffness k, exponent n, damping d
[s/m] and the width w of the rounding:

    N = k δ₊ⁿ (1 + d δ̇)₊

The subscript is `soft_ramp`: δ₊ of width w, so that N = k δⁿ exactly from δ = w/2 on, and exactly zero up to -w/2; the
factor of width `LEAVING`, so that it is exact for d δ̇ ≥ -(1 - LEAVING/2), and a body that leaves fast is never pulled
back. The damping of Hunt and Crossley vanishes with the depth, and makes the loss of an impact a function of d times
the speed u alone: it comes back with u' of d u - ln(1 + d u) = -d u' - ln(1 - d u'). The law's rounding does not change
that up to d u = 2.4, where 36 % of the speed is left; it adds 0.02 % to u' at d u = 3, 1.1 % at 5 and 4.9 % at 10.

Dry friction over the sliding speed, after Stribeck, regularized: creep far below a given speed, no sticking.

    F = N [μ + (μ_s - μ) exp(-(u/u_s)²)] tanh(u/u_0) + c u

N is the normal load, μ the coefficient of sliding and μ_s that of sticking friction, u_s the speed over which one
falls to the other (Stribeck), u_0 the speed of regularization, c a viscous coefficient. |u| ≪ u_0
represents sticking.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._jit.formulas.functions import exp, log, minimum, ramp, tanh

TINY = 1e-100  # keeps the logarithm of zero and its slopes finite; below round-off of all that is not zero
_points, _shares = np.polynomial.legendre.leggauss(16)
NODES = tuple(float(y) for y in (_points + 1) / 2)  # of Gauss' rule from 0 to 1
WEIGHTS = tuple(float(w) for w in _shares / 2)


def soft_step(x: Any, width: Any) -> Any:
    """0 for x ≤ -width/2, 1 for x ≥ width/2, between them u² (3 - 2u): the slope of `soft_ramp`."""
    u, _ = along(x, width)
    return u * u * (3 - 2 * u)


def soft_ramp(x: Any, width: Any) -> Any:
    """0 for x ≤ -width/2, x for x ≥ width/2, between them width (u³ - u⁴/2) with u = x/width + 1/2."""
    u, beyond = along(x, width)
    return width * (u * u * u * (2 - u) / 2) + beyond


def power(x: Any, exponent: Any) -> Any:
    """x to an exponent of at least 1, for x ≥ 0; zero at zero, with all its derivatives along a `soft_ramp`."""
    return x * exp((exponent - 1) * log(x + TINY))


def along(x: Any, width: Any) -> tuple[Any, Any]:
    """The way through the band, from 0 to 1, and the way beyond it."""
    return minimum(ramp(x / width + 1 / 2), 1), ramp(x - width / 2)


LEAVING = 1 / 4  # [-] width of the rounding where a body leaves so fast that the law would pull it back


def contact_force(depth: Any, rate: Any, k: Any, exponent: Any, damping: Any, width: Any) -> Any:
    """N, see above; never negative."""
    return k * power(soft_ramp(depth, width), exponent) * soft_ramp(1 + damping * rate, LEAVING)


def contact_energy(depth: Any, k: Any, exponent: Any, width: Any) -> Any:
    """The energy stored at a depth: the integral of k δ₊ⁿ.

    Beyond the rounding k (δⁿ⁺¹ - (w/2)ⁿ⁺¹) / (n + 1) and that at w/2; within, the integral of (s³ - s⁴/2)ⁿ from 0 to
    u = δ/w + 1/2 by Gauss' rule over y, s = u y², to round-off for n ≥ 1.
    """
    u, beyond = along(depth, width)
    within = sum(
        w * y * power(width * (u * u * u) * y**6 * (1 - u * (y * y / 2)), exponent)
        for y, w in zip(NODES, WEIGHTS, strict=True)
    )
    full = [d * power(d, exponent) / (exponent + 1) for d in (beyond + width / 2, width / 2)]
    return k * (2 * width * u * within + full[0] - full[1])


def friction_force(
    u: Any, load: Any, mu: Any, mu_static: Any, stribeck: Any, creep: Any, viscous: Any
) -> Any:
    """F, see above; it acts against u."""
    ratio = u / stribeck
    return load * (mu + (mu_static - mu) * exp(-ratio * ratio)) * tanh(u / creep) + viscous * u
