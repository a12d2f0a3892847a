"""What is attacked: for each kind a case is made from a random generator, and run."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np

import sarrus as sr
from sarrus import mechanisms

from . import calls, oracle, seeds
from .mutate import mutated


class Case(NamedTuple):
    """The input of a case as bytes, and what runs it: it returns what is impossible about what was accepted."""

    content: bytes
    run: Callable[[Path], list[str]]


def _model(
    name: str, load: Callable[[Path], Any], corpus: list[bytes], kind: str
) -> Callable[[Random], Case]:
    def run(folder: Path, content: bytes) -> list[str]:
        (folder / name).write_bytes(content)
        model = load(folder / name)
        found = list(oracle.nonsense(model))
        system = sr.System(model)
        if not np.isfinite(system.b).all() or not np.isfinite(system.q0).all():
            found.append("the system's numbers are not finite")
        model.looks()
        return found

    def case(random: Random) -> Case:
        content = mutated(random.choice(corpus), kind, random)
        return Case(content, lambda folder: run(folder, content))

    return case


def _mesh(random: Random) -> Case:
    from sarrus.views.meshes import read_mesh

    name, content = random.choice([*seeds.meshes().items()])
    kind = {".gltf": "json", ".dae": "xml", ".glb": "binary"}.get(
        Path(name).suffix, "binary" if "binary" in name else "text"
    )
    content = mutated(content, kind, random)

    def run(folder: Path) -> list[str]:
        read_mesh.cache_clear()
        (folder / name).write_bytes(content)
        pieces = read_mesh(folder / name)
        wrong = [
            p
            for p in pieces
            if not np.isfinite(p.mesh.vertices).all() or p.mesh.faces.max(initial=-1) >= len(p.mesh.vertices)
        ]
        return ["a mesh with corners that do not exist"] if wrong else []

    return Case(content, run)


def _study(random: Random) -> Case:
    from sarrus.studies.file import read_study_file

    content = mutated(random.choice([seeds.STUDY, seeds.SPREAD, seeds.STATIC]).encode(), "yaml", random)

    def run(folder: Path) -> list[str]:
        asked = read_study_file(_beside(folder, content), sr.load)
        return [] if np.isfinite(asked.cases).all() else ["a case with a number that is not finite"]

    return Case(content, run)


def _optimization(random: Random) -> Case:
    from sarrus.studies.optimization import read_optimization_file

    content = mutated(random.choice([seeds.OPTIMIZATION, seeds.FIT]).encode(), "yaml", random)

    def run(folder: Path) -> list[str]:
        (folder / "data.csv").write_text("t,x\n0,1\n0.1,1.1\n")
        sought = read_optimization_file(_beside(folder, content), sr.load)
        bad = [limits for limits in sought.bounds.values() if np.isnan(limits).any()]
        return ["limits that are no numbers"] if bad else []

    return Case(content, run)


def _beside(folder: Path, content: bytes) -> Path:
    (folder / "crank.yaml").write_text(mechanisms.path("slider_crank").read_text())
    (folder / "file.yaml").write_bytes(content)
    return folder / "file.yaml"


def _api(random: Random) -> Case:
    name, arguments, run = calls.random_call(random)
    content = json.dumps(
        {"call": name, "arguments": {key: repr(value)[:200] for key, value in arguments.items()}}, indent=1
    )
    return Case(content.encode(), run)


TARGETS: dict[str, Callable[[Random], Case]] = {
    "yaml": _model("model.yaml", sr.load, seeds.models(), "yaml"),
    "json": _model("model.json", sr.load, seeds.json_models(), "json"),
    "urdf": _model("model.urdf", sr.load_urdf, seeds.urdfs(), "xml"),
    "mjcf": _model("model.xml", sr.load_mjcf, [seeds.MJCF.encode()], "xml"),
    "mesh": _mesh,
    "study": _study,
    "optimization": _optimization,
    "api": _api,
}
