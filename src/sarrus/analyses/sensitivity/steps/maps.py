"""Affine maps between states, stages and unknowns, emitted for the structure of an operation and called by address.

One pass over the entries of a map computes all blocks that it sets: it reads each block that it needs once. Generic
loops over blocks took a fifth of the sweep of a small system. A map has its coefficients as arguments, so that it is
compiled once for all values of a method's coefficients, step sizes and numbers of columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...._jit.kernels import pointer
from ...._jit.kernels.driver import COMPILING, Signature, compile_source
from ...._jit.kernels.lanes import fill, load, plus_product, product, store
from ...._jit.kernels.vector import LANES
from ....algebra import Array
from ....system import System
from ....system.cached import once_alike
from ...dynamics.methods.description import CONSTRAINTS
from ...dynamics.methods.tables import Quantity, Structure, Tables

NAMESPACE = {
    "np": np,
    "load": load,
    "store": store,
    "fill": fill,
    "plus_product": plus_product,
    "product": product,
}
Block = tuple[str, str | Quantity]  # vector, and which of its blocks


class KernelTable(NamedTuple):
    """A term of a block that is set: its coefficient (None: 1), and the block that it takes."""

    coefficient: int | None
    of: Block


Rows = dict[Block, list[KernelTable]]  # blocks that are set, by others


class Drivers(NamedTuple):
    """One driver of each operation, or none: see `KernelTable`; `at` is where that of each begins."""

    addresses: Array
    starts: Array
    tables: Array
    at: Array


class Maps(NamedTuple):
    """The maps of all operations, see `maps_of`: drivers one after another."""

    moved: Drivers
    after: Drivers
    right: Drivers
    before: Drivers


def _grouped(tables: Tables) -> tuple[list[Rows], list[Rows]]:
    """Forward `moved`, `after`; backward `right`, `before`; coefficients count through all four kinds of terms."""
    places, at = [], 0
    kinds: Sequence[Sequence[tuple[str | Quantity, str]]] = (
        tables.by_state, tables.by_unknowns, tables.from_state, tables.from_unknowns,
    )  # fmt: skip
    for kind in kinds:
        places.append(range(at, at + len(kind)))
        at += len(kind)
    state = [name for name, _ in tables.structure.state]
    updated = {name for name, _ in tables.structure.update}
    moved: Rows = {("stages", key): [] for key in tables.moving}
    after: Rows = {("state", name): [] for name in state if name in updated}
    right: Rows = {("unknowns", name): [] for name, _ in tables.structure.unknowns}
    before: Rows = {("state", n): [] if n in updated else [KernelTable(None, ("state", n))] for n in state}
    for n, (key, name) in zip(places[0], tables.by_state, strict=True):
        moved["stages", key].append(KernelTable(n, ("state", name)))
        before["state", name].append(KernelTable(n, ("stages", key)))
    for n, (to, name) in zip(places[2], tables.from_state, strict=True):
        after["state", to].append(KernelTable(n, ("state", name)))
        before["state", name].append(KernelTable(n, ("state", to)))
    for n, (to, name) in zip(places[3], tables.from_unknowns, strict=True):
        after["state", to].append(KernelTable(n, ("unknowns", name)))
        right["unknowns", name].append(KernelTable(n, ("state", to)))
    return [moved, after], [right, before]


@once_alike
def maps_of(system: System, structures: tuple[Structure | None, ...], width: int, forward: bool) -> Maps:
    """The maps of operations for vectors with some columns (entries * width): forward, or backward."""
    n, m = system.nq * width, system.m * width
    pairs = [_entries(one, n, m, forward) if one else (pointer.NONE,) * 2 for one in structures]
    first, second = (_stacked([pair[n] for pair in pairs]) for n in (0, 1))
    none = _stacked([pointer.NONE] * len(pairs))
    return Maps(first, second, none, none) if forward else Maps(none, none, first, second)


def _stacked(entries: Sequence[pointer.KernelTable]) -> Drivers:
    counts = np.cumsum([0, *(len(one.addresses) for one in entries)])
    addresses = np.concatenate([one.addresses for one in entries])
    tables = np.concatenate([one.tables for one in entries])
    starts = 2 * np.arange(len(addresses) + 1)
    return Drivers(addresses, starts, tables, counts.astype(np.int64))


def _entries(
    structure: Structure, n: int, m: int, forward: bool
) -> tuple[pointer.KernelTable, pointer.KernelTable]:
    found = _compiled(structure, forward)
    table = np.array([n, m], np.int64)
    return pointer.kernel_table([found[0]], [table], SIGNATURE), pointer.kernel_table(
        [found[1]], [table], SIGNATURE
    )


SIGNATURE = Signature("map", (), ("state", "other"), ("out",), (False,))


@cache
def _compiled(structure: Structure, forward: bool) -> list[Any]:
    """Both maps of an operation in one direction."""
    tables = Tables(structure, 0, 0, 0)
    rows = _grouped(tables)[0 if forward else 1]
    with COMPILING:
        drivers = [compile_source("affine_map", _lines(tables, own), NAMESPACE) for own in rows]
        for driver in drivers:
            driver.compile(SIGNATURE.types())
    return drivers


def _lines(tables: Tables, rows: Rows) -> list[str]:
    """The source: from the state and another vector to one that is set, which may be the state itself."""
    names: dict[Block, str] = {}
    for block in (*rows, *(entry.of for own in rows.values() for entry in own)):
        names.setdefault(block, f"x{len(names)}")
    to = next(iter(rows))[0]
    lines = [
        "def affine_map(index, c, state, other, out):",
        "    n, m = np.uint64(index[0]), np.uint64(index[1])",
    ]
    for block, name in names.items():
        vector = "out" if block[0] == to else "state" if block[0] == "state" else "other"
        lines.append(f"    {name} = {vector}[{_first(tables, block)}:]")
    used = sorted({e.coefficient for own in rows.values() for e in own if e.coefficient is not None})
    lines += [f"    c{k}, f{k} = c[{k}], fill(c[{k}])" for k in used]
    for size in ("n", "m"):
        own = {block: entries for block, entries in rows.items() if _size(tables, block) == size}
        if own:
            lines += [f"    for k in range({size} // np.uint64({LANES})):", *_pass(own, names, True)]
            lines += [
                f"    for k in range({size} // np.uint64({LANES}) * np.uint64({LANES}), {size}):",
                *_pass(own, names, False),
            ]
    return lines


def _pass(rows: Rows, names: dict[Block, str], vector: bool) -> list[str]:
    """One entry, or those of a vector, of all blocks that are set: all are read before one is written."""
    needed = dict.fromkeys(entry.of for own in rows.values() for entry in own)
    lines = [
        f"u_{names[b]} = load({names[b]}, k)" if vector else f"u_{names[b]} = {names[b]}[k]" for b in needed
    ]
    results = []
    for block, entries in rows.items():
        total = "fill(0.0)" if vector else "0.0"
        for number, (k, of) in enumerate(entries):
            x = f"u_{names[of]}"
            if vector:
                factor = "fill(1.0)" if k is None else f"f{k}"
                total = f"plus_product({total}, {factor}, {x})" if number else f"product({factor}, {x})"
            else:
                term = x if k is None else f"c{k} * {x}"
                total = f"{total} + {term}" if number else term
        lines.append(f"r_{names[block]} = {total}")
        results.append(block)
    writes = (
        f"store({names[b]}, k, r_{names[b]})" if vector else f"{names[b]}[k] = r_{names[b]}" for b in results
    )
    return [f"        {line}" for line in (*lines, *writes)]


def _size(tables: Tables, block: Block) -> str:
    vector, name = block
    if vector == "stages":
        return "m" if name[1] in ("lam", "mu") else "n"
    sizes = dict(tables.structure.state if vector == "state" else tables.structure.unknowns)
    return "m" if sizes[str(name)] == CONSTRAINTS else "n"


def _first(tables: Tables, block: Block) -> str:
    """The first entry of a block, by the sizes of those before it in its vector."""
    vector, name = block
    every: list[Any] = list(
        tables.stages if vector == "stages" else tables.state if vector == "state" else tables.unknowns
    )
    before = [_size(tables, (vector, other)) for other in every[: every.index(name)]]
    return f"np.uint64({before.count('n')}) * n + np.uint64({before.count('m')}) * m"
