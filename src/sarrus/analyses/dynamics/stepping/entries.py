"""Kernel tables of a system's operators, by which compiled loops call them; cached for each system."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...._jit.kernels.pointer import NONE, KernelTable
from ....system import System
from ....system.cached import once_alike
from ....system.operators.element_values import ElementValues


@once_alike
def entry_of(system: System, *names: str) -> KernelTable:
    """The entry of operators that are computed together, or of "remembered" or "potentials"."""
    if names[0] in ("remembered", "potentials"):
        values: ElementValues = getattr(system, names[0])
        return values.entry()
    group = system.group(*names)
    found = group.entry()
    return (
        found._replace(tables=group.index) if len(found.addresses) == 1 else found
    )  # one table is not copied


def joined(entries: Sequence[KernelTable]) -> KernelTable:
    """Several entries as one: their drivers one after another."""
    shifts = np.cumsum([0, *(len(entry.tables) for entry in entries)])
    starts = [entry.starts[:-1] + shift for entry, shift in zip(entries, shifts, strict=False)]
    addresses, tables = (
        np.concatenate([getattr(NONE, name), *(getattr(entry, name) for entry in entries)])
        for name in ("addresses", "tables")
    )
    return KernelTable(addresses, np.concatenate([*starts, shifts[-1:]]).astype(np.int64), tables)
