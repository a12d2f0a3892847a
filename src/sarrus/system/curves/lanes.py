"""Arrays in SIMD lanes, and calls of kernels for many states at once.

The system takes as long to provide and release fresh pages as a sweep takes to fill them, so large arrays reuse memory
that nothing refers to any more.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Sequence
from functools import cache
from math import prod
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from ..._jit.formulas.expression import Graph
from ..._jit.kernels import pointer
from ..._jit.kernels.driver import COMPILING, Signature, driver
from ..._jit.kernels.emit import HEADER, Recording
from ..._jit.kernels.vector import LANES
from ..._jit.linking.cache import stored_value
from ...algebra import Array
from ...elements import BUILT_IN
from ...elements.evaluation import element_from, partition
from ...elements.recorder import Variant
from ..structure.population import Population

LINE = 64  # bytes that are read at once
SMALL, LARGE, MOST = (
    1 << 14,
    1 << 20,
    1 << 23,
)  # numbers: limits of stored arrays, and of all of them together
UNUSED = 3  # references to an array that only the list below holds, while it is looked at
_LENT: list[Array] = []
_LOOKING = Lock()


def used(*shape: int) -> Array:
    """An uninitialized array."""
    size = prod(shape) + LINE // 8
    found = _lent(-(-size // LINE) * LINE) if SMALL < size < LARGE else np.empty(size)
    first = -found.ctypes.data % LINE // 8
    return found[first : first + prod(shape)].reshape(shape)


def _lent(size: int) -> Array:
    with _LOOKING:
        for n in range(len(_LENT)):
            if len(_LENT[n]) == size and sys.getrefcount(_LENT[n]) < UNUSED:
                _LENT.append(_LENT.pop(n))
                return _LENT[-1]
        while _LENT and sum(map(len, _LENT)) + size > MOST:
            _LENT.pop(0)
        _LENT.append(np.empty(size))
        return _LENT[-1]


def aligned(*shape: int) -> Array:
    """Zeros aligned to a cache line."""
    found = used(*shape)
    found[...] = 0.0
    return found


def buffer(entries: int, *rows: int) -> Array:
    """Zeros in lanes."""
    return aligned(*rows, entries * LANES)


def block(values: Sequence[Any]) -> list[Array]:
    """Return one block, or None if it is empty."""
    return [np.array(values, dtype=object)] if len(values) else []


def local(variant: Variant, flat: Array, name: str) -> Any:
    """Coordinates of an element's bodies, or a direction in them; some bodies may be the ground."""
    return partition(variant.kind, variant.gathered(flat, name))


def recorded_element(variant: Variant, graph: Graph, numbers: Array) -> tuple[Any, tuple[Any, Any, Any]]:
    """An element with recorded numbers, and a recorded state of its bodies."""
    element = element_from(variant.kind, numbers, t=graph.input("t"))
    x, v = (local(variant, variant.inputs(graph, name), name) for name in ("q", "v"))
    return element, (x, v, graph.input("t"))


class Recipe(NamedTuple):
    """A recording that is made only if it has to be compiled.

    Attributes
    ----------
    variant : of an element
    make : records it, ``make(variant, quantity)``
    quantity : which one is recorded
    arrays : operands
    """

    variant: Variant
    make: Callable[[Variant, Any], Recording]
    quantity: str
    arrays: tuple[str, ...]


@cache
def _recorded(recipe: Recipe) -> Recording:
    return recipe.make(recipe.variant, recipe.quantity)


@cache
def fingerprint(recipe: Recipe) -> str:
    """That of the recording. Of a built-in element it depends on sources alone, and is stored."""
    if recipe.variant.kind not in BUILT_IN:
        return _recorded(recipe).fingerprint()
    sources = _sources(recipe.make.__module__)
    name = f"{recipe.make.__name__}.{recipe.variant.name}.{recipe.quantity}.{sources}"
    return str(stored_value(name, lambda: _recorded(recipe).fingerprint()))


@cache
def _sources(module: str) -> str:
    """Hash of this file, and of those in the folder of a module: what recordings depend on besides elements."""
    own, given = (Path(sys.modules[name].__file__ or "") for name in (__name__, module))
    files = [own, *sorted(given.parent.glob("*.py"))]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


def entry(
    populations: Sequence[Population],
    recipes: Sequence[Recipe],
    outputs: Sequence[str],
    title: str,
    firsts: Sequence[int] | None = None,
) -> pointer.KernelTable:
    """Drivers in lanes, one for each population, to be called by their addresses; `outputs` names what each is along.

    Compiled under the hash of what they compute. `firsts`: where the numbers of each population begin in an output
    along numbers; by default as in b.
    """
    places = [p.at for p in populations] if firsts is None else firsts
    tables = [_table(p, outputs, first) for p, first in zip(populations, places, strict=True)]
    return entry_with(tables, recipes, outputs, title)


def entry_with(
    tables: Sequence[Array], recipes: Sequence[Recipe], outputs: Sequence[str], title: str
) -> pointer.KernelTable:
    """The same with tables of one's own."""
    found = [_driver(recipe, outputs, title) for recipe in recipes]
    return (
        pointer.kernel_table(found, [*tables], _signature(recipes[0], outputs, title))
        if found
        else pointer.NONE
    )


def _signature(recipe: Recipe, outputs: Sequence[str], title: str) -> Signature:
    name = f"{title}_x{LANES}_{recipe.variant.name}.{recipe.quantity}_{fingerprint(recipe)}"
    outs = tuple(f"out_{n}" for n in range(len(outputs)))
    return Signature(name, ("t",), recipe.arrays, outs, (False,) * len(outs), lanes=LANES)


def _driver(recipe: Recipe, outputs: Sequence[str], title: str) -> Any:
    own = _signature(recipe, outputs, title)
    with COMPILING:
        if own.name not in _drivers:
            _drivers[own.name] = driver(own, [lambda: _recorded(recipe)], clear=False)
        return _drivers[own.name]


_drivers: dict[str, Any] = {}


def _table(p: Population, outputs: Sequence[str], first: int) -> Array:
    """Header, bodies, rows and places of a population, as `emit` reads them."""
    coordinates = [_place(p.bodies[:, slot]) for slot in range(p.variant.moving)]
    none = np.zeros((p.count, 0, 2), np.int64)
    places = {
        "coordinates": np.stack(coordinates, axis=1) if coordinates else none,
        "rows": _place(p.rows)[:, None] if p.kind.rows else none,
        "numbers": _place(first + p.kind.size() * np.arange(p.count))[:, None] if p.kind.size() else none,
        "one": _place(np.zeros(p.count, np.int64))[:, None],
    }
    parts = [part.reshape(-1) for part in (p.bodies, p.rows, *(places[along] for along in outputs))]
    starts = HEADER + len(outputs) + np.cumsum([0, *(len(part) for part in parts)])
    header = [p.count, starts[0], starts[1], p.at, *starts[2:-1]]
    return np.concatenate([header, *parts]).astype(np.int64)


def own_tables(p: Population) -> Array:
    """For every element of a population a table by itself (count, entries).

    What it computes along the coordinates of its bodies, and then along its equations, is put one after another.
    """
    bodies, numbers = p.bodies.reshape(p.count, -1), p.at + p.kind.size() * np.arange(p.count)
    ends = np.cumsum([0, *p.variant.widths])
    along = [(at, 1) for at in (ends if p.kind.rows else ends[:-1])]
    first = HEADER + 2
    header = [1, first, first + bodies.shape[1], first + bodies.shape[1] + 1, 0]
    header[4] = header[3] + 2 * p.variant.moving
    table = [np.tile(header[:3], (p.count, 1)), numbers[:, None], np.tile(header[3:], (p.count, 1))]
    table += [bodies, p.rows.reshape(-1, 1), np.tile(np.ravel(along), (p.count, 1))]
    return np.concatenate(table, axis=1).astype(np.int64)


def own_rows(p: Population, nq: int) -> Array:
    """Which equations the results of `own_tables` belong to (count, results), those of constraints after all others."""
    return np.concatenate([p.coordinates, nq + p.rows.reshape(-1, 1) + np.arange(p.kind.rows)], axis=1)


def _place(first: Array) -> Array:
    return np.stack([np.asarray(first), np.ones(len(first))], axis=1).astype(np.int64)
