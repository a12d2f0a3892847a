"""Are the pivots of small matrices large enough, and their factors sparse?"""

import numpy as np
import pytest
from scipy.sparse import block_diag, csc_array, random_array

from sarrus.linalg.pivot_order import LONGEST
from sarrus.linalg.sparse_solver import LARGE, SingularMatrix, SparseLU


def lu_of(matrix: csc_array) -> SparseLU:
    matrix.sort_indices()
    return SparseLU(matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64), matrix.data)


def mixed(n: int, kind: type) -> csc_array:
    """Sparse, not symmetric, with zeros on the diagonal and rows of very different size."""
    draw = np.random.default_rng(n)
    rings = csc_array((np.ones(n), (np.arange(n), (np.arange(n) + 1) % n)), shape=(n, n))
    matrix = (random_array((n, n), density=3 / n, rng=draw) + rings).tocsc()
    sizes = 10.0 ** draw.uniform(-3, 3, n)
    return csc_array(matrix.multiply(sizes[:, None]), dtype=kind) * kind(1 + 1j if kind is complex else 1)


@pytest.mark.parametrize("n", [3, 40, 200, 600])
@pytest.mark.parametrize("kind", [float, complex])
def test_it_solves(n: int, kind: type) -> None:
    matrix = mixed(n, kind)
    x = np.random.default_rng(1).normal(size=n).astype(kind)
    found = lu_of(matrix)
    np.testing.assert_allclose(found.solve(matrix @ x), x, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(found.solve_transposed(matrix.T @ x), x, rtol=1e-8, atol=1e-8)


def test_pivots_are_not_small_in_their_columns() -> None:
    found = lu_of(mixed(150, float))
    lower = np.array(
        [
            abs(found.factors[d + 1 : e]).max(initial=0)
            for d, e in zip(found.diagonal, found.pointers[1:], strict=True)
        ]
    )
    assert lower.max() <= 1 / LARGE * (1 + 1e-12)


@pytest.mark.parametrize("n", [60, LONGEST[-1] + 1])
def test_an_arrow_does_not_fill(n: int) -> None:
    """Its first row and column are full: eliminated first, they would fill the whole matrix.

    Rows that are longer than Markowitz's rule takes are left to SuperLU.
    """
    dense = np.diag(np.full(n, 2.0))
    dense[0], dense[:, 0] = 1.0, 1.0
    assert len(lu_of(csc_array(dense)).rows) == 3 * n - 2


def test_a_column_that_the_others_imply_is_refused() -> None:
    dense = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 9.0], [0.0, 1.0, 1.0]])
    with pytest.raises(SingularMatrix, match="singular"):
        lu_of(csc_array(dense))


def test_the_factors_of_linked_parts_are_about_those_of_the_parts() -> None:
    """Minimum degree, which knows the pattern alone, gives 1.6 times as many."""
    count, one = 5, mixed(120, float)
    ends = 120 * np.arange(1, count)
    links = csc_array((np.ones(count - 1), (ends, ends - 1)), shape=(120 * count, 120 * count))
    whole = csc_array(block_diag([one] * count) + links)
    assert len(lu_of(whole).rows) < 1.1 * count * len(lu_of(one).rows)
