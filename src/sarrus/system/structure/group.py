"""Operators that are computed together: one compiled call for all elements of a system."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, cached_property, partial
from typing import Any

import numpy as np

from ..._jit.kernels.driver import COMPILING, Signature, compile_source, driver
from ..._jit.kernels.emit import HEADER
from ..._jit.kernels.pointer import KernelTable, kernel_table
from ..._jit.kernels.vector import LANES
from ...algebra import Array
from ...elements import BUILT_IN, GROUPS, OPERATORS
from ...elements.recorder import SCALARS, Variant, operands_of, record, variants
from .pattern import Pattern
from .population import Population


class Group:
    """The compiled drivers of a group of operators, with the index tables of one system.

    ``group.run(numbers, *operands, *outputs)`` writes every operator's numbers, unchecked; `operands` in the order of
    `group.operands` (scalars first), outputs in the order of `group.names`. For calls from other compiled code there
    are `group.compiled`, the driver of the common elements, and `group.index`, its tables.
    """

    def __init__(
        self, names: tuple[str, ...], populations: Sequence[Population], patterns: Sequence[Pattern]
    ):
        self.names = names
        self.patterns = tuple(patterns)
        found = operands_of(names)
        self.operands = (*(n for n in found if n in SCALARS), *(n for n in found if n not in SCALARS))
        family = OPERATORS[names[0]].family
        members = [p for p in populations if p.kind.family and p.kind.family[0].family == family]
        self._members = members
        shared = not any(is_long(name) for name in names)
        built_in = [n for n, p in enumerate(members) if p.variant in USUAL and shared]
        self.index = self._pack(members, built_in)
        self.compiled = built_in_driver(names)
        self._others = [
            (own_driver(names, members[n].variant), self._pack(members, [n]))
            for n in range(len(members))
            if n not in built_in and (members[n].count or shared)
        ]

    def _pack(self, members: Sequence[Population], chosen: Sequence[int]) -> Array:
        """Headers of the chosen populations, then their tables. See `emit.HEADER`."""
        width = HEADER + len(self.names)
        headers, tables = np.zeros((len(chosen), width), dtype=np.int64), []
        at = headers.size
        for slot, n in enumerate(chosen):
            p = members[n]
            parts = [p.bodies, p.rows, *(pattern.places[n] for pattern in self.patterns)]
            starts = at + np.cumsum([0, *(part.size for part in parts)])
            headers[slot] = [p.count, starts[0], starts[1], p.at, *starts[2:-1]]
            tables += [part.reshape(-1) for part in parts]
            at = int(starts[-1])
        return np.concatenate([headers.reshape(-1), *tables]).astype(np.int64)

    def run(self, numbers: Array, *arrays: Any) -> None:
        """Compute all operators of the group into the outputs given, as fast as compiled code is called.

        Nothing is checked: `numbers` must have the length of `system.b`, operands and outputs the lengths of
        `allocate()` and of the system, all contiguous arrays of floats, and t a float. Wrong lengths are not noticed:
        memory beyond the arrays is then read or overwritten. `System.Phi_q` and the like check theirs.
        """
        arrays = tuple(_writable(array) for array in arrays)
        self.compiled(self.index, numbers, *arrays)
        for run, index in self._others:
            run(index, numbers, *arrays)

    def bundle(self) -> tuple[Any, tuple[Array, ...]]:
        """All drivers as one compiled function ``(indices, numbers, *operands, *outputs)``, and its indices."""
        drivers = [self.compiled, *(run for run, _ in self._others)]
        arguments = ", ".join(f"a{n}" for n in range(len(self.operands) + len(self.names)))
        lines = [f"def bundle(indices, numbers, {arguments}):"]
        lines += [f"    driver_{n}(indices[{n}], numbers, {arguments})" for n in range(len(drivers))]
        name = "_".join(["bundle", *(run.py_func.__name__ for run in drivers)])
        function = compile_source(name, lines, {f"driver_{n}": run for n, run in enumerate(drivers)})
        return function, (self.index, *(index for _, index in self._others))

    def entry(self) -> KernelTable:
        """All drivers by address, for compiled loops that call them with `_jit.kernels.pointer.call_kernels`."""
        drivers = [self.compiled, *(run for run, _ in self._others)]
        return kernel_table(
            drivers, [self.index, *(index for _, index in self._others)], signature(self.names)
        )

    @cached_property
    def entry_in_lanes(self) -> KernelTable:
        """Drivers for several states at once, for compiled loops; what is summed is added to what is there."""
        members = [n for n, p in enumerate(self._members) if p.count]
        drivers = [own_driver(self.names, self._members[n].variant, LANES) for n in members]
        tables = [self._pack(self._members, [n]) for n in members]
        return kernel_table(drivers, tables, signature(self.names, lanes=LANES))

    def allocate(self) -> list[Array]:
        """Fresh outputs, one array per operator."""
        return [np.zeros(pattern.size) for pattern in self.patterns]


def _writable(array: Any) -> Any:
    """A read-only operand, such as a result's, as a copy: the drivers are compiled for arrays of one type."""
    return array.copy() if isinstance(array, np.ndarray) and not array.flags.writeable else array


USUAL = {variant for kind in BUILT_IN for variant in variants(kind)}
_drivers: dict[tuple[str, ...], Any] = {}
WIDE = 8  # moving bodies of an element: with more, LLVM takes minutes to vectorize its matrices


def is_long(name: str) -> bool:
    """Whether an operator is a derived matrix, whose code for all elements would take long to compile."""
    return OPERATORS[name].origin == "derived" and not OPERATORS[name].is_vector


def built_in_driver(names: tuple[str, ...]) -> Any:
    """The driver of a group over all built-in elements of its family: the same code for every system.

    Long operators are not compiled for elements that a system does not have: their driver only clears.
    """
    with COMPILING:
        if names not in _drivers:
            family = OPERATORS[names[0]].family
            kinds = [kind for kind in BUILT_IN if kind.family[0].family == family]
            if any(is_long(name) for name in names):
                kinds = []
            _drivers[names] = driver(
                signature(names),
                [partial(record, variant, names) for kind in kinds for variant in variants(kind)],
            )
        return _drivers[names]


@cache
def own_driver(names: tuple[str, ...], variant: Variant, lanes: int = 1) -> Any:
    """The driver of a group over one variant alone.

    Drivers of built-in elements are stored under their names, those of users' elements under a hash of their code.
    """
    wide = variant.moving > WIDE
    if variant.kind in BUILT_IN:
        with COMPILING:
            own = signature(names, variant.name, lanes, wide)
            return driver(own, [partial(record, variant, names)], clear=False)
    recording = record(variant, names)
    return driver(signature(names, recording.fingerprint(), lanes, wide), [lambda: recording], clear=False)


def signature(names: tuple[str, ...], suffix: str = "", lanes: int = 1, wide: bool = False) -> Signature:
    """What the driver of a group takes; that of a `wide` element is not vectorized."""
    found = operands_of(names)
    side_by_side = f"x{lanes}" if lanes > 1 else ""
    return Signature(
        name="_".join(filter(None, ("__".join(names), side_by_side, suffix))),
        scalars=tuple(n for n in found if n in SCALARS),
        arrays=tuple(n for n in found if n not in SCALARS),
        outputs=tuple(f"out_{name}" for name in names),
        clears=tuple(OPERATORS[name].sums or OPERATORS[name].is_vector for name in names),
        hot=lanes == 1 and not wide and (len(names) > 1 or names in GROUPS.values()),
        lanes=lanes,
    )
