"""Are the real and the complex matrix of split stages factored at once as each of them alone?"""

import numpy as np
import pytest
from tests.analyses.linkages import slider_crank_in_line

from sarrus._jit.linking.link import link
from sarrus.analyses.equations.block_matrix import UNIT, Numbers, Part, PlacedMatrix
from sarrus.analyses.equations.paired_matrix import PairedMatrix, solve_stages
from sarrus.linalg.sparse_solver import SingularMatrix

T = np.array([[1.0, 0.5, 0.2], [0.3, 1.0, -0.4], [0.1, 0.2, 1.0]])


@pytest.fixture(scope="module")
def numbers() -> Numbers:
    """M and the weights of the coordinates of a slider-crank."""
    system = slider_crank_in_line()
    found = Numbers(system, ("M", "Phi_q", "left_out", UNIT))
    found.evaluate(("M",), system.b, {"t": 0.0, "q": system.q0})
    return found


def paired(numbers: Numbers, real: list[float], other: list[complex]) -> PairedMatrix:
    """[M I; I M], with weights of the four blocks in both matrices."""
    n = numbers.system.nq
    parts = [Part("M", 0, 0), Part(UNIT, 0, n), Part(UNIT, n, 0), Part("M", n, n)]
    matrix = PlacedMatrix(numbers, 2 * n, parts)
    made = PairedMatrix(matrix, parts)
    matrix.weights[:], made.complex.weights[:] = real, other
    return made


def residual(matrix: PairedMatrix) -> float:
    """Of the solution for random right sides, transformed by T and back: of both matrices, relative."""
    n = matrix.real.n
    right, solution = np.random.default_rng(1).normal(size=3 * n), np.zeros(3 * n)
    link(solve_stages)(T, np.linalg.inv(T), matrix.show(), right, solution)
    of_right, of_solution = (np.linalg.inv(T) @ x.reshape(3, n) for x in (right, solution))
    pair = of_right[1] + 1j * of_right[2], of_solution[1] + 1j * of_solution[2]
    rest = (
        matrix.real.matrix() @ of_solution[0] - of_right[0],
        matrix.complex.matrix() @ pair[1] - pair[0],
    )
    return float(max(abs(x).max() for x in rest))


def test_both_are_solved(numbers: Numbers) -> None:
    matrix = paired(numbers, [3.0, 0.5, 2.0, 1.0], [1 + 2j, 0.5 - 1j, 1j, 2.0])
    matrix.factor(1e-3)
    assert residual(matrix) < 1e-11


def test_pivots_suit_the_complex_matrix_where_those_of_the_real_one_do_not(numbers: Numbers) -> None:
    """M, in which the real matrix has its pivots, is missing in the complex one."""
    matrix = paired(numbers, [1.0, 1e-4, 1e-4, 1.0], [0.0, 1 + 1j, 1 - 2j, 0.0])
    matrix.factor(1e-3)
    assert residual(matrix) < 1e-7


def test_a_singular_matrix_is_refused(numbers: Numbers) -> None:
    with pytest.raises(SingularMatrix, match="singular"):
        paired(numbers, [3.0, 0.5, 2.0, 1.0], [1j, 0.0, 0.0, 0.0]).factor(1e-3)


def test_factors_are_taken_over(numbers: Numbers) -> None:
    """As a run that goes on from its saved state does: with the same bits."""
    matrix = paired(numbers, [3.0, 0.5, 2.0, 1.0], [1 + 2j, 0.5 - 1j, 1j, 2.0])
    matrix.factor(1e-3)
    other = paired(numbers, [3.0, 0.5, 2.0, 1.0], [1 + 2j, 0.5 - 1j, 1j, 2.0])
    other.resume(matrix.state())
    assert residual(other) == residual(matrix)
