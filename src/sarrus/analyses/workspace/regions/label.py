"""Reachability of cells of the plane, by the curves around them, by known positions, or by search."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....algebra import Array
from ..problem.rows import Problem
from ..tracing.explore import Branch
from .arrangement import TOUCH
from .crossing import Crossing
from .faces import Cells
from .reach import reach

SHORT = 10 * TOUCH  # free of units: on pieces that are shorter, curves that cross look like one
# Free of units: on pieces that are shorter, curves that touch (curvatures 6e-3 apart) look like one
TOUCHING = 0.05
TRIES = 12  # of inverse kinematics for a cell of which nothing is known


def labels(
    problem: Problem,
    branches: Sequence[Branch],
    crossings: Sequence[Crossing],
    cells: Cells,
    met: Array,
    seed: int,
    tries: int,
) -> Array:
    """Whether each cell can be reached (count,).

    The cell on the open side of a barrier can be reached, those on both sides of a curve that can be crossed.
    Cells that no curve decides are decided by admissible positions `met` (k, n), then by inverse kinematics from so
    many of them.
    """
    found = np.zeros(len(cells.cells), dtype=bool)
    for k, piece in enumerate(cells.division.pieces):
        several = len({n for n, *_ in piece.owners}) > 1
        if piece.arc.length < (TOUCHING if several else SHORT):
            continue
        for way, can in enumerate(_sides(k, branches, crossings, cells)):
            found[cells.of[k, way]] |= can
    if len(met):
        outputs = problem.m + problem.outputs
        at = cells.locate(np.array([problem.values(q)[outputs] for q in met]))
        found[at[at > 0]] = True
    for k, cell in enumerate(cells.cells):
        if cell.bounded and not found[k] and len(met):
            target = cells.inner_point(k)
            random = np.random.default_rng(seed + k)
            found[k] = target is not None and reach(problem, target, met, tries, random) is not None
    return found


def _sides(
    k: int, branches: Sequence[Branch], crossings: Sequence[Crossing], cells: Cells
) -> tuple[bool, bool]:
    """Whether its left and its right can be reached according to the curves on a piece."""
    piece, left, right = cells.division.pieces[k], False, False
    slope = piece.arc.slope(0.5 * piece.arc.end)
    for n, _, low, high in piece.owners:
        if not crossings[n].sure:
            continue
        side = crossings[n].side
        c = normal_at(branches[n], 0.5 * (low + high))
        leftward = side * float(c[1] * slope[0] - c[0] * slope[1])
        left |= side == 0 or leftward > 0
        right |= side == 0 or leftward < 0
    return left, right


def normal_at(branch: Branch, at: float) -> Array:
    """The normal c of a branch at a parameter that counts its points, nearly."""
    k = min(int(at), len(branch.points) - 2)
    share = at - k
    return np.asarray((1 - share) * branch.points[k].c + share * branch.points[k + 1].c)
