"""What every test begins without: figures of the tests before it, which depend on the worker that ran them."""

import sys
from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True)
def _no_figures_are_left_open() -> Iterator[None]:
    """Close all figures after each test; Matplotlib warns from the 21st on."""
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")
