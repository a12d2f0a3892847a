"""Operations of a run linearized several at a time, one in every lane. (Functions that are compiled.)

In a sweep all states are known: operators, matrices and their factors do not wait for what is swept. A block holds
occurrences of one operation that follow one another. In arrays "in lanes" every entry is a number for each lane. What
takes a whole block is called in one place, so that it becomes part of the caller: handing over all its arrays would
take as long as a step of a small system.
"""

from __future__ import annotations

from typing import NamedTuple

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.kernels.vector import LANES
from ...._jit.linking.link import compiled
from ....algebra import Array
from ....linalg.lanes_loop import assemble_lanes, clear_lanes, factor_lanes, turn_lanes
from ....linalg.panel_loop import Pattern
from ...dynamics.methods.tables import GAMMA_Q_V, GAMMA_V, INERTIA, JACOBIAN, STIFFNESS
from .layout import Layout, group_of
from .split_loop import SplitStages, factor_split
from .stacked import Ragged, Row, Series, at, row

UNKNOWN = 1.0  # relative change of a solution by its refinement, before there was one
UNEVALUATED, REDUNDANT, END = 0, 1, 2


class Kernels(NamedTuple):
    """Drivers by address, in lanes: of operators, in the order of `tables.DRIVERS`, and of all Lagrangians.

    gradient : by the numbers of elements, of all kinds one after another; `gradients` is where each kind begins
    """

    jacobian: KernelTable
    inertia: KernelTable
    stiffness: KernelTable
    gamma_v: KernelTable
    gamma_q_v: KernelTable
    Phi_q_xi_q: KernelTable
    gradient: KernelTable
    gradients: Array


class Run(NamedTuple):
    """What a run adds to the layout of its operations, see `record`.

    coefficients : of the affine maps; `unknowns`: where those of the stages by the unknowns begin
    weights, product_weights, split_weights, scales : of the matrices' parts and of the equations
    times : of the stages
    steps, nodes, alike : whose memory and redundant equations hold; what is the same where these are
    sources, pieces : recorded values; the source of each, its first row and its stride
    bounds : (operations, 2) occurrences of each within the sweep
    memory, places, left_out : of the steps, see `sarrus.results.StepsTaken`
    """

    coefficients: Series
    unknowns: Array
    weights: Series
    product_weights: Series
    split_weights: Series
    scales: Series
    times: Series
    steps: Series
    nodes: Series
    alike: Series
    sources: tuple[Array, ...]
    pieces: Ragged
    bounds: Array
    memory: Array
    places: Array
    left_out: Array


class RaggedPattern(NamedTuple):
    """Patterns of factors, one after another: the fields of `panel_loop.Pattern`."""

    indptr: Ragged
    indices: Ragged
    pointers: Ragged
    rows: Ragged
    diagonal: Ragged
    ends: Ragged
    row_place: Ragged
    column_order: Ragged


class RaggedRows(NamedTuple):
    """Matrices by rows, one after another: the fields of `columns_loop.Rows`."""

    indptr: Ragged
    columns: Ragged
    places: Ragged
    more: Ragged


class Matrices(NamedTuple):
    """Of all operations: the matrix, its factors' pattern, and the product.

    upper, whole, by_rows : by rows, for panels of columns: U, the matrix, the product; fields of `columns_loop.Rows`
    split : of the operation `split_operation`, whose stages are split, or -1: its matrix is not factored
    """

    parts: Ragged
    places: Ragged
    pattern: RaggedPattern
    product_parts: Ragged
    product_places: Ragged
    product_indptr: Ragged
    product_indices: Ragged
    upper: RaggedRows
    whole: RaggedRows
    by_rows: RaggedRows
    split: SplitStages
    split_operation: int


class Block(NamedTuple):
    """One block for each operation.

    occurrences, used : (operations, lanes); (operations, 2) how many lanes are in use, and which is next
    states, values : in lanes, see `layout.Layout`
    weights : of the parts of one matrix, in lanes
    sheet : factors and numbers of one matrix, or those of its product, in lanes
    split : numbers of the matrices of split stages, in lanes
    turned, starts, strides : the same lane by lane, where those of each operation begin, and how many each lane has
    cuts : (operations, 4) where factors, numbers of the matrix and of the product begin among these, and the end
    work : of the unknowns, in lanes
    growth : (operations, lanes) of the factors
    refined : (operations, 3) what the last refinement changed, the growth of its factors, and the change up to which
        the next solutions are not refined
    adjoint, by_b : (columns, entries) backwards, adjoint variables of all groups, and the gradients by b, in lanes
    moved : forwards, what changes of b do, see `changes`
    """

    occurrences: Array
    used: Array
    states: Array
    values: Array
    weights: Array
    sheet: Array
    split: Array
    turned: Array
    starts: Array
    strides: Array
    cuts: Array
    work: Array
    growth: Array
    refined: Array
    adjoint: Array
    by_b: Array
    moved: Changes


class Changes(NamedTuple):
    """What changes of the numbers do to the equations: a call for every group and every element that a column touches.

    entry : the driver and the table of each element by itself
    dots : (columns, len(b)) the changes
    calls : of each operation: column, element, group, where its results begin, and end
    results : in lanes
    places, equations, signs, chosen : of each operation and panel of columns: place in a panel of each result, its
        equation and sign, and where the result is
    panels : how many panels there are
    """

    entry: KernelTable
    dots: Array
    calls: Ragged
    results: Array
    places: Ragged
    equations: Ragged
    signs: Ragged
    chosen: Ragged
    panels: int


@compiled
def collect(run: Run, op: int, k: int, way: int, block: Block) -> None:
    """Fill the lanes with occurrences that are alike, from k on; those that are left repeat one."""
    count, n, kin = 0, k, at(run.alike, op, k).values[0]
    while (
        count < LANES and run.bounds[op, 0] <= n < run.bounds[op, 1] and at(run.alike, op, n).values[0] == kin
    ):
        block.occurrences[op, count] = n
        count += 1
        n += way
    for lane in range(count, LANES):
        block.occurrences[op, lane] = k
    block.used[op, 0], block.used[op, 1] = count, 0


@compiled
def gather(layout: Layout, run: Run, op: int, block: Block) -> None:
    """The recorded stages; adjoint variables begin with zero."""
    pieces, places, states = row(run.pieces, op).values, row(layout.pieces, op).values, block.states
    for lane in range(LANES):
        k = block.occurrences[op, lane]
        times = at(run.times, op, k).values
        for s in range(len(times)):
            states[(layout.times[op, 0] + s) * LANES + lane] = times[s]
        for p in range(len(pieces)):
            source = run.sources[pieces[p, 0]]
            n, first = pieces[p, 1] + pieces[p, 2] * k, places[p] * LANES + lane
            for j in range(source.shape[1]):
                states[first + j * LANES] = source[n, j]
    if len(block.adjoint) > 0:
        block.adjoint[:, layout.adjoints[op, 0] * LANES : layout.adjoints[op, 1] * LANES] = 0.0


@compiled
def remember(b: Array, run: Run, op: int, block: Block) -> None:
    """What elements remembered during the steps of a block."""
    n = at(run.steps, op, block.occurrences[op, 0]).values[0]
    for k in range(len(run.places)):
        b[run.places[k]] = run.memory[n, k]


@compiled
def leave_out(layout: Layout, run: Run, op: int, block: Block) -> None:
    """Equations that are left out have no gradient."""
    if len(run.left_out) > 0:
        out = run.left_out[at(run.nodes, op, block.occurrences[op, 0]).values[0]]
        first = layout.values[op, REDUNDANT] * LANES
        for k in range(len(out)):
            block.values[first + k * LANES : first + (k + 1) * LANES] = out[k]
        places = row(layout.constrained, op).values
        for k in range(len(places)):
            for lane in range(LANES):
                block.values[places[k, 0] * LANES + lane] *= 1.0 - out[places[k, 1]]


@compiled
def evaluate(layout: Layout, kernels: Kernels, b: Array, run: Run, op: int, block: Block) -> None:
    """The numbers of all operators."""
    clear_lanes(block.values[layout.values[op, UNEVALUATED] * LANES : layout.values[op, REDUNDANT] * LANES])
    calls = row(layout.calls, op).values
    for n in range(len(calls)):
        driver = calls[n, 0]
        t, q = block.states[calls[n, 1] * LANES :], block.states[calls[n, 2] * LANES :]
        x, a = block.states[calls[n, 3] * LANES :], block.states[calls[n, 4] * LANES :]
        first, second = block.values[calls[n, 5] * LANES :], block.values[calls[n, 6] * LANES :]
        if driver == JACOBIAN:
            call_kernels(kernels.jacobian, b, t, q, x, first, second)
        elif driver == INERTIA:
            third, fourth = block.values[calls[n, 7] * LANES :], block.values[calls[n, 8] * LANES :]
            call_kernels(kernels.inertia, b, q, x, a, first, second, third, fourth)
        elif driver == STIFFNESS:
            call_kernels(kernels.stiffness, b, t, q, x, first, second)
        elif driver == GAMMA_V:
            call_kernels(kernels.gamma_v, b, t, q, x, first)
        elif driver == GAMMA_Q_V:
            call_kernels(kernels.gamma_q_v, b, t, q, x, first, second)
        else:
            call_kernels(kernels.Phi_q_xi_q, b, t, q, x, first)
    leave_out(layout, run, op, block)


@compiled
def weigh(series: Series, op: int, block: Block) -> None:
    """The weights of the parts of a matrix."""
    for lane in range(LANES):
        weights = at(series, op, block.occurrences[op, lane]).values
        for k in range(len(weights)):
            block.weights[k * LANES + lane] = weights[k]


@compiled
def pattern_of(matrices: Matrices, op: int) -> Pattern:
    """The pattern of the matrix of an operation and of its factors."""
    own = matrices.pattern
    return Pattern(
        row(own.indptr, op).values,
        row(own.indices, op).values,
        row(own.pointers, op).values,
        row(own.rows, op).values,
        row(own.diagonal, op).values,
        row(own.ends, op).values,
        row(own.row_place, op).values,
        row(own.column_order, op).values,
    )


@compiled
def factor_block(layout: Layout, run: Run, op: int, matrices: Matrices, block: Block) -> None:
    """Assemble and factor the matrices."""
    first, last = block.cuts[op, 1], block.cuts[op, 2]
    factors, data = block.sheet[: first * LANES], block.sheet[first * LANES : last * LANES]
    weigh(run.weights, op, block)
    values = block.values[layout.values[op, UNEVALUATED] * LANES :]
    assemble_lanes(
        row(matrices.parts, op).values, row(matrices.places, op).values, block.weights, values, data
    )
    if matrices.split_operation == op:
        weigh(run.split_weights, op, block)
        factor_split(matrices.split, block.weights, values, block.split, factors, block.work)
    else:
        factor_lanes(pattern_of(matrices, op), data, factors, block.work, block.growth[op])
    block.refined[op, 0] = UNKNOWN
    turn_lanes(block.sheet, last, turned(block, op).values, block.strides[op], 0)


@compiled
def turned(block: Block, op: int) -> Row:
    """What is stored lane by lane for an operation."""
    return Row(block.turned[block.starts[op] : block.starts[op] + LANES * block.strides[op]])


@compiled
def make_product(layout: Layout, run: Run, op: int, matrices: Matrices, block: Block) -> None:
    """Assemble the products."""
    first, last = block.cuts[op, 2], block.cuts[op, 3]
    data = block.sheet[: (last - first) * LANES]
    weigh(run.product_weights, op, block)
    parts, places = row(matrices.product_parts, op).values, row(matrices.product_places, op).values
    values = block.values[layout.values[op, UNEVALUATED] * LANES :]
    assemble_lanes(parts, places, block.weights, values, data)
    turn_lanes(block.sheet, last - first, turned(block, op).values, block.strides[op], first)


@compiled
def change(layout: Layout, b: Array, op: int, block: Block) -> None:
    """Forwards, what changes of the numbers do, element by element."""
    moved, states = block.moved, block.states
    calls, groups = row(moved.calls, op).values, row(layout.groups, op).values
    if len(calls) > 0:
        clear_lanes(moved.results[calls[0, 3] * LANES : calls[len(calls) - 1, 4] * LANES])
    for n in range(len(calls)):
        element, dots, group = calls[n, 1], moved.dots[calls[n, 0]], group_of(groups, calls[n, 2])
        out, every = moved.results[calls[n, 3] * LANES : calls[n, 4] * LANES], moved.entry
        own = KernelTable(
            every.addresses[element : element + 1], every.starts[element : element + 2], every.tables
        )
        t, q, v = states[group.t * LANES :], states[group.q * LANES :], states[group.v * LANES :]
        a, lam = states[group.a * LANES :], states[group.lam * LANES :]
        call_kernels(own, b, t, q, v, a, lam, dots, out, out)


@compiled
def finish(layout: Layout, kernels: Kernels, b: Array, run: Run, op: int, block: Block) -> None:
    """Backwards, what the adjoint variables give for the gradient by the numbers; the block is used up."""
    if block.used[op, 0] > 0 and len(block.adjoint) > 0:
        remember(b, run, op, block)
        groups, states, every = row(layout.groups, op).values, block.states, kernels.gradient
        for n in range(len(groups)):
            group = group_of(groups, n)
            first, last = kernels.gradients[group.kind], kernels.gradients[group.kind + 1]
            own = KernelTable(every.addresses[first:last], every.starts[first : last + 1], every.tables)
            t, q, v = states[group.t * LANES :], states[group.q * LANES :], states[group.v * LANES :]
            a, lam = states[group.a * LANES :], states[group.lam * LANES :]
            for c in range(len(block.adjoint)):
                xi, nu = block.adjoint[c, group.xi * LANES :], block.adjoint[c, group.nu * LANES :]
                call_kernels(own, b, t, q, v, a, xi, lam, nu, block.by_b[c])
    block.used[op, 0], block.used[op, 1] = 0, 0


@compiled
def linearize(
    layout: Layout,
    kernels: Kernels,
    b: Array,
    run: Run,
    op: int,
    k: int,
    way: int,
    matrices: Matrices,
    block: Block,
) -> None:
    """Evaluate and factor for occurrences of an operation from k on, up or down."""
    collect(run, op, k, way, block)
    gather(layout, run, op, block)
    remember(b, run, op, block)
    evaluate(layout, kernels, b, run, op, block)
    factor_block(layout, run, op, matrices, block)
    make_product(layout, run, op, matrices, block)
    change(layout, b, op, block)
