"""A few hundred damaged files and wrong arguments, always the same: no raw error, no hang, no accepted nonsense."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

SCRIPT = Path(__file__).resolve().parent.parent / "benchmarks" / "fuzz.py"


def fuzzed(*kinds: str, cases: int) -> dict[str, Any]:
    command = [sys.executable, str(SCRIPT), "--json", "--seed", "11", "--cases", str(cases), "--kind", *kinds]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.stdout, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    ("kinds", "cases"),
    [
        (("urdf",), 30),
        (("yaml", "json"), 60),
        (("mesh",), 150),
        (("study", "optimization"), 50),
        (("api",), 120),
    ],
)
def test_damaged_input_is_refused_or_accepted_rightly(kinds: tuple[str, ...], cases: int) -> None:
    found = fuzzed(*kinds, cases=cases)
    assert found["findings"] == []
    assert all(sum(counts.values()) == cases for counts in found["counts"].values())


def test_the_oracle_sees_what_cannot_be() -> None:
    """A model whose checks are evaded is nonsense, so that the silence above means something."""
    program = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "import numpy as np, sarrus as sr; from attack.oracle import nonsense\n"
        "from sarrus.io.robot.tree.merge import UncheckedBody\n"
        "body = UncheckedBody('a', mass=1.0, inertia=np.diag([1.0, 1.0, 5.0]))\n"
        "print(list(nonsense(sr.Model('m', bodies=[body]))))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(SCRIPT.parent)], capture_output=True, text=True, check=True
    )
    assert "principal moments" in done.stdout
