"""The equations of a step, their matrix, and corrections of the unknowns."""

from __future__ import annotations

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array
from ...equations.block_matrix import backsolve, refactor
from ...equations.paired_matrix import renew_pairs, solve_stages
from ..methods.program import CHANGE, EQUATIONS, MOMENTUM, OF_EQUATIONS, RESIDUAL, STAGES, VELOCITY, Program
from ..methods.tables import GAMMA_Q_V, INERTIA, JACOBIAN, STIFFNESS
from ..stepping.motion_scale import Tolerance
from .coefficients import apply
from .records import Control, Entries, Matrix, Memory, State

TRUSTED = 1e-9  # pivot over column, below which the order of the pivots is chosen anew


@compiled
def call_operators(
    calls: Array, times: Array, entries: Entries, b: Array, t: float, h: float, x: Array
) -> None:
    """The operators in the equations of all stages of a step that ends at t. Outputs are cleared as far as they go."""
    for n in range(len(calls)):
        row = calls[n]
        group, time = row[0], t + (times[row[1]] - 1.0) * h
        first, last = entries.bounds[group], entries.bounds[group + 1]
        kernels = KernelTable(entries.addresses[first:last], entries.starts[first : last + 1], entries.tables)
        q, second, third, out, other = (
            x[row[2] :],
            x[row[3] :],
            x[row[4] :],
            x[row[5] : row[6]],
            x[row[7] : row[8]],
        )
        if group in (RESIDUAL, VELOCITY):
            call_kernels(kernels, b, time, q, second, out, other)
        elif group == MOMENTUM:
            call_kernels(kernels, b, q, second, third, out, other)
        else:
            call_kernels(kernels, b, time, q, second, out)


@compiled
def residual(
    program: Program, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory, left_out: Array,
    ignored: float,
) -> None:  # fmt: skip
    """All equations of a step, scaled.

    `ignored` times the round-off of Φ is left out: in very short steps its scale would make accelerations of it.
    """
    x, right = state.x, memory.right
    call_operators(program.calls, program.times, entries, b, t, h, x)
    for n in range(len(program.rates)):
        of, to = program.rates[n, 0], program.rates[n, 1]
        for k in range(len(memory.unit)):
            x[to + k] = memory.unit[k] * x[of + k]
    apply(program, EQUATIONS, state)
    for n in range(len(program.positions) if ignored > 0.0 else 0):
        row, factor = program.positions[n, 0], ignored * abs(state.r[program.positions[n, 1]])
        for k in range(len(memory.noise)):
            gap, noise = right[row + k], factor * memory.noise[k]
            right[row + k] = gap - noise if gap > noise else (gap + noise if gap < -noise else 0.0)
    for n in range(len(program.multipliers)):
        row, of, solved = program.multipliers[n, 0], program.multipliers[n, 1], program.multipliers[n, 2]
        for k in range(len(left_out)):
            if left_out[k] != 0.0 or k >= solved:
                right[row + k] = x[of + k]


@compiled(entry=True)
def evaluate(
    program: Program, entries: Entries, b: Array, t: float, h: float, x: Array, values: Array, left_out: Array
) -> None:
    """The operators of the matrix, at all stages of a step that ends at t."""
    for n in range(len(program.operators)):
        row = program.operators[n]
        group, time = row[0], t + (program.times[row[1]] - 1.0) * h
        first, last = entries.bounds[OF_EQUATIONS + group], entries.bounds[OF_EQUATIONS + group + 1]
        kernels = KernelTable(entries.addresses[first:last], entries.starts[first : last + 1], entries.tables)
        q, second, third = x[row[2] :], x[row[3] :], x[row[4] :]
        one, two = values[row[5] : row[6]], values[row[7] : row[8]]
        if group == INERTIA:
            three, four = values[row[9] : row[10]], values[row[11] : row[12]]
            call_kernels(kernels, b, q, second, third, one, two, three, four)
        elif group in (JACOBIAN, STIFFNESS, GAMMA_Q_V):
            call_kernels(kernels, b, time, q, second, one, two)
        else:
            call_kernels(kernels, b, time, q, second, one)
    for n in range(len(program.constrained) if left_out.any() else 0):
        values[program.constrained[n, 0]] *= 1.0 - left_out[program.constrained[n, 1]]


@compiled
def renew(
    program: Program,
    entries: Entries,
    b: Array,
    t: float,
    h: float,
    state: State,
    matrix: Matrix,
    control: Control,
) -> bool:
    """Factor the matrix of the step as it is now; false if pivots must be renewed."""
    control.matrices += 1
    evaluate(program, entries, b, t, h, state.x, matrix.values, matrix.left_out)
    if not factored(program, matrix):
        return False
    control.factored_h = h
    return True


@compiled
def factored(program: Program, matrix: Matrix) -> bool:
    """Factor the matrix of its values, or both of them where stages are split; false if pivots must be renewed."""
    if len(program.T) > 0:
        return renew_pairs(matrix.values, matrix.pair) > TRUSTED
    return refactor(matrix.values, matrix.placed) > TRUSTED


@compiled
def size(change: Array, factor: float, q0: Array, q1: Array, rtol: Array, atol: Array) -> float:
    """Root mean square of factor x change, each entry over its tolerance."""
    total = 0.0
    for k in range(len(q0)):
        entry = factor * change[k] / (atol[k] + rtol[k] * max(abs(q0[k]), abs(q1[k])))
        total += entry * entry
    return float((total / len(q0)) ** 0.5)


@compiled
def correct(program: Program, state: State, memory: Memory, matrix: Matrix, tol: Tolerance) -> float:
    """One correction of the unknowns by the residual and the factors at hand; returns its size."""
    x = state.x
    if len(program.T) > 0:
        solve_stages(program.T, program.T_inverse, matrix.pair, memory.right, memory.solution)
    else:
        backsolve(matrix.placed, memory.right, memory.solution)
    unknowns, change = (
        x[program.unknowns : program.unknowns + program.n],
        x[program.change : program.change + program.n],
    )
    for k in range(len(unknowns)):
        unknowns[k] -= memory.solution[k]
        change[k] = memory.solution[k]
    apply(program, STAGES, state)
    return size_of_change(program, state, tol)


@compiled
def size_of_change(program: Program, state: State, tol: Tolerance) -> float:
    """The size of changes of q₁ and v₁ by those of the unknowns."""
    n, x, first = len(state.q0), state.x, program.moved
    apply(program, CHANGE, state)
    in_q = size(x[first : first + n], 1.0, state.q0, state.q1, tol.rtol_q, tol.atol_q)
    in_v = size(x[first + n : first + 2 * n], 1.0, state.v0, state.v1, tol.rtol_v, tol.atol_v)
    return max(in_q, in_v) + 0.0 * in_v  # max may hide what is not a number
