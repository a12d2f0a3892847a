"""The force of a unilateral contact, after Hunt and Crossley, without corners and without pull.

With the depth δ (negative: apart), its rate δ̇, stiffness k, exponent n, damping d [s/m] and the width w of the
rounding:

    N = k δ₊ⁿ (1 + d δ̇)₊

The subscript is `soft_ramp`: δ₊ of width w, so that N = k δⁿ exactly from δ = w/2 on, and exactly zero up to -w/2; the
factor of width `LEAVING`, so that it is exact for d δ̇ ≥ -(1 - LEAVING/2), and a body that leaves fast is never pulled
back. The damping of Hunt and Crossley vanishes with the depth, and makes the loss of an impact a function of d times
the speed u alone: it comes back with u' of d u - ln(1 + d u) = -d u' - ln(1 - d u'). The law's rounding does not change
that up to d u = 2.4, where 36 % of the speed is left; it adds 0.02 % to u' at d u = 3, 1.1 % at 5 and 4.9 % at 10.
"""

from __future__ import annotations

from typing import Any

from .smooth import power, soft_ramp

LEAVING = 1 / 4  # [-] width of the rounding where a body leaves so fast that the law would pull it back


def contact_force(depth: Any, rate: Any, k: Any, exponent: Any, damping: Any, width: Any) -> Any:
    """N, see above; never negative."""
    return k * power(soft_ramp(depth, width), exponent) * soft_ramp(1 + damping * rate, LEAVING)
