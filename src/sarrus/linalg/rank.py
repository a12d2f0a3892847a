"""Rank of a sparse Jacobian: the combinations of rows that vanish, and the directions that it does not restrain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import qr
from scipy.linalg.lapack import dtrtri
from scipy.sparse import csr_array, eye_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from ..algebra import Array
from .threads import one_thread

DEPENDENT = 1e-9

# A singular value of the rows scaled to unit length, relative to the largest, that counts as zero
TOLERANCE = 1e-8
DENSE_UP_TO = 250  # rows of a component that are analysed by singular values
LONG = 0.01  # share of the tolerance in large components, see `zero_below`
FLOOR = 1e-12  # added to the squares of singular values, where they are found by inverse iteration
SPARE = 8  # vectors of the block beyond those that are known to vanish: 5 to 10, by Halko et al.
SETTLED = 1e-2  # relative change of the smallest singular value in one iteration, at which it ends


@dataclass(frozen=True)
class Rank:
    """Rank of J (m, n).

    Attributes
    ----------
    rank : number of independent rows
    null : (m, m - rank) orthonormal combinations of unit rows that vanish
    smallest : smallest singular value that is not taken for zero, rows scaled to unit length, or a bound from below
    """

    rank: int
    null: Array
    smallest: float


def rank_of(
    J: csr_array,
    tolerance: float | None = None,
    parts: tuple[Array, int] | None = None,
    enough: float = np.inf,
) -> Rank:
    """Analyse each connected component of J by itself: by singular values, large ones by inverse iteration.

    The tolerance is by default that of `zero_below`; `parts` are the `components` of its pattern, if they are known.
    Where a QR decomposition shows that all singular values are above `enough`, only a bound of them is computed.
    """
    unit, (labels, count) = unit_rows(J), parts or components(J)
    nulls, smallest = [], np.inf
    for n in range(count):
        rows = np.flatnonzero(labels == n)
        null, least = _null_of(unit if count == 1 else unit[rows], tolerance, enough)
        wide = np.zeros((J.shape[0], null.shape[1]))
        wide[rows] = null
        nulls.append(wide)
        smallest = min(smallest, least)
    null = np.hstack(nulls) if nulls else np.zeros((J.shape[0], 0))
    return Rank(J.shape[0] - null.shape[1], null, float(smallest))


def zero_below(rows: int) -> float:
    """Return the default tolerance of a component: the smallest value of a chain of N links falls with 1/N²."""
    return TOLERANCE * min(1.0, max(LONG, (DENSE_UP_TO / rows) ** 2))


def unit_rows(J: csr_array) -> csr_array:
    """J with every row scaled to unit length; rows of zeros stay."""
    return divided(J, row_lengths(J))


def divided(J: csr_array, rows: Array) -> csr_array:
    """J with every row divided by a number."""
    return with_data(J, J.data / rows[rows_of_entries(J)])


def with_data(J: csr_array, data: Array) -> csr_array:
    """A matrix with the pattern of J, which is not checked again, and other values."""
    found = csr_array.__new__(csr_array)
    found.__dict__.update(J.__dict__, data=data)
    return found


def row_lengths(J: csr_array) -> Array:
    """Length of every row (m,), 1 for rows of zeros."""
    length = np.sqrt(np.bincount(rows_of_entries(J), weights=J.data * J.data, minlength=J.shape[0]))
    return np.where(length > 0, length, 1.0)


def rows_of_entries(J: csr_array) -> Array:
    """The row of every stored entry."""
    return np.repeat(np.arange(J.shape[0]), J.indptr[1:] - J.indptr[:-1])


def independent_rows(null: Array, last: Array) -> Array:
    """A well-conditioned choice of independent rows, given all vanishing combinations (m, k).

    Parameters
    ----------
    null : (m, k) from `Rank`
    last : (m,) rows that are always among the independent ones

    Notes
    -----
    The k rows left out are the pivots of a QR factorization of the combinations: these rows follow from the
    others with the least amplification.
    """
    candidates = np.flatnonzero(~last)
    if not null.shape[1]:
        return np.arange(len(null))
    order = qr(null[candidates].T, mode="r", pivoting=True)[1]
    dropped = candidates[order[: null.shape[1]]]
    return np.setdiff1d(np.arange(len(null)), dropped)


def components(J: Any) -> tuple[Array, int]:
    """The component of each row, and how many there are: rows that share a column belong together."""
    m, n = J.shape
    pointers = np.concatenate([J.indptr, np.full(n, J.indptr[-1])])
    graph = csr_array((np.ones(len(J.indices)), m + J.indices, pointers), shape=(m + n, m + n))
    labels = connected_components(graph, directed=False)[1][:m]
    names, labels = np.unique(labels, return_inverse=True)
    return labels, len(names)


def _null_of(unit: csr_array, tolerance: float | None, enough: float) -> tuple[Array, float]:
    m, used = unit.shape[0], np.unique(unit.indices)
    tolerance = zero_below(m) if tolerance is None else tolerance
    if m > DENSE_UP_TO:
        with one_thread.held():  # blocks of a few vectors gain nothing by others
            return _null_by_iteration(unit, tolerance, m - len(used))
    dense = (unit if 2 * len(used) > unit.shape[1] else unit[:, used]).toarray()
    inverse = inverse_if_regular(np.linalg.qr(dense.T, mode="r"), tolerance) if enough < np.inf else None
    if inverse is not None and (least := float(1 / np.linalg.norm(inverse))) > enough:
        return np.zeros((m, 0)), least
    values = np.linalg.svd(dense, compute_uv=False)
    values = np.concatenate([values, np.zeros(m - len(values))])
    zero = values <= tolerance * values.max(initial=0.0)
    left = np.linalg.svd(dense)[0] if np.any(zero) else np.zeros((m, m))  # vectors cost the most
    return left[:, zero], float(values[~zero].min(initial=np.inf))


def inverse_if_regular(triangle: Any, tolerance: float) -> Array | None:
    """R⁻¹ (m, m) for rowsᵀ = QR of m unit rows, if it shows that all singular values are above the tolerance.

    The largest is at most √m, the smallest at least 1 over the norm of the inverse.
    """
    n, m = triangle.shape
    inverse, failed = dtrtri(triangle[:m]) if 0 < m <= n else (triangle, 1)
    return inverse if not failed and np.sqrt(m) * np.linalg.norm(inverse) < 1 / tolerance else None


def _null_by_iteration(unit: csr_array, tolerance: float, surplus: int) -> tuple[Array, float]:
    """Iterate a random block with (J Jᵀ + floor)⁻¹, a larger one until it holds more than what vanishes.

    The values of a block are never below the singular values, so that all that vanish are true; a random block has
    parts along all of them (Halko, Martinsson and Tropp 2011), and values above show that none is missing.
    """
    m, random = unit.shape[0], np.random.default_rng(0)
    normal, transposed = (unit @ unit.T).tocsc(), unit.T.tocsr()
    inverse = splu((normal + FLOOR * eye_array(m)).tocsc())
    limit, count = tolerance * np.sqrt(normal.diagonal().max()), max(surplus, 0) + SPARE
    while True:
        block, vanishing, least = random.normal(size=(m, min(count, m))), -1, np.inf
        while True:
            block = qr(inverse.solve(block), mode="economic")[0]
            image = np.asarray((transposed @ block).T)
            rotation, values, _ = np.linalg.svd(image, full_matrices=image.shape[0] > image.shape[1])
            values = np.concatenate([values, np.zeros(len(image) - len(values))])
            block, zero, before = block @ rotation, values <= limit, (vanishing, least)
            vanishing, least = int(zero.sum()), float(values[~zero].min(initial=np.inf))
            if vanishing == before[0] and not least < (1 - SETTLED) * before[1]:
                break
        if vanishing < len(values) or count >= m:
            return block[:, zero], least
        count *= 2
