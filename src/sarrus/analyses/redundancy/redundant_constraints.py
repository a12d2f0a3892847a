"""Redundant constraints in analyses: independent equations, multipliers of minimum norm, and refusals.

An analysis of a system whose equations are dependent, but consistent, goes on with a choice of independent equations.
Coordinates, velocities and accelerations do not depend on this choice. Multipliers are not unique; reported are those
of least norm, see `minimum_norm`, of all that give the same constraint forces Φ_qᵀλ.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.factors import SingularSystem
from ...linalg.rank import TOLERANCE, components, independent_rows, rank_of, row_lengths
from ...model.errors import listed
from ...model.tape import Tracer
from ...outputs.motion import motion_outputs, states_of
from ...outputs.output import Level, find_output
from ...outputs.outputs import Outputs
from ...results import Assembly
from ...system import System
from ...system.cached import once_alike
from ..equations.length import lever, scaled
from ..equations.minimum_norm import MinimumNorm
from ..equations.nullspace import normalizations

CONTRADICTION = 1e-6  # nᵀγ for unit gradients, relative to γ, above which accelerations do not exist
# Over n² for n bodies: smallest singular value of Φ_q, rows at unit length, of nearly dependent constraints (chains: 2)
NEARLY = 1e-3
SHARE = 0.2  # of the largest entry of a combination that nearly vanishes: parts with more are named
AMPLIFICATION = 10.0  # of the chosen equations in those left out, above which another choice is made


class InconsistentConstraints(ArithmeticError):
    """Dependent constraints contradict each other."""


class Independence:
    """A choice of independent equations of one system, made at one position and renewed along a motion.

    Parameters
    ----------
    system : System
    q : (nq,) a position that satisfies the constraints
    t : time [s]

    Attributes
    ----------
    rows : indices in Φ of the equations chosen, or None where all are independent
    known : how many equations depend on others
    length : by which displacements are measured, in all positions
    nearly : message on constraints that were nearly dependent there, or empty
    """

    def __init__(self, system: System, q: Array, t: float = 0.0) -> None:
        self._system, self._fixed = system, normalizations(system)
        self.length = lever(system, q, J := system.Phi_q(q, t))
        least, self._start = NEARLY / len(system.bodies) ** 2, (q.copy(), t)
        rank = rank_of(scaled(J, system.layout.scales(self.length)), None, _components(system), least)
        self.rows: Array | None = None
        self._looked_at: tuple[float, bytes] | None = None
        self._choose(rank.null)
        self.known = self._null.shape[1]
        self.nearly = self._message(q, t) if rank.smallest < least else ""

    @cached_property
    def smallest(self) -> float:
        """Smallest singular value of Φ_q, rows at unit length, that is not taken for zero, at the start."""
        return rank_of(self.scaled_Phi_q(*self._start), parts=_components(self._system)).smallest

    def _message(self, q: Array, t: float) -> str:
        near = rank_of(self.scaled_Phi_q(q, t), 2 * self.smallest, _components(self._system)).null
        sizes = abs(near - self._null @ (self._null.T @ near)).max(axis=1)
        rows = sorted(named_rows(self._system, sizes))
        parts = [*dict.fromkeys(self._system.row_names[k].split(":")[0] for k in rows)]
        return (
            f"constraints of {listed(parts)} are nearly dependent at the start, with a smallest singular "
            f"value of {self.smallest:.1e}. Align joints that are meant to be redundant to 1e-8, as hinges in line, "
            "or start farther from a singular configuration"
        )

    def scaled_Phi_q(self, q: Array, t: float) -> csr_array:
        """Φ_q by coordinates without unit, as `rank_of` wants it."""
        return scaled(self._system.Phi_q(q, t), self._system.layout.scales(self.length))

    def _choose(self, null: Array) -> None:
        self._null = null
        if null.shape[1]:
            self.rows = independent_rows(null, self._fixed)
            self._minimum = MinimumNorm(self._system, self.rows)

    def state(self) -> dict[str, Array]:
        """Return the data of the choice for `resume`."""
        return {"null": self._null}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Take over a choice made before."""
        self._looked_at = None
        self._choose(state["null"])

    def renew(self, t: float, q: Array) -> bool:
        """Choose again at another position, if the choice is no longer good there; true if there is another choice.

        Where the rank is not what it was, at a singular configuration, the choice stays.
        """
        if self.rows is None or self._looked_at == (here := (t, q.tobytes())):
            return False
        self._looked_at = here  # steps that are taken again begin there
        if not self._poor(t, q):
            return False
        null = rank_of(self.scaled_Phi_q(q, t), parts=_components(self._system)).null
        if same := null.shape == self._null.shape:
            self._choose(null)
        return same

    def _poor(self, t: float, q: Array) -> bool:
        try:
            J = self._system.Phi_q(q, t)
            lengths = row_lengths(scaled(J, self._system.layout.scales(self.length)))
            sizes = lengths[:, None] * abs(self._minimum.combinations(J))
            return bool(np.any(sizes > AMPLIFICATION * lengths[self._minimum.dropped]))
        except SingularSystem:
            return True

    def shortest(self, t: float, q: Array, lam: Array) -> Array:
        """The shortest multipliers (m,) that give the same constraint forces."""
        if self.rows is None:
            return lam
        J = self._system.Phi_q(q, t)
        return self._minimum.least(self._system, J, q, self._system.b).choose(lam)

    def row_lengths(self, q: Array, t: float) -> Array:
        """Return the lengths of the rows of Φ_q, with displacements relative to the length (m,)."""
        return row_lengths(self.scaled_Phi_q(q, t))

    def vanishing(self, q: Array, t: float, random: np.random.Generator) -> Array:
        """A random combination n of equations with nᵀΦ_q = 0 (m,)."""
        null = self._minimum.null(self._system.Phi_q(q, t))
        return np.asarray(null @ random.normal(size=null.shape[1]))

    def motions(self, q: Array, t: float, unit: Array, random: np.random.Generator) -> tuple[Array, Array]:
        """Two random directions ξ with Φ_q ξ = 0 (nq,)."""
        J = self._system.Phi_q(q, t)
        self._minimum.combinations(J)
        xi = unit[:, None] * random.normal(size=(len(unit), 2))
        for _ in range(2):
            xi = xi - self._minimum.motions(J @ xi)
        return xi[:, 0], xi[:, 1]

    def check(self, start: Assembly) -> None:
        """Refuse a start whose equations contradict each other.

        Raises
        ------
        Inconsistent
            If the assembly failed, or no acceleration satisfies all constraints.
        """
        if not start.success:
            raise InconsistentConstraints(start.message)
        if self.rows is None:
            return
        lengths = self.row_lengths(start.q, start.t)
        scaled = self._system.gamma(start.q, start.v, start.t) / lengths
        missing = self._null @ (self._null.T @ scaled)
        if abs(missing).max() > CONTRADICTION * max(abs(scaled).max(), CONTRADICTION):
            row = self._system.row_names[int(np.argmax(abs(missing)))]
            raise InconsistentConstraints(
                f"{self._system.name} has redundant constraints that contradict each other as soon as it moves, "
                f"first of all {row}; it is stuck in this position, or its velocity leaves the way that it can go"
            )


def named_rows(system: System, sizes: Array) -> list[int]:
    """The equations with the largest entries of combinations (m,), from the largest on.

    Normalizations, which take part where a body rotates, only if there are no others.
    """
    own = np.where(normalizations(system), 0.0, sizes)
    sizes = own if own.any() else sizes
    return [int(n) for n in np.argsort(-sizes, kind="stable") if sizes[n] > SHARE * sizes.max()]


@once_alike
def _components(system: System) -> tuple[Array, int]:
    """Return the groups of equations that share coordinates, directly or by others."""
    return components(system.pattern("Phi_q"))


def sharing(system: System, result: Any, names: Sequence[str]) -> tuple[str, ...]:
    """The joints and drivers that share what some outputs read, at the first, middle or last state of a result.

    Multipliers may change by any n with nᵀΦ_q = 0. An output that changes with n is a choice among the parts in which
    n has equations. Forces count times the length of the system, as moments.
    """
    read = [
        output for output in map(partial(find_output, system), names) if output.level == Level.ACCELERATION
    ]
    states, joints = states_of(result), set[str]()
    last = len(states.t) - 1
    for at in sorted({0, last // 2, last}) if read and last >= 0 else ():
        t, q = float(states.t[at]), states.q[at]
        length = lever(system, q, J := system.Phi_q(q, t))
        null = rank_of(J := scaled(J, system.layout.scales(length)), parts=_components(system)).null
        if not null.shape[1]:
            continue
        # normalizations bear no loads
        null = null @ np.linalg.inv(np.linalg.qr(null[~normalizations(system)], mode="r"))
        one_state = {name: getattr(states, name)[[at]] for name in "tqva"}
        outputs = motion_outputs(system, SimpleNamespace(**one_state, lam=states.lam()[[at]]), Outputs)
        values, ways = [output.record(outputs) for output in read], null / row_lengths(J)[:, None]
        moved = {x.at: ways[n] for (kind, n), x in outputs.inputs.items() if kind == "lam"}
        dots = outputs.tape.along(moved)
        changes = np.zeros((len(read), null.shape[1]))
        for change, output, value in zip(changes, read, values, strict=True):
            if isinstance(value, Tracer):
                change[:] = (length if output.unit == "N" else 1.0) * dots[value.at]
        _, sizes, turned = np.linalg.svd(np.nan_to_num(changes), full_matrices=False)
        n = abs(null @ turned[sizes > np.sqrt(TOLERANCE)].T)
        joints |= {part for part, rows in system.rows.items() if np.any(n[rows] > np.sqrt(TOLERANCE))}
    return tuple(part for part in system.rows if part in joints)
