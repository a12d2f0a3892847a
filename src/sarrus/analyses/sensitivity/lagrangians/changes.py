"""Contracted second derivatives of the equations of an operation, for the change of adjoints.

The gradient of ℓ = μᵀR (`shares`) by everything that it depends on changes along a direction by the Hessian of ℓ times
that direction. Here this change is recorded for every kind of element, by one sweep backwards and one forwards over its
formulas, and compiled for all elements, for several states at once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...._jit.formulas.differentiate import directional
from ...._jit.formulas.reverse import gradient
from ...._jit.kernels.emit import NUMBERS_DOT, Recording
from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.kernels.vector import LANES
from ...._jit.linking.link import compiled, link
from ....algebra import Array
from ....elements.recorder import Variant
from ....system import System
from ....system.cached import once_alike
from ....system.curves.lanes import Recipe, block, buffer, entry
from .curves import CurveLagrangian
from .elements import STATES, Share, concerned

DOTS = tuple(f"{name}_dot" for name in STATES)
OPERANDS = (*STATES, *DOTS, "xi", "lam", "nu", "lam_dot", NUMBERS_DOT)
RESULTS = (*STATES, "lam", "b")


class Change(NamedTuple):
    """The change of the gradient of ℓ by coordinates, rates, accelerations (nq,), λ (m,), the parameters, the time."""

    q: Array
    v: Array
    a: Array
    lam: Array
    b: Array
    t: float = 0.0


@once_alike
def lagrangian(system: System, kind: str) -> Any:
    """Operands t, `OPERANDS`; the change of the gradient by `RESULTS` is added to the outputs."""
    own, along = concerned(system, kind), (*("coordinates",) * len(STATES), "rows", "numbers")
    return entry(own, [Recipe(p.variant, _record, kind, OPERANDS) for p in own], along, "lagrangian")


def _record(variant: Variant, kind: str) -> Recording:
    """The change of the gradient of one element's share of ℓ."""
    share, size = Share(variant, kind), variant.kind.size()
    states = [x for name in STATES for x in share.moving[name].flat]
    moved = [x for name in DOTS for x in share.coordinates(name).flat]
    free = [x for x, held in zip(share.numbers, share.held, strict=True) if not held]
    dots = zip(share.numbers, share.graph.inputs(NUMBERS_DOT, size), strict=True)
    pairs = [*zip(states, moved, strict=True), *zip(share.lam, share.rows("lam_dot"), strict=True)]
    pairs += [(x, dot) for (x, dot), held in zip(dots, share.held, strict=True) if not held]
    slopes = gradient(share.graph, share.value, [*states, *share.lam, *share.numbers])
    assert len(pairs) == len(slopes) - size + len(free)
    change = directional(share.graph, slopes, pairs)
    cut = len(states) // len(STATES)
    bodies = [share.variant.split(change[n * cut : (n + 1) * cut]) for n in range(len(STATES))]
    rest = change[len(states) :]
    rows, numbers = rest[: len(share.lam)], share.free(rest[len(share.lam) :])
    return share.recording(OPERANDS, [*bodies, block(rows), block(numbers)])


@compiled(entry=True)
def call_once(kernels: KernelTable, b: Array, operands: tuple[Array, ...]) -> None:
    """Call kernels from Python; the cache has this, unlike `call_kernels` itself."""
    call_kernels(kernels, b, *operands)


def change_at(
    system: System,
    kind: str,
    t: float,
    b: Array,
    b_dot: Array,
    lam: Array,
    nu: Array,
    lam_dot: Array,
    curves: CurveLagrangian | None = None,
    t_dot: float = 0.0,
    /,
    **x: Array,
) -> Change:
    """Evaluate at one state; operands that are not given are zero. `curves` are those that change, or the time."""
    given = {"lam": lam, "nu": nu, "lam_dot": lam_dot, **x}
    none = np.zeros(system.nq)
    operands = [np.repeat(given.get(name, none), LANES) for name in OPERANDS[:-1]]
    sizes = {"lam": system.m, "b": len(system.b)}
    found = [buffer(sizes.get(name, system.nq)) for name in RESULTS]
    link(call_once)(lagrangian(system, kind), b, (np.full(LANES, t), *operands, b_dot, *found))
    q, v, a, by_lam, by_b = (out[::LANES].copy() for out in found)
    change = Change(q, v, a, by_lam, by_b)
    if not curves:
        return change
    at_one = {name: np.asarray(operand)[None] for name, operand in {"nu": nu, **given}.items()}
    added = curves.change(kind, b, b_dot, {}, t=np.array([t]), t_dot=np.array([t_dot]), **at_one)
    q, v, a, by_lam = (getattr(change, name) + getattr(added, name)[0] for name in (*STATES, "lam"))
    return Change(q, v, a, by_lam, by_b + added.b, float(added.t[0]))
