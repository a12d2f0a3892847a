"""Singular values of a Jacobian for which LAPACK's divide and conquer does not converge."""

from pathlib import Path

import numpy as np

from sarrus.linalg.svd import singular


def test_a_jacobian_with_tiny_entries() -> None:
    """Of a five-bar: condition 31, entries down to 1e-47; NumPy's function has failed on it."""
    J = np.load(Path(__file__).parent / "five_bar_jacobian.npy")
    left, sizes, right = singular(J)
    assert abs(left * sizes @ right - J).max() < len(sizes) * np.finfo(float).eps * sizes[0]  # any LAPACK
    assert abs(right @ right.T - np.eye(28)).max() < 1e-14
    assert sizes[0] / sizes[-1] < 50
