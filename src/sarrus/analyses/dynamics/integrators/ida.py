"""SUNDIALS IDA (BDF of orders 1 to 5) on the stabilized index-2 equations: an independent check of the other methods.

Multipliers are the derivatives of unknowns Λ and Μ, λ = Λ', μ = Μ', which lowers the index to 1 (Gear 1988):

    q' = v - Φ_qᵀ Μ',    M v' = Q + S - Φ_qᵀ Λ',    Φ = 0,    Φ_q v + Φ_t = 0.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....algebra import Array
from ....linalg.factors import SingularSystem
from ....results import Assembly
from ....system import System
from ...equations.block_matrix import LEFT_OUT, UNIT, Numbers, Part, PlacedMatrix
from ...equations.motion import EquationsOfMotion
from ...equations.projection import Projection
from ...redundancy.redundant_constraints import Independence
from ..step_loop.crossing import Switching
from ..stepping.failures import redundant_rows, singular
from ..stepping.nodes import Nodes
from ..stepping.step_control import StepControl
from ..stepping.stepper import RunFailure, RunPart, Settings, Tally, independence_at, remember_start
from ..stepping.tolerance import FIRST, begin_motion, first_step
from .ode import PARTS

MATRICES = ("Phi_q", "Phi_qT_lam_q", "M", "M_a_q", "S_q", "S_v", "Q_q", "Q_v", "gamma_v")
UNMEASURED = 1e100  # tolerance of Λ and Μ, of which only the derivatives mean anything
LIMIT = 1_000_000  # steps between two outputs


@dataclass(frozen=True)
class IDA(StepControl):
    """IDA, the BDF solver of SUNDIALS, with exact Jacobians; needs the extra `ida` (scikit-sundae).

    Its options are those of `StepControl`.
    """

    def stepper(self, system: System, start: Assembly, settings: Settings) -> IDAStepper:
        """The method at work, see `Stepper`.

        Raises
        ------
        ImportError
            If scikit-sundae is not installed.
        """
        if settings.store_steps:
            raise ValueError(
                "method: IDA() stores no steps. Choose HHT(), GeneralizedAlpha(), Radau() or a description."
            )
        return IDAStepper(system, start, settings)


class IDAStepper(RunPart):
    """IDA at work on one system, see `Stepper`."""

    VARIABLES = ("tally",)  # IDA does not give access to its history
    apart = passes_kinks = has_history = False
    host = switched = None  # it keeps no matrix of the equations of motion for others

    def __init__(self, system: System, start: Assembly, settings: Settings) -> None:
        self.system, self.settings, self.t, self.tally = system, settings, start.t, Tally()
        self.independence = independence_at(system, start)
        self._equations = Equations(system, self.independence, start)
        self.b = self._equations.motion.b
        self._projection = Projection(system, self.b, self.independence.rows)
        self._solver: Any = None

    def end_at(self, switching: Switching) -> None:
        """Its steps end at no switches, see `Plan.free`."""

    def restart(self, t: float, q: Array, v: Array, until: float) -> None:
        """Begin at a consistent state."""
        self.t, self._q, self._v = t, q.copy(), v.copy()
        motion, nothing_yet = self._equations.motion, np.zeros(2 * self.system.m)
        try:
            a, lam = motion.acceleration(t, q, v)
        except SingularSystem:
            raise singular(t, redundant_rows(self.system, q, t, self.independence)) from None
        tolerance = self.settings.tolerances.for_loop()
        if (
            self.settings.tolerances.follow
        ):  # that of the first step: IDA's relative one takes over as the motion grows
            begin_motion(tolerance, self.system, t, q, until)
            first_step(motion, tolerance, FIRST, t, q, v, a, min(0.01 * (until - t), self.settings.max_step))
        self._solver = _solver(self._equations, self.settings, [tolerance.atol_q, tolerance.atol_v])
        rates = np.concatenate([v, a, lam, nothing_yet[self.system.m :]])
        self._solver.init_step(t, np.concatenate([q, v, nothing_yet]), rates)

    def advance(self, stop: float, limit: int) -> Nodes:
        """Take one step towards a time, see `Stepper`."""
        rows = [self._node(self.t, self._q, self._v)]
        step, before, nq = self._solver.step(stop, method="onestep", tstop=stop), self.t, self.system.nq
        if not step.success:
            raise RunFailure(
                "step too small", f"IDA gave up at t = {step.t:.6g} s: {step.message}. Take Radau()."
            )
        self.t = float(step.t)
        y = step.y.copy()
        times = self.settings.times[(self.settings.times > before) & (self.settings.times < self.t)]
        inner = np.linspace(before, self.t, PARTS + 1)[1:-1] if self.settings.dense else times[:0]
        wanted = np.union1d(times, inner)
        rows += [self._node(t, *self._at(t, self._solver.step(t).y[: 2 * nq])) for t in wanted]
        self._q, self._v = self._at(self.t, y[: 2 * nq])
        rows.append(self._node(self.t, self._q, self._v))
        self.system.remember(self._q, self.b, self.t)
        self.tally.add(1, 0, 0, 0, 0)
        self.tally.nfev = self._equations.evaluations
        self.tally.history.append(np.array([[self.t, self.t - before, np.nan, 0, 0]]))
        return Nodes._make(np.array(column) for column in zip(*rows, strict=True))

    def _at(self, t: float, y: Array) -> tuple[Array, Array]:
        """q and v on the constraints."""
        q, v = np.split(np.array(y), 2)
        return self._projection(float(t), q, v)

    def _node(self, t: float, q: Array, v: Array) -> tuple[Any, ...]:
        a, lam = self._equations.motion.acceleration(float(t), q, v)
        return float(t), q.copy(), v.copy(), a, lam, self.b[self.system.memory_places]

    def resume(self, state: Mapping[str, Array]) -> None:
        """There is no such state.

        Raises
        ------
        ValueError
            Always.
        """
        raise ValueError(
            "IDA: a saved run cannot be resumed, as its past steps are inside of IDA. Read it with load_run, or "
            "run it again with repeat."
        )

    def shorten(self, longest: float) -> None:
        """IDA chooses its steps; nothing asks for shorter ones, as they cannot be taken again."""

    def steps(self) -> None:
        """No steps are stored."""


def _solver(equations: Equations, settings: Settings, atol: list[Array]) -> Any:
    try:
        from sksundae.ida import IDA as Solver
    except ImportError:
        raise ImportError("IDA() needs scikit-sundae. Install it with: pip install 'sarrus[ida]'") from None
    m = equations.system.m
    tolerances, max_step = settings.tolerances, settings.max_step
    message: dict[str, Any] = {"max_num_steps": LIMIT, "max_step": 0.0 if np.isinf(max_step) else max_step}
    message["rtol"] = float(min(tolerances.rtol_q.min(), tolerances.rtol_v.min()))
    message["atol"] = np.concatenate([*atol, np.full(2 * m, UNMEASURED)])
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Custom sparse Jacobian approximation")
        sparse = {"linsolver": "sparse", "sparsity": equations.matrix.pattern()}
        return Solver(equations.residual, jacfn=equations.jacobian, **sparse, **message)


def matrix_parts(nq: int, m: int, holonomic: int) -> list[Part]:
    """Return the positions of operators in the matrix; (Φ_q v + Φ_t)_q is -½ γ_v.

    [ c W             -W             0     Φ_qᵀ] [ δq ]
    [ (...)_q          c M + (...)_v  Φ_qᵀ  0  ] [ δv ]
    [ Φ_q              0             0     0   ] [ δλ ]
    [ (Φ_q v + Φ_t)_q  Φ_q           0     0   ] [ δη ]

    Nonholonomic constraints, behind the `holonomic` ones, have Φ_q v in the third row and Μ = 0 in the last.
    """
    v, lam, mu = nq, 2 * nq, 2 * nq + m
    own = None if holonomic == m else (0, holonomic)
    found = [
        Part(UNIT, 0, 0),
        Part(UNIT, 0, v),
        Part("Phi_q", 0, mu, transposed=True),
        Part("Phi_q", v, lam, transposed=True),
        Part("M_a_q", v, 0),
        Part("Phi_qT_lam_q", v, 0),
        Part("S_q", v, 0),
        Part("Q_q", v, 0),
        Part("M", v, v),
        Part("S_v", v, v),
        Part("Q_v", v, v),
        Part("Phi_q", lam, 0, rows=own),
        Part("Phi_q", mu, v, rows=own),
        Part("gamma_v", mu, 0, rows=own),
        Part(LEFT_OUT, lam, lam),
        Part(LEFT_OUT, mu, mu, rows=own),
    ]
    if own:
        rest = holonomic, m
        found += [Part("Phi_q", lam, v, rows=rest), Part("Phi_q_xi_q", lam, 0, rows=rest)]
        found += [Part(UNIT, mu + holonomic, mu + holonomic, rows=(0, m - holonomic))]
    return found


class Equations:
    """F(t, y, y') = 0 for y = [q; v; Λ; Μ], and F_y + c F_y'."""

    def __init__(self, system: System, independence: Independence, start: Assembly) -> None:
        self.system, self.independence, self.evaluations = system, independence, 0
        self.motion = EquationsOfMotion(system, independence.rows)
        remember_start(system, start, self.motion.b)
        nq, m, holonomic = system.nq, system.m, system.m_holonomic
        self._turned = ("Phi_q_xi_q",) * (holonomic < m)
        self._numbers = Numbers(system, (*MATRICES, *self._turned, UNIT, LEFT_OUT))
        self.matrix = PlacedMatrix(self._numbers, 2 * (nq + m), matrix_parts(nq, m, holonomic))
        self._left_out = self._numbers.views[LEFT_OUT]
        if self.independence.rows is not None:
            self._left_out[:] = 1.0
            self._left_out[self.independence.rows] = 0.0
        self._row_of = self._numbers.row_of
        self._cut = np.cumsum([nq, nq, m])

    def residual(self, t: float, y: Array, rate: Array, out: Array) -> None:
        """[W (q' - v) + Φ_qᵀ Μ'; M v' + Φ_qᵀ Λ' - Q - S; Φ; Φ_q v + Φ_t]; Λ' and Μ' of equations left out are 0."""
        self.evaluations += 1
        system, b, stored = self.system, self.motion.b, 1.0 - self._left_out
        q, v, _, _ = np.split(y, self._cut)
        qd, a, lam, mu = (part.copy() for part in np.split(rate, self._cut))
        q, v = q.copy(), v.copy()
        first = self._numbers.views[UNIT] * (qd - v) + system.Phi_qT_lam(q, mu, t, b=b)
        second = system.M_a(q, a, b=b) + system.Phi_qT_lam(q, lam, t, b=b)
        second -= system.Q(q, v, t, b=b) + system.S(q, v, b=b)
        position, velocity = system.Phi(q, t, b=b), system.Phi_q_xi(q, v, t, b=b) + system.Phi_t(q, t, b=b)
        rolling = slice(system.m_holonomic, system.m)
        position[rolling] = velocity[rolling]
        third, fourth = np.where(stored > 0, position, lam), np.where(stored > 0, velocity, mu)
        fourth[rolling] = self._numbers.views[UNIT][: system.m - system.m_holonomic] * mu[rolling]
        out[:] = np.concatenate([first, second, third, fourth])

    def jacobian(self, t: float, y: Array, rate: Array, _: Array, c: float, out: Array) -> None:
        """The numbers of F_y + c F_y' by columns; (Φ_qᵀ Μ')_q is left out, Μ' being 0 on the solution."""
        q, v = (part.copy() for part in np.split(y, self._cut)[:2])
        _, a, lam, _ = (part.copy() for part in np.split(rate, self._cut))
        views, operands = self._numbers.views, {"t": t, "q": q, "v": v, "a": a, "lam": lam}
        operands["xi"] = v
        groups = (("Phi_q", "Phi_qT_lam_q"), ("M", "M_a_q", "S_q", "S_v"), ("Q_q", "Q_v"), ("gamma_v",))
        for names in (*groups, self._turned) if self._turned else groups:
            group = self.system.group(*names)
            group.run(self.motion.b, *(operands[k] for k in group.operands), *(views[name] for name in names))
        views["Phi_q"][self._left_out[self._row_of] > 0] = 0.0
        weights = [c, -1, c, c, 1, 1, -1, -1, c, -1, -1, 1, 1, -0.5, c, c]
        self.matrix.weights[:] = [*weights, 1, 1, c] if self._turned else weights
        out[:] = self.matrix.assembled()
