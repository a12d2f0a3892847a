"""The result of the search for a static equilibrium."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ..algebra import Array
from ..model.checks.arguments import CHECKS
from ..outputs import Level, outputs_of
from ..outputs.motion import reaction_outputs, series, shared_by, words_of
from ..outputs.output import components
from ..system import System
from ..system.operators.reactions import Wrench
from .result import Result

Stability = Literal["stable", "neutral", "unstable", "unknown"]


class RestReaction(Wrench):
    """The reaction of a joint or driver in an equilibrium.

    Attributes
    ----------
    shared : the redundant joints that share it, in least norm; none where it is determined
    """

    joint: str
    rest: Equilibrium

    @property
    def shared(self) -> tuple[str, ...]:
        return shared_by(self.rest, reaction_outputs(self.joint))

    def __str__(self) -> str:
        return f"{self!r}{words_of(self.shared)}"


@dataclass(frozen=True)
class Equilibrium(Result):
    """Result of `equilibrium`: a position in which all forces balance, or the best approximation.

    Attributes
    ----------
    name : of the system
    q : (nq,)
    lam : (m,) multipliers of the joints and normalizations; for reactions, see `reaction`
    success : whether the forces balance
    message : the outcome and the stability
    stability : from the smallest of `squares`; "neutral" if a motion has no stiffness, "unknown" without success
    squares : (d,) eigenvalues of the constrained Hessian Zᵀ((Φ_qᵀ lam)_q - Q_q)Z in the metric of the mass matrix,
        increasing: squares of the undamped angular frequencies [rad²/s²], negative if the equilibrium is unstable
    motions : (nq, d) the corresponding directions
    residual : largest entry of the unbalanced force [N], [N m]
    iterations : number of steps
    t : time at which drivers and forces are evaluated [s]
    v : (nq,) zero, except for first-order states
    memory, revolutions : state variables of elements, and revolutions of the joints' angles, see `State`
    system : System, for outputs and reactions
    """

    name: str
    q: Array = field(repr=False)
    lam: Array = field(repr=False)
    success: bool
    message: str
    stability: Stability
    squares: Array = field(repr=False)
    motions: Array = field(repr=False)
    residual: float
    iterations: int
    t: float = 0.0
    v: Array | None = field(default=None, repr=False)
    memory: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    revolutions: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    system: System | None = field(default=None, repr=False, compare=False, kw_only=True)

    def __getitem__(self, name: str) -> Any:
        """Return the value of an output, ``rest["spring.length"]``, or of a vector, ``rest["pin.force"]`` (3,).

        Raises
        ------
        UnknownOutput
            If there is no such output, which is a KeyError, too.
        """
        found = np.array(
            [series(self._system, self, one).values[0] for one in components(self._system, name)]
        )
        return float(found[0]) if len(found) == 1 else found

    def _ipython_key_completions_(self) -> list[str]:
        return (
            [one.name for one in outputs_of(self.system) if one.level < Level.HISTORY] if self.system else []
        )

    def reaction(self, joint: str) -> RestReaction:
        """Return force and torque of a joint or driver on its second body, see `System.reaction`.

        Raises
        ------
        KeyError
            If there is no such joint or driver.
        """
        CHECKS["name"]("joint", joint)
        found = RestReaction(*self._system.reaction(joint, self.q, self.lam, self.t))
        found.joint, found.rest = joint, self
        return found

    @property
    def _system(self) -> System:
        if self.system is None:
            raise ValueError(
                f"{self.name}: this equilibrium does not know its system. Use that of `equilibrium`."
            )
        return self.system

    def summary(self) -> str:
        """Return the outcome and the stability of the position."""
        return self.message
