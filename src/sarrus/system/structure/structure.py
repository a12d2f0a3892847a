"""Data common to systems that differ only in parameter values: patterns, tables of kernels, and what derives from them.

An optimization or a study creates a system for every design, nearly always with the same elements between the same
bodies. The structure is then one object for all of them, which exists as long as one of them does. The last few
structures of small systems exist longer, for programs that create a system, use it and create the next one.

A sum with cancellation contains no information about its round-off. Tests for "balanced" or "zero" compare with these
sums, which cannot vanish by cancellation.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Sequence
from dataclasses import replace
from threading import RLock
from typing import Any
from weakref import WeakValueDictionary

import numpy as np

from ...algebra import Array
from ...elements.operators import Operator
from .group import Group
from .pattern import Axes, Pattern
from .population import Population


class Magnitude:
    """An operator evaluated element by element, for sums of absolute values; cached per structure.

    The compiled loops write each block of each element to a separate position, given by the index tables.
    """

    def __init__(self, axes: Axes, operator: Operator, pattern: Pattern) -> None:
        members = [n for n, p in enumerate(axes.populations) if operator in p.kind.family]
        self._size, self._targets = pattern.size, np.zeros(0, dtype=np.int64)
        places = [
            self._separate(axes, operator, n, old) for n, old in zip(members, pattern.places, strict=True)
        ]
        none = np.zeros(0, dtype=np.int64)
        separate = Pattern((len(self._targets),), none, none, tuple(places))
        self._group = Group((operator.name,), axes.populations, [separate])
        self.operands = self._group.operands

    def _separate(self, axes: Axes, operator: Operator, n: int, old: Array) -> Array:
        """A table of separate positions; the target of each value is appended to the targets."""
        heights, widths = _shapes(axes, operator, n, old.shape[:2])
        size = heights * widths
        start = len(self._targets) + np.cumsum(size.reshape(-1)) - size.reshape(-1)
        within = np.arange(int(size.sum())) - np.repeat(start - len(self._targets), size.reshape(-1))
        base, stride, width = (
            np.repeat(x.reshape(-1), size.reshape(-1)) for x in (old[..., 0], old[..., 1], widths)
        )
        targets = base + within // width * stride + within % width
        self._targets = np.concatenate([self._targets, targets])
        return np.stack([start.reshape(size.shape), np.where(widths > 0, widths, 1)], axis=-1)

    def __call__(self, numbers: Array, operands: Sequence[object]) -> Array:
        """The values of the operator's pattern."""
        out = np.zeros(len(self._targets))
        self._group.run(numbers, *operands, out)
        return np.bincount(self._targets, weights=abs(out), minlength=self._size)


def _shapes(axes: Axes, operator: Operator, n: int, count: tuple[int, ...]) -> tuple[Array, Array]:
    """Height and width of every block of every element of population n (elements, blocks)."""
    sizes = np.ones((2, *count), dtype=np.int64)
    for side, axis in enumerate(operator.axes):
        for k, block in enumerate(axes.blocks(n, operator)):
            sizes[side, :, k] = axes.atoms(axis).width[axes.atom_of(n, axis, block[side])]
    return sizes[0], sizes[1]


class Structure:
    """Elements without their parameter values: their kinds, bodies and equations, and positions of their parameters.

    Attributes
    ----------
    axes : of populations without values
    patterns, groups, magnitudes : by name and names; they are made at first use
    """

    def __init__(self, populations: Sequence[Population], widths: Array, rows: int, numbers: int) -> None:
        bare = [replace(p, values=[], owners=[], labels=[]) for p in populations]
        self.axes = Axes(bare, widths, rows, numbers)
        self.patterns: dict[str, Pattern] = {}
        self.groups: dict[tuple[str, ...], Group] = {}
        self.magnitudes: dict[str, Magnitude] = {}

    def __getstate__(self) -> dict[str, Any]:
        """Everything except the compiled groups, which are created again at first use."""
        return {**self.__dict__, "groups": {}, "magnitudes": {}}


RECENT = 16  # structures that are cached without a system
SMALL = 2000  # coordinates of the systems whose structures are: larger ones take too much memory
_recent: OrderedDict[Hashable, Structure] = OrderedDict()
_known: WeakValueDictionary[Hashable, Structure] = WeakValueDictionary()
_asking = RLock()


def structure_of(populations: Sequence[Population], widths: Array, rows: int, numbers: int) -> Structure:
    """The structure of these elements and widths of blocks: one object for all systems that have it."""
    own = tuple(
        (p.variant, p.at, p.bodies.tobytes(), p.rows.tobytes(), p.constraints.tobytes())
        for p in populations
        if p.count
    )
    key = (own, widths.tobytes(), rows, numbers)
    with _asking:
        found = _known.get(key)
        if found is None:
            found = _known[key] = Structure(populations, widths, rows, numbers)
        if widths.sum() <= SMALL:
            _recent[key] = found
            _recent.move_to_end(key)
            if len(_recent) > RECENT:
                _recent.popitem(last=False)
        return found
