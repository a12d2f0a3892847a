"""Magnitude of an operator's components before the elements' contributions cancel: the sum of their absolute values.

A sum with cancellation contains no information about its round-off. Tests for "balanced" or "zero" compare with these
sums, which cannot vanish by cancellation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...algebra import Array
from ...elements.operators import Operator
from .group import Group
from .pattern import Layout, Pattern


class Magnitude:
    """An operator evaluated element by element, for sums of absolute values; cached per structure.

    The compiled loops write each block of each element to a separate position, given by the index tables.
    """

    def __init__(self, layout: Layout, operator: Operator, pattern: Pattern) -> None:
        members = [n for n, p in enumerate(layout.populations) if operator in p.kind.family]
        self._size, self._targets = pattern.size, np.zeros(0, dtype=np.int64)
        places = [
            self._separate(layout, operator, n, old) for n, old in zip(members, pattern.places, strict=True)
        ]
        none = np.zeros(0, dtype=np.int64)
        separate = Pattern((len(self._targets),), none, none, tuple(places))
        self._group = Group((operator.name,), layout.populations, [separate])
        self.operands = self._group.operands

    def _separate(self, layout: Layout, operator: Operator, n: int, old: Array) -> Array:
        """A table of separate positions; the target of each value is appended to the targets."""
        heights, widths = _shapes(layout, operator, n, old.shape[:2])
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


def _shapes(layout: Layout, operator: Operator, n: int, count: tuple[int, ...]) -> tuple[Array, Array]:
    """Height and width of every block of every element of population n (elements, blocks)."""
    sizes = np.ones((2, *count), dtype=np.int64)
    for side, axis in enumerate(operator.axes):
        for k, block in enumerate(layout.blocks(n, operator)):
            sizes[side, :, k] = layout.atoms(axis).width[layout.atom_of(n, axis, block[side])]
    return sizes[0], sizes[1]
