"""Blocks of states: three states are the velocities of a hidden body of unit mass that only translates.

    m v̇ = m f(v, outputs, t),    x = v

so that x' = f is one of the equations of motion, with all its derivatives, in every method. Unused slots of the body
are held by constraints. See decision 046.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...algebra import I3, Array, Row
from ...elements import InertiaElement, Primitive, Single
from ...elements.element import Grid, Scalar
from ..primitive import Primitive as Piece
from ..signals import Measure, Signal
from ..tape import value_of
from .rate_load import SLOTS, Slots


class StateValue(NamedTuple):
    """A state of a part: its name as an output, its initial value, its unit, and its size for tolerances."""

    name: str
    initial: Any
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
        return ()

    def Phi_q_xi_b(self, x: Single, xi: Single) -> Row:
        return ()

    def Phi_q_xi_q_eta_b(self, x: Single, xi: Single, eta: Single) -> Row:
        return ()

    def Phi_qT_lam_b(self, x: Single, lam: Array) -> Grid:
        return (), ()


class UnusedAfterOne(Unused, rows=5, bodies=1, derivatives="automatic", rare=True, registered=False):
    """Of a block with one state."""

    used = 1


class UnusedAfterTwo(Unused, rows=4, bodies=1, derivatives="automatic", rare=True, registered=False):
    """Of a block with two states."""

    used = 2


class UnusedAfterThree(Unused, rows=3, bodies=1, derivatives="automatic", rare=True, registered=False):
    """Of a block with three states."""

    used = 3


UNUSED: tuple[type[Unused], ...] = (UnusedAfterOne, UnusedAfterTwo, UnusedAfterThree)


class Block(NamedTuple):
    """A block: the name of its body, its states, and its mass."""

    name: str
    states: tuple[StateValue, ...]
    mass: float

    def initial(self) -> Array:
        """The initial velocities of its body (7,)."""
        values = [state.initial for state in self.states]
        return np.array(values + [0.0] * (SLOTS - len(values)) + [0.0] * 4)

    def primitives(self) -> tuple[Piece, Piece]:
        """Its inertia, and the constraints of what is unused."""
        return (
            Piece(StateInertia, (self.name,), (self.mass,), "states"),
            Piece(UNUSED[len(self.states) - 1], (self.name,), (), "unused"),
        )

    def signals(self) -> Mapping[str, Signal]:
        """The states by name, for formulas."""
        measure = Measure(Slots, (self.name,), (self.mass,))
        return {one.name: Signal(measure, "values", 2, n, one.unit) for n, one in enumerate(self.states)}


def blocks_of(states: Iterable[StateValue], masses: Iterable[Any]) -> tuple[Block, ...]:
    """The blocks of states, in their order; their mass is a power of two near the largest of the bodies' `masses`."""
    every, largest = list(states), max((float(value_of(mass)) for mass in masses), default=0.0)
    mass = float(2.0 ** np.round(np.log2(largest))) if largest > 0 else 1.0
    return tuple(
        Block(f"states {n // SLOTS + 1}", tuple(every[n : n + SLOTS]), mass)
        for n in range(0, len(every), SLOTS)
    )
