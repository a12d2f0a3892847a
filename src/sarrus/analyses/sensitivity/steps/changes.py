"""Changes of the equations of operations with the element parameters: one call for each element concerned."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...._jit.kernels import pointer
from ....algebra import Array
from ....system import System
from ....system.curves.lanes import buffer
from ...dynamics.methods.tables import NOWHERE, Group, Tables
from ...dynamics.stepping.entries import joined
from ..lagrangians.by_parameters import elements
from ..lagrangians.elements import concerned
from .block_loop import Changes
from .stacked import ragged

NO_INDICES = np.zeros(0, np.int64)
NONE = ragged([NO_INDICES] * 3)
UNCHANGED = Changes(
    pointer.NONE, np.zeros((0, 0)), ragged([np.zeros((0, 5))] * 3), np.zeros(0), NONE, NONE,
    ragged([NO_INDICES] * 3, float), NONE, 1,
)  # of sweeps backwards  # fmt: skip


class _Results(NamedTuple):
    """Of the calls of one group: their columns and elements, sizes, and of all results equation (row, -1: none)."""

    columns: Array
    elements: Array
    sizes: Array
    rows: Array
    equations: Array
    signs: Array


def changes(system: System, tables: Sequence[Tables | None], dots: Array, width: int) -> Changes:
    """For changes of the numbers (columns, len(b)), in panels of some width."""
    entries: list[pointer.KernelTable] = []
    calls, every, first, count = list[Array](), list[Array](), 0, 0
    panels = -(-len(dots) // width)
    for own in tables:
        rows, results = [np.zeros((0, 5), np.int64)], [np.zeros((0, 5))]
        pairs = (
            ((n, _results(system, group, own.nq, dots)) for n, group in enumerate(own.groups)) if own else ()
        )
        for n, (entry, found) in pairs:
            ends = first + np.cumsum([0, *found.sizes])
            columns = np.repeat(found.columns, found.sizes)
            rows.append(np.column_stack([found.columns, count + found.elements, np.full(len(found.columns), n),
                                         ends[:-1], ends[1:]]))  # fmt: skip
            at = np.arange(first, ends[-1])
            places = columns // width, width * found.rows + columns % width
            whole = np.column_stack([*places, found.equations, found.signs, at])
            results.append(whole[found.equations != NOWHERE])
            first, count = int(ends[-1]), count + len(entry.addresses)
            entries.append(entry)
        calls.append(np.concatenate(rows))
        whole = np.concatenate(results)
        every += [whole[whole[:, 0] == p] for p in range(panels)]
    kinds: dict[str, Any] = {"places": np.int64, "equations": np.int64, "signs": float, "chosen": np.int64}
    stacked = {
        name: ragged([x[:, n] for x in every], kind) for n, (name, kind) in enumerate(kinds.items(), start=1)
    }
    return Changes(
        entry=joined(entries), dots=dots, calls=ragged(calls), results=buffer(first), panels=panels, **stacked
    )


def _results(system: System, group: Group, nq: int, dots: Array) -> tuple[pointer.KernelTable, _Results]:
    """The calls of one group of equations."""
    kind, touched = group.kind.kind, np.any(dots != 0.0, axis=0)
    own = tuple(n for n, p in enumerate(concerned(system, kind)) if touched[p.at : p.end].any())
    found = elements(system, kind, own)
    columns, numbers = np.nonzero(dots[:, : system.nb])
    count = len(found.first) - 1
    calls = np.unique((columns * count + found.owners[numbers])[found.owners[numbers] >= 0])
    columns, chosen = np.divmod(calls, max(count, 1))
    sizes = np.diff(found.first)[chosen]
    starts = np.cumsum([0, *sizes])
    rows = found.rows[np.repeat(found.first[chosen] - starts[:-1], sizes) + np.arange(starts[-1])]
    above = rows < nq
    first, last = (nq + row for row in group.rows)
    there = np.where((first <= rows) & (rows < last), group.nu_equation, NOWHERE)
    equations = np.where(above, group.xi_equation, there)
    places = np.where(above, group.xi + rows, group.nu + rows - nq)
    signs = np.where(above, 1.0, group.kind.sign)
    return found.entry, _Results(columns, chosen, sizes, places, equations, signs)
