"""Blocks of states: three states are the velocities of a hidden body of unit mass that only translates.

    m v̇ = m f(v, outputs, t),    x = v

so that x' = f is one of the equations of motion, with all its derivatives, in every method. Unused slots of the body
are held by constraints. See decision 046.

States that drivers follow are two coordinates of such a body; the third is a clock τ = t: ṡ - f(s, outputs, τ) τ̇ = 0.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...algebra import I3, Array, Row
from ...elements import InertiaElement, Primitive, Single
from ...elements.element import Grid, Scalar, Time
from ..arithmetic import Numeric
from ..primitive import Primitive as Piece
from ..signals import Measure, Signal
from ..tape import value_of
from .rate_load import CLOCK, SLOTS, Slots


class StateValue(NamedTuple):
    """A state of a part: its name as an output, its initial value, its unit, and its size for tolerances."""

    name: str
    initial: Numeric
    unit: str = ""
    nominal: float = 1.0


class StateInertia(InertiaElement, derivatives="automatic", rare=True, registered=False):
    """The inertia of a block: a mass that translates."""

    mass: Scalar  # [kg] a scale alone, which the states do not depend on

    def M(self, x: Single) -> Grid:
        return (self.mass * I3, None), (None, None)

    def S(self, x: Single, v: Single) -> Row:
        return None, None


class Unused(Primitive, abstract=True):
    """Slots of a block without a state, and its rotation, are held."""

    used: ClassVar[int]

    def Phi(self, x: Single) -> Array:
        return np.array([*x.r[self.used :], *x.p[1:]])

    def Phi_b(self, x: Single) -> Row:
        return (None,) * len(self.fields)

    def Phi_q_xi_b(self, x: Single, xi: Single) -> Row:
        return self.Phi_b(x)

    def Phi_q_xi_q_eta_b(self, x: Single, xi: Single, eta: Single) -> Row:
        return self.Phi_b(x)

    def Phi_qT_lam_b(self, x: Single, lam: Array) -> Grid:
        return self.Phi_b(x), self.Phi_b(x)


class UnusedAfterOne(Unused, rows=5, bodies=1, derivatives="automatic", rare=True, registered=False):
    """Of a block with one state."""

    used = 1


class UnusedAfterTwo(Unused, rows=4, bodies=1, derivatives="automatic", rare=True, registered=False):
    """Of a block with two states."""

    used = 2


class UnusedAfterThree(Unused, rows=3, bodies=1, derivatives="automatic", rare=True, registered=False):
    """Of a block with three states."""

    used = 3


class Clocked(Unused, abstract=True):
    """The same with a clock in the last slot, for states that drivers follow."""

    t: Time  # which subclasses declare

    def Phi(self, x: Single) -> Array:
        return np.array([*x.r[self.used : CLOCK], x.r[CLOCK] - self.t, *x.p[1:]])


class ClockedAfterOne(Clocked, rows=5, bodies=1, derivatives="automatic", rare=True, registered=False):
    """A block with one state and a clock."""

    used = 1
    t: Time


class ClockedAfterTwo(Clocked, rows=4, bodies=1, derivatives="automatic", rare=True, registered=False):
    """A block with two states and a clock."""

    used = 2
    t: Time


UNUSED: tuple[type[Unused], ...] = (UnusedAfterOne, UnusedAfterTwo, UnusedAfterThree)
CLOCKED: tuple[type[Unused], ...] = (ClockedAfterOne, ClockedAfterTwo)


class Block(NamedTuple):
    """A block: the name of its body, its states, its mass, and whether drivers follow the states."""

    name: str
    states: tuple[StateValue, ...]
    mass: float
    followed: bool = False

    def initial(self) -> Array:
        """The initial values in the slots of its body (3,)."""
        values = [state.initial for state in self.states]
        return np.array(values + [0.0] * (SLOTS - len(values)))

    def primitives(self) -> tuple[Piece, Piece]:
        """Its inertia, and the constraints of what is unused."""
        unused = (CLOCKED if self.followed else UNUSED)[len(self.states) - 1]
        return (
            Piece(StateInertia, (self.name,), (self.mass,), "states"),
            Piece(unused, (self.name,), (), "unused"),
        )

    def signals(self) -> Mapping[str, Signal]:
        """The states by name, for formulas."""
        measure = Measure(Slots, (self.name,), (self.mass,))
        read = ("positions", 1) if self.followed else ("values", 2)
        return {one.name: Signal(measure, *read, n, one.unit) for n, one in enumerate(self.states)}


def blocks_of(
    states: Iterable[StateValue], masses: Iterable[Any], followed: Collection[str] = ()
) -> tuple[Block, ...]:
    """The blocks of states, those that drivers follow last.

    Their mass is a power of two near the largest of the bodies' `masses`.
    """
    every, largest = list(states), max((float(value_of(mass)) for mass in masses), default=0.0)
    mass = float(2.0 ** np.round(np.log2(largest))) if largest > 0 else 1.0
    found: list[Block] = []
    for kind, size in ((False, SLOTS), (True, CLOCK)):
        own = [one for one in every if (one.name in followed) == kind]
        for n in range(0, len(own), size):
            found.append(Block(f"states {len(found) + 1}", tuple(own[n : n + size]), mass, kind))
    return tuple(found)
