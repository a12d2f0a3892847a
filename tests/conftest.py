"""What no test leaves to the next, which depends on the worker that runs them: open figures, kinds, digits of mpmath.

`--part K/N` runs one of N parts of the tests. Of a test with the mark `one_in(n)` the first case runs by default and,
if it has more than n cases, one in n of the others. The rest, which take the same path, are slow: the parts of
`make slow` run them. A test with the mark `needs(package)` is skipped where the package is not installed; `make others`
installs the packages, and runs these tests, slow ones too.
"""

import gc
import sys
import zlib
from collections import Counter
from collections.abc import Generator, Iterator

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--part", metavar="K/N", default="1/1", help="run part K of N parts of the tests")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect no garbage among modules and tests, which all stay."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Every other worker begins at the end: from where they meet, the other's rewritten bytecode is there."""
    report = yield
    worker = getattr(collector.config, "workerinput", {"workerid": "gw0"})["workerid"]
    if isinstance(collector, pytest.Directory) and int(worker.removeprefix("gw")) % 2:
        report.result.reverse()
    return report


@pytest.hookimpl(tryfirst=True)  # before slow tests are left out
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if hasattr(config, "workerinput"):  # all workers need the same order
        items.sort(key=lambda item: item.path)
    _put_off(items)
    part, count = (int(number) for number in config.getoption("--part").split("/"))
    items[:] = [item for item in items if zlib.crc32(item.nodeid.encode()) % count == part - 1]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(
    item: pytest.Item, nextitem: pytest.Item | None
) -> Generator[None, object, object]:
    """Collect the garbage of each module, and examine what stays of it no more, which takes seconds in the end."""
    done = yield
    if nextitem and nextitem.path != item.path:
        gc.collect()
        gc.freeze()
    return done


def pytest_runtest_setup(item: pytest.Item) -> None:
    for mark in item.iter_markers("needs"):
        pytest.importorskip(mark.args[0])


def pytest_collectreport(report: pytest.CollectReport) -> None:
    """Refuse a module that loads or compiles kernels when it is imported: each worker imports all modules."""
    runtime = sys.modules.get("numba.core.runtime.nrt")
    if runtime and runtime.rtsys._init:
        raise pytest.UsageError(
            f"{report.nodeid}: it uses kernels when it is imported. Use them in a test or fixture."
        )


def _put_off(items: list[pytest.Item]) -> None:
    """Mark as slow all but the first and one in n of the other cases of tests; which ones follows from their names."""
    tests = [item.nodeid.partition("[")[0] for item in items]
    cases, begun = Counter(tests), set[str]()
    for item, test in zip(items, tests, strict=True):
        mark = item.get_closest_marker("one_in")
        n = mark.args[0] if mark else 1
        if test in begun and (cases[test] <= n or zlib.crc32(item.nodeid.encode()) // 64 % n):
            item.add_marker(pytest.mark.slow)
        begun.add(test)


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


@pytest.fixture(autouse=True, scope="module")
def _nothing_stays_registered() -> Iterator[None]:
    """Fail the last test of a module that leaves a kind, output, importer, method or verb to other tests."""
    from tests.registries import of_others

    known = of_others()
    yield
    assert of_others() <= known
