"""Small perturbations carried along a motion, with the linearized equations of motion: one function that is compiled.

    M δa + C δv + K δq + Φ_qᵀδλ = 0,    Φ_q δq = 0,    Φ_q δv + (Φ_q v + Φ_t)_q δq = 0,

by the implicit midpoint rule over some steps of a run at a time, with matrices in the middle and constraints at the
end: over as many as the change of δa permits. Every step of the run adds a local error to δq and δv.
"""

from __future__ import annotations

from typing import NamedTuple

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array
from ...equations.block_matrix import Placed, backsolve, leave_out, refactor
from ..stepping.nodes import Nodes

LONGEST = 8  # steps of the run at a time
SHARP, SMOOTH = 0.3, 0.08  # change of δv by that of δa, over the perturbation: shorter above, longer below
TRUSTED = 1e-12  # pivot over column, below which the order of the pivots is chosen anew
LEAST_MOTION = 0.01  # of displacements over the length of the system by rotations, and the reverse


BLOCKS = ("M", "M_a_q", "S_q", "S_v", "Q_q", "Q_v", "Phi_qT_lam_q")  # of M + ½h C + ¼h² K


class Entries(NamedTuple):
    """The kernels of the groups of operators, see `_jit.kernels.pointer`."""

    jacobian: KernelTable
    inertia: KernelTable
    stiffness: KernelTable
    constraints: KernelTable
    turning: KernelTable


class Matrix(NamedTuple):
    """The numbers of all operators; the matrix [M + ½h C + ¼h² K, Φ_qᵀ; Φ_q at the end, 0] and its factors."""

    values: Array
    Phi_q: Array
    Phi_qT_lam_q: Array
    M: Array
    M_a_q: Array
    S_q: Array
    S_v: Array
    Q_q: Array
    Q_v: Array
    end: Array
    gamma_v: Array
    row_of: Array
    left_out: Array
    placed: Placed


class Pattern(NamedTuple):
    """The row and the column of each number of an operator."""

    rows: Array
    columns: Array


class Patterns(NamedTuple):
    """Patterns of the operators that are multiplied."""

    Phi_qT_lam_q: Pattern
    M_a_q: Pattern
    S_q: Pattern
    S_v: Pattern
    Q_q: Pattern
    Q_v: Pattern
    Phi_q: Pattern
    gamma_v: Pattern


class Perturbation(NamedTuple):
    """The perturbation, and what it is measured by.

    Attributes
    ----------
    q, v : δq and δv over the relative error of one step (nq,)
    a : the last δa
    random : signs and sizes of the local errors of q and v (2 nq,)
    base : q at the start (nq,)
    moved : largest displacement, rotation, and rates of both so far (4,)
    known : whether δa is known, and how many steps come next (2,)
    measured : 1 for coordinates of bodies, 0 for those of blocks of states (nq,)
    """

    q: Array
    v: Array
    a: Array
    random: Array
    base: Array
    moved: Array
    known: Array
    measured: Array


class Work(NamedTuple):
    """Work arrays."""

    q: Array
    v: Array
    a: Array
    lam: Array
    new_q: Array
    new_v: Array
    turned: Array
    right: Array
    solution: Array
    sizes: Array


@compiled
def weigh(weights: Array, beta: float, gamma: float) -> None:
    """The weights of `BLOCKS`: K = (M a)_q + (Φ_qᵀλ)_q - Q_q - S_q times β, C = -Q_v - S_v times γ."""
    weights[1], weights[2], weights[4], weights[6] = beta, -beta, -beta, beta
    weights[3], weights[5] = -gamma, -gamma


@compiled
def measure(nodes: Nodes, first: int, last: int, length: float, own: Perturbation, sizes: Array) -> None:
    """Bring `moved` up to date; `sizes` of q and v (2 nq,), in which displacements and rotations are comparable."""
    nq = nodes.q.shape[1]
    for n in range(first, last + 1):
        for k in range(nq):
            kind, counts = 0 if k % 7 < 3 else 1, own.measured[k]
            own.moved[kind] = max(own.moved[kind], counts * abs(nodes.q[n, k] - own.base[k]))
            own.moved[2 + kind] = max(own.moved[2 + kind], counts * abs(nodes.v[n, k]))
    for k in range(nq):
        for s in range(2):
            shift, turn = own.moved[2 * s], own.moved[2 * s + 1]
            if k % 7 < 3:
                sizes[s * nq + k] = own.measured[k] * max(shift, LEAST_MOTION * length * turn)
            else:
                sizes[s * nq + k] = own.measured[k] * max(turn, LEAST_MOTION * shift / length)


@compiled
def middle(nodes: Nodes, first: int, last: int, work: Work) -> float:
    """The state in the middle between two nodes by Hermite's cubic, or at a node there; returns its time."""
    nq, h = nodes.q.shape[1], nodes.t[last] - nodes.t[first]
    if (last - first) % 2 == 0:
        n = (first + last) // 2
        for k in range(nq):
            work.q[k], work.v[k], work.a[k] = nodes.q[n, k], nodes.v[n, k], nodes.a[n, k]
        for k in range(len(work.lam)):
            work.lam[k] = nodes.lam[n, k]
        return float(nodes.t[n])
    for k in range(nq):
        q0, v0, a0 = nodes.q[first, k], nodes.v[first, k], nodes.a[first, k]
        q1, v1, a1 = nodes.q[last, k], nodes.v[last, k], nodes.a[last, k]
        work.q[k] = 0.5 * (q0 + q1) + 0.125 * h * (v0 - v1)
        work.v[k] = 1.5 * (q1 - q0) / h - 0.25 * (v0 + v1)
        work.a[k] = 1.5 * (v1 - v0) / h - 0.25 * (a0 + a1)
    for k in range(len(work.lam)):
        work.lam[k] = 0.5 * (nodes.lam[first, k] + nodes.lam[last, k])
    return float(nodes.t[first] + 0.5 * h)


@compiled
def evaluate(
    entries: Entries, b: Array, nodes: Nodes, first: int, last: int, work: Work, matrix: Matrix
) -> float:
    """All operators, in the middle and at the end; the matrix factored. Returns how far its pivots can be trusted."""
    h, t = nodes.t[last] - nodes.t[first], middle(nodes, first, last, work)
    q, v, a = work.q, work.v, work.a
    call_kernels(entries.jacobian, b, t, q, work.lam, matrix.Phi_q, matrix.Phi_qT_lam_q)
    call_kernels(entries.inertia, b, q, v, a, matrix.M, matrix.M_a_q, matrix.S_q, matrix.S_v)
    call_kernels(entries.stiffness, b, t, q, v, matrix.Q_q, matrix.Q_v)
    call_kernels(entries.constraints, b, nodes.t[last], nodes.q[last], matrix.end)
    call_kernels(entries.turning, b, nodes.t[last], nodes.q[last], nodes.v[last], matrix.gamma_v)
    leave_out(matrix.Phi_q, matrix.row_of, matrix.left_out)
    leave_out(matrix.end, matrix.row_of, matrix.left_out)
    weigh(matrix.placed.weights, 0.25 * h * h, 0.5 * h)
    return refactor(matrix.values, matrix.placed)


@compiled
def add_product(right: Array, shift: int, factor: float, numbers: Array, pattern: Pattern, x: Array) -> None:
    """right += factor A x, from an entry on."""
    for k in range(len(numbers)):
        right[shift + pattern.rows[k]] += factor * numbers[k] * x[pattern.columns[k]]


@compiled
def solve(work: Work, matrix: Matrix) -> None:
    """The solution for the right side that is there, of equations that are not left out; it becomes 0."""
    n = len(work.q)
    for k in range(len(matrix.left_out)):
        work.right[n + k] *= 1.0 - matrix.left_out[k]
    backsolve(matrix.placed, work.right, work.solution)
    for k in range(len(work.right)):
        work.right[k] = 0.0


@compiled
def propagate(h: float, own: Perturbation, work: Work, matrix: Matrix, patterns: Patterns) -> float:
    """`new_q`, `new_v` at the end, δv's change in `solution`; returns how much that of δa changed it."""
    nq, right, q, v = len(own.q), work.right, work.new_q, work.new_v
    for k in range(nq):
        q[k] = own.q[k] + 0.5 * h * own.v[k]
    add_product(right, 0, -h, matrix.Phi_qT_lam_q, patterns.Phi_qT_lam_q, q)
    add_product(right, 0, -h, matrix.M_a_q, patterns.M_a_q, q)
    add_product(right, 0, h, matrix.S_q, patterns.S_q, q)
    add_product(right, 0, h, matrix.Q_q, patterns.Q_q, q)
    add_product(right, 0, h, matrix.S_v, patterns.S_v, own.v)
    add_product(right, 0, h, matrix.Q_v, patterns.Q_v, own.v)
    for k in range(nq):
        q[k] = own.q[k] + h * own.v[k]
    add_product(right, nq, -1.0, matrix.end, patterns.Phi_q, own.v)
    add_product(right, nq, 0.5, matrix.gamma_v, patterns.gamma_v, q)
    solve(work, matrix)
    turned, size = 0.0, 0.0
    for k in range(nq):
        v[k] = own.v[k] + work.solution[k]
        q[k] = own.q[k] + 0.5 * h * (own.v[k] + v[k])
        unit = work.sizes[nq + k]
        if unit > 0.0:
            turned = max(turned, abs(work.solution[k] - h * own.a[k]) / unit)
            size = max(size, abs(own.v[k]) / unit, abs(own.q[k]) / work.sizes[k])
        work.turned[k] = work.solution[k] / h
    return turned / size if size > 0.0 and own.known[0] > 0.0 else 0.0


@compiled
def project(count: int, own: Perturbation, work: Work, matrix: Matrix, patterns: Patterns) -> None:
    """Add local errors of some steps, and satisfy the linearized constraints."""
    nq, right = len(own.q), work.right
    for k in range(nq):
        own.q[k] = work.new_q[k] + count * own.random[k] * work.sizes[k]
        own.v[k] = work.new_v[k] + count * own.random[nq + k] * work.sizes[nq + k]
        own.a[k] = work.turned[k]
    add_product(right, nq, -1.0, matrix.end, patterns.Phi_q, own.q)
    solve(work, matrix)
    for k in range(nq):
        own.q[k] += work.solution[k]
    add_product(right, nq, -1.0, matrix.end, patterns.Phi_q, own.v)
    add_product(right, nq, 0.5, matrix.gamma_v, patterns.gamma_v, own.q)
    solve(work, matrix)
    for k in range(nq):
        own.v[k] += work.solution[k]


@compiled(entry=True)
def carry(
    entries: Entries, b: Array, places: Array, nodes: Nodes, first: int, length: float, own: Perturbation,
    twin: Perturbation, matrix: Matrix, patterns: Patterns, work: Work, least: float,
) -> tuple[int, float]:  # fmt: skip
    """Carry two perturbations over the nodes, from one on; the first one determines over how many steps at a time.

    Returns
    -------
    the node arrived at, which is not the last one where pivots do not fit or a perturbation is larger than `least`;
    and the largest part of q over the size of the motion
    """
    n, nq, largest = first, len(own.q), 0.0
    while n + 1 < len(nodes.t):
        last = min(n + int(own.known[1]), len(nodes.t) - 1)
        h = nodes.t[last] - nodes.t[n]
        if not h > 0.0:
            n, own.known[0] = last, 0.0
            continue
        for k in range(len(places)):
            b[places[k]] = nodes.memory[last, k]
        measure(nodes, n, last, length, own, work.sizes)
        if not evaluate(entries, b, nodes, n, last, work, matrix) > TRUSTED:
            return n, largest
        turned = propagate(h, own, work, matrix, patterns)
        if turned > SHARP and last > n + 1:
            own.known[1] = max(1, (last - n) // 2)
            continue
        project(last - n, own, work, matrix, patterns)
        propagate(h, twin, work, matrix, patterns)
        project(last - n, twin, work, matrix, patterns)
        own.known[0], own.known[1] = 1.0, float(last - n)
        if turned < SMOOTH:
            own.known[1] = float(min(LONGEST, 2 * (last - n)))
        n = last
        for k in range(nq):
            if work.sizes[k] > 0.0:
                largest = max(largest, abs(own.q[k]) / work.sizes[k], abs(twin.q[k]) / work.sizes[k])
        if not largest < least:
            return n, largest
    return n, largest
