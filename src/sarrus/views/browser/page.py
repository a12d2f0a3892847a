"""One self-contained web page: saved, opened in the browser, or shown in a notebook."""

from __future__ import annotations

import base64
import gzip
import html
import json
import sys
import tempfile
import webbrowser
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...model.coordinates import by_body, slice_of
from ...results.saving.exported_file import exporting
from ..looks import Part, Sketch, Span
from ..motion import Arrow, Frames

HEIGHT = 520  # [px] in a notebook


@dataclass(frozen=True)
class Page:
    """A web page as text. Notebooks show it; `open` shows it in the browser, `save` writes it."""

    title: str
    html: str = field(repr=False)

    def save(self, path: str | Path) -> Path:
        """Write the page to a file, and return its path."""
        with exporting(path) as draft:
            draft.write_text(self.html, encoding="utf-8")
        return Path(path)

    def open(self) -> Path:
        """Write the page to a temporary file, open it in the browser, and return its path."""
        stem = "".join(c if c.isalnum() else "-" for c in self.title)[:40]
        path = self.save(Path(tempfile.mkdtemp(prefix="sarrus-")) / f"{stem}.html")
        webbrowser.open(path.as_uri())
        return path

    def _repr_html_(self) -> str:
        style = f"width:100%;height:{HEIGHT}px;border:1px solid #d7dde3;border-radius:8px"
        page = html.escape(self.html, quote=True)
        return f'<iframe srcdoc="{page}" sandbox="allow-scripts allow-downloads" style="{style}"></iframe>'


def in_notebook() -> bool:
    """Whether this is a notebook, which shows the last value of a cell by itself."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel")


THREE = "187"
GHOSTS = ("#c2410c", "#1d7a46", "#6d28d9", "#a16207")  # of the second run and those after it
SPEEDS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
BRISK = 6.0  # [s] that a run shall take which is too quick to be seen
SHORT = 2.0  # [s] a run that is shorter is slowed down
FLAT = 0.02  # of the largest extent: a mechanism that is thinner is first seen from the front


class Curve(NamedTuple):
    """An output at the times of the frames."""

    name: str
    unit: str
    values: Array


class Influences(NamedTuple):
    """Changes of a response for 1 % more of each number, the largest first."""

    title: str
    names: Sequence[str]
    changes: Sequence[float]


class Scene(NamedTuple):
    """A run as it is shown: name, sketch, frames, arrows, traces as (body number, point in its axes), and curves.

    The camera follows the body with the number `follow`, none for 0.
    """

    name: str
    sketch: Sketch
    frames: Frames
    arrows: Sequence[Arrow] = ()
    traces: Sequence[tuple[int, Array]] = ()
    curves: Sequence[Curve] = ()
    follow: int = 0


class Numbers:
    """A block of numbers, and where in it each array is."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0
        self._known: dict[bytes, list[int]] = {}

    def add(self, values: Any, kind: Any = np.float32) -> list[int]:
        """Append an array, or find it if it is there; return its first byte and how many numbers it has."""
        data = np.ascontiguousarray(values, dtype=np.dtype(kind).newbyteorder("<")).tobytes()
        if data not in self._known:
            self._known[data] = [self._size, np.size(values)]
            self._parts.append(data + b"\0" * (-len(data) % 4))
            self._size += len(self._parts[-1])
        return self._known[data]

    def text(self) -> str:
        """All of it, compressed, in letters."""
        packed = gzip.compress(b"".join(self._parts), compresslevel=6, mtime=0)
        return base64.b64encode(packed).decode("ascii")


def write_page(
    scenes: Sequence[Scene],
    *,
    speed: float | None = None,
    names: bool = False,
    frames: bool = False,
    arrows: bool = True,
    play: bool = True,
    influences: Sequence[Influences] = (),
) -> Page:
    """Return runs of one or several models, drawn over each other, as a page.

    Parameters
    ----------
    scenes : the first in its own colours, the others in one colour each
    speed : at first, times that of life; by default 1, or slow enough to be seen
    names, frames, arrows : whether names of bodies, their frames, and arrows are on at first
    play : whether it plays when it is opened
    influences : of numbers on responses, drawn as bars
    """
    numbers = Numbers()
    first = scenes[0]
    sketches = list({id(scene.sketch): scene.sketch for scene in scenes}.values())
    description = {
        "title": title_of(scenes),
        "subtitle": _subtitle(scenes),
        "up": first.sketch.up,
        "size": max(sketch.size for sketch in sketches),
        "low": min(sketch.low for sketch in sketches),
        "floor": first.sketch.floor,
        "front": front(first),
        "follow": first.follow,
        "sketches": [_sketch(sketch, numbers) for sketch in sketches],
        "runs": [_run(run, n, sketches, numbers) for n, run in enumerate(scenes)],
        "names": names,
        "frames": frames,
        "arrows": arrows,
        "play": play,
        "influences": [influence._asdict() for influence in influences],
        **pace(scenes, speed),
    }
    return Page(first.sketch.name, _filled(title_of(scenes), description, numbers))


def title_of(scenes: Sequence[Scene]) -> str:
    """The name of a single run, such as that of a mode with its frequency; of several, that of their mechanism."""
    return scenes[0].name if len(scenes) == 1 else scenes[0].sketch.name


def _filled(title: str, description: dict[str, Any], numbers: Numbers) -> str:
    """The template with everything in its place; text that could end a script is written differently."""
    words = json.dumps(description, separators=(",", ":"), allow_nan=False, default=_plain).replace(
        "<", "\\u003c"
    )
    places = {
        "TITLE": html.escape(title),
        "STYLE": _file("page.css"),
        "SCENE": words,
        "NUMBERS": numbers.text(),
        "THREE": THREE,
        "LIBRARY": _file("three.min.js"),
        "VIEWER": _file("viewer.js"),
    }
    page = _file("page.html").split("@")
    return "".join(places.get(piece, piece) if n % 2 else piece for n, piece in enumerate(page))


def _file(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _subtitle(scenes: Sequence[Scene]) -> str:
    t = scenes[0].frames.t
    span = f"t = {t[0]:g} … {t[-1]:g} s, " if len(t) > 1 else ""
    count = len(scenes[0].sketch.bodies)
    missing = len(scenes[0].sketch.notes)
    notes = f", {missing} {'mesh' if missing == 1 else 'meshes'} not found" if missing else ""
    return f"{span}{count} {'body' if count == 1 else 'bodies'}{notes}"


def _plain(values: Array) -> Any:
    return np.asarray(values, dtype=float).round(9).tolist()


def front(run: Scene) -> str:
    """The axis along which the mechanism has no extent, to look along at first; "iso" if there is none."""
    if run.sketch.given:
        return "iso"
    q = by_body(run.frames.q[:, : slice_of(len(run.sketch.bodies)).start])
    places = [q[:, :, :3].reshape(-1, 3)]
    places += [part.mesh.vertices for part in run.sketch.parts if part.body == 0 and part.kind == "joint"]
    extent = np.ptp(np.concatenate(places), axis=0)
    thin = [
        n for n in range(3) if extent[n] <= FLAT * max(extent.max(), run.sketch.size) + 4 * run.sketch.unit
    ]
    level = abs(run.sketch.up)
    return "xyz"[thin[0]] if len(thin) == 1 and (level[thin[0]] < 0.5 or not run.sketch.weighs) else "iso"


def pace(scenes: Sequence[Scene], speed: float | None) -> dict[str, Any]:
    """Speeds to choose from, the one to begin with, and digits of the clock."""
    span = max(float(run.frames.t[-1] - run.frames.t[0]) for run in scenes) or 1.0
    if speed is None:
        speed = 1.0 if span >= SHORT else _round(span / BRISK)
    digits = max(2, 3 - int(np.floor(np.log10(span))))
    return {"speed": speed, "speeds": [speed * factor for factor in SPEEDS], "digits": digits}


def _round(value: float) -> float:
    """The nearest of 1, 2 and 5 with a power of ten that is not larger."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= value * (1 + 1e-12)))


def _sketch(sketch: Sketch, numbers: Numbers) -> dict[str, Any]:
    return {
        **{name: getattr(sketch, name) for name in ("unit", "bodies", "colors", "centers")},
        "moving": [frame.name for frame in sketch.moving],
        "parts": [_drawn(part, numbers) for part in sketch.parts],
        "spans": [_drawn(span, numbers) for span in sketch.spans],
    }


def _drawn(part: Part | Span, numbers: Numbers) -> dict[str, Any]:
    """A part or a span; its mesh is in the block of numbers."""
    wide = len(part.mesh.vertices) > 65535
    mesh = {
        "wide": wide,
        "v": numbers.add(part.mesh.vertices),
        "f": numbers.add(part.mesh.faces, np.uint32 if wide else np.uint16),
    }
    return {"body": 0, "opacity": 1.0} | {k: v for k, v in part._asdict().items() if k != "mesh"} | mesh


def _run(scene: Scene, n: int, sketches: list[Sketch], numbers: Numbers) -> dict[str, Any]:
    return {
        "name": scene.name,
        "sketch": next(k for k, sketch in enumerate(sketches) if sketch is scene.sketch),
        "color": GHOSTS[(n - 1) % len(GHOSTS)] if n else None,
        "start": float(scene.frames.t[0]),
        "step": scene.frames.step,
        "count": len(scene.frames.t),
        "q": numbers.add(scene.frames.q),
        "traces": [{"body": body, "point": point} for body, point in scene.traces],
        "arrows": [
            one._asdict() | {"points": numbers.add(one.points), "ways": numbers.add(one.ways)}
            for one in scene.arrows
        ],
        "curves": [one._asdict() | {"values": numbers.add(one.values)} for one in scene.curves],
    }
