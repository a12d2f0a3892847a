"""Second-order sweep: how the Lagrangians of all operations change along a direction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...._jit.kernels.vector import LANES
from ...._jit.linking.link import link
from ....algebra import Array
from ....system.curves.lanes import buffer
from ...dynamics.stepping.entries import joined
from ..lagrangians.changes import lagrangian
from ..lagrangians.curves import CurveLagrangian
from . import second_order_loop as loop
from .blocks import Blocks
from .layout import kinds_of
from .record import Operations
from .sweep import PerOperation, stages_of


class ChangesAlong(NamedTuple):
    """The changes of the gradients of all Lagrangians.

    By the stages' quantities, by the parameters (len(b),), and by the times of the steps (steps,).
    """

    sources: PerOperation
    b: Array
    t: Array


def changes_along(
    record: Operations,
    b_dot: Array,
    stages: PerOperation,
    adjoint: PerOperation,
    curves: CurveLagrangian,
    t_dot: Array,
) -> ChangesAlong:
    """The changes along a direction.

    Parameters
    ----------
    record : of the operations
    b_dot, stages, t_dot : the direction: changes of the parameters (len(b),), of the stages' quantities, and of the
        times of the steps
    adjoint : the adjoint variables of all operations
    curves : second derivatives by parameters of curves, and by times
    """
    system = record.system
    structures = [one.tables.structure for one in record.operations if len(one)]
    entries = [lagrangian(system, kind) for kind in kinds_of(structures, system)]
    ends = np.cumsum([0, *(len(entry.addresses) for entry in entries)]).astype(np.int64)
    sizes = {"lam_dot": system.m, "nu": system.m, "by_lam": system.m, "by_b": len(system.b)}
    work = loop.Operands._make(buffer(sizes.get(name, system.nq)) for name in loop.Operands._fields)
    blocks, found = Blocks(record, 0, None), stages_of(record, 1)
    link(loop.change)(
        blocks.layout, joined(entries), ends, record.steps.b.copy(), b_dot.copy(), record.run(), stages.series,
        adjoint.series, blocks.block, work, found.series,
    )  # fmt: skip
    by_b = work.by_b.reshape(-1, LANES).sum(axis=1)
    whole = ChangesAlong(found, by_b, np.zeros(len(record.steps)))
    for n in [n for n, one in enumerate(record.operations) if curves and len(one)]:
        _add_curves(
            n, record, b_dot, stages.parts[n][:, :, 0], adjoint.parts[n][:, :, 0], curves, t_dot, whole
        )
    return whole


def _add_curves(
    n: int, record: Operations, b_dot: Array, stages: Array, mu: Array, curves: CurveLagrangian, t_dot: Array,
    to: ChangesAlong,
) -> None:  # fmt: skip
    """Add what parameters of curves and the times do in all occurrences of an operation."""
    system, one, sizes = record.system, record.operations[n], {"lam": record.system.m}
    for group in one.tables.groups:
        s, kind = group.stage, group.kind
        names = {"q": "q", "v": "v", "a": kind.acceleration or "", "lam": kind.multipliers}
        given = {x: one.sources[s, of].all(len(one)) for x, of in names.items() if (s, of) in one.sources}
        at = {x: one.tables.stages[s, of] for x, of in names.items() if (s, of) in one.tables.stages}
        rows = {x: slice(first, first + sizes.get(x, system.nq)) for x, first in at.items()}
        given |= {f"{x}_dot": stages[:, own] for x, own in rows.items()}
        if group.xi >= 0:
            given["xi"] = mu[:, group.xi : group.xi + system.nq] * one.scales[:, group.xi_equation, None]
        if group.nu >= 0:
            scale = kind.sign * one.scales[:, group.nu_equation, None]
            given["nu"] = mu[:, group.nu : group.nu + system.m] * scale
            given["nu"][:, : group.rows[0]] = given["nu"][:, group.rows[1] :] = 0.0
        given |= {"t": one.times[:, s], "t_dot": t_dot[one.steps]}
        added = curves.change(kind.kind, record.steps.b, b_dot, record.memory(one), **given)
        for x, own in rows.items():
            to.sources.parts[n][:, own, 0] += getattr(added, x)
        to.b[:] += added.b
        np.add.at(to.t, one.steps, added.t)
