"""The start of a motion for many designs: assembled again for each, or a fixed state that suits all of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ....model import ModelError, SarrusError
from ....results import Assembly, Equilibrium, State
from ....system import System
from ...position.assembly import assemble
from ...position.assembly_derivatives import AssemblyDerivatives
from ...position.initial_state import Start, is_off, meant, start_of

if TYPE_CHECKING:
    from .parameters import Parameters

SAME = 1e-12  # [m, 1] of coordinates: guesses that differ less are the model's own, renormalized
REMEDY = "Pass sr.assemble(system, state.q, state.v, t=state.t) as start, which is assembled again for every design."


@dataclass(frozen=True, eq=False)
class DesignStart:
    """What a run of any design starts from.

    An assembly and coordinates are assembled again for every design, with the same guess, rates and metric. The state
    of another run and an equilibrium are fixed; designs that they contradict are refused.

    Attributes
    ----------
    first : the start of the design that is given
    fixed : whether it is that of all designs
    own : whether the guess of the assembly is the model's own q and v, which follow the design
    held : names of the coordinates that the assembly holds
    """

    first: Assembly
    fixed: bool
    own: tuple[bool, bool]
    held: tuple[str, ...]

    @classmethod
    def of(cls, system: System, given: Start | DesignStart | None) -> DesignStart:
        """The start of a system, and of other designs of it; for parameters see `start_of`."""
        if isinstance(given, DesignStart):
            return given
        found = meant(system, given)
        first = start_of(system, found)
        names = tuple(np.array(system.coordinate_names)[first.asked.held]) if first.asked else ()
        return cls(first, isinstance(found, State | Equilibrium), own_start(system, first), names)

    @property
    def t(self) -> float:
        """Its time [s]."""
        return self.first.t

    def at(self, system: System) -> Assembly:
        """The start of a design.

        Raises
        ------
        SarrusError
            If a fixed state contradicts its constraints.
        """
        first = self.first
        if (
            first.success
            and self.fixed
            and is_off(system.with_memory(first.memory), first.q, first.v, first.t)
        ):
            raise SarrusError(f"start: {system.name} has other constraints than the given state. {REMEDY}")
        if not first.success or self.fixed or first.asked is None:
            return first
        asked = first.asked
        q, v = (system.q0 if self.own[0] else asked.q), (system.v0 if self.own[1] else asked.v)
        system = system.with_memory(first.memory)
        found = assemble(system, q, v, t=asked.t, fixed=self.held, rates=asked.rates, metric=asked.weight)
        return (
            found if len(found.memory) else replace(found, memory=first.memory, revolutions=first.revolutions)
        )

    def refuse_moved(self, system: System, parameters: Parameters) -> None:
        """Refuse variables that change constraints, which a fixed state contradicts.

        Raises
        ------
        ModelError
        """
        if not self.fixed or not self.first.success:
            return
        changes = parameters.along(np.eye(len(parameters.names)))[0]
        moved = np.flatnonzero(AssemblyDerivatives(system, self.first).opens(changes))
        if len(moved):
            name = parameters.names[moved[0]]
            raise ModelError(f"start: {name} changes constraints, but the given state is fixed. {REMEDY}")

    def described(self) -> dict[str, Any]:
        """All of it in plain values."""
        arrays = {name: getattr(self.first, name).tolist() for name in ("q", "v", "memory", "revolutions")}
        asked = self.first.asked
        guess = {"rates": dict(asked.rates), "weight": asked.weight.tolist()} if asked else {}
        return {"t": self.t, "fixed": self.fixed, **arrays, "held": list(self.held), **guess}


def own_start(system: System, start: Assembly | None) -> tuple[bool, bool]:
    """Whether an assembly started from the coordinates and velocities that the model gives."""
    if start is None or start.asked is None:
        return True, True
    asked = start.asked
    return np.allclose(asked.q, system.q0, rtol=0, atol=SAME), np.array_equal(asked.v, system.v0)
