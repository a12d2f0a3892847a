"""Pictures and films without a browser: PNG, GIF and MP4."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from errno import EIO
from pathlib import Path
from typing import Any

import numpy as np

from ..algebra import Array
from ..analyses.progress import monitor
from ..results.saving.exported_file import exporting
from .browser import Scene
from .browser.page import GHOSTS, front, pace, title_of
from .looks import Part, Span, body_frame, place_of
from .meshes.mesh import along, rgb, upright
from .motion import SAMPLES, interpolated
from .raster import Camera, Canvas, camera

SIZE = (720, 450)  # [pixels] of a film
LARGE = (1200, 750)  # [pixels] of a picture
FINER = 2  # each pixel is the mean of so many by so many
RATE = {".gif": 20, ".mp4": 30}  # frames per second
BACKGROUND, INK = np.array([0.933, 0.945, 0.957]), "#23282e"
LIGHT = np.array([0.35, 0.45, 0.82])  # in axes of the camera: right, up, back
AMBIENT, GHOST = 0.52, 0.38
MISSING = 'pictures and films need Pillow: pip install "sarrus[plot]"'
NO_FFMPEG = 'an .mp4 film needs ffmpeg: pip install "sarrus[film]", or write a .gif or .html'


def write_picture(scenes: Sequence[Scene], file: Path) -> Path:
    """Write the first frame of runs as PNG, and return the path."""
    studio = _Studio(scenes, LARGE)
    with exporting(file) as draft:
        studio.image(float(scenes[0].frames.t[0]), clock=False).save(draft)
    return file


def write_film(
    scenes: Sequence[Scene],
    file: Path,
    speed: float | None,
    *,
    progress: bool | Callable[[float], None] | None = None,
) -> Path:
    """Write runs as GIF or MP4, and return the path.

    Parameters
    ----------
    progress : True for a bar on standard error, a function of the number of pictures drawn, or False; by default a bar
        on a terminal and in a notebook

    Raises
    ------
    ImportError
        If Pillow is not installed.
    OSError
        If an MP4 is wanted and there is no ffmpeg.
    """
    ending = file.suffix.lower()
    ffmpeg = _ffmpeg() if ending == ".mp4" else ""
    studio = _Studio(scenes, SIZE)
    times = _times(scenes, speed, RATE[ending])
    bar = monitor(progress, len(times), done="drew", unit=" pictures")
    with exporting(file) as draft, bar as report:

        def images() -> Iterator[Any]:
            for number, t in enumerate(times, start=1):
                yield studio.image(t)
                report(number)

        if ffmpeg:
            _mp4(images(), ffmpeg, draft)
        else:
            _gif(images(), draft)
    return file


def _ffmpeg() -> str:
    """The program: that on the PATH, or the one that a Python package carries.

    Raises
    ------
    OSError
        If there is none.
    """
    if path := shutil.which("ffmpeg"):
        return path
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError:
        raise OSError(NO_FFMPEG) from None
    return str(get_ffmpeg_exe())


def _times(scenes: Sequence[Scene], speed: float | None, rate: int) -> Array:
    start, end = min(run.frames.t[0] for run in scenes), max(run.frames.t[-1] for run in scenes)
    lasts = (end - start) / pace(scenes, speed)["speed"]
    return np.linspace(start, end, max(2, round(lasts * rate)))


def _gif(images: Iterator[Any], file: Path) -> None:
    first = next(images).quantize(128)
    # the colours are those of the first one
    others = [image.quantize(palette=first, dither=0) for image in images]
    wait = 1000 // RATE[".gif"]
    first.save(file, save_all=True, append_images=others, duration=wait, loop=0, optimize=False)


def _mp4(images: Iterator[Any], ffmpeg: str, file: Path) -> None:
    raw = f"-y -loglevel error -f rawvideo -pix_fmt rgb24 -s {SIZE[0]}x{SIZE[1]} -r {RATE['.mp4']} -i -"
    command = [ffmpeg, *raw.split(), *["-an", "-pix_fmt", "yuv420p", "-movflags", "+faststart"], str(file)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE)
    with suppress(BrokenPipeError), process:
        assert process.stdin is not None  # the pipe breaks where ffmpeg cannot go on
        for image in images:
            process.stdin.write(image.tobytes())
        process.stdin.close()
    if process.returncode:
        raise OSError(EIO, f"ffmpeg ended with code {process.returncode}")


class _Studio:
    """Runs in front of a camera that is fixed, or follows a body of the first one."""

    def __init__(self, scenes: Sequence[Scene], size: tuple[int, int]) -> None:
        self.scenes, self.size = scenes, size
        places = np.concatenate([_places(run) for run in scenes])
        wide, high = size[0] * FINER, size[1] * FINER
        self._follow, self._near = scenes[0].follow, places
        if self._follow:
            at = scenes[0].frames
            self._near = _places(scenes[0]._replace(frames=at._replace(q=at.q[:1])))
        self.camera: Camera = camera(self._near, scenes[0].sketch.up, front(scenes[0]), wide, high)
        self._first = self.camera
        self.up, self.places = scenes[0].sketch.up, places
        self._empty = Canvas(wide, high, BACKGROUND)
        if not self._follow:
            self._ground(self._empty, places)

    def image(self, t: float, *, clock: bool = True) -> Any:
        """The picture at a time, as an image of Pillow."""
        try:
            from PIL import Image, ImageDraw, ImageFont
        except ImportError:
            raise ImportError(MISSING) from None
        canvas = self._empty.copy()
        if self._follow:
            start, now = (
                body_frame(q, self._follow)[0]
                for q in (self.scenes[0].frames.q[0], _state(self.scenes[0], t))
            )
            self.camera = self._first._replace(place=self._first.place + now - start)
            self._ground(canvas, self._near + now - start)
        for number, run in enumerate(self.scenes):
            self._run(canvas, run, t, None if number == 0 else GHOSTS[(number - 1) % len(GHOSTS)])
        image = Image.fromarray(canvas.bytes()).reduce(FINER)
        pen = ImageDraw.Draw(image)
        for run in self.scenes:
            self._traces(pen, run, t)
        pen.text((14, 10), title_of(self.scenes), fill=INK, font=ImageFont.load_default(17))
        if clock:
            pen.text((14, self.size[1] - 26), f"t = {t:.2f} s", fill=INK, font=ImageFont.load_default(15))
        return image

    def _run(self, canvas: Canvas, run: Scene, t: float, ghost: str | None) -> None:
        q = _state(run, t)
        solid = [(mesh, part) for mesh, part in _moved(run, q) if _opacity(part, ghost) == 1]
        glass = [(mesh, part) for mesh, part in _moved(run, q) if _opacity(part, ghost) < 1]
        if solid:
            drawn = [self._lit(mesh, rgb(part.color), part.mesh.faces, both=False) for mesh, part in solid]
            canvas.draw(*(np.concatenate(column) for column in zip(*drawn, strict=True)))
        for mesh, part in glass:
            if not (ghost and part.kind == "ground"):
                lit = self._lit(mesh, rgb(ghost or part.color), part.mesh.faces, both=True)
                canvas.blend(*lit, _opacity(part, ghost))

    def _lit(self, vertices: Array, color: Array, faces: Array, *, both: bool) -> tuple[Array, Array]:
        """Triangles that are seen, in pixels, with their colours."""
        corners = vertices[faces]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        size = np.linalg.norm(across, axis=1, keepdims=True)
        h = across / np.where(size > 0, size, 1.0)
        towards = np.einsum("ij,ij->i", h, self.camera.place - corners[:, 0])
        seen = (size[:, 0] > 0) & ((towards > 0) | both)
        h = np.where(towards[:, None] > 0, h, -h)[seen] @ self.camera.axes
        light = AMBIENT + (1 - AMBIENT) * np.maximum(h @ (LIGHT / np.linalg.norm(LIGHT)), 0.0)
        return self.camera.seen(corners[seen]), np.clip(light[:, None] * color * 1.08, 0, 1)

    def _ground(self, canvas: Canvas, places: Array) -> None:
        """Lines of a grid below, as thin triangles."""
        sketch = self.scenes[0].sketch
        level = float((self.places @ self.up).min()) if sketch.floor is None else sketch.floor
        corners = _grid(places, self.up, level - 1e-3 * sketch.size, 1e-3 * sketch.size)
        ahead = np.all((corners - self.camera.place) @ self.camera.axes[:, 2] < -1e-3 * sketch.size, axis=1)
        canvas.draw(self.camera.seen(corners[ahead]), np.tile([0.83, 0.85, 0.87], (int(ahead.sum()), 1)))

    def _traces(self, pen: Any, run: Scene, t: float) -> None:
        for body, point in run.traces:
            path = place_of(run.frames.q, body, point)
            seen = self.camera.seen(path)[:, :2] / FINER
            past = seen[run.frames.t <= t]
            if len(past) > 1:
                pen.line([tuple(p) for p in past.tolist()], fill=run.sketch.colors[body - 1], width=2)


def _opacity(part: Part | Span, ghost: str | None) -> float:
    return (part.opacity if isinstance(part, Part) else 1.0) * (GHOST if ghost else 1.0)


def _state(scene: Scene, t: float) -> Array:
    return np.asarray(interpolated(scene.frames.t, scene.frames.q, np.array([t]))[0])


def _moved(scene: Scene, q: Array) -> Iterator[tuple[Array, Part | Span]]:
    """Yield the vertices of every part in space."""
    for part in scene.sketch.parts:
        yield part.mesh.moved(*body_frame(q, part.body)).vertices, part
    for span in scene.sketch.spans:
        ends = (place_of(q, body, point) for body, point in zip(span.bodies, span.points, strict=True))
        place, way, (stretch,) = span.placed(*ends)
        yield span.mesh.stretched((1, 1, stretch)).moved(place, along(way)).vertices, span


def _places(scene: Scene) -> Array:
    """Corners of the boxes around each part over the motion (n, 3)."""
    few = scene.frames.q[:: max(1, len(scene.frames.q) // SAMPLES)]
    shapes = (vertices for q in few for vertices, _ in _moved(scene, q))
    return np.array([corner for x in shapes for corner in (x.min(axis=0), x.max(axis=0))])


def _grid(places: Array, up: Array, level: float, half: float) -> Array:
    """Triangles (n, 3, 3) of the lines of a square grid at a height around places."""
    side, ahead, _ = upright(up).T
    reach = 1.2 * float(np.linalg.norm(np.ptp(places, axis=0)))
    step = 10.0 ** np.floor(np.log10(reach / 3))
    center = places.mean(axis=0)
    middle = [round(float(center @ axis) / step) * step for axis in (side, ahead)]
    lines = np.arange(-np.ceil(reach / step), np.ceil(reach / step) + 1) * step
    triangles = []
    for n, (along_it, across) in enumerate(((side, ahead), (ahead, side))):
        base = level * up + middle[n] * along_it + middle[1 - n] * across
        for x in lines:
            for low in lines[:-1]:  # in pieces, so that none begins behind the camera
                a, b = base + x * across + low * along_it, base + x * across + (low + step) * along_it
                w = half * across
                triangles += [[a - w, b - w, b + w], [a - w, b + w, a + w]]
    return np.array(triangles)
