"""From which sides a candidate curve can be crossed: the second-order form on the directions that leave the outputs.

With s_i >= 0 the distance from an active limit and sigma_i = +1 at its lowest, -1 at its highest value, neighbouring
admissible positions have c·du = -Σ lam_i sigma_i s_i + ½ etaᵀ H eta, eta in the null space of all gradients. Where all
terms have one sign, the outputs stay on that side: a barrier.

A limit that coincides with a singular configuration, as an elbow that is stretched at its limit, has lam_i = 0 along
the whole curve: motion away from it leaves the outputs where they are to first order. Then eta includes that motion.
A quadratic form takes the same values on both sides of a limit, so that such a limit, or one that is reached without
being active, changes nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....linalg.svd import singular
from ..problem.rows import Problem
from ..problem.settle import reach
from ..tracing.explore import Branch
from ..tracing.point import Step
from ..tracing.stratum import NoPoint, Stratum, correct, plane
from .arrangement import BESIDE, TOUCH, Cells, Owner, Piece

VANISHES = 1e-9  # of a term, free of units: multipliers and normal have length 1
# Free of units: a limit that outputs leave by less before they turn back is a singularity
SHALLOW = 10 * TOUCH


class Crossing(NamedTuple):
    """Possible continuations of a motion that arrives at a curve.

    Attributes
    ----------
    x : unknowns of the point that was examined
    side : +1 or -1: the outputs stay on the side of c or -c, a barrier; 0: they can go to both sides
    terms : -lam_i sigma_i of the active limits, then the eigenvalues of the form
    sure : false where further limits are reached by coincidence, which are not in the terms, or where some terms
        vanish, as for a freedom that moves none of the outputs; the others then determine the side
    """

    x: Array
    side: int
    terms: Array
    sure: bool = True


def crossing(branch: Branch) -> Crossing:
    """Examine a curve in its middle; along it the signs do not change."""
    k = (len(branch.points) - 1) // 2
    step = Step(branch.points[k], branch.points[k + 1])
    x = step.x(0.5)
    with suppress(NoPoint):
        x = correct(branch.stratum, x, plane(x, step.a.t))[0]
    return examine(branch.stratum, x)


def examine(stratum: Stratum, x: Array) -> Crossing:
    """The terms of the second-order form at one point."""
    q, lam, c = stratum.parts(x)
    J, H = stratum.problem.jacobian(q), stratum.problem.curvature(q, stratum.weights(x))
    pushes = -lam[len(lam) - len(stratum.active) :] * stratum.signs
    turning = _turning(stratum, J, H, pushes, float(np.linalg.norm(c)))
    Z = _null_space(stratum, J, turning)
    terms = np.concatenate([pushes[~turning], np.linalg.eigvalsh(Z.T @ H @ Z)])
    decisive = terms[abs(terms) > VANISHES]
    side = 0 if not len(decisive) else 1 if np.all(decisive > 0) else -1 if np.all(decisive < 0) else 0
    known = len(decisive) > 0 and (side == 0 or len(decisive) == len(terms))
    return Crossing(x, side, terms, known and _unrestrained(stratum, q, J, Z, side))


def _turning(stratum: Stratum, J: Array, H: Array, pushes: Array, normal: float) -> Array:
    """Which active limits the outputs leave by less than `SHALLOW` before they turn back (count,)."""
    found = abs(pushes) <= VANISHES
    for k in np.flatnonzero(abs(pushes) < np.sqrt(SHALLOW)):
        alone = np.arange(len(pushes)) == k
        Z = _null_space(stratum, J, alone)
        away = Z @ (Z.T @ J[stratum.rows[len(stratum.rows) - len(pushes) + k]])
        rate = float(away @ away)
        bend = float(away @ H @ away) / rate**2 if rate > VANISHES else 0.0
        found[k] |= pushes[k] ** 2 <= 2 * SHALLOW * abs(bend) * normal
    return np.asarray(found)


def _null_space(stratum: Stratum, J: Array, without: Array) -> Array:
    """Motions (n, count) that leave constraints, outputs and active limits as they are, except some of the limits."""
    rows = stratum.rows[: len(stratum.rows) - len(without)]
    limits = stratum.rows[len(rows) :][~without]
    gradients = np.concatenate([J[rows], J[limits], J[stratum.normal]])
    free = stratum.n - len(gradients) + 1
    return np.asarray(singular(gradients)[2][stratum.n - free :].T)


def _unrestrained(stratum: Stratum, q: Array, J: Array, Z: Array, side: int) -> bool:
    """Whether limits that are reached without being active leave the terms as they are."""
    problem = stratum.problem
    margins = problem.margins(problem.values(q))
    others = [
        i for i in range(len(margins)) if min(margins[i]) <= VANISHES and not {(i, 0), (i, 1)} & stratum.key
    ]
    if not others:
        return True
    sizes = np.linalg.svd(J[problem.m + problem.limited[others]] @ Z, compute_uv=False)
    independent = len(sizes) == len(others) and bool(sizes.min() > np.sqrt(VANISHES))
    return independent and (side != 0 or len(others) == 1)


SHORT = 10 * TOUCH  # free of units: on pieces that are shorter, curves that cross look like one


def labels(
    problem: Problem,
    branches: Sequence[Branch],
    crossings: Sequence[Crossing],
    cells: Cells,
    met: Array,
    seed: int,
    search: bool,
) -> Array:
    """Whether each cell can be reached (count,).

    The cell on the open side of a barrier can be reached, those on both sides of a curve that can be crossed.
    Cells that no curve decides are decided by admissible positions `met` (k, n), then by inverse kinematics from so
    many of them.
    """
    found = np.zeros(len(cells.cells), dtype=bool)
    for k, piece in enumerate(cells.division.pieces):
        several = len({n for n, *_ in piece.owners}) > 1
        if piece.arc.length < (BESIDE if several else SHORT):
            continue
        for way, can in enumerate(_sides(k, branches, crossings, cells)):
            found[cells.of[k, way]] |= can
    if len(met):
        outputs = problem.m + problem.outputs
        at = cells.locate(np.array([problem.values(q)[outputs] for q in met]))
        found[at[at > 0]] = True
    for k, cell in enumerate(cells.cells):
        if cell.bounded and not found[k] and len(met) and search:
            target = cells.inner_point(k)
            random = np.random.default_rng(seed + k)
            found[k] = target is not None and reach(problem, target, met, random) is not None
    return found


def _sides(
    k: int, branches: Sequence[Branch], crossings: Sequence[Crossing], cells: Cells
) -> tuple[bool, bool]:
    """Whether its left and its right can be reached according to the curves on a piece."""
    piece, left, right = cells.division.pieces[k], False, False
    for owner in piece.owners:
        if crossings[owner[0]].sure:
            to_left = crossings[owner[0]].side * leftward(branches[owner[0]], piece, owner)
            left |= to_left >= 0
            right |= to_left <= 0
    return left, right


def leftward(branch: Branch, piece: Piece, owner: Owner) -> float:
    """The sign with which the normal c of a branch points to the left of a piece that it owns, in its middle."""
    at = 0.5 * (owner[1] + owner[2])
    k = min(int(at), len(branch.points) - 2)
    c = (1 - at + k) * branch.points[k].c + (at - k) * branch.points[k + 1].c
    slope = piece.arc.slope(0.5 * piece.arc.end)
    return float(np.sign(c[1] * slope[0] - c[0] * slope[1]))
