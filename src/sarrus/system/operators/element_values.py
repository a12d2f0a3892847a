"""Scalar values that elements compute from a state: their state variables, and their potential energies."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache, partial
from typing import Any

import numpy as np

from ..._jit.kernels.driver import COMPILING, Signature, driver
from ..._jit.kernels.emit import HEADER
from ..._jit.kernels.pointer import NONE, KernelTable, kernel_table
from ...algebra import Array
from ...elements import BUILT_IN
from ...elements.recorder import Variant, record_scalars
from ..structure.population import Population


class ElementValues:
    """The values that a method of elements computes from a state: one row of values for each element with this method.

    Attributes
    ----------
    size : total number of values
    owners : the part of the model that each value belongs to
    """

    def __init__(self, method: str, populations: Iterable[Population]) -> None:
        self._method = method
        self._members = [p for p in populations if p.count and callable(getattr(p.kind, method, None))]
        widths = [_count(p, method) for p in self._members]
        starts = np.cumsum([0, *(p.count * width for p, width in zip(self._members, widths, strict=True))])
        self.size = int(starts[-1])
        self.owners = [
            o for p, width in zip(self._members, widths, strict=True) for o in p.owners for _ in range(width)
        ]
        self._drivers = [_driver(p.variant, method) for p in self._members]
        self._tables = [
            _table(p, width, int(start))
            for p, width, start in zip(self._members, widths, starts, strict=False)
        ]

    def entry(self) -> KernelTable:
        """For compiled loops, see `Group.entry`; the operands are t, q and the output array."""
        if not self._members:
            return NONE
        return kernel_table(self._drivers, self._tables, _signature(self._method))

    def __call__(self, q: Array, b: Array, t: float) -> Array:
        """All values at a state."""
        out = np.zeros(self.size)
        for run, table in zip(self._drivers, self._tables, strict=True):
            run(table, b, float(t), q, out)
        return out


def memory_places(populations: Iterable[Population]) -> Array:
    """Indices in `b` of the elements' state variables, in the order of `ElementValues("remember")`."""
    found = []
    for p in populations:
        if p.count and "Memory" in p.kind.fields.values():
            starts = np.cumsum([0, *p.kind.widths()])
            memory = [
                start for start, kind in zip(starts, p.kind.fields.values(), strict=False) if kind == "Memory"
            ]
            found += [p.at + k * p.kind.size() + start for k in range(p.count) for start in memory]
    return np.array(found, dtype=np.int64)


def _count(p: Population, method: str) -> int:
    return len(record_scalars(p.variant, method).outputs[0].blocks)


def _table(p: Population, width: int, start: int) -> Array:
    """Header, bodies, rows and positions of a population's values, as `emit` reads them."""
    places = np.zeros((p.count, width, 2), dtype=np.int64)
    places[:, :, 0] = start + np.arange(p.count * width).reshape(p.count, width)
    parts = [part.reshape(-1) for part in (p.bodies, p.rows, places)]
    at = np.cumsum([HEADER + 1, *(len(part) for part in parts)])
    header = [p.count, at[0], at[1], p.at, at[2]]
    return np.concatenate([header, *parts]).astype(np.int64)


def _signature(name: str) -> Signature:
    return Signature(name, ("t",), ("q",), ("out",), (False,))


@cache
def _driver(variant: Variant, method: str) -> Any:
    with COMPILING:
        if variant.kind in BUILT_IN:
            return driver(
                _signature(f"{method}_{variant.name}"), [partial(record_scalars, variant, method)], False
            )
        recording = record_scalars(variant, method)
        return driver(_signature(f"{method}_{recording.fingerprint()}"), [lambda: recording], False)
