"""Attacks saved runs and studies: runs are killed and resumed, folders and ledgers are damaged.

    python benchmarks/attack_saving.py --kill [--runs 30] [--seconds 120] [--at-once 10]    # about 15 minutes
    python benchmarks/attack_saving.py --damage [--folders 500] [--ledgers 200]             # about 10 minutes

`--kill`: runs of at least so many seconds, each killed by SIGKILL once to three times, at random moments or while
files are being written, and resumed, are compared bit by bit with runs in one go. A run is made long by pauses between
its stretches of steps, so that many are at risk at once on few cores; the run in one go has none.

`--damage`: run folders and ledgers of studies in which files are cut, zeroed, flipped, deleted, swapped or taken from
another run. Each must load, and be resumed, to identical numbers, or be refused by a message of Sarrus.

The exit code is 1 if anything else happens. `--seed` makes other random choices.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

import sarrus as sr
from sarrus import mechanisms
from sarrus.model.written import with_numbers
from sarrus.results.saving import saved

STATES = ("t", "q", "v", "a", "lam", "violation", "velocity_violation", "kinetic_energy", "potential_energy")
COUNTS = ("nfev", "njev", "nlu", "nsteps", "nrejected", "status", "message")
LEAST = 5  # checkpoints of a run that is killed


def crank(mass: float = 1.0) -> sr.System:
    """The slider-crank, with another rod."""
    model = sr.load(mechanisms.path("slider_crank"))
    return sr.System(with_numbers(model, {"rod.mass": mass}))


def balls() -> sr.System:
    """Two balls that bounce."""
    bodies = [
        sr.Body(n, mass=1, inertia=(1, 1, 1), position=(x, 0, 1 + x)) for x, n in enumerate(("one", "two"))
    ]
    return sr.System(sr.Model("balls", bodies=bodies, gravity=(0, 0, -9.81)))


def options(name: str) -> dict[str, Any]:
    """What is simulated: system and options by name."""
    dense = np.linspace(0, 20, 8001)
    fine = {"rtol": 1e-9, "atol": 1e-11}
    kinds: dict[str, dict[str, Any]] = {
        "HHT": {"until": 20.0, "t_eval": dense, "method": sr.HHT(**fine)},
        "generalized-alpha": {"until": 20.0, "t_eval": dense, "method": sr.GeneralizedAlpha(**fine)},
        "Radau": {"until": 20.0, "t_eval": dense, "method": sr.Radau(max_step=1e-3)},
        "ODE": {"until": 20.0, "t_eval": dense, "method": sr.ODE(max_step=2e-3)},
        "events": {
            "until": 20.0,
            "t_eval": dense,
            "events": [
                sr.Event("slider.x - 4.0", name="middle"),
                sr.Event("pin.angle^2 + 20*slider.x - 98", direction=-1),
            ],
            "method": sr.Radau(rtol=1e-6),
        },
        "impacts": {
            "until": 2.4,
            "t_eval": np.linspace(0, 2.4, 2001),
            "method": sr.Radau(max_step=2e-3),
            "events": [sr.Event(f"{n}.z", reset=sr.Impact(e)) for n, e in (("one", 0.8), ("two", 0.9))],
        },
        "steps": {
            "until": 6.0,
            "t_eval": np.linspace(0, 6, 2001),
            "method": sr.Radau(max_step=1e-3),
            "store": "steps",
        },
    }
    return {"system": balls() if name == "impacts" else crank(), **kinds[name]}


NAMES = ("HHT", "Radau", "events", "steps", "generalized-alpha", "ODE", "impacts")


# ------------------------------------------------------------------------------------------------------- kill
class Pace:
    """Called between stretches of steps: a pause, so that the whole run takes so many seconds."""

    def __init__(self, until: float, seconds: float) -> None:
        self.until, self.seconds, self.began, self.first = until, seconds, time.monotonic(), -1.0

    def __call__(self, t: float) -> None:
        if self.first < 0:
            self.first, self.began = t, time.monotonic()
        due = (t - self.first) / self.until * self.seconds
        time.sleep(max(0.0, due - (time.monotonic() - self.began)))


def child(name: str, folder: str, seconds: float) -> None:
    """One process of a run: it is resumed, or begun where nothing was written yet."""
    saved.BYTES = 100_000  # many chunks
    given = options(name)
    pace = Pace(given["until"], 1.2 * seconds)  # the first stretch of each process has no pause
    try:
        sr.resume(folder, progress=pace)
    except FileNotFoundError:
        sr.simulate(save=folder, progress=pace, **given)


class Killed:
    """One run, killed several times."""

    def __init__(self, number: int, place: Path, seconds: float, seed: int) -> None:
        self.name, self.folder, self.seconds = NAMES[number % len(NAMES)], place / f"run{number}", seconds
        self.random = random.Random(seed * 1000 + number)
        self.wanted = 1 + number % 3
        self.kills: list[str] = []
        self.checkpoints, self.lasted, self._seen, self._chunks = 0, 0.0, 0, 0
        self.wrong = ""

    def go(self) -> Killed:
        """Begin, kill and resume, until it ends by itself."""
        try:
            for _ in range(self.wanted + 1):
                if self._part():
                    return self
            self.wrong = "did not end"
        except Exception as wrong:
            self.wrong = f"{type(wrong).__name__}: {wrong}"
        return self

    def _part(self) -> bool:
        """One process of it; true if it ended by itself."""
        command = [sys.executable, __file__, "--child", self.name, str(self.folder), str(self.seconds)]
        last = len(self.kills) == self.wanted
        left = max(self.seconds - self.lasted, 1.0)
        moment = np.inf if last else self.random.uniform(0.0, 0.9 * left)
        aimed, early, began = self.random.random() < 0.5, self.random.random() < 0.2, time.monotonic()
        running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        began_run, before = None, self.checkpoints
        while running.poll() is None:
            self._look()
            if began_run is None and self.checkpoints > before:
                began_run = time.monotonic()
            since = began if early else began_run or np.inf
            now = time.monotonic() - since
            writing = self._is_writing() if aimed and now > moment - 0.2 else False
            if now > moment and (not aimed or writing or now > moment + 10):
                return self._kill(running, began_run, writing)
            time.sleep(0.001 if aimed and now > moment - 0.2 else 0.1)
        self.lasted += time.monotonic() - (began_run or began)
        _, told = running.communicate()
        if running.returncode:
            raise RuntimeError(told.strip().splitlines()[-1])
        return True

    def _kill(self, running: subprocess.Popen[str], began: float | None, writing: bool) -> bool:
        os.kill(running.pid, signal.SIGKILL)
        running.communicate()
        if running.returncode != -signal.SIGKILL:
            return running.returncode == 0
        self.lasted += time.monotonic() - began if began else 0.0
        before = "before the first checkpoint" if not (self.folder / saved.CHECKPOINT).exists() else "between"
        self.kills.append("while writing" if writing else before)
        return False

    def _is_writing(self) -> bool:
        """Whether a checkpoint is being written, or a chunk just was, so that others are still to come."""
        try:
            chunks = (self.folder / "q").stat().st_mtime_ns
        except OSError:
            return False
        found = (self.folder / f"{saved.CHECKPOINT}.draft").exists() or chunks != self._chunks
        self._chunks = chunks
        return found

    def _look(self) -> None:
        try:
            now = (self.folder / saved.CHECKPOINT).stat().st_mtime_ns
        except OSError:
            return
        self.checkpoints, self._seen = self.checkpoints + (now != self._seen), now


def kill(runs: int, seconds: float, at_once: int, seed: int) -> int:
    """All runs, and how they compare with those in one go."""
    wanted = {name: sr.simulate(**options(name)) for name in NAMES[:runs]}
    for name, run in wanted.items():
        print(f"{name}: {run.message}, {run.nsteps} steps", flush=True)
    failures, kills, began = 0, Counter[str](), time.monotonic()
    with tempfile.TemporaryDirectory(prefix="attack-") as place, ThreadPoolExecutor(at_once) as pool:
        tasks = [Killed(n, Path(place), seconds, seed) for n in range(runs)]
        for n, one in enumerate(pool.map(Killed.go, tasks)):
            wrong = one.wrong or differences(sr.resume(one.folder), wanted[one.name])
            if not wrong and one.checkpoints < LEAST:
                wrong = f"only {one.checkpoints} checkpoints"
            if not wrong and one.lasted < seconds:
                wrong = f"lasted only {one.lasted:.0f} s"
            failures += bool(wrong)
            kills.update(one.kills)
            told = f"{one.lasted:.0f} s, {one.checkpoints} checkpoints, killed {len(one.kills)} times"
            print(f"run {n} ({one.name}): {told}: {wrong or 'identical'}", flush=True)
            shutil.rmtree(one.folder, ignore_errors=True)
    print(
        f"{runs} runs, {sum(kills.values())} kills ({dict(kills)}), {runs - failures} bit-identical, ", end=""
    )
    print(f"{failures} failures; {time.monotonic() - began:.0f} s")
    return failures


def differences(one: Any, other: Any) -> str:
    """Names of what is not the same, bit by bit; an empty text if all is."""
    found = [name for name in (*STATES, "history") if not same(getattr(one, name), getattr(other, name))]
    found += [name for name in COUNTS if getattr(one, name) != getattr(other, name)]
    if len(one.events) != len(other.events):
        found.append("number of events")
    for mine, its in zip(one.events, other.events, strict=False):
        found += [
            f"event {name}"
            for name in ("t", "q", "v", "after")
            if not same(vars(mine)[name], vars(its)[name])
        ]
    if other.steps is not None:
        found += [
            f"steps {n}"
            for n in ("t", "q", "v", "lam")
            if not same(getattr(one.steps, n), getattr(other.steps, n))
        ]
        found += [f"sol({t})" for t in (0.1, 1.7, 5.3) if not same(one.sol(t).q, other.sol(t).q)]
    return ", ".join(found)


def same(one: Any, other: Any) -> bool:
    """Equal bits."""
    mine, its = np.asarray(one), np.asarray(other)
    return mine.shape == its.shape and mine.tobytes() == its.tobytes()


# ----------------------------------------------------------------------------------------------------- damage
Damage = Callable[[Path, Path, random.Random], str]


def damaged_bytes(data: bytes, how: str, chance: random.Random) -> bytes:
    """A file's content after an accident."""
    place = chance.randrange(len(data) + 1)
    some = bytearray(data)
    if how == "cut":
        return data[:place]
    if how == "zeroed":
        return bytes(len(data))
    if how == "block zeroed":
        block = place // 512 * 512
        some[block : block + 512] = bytes(len(some[block : block + 512]))
        return bytes(some)
    if how == "bit flipped" and data:
        some[place % len(data)] ^= 1 << chance.randrange(8)
        return bytes(some)
    if how == "appended":
        return data + chance.randbytes(1 + chance.randrange(20))
    if how == "garbage":
        return chance.randbytes(len(data))
    return b""


BYTES_WISE = ("cut", "zeroed", "block zeroed", "bit flipped", "bit flipped", "appended", "garbage", "emptied")
FILE_WISE = ("deleted", "swapped", "from another run", "from another place", "a folder")


def damage_folder(folder: Path, other: Path, chance: random.Random) -> str:
    """Damage one file of a folder; what was done."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    path, how = chance.choice(files), chance.choice((*BYTES_WISE, *FILE_WISE))
    if how in BYTES_WISE:
        path.write_bytes(damaged_bytes(path.read_bytes(), how, chance))
    elif how == "from another run" and (other / path.relative_to(folder)).is_file():
        shutil.copy(other / path.relative_to(folder), path)
    elif how in ("swapped", "from another place"):
        second = chance.choice([one for one in files if one.suffix == path.suffix])
        first, content = path.read_bytes(), second.read_bytes()
        path.write_bytes(content)
        second.write_bytes(first if how == "swapped" else content)
    else:
        path.unlink()
        if how == "a folder":
            path.mkdir()
    return f"{path.relative_to(folder)} {how}"


def stop_after(t_end: float) -> Callable[[float], None]:
    """Stop a run on its way."""

    def stop(t: float) -> None:
        if t > t_end:
            raise KeyboardInterrupt

    return stop


def pairs_of_runs(place: Path) -> Iterator[tuple[str, Path, Path, Any, Any]]:
    """Kinds of folders: name, folder, that of another run, what it loads as, and the whole run."""
    from sarrus.analyses.dynamics.time_loop import recording, time_loop

    recording.PAUSE = recording.PATIENT = 0.0
    time_loop.CHUNK = 40
    kinds = {
        "finished": (20_000, None, {"until": 1.0, "t_eval": np.linspace(0, 1, 1001)}),
        "cut short": (
            20_000,
            0.6,
            {"until": 1.0, "t_eval": np.linspace(0, 1, 1001), "method": sr.Radau(rtol=1e-7)},
        ),
        "no chunk yet": (
            10**6,
            0.3,
            {"until": 0.5, "t_eval": np.linspace(0, 0.5, 101), "method": sr.Radau(rtol=1e-7)},
        ),
    }
    for name, (size, stop, given) in kinds.items():
        saved.BYTES = size
        folders = [place / f"{name} {n}" for n in range(2)]
        for folder, mass in zip(folders, (1.0, 1.5), strict=True):
            sr.simulate(crank(mass), save=folder, progress=stop_after(stop) if stop else None, **given)
        yield name, *folders, sr.load_run(folders[0]), sr.simulate(crank(), **given)


def verdict(make: Callable[[], Any], wanted: Any) -> str:
    """What became of reading: identical, refused by a message, or how it failed."""
    try:
        run = make()
        if run.status == "not saved":
            return "refused" if len(run.message) > 20 else "FAILED: no message"
        wrong = differences(run, wanted)
    except sr.SarrusError as told:
        return "refused" if len(str(told)) > 20 else f"FAILED: no message but {str(told)!r}"
    except Exception as raw:
        return f"FAILED: {type(raw).__name__}: {raw}"
    return f"FAILED: other {wrong}" if wrong else "identical"


def damage_runs(count: int, chance: random.Random, place: Path) -> Counter[str]:
    """Damage so many run folders."""
    found = Counter[str]()
    kinds = list(pairs_of_runs(place))
    for n in range(count):
        name, folder, other, loaded, whole = kinds[n % len(kinds)]
        copy = place / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(folder, copy)
        done = [damage_folder(copy, other, chance) for _ in range(chance.choice((1, 1, 2)))]
        told = {"load": verdict(lambda: sr.load_run(copy), loaded)}  # noqa: B023 - called at once
        told["resume"] = verdict(lambda: sr.resume(copy), whole)  # noqa: B023
        for verb, one in told.items():
            found[f"{verb}: {one.split(':')[0]}"] += 1
            if one.startswith("FAILED"):
                print(f"{name}, {verb}, {'; '.join(done)}: {one}", flush=True)
    return found


def number(system: sr.System) -> dict[str, float]:
    """The response of a study."""
    return {"x": float(system.model.bodies[1].mass) ** 2 / 3}


def damage_ledgers(count: int, chance: random.Random, place: Path) -> Counter[str]:
    """Damage so many studies."""
    model = sr.load(mechanisms.path("slider_crank"))

    def run(folder: Path, first: float = 1.0) -> Any:
        values = {"rod.mass": list(first + np.arange(30) / 7)}
        return sr.study(model, values, {"x": "x"}, analysis=number, workers=1, folder=folder)

    whole, _ = run(place / "study 0"), run(place / "study 1", 1.05)
    found = Counter[str]()
    for _ in range(count):
        copy = place / "copy of a study"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(place / "study 0", copy)
        done = damage_ledger(copy, place / "study 1", chance)
        for verb, make in (("open", lambda: sr.open_study(copy)), ("continue", lambda: run(copy))):  # noqa: B023
            one = verdict_of_study(make, whole, verb == "continue")
            found[f"{verb}: {one.split(':')[0]}"] += 1
            if one.startswith("FAILED"):
                print(f"study, {verb}, {done}: {one}", flush=True)
    return found


def damage_ledger(folder: Path, other: Path, chance: random.Random) -> str:
    """Damage one file, or some lines, of a study."""
    if chance.random() < 0.5:
        for model_file in (folder / "model").rglob("*"):
            model_file.unlink()  # copies for people: no number is read from them
        return damage_folder(folder, other, chance)
    path = folder / "cases.jsonl"
    lines, how = path.read_bytes().splitlines(keepends=True), chance.randrange(6)
    one, two = chance.randrange(len(lines)), chance.randrange(len(lines))
    if how == 0:
        lines.insert(one, b"\n")
    elif how == 1:
        lines.insert(one, lines[two])
    elif how == 2:
        lines[one], lines[two] = lines[two], lines[one]
    elif how == 3:
        del lines[one]
    elif how == 4:
        lines[one] = (other / "cases.jsonl").read_bytes().splitlines(keepends=True)[one]
    else:
        lines[one] = lines[one].replace(b"1", b"2", 1)
    path.write_bytes(b"".join(lines))
    return f"lines {one}, {two}: damage {how}"


def verdict_of_study(make: Callable[[], Any], whole: Any, complete: bool) -> str:
    """As `verdict`; a ledger that was cut holds fewer cases, which are computed when it is continued."""
    try:
        table = make()
    except sr.SarrusError:
        return "refused"
    except Exception as raw:
        return f"FAILED: {type(raw).__name__}: {raw}"
    if table.status == "not saved":
        return "refused" if table.warnings else "FAILED: no message"
    done = np.isfinite(table["x"])
    if not (same(table.values, whole.values) and same(table["x"][done], whole["x"][done])):
        return "FAILED: other numbers"
    if done.all():
        return "identical"
    return "FAILED: cases are missing" if complete else "identical as far as it goes"


def damage(folders: int, ledgers: int, seed: int) -> int:
    """Damage folders and ledgers; the number of failures."""
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="attack-") as place:
        runs, studies = (
            damage_runs(folders, chance, Path(place)),
            damage_ledgers(ledgers, chance, Path(place)),
        )
    print(f"{folders} run folders: {dict(sorted(runs.items()))}")
    print(f"{ledgers} ledgers: {dict(sorted(studies.items()))}")
    return sum(count for told, count in (runs + studies).items() if "FAILED" in told)


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kill", action="store_true")
    parser.add_argument("--damage", action="store_true")
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--at-once", type=int, default=10)
    parser.add_argument("--folders", type=int, default=500)
    parser.add_argument("--ledgers", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--child", nargs=3, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.child:
        child(chosen.child[0], chosen.child[1], float(chosen.child[2]))
        return 0
    failures = 0
    if chosen.kill:
        failures += kill(chosen.runs, chosen.seconds, chosen.at_once, chosen.seed)
    if chosen.damage:
        failures += damage(chosen.folders, chosen.ledgers, chosen.seed)
    return 1 if failures else 0


if __name__ == "__main__":
    raise SystemExit(main())
