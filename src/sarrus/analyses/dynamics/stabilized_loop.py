"""One step of the generalized-α method on the stabilized index-2 equations (Gear, Gupta and Leimkuhler 1985), compiled.

As in `alpha_loop`, but both constraints hold at the end of a step (Arnold, Brüls and Cardona 2015):

    q₁ = q₀ + h v₀ + h² ((½ - β) ã₀ + β ã₁) - Φ_q(q₀)ᵀ η,    Φ(q₁) = 0,    Φ_q(q₁) v₁ + Φ_t = 0.

Unknowns are a₁, λ₁, η₁ and the shift s₁ of q₁ from what ã gives, which converges to -Φ_q(q₀)ᵀ η₁: with it the matrix
stays sparse, see `stabilized_matrix`. η and s are as small as the local error, h³.

What is not defined here (`advance`, `newton`, ...) is that of `alpha_loop`, compiled with these functions.
"""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.link import compiled
from ..._jit.pointer import Entry, call_kernels
from ...algebra import Array
from ..equations.block_matrix import Placed, backsolve, leave_out, refactor
from .alpha_loop import Control, Record, Scheme, Tolerance, size, stretch
from .alpha_loop import accept as plain_accept
from .alpha_loop import keep as plain_keep
from .alpha_loop import predict as plain_predict
from .alpha_loop import residual as plain_residual
from .alpha_loop import update as plain_update
from .radau_loop import evaluate
from .stabilized_matrix import weigh


class State(NamedTuple):
    """`alpha_loop.State`, with the multipliers η and the shift s of q at the start and the end of a step."""

    q0: Array
    v0: Array
    a0: Array
    x0: Array
    lam0: Array
    q1: Array
    v1: Array
    a1: Array
    x1: Array
    lam1: Array
    a_change: Array
    lam_change: Array
    eta0: Array
    eta1: Array
    shift0: Array
    shift1: Array


class Memory(NamedTuple):
    """`alpha_loop.Memory`, with Φ_q(q₀)ᵀη; `right` is of the index-3 equations, `whole` and `solution` of all."""

    Phi: Array
    Phi_qT_lam: Array
    M_a: Array
    S: Array
    Q: Array
    rate: Array
    Phi_t: Array
    right: Array
    solution: Array
    previous: Array
    noise: Array
    correction: Array
    Phi_qT_eta: Array
    whole: Array


class Matrix(NamedTuple):
    """The numbers of all operators, Φ_q at the start of the step among them; q there; the matrix and its factors."""

    values: Array
    Phi_q: Array
    Phi_qT_lam_q: Array
    M: Array
    M_a_q: Array
    S_q: Array
    S_v: Array
    Q_q: Array
    Q_v: Array
    gamma_v: Array
    Phi_q_start: Array
    q0: Array
    row_of: Array
    left_out: Array
    placed: Placed


class Entries(NamedTuple):
    """The kernels of the groups of operators, see `_jit.pointer`."""

    residual: Entry
    momentum: Entry
    force: Entry
    jacobian: Entry
    inertia: Entry
    stiffness: Entry
    velocity: Entry
    turning: Entry
    remember: Entry


@compiled
def update(scheme: Scheme, h: float, state: State) -> None:
    """q₁, v₁, ã₁ of a₁ and s₁."""
    plain_update(scheme, h, state)  # type: ignore[arg-type]
    for k in range(len(state.q1)):
        state.q1[k] += state.shift1[k]


@compiled
def residual(
    entries: Entries, b: Array, t: float, state: State, memory: Memory, left_out: Array, beta: float,
    ignored: float,
) -> None:  # fmt: skip
    """[M a + Φ_qᵀλ - Q - S; Φ / β'] at the end of the step, Φ_q v and Φ_t there, and Φ_q(q₀)ᵀη."""
    plain_residual(entries, b, t, state, memory, left_out, beta, ignored)  # type: ignore[arg-type]
    call_kernels(entries.velocity, b, t, state.q1, state.v1, memory.rate, memory.Phi_t)
    call_kernels(entries.residual, b, t, state.q0, state.eta1, memory.Phi, memory.Phi_qT_eta)


@compiled
def factor(
    entries: Entries, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array, matrix: Matrix, beta: float,
    gamma: float,
) -> float:  # fmt: skip
    """Evaluate, assemble and factor the Newton matrix; returns how far the pivots can be trusted."""
    call_kernels(entries.jacobian, b, t, matrix.q0, lam, matrix.Phi_q_start, matrix.Phi_qT_lam_q)
    evaluate(entries, b, t, q, v, a, lam, matrix)  # type: ignore[arg-type]
    leave_out(matrix.Phi_q_start, matrix.row_of, matrix.left_out)
    weigh(matrix.placed.weights, beta, gamma)
    return refactor(matrix.values, matrix.placed)


@compiled
def scaled(state: State, memory: Memory, left_out: Array, beta: float, gamma: float) -> None:
    """The right side of a Newton step, its rows scaled as those of the matrix."""
    n, m, whole = len(state.q0), len(left_out), memory.whole
    for k in range(n):
        whole[k] = state.shift1[k] + memory.Phi_qT_eta[k]
        whole[n + k] = beta * memory.right[k]
    for k in range(m):
        whole[2 * n + k] = beta * memory.right[n + k]
        rate = beta / gamma * (memory.rate[k] + memory.Phi_t[k])
        whole[2 * n + m + k] = rate if left_out[k] == 0.0 else state.eta1[k]


@compiled
def correct(
    scheme: Scheme, h: float, state: State, memory: Memory, matrix: Matrix, beta: float, gamma: float,
    tol: Tolerance,
) -> float:  # fmt: skip
    """One correction of a₁, λ₁, η₁ and s₁ by the residual and the factors at hand; returns its size."""
    n, m, change = len(state.q0), len(state.lam0), memory.solution
    scaled(state, memory, matrix.left_out, beta, gamma)
    backsolve(matrix.placed, memory.whole, change)
    for k in range(n):
        state.shift1[k] -= change[k] - change[n + k]
        state.a1[k] -= change[n + k] / beta
    for k in range(m):
        state.lam1[k] -= change[2 * n + k] / beta
        state.eta1[k] -= change[2 * n + m + k]
    update(scheme, h, state)
    in_q = size(change, 1.0, state.q0, state.q1, tol.rtol_q, tol.atol_q)
    in_v = size(change[n:], gamma / beta, state.v0, state.v1, tol.rtol_v, tol.atol_v)
    return max(in_q, in_v)


@compiled
def multiplier_change(state: State, memory: Memory, beta: float) -> float:
    """The largest change of a multiplier by the last correction."""
    change = 0.0
    for k in range(len(state.lam1)):
        change = max(change, abs(memory.solution[2 * len(state.q0) + k]) / beta)
    return change


@compiled
def predict(ratio: float, state: State) -> None:
    """First guess of the unknowns; η and s go with h³."""
    plain_predict(ratio, state)  # type: ignore[arg-type]
    for k in range(len(state.eta0)):
        state.eta1[k] = ratio**3 * state.eta0[k]
    for k in range(len(state.shift0)):
        state.shift1[k] = ratio**3 * state.shift0[k]


@compiled
def accept(state: State) -> None:
    """The end of the step is the start of the next."""
    plain_accept(state)  # type: ignore[arg-type]
    for k in range(len(state.eta0)):
        state.eta0[k] = state.eta1[k]
    for k in range(len(state.shift0)):
        state.shift0[k] = state.shift1[k]


@compiled
def rescale(
    entries: Entries, b: Array, t: float, ratio: float, state: State, memory: Memory, matrix: Matrix,
    control: Control,
) -> None:  # fmt: skip
    """A new step size; velocities satisfy their constraints, so that none of their defect is removed."""
    stretch(ratio, state)  # type: ignore[arg-type]
    control.beta = 0.0


@compiled
def keep(
    record: Record, row: int, t: float, h: float, state: State, memory: Memory, control: Control
) -> None:
    """Write an accepted step into the record."""
    plain_keep(record, row, t, h, state, memory, control)  # type: ignore[arg-type]
    for k in range(len(state.eta1) if len(record.eta) > 0 else 0):
        record.eta[row, k] = state.eta1[k]
