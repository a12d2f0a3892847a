"""The force of a unilateral contact, after Hunt and Crossley, without corners and without pull.

With the depth δ (negative: apart), its rate δ̇, stiffness k, exponent n, damping d [s/m] and the width w of the
rounding:

    N = k δ₊ⁿ (1 + d δ̇)₊

The subscript is `soft_ramp`: δ₊ of width w, so that N = k δⁿ exactly from δ = w/2 on, and exactly zero up to -w/2; the
factor of width 1, so that it is exact for d δ̇ ≥ -1/2, and a body that leaves fast is never pulled back. The damping
of Hunt and Crossley vanishes with the depth, and makes the loss of an impact a function of d times the speed alone.
"""

from __future__ import annotations

from typing import Any

from .smooth import power, soft_ramp


def contact_force(depth: Any, rate: Any, k: Any, exponent: Any, damping: Any, width: Any) -> Any:
    """N, see above; never negative."""
    return k * power(soft_ramp(depth, width), exponent) * soft_ramp(1 + damping * rate, 1)
