"""Pictures and films drawn without a browser, and files for other programs."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.transforms import Bbox
from PIL import Image
from tests.analyses.driven import turned
from tests.views.page_parts import read

import sarrus as sr
from sarrus import mechanisms
from sarrus.views import mechanism_figure
from sarrus.views.film import SIZE, _ffmpeg, _Studio, write_film
from sarrus.views.raster import Canvas, camera
from sarrus.views.shows import _scene as scene_of

PANDA = Path(__file__).parents[1] / "io" / "data" / "panda.urdf"
WHITE, RED, BLUE = np.ones(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0])


@cache
def run() -> sr.Trajectory:
    return sr.kinematics(turned(3.0, 0.5), np.linspace(0.0, 1.0, 21))


def triangle(depth: float, *corners: tuple[float, float]) -> np.ndarray:
    return np.array([[(*corner, depth) for corner in corners]])


def test_nearer_triangles_hide_farther_ones() -> None:
    canvas = Canvas(10, 10, WHITE)
    canvas.draw(triangle(2.0, (0, 0), (10, 0), (0, 10)), BLUE[None])
    canvas.draw(triangle(1.0, (0, 0), (4, 0), (0, 4)), RED[None])
    canvas.draw(triangle(3.0, (0, 0), (10, 0), (0, 10)), np.zeros((1, 3)))
    assert np.array_equal(canvas.pixels[1, 1], RED)
    assert np.array_equal(canvas.pixels[5, 3], BLUE)
    assert np.array_equal(canvas.pixels[9, 9], WHITE)


def test_as_many_pixels_as_a_triangle_has_area() -> None:
    canvas = Canvas(400, 300, WHITE)
    canvas.draw(triangle(1.0, (20.3, 10.7), (380.2, 150.1), (90.9, 280.4)), RED[None])
    a, b = np.array([359.9, 139.4]), np.array([70.6, 269.7])
    assert np.isfinite(canvas.depth).sum() == pytest.approx(abs(a[0] * b[1] - a[1] * b[0]) / 2, rel=2e-3)


def test_depth_is_that_of_the_plane() -> None:
    canvas = Canvas(20, 20, WHITE)
    canvas.draw(np.array([[(0, 0, 1.0), (20, 0, 3.0), (0, 20, 2.0)]]), RED[None])
    assert canvas.depth[4, 6] == pytest.approx(1 + 2 * 6.5 / 20 + 4.5 / 20)


def test_glass_mixes_colours() -> None:
    canvas = Canvas(4, 4, WHITE)
    canvas.blend(triangle(1.0, (-9, -9), (30, -9), (-9, 30)), RED[None], 0.25)
    assert canvas.pixels[2, 2] == pytest.approx([1.0, 0.75, 0.75])


@pytest.mark.parametrize("view", ["iso", "x", "y", "z"])
def test_a_camera_sees_all_points(view: str) -> None:
    points = np.random.default_rng(1).normal(size=(50, 3)) * [3.0, 1.0, 0.2]
    seen = camera(points, np.array([0, 0, 1.0]), view, 640, 400).seen(points)
    assert (seen[:, :2] >= 0).all()
    assert (seen[:, 0] <= 640).all()
    assert (seen[:, 1] <= 400).all()
    assert max(np.ptp(seen[:, 0]) / 640, np.ptp(seen[:, 1]) / 400) > 0.4


def test_up_is_up() -> None:
    points = np.array([[0.0, 0, 0], [0, 1.0, 0]])
    low, high = camera(points, np.array([0, 1.0, 0]), "z", 640, 400).seen(points)
    assert high[1] < low[1]


def test_a_picture_shows_the_bodies(tmp_path: Path) -> None:
    sr.load(mechanisms.path("slider_crank")).view(tmp_path / "crank.png")
    pixels = np.asarray(Image.open(tmp_path / "crank.png").convert("RGB"), dtype=float)
    assert pixels.shape == (750, 1200, 3)
    red, green, blue = (pixels[:, :, n] for n in range(3))
    assert ((red > green + 40) & (green > blue + 20)).sum() > 3000  # the orange rod
    assert ((green > red + 30) & (green > blue + 20)).sum() > 3000  # the green slider


def test_a_film_moves(tmp_path: Path) -> None:
    with Image.open(run().animate(tmp_path / "motion.gif", speed=2.0, traces=["slider"])) as film:
        assert film.n_frames == 10
        first = np.asarray(film.convert("RGB"), dtype=float)
        film.seek(9)
        assert abs(np.asarray(film.convert("RGB"), dtype=float) - first).max() > 50


def test_an_mp4_film_moves(tmp_path: Path) -> None:
    """Written by ffmpeg, and read again by it: its frames, and what changes."""
    file = run().animate(tmp_path / "motion.mp4", speed=2.0)
    told = [str(_ffmpeg()), "-loglevel", "error", "-i", str(file), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(told, capture_output=True, check=True).stdout
    images = np.frombuffer(raw, dtype=np.uint8).astype(int).reshape(-1, 450, 720, 3)
    assert len(images) == 15
    assert abs(images[-1] - images[0]).max() > 50


def test_mp4_without_ffmpeg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(OSError, match="needs ffmpeg"):
        write_film([], tmp_path / "motion.mp4", None)


class Glb:
    """The parts of a GLB file."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        magic, version, size = struct.unpack("<4sII", data[:12])
        assert (magic, version, size) == (b"glTF", 2, len(data))
        length, kind = struct.unpack("<I4s", data[12:20])
        self.told: Any = json.loads(data[20 : 20 + length])
        self.body = data[28 + length :]
        assert kind == b"JSON"
        assert struct.unpack("<I4s", data[20 + length : 28 + length]) == (len(self.body), b"BIN\0")

    def array(self, accessor: int) -> Any:
        a = self.told["accessors"][accessor]
        view = self.told["bufferViews"][a["bufferView"]]
        kind = {5126: "<f4", 5125: "<u4"}[a["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[a["type"]]
        return np.frombuffer(self.body, kind, a["count"] * width, view["byteOffset"]).reshape(-1, width)


def test_glb_is_whole_and_moves(tmp_path: Path) -> None:
    glb = Glb(run().animate(tmp_path / "motion.glb", count=21))
    for mesh in glb.told["meshes"]:
        (primitive,) = mesh["primitives"]
        positions = glb.array(primitive["attributes"]["POSITION"])
        assert glb.array(primitive["indices"]).max() < len(positions)
        assert np.linalg.norm(glb.array(primitive["attributes"]["NORMAL"]), axis=1) == pytest.approx(
            1.0, abs=1e-5
        )
    names = [node["name"] for node in glb.told["nodes"]]
    (animation,) = glb.told["animations"]
    channel = next(
        c
        for c in animation["channels"]
        if c["target"] == {"node": names.index("slider"), "path": "translation"}
    )
    sampler = animation["samplers"][channel["sampler"]]
    assert glb.array(sampler["input"])[:, 0] == pytest.approx(run().t, abs=1e-6)
    assert glb.array(sampler["output"]) == pytest.approx(run()["slider"].position, abs=1e-5)


def test_glb_turns_up_into_y(tmp_path: Path) -> None:
    glb = Glb(sr.load(mechanisms.path("slider_crank")).view(tmp_path / "crank.glb"))
    x, y, z, w = glb.told["nodes"][0]["rotation"]
    turned_z = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    assert turned_z == pytest.approx([0, 1, 0], abs=1e-7)
    assert "animations" not in glb.told


def test_names_in_a_crowded_drawing_do_not_lie_on_each_other() -> None:
    """As the renderer measures them, not as they were guessed."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = mechanism_figure(
        sr.load_urdf(PANDA, mimic="lock", inertia="given", lock=["panda_finger_joint1"])
    )
    FigureCanvasAgg(figure).draw()
    (ax,) = figure.axes
    boxes = [_shown(text, ax) for text in ax.texts]
    assert len(boxes) == 12
    pairs = [(a, b) for n, a in enumerate(boxes) for b in boxes[n + 1 :]]
    assert not [1 for a, b in pairs if a.overlaps(b)]


def _shown(text: Any, ax: Any) -> Any:
    """The box around the written line of a text in space, a little smaller than its letters."""
    from mpl_toolkits.mplot3d import proj3d

    x, y, _ = proj3d.proj_transform(*text.get_position_3d(), ax.get_proj())
    flat = ax.text2D(x, y, text.get_text(), fontsize=text.get_fontsize(), ha=text.get_ha(), va=text.get_va())
    flat.set_transform(text.get_transform())
    box = flat.get_window_extent()
    lines = text.get_text().split("\n")
    step = box.height / len(lines)
    first = next(n for n, line in enumerate(lines) if line.strip())
    flat.remove()
    return Bbox.from_extents(box.x0, box.y1 - (first + 0.9) * step, box.x1, box.y1 - (first + 0.1) * step)


def moving() -> sr.Trajectory:
    """A box that goes far away and rotates."""
    box = sr.Body.box("box", (1.0, 0.5, 0.3), mass=1.0, velocity=(20, 0, 3), angular_velocity=(0, 1, 0))
    return sr.simulate(sr.System(sr.Model("far", [box])), until=2.0)


def test_a_camera_follows_a_body(tmp_path: Path) -> None:
    run = moving()
    found = read(sr.animate(run, tmp_path / "far.html", follow="box")).told
    assert found["follow"] == 1
    assert read(sr.animate(run, tmp_path / "far.html")).told["follow"] == 0
    with pytest.raises(KeyError, match="bix"):
        sr.animate(run, follow="bix")
    with pytest.raises(ValueError, match="has no camera that follows a body"):
        sr.animate(run, tmp_path / "far.glb", follow="box")
    times = (0.0, 0.7, 2.0)
    studios = [
        _Studio([scene_of(run, "far", (), ([], False, False), 50)._replace(follow=n)], SIZE) for n in (0, 1)
    ]
    for studio, widths in zip(studios, ((0.0, 0.2), (0.3, 1.0)), strict=True):
        for t in times:
            colours = np.asarray(studio.image(t, clock=False)).astype(int)
            orange = np.argwhere(np.ptp(colours[40:], axis=2) > 60)
            wide = np.ptp(orange[:, 1]) / SIZE[0] if len(orange) else 0.0
            assert widths[0] <= wide <= widths[1]
            assert widths[0] == 0 or abs(orange[:, 1].mean() / SIZE[0] - 0.5) < 0.1
