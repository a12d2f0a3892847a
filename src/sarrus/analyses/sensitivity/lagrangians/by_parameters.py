"""Derivatives of the equations of an operation with respect to element parameters, in lanes.

With ℓ = μᵀR of an operation (`shares`), backward sweeps take ∂ℓ/∂b, forward ones the change R_b b'.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...._jit.formulas.differentiate import directional
from ...._jit.formulas.reverse import gradient
from ...._jit.kernels import pointer
from ...._jit.kernels.emit import NUMBERS_DOT, Recording
from ....algebra import Array
from ....elements.recorder import Variant
from ....system import System
from ....system.cached import once_alike
from ....system.curves.lanes import Recipe, block, entry, entry_with, own_rows, own_tables
from .elements import STATES, Share, concerned

ADJOINT = (*STATES, "xi", "lam", "nu")
CHANGES = (*STATES, "lam", NUMBERS_DOT)
NO_ROWS = np.zeros(0, np.int64)


@once_alike
def gradient_entry(system: System, kind: str) -> Any:
    """Operands t, `ADJOINT`; ∂ℓ/∂b is added to the output."""
    every = [p for p in concerned(system, kind) if p.kind.size()]
    return entry(
        every, [Recipe(p.variant, _gradient, kind, ADJOINT) for p in every], ("numbers",), "gradient"
    )


class Elements(NamedTuple):
    """The elements of some kinds one after another: drivers, equations of results, and whose each number is, or -1."""

    entry: pointer.KernelTable
    rows: Array
    first: Array
    owners: Array


@once_alike
def elements(system: System, kind: str, chosen: tuple[int, ...]) -> Elements:
    """The drivers of R_b b' for the kinds of elements that are chosen of those concerned.

    Operands t, `CHANGES`; results along coordinates and along equations are added to two outputs, which may be one.
    """
    every = concerned(system, kind)
    own = [every[n] for n in chosen]
    tables, rows = [own_tables(p) for p in own], [own_rows(p, system.nq) for p in own]
    recipes = [Recipe(p.variant, _change, kind, CHANGES) for p in own]
    entry = entry_with([table.ravel() for table in tables], recipes, ("coordinates", "rows"), "change")
    owners, count = np.full(system.nb, -1), 0
    for p in own:
        owners[p.at : p.end] = count + np.repeat(np.arange(p.count), p.kind.size())
        count += p.count
    counts = [p.count for p in own]
    by_element = entry._replace(addresses=np.repeat(entry.addresses, counts), starts=_starts(tables))
    return Elements(by_element, np.concatenate([NO_ROWS, *(x.ravel() for x in rows)]), _starts(rows), owners)


def _starts(arrays: Sequence[Array]) -> Array:
    """Return the first index of each row of concatenated arrays, and the end."""
    return np.concatenate([[0], np.cumsum([size for x in arrays for size in [x.shape[1]] * len(x)])]).astype(
        np.int64
    )


def _gradient(variant: Variant, kind: str) -> Recording:
    share = Share(variant, kind)
    found = gradient(share.graph, share.value, list(share.numbers))
    return share.recording(ADJOINT, [block(share.free(found))])


def _change(variant: Variant, kind: str) -> Recording:
    share = Share(variant, kind)
    xi = share.moving["xi"].reshape(-1)
    equations = gradient(share.graph, share.value, [*xi, *share.nu])
    dots = share.graph.inputs(NUMBERS_DOT, variant.kind.size())
    pairs = [(x, dot) for x, dot, held in zip(share.numbers, dots, share.held, strict=True) if not held]
    found = directional(share.graph, equations, pairs)
    return share.recording(CHANGES, [share.variant.split(found[: len(xi)]), block(found[len(xi) :])])
