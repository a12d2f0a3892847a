"""What ``import sarrus`` costs and offers."""

import subprocess
import sys

import sarrus


def test_import_is_light() -> None:
    heavy = ("numba", "scipy", "matplotlib", "numpy", "yaml", "pydantic")
    program = f"import sys, sarrus; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_public_name_is_there() -> None:
    for name in sarrus.__all__:
        assert getattr(sarrus, name) is not None
