"""How do compiled loops call a system's operators: by addresses and tables, made once for each system."""

from __future__ import annotations

from ..._jit.pointer import Entry
from ...system import System
from ...system.once import once_alike
from ...system.told import Told


@once_alike
def entry_of(system: System, *names: str) -> Entry:
    """The entry of operators that are computed together, or of "remembered" or "potentials"."""
    if names[0] in ("remembered", "potentials"):
        told: Told = getattr(system, names[0])
        return told.entry()
    group = system.group(*names)
    found = group.entry()
    return (
        found._replace(tables=group.index) if len(found.addresses) == 1 else found
    )  # one table is not copied
