"""Warnings about the configuration in which a simulation starts: constraints that lose rank there, nothing to move."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from ....algebra import Array
from ....model import Formula
from ....results import Assembly
from ....system import System
from ....system.cached import once
from ...equations.length import units
from ...redundancy.degrees_of_freedom import STRAIGHT, largest_curvature
from ...redundancy.redundant_constraints import Independence
from ..inputs.laws_of_time import ASIDE, fields_of_time, formula_law, parts_of

JUMP = 1e-6  # of a prescribed motion: smaller changes at a corner are those of its rate
PROBES = 3  # random motions and combinations of equations: one alone could miss by chance


def initial_warnings(system: System, start: Assembly, first: Independence) -> Iterator[str]:
    """Yield what a user should know before a run from this state."""
    t = start.asked.t if start.asked else 0.0
    freedom = system.nq - system.m + first.known
    if first.nearly:
        yield f"{system.name}: {first.nearly}."
    if freedom == 0 and not driven(system):
        yield (
            f"{system.name}: nothing can move, since the model has no degrees of freedom and no driver. Remove "
            "constraints, or use `equilibrium` for the forces in a structure."
        )
    elif freedom and first.known and rank_changes(system, start.q, t, first):
        yield (
            f"{system.name}: the constraints lose rank in the initial configuration: it has {freedom} degree"
            f"{'' if freedom == 1 else 's'} of freedom there and fewer nearby, and the motion may follow any branch. "
            "Start from another configuration."
        )


@once
def driven(system: System) -> bool:
    """Whether a constraint depends on time."""
    return any(p.count and p.kind.rows and p.kind.timed for p in system.populations)


def motion_jumps(system: System, begin: float, until: float) -> Iterator[str]:
    """Yield a warning for each driver whose prescribed motion jumps within a run: no force can follow it."""
    for p in system.populations:
        fields = fields_of_time(p.variant) if p.count and p.kind.rows else ()
        for n, (owner, values) in product(fields, zip(p.owners, p.values, strict=True)):
            for t, jump in _jumps(values[n], begin, until) if isinstance(values[n], Formula) else ():
                yield (
                    f"{owner}: its motion jumps by {jump:.3g} at t = {t:.6g} s, which no velocity and no force can "
                    "follow. Give it a rise that takes a time, as by step(t, ...)."
                )


def _jumps(formula: Formula, begin: float, until: float) -> Iterator[tuple[float, float]]:
    """Yield where a law over the time jumps within a run, and by how much."""
    law = formula_law(formula)
    parts = parts_of(law, begin, until)
    for t in parts.corners:
        before, behind = law(t + ASIDE * max(abs(begin), abs(until)) * np.array([-1, 1]))
        if begin < t < until and abs(behind - before) > JUMP * parts.spread:
            yield float(t), float(behind - before)


def rank_changes(system: System, q: Array, t: float, first: Independence) -> bool:
    """Whether the rank of Φ_q changes along some motion that is possible at a position.

    It does not if ηᵀ (Φ_qᵀ n)_q ξ = 0 for all motions ξ and η and all combinations n of equations with nᵀΦ_q = 0, which
    is tried for random ones.
    """
    random, unit = np.random.default_rng(0), units(system.nq, first.length)
    sizes = first.row_lengths(q, t)
    curvature = largest_curvature(system, q, t, sizes, unit) or 1.0
    for _ in range(PROBES):
        n = first.vanishing(q, t, random)
        n = n / np.linalg.norm(n * sizes)
        xi, eta = (xi / np.linalg.norm(xi / unit) for xi in first.motions(q, t, unit, random))
        if abs(eta @ (system.Phi_qT_lam_q(q, n, t) @ xi)) > STRAIGHT * curvature:
            return True
    return False
