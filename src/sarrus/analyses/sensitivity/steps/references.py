"""State variables of elements as sweeps take them: steps that count the same revolutions share a reference.

An element of the library remembers the angle at the last accepted state, and takes the angle nearest to it. This angle,
which `remember` returns, is all by which the reference enters. So a step can take the reference of another one if its
angles remain the same numbers: only steps with the same state variables are linearized together. State variables of
users' elements may enter in other ways, and are shared only where they are equal.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.linking.link import compiled, link
from ....algebra import Array
from ....elements import BUILT_IN
from ....model.forces.formula_element import OutputLaws
from ....system import System
from ....system.operators.element_values import memory_places


def shared_references(system: System, b: Array, t: Array, q: Array, memory: Array) -> Array:
    """What elements remember during each step (steps, k), the same for as many as can share it.

    Parameters
    ----------
    b : (len(system.b),)
    t, q : (steps, s), (steps, s, nq) all states of the steps at which equations are evaluated
    memory : (steps, k) what they remembered during the run
    """
    places = system.memory_places
    angles = np.isin(places, memory_places(p for p in system.populations if remembers_angles(p.kind)))
    found = memory.copy()
    if angles.any():
        remembered, values = system.remembered.entry(), np.zeros((2, len(places)))
        link(share)(remembered, b.copy(), t, q, places, angles, found, values)
    return found


def remembers_angles(kind: Any) -> bool:
    """Whether all that an element, or a measure of a formula, remembers is of elements of the library."""
    by_formulas = isinstance(kind, type) and issubclass(kind, OutputLaws)
    parts = [one.kind for one in kind.structure.parts] if by_formulas else getattr(kind, "parts", ())
    within = [one for one in parts if "Memory" in one.fields.values()]
    return kind in BUILT_IN or (len(within) > 0 and all(map(remembers_angles, within)))


@compiled
def remember(
    remembered: KernelTable, b: Array, t: float, q: Array, places: Array, row: Array, values: Array
) -> None:
    """What elements remember after a state, given what they remembered before it."""
    for k in range(len(places)):
        b[places[k]] = row[k]
    call_kernels(remembered, b, t, q, values)


@compiled
def serves(
    remembered: KernelTable, b: Array, t: Array, q: Array, places: Array, angles: Array, row: Array, other: Array,
    values: Array,
) -> bool:  # fmt: skip
    """Whether another row of state variables gives the same angles at all states of a step."""
    for k in range(len(places)):
        if not angles[k] and row[k] != other[k]:
            return False
    for s in range(len(t)):
        remember(remembered, b, t[s], q[s], places, row, values[0])
        remember(remembered, b, t[s], q[s], places, other, values[1])
        for k in range(len(places)):
            if values[0, k] != values[1, k]:
                return False
    return True


@compiled(entry=True)
def share(
    remembered: KernelTable, b: Array, t: Array, q: Array, places: Array, angles: Array, memory: Array, values: Array
) -> None:  # fmt: skip
    """Replace each row of `memory` (steps, k) by the one before it where that serves."""
    for n in range(1, len(memory)):
        if serves(remembered, b, t[n], q[n], places, angles, memory[n], memory[n - 1], values):
            memory[n] = memory[n - 1]
