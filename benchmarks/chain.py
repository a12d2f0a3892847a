"""One evaluation of everything for a chain of N bodies: time and memory per body should not depend on N.

    python benchmarks/chain.py [--json] [--quick] [--sizes 100 1000 ...]

The chain hangs from the ground: revolute joints with the axis y, a spring and damper between neighbours, gravity.
Every length runs in a process of its own, so that its peak memory is its own. The kernels are compiled beforehand.
"""

from __future__ import annotations

import argparse
import json
import resource
import statistics
import subprocess
import sys
import time
from typing import Any

from sarrus.elements import OPERATORS

SIZES = (100, 1_000, 10_000, 100_000)
QUICK = (100, 1_000, 10_000)
STAGES = ("model", "system", "patterns", "first", "evaluation")


def chain(count: int) -> Any:
    """The model: link k from (k, 0, 0) to (k + 1, 0, 0), centre of mass in the middle."""
    from sarrus.model import TSDA, Body, Model, Revolute, ground

    bodies = [Body(f"link_{k}", 1.0, (0.02, 0.1, 0.1), position=(k + 0.5, 0.0, 0.0)) for k in range(count)]
    pairs = list(zip([ground, *bodies], bodies, strict=False))
    joints = [
        Revolute(f"pin_{k}", i, j, point=(float(k), 0.0, 0.0), axis=(0.0, 1.0, 0.0))
        for k, (i, j) in enumerate(pairs)
    ]
    springs = [
        TSDA(f"spring_{k}", i.point(0.0, 0.0, 0.3), j.point(0.1, 0.0, 0.2), k=100.0, length=0.9, c=1.0)
        for k, (i, j) in enumerate(pairs)
    ]
    return Model("chain", bodies, joints, springs, gravity=(0.0, 0.0, -9.81))


def state(system: Any) -> dict[str, Any]:
    """Operands of every operator: coordinates off the unit sphere, everything else random."""
    import numpy as np

    random = np.random.default_rng(7)
    operands = {name: random.standard_normal(system.nq) for name in ("xi", "eta", "v", "a")}
    operands |= {"q": system.q0 + 0.01 * random.standard_normal(system.nq), "t": 0.3}
    return operands | {"lam": random.standard_normal(system.m)}


def peak() -> float:
    """Peak memory of this process so far, in bytes."""
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def evaluate(system: Any, operands: dict[str, Any], outputs: Any) -> tuple[dict[str, Any], dict[str, float]]:
    """Every operator of the system once, through its public method, and the seconds of each."""
    results, seconds = {}, {}
    for name, operator in OPERATORS.items():
        wanted = ("q", *operator.operands)
        start = time.perf_counter()
        out = outputs[name] if outputs else None
        results[name] = getattr(system, name)(*(operands[n] for n in wanted), out=out)
        seconds[name] = time.perf_counter() - start
    return results, seconds


def measure(count: int, repeats: int) -> dict[str, Any]:
    """Times [s] of all stages and the memory [bytes] that each adds to the peak."""
    from sarrus.system import System

    warm = System(chain(3))
    evaluate(warm, state(warm), None)
    clock, memory = [time.perf_counter()], [peak()]

    def lap() -> None:
        clock.append(time.perf_counter())
        memory.append(peak())

    model = chain(count)
    lap()
    system = System(model)
    lap()
    for name in OPERATORS:
        system.group(name)
    lap()
    operands = state(system)
    clock[-1] = time.perf_counter()
    results, _ = evaluate(system, operands, None)
    lap()
    runs = [evaluate(system, operands, results)[1] for _ in range(repeats)]
    kernels = {name: min(run[name] for run in runs) for name in OPERATORS}
    times = {n: b - a for n, a, b in zip(STAGES, clock, clock[1:], strict=False)}
    times["evaluation"] = statistics.median(sum(run.values()) for run in runs)
    return {
        "bodies": count,
        "seconds": times,
        "bytes": {n: b - a for n, a, b in zip(STAGES, memory, memory[1:], strict=False)},
        "peak": memory[-1] - memory[0],
        "stored": sum(system.pattern(name).size for name in OPERATORS),
        "kernels": kernels,
    }


def in_own_process(count: int, repeats: int) -> dict[str, Any]:
    """`measure` in a fresh process."""
    command = [sys.executable, __file__, "--one", str(count), "--repeats", str(repeats)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return dict(json.loads(done.stdout))


def ratios(results: list[dict[str, Any]]) -> dict[str, float]:
    """Named figures: microseconds and bytes per body, and how they grow from the second length to the last."""
    figures: dict[str, float] = {}
    for result in results:
        count = result["bodies"]
        for stage, seconds in result["seconds"].items():
            figures[f"chain.{count}.{stage}_us_per_body"] = 1e6 * seconds / count
        figures[f"chain.{count}.peak_bytes_per_body"] = result["peak"] / count
    if len(results) > 2:
        first, last = results[1], results[-1]
        factor = last["bodies"] / first["bodies"]
        for stage in STAGES:
            growth = last["seconds"][stage] / first["seconds"][stage]
            figures[f"chain.growth.{stage}"] = growth / factor
        figures["chain.growth.memory"] = last["peak"] / first["peak"] / factor
    return figures


def show(results: list[dict[str, Any]]) -> None:
    """A readable table."""
    print("µs per body" + "".join(f"{stage:>12}" for stage in STAGES) + "   memory")
    for result in results:
        count = result["bodies"]
        times = "".join(f"{1e6 * result['seconds'][stage] / count:12.2f}" for stage in STAGES)
        print(f"N = {count:<7}{times}   {result['peak'] / count / 1024:.1f} KiB per body")
    if len(results) > 2:
        text = f"from N = {results[1]['bodies']} to {results[-1]['bodies']} (1 is linear): "
        growth = {k.rsplit(".", 1)[1]: v for k, v in ratios(results).items() if ".growth." in k}
        print(text + ", ".join(f"{name} {value:.2f}" for name, value in growth.items()))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one object of named figures")
    parser.add_argument("--quick", action="store_true", help="no chain of 100,000 bodies")
    parser.add_argument("--sizes", type=int, nargs="+")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(measure(arguments.one, arguments.repeats)))
        return
    in_own_process(3, 1)  # compiles the kernels
    sizes = arguments.sizes or (QUICK if arguments.quick else SIZES)
    results = [in_own_process(count, arguments.repeats) for count in sizes]
    if arguments.json:
        print(json.dumps(ratios(results), indent=2))
    else:
        show(results)


if __name__ == "__main__":
    main()
