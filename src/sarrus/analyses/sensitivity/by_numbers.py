"""How do the equations of an operation depend on the numbers of the elements? In lanes, without the operators by b.

With ℓ = μᵀR of an operation (`shares`), backward sweeps take ∂ℓ/∂b, forward ones the change R_b b'.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._jit import pointer
from ..._jit.differentiate import directional
from ..._jit.emit import NUMBERS_DOT, Recording
from ...algebra import Array
from ...elements.recorder import Variant
from ...system import System
from ...system.population import Population
from ..once import once_alike
from .reverse import gradient
from .shares import STATES, Share, block, concerned, entry

ADJOINT = (*STATES, "xi", "lam", "nu")
CHANGES = (*STATES, "lam", NUMBERS_DOT)


def calls() -> dict[str, Any]:
    """What calls the drivers."""
    return {"GRADIENT": pointer.run(0, 1 + len(ADJOINT) + 1), "CHANGE": pointer.run(0, 1 + len(CHANGES) + 2)}


@once_alike
def gradient_entry(system: System, kind: str) -> Any:
    """Operands t, `ADJOINT`; ∂ℓ/∂b is added to the output."""
    every = [p for p in concerned(system, kind) if p.kind.size()]
    return entry(every, [_gradient(p.variant, kind) for p in every], ("numbers",), "gradient")


@once_alike
def change_entry(system: System, kind: str, moved: tuple[bool, ...]) -> Any:
    """Operands t, `CHANGES`; R_b b' is added to the outputs, along coordinates and along equations (those of ν).

    `moved` tells which numbers change.
    """
    own = _moved(system, kind, np.array(moved))
    return entry(own, [_change(p.variant, kind) for p in own], ("coordinates", "rows"), "change")


def drivers_of_columns(system: System, kind: str, dots: Array) -> Array:
    """Which drivers of `change_entry` concern each row of changes of the numbers (k, len(b)): (k, 2) from, to."""
    own = _moved(system, kind, np.any(dots != 0.0, axis=0))
    found = np.zeros((len(dots), 2), np.int64)
    for row, of_row in zip(found, dots, strict=True):
        touched = np.flatnonzero([np.any(of_row[p.at : p.end]) for p in own])
        row[:] = (touched[0], touched[-1] + 1) if len(touched) else (0, 0)
    return found


def _moved(system: System, kind: str, moved: Array) -> list[Population]:
    """The elements that have numbers which change."""
    return [p for p in concerned(system, kind) if np.any(moved[p.at : p.end])]


def _gradient(variant: Variant, kind: str) -> Recording:
    share = Share(variant, kind)
    found = gradient(share.graph, share.value, list(share.numbers))
    return share.recording(ADJOINT, [block(share.free(found))])


def _change(variant: Variant, kind: str) -> Recording:
    share = Share(variant, kind)
    xi = share.moving["xi"].reshape(-1)
    equations = share.expressions(gradient(share.graph, share.value, [*xi, *share.nu]))
    dots = share.graph.inputs(NUMBERS_DOT, variant.kind.size())
    pairs = [(x, dot) for x, dot, held in zip(share.numbers, dots, share.held, strict=True) if not held]
    found = directional(share.graph, equations, pairs)
    return share.recording(CHANGES, [share.by_body(found[: len(xi)]), block(found[len(xi) :])])
