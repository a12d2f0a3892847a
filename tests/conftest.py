"""What no test leaves to the next, which depends on the worker that runs them: open figures, other digits of mpmath.

`--part K/N` runs one of N parts of the tests.
"""

import sys
import zlib
from collections.abc import Iterator

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--part", metavar="K/N", default="1/1", help="run part K of N parts of the tests")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    part, count = (int(number) for number in config.getoption("--part").split("/"))
    items[:] = [item for item in items if zlib.crc32(item.nodeid.encode()) % count == part - 1]


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
