"""Where the coordinates of a system are in q and v: blocks, each of one kind and one owner."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..algebra import Array
from ..elements.element import POSITION, ROTATION, Kind
from ..model.coordinates import WIDTH

STATES = Kind("states", POSITION.parts, True)  # first-order states: displacements of a hidden body


class Block(NamedTuple):
    """A block of coordinates.

    Attributes
    ----------
    kind : Kind
    owner : the body, or ``states 1``: a hidden body, whose Euler parameters are held by constraints
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

    def scale(self, length: float) -> float:
        """The size of a unit change: the length for positions, 1 for Euler parameters."""
        return length if self.kind.is_length else 1.0


@dataclass(frozen=True, eq=False)
class Layout:
    """The blocks of all coordinates in their order, and index arrays that follow from them.

    An owner is a body or a hidden body of first-order states, all of whose blocks are adjacent.
    """

    blocks: tuple[Block, ...]

    @classmethod
    def of(cls, bodies: Sequence[str], hidden: int = 0) -> Layout:
        """The layout of bodies by name, and of hidden bodies of states."""
        owners = [(POSITION, name) for name in bodies]
        owners += [(STATES, f"states {n + 1}") for n in range(hidden)]
        first = range(0, WIDTH * len(owners), WIDTH)
        return cls(
            tuple(
                block
                for (kind, name), at in zip(owners, first, strict=True)
                for block in (Block(kind, name, at), Block(ROTATION, name, at + len(kind.parts)))
            )
        )

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.blocks[-1].slice.stop if self.blocks else 0

    @cached_property
    def bodies(self) -> Layout:
        """The blocks of bodies alone, which come first."""
        hidden = {block.owner for block in self.blocks if block.kind is STATES}
        return Layout(tuple(block for block in self.blocks if block.owner not in hidden))

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
        """Where the blocks of each owner begin and end: r, p, and the next owner (owners, 3)."""
        return np.column_stack([self.firsts, self.rotations[:, 0], self.rotations[:, -1] + 1])

    @cached_property
    def positions(self) -> Array:
        """Indices of the positions of bodies (bodies, 3)."""
        return self._places(POSITION)

    @cached_property
    def rotations(self) -> Array:
        """Indices of all Euler parameters (owners, 4)."""
        return self._places(ROTATION)

    @cached_property
    def is_length(self) -> Array:
        """Which coordinates are divided by a length: all but Euler parameters (nq,)."""
        return np.repeat(np.array([block.kind.is_length for block in self.blocks], dtype=bool), self.widths)

    def scales(self, length: float) -> Array:
        """The size of a unit change of each coordinate, see `Block.scale` (nq,)."""
        return np.where(self.is_length, length, 1.0)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates, such as ``crank.p.e0``."""
        return tuple(f"{block.owner}.{part}" for block in self.blocks for part in block.kind.parts)

    def _places(self, kind: Kind) -> Array:
        first = np.array([block.start for block in self.blocks if block.kind is kind], dtype=np.int64)
        return first[:, None] + np.arange(len(kind.parts))
