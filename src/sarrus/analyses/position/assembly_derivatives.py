"""Exact derivatives of assembled coordinates and velocities, by the implicit function theorem.

The conditions of least change,

    W (q - q₀) + Φ_qᵀλ = 0,         Φ(q, b) = 0,
    W (v - v₀) + Φ_qᵀμ + Cᵀν = 0,   Φ_q v = -Φ_t,  C v = rates,

with another W for velocities, differentiated along a direction of the numbers b and of the guess (q₀, v₀), or
transposed.
"""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

import numpy as np
from scipy.sparse import csr_array, vstack

from ...algebra import Array
from ...linalg.kkt import KKT, diagonal
from ...model import SarrusError
from ...results import Assembly
from ...system import System
from ...system.curves.curve_derivatives import CurveDerivatives
from ..equations.block_matrix import LEFT_OUT, Numbers, Part
from ..equations.joined_operators import CurveTerms, TwoSidedMatrix
from ..equations.nullspace import normalizations
from .metric_derivatives import MetricDerivatives
from .velocity import Rates

BENT, BENT_B = "Phi_qT_mu_q", "Phi_qT_mu_b"  # with the multipliers of the velocities
ROLLING = "Phi_q_xi_q"  # of nonholonomic constraints, along v
EVALUATED = (
    ("Phi_q", "Phi_qT_lam_q"),
    *((n,) for n in ("gamma_v", "Phi_qT_lam_b", "Phi_b", "Phi_q_xi_b", "Phi_t_b")),
)
NAMES = (LEFT_OUT, *(name for group in EVALUATED for name in group), BENT, BENT_B)
OPEN = 1e-8  # |Φ_q q' + Φ_b db| relative to |Φ_b db|, above which dependent equations contradict each other
LEAST = 1e-6  # |Φ_b db| below which it is taken for this
ROUND_OFF = 1e-12  # the same relative to the sizes of the terms of both
NOISE = 1e-9  # |Φ_b db| relative to the sizes of its terms, below which it is round-off


class NoDerivative(SarrusError, ArithmeticError):
    """Raised for a parameter without a derivative: its change makes the constraints contradict each other."""


class Adjoint(NamedTuple):
    """Gradients by the parameters, the guess, the joints' parameters and given rates; adjoint variables.

    x1 and y1 are those for q and Φ, x2 and y2 those for v and its rows; `guess` are the gradients by q₀ and v₀ in a
    constant metric.
    """

    b: Array
    q: Array
    v: Array
    c: Array
    x1: Array
    y1: Array
    x2: Array
    y2: Array
    guess: tuple[Array, Array]


class AssemblyDerivatives:
    """Derivatives of an assembled state with respect to parameters and to the initial estimate.

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
    The derivatives are those of a smooth branch: the nearest point is discontinuous where two points are equally near.
    The metric "unit" follows the model's dimensions; other metrics are constant.
    """

    further: ClassVar[tuple[str, ...]] = ()  # operators that the conditions on q contain besides
    lagrangian: ClassVar[str] = "place"  # whose second derivatives are those of the conditions on q

    def __init__(self, system: System, assembly: Assembly) -> None:
        if not assembly.success or not assembly.nearest or assembly.asked is None:
            raise ValueError(
                f"{system.name}: derivatives need a start that is assembled with the least change, but it is "
                f"{assembly.message}. Give a start closer to the assembled one, or farther from a dead centre."
            )
        system = system.with_memory(assembly.memory)
        self._system, self._assembly, self._request = system, assembly, assembly.asked
        self.rates = Rates(system, self._request.rates)
        self.metric = MetricDerivatives(system, assembly, self._request)
        numbers = self._evaluated()
        J = system.matrix("Phi_q", numbers.views["Phi_q"])
        self._position = self._position_block(numbers, J)
        request = self._request
        J = self.rates.below(J, assembly.q)
        self._velocity = Conditions(None, J, request.weight_v, request.held_velocities)
        self._join(numbers)

    def _position_block(self, numbers: Numbers, J: csr_array) -> Conditions:
        """The matrix of the conditions on q and λ."""
        weight, held = self._request.weight, self._request.held_positions
        A = diagonal(weight) + self._system.matrix("Phi_qT_lam_q", numbers.views["Phi_qT_lam_q"])
        return Conditions(A, J, weight, held, count=self._system.m_holonomic)

    def _evaluated(self) -> Numbers:
        """The numbers of all operators at the assembled state."""
        system, assembly = self._system, self._assembly
        rolling = (ROLLING,) * (system.m_holonomic < system.m)
        names = (*NAMES, *rolling, *self.further)
        numbers = Numbers(system, names, {BENT: "Phi_qT_lam_q", BENT_B: "Phi_qT_lam_b"})
        at = {"t": self._request.t, "q": assembly.q, "v": assembly.v, "xi": assembly.v, "lam": assembly.lam}
        for group in (*EVALUATED, *((name,) for name in rolling)):
            numbers.evaluate(group, system.b, at)
        for name, operator in ((BENT, "Phi_qT_lam_q"), (BENT_B, "Phi_qT_lam_b")):
            numbers.evaluate((operator,), system.b, at | {"lam": assembly.mu}, (name,))
        return numbers

    def _join(self, numbers: Numbers) -> None:
        """The right sides: of q and λ by the numbers, of v and μ by q and the numbers."""
        system, assembly, q = self._system, self._assembly, self._assembly.q
        nq, size, width = system.nq, system.nq + system.m, len(system.b)
        first = {Part("Phi_qT_lam_b", 0, 0): -1.0, Part("Phi_b", nq, 0): -1.0}
        first |= {Part(name, 0, 0): 1.0 for name in self.further if name.endswith("_b")}
        second = {Part(BENT, 0, 0): -1.0}
        count = system.m_holonomic  # of the equations with a Φ, of which γ_v = -2 (Φ_q v)_q - 2 Φ_tq
        second |= {Part("gamma_v", nq, 0, rows=(0, count)): 0.5}
        second |= {Part(ROLLING, nq, 0, rows=(count, system.m)): -1.0} if count < system.m else {}
        second |= {Part(BENT_B, 0, nq): -1.0, Part("Phi_q_xi_b", nq, nq): -1.0, Part("Phi_t_b", nq, nq): -1.0}
        curved = self._curved()
        self._first = TwoSidedMatrix(numbers, first, size, 0, width, curved[:-3])
        self._second = TwoSidedMatrix(numbers, second, size, nq, nq + width, curved[-3:])
        if self._request.rates:
            self._turned = self.rates.curvature(q, assembly.nu), self.rates.rows_xi_q(q, assembly.v)
            self._axes = self.rates.curvature_c(q, assembly.nu), self.rates.rows_xi_c(q, assembly.v)

    @property
    def system(self) -> System:
        """The system, with what its elements remember."""
        return self._system

    @property
    def rest(self) -> Array:
        """Velocities (nq,) in the conditions on q: none, but those that are first-order states."""
        return np.zeros(self._system.nq)

    def _curved(self) -> list[CurveTerms]:
        """The same by numbers of curves."""
        system, assembly, curves = self._system, self._assembly, CurveDerivatives(self._system)
        nq, m, now = system.nq, system.m, {"t": np.array([self._request.t]), "q": assembly.q[None]}
        if not curves:
            return []

        def part(name: str, row: int, height: int, sign: float = -1.0, **operands: Array) -> CurveTerms:
            return CurveTerms(sign, curves(name, system.b, {}, **now, **operands), row, height)

        xi = assembly.v[None]
        position = [part("Phi_qT_lam", 0, nq, lam=assembly.lam[None]), part("Phi", nq, m)]
        position += [part("Q", 0, nq, 1.0, v=self.rest[None])] * bool(self.further)
        velocity = [part("Phi_qT_lam", 0, nq, lam=assembly.mu[None]), part("Phi_q_xi", nq, m, xi=xi)]
        return [*position, *velocity, part("Phi_t", nq, m)]

    def along(self, db: Any = None, *, dq: Any = None, dv: Any = None, dc: Any = None) -> tuple[Array, Array]:
        """Return the derivative along a direction: q' and v' (nq,), or (nq, k) for k directions at once.

        Parameters
        ----------
        db : (len(system.b),) or (len(system.b), k) change of the numbers
        dq, dv : (nq,) or (nq, k) change of the guess `found.asked.q`, `found.asked.v`
        dc : change of the parameters of `system.joint_coordinates`, which given rates of joints depend on, and of
            these rates; more rows are of something else

        Raises
        ------
        NoDerivative
            If dependent equations would contradict each other.
        """
        q_dot, _, v_dot, _ = self.whole_along(db, dq=dq, dv=dv, dc=dc)
        return q_dot, v_dot

    def whole_along(
        self, db: Any = None, *, dq: Any = None, dv: Any = None, dc: Any = None
    ) -> tuple[Array, Array, Array, Array]:
        """Return the derivative as `along` does, with the multipliers: q', λ', v', and μ' followed by ν'."""
        db, dq, dv = self._directions(db, dq, dv)
        f1, g1 = self._parts(self._first @ db)
        q_dot, lam_dot = self._position.solve(f1, g1, dq + self.metric.along(db, dq)[0])
        gap = abs(self._position.J @ q_dot - g1)
        if gap.max(initial=0.0) > float(np.max(self._permitted(db, q_dot, g1))):
            row = self._system.row_names[self._widest(gap)]
            raise NoDerivative(
                f"{self._system.name}: such a change would open {row}, which repeats other equations. Change "
                "together what keeps them consistent."
            )
        q_dot, dv = self._with_states(q_dot, dv)
        v_dot, mu_dot = self._velocity_along(db, dq, dv, q_dot, dc)
        return q_dot, lam_dot, v_dot, mu_dot

    def _with_states(self, q_dot: Array, dv: Array) -> tuple[Array, Array]:
        """Changes of coordinates and of the velocities' estimate, from those of the unknowns of the conditions on q."""
        return q_dot, dv

    def _by_unknowns(self, q_bar: Array, by_v: Array) -> tuple[Array, Array]:
        """The transpose: gradients by these unknowns, and by an estimate that does not follow from them."""
        return q_bar, by_v

    def opens(self, db: Array) -> Array:
        """Return whether changes of the parameters (len(system.b), k) violate constraints at constant q, v (k,)."""
        moved = np.zeros(db.shape[1], dtype=bool)
        still = np.zeros((self._system.nq, db.shape[1]))
        for joined, direction in ((self._first, db), (self._second, np.concatenate([still, db]))):
            change, size = self._parts(joined @ direction)[1], self._parts(joined.sizes(direction))[1]
            moved |= np.any(abs(change) > NOISE * size, axis=0)
        return moved

    def _permitted(self, db: Array, q_dot: Array, g: Array) -> Array:
        """Return the permitted violation of equations for each direction."""
        sizes = self._parts(self._first.sizes(db))[1] + abs(self._position.J) @ abs(q_dot)
        opened = OPEN * np.maximum(abs(g).max(axis=0, initial=0.0), LEAST)
        return np.asarray(opened + ROUND_OFF * sizes.max(axis=0, initial=0.0))

    def unchecked_along(self, db: Array, *, dq: Array, dv: Array, dc: Array | None) -> tuple[Array, Array]:
        """Return the derivative as `along` does, without the check that equations do not contradict each other."""
        q_dot, _ = self._position.solve(*self._parts(self._first @ db), dq + self.metric.along(db, dq)[0])
        q_dot, dv = self._with_states(q_dot, dv)
        return q_dot, self._velocity_along(db, dq, dv, q_dot, dc)[0]

    def _widest(self, gap: Array) -> int:
        """The joint equation with the largest gap."""
        mark = normalizations(self._system)
        return int(np.argmax(np.where(mark, -1.0, gap.reshape(len(gap), -1).max(axis=1))))

    def _directions(self, *directions: Any) -> tuple[Array, Array, Array]:
        known = [np.asarray(x, dtype=float) for x in directions if x is not None]
        columns = known[0].shape[1:] if known else ()
        sizes = (len(self._system.b), self._system.nq, self._system.nq)
        arrays = [
            np.zeros((size, *columns)) if x is None else np.asarray(x, dtype=float)
            for x, size in zip(directions, sizes, strict=True)
        ]
        for x, size in zip(arrays, sizes, strict=True):
            if x.shape != (size, *columns):
                raise ValueError(
                    f"a direction must have shape {(size, *columns)}, got {x.shape}. Pass an array of this shape."
                )
        return arrays[0], arrays[1], arrays[2]

    def _velocity_along(
        self, db: Array, dq: Array, dv: Array, q_dot: Array, dc: Array | None = None
    ) -> tuple[Array, Array]:
        dv = dv + self.metric.along(db, q_dot if self._assembly.settled else dq)[1]
        f2, g2 = self._parts(self._second @ np.concatenate([q_dot, db]))
        if self._request.rates:
            curvature, rows = self._turned
            f2, g2 = f2 - curvature @ q_dot, np.concatenate([g2, -(rows @ q_dot)])
        if self._request.rates and dc is not None:
            axes, by_axes = self._axes
            m = self._system.m
            of_joints, rates, _ = np.split(dc, np.cumsum(axes.shape[1:] + by_axes.shape[:1]))
            f2, g2 = f2 - axes @ of_joints, np.concatenate([g2[:m], g2[m:] - by_axes @ of_joints + rates])
        return self._velocity.solve(f2, g2, dv)

    def _parts(self, both: Array) -> tuple[Array, Array]:
        """Return the parts of coordinates and of equations."""
        return both[: self._system.nq], both[self._system.nq :]

    def q_b(self, db: Any) -> Array:
        """Return q_b db, the change of q for a change of the parameters, (nq,) or (nq, k)."""
        return self.along(db)[0]

    def v_b(self, db: Any) -> Array:
        """Return v_b db, the change of v for a change of the parameters, (nq,) or (nq, k)."""
        return self.along(db)[1]

    def columns(self) -> tuple[Array, Array]:
        """Return the dense matrices q_b and v_b (nq, len(system.b)); columns are NaN where `along` raises an error."""
        db = np.eye(len(self._system.b))
        f1, g1 = self._parts(self._first @ db)
        none = np.zeros((self._system.nq, len(db)))
        q_b, _ = self._position.solve(f1, g1, self.metric.along(db, none)[0])
        opened = abs(self._position.J @ q_b - g1).max(axis=0) > self._permitted(db, q_b, g1)
        q_b, dv = self._with_states(q_b, none)
        v_b, _ = self._velocity_along(db, none, dv, q_b)
        q_b[:, opened] = v_b[:, opened] = np.nan
        return q_b, v_b

    def gradient(self, q_bar: Any, v_bar: Any) -> tuple[Array, Array, Array]:
        """Return the gradients with respect to b, q₀ and v₀ of a function of (q, v), by the transposed product.

        Parameters
        ----------
        q_bar, v_bar : (nq,) gradients by the assembled q and v

        Returns
        -------
        by_b : (len(system.b),)
        by_q, by_v : (nq,) by the guess
        """
        adjoint = self.adjoint(q_bar, v_bar)
        return adjoint.b, adjoint.q, adjoint.v

    def adjoint(
        self, q_bar: Any, v_bar: Any, change: tuple[Array, Array, Array, Array] | None = None
    ) -> Adjoint:
        """Return gradients with adjoint variables; `change` is subtracted from the right sides of q, λ, v and μ."""
        m, nq = self._system.m, self._system.nq
        c_q, c_lam, c_v, c_mu = change or (0.0, np.zeros(m), 0.0, np.zeros(m + len(self._request.rates)))
        x2, y2, by_v = self._velocity.transposed(np.asarray(v_bar, dtype=float) - c_v, -c_mu)
        second = self._second.transposed(np.concatenate([x2, y2[:m]]))
        through = np.asarray(q_bar, dtype=float) + second[:nq]
        if self._request.rates:
            curvature, rows = self._turned
            through = through - curvature @ x2 - rows.T @ y2[m:]
        through, by_v = self._by_unknowns(through, by_v)
        if self._assembly.settled:
            through = through + self.metric.gradient(np.zeros(nq), by_v)[1]
        x1, y1, by_q = self._position.transposed(through - c_q, -c_lam)
        metric_b, metric_q = self.metric.gradient(by_q, by_v)
        by_b = self._first.transposed(np.concatenate([x1, y1])) + second[nq:] + metric_b
        by_c = np.zeros(len(self._system.joint_coordinates.b))
        if self._request.rates:
            axes, by_axes = self._axes
            by_c = np.concatenate([-(axes.T @ x2) - by_axes.T @ y2[m:], y2[m:]])
        return Adjoint(
            by_b,
            by_q if self._assembly.settled else by_q + metric_q,
            by_v,
            by_c,
            x1,
            y1,
            x2,
            y2,
            (by_q, by_v),
        )


class Conditions:
    """A x + Jᵀy = W d + f, J x = g for the free coordinates; those that are held follow the guess, x = d.

    Parameters
    ----------
    A : (nq, nq), W itself, or None for the same
    J : (m, nq)
    weight : (nq,) the diagonal of the metric
    W : (nq,) diagonal, by default the metric; zeros where the guess has no influence
    held : (nq,) which coordinates are
    count : of the equations; the others are empty, and their multipliers zero
    """

    def __init__(
        self,
        A: csr_array | None,
        J: csr_array,
        weight: Array,
        held: Array,
        *,
        W: Array | None = None,
        count: int | None = None,
    ) -> None:
        self._count, self._others = count, J.shape[0] - (J.shape[0] if count is None else count)
        own = csr_array(J[:count]) if self._others else J
        self.J = csr_array(vstack([own, csr_array((self._others, J.shape[1]))])) if self._others else J
        self._free, self._held = np.flatnonzero(~held), np.flatnonzero(held)
        self._W, free, every = weight if W is None else W, self._free, not len(self._held)
        self._A: Any = diagonal(weight) if A is None else A
        inside = None if A is None else A if every else csr_array(A[free][:, free])
        self._kkt = KKT(inside, own if every else csr_array(own[:, free]), weight[free])

    def solve(self, f: Array, g: Array, d: Array) -> tuple[Array, Array]:
        """The unknowns and multipliers for right sides and a change of the guess."""
        x, F, h = np.zeros(d.shape), self._free, self._held
        x[h] = d[h]
        right = f + (self._W * d.T).T - self._A @ x
        x[F], y = self._kkt.solve(right[F], (g - self.J @ x)[: self._count])
        return x, self._whole(y)

    def transposed(self, x_bar: Array, y_bar: Array | None = None) -> tuple[Array, Array, Array]:
        """The solution (x, y) with Aᵀ for the right sides x_bar and y_bar, by default 0, and the gradient by d."""
        x, F, h = np.zeros(len(x_bar)), self._free, self._held
        none = np.zeros(self.J.shape[0])
        x[F], y = self._kkt.solve_transposed(x_bar[F], (none if y_bar is None else y_bar)[: self._count])
        y, by_d = self._whole(y), self._W * x
        if len(h):
            by_d[h] = (x_bar - self._A.T @ x - self.J.T @ y)[h]
        return x, y, by_d

    def _whole(self, y: Array) -> Array:
        return np.concatenate([y, np.zeros((self._others, *y.shape[1:]))]) if self._others else y
