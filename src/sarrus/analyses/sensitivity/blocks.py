"""Room for a block of steps whose derivatives are evaluated together: patterns, tables, and arrays in lanes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._jit.pointer import NONE
from ..._jit.vector import LANES
from ...algebra import Array
from ...system import System
from ...system.lane_room import room, rooms, used
from ...system.once import once_alike
from ..dynamics.newton_matrix import NUMBERS, alpha_parts, weigh
from ..dynamics.placed import Numbers, Part, layout_of
from .block_loop import Block, Cuts, Entries, Lanes, Product, Refinement
from .by_numbers import UNMOVED, gradient_entry, moved
from .columns_loop import COLUMNS, ByRows
from .kernels import GROUPS
from .panel_loop import Factors
from .row_order import by_rows, no_rows, rows_of
from .step_matrix import StepMatrix, unsigned

OPERATORS = (*NUMBERS, "gamma_v")  # whose numbers are evaluated
STEP = {"M_a_q": -1.0, "S_q": 1.0, "Q_q": 1.0, "Phi_qT_lam_q": -1.0, "S_v": 1.0, "Q_v": 1.0, "Phi_q": 1.0}
RESCALE = {"M_a_q": -1.0, "Phi_qT_lam_q": -1.0, "gamma_v": -0.5, "Phi_q": 1.0}


def _whole(count: int) -> int:
    """The next multiple of the number of lanes."""
    return -(-count // LANES) * LANES


class Blocks:
    """Blocks of steps and of changes of their size of one run; one matrix for both.

    Parameters
    ----------
    system : System
    columns : how many derivatives or responses are swept at once
    b_dot : (len(system.b), k) changes of the numbers, for a sweep forward

    Attributes
    ----------
    width : how many columns are handled side by side: forward those of a panel, or a single one; backward all
    matrix : of a single step; the order of its pivots serves all lanes
    by_rows : that matrix by rows, for panels
    steps, rescales : the blocks; they share room for what is turned, and not needed then
    """

    def __init__(self, system: System, columns: int, b_dot: Array | None) -> None:
        self._system, self._columns = system, columns
        nq, m = system.nq, system.m
        self._numbers = Numbers(system, OPERATORS)
        self.matrix = StepMatrix(self._numbers, nq + m, alpha_parts(nq))
        groups = (system.group(*GROUPS[name]) for name in Entries._fields)
        self.entries = Entries._make(group.entry_in_lanes for group in groups)
        self._values = room(len(self._numbers.values))
        self._dots = np.zeros((0, len(system.b))) if b_dot is None else np.ascontiguousarray(b_dot.T)
        self._panels = len(self._dots) > 1
        self.width = COLUMNS if self._panels else columns
        self.by_rows = ByRows(no_rows(), no_rows())
        self.steps = self._block("step", product_of(system, "step", self._panels))
        self.rescales = self._block("rate", product_of(system, "rate", self._panels))

    def _block(self, kind: str, product: Product) -> Block:
        system, numbers, k = self._system, self._numbers, self._columns
        nq, m, forward = system.nq, system.m, len(self._dots) > 0
        values, backward = self._values, 0 if forward else k
        starts = {name: numbers.start[name] for name in numbers.names}
        views = {
            name: values[start * LANES : (start + len(numbers.views[name])) * LANES]
            for name, start in starts.items()
        }
        weights = room(1, len(self.matrix.weights))
        weights[:] = 1.0
        weigh(weights, 0.0, 0.0)
        sizes = {"t": 1, "lam": m, "Phi_q_xi": m, "Phi_t": m, "work": nq + m, "growth": 1}
        sizes |= dict.fromkeys(("q", "v", "a", "eta"), nq)
        given: dict[str, Any] = views | rooms(sizes) | {
            "steps": np.zeros(LANES, np.int64), "lanes": Lanes.zeros(), "values": values,
            "row_of": numbers.row_of, "weights": weights, "product": product,
            "sheet": room(0), "turned": np.zeros((LANES, 0)),
            "cuts": Cuts.zeros(), "refined": Refinement.of(1.0, 1.0, 1.0),
            "entry": NONE if forward else gradient_entry(system, kind),
            "xi": room(nq, backward), "nu": room(m, backward), "by_b": room(system.nb, backward),
            "moved": moved(system, kind, self._dots, self.width) if forward else UNMOVED,
        }  # fmt: skip
        return Block(**given)

    def arrange(self, known: Factors | None = None) -> Factors:
        """Room for factors in the blocks, in a known order of pivots, or in one for what is in the matrix now."""
        matrix = known or self.matrix.in_panels()
        parts = [len(matrix.factors), len(matrix.data)]
        both = [
            Cuts.of(*np.cumsum([_whole(n) for n in (*parts, len(x.product.indices))]))
            for x in (self.steps, self.rescales)
        ]
        sheet = used(LANES * int(max(max(cuts.product, cuts.end - cuts.product) for cuts in both)))
        self.steps, self.rescales = (
            block._replace(sheet=sheet, turned=used(LANES, int(cuts.end)), cuts=cuts)
            for block, cuts in zip((self.steps, self.rescales), both, strict=True)
        )
        if self._panels:
            self.by_rows = by_rows(matrix)
        return matrix

    def gradient(self) -> Array:
        """What the adjoint variables have given for the gradient by the numbers (nb, k), which is taken."""
        found = np.zeros((self._system.nb, self._columns))
        for block in (self.steps, self.rescales):
            found -= block.by_b.reshape(self._columns, -1, LANES).sum(axis=2).T
            block.by_b[:] = 0.0
        return found


@once_alike
def product_of(system: System, kind: str, panels: bool) -> Product:
    """P made of some operators."""
    nq, m = system.nq, system.m
    weights = STEP if kind == "step" else RESCALE
    places = {"S_v": (0, nq), "Q_v": (0, nq), "Phi_q": (nq, 0)}
    if kind == "rate":
        places |= {"gamma_v": (nq, 0), "Phi_q": (nq, nq)}
    kinds = tuple(Part(name, *places.get(name, (0, 0))) for name in weights)
    layout = layout_of(system, max(2 * nq, nq + m), (), kinds)
    numbers = Numbers(system, OPERATORS)
    rows = [(numbers.start[name], len(numbers.views[name])) for name in weights]
    parts = np.column_stack([np.array(rows), layout.first]).astype(np.int64)
    filled = room(len(weights))
    filled[:] = np.repeat(list(weights.values()), LANES)
    place, indptr, indices = unsigned((layout.place, layout.indptr, layout.indices))
    pattern = layout.indptr, layout.indices, np.arange(len(layout.indices))
    by_rows = rows_of(*pattern, nq + m) if panels else no_rows()
    return Product(parts, place, filled, indptr, indices, by_rows)
