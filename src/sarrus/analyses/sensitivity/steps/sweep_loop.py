"""Tangent and adjoint sweeps over the operations of a run, whatever the method, as functions that are compiled.

An operation with equations R(z; y, b) = 0, stages s = S_y y + S_z z and a state after it U_y y + U_z z changes by

    J z' = -(R_b b' + R_s S_y y'),    J = R_s S_z,    y' ← U_y y' + U_z z';

its adjoint, with ȳ the gradient by the state after it, is

    Jᵀ μ = U_zᵀ ȳ,    b̄ -= R_bᵀ μ,    ȳ ← U_yᵀ ȳ - S_yᵀ R_sᵀ μ.

Columns (of parameters, or of responses) are handled together: vectors are arrays (n, width) backwards, of a single
column or of whole vectors; forwards, where there may be many, panel after panel (`columns_loop`), or a single column.
All that does not depend on what is swept is done for several occurrences at once: `block_loop`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...._jit.kernels.lanes import fill, load, plus_product, store
from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.kernels.vector import LANES
from ...._jit.linking.link import compiled
from ....algebra import Array
from ....linalg.columns_loop import ByRows, Rows, minus_rows, solve_panel
from ....linalg.panel_loop import (
    REFINEMENTS,
    Buffers,
    Factors,
    solve_columns_transposed,
    solve_flat,
    solve_plain_transposed,
)
from .block_loop import (
    UNKNOWN,
    Block,
    Changes,
    Kernels,
    Matrices,
    RaggedRows,
    Run,
    finish,
    linearize,
    pattern_of,
    turned,
)
from .layout import Layout, group_of
from .maps import Drivers, Maps
from .split_loop import solve_split
from .stacked import Row, Series, at, row

ONE: Any = np.uint64(1)
TWO: Any = np.uint64(2)
CHANGE, GROWTH, LIMIT = 0, 1, 2  # columns of `Block.refined`
LARGER = 1e2  # times the squares of L may be those of factors with which a solution needed no refinement


class Timeline(NamedTuple):
    """The operations of a sweep in their order.

    operations, occurrences, nodes : which each is, its occurrence, and the node that it ends at, or -1
    states : derivatives of states that do not depend on each other, or by these, one for each node; or none
    initial : the state with which each operation begins, or -1
    adjoints : (steps, 2, 2 nq, columns) take those by q and v, their first blocks, before and after each step; or none
    steps : the step that each operation is, or -1
    """

    operations: Array
    occurrences: Array
    nodes: Array
    initial: Array
    states: Array
    adjoints: Array
    steps: Array


class Work(NamedTuple):
    """Vectors of the unknowns (n, width), and of the stages' quantities.

    width : of all columns backwards, of a panel forwards
    buffers : of three vectors of the unknowns, as long as pairs of a stage need, to solve with
    changes : of the columns by a correction of a solution (width,)
    stages : (entries * width)
    maps : for vectors of this width, see `maps`
    trusted : the relative error left in a refined solution up to which the order of the pivots is not renewed
    left : the relative error that may be left in solutions with split stages
    done : how many panels have made the operation that is next; backwards, whether its node's gradients are added
    """

    right: Array
    solution: Array
    buffers: Array
    changes: Array
    stages: Array
    maps: Maps
    trusted: Array
    left: Array
    done: Array


class NodeArrays(NamedTuple):
    """Per node gradients of responses, which a sweep takes, or buffers for derivatives, which a forward sweep gives."""

    q: Array
    v: Array
    a: Array
    lam: Array


class Weighing(NamedTuple):
    """Forwards, the change of responses, so that no derivatives of states need be stored; or none.

    by : their gradients by the states
    ends, rows, values : those of one node that are not zero: where each response's begin and end; buffers
    total : (panels, responses * width)
    """

    by: NodeArrays
    ends: Array
    rows: Array
    values: Array
    total: Array


@compiled
def apply_map(own: Drivers, op: int, coefficients: Array, state: Array, other: Array, out: Array) -> None:
    """Set a vector by the state and another one, see `maps`."""
    n = own.at[op]
    driver = KernelTable(own.addresses[n : n + 1], own.starts[n : n + 2], own.tables)
    call_kernels(driver, coefficients, state, other, out)


@compiled
def spread(terms: Array, coefficients: Array, x: Array, out: Array) -> None:
    """Out += A x, for blocks of rows and columns; a single column."""
    for n in range(len(terms)):
        for k in range(terms[n, 2]):
            out[terms[n, 0] + k] += coefficients[n] * x[terms[n, 1] + k]


@compiled
def spread_transposed(terms: Array, coefficients: Array, x: Array, out: Array) -> None:
    """Out += Aᵀ x."""
    for n in range(len(terms)):
        for k in range(terms[n, 2]):
            out[terms[n, 1] + k] += coefficients[n] * x[terms[n, 0] + k]


@compiled
def numbers_of(block: Block, op: int, lane: int) -> Row:
    """What is stored of a lane."""
    first = lane * block.strides[op]
    return Row(turned(block, op).values[first : first + block.strides[op]])


@compiled
def lane_of(matrices: Matrices, block: Block, op: int, numbers: Array) -> Factors:
    """The matrix of one lane and its factors."""
    cuts = block.cuts[op]
    return Factors(pattern_of(matrices, op), numbers[cuts[1] : cuts[2]], numbers[: cuts[1]])


@compiled
def rows_of(by_rows: RaggedRows, op: int) -> Rows:
    """A matrix by rows."""
    return Rows(
        row(by_rows.indptr, op).values,
        row(by_rows.columns, op).values,
        row(by_rows.places, op).values,
        row(by_rows.more, op).values,
    )


@compiled
def plainly(refined: Array, growth: float) -> bool:
    """Whether a solution with factors of some growth need not be refined."""
    return bool(refined[CHANGE] <= refined[LIMIT] and growth <= LARGER * refined[GROWTH])


@compiled
def solve_lane(
    own: Factors,
    upper: Rows,
    whole: Rows,
    refined: Array,
    growth: float,
    initial: bool,
    right: Array,
    solution: Array,
    buffers: Buffers,
) -> float:
    """Solve for one column as in `solve_lane_transposed`, or for a panel of them.

    Panels are not refined where that changed next to nothing in all panels of the same block that were; each is in the
    block's first lane, which determines the growth, too. `initial`: whether this is not that one.
    """
    size, alone = right.shape[0] * right.shape[1], right.shape[1] == 1
    given, found = right.reshape(size), solution.reshape(size)
    x, rest, more = buffers[0].reshape(size), buffers[1].reshape(size), buffers[2].reshape(size)
    plain = plainly(refined, growth) and (alone or initial)
    most = 0 if plain else REFINEMENTS
    if alone:
        first, error = solve_flat(own, given, found, x, rest, more, most)
    else:
        first, error = solve_panel(own, ByRows(upper, whole), given, found, x, rest, most)
    if plain:
        return 0.0
    if first > 0.0:  # a right side of zeros does not test the factors
        begins = alone or refined[CHANGE] == UNKNOWN
        if begins or not initial:
            refined[GROWTH] = growth
        refined[CHANGE] = first if begins else max(first, refined[CHANGE])
    return error


@compiled
def solve_lane_transposed(
    own: Factors, refined: Array, growth: float, right: Array, solution: Array, buffers: Buffers
) -> float:
    """Solve with the transposed factors of one lane; the relative error left in the solution.

    It is not refined where that changed next to nothing in the same block, with factors about as large.
    """
    if plainly(refined, growth):
        solve_plain_transposed(own, right, solution, buffers)
        return 0.0
    first, error = solve_columns_transposed(own, right, solution, buffers)
    if first > 0.0:
        refined[CHANGE], refined[GROWTH] = first, growth
    return error


@compiled
def silence(layout: Layout, run: Run, op: int, k: int, x: Array) -> None:
    """Zero in the rows of equations that are left out."""
    if len(run.left_out) > 0:
        out, rows = run.left_out[at(run.nodes, op, k).values[0]], row(layout.constraints, op).values
        for e in range(len(rows)):
            for j in range(len(out)):
                if out[j] > 0.0:
                    x[rows[e] + j, :] = 0.0


@compiled
def put_adjoint(layout: Layout, run: Run, op: int, k: int, lane: int, mu: Array, block: Block) -> None:
    """ξ and ν of a lane for all groups."""
    groups, scales = row(layout.groups, op).values, at(run.scales, op, k).values
    for n in range(len(groups)):
        group = group_of(groups, n)
        nq = group.nu - group.xi
        if group.xi_row >= 0:
            put_rows(mu, group.xi_row, nq, scales[group.xi_equation], lane, group.xi, block.adjoint)
        if group.nu_row >= 0:
            first, count = group.first, group.last - group.first
            weight = group.sign * scales[group.nu_equation]
            put_rows(mu, group.nu_row + first, count, weight, lane, group.nu + first, block.adjoint)


@compiled
def put_rows(mu: Array, first: int, count: int, weight: float, lane: int, to: int, out: Array) -> None:
    """A lane of out = weight x some rows of μ, for all columns that have gradients by the numbers."""
    for c in range(out.shape[0]):
        for j in range(count):
            out[c, (to + j) * LANES + lane] = weight * mu[first + j, c]


@compiled
def times_transposed(matrices: Matrices, op: int, numbers: Array, mu: Array, out: Array) -> None:
    """Out += Pᵀ μ, for the quantities of the stages that move with the state (n * width)."""
    indptr, indices = row(matrices.product_indptr, op).values, row(matrices.product_indices, op).values
    size: Any = np.uint64(len(indptr) - 1)
    if mu.shape[1] == 1:
        for j in range(size):
            own = out[j]
            for entry in range(indptr[j], indptr[j + ONE]):
                own += numbers[entry] * mu[indices[entry], 0]
            out[j] = own
        return
    across: Any = np.uint64(mu.shape[1] // LANES)
    flat = mu.reshape(mu.shape[0] * mu.shape[1])
    for j in range(size):
        for p in range(across):
            total = load(out, j * across + p)
            for entry in range(indptr[j], indptr[j + ONE]):
                total = plus_product(total, fill(numbers[entry]), load(flat, indices[entry] * across + p))
            store(out, j * across + p, total)


@compiled
def backward_operation(
    layout: Layout, run: Run, op: int, k: int, matrices: Matrices, block: Block, work: Work, bars: Array,
    stored: Series, sources: Series,
) -> bool:  # fmt: skip
    """From the gradients by the state after an operation to those before; false if pivots must be renewed."""
    lane, n, width = block.used[op, 1], layout.n[op], bars.shape[1]
    right, mu, maps = work.right[:n], work.solution[:n], work.maps
    flat, state = right.reshape(n * width), bars.reshape(bars.size)
    moved = work.stages[: layout.stages[op] * width]
    coefficients = at(run.coefficients, op, k).values
    apply_map(maps.right, op, coefficients, state, moved, flat)
    moved[:] = 0.0
    if len(sources.values) > 0:
        source = at(sources, op, k).values
        for j in range(len(source)):
            moved[j] = -source[j]
        spread_transposed(row(layout.by_unknowns, op).values, coefficients[run.unknowns[op] :], moved, flat)
    numbers = numbers_of(block, op, lane).values
    own = lane_of(matrices, block, op, numbers)
    if matrices.split_operation == op:
        error = solve_split(matrices.split, own, True, right, mu, work.buffers, work.changes, work.left[0])
    else:
        buffers = work.buffers[0][:n], work.buffers[1][:n], work.buffers[2][:n]
        error = solve_lane_transposed(own, block.refined[op], block.growth[op, lane], right, mu, buffers)
    if not error <= work.trusted[0]:
        return False
    silence(layout, run, op, k, mu)
    if len(stored.values) > 0:
        saved = at(stored, op, k).values
        copy(mu, saved.reshape(n, len(saved) // n))
    put_adjoint(layout, run, op, k, lane, mu, block)
    times_transposed(matrices, op, numbers[block.cuts[op, 2] :], mu, moved)
    apply_map(maps.before, op, coefficients, state, moved, state)
    block.used[op, 1] += 1
    return True


@compiled
def add_gradients(layout: Layout, given: NodeArrays, n: int, bars: Array) -> None:
    """Add what responses take from one node."""
    add_rows(given.q[n], layout.node[0], bars)
    add_rows(given.v[n], layout.node[1], bars)
    add_rows(given.a[n], layout.node[2], bars)
    add_rows(given.lam[n], layout.node[3], bars)


@compiled
def add_rows(x: Array, first: int, out: Array) -> None:
    """Some rows of out += x."""
    for k in range(x.shape[0]):
        for c in range(x.shape[1]):
            out[first + k, c] += x[k, c]


@compiled
def exchange(bars: Array, out: Array) -> None:
    """Out = bars, which begin with zero again."""
    for k in range(out.shape[0]):
        for c in range(out.shape[1]):
            out[k, c] = bars[k, c]
            bars[k, c] = 0.0


@compiled
def copy(source: Array, out: Array) -> None:
    """out = source, which Numba would check for shapes that fit, with a message that takes seconds to compile."""
    for k in range(out.shape[0]):
        for c in range(out.shape[1]):
            out[k, c] = source[k, c]


@compiled
def backward(
    layout: Layout, kernels: Kernels, b: Array, run: Run, timeline: Timeline, e: int, last: int, matrices: Matrices,
    block: Block, work: Work, bars: Array, given: NodeArrays, stored: Series, sources: Series,
) -> int:  # fmt: skip
    """From the end of operation e to the start of `last`; returns the one that needs new pivots, or last - 1."""
    block.used[:] = 0
    while e >= last:
        op, k = timeline.operations[e], timeline.occurrences[e]
        if work.done[0] == 0 and timeline.nodes[e] >= 0:
            add_gradients(layout, given, timeline.nodes[e], bars)
        work.done[0] = 1
        if len(timeline.adjoints) > 0 and timeline.steps[e] >= 0:
            copy(bars, timeline.adjoints[timeline.steps[e], 1])
        if block.used[op, 1] == block.used[op, 0]:
            finish(layout, kernels, b, run, op, block)
            linearize(layout, kernels, b, run, op, k, -1, matrices, block)
        if not backward_operation(layout, run, op, k, matrices, block, work, bars, stored, sources):
            break
        if len(timeline.adjoints) > 0 and timeline.steps[e] >= 0:
            copy(bars, timeline.adjoints[timeline.steps[e], 0])
        if timeline.initial[e] >= 0:
            exchange(bars, timeline.states[timeline.initial[e]])
        work.done[0] = 0
        e -= 1
    for op in range(len(block.used)):
        finish(layout, kernels, b, run, op, block)
    return e


@compiled
def subtract_changes(moved: Changes, op: int, lane: int, p: int, scales: Array, right: Array) -> None:
    """Right -= what the changes of the numbers do in a lane."""
    n = op * moved.panels + p
    places, chosen = row(moved.places, n).values, row(moved.chosen, n).values
    equations, signs = row(moved.equations, n).values, row(moved.signs, n).values
    for j in range(len(places)):
        right[places[j]] -= moved.results[chosen[j] * LANES + lane] * signs[j] * scales[equations[j]]


@compiled
def subtract_sources(sources: Array, columns: int, p: int, right: Array) -> None:
    """Right -= sources (n * columns) for panel p."""
    width = right.shape[1]
    first = p * width
    for k in range(right.shape[0]):
        for c in range(min(width, columns - first)):
            right[k, c] -= sources[k * columns + first + c]


@compiled
def apply(matrices: Matrices, op: int, numbers: Array, x: Array, right: Array) -> None:
    """Right = P x, for the quantities of the stages that move with the state."""
    out = right.reshape(right.shape[0] * right.shape[1])
    out[:] = 0.0
    if right.shape[1] == 1:
        indptr, indices = row(matrices.product_indptr, op).values, row(matrices.product_indices, op).values
        for j in range(np.uint64(len(indptr) - 1)):
            for entry in range(indptr[j], indptr[j + ONE]):
                out[indices[entry]] -= numbers[entry] * x[j]
    else:
        minus_rows(rows_of(matrices.by_rows, op), numbers, x, out)
    for k in range(len(out)):
        out[k] = -out[k]


@compiled
def forward_operation(
    layout: Layout, run: Run, op: int, k: int, p: int, columns: int, matrices: Matrices, block: Block, work: Work,
    own: Array, stored: Series, sources: Series,
) -> bool:  # fmt: skip
    """The change of the state of a panel p by an operation; false if pivots must be renewed."""
    lane, n, width = block.used[op, 1], layout.n[op], work.right.shape[1]
    right, solution, maps = work.right[:n], work.solution[:n], work.maps
    moved = work.stages[: layout.stages[op] * width]
    coefficients = at(run.coefficients, op, k).values
    apply_map(maps.moved, op, coefficients, own, moved, moved)
    numbers = numbers_of(block, op, lane).values
    apply(matrices, op, numbers[block.cuts[op, 2] :], moved, right)
    flat = right.reshape(n * width)
    subtract_changes(block.moved, op, lane, p, at(run.scales, op, k).values, flat)
    if len(sources.values) > 0:
        subtract_sources(at(sources, op, k).values, columns, p, right)
    silence(layout, run, op, k, right)
    matrix, refined = lane_of(matrices, block, op, numbers), block.refined[op]
    upper, whole = rows_of(matrices.upper, op), rows_of(matrices.whole, op)
    buffers, growth = (work.buffers[0][:n], work.buffers[1][:n], work.buffers[2][:n]), block.growth[op, lane]
    if matrices.split_operation == op:
        error = solve_split(
            matrices.split, matrix, False, right, solution, work.buffers, work.changes, work.left[0]
        )
    else:
        error = solve_lane(matrix, upper, whole, refined, growth, lane > 0, right, solution, buffers)
    if not error <= work.trusted[0]:
        return False
    found = solution.reshape(n * width)
    if len(stored.values) > 0:
        moved[layout.moved[op] * width :] = 0.0
        spread(row(layout.by_unknowns, op).values, coefficients[run.unknowns[op] :], found, moved)
        saved = at(stored, op, k).values
        for j in range(len(saved)):
            saved[j] = moved[j]
    apply_map(maps.after, op, coefficients, own, found, own)
    return True


@compiled
def forward_panels(
    layout: Layout, run: Run, op: int, k: int, columns: int, matrices: Matrices, block: Block, work: Work,
    state: Array, stored: Series, sources: Series,
) -> bool:  # fmt: skip
    """An operation for all panels that have not made it; false if pivots must be renewed."""
    while work.done[0] < len(state):
        p = work.done[0]
        if not forward_operation(
            layout, run, op, k, p, columns, matrices, block, work, state[p], stored, sources
        ):
            return False
        work.done[0] += 1
    work.done[0] = 0
    block.used[op, 1] += 1
    return True


@compiled
def forward(
    layout: Layout, kernels: Kernels, b: Array, run: Run, timeline: Timeline, e: int, columns: int,
    matrices: Matrices, block: Block, work: Work, state: Array, given: NodeArrays, weighed: Weighing, stored: Series,
    sources: Series,
) -> int:  # fmt: skip
    """From operation e to the last; returns the one that needs new pivots, or how many there are.

    `state` are the derivatives of the state in panels (panels, entries * width). `given` takes them at nodes; of
    gradients in `weighed` there is one row for each node, too.
    """
    block.used[:] = 0
    while e < len(timeline.operations):
        op, k = timeline.operations[e], timeline.occurrences[e]
        if block.used[op, 1] == block.used[op, 0]:
            linearize(layout, kernels, b, run, op, k, 1, matrices, block)
        if timeline.initial[e] >= 0 and work.done[0] == 0:
            copy(timeline.states[timeline.initial[e]], state)
        if not forward_panels(layout, run, op, k, columns, matrices, block, work, state, stored, sources):
            break
        if timeline.nodes[e] >= 0:
            put_node(layout, timeline.nodes[e], work.right.shape[1], state, given, weighed)
        e += 1
    return e


@compiled
def put_node(layout: Layout, n: int, width: int, state: Array, given: NodeArrays, weighed: Weighing) -> None:
    """What is asked for at a node: derivatives of its state, or what they do to responses."""
    if len(weighed.by.q) > 0:
        choose_gradients(layout, weighed, n)
    for p in range(len(state)):
        if len(weighed.by.q) > 0:
            weigh_panel(weighed, p, width, state[p])
        if len(given.q) > 0:
            put_block(state[p], layout.node[0], p, width, given.q[n])
            put_block(state[p], layout.node[1], p, width, given.v[n])
            put_block(state[p], layout.node[2], p, width, given.a[n])
            put_block(state[p], layout.node[3], p, width, given.lam[n])


@compiled
def put_block(state: Array, first: int, p: int, width: int, out: Array) -> None:
    """The derivatives of a block of the state in panel p in their place."""
    put_panel(state[first * width : (first + out.shape[0]) * width], p, width, out)


@compiled
def put_panel(panel: Array, p: int, width: int, out: Array) -> None:
    """The columns of panel p in their place (n, columns)."""
    first = p * width
    whole = width > 1 and first + width <= out.shape[1]
    for k in range(np.uint64(out.shape[0])):
        if whole:
            own = out[k, first:]
            store(own, np.uint64(0), load(panel, k * TWO))
            store(own, ONE, load(panel, k * TWO + ONE))
        else:
            for c in range(min(width, out.shape[1] - first)):
                out[k, first + c] = panel[k * width + c]


@compiled
def choose_gradients(layout: Layout, weighed: Weighing, n: int) -> None:
    """Of the gradients of responses by the state of one node those that are not zero."""
    by, count = weighed.by, 0
    for r in range(by.q.shape[2]):
        count = choose(by.q[n], r, layout.node[0], weighed, count)
        count = choose(by.v[n], r, layout.node[1], weighed, count)
        count = choose(by.a[n], r, layout.node[2], weighed, count)
        count = choose(by.lam[n], r, layout.node[3], weighed, count)
        weighed.ends[r + 1] = count


@compiled
def choose(gradient: Array, r: int, first: int, weighed: Weighing, count: int) -> int:
    """Of those by one kind of states, which begin at a row; how many there are then."""
    for k in range(gradient.shape[0]):
        value = gradient[k, r]
        if value != 0.0:
            weighed.rows[count], weighed.values[count] = first + k, value
            count += 1
    return count


@compiled
def weigh_panel(weighed: Weighing, p: int, width: int, own: Array) -> None:
    """Add the change of responses by that of the state of panel p."""
    total = weighed.total[p]
    for r in range(np.uint64(len(weighed.ends) - 1)):
        first, last = weighed.ends[r], weighed.ends[r + ONE]
        if width == 1:
            for k in range(first, last):
                total[r] += weighed.values[k] * own[weighed.rows[k]]
        else:
            a, b = load(total, r * TWO), load(total, r * TWO + ONE)
            for k in range(first, last):
                value, place = fill(weighed.values[k]), weighed.rows[k] * TWO
                a, b = (
                    plus_product(a, value, load(own, place)),
                    plus_product(b, value, load(own, place + ONE)),
                )
            store(total, r * TWO, a)
            store(total, r * TWO + ONE, b)
