"""HHT and generalized-α: implicit methods of order 2 with numerical damping, on the index-3 equations or stabilized."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

from ....model.checks.arguments import Number, real
from ....results import Assembly
from ....system import System
from ..methods.description import Description
from ..methods.generalized_alpha import generalized_alpha
from ..stepping.stepper import Settings
from ..time_loop.prescribed import Prescribed
from .described import DescribedStepper


class Scheme(NamedTuple):
    """Coefficients of the method, and of its local error in q: error h³ ȧ."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    error: float


class AlphaMethod(Prescribed):
    """Base class of HHT and generalized-α, which differ in their coefficients only."""

    step: float | None
    stabilized: bool

    def __post_init__(self) -> None:
        self.scheme()
        if not isinstance(self.stabilized, bool):
            raise TypeError(
                f"stabilized must be True or False, got {type(self.stabilized).__name__}. Pass a bool."
            )
        if self.step is not None:
            Number(positive=True)("step", self.step)

    def scheme(self) -> Scheme:
        """The coefficients of the method."""
        raise NotImplementedError

    @property
    def description(self) -> Description:
        """The method, with an error that is not seen where all steps have one length."""
        scheme = self.scheme() if self.step is None else self.scheme()._replace(error=0.0)
        return generalized_alpha(*scheme, stabilized=self.stabilized)

    def stepper(self, system: System, start: Assembly, settings: Settings) -> DescribedStepper:
        """The method at work, see `Stepper`."""
        if self.step is not None:
            longest = min(self.step, settings.max_step)
            settings = replace(settings, max_step=longest, first_step=longest)
        return DescribedStepper(system, self.description, start, settings)


@dataclass(frozen=True)
class HHT(AlphaMethod):
    """HHT method of order 2 (Hilber, Hughes, Taylor); ``alpha`` from 0, no numerical damping, to -1/3, the most.

    alpha = 0 has no numerical damping. With variable steps the multipliers may then grow: use a fixed step or
    `stabilized`. With `step` [s], all steps have this length, without error control, except before breakpoints and
    after failures of Newton's method.

    With `stabilized` the velocity constraints are solved with the others, by a second set of multipliers (Gear, Gupta
    and Leimkuhler 1985): Φ = 0 and Φ_q v + Φ_t = 0 hold at every step without projection, at a higher cost of each
    step.
    """

    alpha: float = -0.1
    step: float | None = None
    stabilized: bool = False

    def scheme(self) -> Scheme:
        if not -1 / 3 <= real("alpha", self.alpha) <= 0:
            raise ValueError(
                f"alpha of HHT must lie between -1/3 and 0, but is {self.alpha}. Give one of these."
            )
        return _scheme(0.0, -self.alpha)


@dataclass(frozen=True)
class GeneralizedAlpha(AlphaMethod):
    """Generalized-α method of order 2 (Chung, Hulbert); ``rho_inf`` from 1, no numerical damping, to 0, the most.

    `step` and `stabilized` as for `HHT`.
    """

    rho_inf: float = 0.8
    step: float | None = None
    stabilized: bool = False

    def scheme(self) -> Scheme:
        if not 0 <= real("rho_inf", self.rho_inf) <= 1:
            raise ValueError(f"rho_inf must lie between 0 and 1, but is {self.rho_inf}. Give one of these.")
        rho = self.rho_inf
        return _scheme((2 * rho - 1) / (rho + 1), rho / (rho + 1))


def _scheme(alpha_m: float, alpha_f: float) -> Scheme:
    """Second-order accurate coefficients (Chung and Hulbert 1993), and the error h³ ȧ of a step in q."""
    shift = alpha_m - alpha_f
    gamma, beta = 0.5 - shift, 0.25 * (1 - shift) ** 2
    return Scheme(alpha_m, alpha_f, beta, gamma, abs(0.5 * shift + beta - 1 / 6))
