"""Tyre with TMeasy's law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from ...elements.forces.tyres import TMeasy, TyreLaw
from ...elements.forces.tyres.tmeasy import LAST, PARABOLAS
from ..errors import ModelError
from ..forces.force import Force
from ..measure import In, Ratio
from ..quantity import numbers, positive
from ..tape import value_of
from .rolling_tyre import SimpleTyre

Pair = Sequence[float]
TRAIL = {"trail": (0.178, 0.19), "zero_slip": (0.163, 0.204), "end_slip": (0.965, 1.071)}
ORDERED = (
    *((f"peak_slip_{axis}", f"sliding_slip_{axis}") for axis in "xy"),
    *((f"sliding_force_{axis}", f"peak_force_{axis}") for axis in "xy"),
    ("zero_slip", "end_slip"),
)
CURVES = ("slope", "peak_slip", "peak_force", "sliding_slip", "sliding_force")
PAIRS = (*(f"{curve}_{axis}" for curve in CURVES for axis in "xy"), *TRAIL)


@dataclass(frozen=True, eq=False, kw_only=True)
class TmeasyTyre(SimpleTyre, Force):
    """A rolling tyre with the law TMeasy of Rill: each curve by numbers that are read off a measurement.

    All pairs are values at the nominal load and at twice it, from which those at 0 to 4.25 times it follow.
    Slips are those of TMeasy, κ/(1 + κ) and tan α/(1 + κ).

    Parameters
    ----------
    nominal_load
        [N]
    slope_x, slope_y
        Slopes of the forces over the slip at zero [N].
    peak_slip_x, peak_slip_y
        Slips of the largest forces.
    peak_force_x, peak_force_y
        The largest forces [N].
    sliding_slip_x, sliding_slip_y
        Slips from which on the tyre slides.
    sliding_force_x, sliding_force_y
        The forces there [N].
    trail
        Pneumatic trail over the length of the contact, at zero slip.
    zero_slip, end_slip
        Lateral slips at which the trail changes its sign, and from which on it is zero.
    mu
        Friction relative to that of the measurement.
    """

    nominal_load: Annotated[float, In("N")]
    slope_x: Annotated[Pair, In("N")]
    slope_y: Annotated[Pair, In("N")]
    peak_slip_x: Annotated[Pair, In("1")]
    peak_slip_y: Annotated[Pair, In("1")]
    peak_force_x: Annotated[Pair, In("N")]
    peak_force_y: Annotated[Pair, In("N")]
    sliding_slip_x: Annotated[Pair, In("1")]
    sliding_slip_y: Annotated[Pair, In("1")]
    sliding_force_x: Annotated[Pair, In("N")]
    sliding_force_y: Annotated[Pair, In("N")]
    trail: Annotated[Pair, In("1")] = TRAIL["trail"]
    zero_slip: Annotated[Pair, In("1")] = TRAIL["zero_slip"]
    end_slip: Annotated[Pair, In("1")] = TRAIL["end_slip"]
    mu: Ratio = 1.0

    def tyre_law(self) -> tuple[type[TyreLaw], Mapping[str, Any]]:
        found = self.wheel()
        found["nominal_load"] = positive(self.nominal_load, "nominal_load", "Give it in N.")
        found["mu"] = positive(self.mu, "mu", "Give the relative friction.")
        for name in PAIRS:
            remedy = "Give the values at the nominal load and at twice it."
            for n, value in enumerate(numbers(getattr(self, name), 2, name, remedy), 1):
                found[f"{name}_{n}"] = positive(value, name, "Give such numbers.")
        _check_curves(TMeasy({name: float(value_of(value)) for name, value in found.items()}))
        return TMeasy, found


def _check_curves(law: TMeasy) -> None:
    """Refuse numbers without sense at a load from 0 to the last one; all are linear in it, some over the load."""
    for q in (0.0, 1.0, 2.0, LAST):
        at = f"at {q:g} times the nominal load" + ("" if q else ", slopes and forces over this factor")
        for name in PAIRS:
            if law.number(name, q) <= 0.0:
                message = f"{name} leads to {_shown(law, name, q):.4g} {at}, which must be greater than 0"
                remedy = "Bring the two values closer to each other, or further apart."
                raise ModelError(f"{message}. {remedy}", field=name)
        for low, high in ORDERED:
            least, most = law.number(low, q), law.number(high, q)
            if least > most or (least == most and "force" not in low):
                message = f"{low} must be less than {high}, but they are {_shown(law, low, q):g} and"
                message += f" {_shown(law, high, q):g} {at}"
                raise ModelError(f"{message}. Correct the pairs.", field=low)


def _shown(law: TMeasy, name: str, q: float) -> float:
    """A number at a load, slopes and forces in their units for q > 0."""
    return float(law.number(name, q) * (q if q and name.startswith(PARABOLAS) else 1.0))
