"""What tyre laws share: slips, forces and moments of the contact, and a linear vertical spring and damper.

A law is made of numbers by name, of any kind, and works for recorded ones: an element and a plot use the same formulas.
Axes of the contact (TYDEX-W, ISO): x forwards, y to the left, z upwards, all from the road. F_y < 0 for α > 0.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

from ...._jit.formulas.functions import atan
from ..laws import soft_ramp, soft_step


class Slip(NamedTuple):
    """The state of a contact."""

    kappa: Any  # [-] longitudinal slip, -V_sx/|V_x|
    tan_alpha: Any  # [-] tangent of the slip angle, V_sy/|V_x|
    gamma: Any  # [rad] inclination, positive where the top is to the right
    load: Any  # [N] F_z
    speed: Any = 10.0  # [m/s] V_x
    direction: Any = 1  # [-] sign of V_x, rounded at standstill
    turn: Any = 0  # [1/m] turn slip ψ̇/|V|, positive to the left
    roll: Any = 0  # [1/m] Ω/|V|, of which the turn slip by the inclination is made

    @property
    def alpha(self) -> Any:
        """The slip angle [rad]."""
        return atan(self.tan_alpha)


class Wrench(NamedTuple):
    """Forces [N] and moments [N m] of the road on the tyre, at the contact."""

    F_x: Any
    F_y: Any
    M_x: Any = 0
    M_y: Any = 0
    M_z: Any = 0


class TyreLaw(ABC):
    """Base of the laws: coefficients are attributes, and those that are not given have neutral values."""

    neutral: ClassVar[Mapping[str, float]] = {}
    turns: ClassVar[bool] = False  # whether the law has turn slip

    def __init__(self, coefficients: Mapping[str, Any]) -> None:
        self.given = dict(coefficients)

    def __getattr__(self, name: str) -> Any:
        """A coefficient by its name in the books."""
        given = self.__dict__.get("given", {})
        if name in given:
            return given[name]
        if name in type(self).neutral:
            return type(self).neutral[name]
        raise AttributeError(f"{type(self).__name__} has no coefficient {name}.")

    @property
    def unloaded_radius(self) -> Any:
        """R_0 [m]."""
        return self.radius

    def depth(self, loaded: Any, spin: Any, gamma: Any) -> Any:
        """ρ, the compression: the free radius less the loaded one [m]."""
        return self.unloaded_radius - loaded

    def vertical_force(self, depth: Any, rate: Any, spin: Any, width: Any) -> Any:
        """F_z = σ(ρ) (k ρ + c ρ̇)₊, rounded over the width as for `RoadTyre` [N]."""
        return soft_step(depth, width) * soft_ramp(self.k * depth + self.c * rate, self.k * width)

    def stored_energy(self, depth: Any, width: Any) -> Any:
        """½ k ρ₊², the integral of F_z over ρ for ρ̇ = 0 [J]."""
        pressed = soft_ramp(depth, width)
        return self.k * pressed * pressed / 2

    def rolling_radius(self, loaded: Any, load: Any, spin: Any) -> Any:
        """R_e = (2 R_0 + R_l)/3 [m], [R12 3.69]."""
        return (2 * self.unloaded_radius + loaded) / 3

    def in_range(self, slip: Slip) -> Slip:
        """The state that the formulas are evaluated at: limited to the range in which they hold."""
        return slip

    def relaxation_lengths(self, slip: Slip) -> tuple[Any, Any]:
        """σ_x and σ_y [m]."""
        return self.sigma_x, self.sigma_y

    def rolling_moment(self, slip: Slip) -> Any:
        """M_y = -f F_z R d, with the coefficient f of rolling resistance and the direction d of V_x [N m]."""
        return -self.rolling_resistance * slip.load * self.unloaded_radius * slip.direction

    @abstractmethod
    def sliding_slips(self, load: Any) -> tuple[Any, Any]:
        """Slips in x and y [-] at which a load [N] slides with its full friction: bounds of the slips at standstill."""

    @abstractmethod
    def wrench(self, slip: Slip) -> Wrench:
        """Forces and moments of the contact."""
