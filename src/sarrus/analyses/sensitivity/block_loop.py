"""What is evaluated and factored for a block of steps at once, one in every lane? (Functions that are compiled.)

In a sweep all states are known: operators, matrices and their factors do not wait for what is swept. A block holds
steps that follow one another, or changes of the step size. In arrays "in lanes" every entry is a number for each lane.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

from ..._jit.link import compiled
from ..._jit.pointer import Entry, call_kernels
from ..._jit.scalars import Scalars
from ..._jit.vector import LANES
from ...algebra import Array
from ..dynamics.alpha_loop import Scheme, weights_of
from ..dynamics.newton_matrix import weigh
from .by_numbers import Moved
from .columns_loop import ByRows, Rows, solve_panel
from .lanes_loop import assemble_lanes, clear_lanes, factor_lanes, turn_lanes
from .panel_loop import REFINEMENTS, Factors, solve_columns_transposed, solve_flat, solve_plain_transposed

if TYPE_CHECKING:
    from .sweep_loop import Work

UNKNOWN = 1.0  # relative change of a solution by its refinement, before there was one
LARGER = 1e2  # times the squares of L may be those of factors with which a solution needed no refinement


class Record(NamedTuple):
    """The steps as they were taken; see `sarrus.results.Steps`."""

    t: Array
    h: Array
    removed: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    left_out: Array
    places: Array
    memory: Array


class Entries(NamedTuple):
    """The drivers of the operators, by address, and their entries; in lanes."""

    velocity: Entry
    jacobian: Entry
    inertia: Entry
    stiffness: Entry
    gamma_v: Entry


class Product(NamedTuple):
    """A matrix P (nq + m, 2 nq) by columns, made of the numbers of operators as `dynamics.placed` tells.

    rows : the same by rows, for panels of columns
    """

    parts: Array
    places: Array
    weights: Array
    indptr: Array
    indices: Array
    rows: Rows


class Lanes(Scalars):
    """How many lanes of a block are in use, and which of them is next."""

    used: int
    next: int


class Chosen(Protocol):
    """Steps in lanes, and which lanes are in use."""

    @property
    def steps(self) -> Array:
        """The steps (lanes,)."""

    @property
    def lanes(self) -> Lanes:
        """See `Lanes`."""


class Remembered(Protocol):
    """What elements remember during the steps, and the equations that are left out, of a record of steps."""

    @property
    def left_out(self) -> Array:
        """At the ends of steps (n + 1, m), or none."""

    @property
    def places(self) -> Array:
        """Of what elements remember, in b."""

    @property
    def memory(self) -> Array:
        """During each step (n, places)."""


class Refinement(Scalars):
    """The last refinement of a block's solutions.

    Attributes
    ----------
    change : the relative change of the solution
    growth : the growth of the factors with which it was solved
    limit : the change up to which the next solutions are not refined
    """

    change: float
    growth: float
    limit: float


class Cuts(Scalars):
    """Where the numbers of J and those of P begin behind the factors, and where they end."""

    matrix: int
    product: int
    end: int


class Block(NamedTuple):
    """Some steps or changes of their size.

    steps, lanes : (lanes,) the steps; see `Lanes`
    t to lam : states in lanes; of a change of step size with s, v - s, σ in place of a, η, λ
    values, then operators, row_of : all numbers of operators, in lanes; each one's part; the equation of those of Φ_q
    weights, product : of the parts of J; P, by which changes of q and v enter the right sides
    sheet, turned, cuts : factors and numbers of J one after another, then those of P, in lanes; all of them lane by
        lane; where they begin there
    work : (nq + m), in lanes
    growth : of the factors, in lanes
    refined : see `Refinement`
    entry, xi, nu, by_b : see `by_numbers`; backwards, operands and result, one row for each column, in lanes
    moved : forwards, what changes of b do, see `by_numbers`
    """

    steps: Array
    lanes: Lanes
    t: Array
    q: Array
    v: Array
    a: Array
    eta: Array
    lam: Array
    values: Array
    M: Array
    M_a_q: Array
    S_q: Array
    S_v: Array
    Q_q: Array
    Q_v: Array
    Phi_qT_lam_q: Array
    left_out: Array
    Phi_q: Array
    gamma_v: Array
    Phi_q_xi: Array
    Phi_t: Array
    row_of: Array
    weights: Array
    product: Product
    sheet: Array
    turned: Array
    cuts: Cuts
    work: Array
    growth: Array
    refined: Refinement
    entry: Entry
    xi: Array
    nu: Array
    by_b: Array
    moved: Moved


@compiled
def factors_of(matrix: Factors, block: Block, lane: int) -> Factors:
    """The matrix of one lane and its factors."""
    factors, data = (
        block.turned[lane, : block.cuts.matrix],
        block.turned[lane, block.cuts.matrix : block.cuts.product],
    )
    return Factors(
        matrix.parts, matrix.weights, matrix.places, matrix.indptr, matrix.indices, data, matrix.pointers, matrix.rows,
        matrix.diagonal, factors, matrix.ends, matrix.work, matrix.row_place, matrix.column_order,
    )  # fmt: skip


@compiled
def plainly(refined: Refinement, growth: float) -> bool:
    """Whether a solution with factors of some growth need not be refined."""
    return refined.change <= refined.limit and growth <= LARGER * refined.growth


@compiled
def solve_lane(
    own: Factors, by_rows: ByRows, refined: Refinement, growth: float, begun: bool, right: Array,
    solution: Array, room: Array,
) -> float:  # fmt: skip
    """Solve with the factors of one lane, for one column as in `solve_lane_transposed`, or for a panel of them.

    Panels are not refined where that changed next to nothing in all panels of the same block that were; each is in the
    block's first lane, which tells the growth, too. `begun`: whether this is not that one.
    """
    size, alone = right.shape[0] * right.shape[1], right.shape[1] == 1
    given, found = right.reshape(size), solution.reshape(size)
    x, rest, whole = room[0].reshape(size), room[1].reshape(size), room[2].reshape(size)
    plain = plainly(refined, growth) and (alone or begun)
    most = 0 if plain else REFINEMENTS
    if alone:
        first, change = solve_flat(own, given, found, x, rest, whole, most)
    else:
        first, change = solve_panel(own, by_rows, given, found, x, rest, most)
    if plain:
        return refined.change
    refined.change = first if alone or refined.change == UNKNOWN else max(first, refined.change)
    if alone or not begun:
        refined.growth = growth
    return change


@compiled
def solve_lane_transposed(
    own: Factors, refined: Refinement, growth: float, right: Array, solution: Array, room: Array
) -> float:
    """Solve with the transposed factors of one lane; the last relative change of the solution.

    It is not refined where that changed next to nothing in the same block, with factors about as large.
    """
    if plainly(refined, growth):
        solve_plain_transposed(own, right, solution, room)
        return refined.change
    first, change = solve_columns_transposed(own, right, solution, room)
    refined.change, refined.growth = first, growth
    return change


@compiled
def alike(record: Record, n: int, k: int) -> bool:
    """Whether elements remembered the same during two steps, and the same equations were left out."""
    for i in range(len(record.places)):
        if record.memory[n, i] != record.memory[k, i]:
            return False
    if len(record.left_out) > 0:
        for i in range(record.left_out.shape[1]):
            if record.left_out[n + 1, i] != record.left_out[k + 1, i]:
                return False
    return True


@compiled
def collect(record: Record, n: int, last: int, way: int, rescales: bool, block: Chosen) -> None:
    """Fill the lanes with steps that are alike, from n on; those that are left repeat one."""
    count, k = 0, n
    while count < LANES and (last - k) * way >= 0:
        if not rescales or record.removed[k] != 0.0:
            if not alike(record, n, k):
                break
            block.steps[count] = k
            count += 1
        k += way
    for lane in range(count, LANES):
        block.steps[lane] = n
    block.lanes.used, block.lanes.next = count, 0


@compiled
def put(x: Array, lane: int, weight: float, out: Array) -> None:
    """A lane of out = weight x."""
    for k in range(len(x)):
        out[k * LANES + lane] = weight * x[k]


@compiled
def gather(record: Record, after: int, block: Block) -> None:
    """The states at the steps' ends (after = 1) or starts; adjoint variables begin with zero."""
    for lane in range(LANES):
        node = block.steps[lane] + after
        block.t[lane] = record.t[node]
        put(record.q[node], lane, 1.0, block.q)
        put(record.v[node], lane, 1.0, block.v)
        put(record.a[node], lane, 1.0, block.a)
        put(record.lam[node], lane, 1.0, block.lam)
    block.xi[:], block.nu[:] = 0.0, 0.0


@compiled
def remember(b: Array, record: Remembered, block: Chosen) -> None:
    """What elements remembered during the steps of a block."""
    for k in range(len(record.places)):
        b[record.places[k]] = record.memory[block.steps[0], k]


@compiled
def leave_out(record: Record, block: Block) -> None:
    """Equations that are left out have no gradient."""
    if len(record.left_out) > 0:
        out = record.left_out[block.steps[0] + 1]
        for k in range(len(block.left_out)):
            block.left_out[k] = out[k // LANES]
        for k in range(len(block.Phi_q)):
            block.Phi_q[k] *= 1.0 - out[block.row_of[k // LANES]]


@compiled
def solved_rows(record: Record, n: int, x: Array) -> None:
    """Zero in the rows of equations that are left out in step n."""
    if len(record.left_out) > 0:
        m = record.left_out.shape[1]
        below = x[x.shape[0] - m :]
        for k in range(m):
            if record.left_out[n + 1, k] > 0.0:
                below[k, :] = 0.0


@compiled
def evaluate(entries: Entries, b: Array, record: Record, block: Block) -> None:
    """The numbers of the operators of constraints and inertia; all others are zero."""
    clear_lanes(block.values)
    call_kernels(entries.jacobian, b, block.t, block.q, block.lam, block.Phi_q, block.Phi_qT_lam_q)
    call_kernels(entries.inertia, b, block.q, block.v, block.a, block.M, block.M_a_q, block.S_q, block.S_v)
    leave_out(record, block)


@compiled
def factor_block(matrix: Factors, block: Block) -> None:
    """Assemble and factor J."""
    first, last = block.cuts.matrix, block.cuts.product
    factors, data = block.sheet[: first * LANES], block.sheet[first * LANES : last * LANES]
    assemble_lanes(matrix.parts, matrix.places, block.weights, block.values, data)
    factor_lanes(
        matrix.pointers, matrix.rows, matrix.diagonal, matrix.ends, matrix.indptr, matrix.indices, data, factors,
        block.work, block.growth,
    )  # fmt: skip
    block.refined.change = UNKNOWN
    turn_lanes(block.sheet, last, block.turned, 0)


@compiled
def make_product(block: Block) -> None:
    """Assemble P."""
    product, first, last = block.product, block.cuts.product, block.cuts.end
    data = block.sheet[: (last - first) * LANES]
    assemble_lanes(product.parts, product.places, product.weights, block.values, data)
    turn_lanes(block.sheet, last - first, block.turned, first)


@compiled
def change(b: Array, block: Block) -> None:
    """Forwards, what changes of the numbers do, element by element."""
    moved = block.moved
    clear_lanes(moved.results)
    for n in range(len(moved.columns)):
        element, dots = moved.elements[n], moved.dots[moved.columns[n]]
        out = moved.results[moved.first[n] * LANES : moved.first[n + 1] * LANES]
        every = moved.entry
        own = Entry(every.addresses[element : element + 1], every.starts[element : element + 2], every.tables)
        call_kernels(own, b, block.t, block.q, block.v, block.a, block.eta, block.lam, dots, out, out)


@compiled
def finish(b: Array, record: Record, block: Block) -> None:
    """Backwards, what the adjoint variables give for the gradient by the numbers; the block is used up."""
    if block.lanes.used > 0:
        remember(b, record, block)
        for c in range(len(block.xi)):
            call_kernels(
                block.entry, b, block.t, block.q, block.v, block.a, block.eta, block.xi[c], block.lam, block.nu[c],
                block.by_b[c],
            )  # fmt: skip
    block.lanes.used = block.lanes.next = 0


@compiled
def linearize_steps(
    scheme: Scheme, entries: Entries, b: Array, record: Record, n: int, last: int, way: int, matrix: Factors,
    block: Block,
) -> None:  # fmt: skip
    """Evaluate and factor for the steps from n on, up or down."""
    collect(record, n, last, way, False, block)
    gather(record, 1, block)
    remember(b, record, block)
    evaluate(entries, b, record, block)
    call_kernels(entries.stiffness, b, block.t, block.q, block.v, block.Q_q, block.Q_v)
    for lane in range(LANES):
        beta, gamma = weights_of(scheme, record.h[block.steps[lane]])
        weigh(block.weights[:, lane], beta, gamma)
    factor_block(matrix, block)
    make_product(block)
    change(b, block)


@compiled
def linearize_rescales(
    entries: Entries, b: Array, record: Record, n: int, last: int, way: int, matrix: Factors, by_rows: ByRows,
    block: Block, work: Work,
) -> bool:  # fmt: skip
    """The same for changes of the step size from step n on; false if pivots must be renewed for it.

    M s + Φ_qᵀσ = 0, Φ_q s = d = Φ_q v + Φ_t. Derivatives: of the first line (M s)_q + (Φ_qᵀσ)_q, of the second line
    less d: -G with G = (Φ_q (v - s))_q + Φ_tq = -½ γ_v(q, v - s).
    """
    collect(record, n, last, way, True, block)
    gather(record, 0, block)
    remember(b, record, block)
    evaluate(entries, b, record, block)
    factor_block(matrix, block)
    clear_lanes(block.Phi_q_xi)
    clear_lanes(block.Phi_t)
    call_kernels(entries.velocity, b, block.t, block.q, block.v, block.Phi_q_xi, block.Phi_t)
    for lane in range(block.lanes.used):
        if not take_defect(record, matrix, by_rows, block, lane, work):
            block.lanes.used = lane
            break
    if block.lanes.used == 0:
        return False
    evaluate(entries, b, record, block)
    call_kernels(entries.gamma_v, b, block.t, block.q, block.eta, block.gamma_v)
    make_product(block)
    change(b, block)
    return True


@compiled
def take_defect(
    record: Record, matrix: Factors, by_rows: ByRows, block: Block, lane: int, work: Work
) -> bool:
    """s and σ of one lane in place of a and λ; false if pivots must be renewed."""
    nq, m = record.q.shape[1], record.lam.shape[1]
    right, found = work.single[0], work.single[1]
    right[:nq] = 0.0
    for k in range(m):
        right[nq + k, 0] = block.Phi_q_xi[k * LANES + lane] + block.Phi_t[k * LANES + lane]
    solved_rows(record, block.steps[lane], right)
    own = factors_of(matrix, block, lane)
    if (
        not solve_lane(own, by_rows, block.refined, block.growth[lane], True, right, found, work.single[2:])
        <= work.progress.trusted
    ):
        return False
    for k in range(nq):
        place = k * LANES + lane
        block.a[place] = found[k, 0]
        block.eta[place] = block.v[place] - found[k, 0]
    for k in range(m):
        block.lam[k * LANES + lane] = found[nq + k, 0]
    return True
