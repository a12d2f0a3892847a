"""Cases that are put off: the tests that run by default and the slow ones are all tests, and no test is in both."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TESTS = """
import pytest

@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", "abcd")
@pytest.mark.parametrize("case", range(25))
def test_many(case, method):
    pass

@pytest.mark.one_in(4)
@pytest.mark.parametrize("case", range(4))
def test_few(case):
    pass

def test_one():
    pass
"""


def collected(place: Path, *options: str) -> list[str]:
    """The tests that pytest would run."""
    (place / "test_it.py").write_text(TESTS)
    command = [sys.executable, "-m", "pytest", "-p", "tests.conftest", "--collect-only", "-q", *options]
    settings = os.environ | {"PYTHONPATH": str(ROOT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = subprocess.run(command, cwd=place, env=settings, capture_output=True, text=True, check=True)
    return sorted(line for line in done.stdout.splitlines() if line.startswith("test_it.py::"))


def test_every_case_runs_in_one_of_both(tmp_path: Path) -> None:
    usual, slow = collected(tmp_path, "-m", "not slow"), collected(tmp_path, "-m", "slow")
    every = collected(tmp_path)
    assert sorted(usual + slow) == every
    assert len(every) == 105
    assert 15 <= sum("test_many" in name for name in usual) <= 40
    assert {"test_it.py::test_many[0-a]", "test_it.py::test_one"} <= {*usual}
    assert [name for name in usual if "test_few" in name] == ["test_it.py::test_few[0]"]
    assert all(any(f"-{method}]" in name for name in usual) for method in "abcd")


def test_parts_are_all_slow_cases(tmp_path: Path) -> None:
    parts = [collected(tmp_path, "-m", "slow", "--part", f"{n}/3") for n in (1, 2, 3)]
    assert all(parts)
    assert sorted([*parts[0], *parts[1], *parts[2]]) == collected(tmp_path, "-m", "slow")
