"""Description of an implicit method: unknowns of a step, its stages, its equations, and the state after it.

A step of length h solves R(z; y₀, b) = 0 for its unknowns z. Everything is data: the stages (q, v, a, λ, μ) are affine
in the state before the step, y₀, and in z, with coefficients that depend on h and on the ratio of h to the length of
the step before; R consists of equations of a few kinds at the stages; the state after the step is affine in y₀ and z.
Runs, and their tangent, adjoint and second-order sweeps are derived from this, for all methods.

Choose unknowns and scales so that the Newton matrix stays well conditioned as h falls: v h in place of v, and so on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

from ....model.arithmetic import Numeric

COORDINATES, CONSTRAINTS = "coordinates", "constraints"  # sizes of blocks: nq, and m
ALL, HOLONOMIC, NONHOLONOMIC = "all", "holonomic", "nonholonomic"  # rows of the constraints
ROLES = ("q", "v", "a", "lam", "mu")  # of a stage, besides its rate
# Block of the state or of the unknowns → coefficient: a number, or one for each step
Affine: TypeAlias = Mapping[str, Numeric]


class Stage(NamedTuple):
    """A stage, at t₀ + time · h; each of its quantities by blocks of the state before the step and of the unknowns.

    `rate` is the rate in the kinematic equation, equal to -W⁻¹Φ_qᵀμ.
    """

    time: float = 1.0
    q: Affine = {}  # noqa: RUF012
    v: Affine = {}  # noqa: RUF012
    a: Affine = {}  # noqa: RUF012
    lam: Affine = {}  # noqa: RUF012
    mu: Affine = {}  # noqa: RUF012
    rate: Affine = {}  # noqa: RUF012


class Equation(NamedTuple):
    """An equation at a stage, multiplied by a scale.

    The kinds:

        motion        M a + Φ_qᵀλ - Q - S
        position      Φ
        velocity      Φ_q v + Φ_t
        acceleration  Φ_q a - γ
        kinematic     W rate + Φ_qᵀμ      W: see `kinematic_weights`
        impulse       M a + Φ_qᵀλ

    `rows` are those of the constraints in which an equation is solved, see `nonholonomic`; methods leave it out.

    Of the equations of constraints and the blocks of multipliers among the unknowns there are equally many: where an
    equation is redundant, its multiplier, in the same place of both orders, is zero.
    """

    kind: str
    stage: int = 0
    scale: Numeric = 1.0
    rows: str = ALL


class Step(NamedTuple):
    """Stages, equations, and the blocks of the state that change; the others keep their values."""

    stages: tuple[Stage, ...]
    equations: tuple[Equation, ...]
    update: Mapping[str, Affine]


@dataclass(frozen=True)
class Operation:
    """A step or another operation of a run, with coefficients for all its occurrences.

    Attributes
    ----------
    state, unknowns : sizes of blocks by name, `COORDINATES` or `CONSTRAINTS`
    step : its coefficients
    """

    state: Mapping[str, str]
    unknowns: Mapping[str, str]
    step: Step


class Estimate(NamedTuple):
    """Estimate of the local error of a step in q; the error in v is this value divided by h.

    Attributes
    ----------
    order : of the method: the error falls with h^(order + 1)
    constant : of the error of a first step, constant x h^(order + 1) x the derivative of q of that order
    of : of h and ratio, as `Description.step`: the estimate by blocks of the state before the step and of the unknowns
    """

    order: int
    constant: float
    of: Callable[[Numeric, Numeric], Affine]


class FilteredEstimate(NamedTuple):
    """Estimate of the local error of three stages that are split, see `splitting`, which stiff forces do not dominate.

    The error solves the system of the real eigenvalue, with W times a rate of change of q and M times an acceleration
    as right sides of the kinematic equation and of the equation of motion (Hairer and Wanner, IV.8.19).

    Attributes
    ----------
    order : of the estimate, which falls with h^(order + 1)
    constant : as of `Estimate`, for the first step
    of : of h and ratio: rate and acceleration, by blocks of the state before the step and of the unknowns
    of_method : the order of the method
    """

    order: int
    constant: float
    of: Callable[[Numeric, Numeric], tuple[Affine, Affine]]
    of_method: int


class StepLengths(NamedTuple):
    """Rules for the next step size from the error of this step.

    Attributes
    ----------
    safety : times the length at which the error would be the tolerance
    iterations : n, by which safety falls with Newton's iterations i, as (1 + 2 n) / (i + 2 n); 0: it does not
    shrink, grow : the least and the greatest ratio of two steps
    below, above : the length stays for ratios between these, with the factors of the matrix
    predictive : whether the trend of the errors of the last two steps goes on (Gustafsson 1994), which foresees
        rejected steps
    unsolved : the ratio of a step to the one of which Newton's method failed
    hold : for how many steps, at most, the length stays after that: for twice as many each time that the method fails
        again
    """

    safety: float = 0.85
    iterations: int = 0
    shrink: float = 0.2
    grow: float = 3.0
    below: float = 0.8
    above: float = 1.3
    predictive: bool = False
    unsolved: float = 0.25
    hold: int = 0


@dataclass(frozen=True, eq=False)
class Description:
    """An implicit method.

    Attributes
    ----------
    unknowns : sizes of blocks by name
    step : of the length h and of its ratio to the step before, numbers or arrays with one for each step
    extra : blocks of the state besides q, v, a and λ: how each begins, by these
    projects : whether a part of the defect of the velocity constraints is removed when the step size changes
    damps : whether round-off in the multipliers decays from step to step
    error : estimate of the local error; by default the leading term of the method's error, see `leading_error`
    name : for messages
    continued : of h and its ratio to the step before: first guess of the unknowns, by those of the last step and by the
        state before that one; unknowns that are not in it begin with zero. By default they follow from the last nodes
    lengths : of steps, see `StepLengths`

    Where the update has no a, accelerations and multipliers at the ends of steps are those of the equations of motion.
    """

    unknowns: Mapping[str, str]
    step: Callable[[Numeric, Numeric], Step]
    extra: Mapping[str, Affine] = field(default_factory=dict)
    projects: bool = False
    damps: bool = False
    error: Estimate | FilteredEstimate | None = None
    name: str = "method"
    continued: Callable[[Numeric, Numeric], Mapping[str, Affine]] | None = None
    lengths: StepLengths = field(default_factory=StepLengths)

    @property
    def state(self) -> dict[str, str]:
        """Sizes of the blocks of the state."""
        return {**dict.fromkeys(("q", "v", "a", *self.extra), COORDINATES), "lam": CONSTRAINTS}

    @property
    def record(self) -> dict[str, Any]:
        """Return plain values that identify the method: its structure and its coefficients at one h and ratio."""
        at, error = (0.37, 0.83), self.error
        estimate = None if error is None else (error.order, error.constant, repr(error.of(*at)))
        sizes = {"unknowns": dict(self.unknowns), "extra": repr(self.extra)}
        flags = {"projects": self.projects, "damps": self.damps}
        return {"type": self.name, **sizes, "step": repr(self.step(*at)), **flags, "error": estimate}

    def operation(self, h: Numeric, ratio: Numeric) -> Operation:
        """Return the operation for given step sizes."""
        return Operation(self.state, self.unknowns, self.step(h, ratio))


def combined(*terms: tuple[Any, Affine]) -> Affine:
    """The sum of affine maps, each times a factor."""
    found: dict[str, Any] = {}
    for factor, affine in terms:
        for name, coefficient in affine.items():
            found[name] = found.get(name, 0.0) + factor * coefficient
    return found


def projection(state: Mapping[str, str], removed: Any) -> Operation:
    """A part of the defect of the velocity constraints is removed by the least change s of v in the metric of M.

    M s + Φ_qᵀσ = 0, Φ_q s = Φ_q v + Φ_t.
    """
    stage = Stage(0.0, q={"q": 1.0}, v={"v": 1.0, "s": -1.0}, a={"s": 1.0}, lam={"sigma": 1.0})
    equations = (Equation("impulse"), Equation("velocity", scale=-1.0))
    return Operation(
        state,
        {"s": COORDINATES, "sigma": CONSTRAINTS},
        Step((stage,), equations, {"v": {"v": 1.0, "s": -removed}}),
    )


def accelerations(state: Mapping[str, str]) -> Operation:
    """Accelerations and multipliers of the equations of motion at the state that was reached."""
    stage = Stage(q={"q": 1.0}, v={"v": 1.0}, a={"a_end": 1.0}, lam={"lam_end": 1.0})
    equations = (Equation("motion"), Equation("acceleration"))
    update = {"a": {"a_end": 1.0}, "lam": {"lam_end": 1.0}}
    return Operation(state, {"a_end": COORDINATES, "lam_end": CONSTRAINTS}, Step((stage,), equations, update))


def placement(state: Mapping[str, str], nonholonomic: bool = False) -> Operation:
    """The nearest q on the constraints, in the metric of M at q0: M (q - q0) + Φ_q(q0)ᵀσ = 0, Φ(q) = 0.

    For nonholonomic constraints, which have no Φ, Φ_q(q0) (q - q0) = 0.
    """
    change: Affine = {"Q": 1.0, "q0": -1.0}
    before = Stage(q={"q0": 1.0}, a=change, lam={"sigma": 1.0}, v=change if nonholonomic else {})
    equations = [Equation("impulse", 0), Equation("position", 1)]
    if nonholonomic:
        equations[1:] = Equation("position", 1, rows=HOLONOMIC), Equation("velocity", 0, rows=NONHOLONOMIC)
    step = Step((before, Stage(q={"Q": 1.0})), tuple(equations), {"q": {"Q": 1.0}})
    return Operation(state, {"Q": COORDINATES, "sigma": CONSTRAINTS}, step)


def compatible_velocity(state: Mapping[str, str]) -> Operation:
    """The nearest v that the constraints permit at q: M(q0) (V - v) + Φ_q(q0)ᵀρ = 0, Φ_q(q) V + Φ_t = 0."""
    before = Stage(q={"q0": 1.0}, a={"V": 1.0, "v": -1.0}, lam={"rho": 1.0})
    stages = (before, Stage(q={"q": 1.0}, v={"V": 1.0}))
    step = Step(stages, (Equation("impulse", 0), Equation("velocity", 1)), {"v": {"V": 1.0}})
    return Operation(state, {"V": COORDINATES, "rho": CONSTRAINTS}, step)
