"""Shows that no kernel allocates memory.

    python benchmarks/allocation.py [--json] [--calls 100000]

1. What the compiled drivers of the three groups call, read from LLVM's output: their own loops, memset and a few
   functions of libm, and nothing else. (The wrapper through which Python calls them unpacks arguments; it is left out.)
2. How often malloc, calloc and realloc (glibc, preloaded counter) and Numba's own allocator are called while the
   groups of the HMMWV run: in compiled code, and per call from Python, where Numba notes every array that it is given.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ALLOWED = re.compile(r"llvm\.|sarrus\.|(sin|cos|tan|asin|acos|atan|atan2|exp|log|tanh|floor|sqrt|memset)$")
DEFINED = re.compile(r"define [^@]*@\"?([^\"(]+)\"?\(")
CALLED = re.compile(r"\bcall\b[^@\n]*@\"?([^\"(]+)\"?\(")


def called(text: str) -> dict[str, set[str]]:
    """What every function of a module calls."""
    calls: dict[str, set[str]] = {}
    name = ""
    for line in text.splitlines():
        if found := DEFINED.search(line):
            name = found.group(1)
            calls[name] = set()
        calls.get(name, set()).update(CALLED.findall(line))
    return calls


def suspicious(driver: Any) -> tuple[int, list[str]]:
    """Functions that a driver and its loops call and should not, and how many functions were looked at."""
    (signature,) = driver.signatures
    calls = called(driver.inspect_llvm(signature))
    wrapper = re.compile(r"_ZN7cpython|cfunc\.|NRT_")
    kernels = {name: targets for name, targets in calls.items() if not wrapper.match(name)}
    if not kernels:
        raise AssertionError("no code to look at: the kernels were not compiled here")
    strange = {
        t for targets in kernels.values() for t in targets if not ALLOWED.match(t) and t not in kernels
    }
    return len(kernels), sorted(strange)


def inside(calls: int) -> dict[str, Any]:
    """All figures; in a process with the counter preloaded, an empty kernel cache and Numba's statistics on."""
    import tracemalloc

    from numba.core.runtime import rtsys
    from subjects import cases, compiled_loop

    count = ctypes.CDLL(None).allocations
    count.restype = ctypes.c_long
    figures: dict[str, Any] = {}
    for case in cases(("hmmwv",)):
        loop, run, arguments = compiled_loop(case), case.group.run, case.arguments
        looked, strange = suspicious(case.group.compiled)
        seen = []
        for times in (1, calls + 1):
            before, numba_before = count(), rtsys.get_allocation_stats().alloc
            loop(times)
            seen.append((count() - before, rtsys.get_allocation_stats().alloc - numba_before))
        compiled, numba = (more - once for once, more in zip(*seen, strict=True))
        run(*arguments)
        before = count()
        for _ in range(calls):
            run(*arguments)
        python = count() - before
        tracemalloc.start()
        run(*arguments)
        kept = tracemalloc.get_traced_memory()[0]
        for _ in range(1000):
            run(*arguments)
        kept = tracemalloc.get_traced_memory()[0] - kept
        tracemalloc.stop()
        figures |= {
            f"{case.group_name}.functions": looked,
            f"{case.group_name}.strange_calls": strange,
            f"{case.group_name}.mallocs_compiled": compiled,
            f"{case.group_name}.numba_allocations": numba,
            f"{case.group_name}.mallocs_per_python_call": python / calls,
            f"{case.group_name}.python_bytes_kept": kept,
        }
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one object of named figures")
    parser.add_argument("--calls", type=int, default=100_000)
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.inside:
        print(json.dumps(inside(arguments.calls)))
        return
    with tempfile.TemporaryDirectory() as folder:
        counter = Path(folder) / "malloc_count.so"
        source = Path(__file__).with_name("malloc_count.c")
        subprocess.run(["gcc", "-O2", "-shared", "-fPIC", str(source), "-o", str(counter)], check=True)
        environment = {
            **os.environ,
            "SARRUS_CACHE_DIR": folder,
            "LD_PRELOAD": str(counter),
            "NUMBA_NRT_STATS": "1",
        }
        command = [sys.executable, __file__, "--inside", "--calls", str(arguments.calls)]
        done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    figures = json.loads(done.stdout)
    if arguments.json:
        print(json.dumps(figures, indent=2))
    else:
        print(f"HMMWV, {arguments.calls} calls of each group")
        for name, value in figures.items():
            print(f"{name:36}{value!s:>10}")
    if any(value for name, value in figures.items() if name.endswith(("calls", "compiled", "allocations"))):
        sys.exit("something allocates")


if __name__ == "__main__":
    main()
