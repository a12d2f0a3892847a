"""Where the coordinates of a system are in q and v: blocks, each of one kind and one owner."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..algebra import Array
from ..elements.element import POSITION, ROTATION, Kind
from ..model.states.block import STATES


class Block(NamedTuple):
    """A block of coordinates.

    Attributes
    ----------
    kind : Kind
    owner : the body, the block of a part, or ``states 1``: a hidden body, whose Euler parameters are held
    start : index of its first coordinate
    """

    kind: Kind
    owner: str
    start: int

    @property
    def width(self) -> int:
        """Number of its coordinates."""
        return len(self.kind.parts)

    @property
    def slice(self) -> slice:
        """Its indices in q and v."""
        return slice(self.start, self.start + self.width)


@dataclass(frozen=True, eq=False)
class Layout:
    """The blocks of all coordinates in their order, and index arrays that follow from them.

    All blocks of an owner are adjacent, displacements first. Owners are bodies, then what else moves, such as the modes
    of a body, then hidden bodies of first-order states.
    """

    blocks: tuple[Block, ...]

    @classmethod
    def of(cls, owners: Mapping[str, tuple[Kind, ...]]) -> Layout:
        """The layout of the blocks of owners by name."""
        blocks: list[Block] = []
        for name, kinds in owners.items():
            for kind in kinds:
                blocks.append(Block(kind, name, blocks[-1].slice.stop if blocks else 0))
        return cls(tuple(blocks))

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.blocks[-1].slice.stop if self.blocks else 0

    @cached_property
    def bodies(self) -> Layout:
        """The blocks of bodies alone, which come first."""
        bodies = {block.owner for block in self.blocks if block.kind == POSITION}
        return Layout(tuple(block for block in self.blocks if block.owner in bodies))

    @cached_property
    def moving(self) -> Layout:
        """The blocks of all that moves, without first-order states, which come last."""
        states = {block.owner for block in self.blocks if block.kind == STATES}
        return Layout(tuple(block for block in self.blocks if block.owner not in states))

    @cached_property
    def widths(self) -> Array:
        """Widths of the blocks."""
        return np.array([block.width for block in self.blocks], dtype=np.int64)

    @cached_property
    def starts(self) -> Array:
        """First coordinate of each block."""
        return np.array([block.start for block in self.blocks], dtype=np.int64)

    @cached_property
    def owners(self) -> tuple[str, ...]:
        """Names of the owners."""
        return tuple(dict.fromkeys(block.owner for block in self.blocks))

    @cached_property
    def firsts(self) -> Array:
        """First coordinate of each owner."""
        first = {block.owner: block.start for block in reversed(self.blocks)}
        return np.array([first[owner] for owner in self.owners], dtype=np.int64)

    @cached_property
    def owner_of(self) -> Array:
        """Index of the owner of each coordinate (nq,)."""
        return np.searchsorted(self.firsts, np.arange(self.size), side="right") - 1

    @cached_property
    def bounds(self) -> Array:
        """Where displacements, what is none, and the next owner begin, for each owner (owners, 3)."""
        lengths = np.bincount(self.owner_of, self.is_length, len(self.firsts)).astype(np.int64)
        return np.column_stack([self.firsts, self.firsts + lengths, np.append(self.firsts[1:], self.size)])

    @cached_property
    def positions(self) -> Array:
        """Indices of the positions of bodies (bodies, 3)."""
        return self._places(POSITION)

    @cached_property
    def rotations(self) -> Array:
        """Indices of all Euler parameters (owners that have some, 4)."""
        return self._places(ROTATION)

    @cached_property
    def is_length(self) -> Array:
        """Which coordinates are divided by a length: all but Euler parameters (nq,)."""
        return np.repeat(np.array([block.kind.is_length for block in self.blocks], dtype=bool), self.widths)

    def scales(self, length: float) -> Array:
        """The size of a unit change of each coordinate, see `Kind.scale` (nq,)."""
        return np.repeat(np.array([block.kind.scale(length) for block in self.blocks]), self.widths)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates, such as ``crank.p.e0``."""
        return tuple(f"{block.owner}.{part}" for block in self.blocks for part in block.kind.parts)

    def _places(self, kind: Kind) -> Array:
        first = np.array([block.start for block in self.blocks if block.kind == kind], dtype=np.int64)
        return first[:, None] + np.arange(len(kind.parts))
