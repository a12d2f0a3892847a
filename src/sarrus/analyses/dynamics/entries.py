"""How do compiled loops call a system's operators: by addresses and tables, made once for each system."""

from __future__ import annotations

from ..._jit.pointer import Entry
from ...system import System
from ...system.element_values import ElementValues
from ...system.once import once_alike


@once_alike
def entry_of(system: System, *names: str) -> Entry:
    """The entry of operators that are computed together, or of "remembered" or "potentials"."""
    if names[0] in ("remembered", "potentials"):
        values: ElementValues = getattr(system, names[0])
        return values.entry()
    group = system.group(*names)
    found = group.entry()
    return (
        found._replace(tables=group.index) if len(found.addresses) == 1 else found
    )  # one table is not copied
