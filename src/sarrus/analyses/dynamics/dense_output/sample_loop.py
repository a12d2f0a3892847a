"""States between the steps of a method, made consistent: one function that is compiled.

A motion is interpolated in time through q, v and a at the ends of steps (`nodes`). What is given out lies on the
constraints, Φ = 0 and Φ_q v = -Φ_t, by the least changes in the metric of M, and its accelerations and multipliers
solve the equations of motion there: M a + Φ_qᵀλ = Q + S, Φ_q a = γ. All three need the factors of [M Φ_qᵀ; Φ_q 0].

Within a step, the projected q and v are smooth functions of time. Where a step contains many outputs, the projected
states at a few points of the step are interpolated, and each output where that satisfies the constraints to the
tolerance of the projection needs no factors for q and v.
"""

from __future__ import annotations

from typing import NamedTuple

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array
from ...equations.block_matrix import Assembler, backsolve, leave_out, refactor
from ...equations.minimum_norm import Omissions, gradient, shorten
from ..stepping.nodes import Nodes, between

PROJECTIONS, PROJECTED = 25, 1e-13  # most iterations, and where they end, of the length or the largest rate
INFINITE, TINY = 1e300, 1e-300
WARM = 8  # iterations for the weakest combination at the first state
DONE, CHANGED, UNDONE = 0, 1, 2
# Defects after whose removal only round-off is left, as Newton's method converges quadratically
QUADRATIC = 1e-7
ROUND = 1e-11  # of the largest coordinate, or of the length: defects below it may be round-off
LEFT = 1e-9  # of the largest velocity: a defect that may stay behind a change, if the next one is not trusted
MAGNIFIED, SLIGHT = 1e4, 1e-6  # change of v over the defect, and relative to v: above both it is not trusted
REFINEMENTS, REFINED = 6, 1e-13  # of a and λ: most, and where they end, relative to their size
POINTS = 7  # of a step with many outputs: their polynomials contain those of the step, which are of degree five at most
TRUSTED = 1e-12  # pivot over column, below which the order of the pivots is chosen anew


class Entries(NamedTuple):
    """The kernels of the groups of operators, see `_jit.kernels.pointer`."""

    inertia: KernelTable
    jacobian: KernelTable
    residual: KernelTable
    velocity: KernelTable
    momentum: KernelTable
    force: KernelTable
    gamma: KernelTable
    potential: KernelTable
    remember: KernelTable


class Work(NamedTuple):
    """Operators' outputs and work arrays.

    weak : the combination of equations that is closest to vanishing
    is_length : which coordinates of bodies are displacements; those of blocks of states are behind them
    """

    Phi: Array
    Phi_qT_lam: Array
    M_a: Array
    S: Array
    Q: Array
    rate: Array
    Phi_t: Array
    gamma: Array
    right: Array
    solution: Array
    potential: Array
    memory: Array
    weak: Array
    is_length: Array


class Matrix(NamedTuple):
    """The numbers of the operators; the matrix [M Φ_qᵀ; Φ_q 0] and its factors."""

    values: Array
    M: Array
    Phi_q: Array
    row_of: Array
    left_out: Array
    placed: Assembler


class MotionSolver(NamedTuple):
    """The equations of motion at a state: their kernels, their matrix, and work arrays."""

    entries: Entries
    matrix: Matrix
    work: Work


class Samples(NamedTuple):
    """Requested times, and buffers for the states there.

    violation : largest |Φ|, |Φ_q v + Φ_t|
    energy : kinetic, potential
    growth : see `growth_of`; infinite where the state could not be settled
    memory : what elements remember of the last step before
    revolutions : of the joints' angles, see `Winding`
    """

    t: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    violation: Array
    energy: Array
    growth: Array
    memory: Array
    revolutions: Array


@compiled
def interpolate(nodes: Nodes, row: int, apart: bool, out: Samples, n: int, place: int) -> None:
    """The state at out.t[n] between the nodes `row` and `row + 1`, see `nodes.between`; a and linear λ as `place`."""
    h = nodes.t[row + 1] - nodes.t[row]
    s = (out.t[n] - nodes.t[row]) / h
    between(nodes.q[row], nodes.v[row], nodes.a[row], nodes.q[row + 1], nodes.v[row + 1], nodes.a[row + 1],
            s, h, apart, out.q[n], out.v[n], out.a[place])  # fmt: skip
    for k in range(nodes.lam.shape[1]):
        out.lam[place, k] = (1.0 - s) * nodes.lam[row, k] + s * nodes.lam[row + 1, k]


@compiled
def interpolate_points(points: Samples, first: int, out: Samples, n: int) -> None:
    """q and v at out.t[n] by the polynomials through POINTS states from `first` on, at Chebyshev's points of a step.

    By the second barycentric formula, J.-P. Berrut and L. N. Trefethen, SIAM Review 46 (2004), equation (5.4).
    """
    total = 0.0
    for k in range(points.q.shape[1]):
        out.q[n, k] = out.v[n, k] = 0.0
    for j in range(POINTS):
        away = out.t[n] - points.t[first + j]
        weight = (-1.0) ** j if 0 < j < POINTS - 1 else 0.5 * (-1.0) ** j
        if away == 0.0:
            for k in range(points.q.shape[1]):
                out.q[n, k], out.v[n, k] = points.q[first + j, k], points.v[first + j, k]
            return
        total += weight / away
        for k in range(points.q.shape[1]):
            out.q[n, k] += weight / away * points.q[first + j, k]
            out.v[n, k] += weight / away * points.v[first + j, k]
    for k in range(points.q.shape[1]):
        out.q[n, k] /= total
        out.v[n, k] /= total


@compiled
def factor(entries: Entries, b: Array, t: float, q: Array, matrix: Matrix) -> float:
    """Evaluate and factor [M Φ_qᵀ; Φ_q 0]; returns how far the pivots can be trusted."""
    call_kernels(entries.inertia, b, q, matrix.M)
    call_kernels(entries.jacobian, b, t, q, matrix.Phi_q)
    leave_out(matrix.Phi_q, matrix.row_of, matrix.left_out)
    return refactor(matrix.values, matrix.placed)


@compiled
def position_defect(entries: Entries, b: Array, t: float, q: Array, lam: Array, work: Work) -> None:
    """Φ, as `work.rate`."""
    call_kernels(entries.residual, b, t, q, lam, work.Phi, work.Phi_qT_lam)
    for k in range(len(work.Phi)):
        work.rate[k] = work.Phi[k]


@compiled
def velocity_defect(entries: Entries, b: Array, t: float, q: Array, v: Array, work: Work) -> None:
    """Φ_q v + Φ_t, as `work.rate`."""
    call_kernels(entries.velocity, b, t, q, v, work.rate, work.Phi_t)
    for k in range(len(work.rate)):
        work.rate[k] += work.Phi_t[k]


@compiled
def length_of(placed: Assembler) -> float:
    """The length by which displacements are measured where pivots are chosen [m]."""
    return float(placed.scale[placed.row_place[0]] / placed.scale[placed.row_place[3]])


@compiled
def size_of(x: Array, is_length: Array, length: float) -> float:
    """The largest of the first entries: displacements, in parts of a length, and Euler parameters; or their rates."""
    largest = 0.0
    for k in range(len(is_length)):
        largest = max(largest, abs(x[k]) / length if is_length[k] else abs(x[k]))
    return largest


@compiled
def largest_defect(n: int, work: Work, matrix: Matrix, violation: Array, kind: int) -> float:
    """The largest defect of the equations that are solved, scaled; `violation` of this kind receives that of all."""
    every, worst, placed = 0.0, 0.0, matrix.placed
    for k in range(len(work.rate)):
        stored = placed.scale[placed.row_place[n + k]] * work.rate[k] * (1.0 - matrix.left_out[k])
        every, worst = max(every, abs(work.rate[k])), max(worst, abs(stored))
    violation[kind] = every
    return worst


@compiled
def correct(
    x: Array, before: float, least: float, work: Work, matrix: Matrix, violation: Array, kind: int
) -> tuple[float, int]:
    """Take the least change that removes the defect from x. Returns the largest defect, scaled, and what was done.

    Nothing is DONE if the defect is small against `least`, or not half of what it was `before`. If it is no round-off
    of x or `least` either, the change before has not helped and is UNDONE. `violation` of this kind receives the
    defect as it is.
    """
    n, placed = len(x), matrix.placed
    worst = largest_defect(n, work, matrix, violation, kind)
    size = max(least, size_of(x, work.is_length, length_of(placed)))
    if worst <= PROJECTED * least or (not worst < 0.5 * before and worst < ROUND * size):
        return worst, DONE
    if not worst < 0.5 * before:
        for k in range(n):
            x[k] += work.solution[k]
        return worst, UNDONE
    for k in range(n):
        work.right[k] = 0.0
    for k in range(len(work.rate)):
        work.right[n + k] = work.rate[k] * (1.0 - matrix.left_out[k])
    backsolve(placed, work.right, work.solution)
    for k in range(n):
        x[k] -= work.solution[k]
    return worst, CHANGED


@compiled
def consistent(
    motion: MotionSolver, b: Array, t: float, q: Array, v: Array, lam: Array, violation: Array
) -> bool:
    """Whether `project` would not change the state; `violation` receives the largest defects."""
    entries, matrix, work = motion
    position_defect(entries, b, t, q, lam, work)
    if not largest_defect(len(q), work, matrix, violation, 0) <= PROJECTED:
        return False
    velocity_defect(entries, b, t, q, v, work)
    fastest = max(TINY, size_of(v, work.is_length, length_of(matrix.placed)))
    return largest_defect(len(q), work, matrix, violation, 1) <= PROJECTED * fastest


@compiled
def sensible(v: Array, defect: float, work: Work, length: float) -> bool:
    """Whether the change of the velocities just made is no round-off that a nearly singular matrix has magnified."""
    moved = size_of(work.solution, work.is_length, length)
    return moved < MAGNIFIED * defect or moved < SLIGHT * (size_of(v, work.is_length, length) + moved)


@compiled
def project(
    motion: MotionSolver, b: Array, t: float, q: Array, v: Array, lam: Array, violation: Array, measured: bool
) -> bool:
    """q onto Φ = 0, then v onto Φ_q v = -Φ_t; `violation` receives the largest remaining entries, if `measured`.

    Defects of v are relative to its largest value so far: at rest, v is round-off, of which the first change leaves
    1e-16, and Φ_q v = -Φ_t need not hold to 1e-13 of that. What the first change leaves is not removed where that would
    magnify its round-off.

    Returns false where constraints are so nearly redundant that the state would become less
    accurate than before.
    """
    entries, matrix, work = motion
    before = 1e30
    for _ in range(PROJECTIONS):
        position_defect(entries, b, t, q, lam, work)
        before, done = correct(q, before, 1.0, work, matrix, violation, 0)
        if done == UNDONE:
            return False
        if done == DONE or (before < QUADRATIC and not measured):
            break
    before, fastest, length, first = INFINITE, TINY, length_of(matrix.placed), True
    for _ in range(PROJECTIONS):
        velocity_defect(entries, b, t, q, v, work)
        fastest = max(fastest, size_of(v, work.is_length, length))
        before, done = correct(v, before, fastest, work, matrix, violation, 1)
        if done == UNDONE:
            return False
        if done == DONE:
            break
        if not sensible(v, before, work, length):
            if first or before > LEFT * fastest:
                return False
            for k in range(len(v)):
                v[k] += work.solution[k]
            break
        if before < QUADRATIC * fastest and not measured:
            break
        first = False
    return True


@compiled
def solve_motion(
    motion: MotionSolver, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array, rounds: int
) -> None:
    """a and λ of the equations of motion by the guess that is there, refined in all rounds but the first."""
    entries, matrix, work = motion
    n, placed = len(q), matrix.placed
    call_kernels(entries.force, b, t, q, v, work.Q)
    call_kernels(entries.gamma, b, t, q, v, work.gamma)
    before = INFINITE
    for _ in range(rounds):
        call_kernels(entries.momentum, b, q, v, a, work.M_a, work.S)
        call_kernels(entries.residual, b, t, q, lam, work.Phi, work.Phi_qT_lam)
        call_kernels(entries.velocity, b, t, q, a, work.rate, work.Phi_t)
        for k in range(n):
            work.right[k] = work.M_a[k] + work.Phi_qT_lam[k] - work.Q[k] - work.S[k]
        for k in range(len(lam)):
            defect = work.rate[k] - work.gamma[k]
            work.right[n + k] = defect if matrix.left_out[k] == 0.0 else lam[k]
        backsolve(placed, work.right, work.solution)
        for k in range(n):
            a[k] -= work.solution[k]
        length = length_of(placed)
        change = size_of(work.solution, work.is_length, length) / max(
            size_of(a, work.is_length, length), TINY
        )
        pulled, force = 0.0, TINY
        for k in range(len(lam)):
            lam[k] -= work.solution[n + k]
            unit = placed.scale[placed.row_place[n + k]]
            pulled, force = max(pulled, abs(work.solution[n + k]) / unit), max(force, abs(lam[k]) / unit)
        change = max(change, pulled / force)
        if change <= REFINED or not change < 0.1 * before:
            return
        before = change


@compiled
def energies(entries: Entries, b: Array, t: float, q: Array, v: Array, work: Work, energy: Array) -> None:
    """Kinetic and potential."""
    call_kernels(entries.momentum, b, q, v, v, work.M_a, work.S)
    total = 0.0
    for k in range(len(work.is_length)):
        total += 0.5 * v[k] * work.M_a[k]
    energy[0], total = total, 0.0
    if len(work.potential):
        call_kernels(entries.potential, b, t, q, work.potential)
        for k in range(len(work.potential)):
            total += work.potential[k]
    energy[1] = total


@compiled
def energies_along(
    entries: Entries, b: Array, places: Array, states: Nodes, work: Work, energy: Array
) -> None:
    """Kinetic and potential energies and the power of moved constraints, λᵀΦ_t."""
    for n in range(len(states.t)):
        t, q, v = states.t[n], states.q[n], states.v[n]
        for k in range(len(places)):
            b[places[k]] = states.memory[n, k]
        energies(entries, b, t, q, v, work, energy[n])
        call_kernels(entries.velocity, b, t, q, v, work.rate, work.Phi_t)
        energy[n, 2] = 0.0
        for k in range(len(work.Phi_t)):
            energy[n, 2] += states.lam[n, k] * work.Phi_t[k]


@compiled
def growth_of(work: Work, matrix: Matrix) -> float:
    """Length of λ in Φ_q M⁻¹ Φ_qᵀ λ = μ for the unit vector μ that was found weakest before, which it replaces.

    An inverse iteration that goes on from state to state: the length comes close to 1 / σ², σ the smallest singular
    value of Φ_q M^(-½), with equations scaled as where pivots are chosen.
    """
    n, before, length, placed = len(work.right) - len(work.weak), 0.0, 0.0, matrix.placed
    if len(work.weak) == 0:
        return 0.0
    for k in range(len(work.weak)):
        before += work.weak[k] ** 2
    rounds = 1
    if before == 0.0:
        rounds, work.weak[:] = WARM, 1.0
    for _ in range(rounds):
        for k in range(n):
            work.right[k] = 0.0
        for k in range(len(work.weak)):
            unit = placed.scale[placed.row_place[n + k]]
            work.right[n + k] = work.weak[k] * (1.0 - matrix.left_out[k]) / unit
        backsolve(placed, work.right, work.solution)
        length = 0.0
        for k in range(len(work.weak)):
            work.solution[n + k] /= placed.scale[placed.row_place[n + k]]
            length += work.solution[n + k] ** 2
        length = length**0.5
        for k in range(len(work.weak)):
            work.weak[k] = work.solution[n + k] / length
    return length


@compiled
def shortest(
    entries: Entries, b: Array, t: float, q: Array, lam: Array, work: Work, matrix: Matrix, others: Omissions
) -> None:
    """The shortest of all multipliers with the same constraint forces, where equations are left out.

    Each of these follows from those that are solved: Φ_qᵀ y is its gradient.
    """
    if not len(others.rows):
        return
    call_kernels(entries.jacobian, b, t, q, others.Phi_q)
    for k in range(len(others.Phi_q)):
        matrix.Phi_q[k] = others.Phi_q[k]
    leave_out(matrix.Phi_q, matrix.row_of, matrix.left_out)
    refactor(matrix.values, matrix.placed)
    n = len(q)
    for k in range(len(others.rows)):
        work.right[:] = 0.0
        gradient(others, others.rows[k], work.right)
        backsolve(matrix.placed, work.right, work.solution)
        for row in range(len(lam)):
            others.null[k, row] = -work.solution[n + row]
        others.null[k, others.rows[k]] = 1.0
    shorten(others, b, q, lam)


@compiled
def sample(
    motion: MotionSolver, b: Array, places: Array, nodes: Nodes, apart: bool, out: Samples, first: int, row: int,
    others: Omissions, known: Samples, points: Samples, point_of: Array, monitored: bool, rounds: int,
) -> tuple[int, int]:  # fmt: skip
    """Fill `out` from entry `first` on at its times, all within the nodes; `row` is the node to begin with.

    What constraints are off and growth are computed only if `monitored`. Positions and velocities that are `known` are
    taken over. Those of steps with `points`, from `point_of` each node on, are interpolated between these where that is
    consistent. Accelerations and multipliers are solved for in so many rounds, at most; without any, only q and v are
    filled.

    Returns
    -------
    the entries filled, and the node arrived at; it stops before the end where the pivots do not fit
    """
    (entries, matrix, work), n = motion, first
    while n < len(out.t):
        while row + 2 < len(nodes.t) and out.t[n] > nodes.t[row + 1]:
            row += 1
        for k in range(len(places)):
            b[places[k]] = nodes.memory[row, k]
        place = n if rounds > 0 else 0  # memory that is not written is not allocated
        t, q, v, a, lam = out.t[n], out.q[n], out.v[n], out.a[place], out.lam[place]
        if row + 1 < len(nodes.t):
            interpolate(nodes, row, apart, out, n, place)
        else:
            for k in range(nodes.q.shape[1]):
                q[k], v[k], a[k] = nodes.q[row, k], nodes.v[row, k], nodes.a[row, k]
            for k in range(nodes.lam.shape[1]):
                lam[k] = nodes.lam[row, k]
        if rounds > 0 and not factor(entries, b, t, q, matrix) > TRUSTED:
            break
        ready = False
        if len(known.t):
            if known.growth[n] > INFINITE:  # this state could not be projected
                break
            for k in range(len(q)):
                q[k], v[k] = known.q[n, k], known.v[n, k]
            out.violation[n, 0], out.violation[n, 1] = known.violation[n, 0], known.violation[n, 1]
            ready = True
        elif point_of[row] >= 0:
            interpolate_points(points, point_of[row], out, n)
            ready = consistent(motion, b, t, q, v, lam, out.violation[n])
            if not ready:
                interpolate(nodes, row, apart, out, n, place)
        if not ready:
            if rounds == 0 and not factor(entries, b, t, q, matrix) > TRUSTED:
                break
            if not project(motion, b, t, q, v, lam, out.violation[n], monitored):
                break
        if rounds > 0:
            solve_motion(motion, b, t, q, v, a, lam, rounds)
            shortest(entries, b, t, q, lam, work, matrix, others)
            if monitored:
                out.growth[n] = growth_of(work, matrix)
        n += 1
    return n, row
