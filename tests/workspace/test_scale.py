"""The same maps whatever the size of the mechanism: no tolerance is a length."""

import numpy as np
import pytest

import sarrus as sr

from .mechanisms import arm

EXACT = 31.497510350119  # of the arm of Haug et al., whose links are 4, 2 and 1 long


@pytest.mark.one_in(8)
@pytest.mark.parametrize("size", [1e-6, 1e-3, 1e4])
def test_an_arm_of_any_size(size: float) -> None:
    system, tip = arm([4 * size, 2 * size, 1 * size])
    limits = {f"q{n}": (-np.pi / 3, np.pi / 3) for n in (1, 2, 3)}
    found = sr.workspace(system, tip["x", "y"], limits=limits, samples=100, rays=6)
    assert found.success, found.message
    assert found.area / size**2 == pytest.approx(EXACT, rel=3e-7)
    stretched = 7 * size * np.array([np.cos(0.3), np.sin(0.3)])
    assert found.contains([stretched, stretched * (1 + 1e-6)]).tolist() == [True, False]
