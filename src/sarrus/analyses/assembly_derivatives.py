"""Exact derivatives of assembled coordinates and velocities, by the implicit function theorem.

The conditions of least change,

    W (q - q₀) + Φ_qᵀλ = 0,         Φ(q, b) = 0,
    W (v - v₀) + Φ_qᵀμ + Cᵀν = 0,   Φ_q v = -Φ_t,  C v = rates,

differentiated along a direction of the numbers b and of the guess (q₀, v₀), or transposed.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack

from ..algebra import Array
from ..results import Asked, Assembly
from ..system import System
from ..system.curve_derivatives import CurveDerivatives
from .degrees_of_freedom import normalizations
from .kkt import KKT
from .velocity import Rates

OPEN = 1e-8  # |Φ_q q' + Φ_b db| relative to |Φ_b db|, above which dependent equations contradict each other


class NoDerivative(ArithmeticError):
    """A change of these numbers makes constraints contradict each other."""


class Adjoint(NamedTuple):
    """Gradients by the numbers and the guess; adjoint variables of the conditions for q and Φ, for v and its rows."""

    b: Array
    q: Array
    v: Array
    x1: Array
    y1: Array
    x2: Array
    y2: Array


class AssemblyDerivatives:
    """The derivatives of one assembly. Two matrices are factored once, for any number of directions.

    Parameters
    ----------
    system : System
    found : from `assemble` of this system, successful and nearest

    Raises
    ------
    ValueError
        If the assembly failed, or is not known to be the nearest one.

    Notes
    -----
    The derivatives are those of a smooth branch: the nearest point jumps where two points are equally near. The
    metric, the values of `rates` and the axes about which joints read their rates are held fixed.
    """

    def __init__(self, system: System, found: Assembly) -> None:
        if not found.success or not found.nearest or found.asked is None:
            raise ValueError(
                f"an assembly has derivatives if it succeeded with the least change, but: {found.message}"
            )
        self._system, self._found, self._asked = system, found, found.asked
        self._free = np.flatnonzero(~self._asked.held)
        self._rates = Rates(system, self._asked.rates)
        J = system.Phi_q(found.q, found.asked.t)
        self._position = _Block(self._asked, self._free, self._curvature(found.lam), J)
        both = csr_array(vstack([J, self._rates.rows(found.q)]))
        self._velocity = _Block(self._asked, self._free, None, both)
        self._make_blocks()

    def _curvature(self, lam: Array) -> csr_array:
        return self._system.Phi_qT_lam_q(self._found.q, lam, self._asked.t)

    def _make_blocks(self) -> None:
        system, found, q, t = self._system, self._found, self._found.q, self._asked.t
        self._f1_b, self._g1_b = self._by_b("Phi_qT_lam_b", lam=found.lam), self._by_b("Phi_b")
        self._f2_b = self._by_b("Phi_qT_lam_b", lam=found.mu)
        self._f2_q = -(self._curvature(found.mu) + self._rates.curvature(q, found.nu))
        # γ_v = -2 (Φ_q v)_q - 2 Φ_tq
        by_q = 0.5 * system.gamma_v(q, found.v, t)
        self._g2_q = csr_array(vstack([by_q, -self._rates.rows_xi_q(q, found.v)]))
        by_b = self._by_b("Phi_q_xi_b", xi=found.v) + self._by_b("Phi_t_b")
        none = csr_array((len(self._rates.values), len(system.b)))
        self._g2_b = csr_array(vstack([by_b, none]))

    def _by_b(self, name: str, **operands: Array) -> csr_array:
        """An operator with its sign turned, as wide as `system.b`."""
        system, q, t = self._system, self._found.q, self._asked.t
        matrix = getattr(system, name)(q, t=t, **operands)
        matrix.resize((matrix.shape[0], len(system.b)))
        curves = CurveDerivatives(system).matrix(name.removesuffix("_b"), system.b, t, q=q, **operands)
        return csr_array(-matrix - curves)

    def along(self, db: Any = None, *, dq: Any = None, dv: Any = None) -> tuple[Array, Array]:
        """The derivative along a direction: q' and v' (nq,), or (nq, k) for k directions at once.

        Parameters
        ----------
        db : (len(system.b),) or (len(system.b), k) change of the numbers
        dq, dv : (nq,) or (nq, k) change of the guess `found.asked.q`, `found.asked.v`

        Raises
        ------
        NoDerivative
            If dependent equations would contradict each other.
        """
        q_dot, _, v_dot, _ = self.whole_along(db, dq=dq, dv=dv)
        return q_dot, v_dot

    def whole_along(
        self, db: Any = None, *, dq: Any = None, dv: Any = None
    ) -> tuple[Array, Array, Array, Array]:
        """As `along`, with the multipliers of both: q', λ', v', and μ' with ν' behind it."""
        db, dq, dv = self._directions(db, dq, dv)
        g1 = self._g1_b @ db
        q_dot, lam_dot = self._position.solve(self._f1_b @ db, g1, dq)
        gap, size = abs(self._position.J @ q_dot - g1), abs(g1).max(initial=0.0)
        if gap.max(initial=0.0) > OPEN * max(size, 1e-6):
            row = self._system.row_names[self._widest(gap)]
            raise NoDerivative(
                f"{self._system.name}: such a change would open {row}, which repeats other equations; change "
                "together what keeps them consistent"
            )
        v_dot, mu_dot = self._velocity_along(db, dv, q_dot)
        return q_dot, lam_dot, v_dot, mu_dot

    def _widest(self, gap: Array) -> int:
        """The joint equation with the largest gap."""
        mark = normalizations(self._system)
        return int(np.argmax(np.where(mark, -1.0, gap.reshape(len(gap), -1).max(axis=1))))

    def _directions(self, *given: Any) -> tuple[Array, Array, Array]:
        known = [np.asarray(x, dtype=float) for x in given if x is not None]
        columns = known[0].shape[1:] if known else ()
        sizes = (len(self._system.b), self._system.nq, self._system.nq)
        found = [
            np.zeros((size, *columns)) if x is None else np.asarray(x, dtype=float)
            for x, size in zip(given, sizes, strict=True)
        ]
        for x, size in zip(found, sizes, strict=True):
            if x.shape != (size, *columns):
                raise ValueError(f"a direction must have shape {(size, *columns)}, but has {x.shape}")
        return found[0], found[1], found[2]

    def _velocity_along(self, db: Array, dv: Array, q_dot: Array) -> tuple[Array, Array]:
        g2 = self._g2_q @ q_dot + self._g2_b @ db
        return self._velocity.solve(self._f2_q @ q_dot + self._f2_b @ db, g2, dv)

    def q_b(self, db: Any) -> Array:
        """q_b db: the change of q for a change of the numbers, (nq,) or (nq, k)."""
        return self.along(db)[0]

    def v_b(self, db: Any) -> Array:
        """v_b db: the change of v for a change of the numbers, (nq,) or (nq, k)."""
        return self.along(db)[1]

    def columns(self) -> tuple[Array, Array]:
        """Dense q_b and v_b (nq, len(system.b)); columns are NaN where `along` would raise."""
        db = np.eye(len(self._system.b))
        g1 = self._g1_b @ db
        q_b, _ = self._position.solve(self._f1_b @ db, g1, np.zeros((self._system.nq, len(db))))
        v_b, _ = self._velocity_along(db, np.zeros_like(q_b), q_b)
        gap, size = abs(self._position.J @ q_b - g1).max(axis=0), abs(g1).max(axis=0)
        opened = gap > OPEN * np.maximum(size, 1e-6)
        q_b[:, opened] = v_b[:, opened] = np.nan
        return q_b, v_b

    def gradient(self, q_bar: Any, v_bar: Any) -> tuple[Array, Array, Array]:
        """The transposed product: gradients by b, q₀ and v₀ of a function of (q, v) with the gradients given.

        Parameters
        ----------
        q_bar, v_bar : (nq,) gradients by the assembled q and v

        Returns
        -------
        by_b : (len(system.b),)
        by_q, by_v : (nq,) by the guess
        """
        found = self.adjoint(q_bar, v_bar)
        return found.b, found.q, found.v

    def adjoint(
        self, q_bar: Any, v_bar: Any, change: tuple[Array, Array, Array, Array] | None = None
    ) -> Adjoint:
        """The gradients with the adjoint variables; `change` is taken from the right sides, of q, λ, v and μ."""
        c_q, c_lam, c_v, c_mu = change or (0.0, np.zeros(self._system.m), 0.0, np.zeros(self._g2_b.shape[0]))
        x2, y2, by_v = self._velocity.transposed(np.asarray(v_bar, dtype=float) - c_v, -c_mu)
        through = np.asarray(q_bar, dtype=float) + self._f2_q.T @ x2 + self._g2_q.T @ y2 - c_q
        x1, y1, by_q = self._position.transposed(through, -c_lam)
        by_b = self._f1_b.T @ x1 + self._g1_b.T @ y1 + self._f2_b.T @ x2 + self._g2_b.T @ y2
        return Adjoint(by_b, by_q, by_v, x1, y1, x2, y2)


class _Block:
    """(W + H) x + Jᵀ y = W d + f, J x = g for the free coordinates; the held ones follow the guess, x = d."""

    def __init__(self, asked: Asked, free: Array, H: csr_array | None, J: csr_array) -> None:
        self.J, self._free, self._held = J, free, np.flatnonzero(asked.held)
        self._weight = asked.weight
        W = diags_array(asked.weight)
        self._A = csr_array(W if H is None else W + H)
        self._kkt = KKT(self._A[free][:, free], csr_array(J[:, free]))

    def solve(self, f: Array, g: Array, d: Array) -> tuple[Array, Array]:
        x, F, h = np.zeros(d.shape), self._free, self._held
        x[h] = d[h]
        right = f + (self._weight * d.T).T - self._A @ x
        x[F], y = self._kkt.solve(right[F], g - self.J @ x)
        return x, y

    def transposed(self, x_bar: Array, y_bar: Array | None = None) -> tuple[Array, Array, Array]:
        """The solution (x, y) for the right sides x_bar and y_bar, by default 0, and the gradient by d."""
        x, F, h = np.zeros(len(x_bar)), self._free, self._held
        x[F], y = self._kkt.solve(x_bar[F], np.zeros(self.J.shape[0]) if y_bar is None else y_bar)
        by_d = self._weight * x
        by_d[h] = (x_bar - self._A @ x - self.J.T @ y)[h]
        return x, y, by_d
