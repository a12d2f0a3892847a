"""The forces at one position at rest, and their exact change along the free directions."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh

from ...algebra import Array
from ...linalg.factors import SingularSystem
from ...model import SarrusError
from ...system import System
from ..dynamics.time_loop.nearness import rank_changes
from ..equations.length import lever
from ..equations.minimum_norm import least_multipliers
from ..equations.motion import KKTMatrix
from ..equations.nullspace import NullSpace
from ..equations.states_at_rest import at_rest, by_position, places, states_last
from ..redundancy.redundant_constraints import Independence

TRUSTED = 1e-12  # pivot over column, below which constraints count as dependent


def independent_at(system: System, q: Array, t: float) -> Array | None:
    """Return places of independent equations, None if all are, for a state and those that it can move to.

    Raises
    ------
    SarrusError
        In a singular configuration: with the equations that are dependent there alone, motions nearby would be wrong.
    """
    choice = Independence(system, q, t)
    if choice.known and choice.known + system.nq > system.m and rank_changes(system, q, t, choice):
        raise singular(system, t)
    return choice.rows


def matrix_at(system: System, q: Array, t: float, b: Array, rows: Array | None) -> KKTMatrix:
    """Return the matrix with pivots for a state and independent equations (rows, None for all).

    Raises
    ------
    SarrusError
        In a singular configuration.
    """
    matrix = KKTMatrix(system, rows=rows)
    try:
        matrix.factor_at(b, t, q)
    except (SingularSystem, ValueError):
        raise singular(system, t) from None
    return matrix


def singular(system: System, t: float) -> SarrusError:
    """Return the error of a state without a unique solution."""
    return SarrusError(
        f"{system.name}: the equations of motion have no unique solution at t = {t:.6g} s, a singular configuration or "
        "a body without inertia. Give another state."
    )


def unsolved(system: System, t: float, trust: float) -> SarrusError:
    """Return the error of a state at which pivots just chosen are not to be trusted: -1, the solution is not finite."""
    if trust >= 0.0:
        return singular(system, t)
    return SarrusError(
        f"{system.name}: accelerations or multipliers are not finite at t = {t:.6g} s. Give other velocities, inputs "
        "or parameters, or look for a force that is not finite there."
    )


def refuse_not_finite(**values: object) -> None:
    """Refuse a state that contains nan or infinity.

    Raises
    ------
    ValueError
    """
    for name, value in values.items():
        if not np.isfinite(value).all():  # type: ignore[call-overload]
            raise ValueError(f"{name} must be finite, got {value!r:.60}. Give finite numbers.")


def input_changes(system: System, names: Sequence[str]) -> Array:
    """Return the derivatives of the parameters b by the values of inputs (len(b), nu)."""
    derivatives = np.zeros((len(system.b), len(names)))
    for k, name in enumerate(names):
        derivatives[system.inputs[name].places, k] = 1.0
    return derivatives


NEUTRAL = 1e-10  # an eigenvalue of (H, W) relative to its terms before they cancel, that counts as zero
ROUND_OFF = 1e-14  # the same relative to the largest eigenvalue: what the eigenvalue solver leaves
RESOLVED = 100 * np.finfo(float).eps  # of a coordinate: smaller changes are round-off
FINISHED = 1e-12  # a step, in parts of the model's size, that changes nothing any more
BALANCED = 1e-8  # of the largest force on a body, before forces cancel: what may remain


class Spectrum(NamedTuple):
    """Eigenvalues ω² (d,) of H y = ω² W y, H's symmetric part, and vectors as columns (d, d) with yᵀ W y = 1.

    `neutral` (d,) marks those that are zero to their own condition.
    """

    squares: Array
    vectors: Array
    neutral: Array


class Balance:
    """Q - Φ_qᵀ lam and its derivative at a position q at rest, with the shortest change of multipliers.

    q holds the first-order states, see `states_at_rest`. Those at the places `settled`, whose rates are zero, follow
    the position and the other states, and only free directions of these are left.

    Attributes
    ----------
    space : of the constraint Jacobian
    Z : (nq, d) the free directions
    lam : (m,) the multipliers that balance the forces best
    g : (d,) the part of the forces along Z, that no constraint balances
    length : by which displacements are measured where they are added to rotations [m]
    """

    def __init__(
        self,
        system: System,
        q: Array,
        t: float,
        b: Array,
        settled: Array | None = None,
        length: float | None = None,
    ) -> None:
        self.system, self.q, self.t, self.b = system, q, t, b
        J = system.Phi_q(q, t, b=b)
        self.length = length or lever(system, q, J)
        self.space = space = NullSpace(J, system.layout.scales(self.length))
        self.rest = at_rest(system, q)
        self.Q = system.Q(q, self.rest, t, b=b)
        self.Z, self.share = space.Z, space.share
        self.lam = least_multipliers(system, space, J, q, b, self.Q)
        self._follows = np.zeros((system.nq, 0))
        if settled is not None and len(settled):
            count = len(settled)
            Z, share = states_last(settled, self.Z, self.share)
            self._follows, self.Z, self.share = Z[:, -count:], Z[:, :-count], share[:-count]
        self.g = self.Z.T @ self.Q

    @cached_property
    def H(self) -> Array:
        """The constrained Hessian Zᵀ ((Φ_qᵀ lam)_q - Q_q) Z (d, d)."""
        K = self.system.Phi_qT_lam_q(self.q, self.lam, self.t, b=self.b).toarray()
        operands: Any = {"q": self.q, "v": self.rest, "t": self.t, "b": self.b}
        K -= by_position(self.system, lambda name: getattr(self.system, name)(**operands))
        Z, S = self.Z, self._follows
        moved = Z - S @ np.linalg.solve(S.T @ (K @ S), S.T @ (K @ Z)) if S.size else Z
        return np.asarray(Z.T @ (K @ moved))

    @cached_property
    def W(self) -> Array:
        """The mass matrix along the free directions, Zᵀ M Z (d, d)."""
        return np.asarray(self.Z.T @ (self.system.M(self.q, b=self.b) @ self.Z))

    @cached_property
    def spectrum(self) -> Spectrum:
        """Squares of the undamped angular frequencies, if the forces are conservative."""
        if not len(self.g):
            return Spectrum(np.zeros(0), np.zeros((0, 0)), np.zeros(0, dtype=bool))
        squares, vectors = eigh(0.5 * (self.H + self.H.T), self.W)
        motions = abs(self.Z @ vectors)
        round_off = (motions * (self._stiffness_round_off() @ motions)).sum(axis=0)
        neutral = abs(squares) <= round_off + ROUND_OFF * abs(squares).max()
        return Spectrum(squares, vectors, neutral)

    @property
    def asymmetry(self) -> float:
        """Return the asymmetry of H relative to its terms, which is zero if the forces have a potential.

        With first-order states they have none.
        """
        if self.system.states:
            return 1.0
        terms = abs(self.Z).T @ (self.stiffness_terms @ abs(self.Z))
        return float(abs(self.H - self.H.T).max(initial=0.0) / (terms.max(initial=0.0) or 1.0))

    @property
    def residual(self) -> float:
        """Largest entry of the force that is not balanced [N], [N m]."""
        return float(abs(self.share.T @ self.g).max(initial=0.0))

    @cached_property
    def stiffness_terms(self) -> Array:
        """(Φ_qᵀ lam)_q - Q_q with all elements' contributions taken by their absolute values (nq, nq)."""
        operands: Any = {"q": self.q, "v": self.rest, "t": self.t, "b": self.b}
        terms = self.system.magnitude("Phi_qT_lam_q", q=self.q, lam=self.lam, t=self.t, b=self.b)
        forces = by_position(self.system, lambda name: self.system.magnitude(name, **operands))
        return np.asarray(terms.toarray() + forces)

    def _stiffness_round_off(self) -> Array:
        """Return the round-off of H, from its terms and from that of the multipliers."""
        force = float((self.system.layout.scales(self.length) * self.force_terms).max(initial=0.0))
        terms = self.system.magnitude(
            "Phi_qT_lam_q", q=self.q, lam=force / self.space.lengths, t=self.t, b=self.b
        )
        return np.asarray(NEUTRAL * self.stiffness_terms + RESOLVED * terms.toarray())

    @cached_property
    def force_terms(self) -> Array:
        """The same of Q and Φ_qᵀ lam (nq,): forces before they cancel."""
        terms = self.system.magnitude("Q", q=self.q, v=self.rest, t=self.t, b=self.b)
        terms = terms + self.system.magnitude("Phi_qT_lam", q=self.q, lam=self.lam, t=self.t, b=self.b)
        return np.asarray(terms)

    @property
    def acceleration(self) -> float:
        """Return gᵀ W⁻¹ g: the square of the unbalanced force, in a norm that no coordinates enter."""
        return float(self.g @ np.linalg.lstsq(self.W, self.g, rcond=None)[0])

    def balanced(self, unit: Array) -> bool:
        """Return whether what remains is round-off of the forces before they cancel, or of a finished search.

        A force that a step of `FINISHED` changes remains where nothing but a relaxed spring acts.

        `unit` (nq,) is what a change of a coordinate by one means.
        """
        unbalanced, moving = unit * abs(self.share.T @ self.g), self.system.moving
        changes = unit * (self.stiffness_terms @ (abs(self.q) + unit))
        forces = unit * self.force_terms
        allowed = BALANCED * np.maximum(forces, changes)  # of states each rate; of bodies, the largest force
        force, change = (float(x[:moving].max(initial=0.0)) for x in (forces, changes))
        allowed[:moving] = max(BALANCED * force, FINISHED * change)
        noise = RESOLVED * abs(self.Z).max(axis=0, initial=0.0) * self.force_terms.sum()  # of g, by that of Z
        allowed = np.maximum(allowed, unit * (abs(self.share.T) @ noise))
        places_of_rates = np.concatenate([np.arange(moving), places(self.system)])
        return bool(np.all(unbalanced[places_of_rates] <= allowed[places_of_rates]))
