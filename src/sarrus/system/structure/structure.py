"""Data common to systems that differ only in parameter values: patterns, tables of kernels, and what derives from them.

An optimization or a study creates a system for every design, nearly always with the same elements between the same
bodies. The structure is then one object for all of them, which exists as long as one of them does. The last few
structures of small systems exist longer, for programs that create a system, use it and create the next one.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Sequence
from dataclasses import replace
from threading import RLock
from typing import Any
from weakref import WeakValueDictionary

from ...model.coordinates import WIDTH
from .group import Group
from .magnitude import Magnitude
from .pattern import Layout, Pattern
from .population import Population


class Structure:
    """Elements without their parameter values: their kinds, bodies and equations, and positions of their parameters.

    Attributes
    ----------
    layout : the axes, of populations without values
    patterns, groups, magnitudes : by name and names; they are made at first use
    """

    def __init__(self, populations: Sequence[Population], bodies: int, rows: int, numbers: int) -> None:
        bare = [replace(p, values=[], owners=[], labels=[]) for p in populations]
        self.layout = Layout(bare, bodies, rows, numbers)
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


def structure_of(populations: Sequence[Population], bodies: int, rows: int, numbers: int) -> Structure:
    """The structure of these elements: one object for all systems that have it."""
    own = tuple(
        (p.variant, p.at, p.bodies.tobytes(), p.rows.tobytes(), p.constraints.tobytes())
        for p in populations
        if p.count
    )
    key = (own, bodies, rows, numbers)
    with _asking:
        found = _known.get(key)
        if found is None:
            found = _known[key] = Structure(populations, bodies, rows, numbers)
        if bodies * WIDTH <= SMALL:
            _recent[key] = found
            _recent.move_to_end(key)
            if len(_recent) > RECENT:
                _recent.popitem(last=False)
        return found
