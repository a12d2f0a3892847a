"""Scalar values that elements compute from a state: their state variables, and their potential energies."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from ..._jit.kernels.driver import COMPILING, Signature, driver
from ..._jit.kernels.emit import HEADER, Recording
from ..._jit.kernels.pointer import NONE, KernelTable, kernel_table
from ...algebra import Array
from ...elements import BUILT_IN
from ...elements.recorder import Variant, record_scalars
from ..structure.population import Population

Recorder = Callable[[Variant], Recording]  # one block of the only output for each value


class ElementValues:
    """The values that elements compute from a state: one row of values for each element.

    Parameters
    ----------
    name : under which compiled code is stored
    populations : of the elements
    record : what is computed, with the time and `operands`; by default what the method of that name returns, of
        elements that have it

    Attributes
    ----------
    size : total number of values
    owners : the part of the model that each value belongs to
    widths, starts : values of one element of each population with elements, and where those of the first one begin
    """

    def __init__(
        self, name: str, populations: Iterable[Population], record: Recorder | None = None,
        operands: tuple[str, ...] = ("q",),
    ) -> None:  # fmt: skip
        self._signature = Signature(name, ("t",), operands, ("out",), (False,))
        members = [p for p in populations if p.count and (record or callable(getattr(p.kind, name, None)))]
        made = record or _method(name)
        self.widths = [len(made(p.variant).outputs[0].blocks) for p in members]
        starts = np.cumsum([0, *(p.count * width for p, width in zip(members, self.widths, strict=True))])
        self.starts, self.size = starts[:-1].tolist(), int(starts[-1])
        self.owners = [
            o for p, width in zip(members, self.widths, strict=True) for o in p.owners for _ in range(width)
        ]
        self._drivers = [_driver(p.variant, self._signature, made) for p in members]
        self._tables = [_table(*x) for x in zip(members, self.widths, self.starts, strict=True)]

    def entry(self) -> KernelTable:
        """For compiled loops, see `Group.entry`; the operands are t, those given, and the output array."""
        return kernel_table(self._drivers, self._tables, self._signature) if self._drivers else NONE

    def __call__(self, q: Array, b: Array, t: float) -> Array:
        """All values at a state, where q is the only operand."""
        out, q = (
            np.zeros(self.size),
            np.require(q, float, ("C", "W")),
        )  # the drivers are compiled for such arrays
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


def _table(p: Population, width: int, start: int) -> Array:
    """Header, bodies, rows and positions of a population's values, as `emit` reads them."""
    places = np.zeros((p.count, width, 2), dtype=np.int64)
    places[:, :, 0] = start + np.arange(p.count * width).reshape(p.count, width)
    parts = [part.reshape(-1) for part in (p.bodies, p.rows, places)]
    at = np.cumsum([HEADER + 1, *(len(part) for part in parts)])
    header = [p.count, at[0], at[1], p.at, at[2]]
    return np.concatenate([header, *parts]).astype(np.int64)


@cache
def _method(name: str) -> Recorder:
    """The same for the same name, so that drivers are found again."""
    return partial(record_scalars, method=name)


@cache
def _driver(variant: Variant, signature: Signature, record: Recorder) -> Any:
    with COMPILING:
        if variant.kind in BUILT_IN and isinstance(
            record, partial
        ):  # a method, among the sources of all kernels
            own = replace(signature, name=f"{signature.name}_{variant.name}")
            return driver(own, [partial(record, variant)], False)
        recording = record(variant)
        own = replace(signature, name=f"{signature.name}_{recording.fingerprint()}")
        return driver(own, [lambda: recording], False)
