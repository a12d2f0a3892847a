"""The start of a motion for many designs: assembled again for each, or a fixed state that suits all of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ....model import ModelError, SarrusError
from ....results import Assembly, State
from ....system import System
from ...equations.length import extent
from ...equations.states_at_rest import places
from ...equilibria.statics import equilibrium
from ...position.assembly import assemble
from ...position.assembly_derivatives import AssemblyDerivatives
from ...position.initial_state import Start, is_off, meant, settled, start_by, start_of

if TYPE_CHECKING:
    from .parameters import Parameters

# Of the extent of the system, and of p: guesses that differ less are the model's own, renormalized
SAME = 1e-12
NEAR = 1e-3  # [-] relative change of the parameters at which a function is called again
StartOf: TypeAlias = Callable[[System], Start]
RETURN = "Return an equilibrium, or an assembly with the same rates and guess for all, whose derivatives are known."
REMEDY = "Pass sr.assemble(system, state.q, state.v, t=state.t) as start, which is assembled again for every design."


@dataclass(frozen=True, eq=False)
class DesignStart:
    """Start of the run of any design.

    An assembly and coordinates are assembled again for every design, with the same guess, rates and metric; an
    equilibrium is sought again, near that of the first design. A function is called with the system of every design.
    The state of another run is fixed; designs that it contradicts are refused.

    Attributes
    ----------
    first : the start of the design that is given
    fixed : whether it is that of all designs
    own : whether the guess of the assembly is the model's own q and v, which follow the design
    rates : the given rates that are the model's, which follow the design; empty in the places of others
    held : names of the coordinates that the assembly holds
    function : that returns the start of a system, if one is given
    """

    first: Assembly
    fixed: bool
    own: tuple[bool, bool]
    held: tuple[str, ...]
    rates: tuple[str, ...]
    function: StartOf | None = None

    @classmethod
    def of(cls, system: System, given: Start | StartOf | DesignStart | None) -> DesignStart:
        """The start of a system, and of other designs of it; for parameters see `start_of`."""
        if isinstance(given, DesignStart):
            return given
        function = given if callable(given) else None
        found = meant(system, start_by(function, system) if function else given)
        first = start_of(system, found)
        names = tuple(np.array(system.coordinate_names)[first.asked.held]) if first.asked else ()
        own = own_start(system, first), names, own_rates(system, first)
        return cls(first, isinstance(found, State), *own, function)

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
        if self.function is not None:
            return start_of(system, self.function(system))
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
        rest = equilibrium(system, first) if first.settled else None
        if rest is not None and not rest.success:
            return replace(first, success=False, message=rest.message)
        if rest is not None and rest.v is not None:
            q, v = rest.q, np.where(np.isin(np.arange(system.nq), places(system)), rest.v, v)
        metric = "unit" if asked.unit_metric else asked.weight
        rates = {**asked.rates, **{name: system.model.rates[name] for name in self.rates if name}}
        found = assemble(system, q, v, t=asked.t, fixed=self.held, rates=rates, metric=metric)
        if not len(found.memory):
            found = replace(found, memory=first.memory, revolutions=first.revolutions)
        return found if rest is None else settled(found, rest)

    def refuse_moved(self, system: System, parameters: Parameters) -> None:
        """Refuse variables that change constraints, which a fixed state contradicts.

        Raises
        ------
        ModelError
        """
        if not self.first.success:
            return
        if self.function is not None:
            self._refuse_unknown_changes(parameters)
        if not self.fixed:
            return
        changes = parameters.along(np.eye(len(parameters.names)))[0]
        moved = np.flatnonzero(AssemblyDerivatives(system, self.first).opens(changes))
        if len(moved):
            name = parameters.names[moved[0]]
            raise ModelError(f"start: {name} changes constraints, but the given state is fixed. {REMEDY}")

    def _refuse_unknown_changes(self, parameters: Parameters) -> None:
        """Refuse a function whose start changes with the design in ways that have no known derivative.

        Raises
        ------
        ModelError
        """
        near = System(parameters.model_at(parameters.values * (1 + NEAR) + NEAR * (parameters.values == 0)))
        here, there = self.first, self.at(near)
        if here.asked is None or there.asked is None or not there.success:
            return
        own_q, own_v = own_start(near, there)
        moved = {
            "rates": own_rates(near, there) != self.rates
            or any(
                here.asked.rates[name] != there.asked.rates[name]
                for name in {*here.asked.rates} - {*self.rates}
            ),
            "a guess of q": not (own_q or here.settled or np.array_equal(here.asked.q, there.asked.q)),
            "a guess of v": not (own_v or np.array_equal(here.asked.v, there.asked.v)),
            "a metric": not (here.asked.unit_metric or np.array_equal(here.asked.weight, there.asked.weight)),
            "a state": self.fixed and not np.array_equal(here.q, there.q),
        }
        if any(moved.values()):
            what = [name for name, changes in moved.items() if changes][-1]
            raise ModelError(
                f"start: the function returns {what} that depend{'s' * (what != 'rates')} on the design. {RETURN}"
            )

    def described(self) -> dict[str, Any]:
        """All of it in plain values."""
        arrays = {name: getattr(self.first, name).tolist() for name in ("q", "v", "memory", "revolutions")}
        asked = self.first.asked
        guess: dict[str, Any] = {}
        if asked:
            guess = {
                "rates": dict(asked.rates),
                "metric": "unit" if asked.unit_metric else asked.weight.tolist(),
            }
        kind: dict[str, Any] = {"settled": True} if self.first.settled else {}
        if self.function is not None:
            kind["function"] = f"{self.function.__module__}.{getattr(self.function, '__qualname__', '')}"
        return {"t": self.t, "fixed": self.fixed, **arrays, "held": list(self.held), **guess, **kind}


def own_start(system: System, start: Assembly | None) -> tuple[bool, bool]:
    """Whether an assembly started from the coordinates and velocities that the model gives."""
    if start is None or start.asked is None:
        return True, True
    asked = start.asked
    unit = system.layout.scales(extent(system, system.q0))
    return bool(np.all(abs(asked.q - system.q0) <= SAME * unit)), np.array_equal(asked.v, system.v0)


def own_rates(system: System, start: Assembly | None) -> tuple[str, ...]:
    """Names of the given rates of an assembly, by default the model's; empty for those that are not the model's."""
    own = system.model.rates
    if start is None:
        return tuple(own)
    given = start.asked.rates if start.asked is not None else {}
    return tuple(name if name in own and float(own[name]) == rate else "" for name, rate in given.items())
