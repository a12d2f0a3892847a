"""Changes of the Lagrangians of all operations along a direction, several at once. (Functions that are compiled.)"""

from __future__ import annotations

from typing import NamedTuple

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.kernels.vector import LANES
from ...._jit.linking.link import compiled
from ....algebra import Array
from ....linalg.lanes_loop import clear_lanes
from .block_loop import Block, Run, collect, gather, remember
from .layout import EquationGroup, Layout, group_of
from .stacked import Series, at, row


class Operands(NamedTuple):
    """Operands and results of one call besides the states, in lanes: see `lagrangian`."""

    q_dot: Array
    v_dot: Array
    a_dot: Array
    lam_dot: Array
    xi: Array
    nu: Array
    by_q: Array
    by_v: Array
    by_a: Array
    by_lam: Array
    by_b: Array


@compiled
def put(x: Array, first: int, weight: float, lane: int, out: Array) -> None:
    """A lane of out = weight times entries of x from a place on; zero if there is none."""
    for k in range(len(out) // LANES):
        out[k * LANES + lane] = weight * x[first + k] if first >= 0 else 0.0


@compiled
def clear_others(first: int, last: int, lane: int, out: Array) -> None:
    """A lane of out = 0 but for some entries."""
    for k in range(len(out) // LANES):
        if k < first or k >= last:
            out[k * LANES + lane] = 0.0


@compiled
def take(x: Array, lane: int, first: int, out: Array) -> None:
    """Entries of out from a place on += a lane of x."""
    if first >= 0:
        for k in range(len(x) // LANES):
            out[first + k] += x[k * LANES + lane]


@compiled
def change_group(
    entry: KernelTable, b: Array, b_dot: Array, run: Run, op: int, group: EquationGroup, dots: Series,
    adjoint: Series, block: Block, work: Operands, sources: Series,
) -> None:  # fmt: skip
    """One group of equations of the occurrences in a block."""
    for lane in range(LANES):
        k = block.occurrences[op, lane]
        moved, mu, scales = at(dots, op, k).values, at(adjoint, op, k).values, at(run.scales, op, k).values
        put(moved, group.by_q, 1.0, lane, work.q_dot)
        put(moved, group.by_v, 1.0, lane, work.v_dot)
        put(moved, group.by_a, 1.0, lane, work.a_dot)
        put(moved, group.by_lam, 1.0, lane, work.lam_dot)
        used = 1.0 if lane < block.used[op, 0] else 0.0
        put(mu, group.xi_row, used * scales[group.xi_equation], lane, work.xi)
        put(mu, group.nu_row, used * group.sign * scales[group.nu_equation], lane, work.nu)
        clear_others(group.first, group.last, lane, work.nu)
    clear_lanes(work.by_q)
    clear_lanes(work.by_v)
    clear_lanes(work.by_a)
    clear_lanes(work.by_lam)
    states = block.states
    t, q, v = states[group.t * LANES :], states[group.q * LANES :], states[group.v * LANES :]
    a, lam = states[group.a * LANES :], states[group.lam * LANES :]
    call_kernels(
        entry, b, t, q, v, a, work.q_dot, work.v_dot, work.a_dot, work.xi, lam, work.nu, work.lam_dot, b_dot,
        work.by_q, work.by_v, work.by_a, work.by_lam, work.by_b,
    )  # fmt: skip
    for lane in range(block.used[op, 0]):
        out = at(sources, op, block.occurrences[op, lane]).values
        take(work.by_q, lane, group.by_q, out)
        take(work.by_v, lane, group.by_v, out)
        take(work.by_a, lane, group.by_a, out)
        take(work.by_lam, lane, group.by_lam, out)


@compiled
def change_operation(
    layout: Layout, entries: KernelTable, ends: Array, b: Array, b_dot: Array, run: Run, op: int, dots: Series,
    adjoint: Series, block: Block, work: Operands, sources: Series,
) -> None:  # fmt: skip
    """All occurrences of an operation."""
    k, groups = run.bounds[op, 0], row(layout.groups, op).values
    while k < run.bounds[op, 1]:
        collect(run, op, k, 1, block)
        gather(layout, run, op, block)
        remember(b, run, op, block)
        for n in range(len(groups)):
            group = group_of(groups, n)
            first, last = ends[group.kind], ends[group.kind + 1]
            own = KernelTable(entries.addresses[first:last], entries.starts[first : last + 1], entries.tables)
            change_group(own, b, b_dot, run, op, group, dots, adjoint, block, work, sources)
        k += block.used[op, 0]


@compiled(entry=True)
def change(
    layout: Layout, entries: KernelTable, ends: Array, b: Array, b_dot: Array, run: Run, dots: Series, adjoint: Series,
    block: Block, work: Operands, sources: Series,
) -> None:  # fmt: skip
    """Of all operations; what the changes add to the gradient by the numbers is left in `work`.

    dots, adjoint : changes of the stages' quantities, adjoint variables
    sources : takes the changes of the gradients by the stages' quantities
    """
    for op in range(len(run.bounds)):
        change_operation(layout, entries, ends, b, b_dot, run, op, dots, adjoint, block, work, sources)
