"""Throw damaged files and wrong arguments at Sarrus: each must be accepted rightly, or refused by a message of ours.

    python benchmarks/fuzz.py --minutes 10                 all kinds, the time shared among them
    python benchmarks/fuzz.py --kind yaml study --seed 7
    python benchmarks/fuzz.py --kind yaml --seed 7 --case 412     one case again, with its traceback

A finding is a raw error, a hang (10 s of processor time, or a minute of the clock), a death of the process, or accepted
nonsense (``attack/oracle.py``). Cases run in child processes; the same seed gives the same cases.
"""

from __future__ import annotations

import argparse
import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

KINDS = ("yaml", "json", "urdf", "mjcf", "mesh", "study", "optimization", "api")
PROCESSOR, CLOCK = 10.0, 90.0  # seconds of a case; of the clock more, for kernels may have to be compiled
MEMORY = 6 * 2**30  # bytes


class Hang(BaseException):
    """A case took too much time."""


def verdict(kind: str, seed: int, number: int, folder: Path) -> dict[str, Any]:
    """What came of one case: accepted, refused, or a finding with its place."""
    from attack.targets import TARGETS

    case = TARGETS[kind](Random(f"{seed} {kind} {number}"))
    try:
        wrong = case.run(folder)
    except Hang:
        return _finding(
            "hang", "", "".join(traceback.format_exc().splitlines(keepends=True)[-8:]), case.content
        )
    except Exception as error:
        if refused(error):
            return {"verdict": "refused", "message": str(error)}
        frames = traceback.extract_tb(error.__traceback__)
        place = next(
            (f"{f.filename}:{f.lineno}" for f in reversed(frames) if "/sarrus/" in f.filename), "outside"
        )
        return _finding(
            "raw error", f"{type(error).__name__} at {place}", traceback.format_exc(), case.content
        )
    if wrong:
        return _finding("nonsense", wrong[0].split(":")[-1][:40], "\n".join(wrong), case.content)
    return {"verdict": "accepted"}


def refused(error: Exception) -> bool:
    """Whether an error was raised on purpose by a line of ours, or by Python for a call that does not fit."""
    import sarrus as sr

    if isinstance(error, sr.SarrusError | ImportError):
        return "defect" not in str(error)
    last = traceback.extract_tb(error.__traceback__)[-1]
    if last.filename.endswith("attack/calls.py"):
        return isinstance(error, TypeError)
    meant = isinstance(error, ValueError | TypeError | LookupError | AttributeError)
    return meant and "/sarrus/" in last.filename and (last.line or "").startswith("raise")


def _finding(verdict: str, place: str, told: str, content: bytes) -> dict[str, Any]:
    return {
        "verdict": verdict,
        "place": place,
        "message": told,
        "content": content.decode(errors="replace")[:20_000],
    }


def work(kind: str, seed: int, first: int) -> None:
    """Run cases for ever, telling each before and after."""
    import resource

    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    signal.signal(signal.SIGPROF, _hang)
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        if kind == "api":
            from attack.calls import functions

            functions()
        number = first
        while True:
            _tell({"begins": number})
            signal.setitimer(signal.ITIMER_PROF, PROCESSOR)
            found = verdict(kind, seed, number, Path(name))
            signal.setitimer(signal.ITIMER_PROF, 0)
            _tell({"case": number, **found})
            number += 1


def _hang(*_: Any) -> None:
    raise Hang


def _tell(what: dict[str, Any]) -> None:
    print(json.dumps(what), file=TOLD, flush=True)


class Child:
    """A process that runs cases of a kind; what it tells comes in order, nothing for too long is a hang."""

    def __init__(self, kind: str, seed: int, first: int) -> None:
        command = [sys.executable, __file__, "--work", kind, str(seed), str(first)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.lines: queue.Queue[str | None] = queue.Queue()
        threading.Thread(target=self._listen, daemon=True).start()
        threading.Thread(target=self._errors, daemon=True).start()
        self.errors = ""

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.put(line)
        self.lines.put(None)

    def _errors(self) -> None:
        assert self.process.stderr is not None
        self.errors = self.process.stderr.read()[-3000:]

    def told(self, seconds: float) -> dict[str, Any]:
        """The next thing that is told; a finding if nothing comes."""
        try:
            line = self.lines.get(timeout=seconds)
        except queue.Empty:
            return {"verdict": "hang", "place": "clock", "message": "nothing for a minute", "content": ""}
        if line is None:
            self.process.wait()
            time.sleep(0.2)
            return {
                "verdict": "death",
                "place": "",
                "message": f"exit {self.process.returncode}\n{self.errors}",
                "content": "",
            }
        found: dict[str, Any] = json.loads(line)
        return found

    def end(self) -> None:
        self.process.kill()
        self.process.wait()


def attack(
    kind: str, seed: int, seconds: float, cases: int | None
) -> tuple[Counter[str], list[dict[str, Any]]]:
    """Counts of verdicts, and the first finding at each place."""
    counts: Counter[str] = Counter()
    findings: dict[str, dict[str, Any]] = {}
    child, number, end = Child(kind, seed, 0), 0, time.monotonic() + seconds
    while time.monotonic() < end and (cases is None or number < cases):
        told = child.told(CLOCK)
        if "begins" in told:
            number = told["begins"]
            continue
        counts[told["verdict"]] += 1
        if told["verdict"] not in ("accepted", "refused"):
            key = f"{told['verdict']} {told['place']}"
            found = findings.setdefault(key, {"kind": kind, "seed": seed, "case": number, "times": 0, **told})
            found["times"] += 1
        number += 1
        if "case" not in told:
            child.end()
            child = Child(kind, seed, number)
    child.end()
    return counts, [*findings.values()]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kind", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cases", type=int, help="of each kind")
    parser.add_argument("--case", type=int, help="run this one alone, here")
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    if chosen.case is not None:
        with tempfile.TemporaryDirectory() as name:
            warnings.simplefilter("ignore")
            found = verdict(chosen.kind[0], chosen.seed, chosen.case, Path(name))
        print("\n".join(f"--- {key}\n{value}" for key, value in found.items()))
        return int(found["verdict"] not in ("accepted", "refused"))
    everything: list[dict[str, Any]] = []
    totals: dict[str, Counter[str]] = {}
    for kind in chosen.kind:
        totals[kind], found = attack(kind, chosen.seed, 60 * chosen.minutes / len(chosen.kind), chosen.cases)
        everything += found
        if not chosen.json:
            _report(kind, totals[kind], found)
    if chosen.json:
        print(json.dumps({"counts": totals, "findings": everything}))
    return int(bool(everything))


def _report(kind: str, counts: Counter[str], findings: list[dict[str, Any]]) -> None:
    print(f"{kind}: " + ", ".join(f"{n} {what}" for what, n in counts.most_common()), flush=True)
    for one in findings:
        last = one["message"].strip().splitlines()[-1][:200] if one["message"].strip() else ""
        again = f"python benchmarks/fuzz.py --kind {kind} --seed {one['seed']} --case {one['case']}"
        print(f"  {one['verdict']}, {one['times']} times, {one['place']}: {last}\n    {again}", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--work"]:
        TOLD, sys.stdout = sys.stdout, sys.stderr
        work(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
    sys.exit(main())
