"""Every robot and mechanism file in folders: load, simulate briefly, and compare accelerations with MuJoCo.

``python -m benchmarks.corpora FOLDER...`` prints how many files of each format ran, were refused (by reason) or
crashed, and how many agree with MuJoCo to 1e-6 of the largest acceleration. A process of its own tries them, and is
replaced when a file crashes it or takes longer than the time limit. ``--hashes FILE.csv`` writes a table of files by
repository, commit, path and hash, with their results.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import multiprocessing
import re
import subprocess
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from tests.io.beside_mujoco import accelerations, numbers_of, of_mujoco, random_configuration

import sarrus as sr
from sarrus.io.mjcf.compiled import compiled

FORMATS = {"mujoco": "MJCF", "robot": "URDF", "sdf": "SDF"}  # by root element
ENDINGS = (".urdf", ".sdf", ".world", ".xml")
PART = re.compile(r'"[^"]*"|\'[^\']*\'|-?\d[\d.,e+-]*|\[.*?\]')  # of a reason, that differs from file to file
AGREE = 1e-6
UNREADABLE = ("cannot be read by MuJoCo", "is not well-formed XML")  # in Sarrus's messages on an MJCF
LARGE = "larger than what was compared within the time limit"
FRICTION = (sr.AngleFriction, sr.DisplacementFriction)


def files(folders: list[Path]) -> Iterator[tuple[Path, str]]:
    """Yield the files in folders with their formats; MJCF without bodies are parts of others."""
    for folder in folders:
        for path in sorted(folder.rglob("*") if folder.is_dir() else [folder]):
            if path.suffix.lower() in ENDINGS and path.is_file():
                text = path.read_text(errors="replace")
                root = re.search(r"<(mujoco|robot|sdf)[\s>]", text)
                if root and (root[1] != "mujoco" or "<worldbody" in text or "<include" in text):
                    yield path, FORMATS[root[1]]


def reason(message: str) -> str:
    """Return a message without file, line, part and numbers; of what changes the motion, the words to ignore it."""
    if needed := re.search(r"ignore=\[.*\]", message):
        return f"moves differently without what it has, {needed[0]}"
    message = re.sub(r"^[^ ]*: (\S+ \"[^\"]*\": |file: |robot: |import: )?", "", message)
    return PART.sub("…", message.partition(". ")[0])[:150]


def tried(path: Path, kind: str, ignore: list[str], until: float) -> Iterator[dict[str, Any]]:
    """Yield what happens to one file; if it runs, before it is compared and after."""
    found: dict[str, Any] = {"file": str(path), "format": kind, "result": "ran"}
    options: dict[str, Any] = {"inertia": "given"} | ({"ignore": ignore} if ignore else {})
    try:
        try:
            robot = sr.load_any(path, **options)
        except sr.ModelError as error:
            if "nothing in it moves" not in str(error) or kind != "URDF":
                raise
            robot = sr.load_any(path, base="floating", **options)
        found["bodies"], system = len(robot.bodies), sr.System(robot)
        run = sr.simulate(system, until=until, t_eval=[0.0, until])
        if not run.success:
            found |= {"result": "stopped", "reason": reason(run.message)}
    except (sr.ModelError, ImportError) as error:
        unreadable = kind == "MJCF" and any(text in str(error) for text in UNREADABLE)
        result = "unreadable" if unreadable else "refused"
        yield found | {"result": result, "reason": reason(str(error)), "message": str(error)}
        return
    except Exception as error:
        yield found | {"result": "crashed", "reason": f"{type(error).__name__}: {error}"[:200]}
        return
    yield found | {"not compared": LARGE}
    try:
        found["difference"] = difference(path, kind, robot, ignore)
    except Exception as error:
        found["not compared"] = f"{type(error).__name__}: {' '.join(str(error).split())}"[:150]
    yield found


def difference(path: Path, kind: str, robot: sr.Robot, ignore: list[str]) -> float:
    """Return the largest difference of accelerations in random states, as a part of the largest acceleration."""
    import mujoco

    if kind == "SDF":
        raise ValueError("MuJoCo does not read SDF")
    spec = mujoco.MjModel.from_xml_string(_bare(path)) if kind == "URDF" else compiled(path)[0]
    if not spec.nv:
        raise ValueError("nothing in it moves")
    disabled = spec.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    if (spec.neq and not disabled) or robot.mimics:
        raise ValueError("has equalities, which MuJoCo makes elastic")
    if kind == "URDF" and any(isinstance(force, sr.RSDA) and force.k for force in robot.forces):
        raise ValueError("has springs for Gazebo, which MuJoCo does not read")
    spec.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
    spec.opt.tolerance = 0
    if "fluid" in ignore:
        spec.opt.density = spec.opt.viscosity = 0
    spec.dof_frictionloss[:] = 0  # MuJoCo's is elastic, and does not reach its limit on light bodies
    if kind == "MJCF":
        robot = sr.load_any(
            path, inertia="given", ignore=[*ignore, "limits", "contacts"]
        )  # also those of tendons
    forces = without_friction(robot.forces)
    system = sr.System(sr.Model(robot.name, robot.bodies, robot.joints, forces, robot.gravity))
    space, rng, worst = sr.JointSpace(sr.System(robot)), np.random.default_rng(8), 0.0
    for _ in range(3):
        theta, qpos, order = random_configuration(space, spec, rng)
        rates = rng.choice([-1, 1], space.freedoms) * rng.uniform(0.5, 2, space.freedoms)
        data = mujoco.MjData(spec)
        data.qpos[:], data.qvel[:] = qpos, rates[order]
        mujoco.mj_forward(spec, data)
        mujoco.mj_rnePostConstraint(spec, data)
        found, numbers = (
            accelerations(system, space.q(theta), space.v(theta, rates)),
            numbers_by_body(robot, spec),
        )
        expected = {name: of_mujoco(spec, data, name, numbers[name]) for name in found if name in numbers}
        if not expected:
            raise ValueError("no body has the same name")
        largest = max(1.0, *(abs(one).max() for one in expected.values()))  # [m/s², rad/s²]
        worst = max(worst, *(abs(found[name] - one).max() / largest for name, one in expected.items()))
    return worst


def numbers_by_body(robot: sr.Robot, spec: Any) -> dict[str, int]:
    """Return the numbers of MuJoCo's bodies by the names of bodies of Sarrus with the same frames."""
    links = [(robot.links[name], k) for name, k in numbers_of(spec).items() if name in robot.links]
    return {link.body.name: k for link, k in links if not link.place.r.any() and link.place.p[0] == 1}


def without_friction(forces: Iterable[sr.Force]) -> tuple[sr.Force, ...]:
    """Return forces without the dry friction of joints, which for a free body is a force of this name."""
    balls = (replace(one, friction=0) if isinstance(one, sr.SphericalSpring) else one for one in forces)
    return tuple(
        one
        for one in balls
        if not isinstance(one, FRICTION)
        and not (isinstance(one, sr.PointForce) and one.name.endswith("_friction"))
    )


def _bare(path: Path) -> str:
    """Return a URDF without shapes, and without fixed joints made one body, which would change names."""
    root = ElementTree.parse(path).getroot()
    for link in root.iter("link"):
        for tag in ("visual", "collision"):
            for shape in link.findall(tag):
                link.remove(shape)
    for extra in [*root.findall("mujoco"), *root.findall("gazebo")]:
        root.remove(extra)
    compiler = ElementTree.SubElement(root, "mujoco")
    settings = {"balanceinertia": "false", "boundmass": "0", "boundinertia": "0", "fusestatic": "true"}
    ElementTree.SubElement(compiler, "compiler", settings)
    return ElementTree.tostring(root, encoding="unicode")


class Worker:
    """A process that tries one file after another, and is replaced when it crashes or takes too long."""

    def __init__(self, *options: Any) -> None:
        self.options = options
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("fork")
        self.here, there = context.Pipe()
        self.process = context.Process(target=_work, args=(there, *self.options), daemon=True)
        self.process.start()
        there.close()

    def tried(self, path: Path, kind: str, seconds: float) -> dict[str, Any]:
        """Return what happens to one file."""
        end = time.monotonic() + seconds
        found: dict[str, Any] = {"file": str(path), "format": kind, "reason": "no answer"}
        try:
            self.here.send((path, kind))
            while self.here.poll(max(end - time.monotonic(), 0.0)):
                answer = self.here.recv()
                if answer is None:
                    return found
                found = answer
            found.setdefault("result", "time limit")
        except (EOFError, OSError):
            found |= {"result": "crashed", "reason": "no answer"}
        self.process.kill()
        self.process.join()
        self._start()
        return found


def _work(pipe: Any, *options: Any) -> None:
    warnings.simplefilter("ignore")
    while True:
        for found in tried(*pipe.recv(), *options):
            pipe.send(found)
        pipe.send(None)


def printed(rows: list[dict[str, Any]]) -> None:
    """Print the counts of each format."""
    for kind in sorted({row["format"] for row in rows}):
        some = [row for row in rows if row["format"] == kind]
        results = Counter(row["result"] for row in some)
        compared = [row for row in some if "difference" in row]
        agree = sum(row["difference"] < AGREE for row in compared)
        print(f"{kind}: {len(some)} files: {', '.join(f'{n} {word}' for word, n in results.most_common())}")
        if kind == "MJCF":
            print(f"  MuJoCo reads {len(some) - results['unreadable']}")
        print(f"  {len(compared)} compared with MuJoCo, {agree} agree to {AGREE:g}")
        for word in ("refused", "crashed", "stopped", "time limit", "unreadable"):
            reasons = Counter(row["reason"] for row in some if row["result"] == word)
            for text, n in reasons.most_common():
                first = next(row["file"] for row in some if row.get("reason") == text)
                print(f"  {n:4d} {word}: {text}\n         as {first}")
        for row in compared:
            if not row["difference"] < AGREE:
                print(f"       differs by {row['difference']:.1e}: {row['file']}")


def source_of(folder: Path) -> tuple[str, str, Path]:
    """Return the repository of a folder, its commit, and the folder of its top; without Git the folder's name."""

    def git(*words: str) -> str:
        done = subprocess.run(["git", "-C", str(folder), *words], capture_output=True, text=True, check=False)
        return done.stdout.strip()

    top = git("rev-parse", "--show-toplevel")
    if not top:
        return folder.resolve().name, "", folder.resolve()
    address = git("config", "--get", "remote.origin.url")
    name = "/".join(re.split(r"[/:]", address.removesuffix(".git"))[-2:]) if address else Path(top).name
    return name, git("rev-parse", "HEAD"), Path(top)


def write_hashes(rows: list[dict[str, Any]], folders: list[Path], table: Path) -> None:
    """Write a table of files by source and hash, with what happened to them."""
    sources = [source_of(folder if folder.is_dir() else folder.parent) for folder in folders]
    with table.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            ("repository", "commit", "file", "sha256", "format", "result", "reason", "difference")
        )
        for row in rows:
            path = Path(row["file"]).resolve()
            name, commit, top = next(one for one in sources if path.is_relative_to(one[2]))
            digest = hashlib.sha256(path.read_bytes()).hexdigest()
            difference = f"{row['difference']:.1e}" if "difference" in row else ""
            what = row["format"], row["result"], row.get("reason", row.get("not compared", "")), difference
            writer.writerow((name, commit, path.relative_to(top).as_posix(), digest, *what))


def main() -> int:
    """Try all files; exit code 1 if one crashed or differs."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--ignore", nargs="*", default=[], help="words of the option `ignore`")
    parser.add_argument("--until", type=float, default=0.01, help="[s] of the simulation")
    parser.add_argument("--limit", type=float, default=60.0, help="[s] of time for each file")
    parser.add_argument("--json", type=Path, help="file for the rows")
    parser.add_argument("--hashes", type=Path, help="file for the table of files by source and hash")
    chosen = parser.parse_args()
    rows, worker = [], Worker(chosen.ignore, chosen.until)
    for path, kind in files(chosen.folders):
        rows.append(worker.tried(path, kind, chosen.limit))
        print(f"\r{len(rows)} {path.name[:60]:60s}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    printed(rows)
    if chosen.json:
        chosen.json.write_text(json.dumps(rows, indent=1))
    if chosen.hashes:
        write_hashes(rows, chosen.folders, chosen.hashes)
    return int(any(row["result"] == "crashed" or not row.get("difference", 0.0) < AGREE for row in rows))


if __name__ == "__main__":
    sys.exit(main())
