"""What no test leaves to the next, which depends on the worker that runs them: open figures, other digits of mpmath."""

import sys
from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True)
def _no_figures_are_left_open() -> Iterator[None]:
    """Close all figures after each test; Matplotlib warns from the 21st on."""
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


@pytest.fixture(autouse=True)
def _digits_stay() -> Iterator[None]:
    """Fail the test that changes mpmath's digits for those after it (`mpmath.workdps` gives them back)."""
    mpmath = sys.modules.get("mpmath")
    digits = mpmath and mpmath.mp.dps
    yield
    assert not mpmath or mpmath.mp.dps == digits
