"""TMeasy: a curve of the force over the slip in each direction, given by five numbers at the nominal load and twice it.

G. Rill, Road Vehicle Dynamics, 2012, chapter 3; W. Hirschberg, G. Rill, H. Weinfurter, Vehicle System Dynamics 45
(2007), sup1. With the direction d of V_x (1, -1 in reverse), slips are s_x = κ/(1 + κ d) and
s_y = -tan α/(1 + κ d), s = √(s_x² + s_y²), q = F_z/F_zN:

    dF_0, F_M, F_S = q [2 w_1 - w_2/2 - (w_1 - w_2/2) q],    s_M, s_S = w_1 + (w_2 - w_1)(q - 1)
    each of the direction φ of the slip: √((w_x cos φ)² + (w_y sin φ)²)
    0 ≤ s < s_M:    F = dF_0 s/(1 + x (x + dF_0 s_M/F_M - 2)),  x = s/s_M
    s_M ≤ s < s*:   F = F_M - a (s - s_M)²,     a = (F_M/s_M)²/(dF_0 s_M),  s* = s_M + (F_M - F_S)/(a (s_S - s_M))
    s* ≤ s < s_S:   F = F_S + b (s_S - s)²,     b = a (s* - s_M)/(s_S - s*)
    if s* > s_S:    F = F_M - (F_M - F_S) x² (3 - 2 x),  x = (s - s_M)/(s_S - s_M)
    s ≥ s_S:        F = F_S

Second derivatives jump at s_M, s* and s_S, the first ones are continuous. Without slip φ has no value: within slips of
1e-6, each force has the slope dF_0 of its own direction. The inclination acts as a third of the lateral slip that the
contact has by it, with the secant of the lateral curve at s.
"""

from __future__ import annotations

from typing import Any

from ...._jit.formulas.functions import maximum, minimum, positive, ramp, sqrt
from .law import Slip, TyreLaw, Wrench
from .rounding import LOCKED, SMALLEST, at_least, limited, rounded_absolute

HIGHEST = 4.0  # [-] load over the nominal one up to which the parabolas over the load are used
LAST = 4.25  # [-] the greatest one after the transition of `limited`
PARABOLAS = ("slope", "peak_force", "sliding_force")


class TMeasy(TyreLaw):
    """TMeasy of radius, k, c, mu, nominal_load, and pairs at the nominal load and twice it, _1 and _2.

    Pairs are ``slope``, ``peak_slip``, ``peak_force``, ``sliding_slip`` and ``sliding_force`` of ``x`` and ``y``, and
    of the pneumatic trail over the length of the contact ``trail``, ``zero_slip`` and ``end_slip``.
    """

    def sliding_slips(self, load: Any) -> tuple[Any, Any]:
        """The slips s < s_M with the force F_S of full sliding: from s_S, a wheel that stops would spring back."""
        q = load / self.nominal_load
        return self._sliding_slip("x", q), self._sliding_slip("y", q)

    def _sliding_slip(self, axis: str, q: Any) -> Any:
        """The smaller root r = s/s_M of r² - b r + 1 = 0, b = D (F_M/F_S - 1) + 2, D = dF_0 s_M/F_M, times s_M."""
        s_M, F_M = (self.mu * self.number(f"{name}_{axis}", q) for name in ("peak_slip", "peak_force"))
        D = maximum(self.number(f"slope_{axis}", q) * s_M / F_M, 2)
        b = D * (F_M / (self.mu * self.number(f"sliding_force_{axis}", q)) - 1) + 2
        return 2 * s_M / (b + sqrt(b * b - 4 + SMALLEST))

    def in_range(self, slip: Slip) -> Slip:
        return slip._replace(load=limited(slip.load, -self.nominal_load, HIGHEST * self.nominal_load))

    def wrench(self, slip: Slip) -> Wrench:
        q = slip.load / self.nominal_load
        ratio = at_least(1 + slip.kappa * slip.direction, LOCKED)
        s_x, s_y = slip.kappa / ratio, -slip.tan_alpha / ratio
        along, across = q * self._secant(s_x, s_y, q, (1, 0)), q * self._secant(s_x, s_y, q, (0, 1))
        length = 2 * sqrt(self.radius * slip.load / self.k + SMALLEST * SMALLEST)
        s_c = -length / 2 * slip.gamma / self.radius * slip.direction
        size = sqrt(s_x * s_x + s_y * s_y + SMALLEST * SMALLEST)
        leaning = q * self._secant(0, size, q, (0, 1)) / 3  # of the inclination, in the lateral direction
        F_y = across * s_y
        trail = length * self.trail(s_y, q) * slip.direction
        return Wrench(along * s_x, F_y + leaning * s_c, M_y=self.rolling_moment(slip), M_z=-F_y * trail)

    def number(self, name: str, q: Any) -> Any:
        """A number of a curve, such as `peak_slip_x`, at q; slopes and forces are divided by q. It is linear in q."""
        return (self._parabola if name.startswith(PARABOLAS) else self._linear)(name, q)

    def trail(self, s_y: Any, q: Any) -> Any:
        """The pneumatic trail over the length of the contact, n/L [-]."""
        n_0, s_0 = self._linear("trail", q), self._linear("zero_slip", q)
        end = maximum(self._linear("end_slip", q), s_0 * (1 + SMALLEST))
        s, w = rounded_absolute(s_y, SMALLEST), s_0 / end
        x = minimum(s / s_0, 1)
        near = (1 - w) * (1 - x) + w * (1 - (3 - 2 * x) * x * x)
        left = ramp(end - s) / (end - s_0)
        far = (1 - w) * ramp(s - s_0) / s_0 * left * left
        return n_0 * (near - far)

    def _secant(self, s_x: Any, s_y: Any, q: Any, at_zero: tuple[int, int]) -> Any:
        """F/(s q) [N]; without slip, in the direction `at_zero`."""
        tiny = SMALLEST * SMALLEST
        squared = s_x * s_x + s_y * s_y + tiny
        x, y = (s_x * s_x + at_zero[0] * tiny) / squared, (s_y * s_y + at_zero[1] * tiny) / squared

        def of(name: str, law: Any) -> Any:
            a, b = law(f"{name}_x", q), law(f"{name}_y", q)
            return sqrt(a * a * x + b * b * y)

        s_M, s_S = self.mu * of("peak_slip", self._linear), self.mu * of("sliding_slip", self._linear)
        F_M, F_S = self.mu * of("peak_force", self._parabola), self.mu * of("sliding_force", self._parabola)
        s, slope = sqrt(squared), maximum(of("slope", self._parabola), 2 * F_M / s_M)
        r = minimum(s / s_M, 1)
        rising = slope / (1 + r * (r + slope * s_M / F_M - 2))
        beyond = positive(s - s_M)
        return (1 - beyond) * rising + beyond * falling(s, slope, s_M, F_M, s_S, F_S) / maximum(s, s_M)

    def _linear(self, name: str, q: Any) -> Any:
        first, second = getattr(self, f"{name}_1"), getattr(self, f"{name}_2")
        return first + (second - first) * (q - 1)

    def _parabola(self, name: str, q: Any) -> Any:
        """The value over the load, divided by q."""
        first, second = getattr(self, f"{name}_1"), getattr(self, f"{name}_2")
        return 2 * first - second / 2 - (first - second / 2) * q


def falling(s: Any, slope: Any, s_M: Any, F_M: Any, s_S: Any, F_S: Any) -> Any:
    """F from s_M on."""
    a = F_M / s_M * (F_M / s_M) / (slope * s_M)
    middle = s_M + (F_M - F_S) / (a * (s_S - s_M))
    far = positive(s - middle)
    b = a * (middle - s_M) / maximum(s_S - middle, SMALLEST * s_S)
    left = ramp(s_S - s)
    parabolas = (1 - far) * (F_M - a * (s - s_M) * (s - s_M)) + far * (F_S + b * left * left)
    x = minimum(ramp(s - s_M) / (s_S - s_M), 1)
    cubic = F_M - (F_M - F_S) * x * x * (3 - 2 * x)
    late = positive(middle - s_S)
    return (1 - late) * parabolas + late * cubic
