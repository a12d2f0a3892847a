#!/usr/bin/env python3
"""One command for each thing to do in a fresh clone, listed by `python3 dev.py`. Standard library only.

The first use makes `.venv` beside this file and installs Sarrus into it with what the command needs; a stamp
remembers what was installed, and the work is done again when pyproject.toml or the Python version changes.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
STAMP = VENV / "sarrus-installed.json"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = str(BIN / "python")

EXTRAS = {
    "install": ["dist", "docs", "lint", "test"],
    "demo": [],
    "quick": ["test"],
    "test": ["test"],
    "slow": ["test"],
    "others": ["bridges", "browser", "dask", "robots"],
    "robots": ["robots"],
    "cluster": ["test", "dask"],
    "browser": ["browser"],
    "dist": ["dist"],
    "wheel": ["dist"],
    "bridges": ["bridges"],
    "check": ["lint", "test"],
    "docs": ["docs", "test"],
    "format": ["lint"],
}
# A process for each processor; one that dies ends the run, for its tests would be waited for.
TESTS = [PYTHON, "-m", "pytest", "-n", "auto", "--dist", "loadfile", "--max-worker-restart", "0"]
DIST = ["tests/test_distribution.py", "tests/test_wheel.py"]
COMMANDS = {
    "install": [],  # what most of the others need, at once
    "demo": [[str(BIN / "sarrus"), "demo"]],
    "quick": [[*TESTS, "-m", "not slow", "tests/model", "tests/elements", "tests/system"]],  # a minute, warm
    "test": [[*TESTS, "-m", "not slow"]],
    "slow": [[*TESTS, "-m", "slow and not needs", *(f"--ignore={file}" for file in DIST)]],
    "others": [
        [*TESTS, "-m", "needs", "--ignore=tests/bridges"],
        [*TESTS, "tests/bridges"],  # JAX warns in processes that are forked beside it
    ],
    "robots": [[*TESTS, "-m", "needs", "tests/io"]],
    "cluster": [[PYTHON, "-m", "pytest", "tests/studies/test_dask.py"]],
    "browser": [[PYTHON, "-m", "pytest", "tests/browser"]],
    "dist": [[PYTHON, "-m", "pytest", *DIST]],
    "wheel": [[PYTHON, "-m", "distribution.wheel"]],  # with compiled kernels, for this Python and platform
    "bridges": [[*TESTS, "tests/bridges"]],
    "sundials": [[PYTHON, "-m", "pytest", "tests/analyses/test_ida.py"]],
    "check": [
        [str(BIN / "ruff"), "check", "."],
        [str(BIN / "ruff"), "format", "--check", "."],
        [PYTHON, "-m", "mypy"],
        [str(BIN / "lint-imports"), "--no-logo"],
        [PYTHON, "-m", "tests.language"],
    ],
    "docs": [[PYTHON, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", "docs", "docs/_build/html"]],
    "format": [[str(BIN / "ruff"), "check", "--fix", "."], [str(BIN / "ruff"), "format", "."]],
}


def main(argv: list[str]) -> int:
    if sys.version_info < (3, 11):
        return fail(
            f"Sarrus needs Python 3.11 or newer; {sys.executable} is {sys.version.split()[0]}. "
            "Name another one: make test PYTHON=python3.12"
        )
    verb = argv[0] if argv else "help"
    if verb == "clean":
        return clean()
    if verb not in COMMANDS:
        print(__doc__)
        print("usage: python3 dev.py", "|".join([*COMMANDS, "clean"]), "[arguments for the last program]")
        return 0 if verb in ("help", "-h", "--help") else 2
    code = install(EXTRAS[verb])
    return code or run_all(COMMANDS[verb], argv[1:])


def run_all(commands: list[list[str]], arguments: list[str]) -> int:
    """Run every command, the last one with the user's arguments; the first failure gives the exit code."""
    commands = [*commands[:-1], *(last + arguments for last in commands[-1:])]
    codes = [run(command) for command in commands]
    return next((code for code in codes if code), 0)


def run(command: list[str]) -> int:
    shown = " ".join(str(Path(command[0]).name if i == 0 else word) for i, word in enumerate(command))
    print(f"$ {shown}", flush=True)
    return subprocess.run(command, cwd=ROOT, check=False).returncode


def install(extras: list[str]) -> int:
    """Bring .venv up to date: nothing to do, one pip call, or a new environment."""
    stamp = read_stamp()
    if stamp.get("python") != python_key():
        code, stamp = make_venv(), {}
        if code:
            return code
    known = stamp.get("extras", [])
    if stamp.get("project") == project_key() and set(extras) <= set(known):
        return 0
    wanted = sorted({*extras, *known})
    target = f"{ROOT}[{','.join(wanted)}]" if wanted else str(ROOT)
    print(f"Installing {target} into .venv (once; up to a minute) ...", flush=True)
    start = time.perf_counter()
    if run(
        [*pip(), "install", "-qq", "--no-compile", "pip", "--editable", target]
    ):  # imports compile modules
        return fail("pip could not install Sarrus; its message stands above.")
    print(f"Installed in {time.perf_counter() - start:.0f} s.", flush=True)
    STAMP.write_text(json.dumps({"python": python_key(), "project": project_key(), "extras": wanted}))
    return 0


def make_venv() -> int:
    """Make an empty environment, which the pip of this Python can fill; otherwise one with the pip that Python brings.

    The latter takes three seconds, and some Linux distributions leave it out.
    """
    shutil.rmtree(VENV, ignore_errors=True)
    print(f"Making .venv with Python {sys.version.split()[0]} ...", flush=True)
    make = [sys.executable, "-m", "venv", "--clear", str(VENV)]
    for command in ([*make, "--without-pip"], make):
        if succeeds(command) and succeeds([*pip(), "list"]):
            return 0
    return fail("no virtual environment could be made. On Debian or Ubuntu, install python3-venv.")


def pip() -> list[str]:
    """The pip of .venv, or the pip of this Python as long as there is none; old ones lack the option `--python`."""
    if any(BIN.glob("pip*")):
        return [PYTHON, "-m", "pip"]
    return [sys.executable, "-m", "pip", "--python", PYTHON]


def succeeds(command: list[str]) -> bool:
    """Whether a program runs without an error; what it prints is not shown."""
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def read_stamp() -> dict:
    try:
        return json.loads(STAMP.read_text())
    except (OSError, ValueError):
        return {}


def python_key() -> str:
    """What a virtual environment depends on: the interpreter, and where the environment stands."""
    return f"{sys.version.split()[0]} {sys.base_prefix} {VENV}"


def project_key() -> str:
    return hashlib.sha256((ROOT / "pyproject.toml").read_bytes()).hexdigest()


def clean() -> int:
    for name in (
        ".venv",
        "docs/_build",
        ".mypy_cache",
        ".ruff_cache",
        ".pytest_cache",
        ".import_linter_cache",
    ):
        shutil.rmtree(ROOT / name, ignore_errors=True)
    return 0


def fail(sentence: str) -> int:
    print(f"dev.py: {sentence}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
