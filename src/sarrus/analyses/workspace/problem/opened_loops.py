"""Equations of the spanning tree of joints: those that remain if every loop is opened."""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ....model.coordinates import WIDTH
from ....system import System
from ...equations.normalizations import normalizations


def tree_rows(system: System) -> Array:
    """Rows of Φ of joints that close no loop, in the model's order, and of the Euler parameters."""
    parent = list(range(len(system.bodies) + 1))
    pattern, found = system.pattern("Phi_q"), [np.flatnonzero(normalizations(system))]
    for joint in system.model.joints:
        rows = system.rows.get(joint.name, np.zeros(0, dtype=int))
        columns = np.concatenate(
            [pattern.indices[pattern.indptr[r] : pattern.indptr[r + 1]] for r in rows] or [rows]
        )
        bodies = {int(column) // WIDTH + 1 for column in columns}
        bodies |= {0} if len(bodies) == 1 else set()
        roots = {_root(parent, body) for body in bodies}
        if len(roots) == len(bodies):
            found.append(rows)
            for root in roots:
                parent[root] = min(roots)
    return np.sort(np.concatenate(found)).astype(int)


def _root(parent: list[int], body: int) -> int:
    while parent[body] != body:
        body = parent[body]
    return body
