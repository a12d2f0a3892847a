"""Shares of the time of runs by what is computed, sampled by Linux's `perf`.

    python -m benchmarks.shares FILE... [--until 1] [--tolerance 1e-6]

The trees of `benchmarks.trees` are integrated by Radau, one after another, for some seconds each. Samples are counted
by the compiled function in which they are: factorization, solutions with the factors, kernels of the elements and their
derivatives, loops of the steps, and Python, which prepares a run and collects its results.
"""

from __future__ import annotations

import argparse
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from .trees import Problem

SECONDS = 10.0  # of processor time for each file
KINDS = {  # by what the name of a compiled function contains, the first that fits
    "choice of pivots": "pivot_order|symbolic|postorder|slots|transposed_|compressed",
    "factorization": "sparse_lu.*refactor|block_matrix.*(assemble|refactor)|hypot",
    "solutions": "sparse_lu.*solve|backsolve|scatter|gather",
    "derivatives of elements": r"sarrus\.\w+\.(\S*\+)?\w+_[qv](\+|$)",
    "elements": r"sarrus\.\w+\.",
    "other loops": "sarrus",
}
OTHERS = "Python and libraries"


def sampled(path: Path, until: float, tolerance: float) -> dict[str, float]:
    """Integrate a tree again and again, print what one run took, and return the share of each kind [%]."""
    problem = Problem(path, until)
    run, call = problem.by_sarrus("Radau", tolerance), problem.setup()
    with tempfile.TemporaryDirectory() as folder:
        data = str(Path(folder) / "perf.data")
        perf = subprocess.Popen(["perf", "record", "-q", "-F", "1000", "-p", str(os.getpid()), "-o", data])
        begin, runs = time.process_time(), 0
        while time.process_time() < begin + SECONDS:
            problem.by_sarrus("Radau", tolerance)
            runs += 1
        whole = (time.process_time() - begin) / runs
        perf.send_signal(signal.SIGINT)
        perf.wait()
        write_names()
        command = ["perf", "script", "-i", data, "-F", "ip,sym"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    counts = f"{run.nsteps} steps, {run.nrejected} repeated; {run.nfev} residuals, {run.nlu} factorizations"
    print(f"{path.name}: {counts}; {1e3 * whole:.1f} ms, of which {1e3 * call:.1f} ms are those of a call")
    return shares(line.split(maxsplit=1)[-1] for line in done.stdout.splitlines() if line.strip())


def write_names() -> None:
    """Write the addresses and names of all compiled functions where `perf` searches them."""
    from numba.core.registry import cpu_target

    engine = cpu_target.target_context.codegen()._engine
    found = sorted((engine._ee.get_function_address(name), name) for name in set(engine._defined_symbols))
    ends = [address for address, _ in found[1:]] + [found[-1][0] + 65536]
    lines = [f"{at:x} {end - at:x} {name}" for (at, name), end in zip(found, ends, strict=True) if at]
    Path(f"/tmp/perf-{os.getpid()}.map").write_text("\n".join(lines))


def shares(names: Iterable[str]) -> dict[str, float]:
    """Return the share of each kind [%]; `names` has the function of each sample."""
    found: Counter[str] = Counter()
    for name, count in Counter(names).items():
        found[next((kind for kind, word in KINDS.items() if re.search(word, name)), OTHERS)] += count
    return {kind: 100 * found[kind] / found.total() for kind in (*KINDS, OTHERS)}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--until", type=float, default=1.0, help="[s]")
    parser.add_argument("--tolerance", type=float, default=1e-6)
    chosen = parser.parse_args()
    warnings.simplefilter("ignore")
    for path in chosen.files:
        for kind, share in sampled(path, chosen.until, chosen.tolerance).items():
            print(f"  {share:5.1f} % {kind}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
