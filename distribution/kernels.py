"""Compile the kernels that a wheel holds: `python -m distribution.kernels FOLDER` fills FOLDER/LEVEL for each level.

Every action of `actions.py` runs in a process of its own, for the level's processor instead of this machine's. What
they compile is what is packed: no list of kernels has to be kept. Levels that this machine's processor does not have
cannot be run, and are left out. Run it from a clone, in an environment that has Sarrus.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from sarrus._jit.linking.cache import contents
from sarrus._jit.linking.processor import Level, levels
from sarrus._jit.linking.shipped import pack

from .actions import ACTIONS

SCRIPT = Path(__file__).with_name("actions.py")
LARGEST = 60e6  # bytes, of all levels
FIRST = ("simulate", "sensitivity")  # what they compile, the others need, too
RUN = "actions.json"  # beside the kernels: the names of the actions that have been run


def build(target: Path, chosen: Sequence[str], names: Sequence[str] = (), cache: Path | None = None) -> int:
    """Compile and pack every level of this machine, or those with given names; return the size of all in bytes.

    What is compiled stays in a folder for each level in `cache`, if one is given.
    """
    found = [level for level in levels() if not names or level.name in names]
    if not found:
        raise SystemExit("This processor has none of the levels. Build the wheel without kernels.")
    # the folder's name must not be one that another user can make
    with tempfile.TemporaryDirectory(prefix="sarrus-kernels-") as made:
        place = cache or Path(made)
        return sum(_level(level, target / level.name, chosen, place / level.name) for level in found)


def _level(level: Level, target: Path, chosen: Sequence[str], cache: Path) -> int:
    cache.mkdir(parents=True, exist_ok=True, mode=0o700)
    compile_into(cache, level, chosen)
    size = pack_from(cache, level, target)
    (target / RUN).write_text(json.dumps(list(chosen)), encoding="ascii")
    return size


def compile_into(cache: Path, level: Level, chosen: Sequence[str]) -> None:
    """Run the actions; those that others build on first, the rest at once in as many processes as processors."""
    first = [name for name in FIRST if name in chosen]
    rest = [name for name in chosen if name not in first]
    began, count = time.perf_counter(), itertools.count(1)

    def run(name: str) -> None:
        _run(name, cache, level)
        elapsed = time.perf_counter() - began
        print(f"  {level.name}: {next(count)} of {len(chosen)}, {name}, after {elapsed:.0f} s", flush=True)

    for name in first:
        run(name)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(run, rest))


def pack_from(cache: Path, level: Level, target: Path) -> int:
    """Pack what the folder holds; return the size in bytes."""
    (folder,) = cache.glob("kernels-*")
    found = dict(contents(folder))
    size = pack(found.items(), target, level.name)
    print(f"{level.name}: {len(found)} kernels, {size / 1e6:.1f} MB", flush=True)
    return size


def _run(name: str, cache: Path, level: Level) -> None:
    settings = {
        "SARRUS_CACHE_DIR": str(cache),
        "NUMBA_CPU_NAME": level.name,
        "NUMBA_CPU_FEATURES": "",
        "PYTHONWARNINGS": "ignore",
    }
    subprocess.run([sys.executable, str(SCRIPT), name], env=os.environ | settings, check=True)


def main() -> None:
    """Build, and refuse what is too large."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="must not hold kernels yet")
    parser.add_argument("--actions", nargs="+", default=list(ACTIONS), metavar="NAME", help="only these")
    parser.add_argument(
        "--levels", nargs="+", default=[], metavar="NAME", help="of processors; by default all"
    )
    parser.add_argument(
        "--cache", type=Path, metavar="FOLDER", help="where what is compiled stays, a folder for each level"
    )
    given = parser.parse_args()
    size = build(given.folder, given.actions, given.levels, given.cache)
    if size > LARGEST:
        raise SystemExit(
            f"The kernels take {size / 1e6:.0f} MB, more than {LARGEST / 1e6:.0f} MB. Leave actions out."
        )


if __name__ == "__main__":
    main()
