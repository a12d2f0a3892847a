"""Random changes of the parameters: how much of errors of derivatives they see, whatever their combination is."""

from __future__ import annotations

import numpy as np
import pytest

from sarrus.analyses.sensitivity.accuracy.derivatives.growth import UNDER, WARNED, certain
from sarrus.analyses.sensitivity.accuracy.derivatives.random_changes import DRAWN, orthogonal


def combinations(p: int) -> np.ndarray:
    """Errors of derivatives by p parameters, in all directions alike, of size one."""
    drawn = np.random.default_rng(3).standard_normal((20000, p))
    return np.asarray(drawn / np.linalg.norm(drawn, axis=1, keepdims=True))


@pytest.mark.parametrize("p", range(1, DRAWN + 1))
def test_errors_of_few_derivatives_are_seen_exactly(p: int) -> None:
    assert np.linalg.norm(combinations(p) @ orthogonal(p).T, axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize("p", [5, 6, 9, 16, 40])
def test_errors_of_many_derivatives_are_seldom_underestimated(p: int) -> None:
    """Those by each parameter alone are exact."""
    each = orthogonal(p)
    seen = np.linalg.norm(combinations(p) @ each.T, axis=1)
    assert np.mean(seen < 1 / 3) < 0.025
    assert seen.max() < 3
    assert np.linalg.norm(each, axis=0) == pytest.approx(1.0)


@pytest.mark.parametrize("p", [3, 4, 9, 40])
@pytest.mark.parametrize("changes", [2, 3])
def test_errors_of_twice_the_limit_are_seldom_missed_by_the_first_changes(changes: int, p: int) -> None:
    each = orthogonal(p)
    seen = np.linalg.norm(combinations(p) @ each[:changes].T, axis=1) * np.sqrt(len(each) / changes)
    assert certain(np.array([WARNED[1] / UNDER[changes - 1]]), changes, WARNED[1])
    assert np.mean(2 * seen < 1 / UNDER[changes - 1]) < 0.035
