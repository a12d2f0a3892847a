"""Tests of a map by means that know nothing of its curves; what they find missing is traced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...algebra import Array
from ...results.workspace import Verification, Workspace
from .mapping import WorkspaceMap
from .reach import reach
from .region import Region

TOLERANCE = 1e-6  # free of units: farther outside, a position is outside
DEPTH = 1e-3  # of places just inside the boundary, free of units
MOST_INNER = 60
WALK = 25  # positions of a random walk from each assembled one
ROUNDS = 4
DIRECTIONS = 6


def verify_workspace(found: Workspace, samples: int = 2000, rays: int = 40) -> Workspace:
    """Test a workspace, trace what was missed, and return it with a `Verification`.

    Random admissible positions, assembled and walked to, must not lie outside; random rays must end on known curves;
    places just inside the boundary must be reached by inverse kinematics. Where a test fails, rays from there lead to
    curves that were missed, and all is tested again.

    Parameters
    ----------
    found : Workspace
    samples, rays : how many of each
    """
    map_: WorkspaceMap = found.map
    known, tests = len(map_.branches), None
    for number in range(1, ROUNDS + 1):
        before = len(map_.branches)
        tests = _round(map_, samples, rays)
        tests = replace(tests, rounds=number, found_late=len(map_.branches) - known)
        if len(map_.branches) == before:
            break
    return map_.result(tests)


def _round(map_: WorkspaceMap, samples: int, rays: int) -> Verification:
    p = map_.problem
    outputs, region = p.m + p.outputs, map_.region()
    positions = _positions(map_, samples)
    u = np.array([p.values(q)[outputs] for q in positions]).reshape(-1, 2)
    outside = np.flatnonzero(region.outside(u, TOLERANCE)) if len(u) else np.zeros(0, dtype=int)
    for n in outside[:20]:
        _look_around(map_, positions[n])
    ended, known = _rays(map_, rays)
    inner, reached = _inner(map_, map_.region())
    return Verification(len(u), len(outside), ended, known, inner, reached, 1, 0, TOLERANCE * p.size)


def _positions(map_: WorkspaceMap, count: int) -> list[Array]:
    found: list[Array] = []
    while len(found) < count:
        q = next(map_.samples, None)
        if q is None:
            break
        found += [q, *map_.samples.walks(q, min(WALK, count - len(found) - 1))]
    return found


def _look_around(map_: WorkspaceMap, q: Array) -> None:
    """Rays from a position outside; if they find nothing new, it tells that its cell can be reached."""
    starts = [map_.ray(q) for _ in range(DIRECTIONS)]
    new = [map_.explorer.start(*start) for start in starts if start is not None]
    if not any(new):
        map_.met.append(q)
    for _ in map_.explorer:
        pass


def _rays(map_: WorkspaceMap, count: int) -> tuple[int, int]:
    """How many rays ended, and how many of them on known curves; the others are starts."""
    ended = known = 0
    for _ in range(count):
        q = next(map_.samples, None)
        start = None if q is None else map_.ray(q)
        if start is None:
            continue
        ended += 1
        new = map_.explorer.start(*start)
        known += not new
        for _ in map_.explorer:
            pass
    return ended, known


def _inner(map_: WorkspaceMap, region: Region) -> tuple[int, int]:
    """Places a little inside of boundary pieces, and how many are reached from positions that were met."""
    p, edges = map_.problem, np.flatnonzero(region.bounds).tolist()
    chosen = edges[:: max(1, len(edges) // MOST_INNER)]
    tried = reached = 0
    for k in chosen:
        piece = region.division.pieces[k]
        middle = 0.5 * piece.arc.end
        slope = piece.arc.slope(middle)
        left = np.array([-slope[1], slope[0]]) / np.linalg.norm(slope)
        target = piece.arc.point(middle) + DEPTH * left * (1 if region.can[region.sides[k, 0]] else -1)
        if region.can[region.cells.locate(target[None])[0]]:
            tried += 1
            reached += reach(p, target, _starts(map_, region, k), 8, map_.random) is not None
    return tried, reached


def _starts(map_: WorkspaceMap, region: Region, k: int) -> Array:
    """Positions to begin with: those of the piece's own curves, then those that were met."""
    n = map_.problem.n
    own = []
    for owner, _, low, high in region.division.pieces[k].owners:
        points = region.branches[owner].points
        own += [points[j].x[:n] for j in range(len(points)) if min(low, high) - 1 <= j <= max(low, high) + 1]
    return np.array([*own, *map_.met[:20]])
