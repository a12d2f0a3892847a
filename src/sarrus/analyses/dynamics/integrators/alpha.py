"""HHT and generalized-α: implicit methods of order 2 with numerical damping, on the index-3 equations or stabilized.

Generalized-α (Chung and Hulbert 1993), HHT among it: one stage at the end of a step.

The unknowns are accelerations and multipliers at the end (Arnold and Brüls 2007); ã is the method's own acceleration,

    (1 - α_m) ã₁ + α_m ã₀ = (1 - α_f) a₁ + α_f a₀,
    q₁ = q₀ + h v₀ + h² ((½ - β) ã₀ + β ã₁),    v₁ = v₀ + h ((1 - γ) ã₀ + γ ã₁).

When h changes, ã₀ - a₀, which is proportional to h, is rescaled. Stabilized (Arnold, Brüls and Cardona 2015) q₁ is an
unknown, too, q₁ = (as above) - Φ_q(q₀)ᵀη, and both constraints hold at the end.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import Any, NamedTuple

from ....defaults import RTOL_OF_ORDER_2
from ....model.checks.arguments import Number, real
from ....results import Assembly
from ....system import System
from ..methods.description import (
    CONSTRAINTS,
    COORDINATES,
    Affine,
    Description,
    Equation,
    Estimate,
    Stage,
    Step,
    combined,
)
from ..stepping.stepper import Settings
from ..stepping.tolerance import Given
from .described import DescribedStepper, StepMethod

DAMPS = 0.02  # γ - ½, which is (1 - ρ) / (1 + ρ) where steps leave ρ of what is fastest


class Scheme(NamedTuple):
    """Coefficients of the method, and of its local error in q: error h³ ȧ."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    error: float


class AlphaMethod(StepMethod):
    """Base class of HHT and generalized-α, which differ in their coefficients only."""

    step: float | None
    stabilized: bool

    def __post_init__(self) -> None:
        super().__post_init__()
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
    step. For `rtol`, 1e-6 by default, `atol`, `max_step` and `first_step` see `StepControl`.
    """

    alpha: float = -0.1
    step: float | None = None
    stabilized: bool = False
    rtol: Given = field(default=RTOL_OF_ORDER_2, kw_only=True)

    def scheme(self) -> Scheme:
        if not -1 / 3 <= real("alpha", self.alpha) <= 0:
            raise ValueError(
                f"alpha of HHT must lie between -1/3 and 0, but is {self.alpha}. Give one of these."
            )
        return _scheme(0.0, -self.alpha)


@dataclass(frozen=True)
class GeneralizedAlpha(AlphaMethod):
    """Generalized-α method of order 2 (Chung, Hulbert); ``rho_inf`` from 1, no numerical damping, to 0, the most.

    `step`, `stabilized` and the control of steps as for `HHT`.
    """

    rho_inf: float = 0.8
    step: float | None = None
    stabilized: bool = False
    rtol: Given = field(default=RTOL_OF_ORDER_2, kw_only=True)

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


@lru_cache(32)
def generalized_alpha(
    alpha_m: float, alpha_f: float, beta: float, gamma: float, error: float, stabilized: bool = False
) -> Description:
    """The method with some coefficients, and an estimated error of `error` h³ ȧ."""
    blocks = {"A": COORDINATES, "L": CONSTRAINTS}
    if stabilized:
        blocks = {"Q": COORDINATES, **blocks, "E": CONSTRAINTS}
    method = alpha_m, alpha_f, beta, gamma
    step = partial(_stabilized if stabilized else _plain, method)
    own: dict[str, Affine] = {"x": {"a": 1.0}}
    estimate = Estimate(2, error, partial(_error, method, error, stabilized))
    return Description(blocks, step, own, not stabilized, gamma - 0.5 > DAMPS, estimate, "generalized-α")


Coefficients = tuple[float, float, float, float]


def _end(method: Coefficients, h: Any, ratio: Any, unit: Any) -> tuple[Affine, Affine, Affine]:
    """q₁, v₁ and ã₁ by the state before and by the unknown A, which is a₁ over `unit`."""
    m, f, beta, gamma = method
    before: Affine = {"a": 1.0 - ratio, "x": ratio}  # ã₀ for the new step size
    mixed = (-m / (1 - m), before), (f / (1 - m), {"a": 1.0}), ((1 - f) / (1 - m) * unit, {"A": 1.0})
    after = combined(*mixed)
    q = combined((1.0, {"q": 1.0, "v": h}), (h * h * (0.5 - beta), before), (h * h * beta, after))
    return q, combined((1.0, {"v": 1.0}), (h * (1 - gamma), before), (h * gamma, after)), after


def _weights(method: Coefficients, h: Any) -> tuple[Any, Any]:
    """β' and γ', the derivatives of q₁ and v₁ by a₁."""
    m, f, beta, gamma = method
    return beta * h * h * (1 - f) / (1 - m), gamma * h * (1 - f) / (1 - m)


def _error(method: Coefficients, constant: float, stabilized: bool, h: Any, ratio: Any) -> Affine:
    """h³ ȧ, of the change of ã."""
    before: Affine = {"a": 1.0 - ratio, "x": ratio}
    after = _end(method, h, ratio, 1 / _weights(method, h)[0] if stabilized else 1.0)[2]
    return combined((constant * h * h, after), (-constant * h * h, before))


def _plain(method: Coefficients, h: Any, ratio: Any) -> Step:
    beta, _ = _weights(method, h)
    q, v, x = _end(method, h, ratio, 1.0)
    stage = Stage(q=q, v=v, a={"A": 1.0}, lam={"L": 1.0})
    equations = (Equation("motion"), Equation("position", scale=1 / beta))
    return Step((stage,), equations, {"q": q, "v": v, "a": stage.a, "x": x, "lam": stage.lam})


def _stabilized(method: Coefficients, h: Any, ratio: Any) -> Step:
    """The unknowns are q₁, β'a₁, β'λ₁ and η; Φ_q(q₀) is at the end's time, too."""
    beta, gamma = _weights(method, h)
    predicted, v, x = _end(method, h, ratio, 1 / beta)
    shift = combined((1.0, {"Q": 1.0}), (-1.0, predicted))
    start = Stage(q={"q": 1.0}, mu={"E": 1.0}, rate=shift)
    end = Stage(q={"Q": 1.0}, v=v, a={"A": 1 / beta}, lam={"L": 1 / beta})
    equations = (
        Equation("kinematic", 0),
        Equation("motion", 1, beta),
        Equation("position", 1),
        Equation("velocity", 1, beta / gamma),
    )
    return Step((start, end), equations, {"q": end.q, "v": v, "a": end.a, "x": x, "lam": end.lam})
