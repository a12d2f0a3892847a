"""What ``import sarrus`` costs and offers."""

import subprocess
import sys

import sarrus
from sarrus.cli import VERBS

HEAVY = ("numba", "scipy", "matplotlib", "numpy", "yaml", "pydantic")


def heavy_after(program: str) -> str:
    """What a program has imported of what is heavy."""
    asked = f"import sys\n{program}\nprint([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1]


def test_import_is_light() -> None:
    assert heavy_after("import sarrus") == "[]"


def test_help_of_every_verb_is_light() -> None:
    program = f"""
from sarrus.cli import main
for words in ([], *([verb] for verb in {tuple(VERBS)})):
    try:
        main([*words, "--help"])
    except SystemExit:
        pass"""
    assert heavy_after(program) == "[]"


def test_what_is_heavy_is_seen() -> None:
    assert heavy_after("import numpy") == "['numpy']"


def test_every_public_name_is_there() -> None:
    for name in sarrus.__all__:
        assert getattr(sarrus, name) is not None
