"""Roads in files: tables, and OpenCRG roads that are straight, turned and curved."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr

TABLE = "x \\ y,-1,0,2\n0,0,0.01,0\n1,0,0.02,0\n2.5,0.1,0,0\n"


@pytest.mark.parametrize(
    "change", [lambda text: text, lambda text: "\ufeff" + text.replace(",", "; ") + "\n"]
)
def test_table(tmp_path: Path, change: Any) -> None:
    (tmp_path / "road.csv").write_text(change(TABLE), encoding="utf-8")
    expected = sr.Surface([0, 1, 2.5], [-1, 0, 2], [[0, 0.01, 0], [0, 0.02, 0], [0.1, 0, 0]])
    assert sr.load_road(tmp_path / "road.csv") == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        ("y,0,1\n0,1\n", "row 2 has 2 columns, but the first one 3"),
        ("y,0,1\n0,1,high\n", 'column 3 of row 2 is no number: "high". Give a height in m'),
        ("y,0,1\n0,1,2\n", "x must have at least two numbers, but has 1"),
        ("y,0,1\n0,1,2\n1,2,nan\n", "z has a number that is not finite"),
    ],
)
def test_what_is_no_table(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "road.csv").write_text(text)
    with pytest.raises(sr.ModelError, match=message) as caught:
        sr.load_road(tmp_path / "road.csv")
    assert "road.csv" in str(caught.value)


def test_what_is_no_text(tmp_path: Path) -> None:
    (tmp_path / "road.csv").write_text(TABLE, encoding="utf-16")
    with pytest.raises(sr.ModelError, match="the file is not UTF-8 text"):
        sr.load_road(tmp_path / "road.csv")


@pytest.mark.parametrize(
    ("name", "message"),
    [("road.txt", "is no road file. Give one that ends with .csv or .crg"), ("r.crg", "does not exist")],
)
def test_what_is_no_file(name: str, message: str) -> None:
    with pytest.raises(sr.ModelError, match=message):
        sr.load_road(name)


def opencrg(folder: Path, phi: float, text: str = "") -> Path:
    """A road of 2 m with points every 0.5 m and a slope of 4 %, written by hand in the text form of OpenCRG."""
    head = [
        "$CT", "a road for a test", "$", "$ROAD_CRG",
        "reference_line_start_u = 0.0", "reference_line_end_u = 2.0", "reference_line_increment = 0.5",
        "reference_line_start_x = 10.0", "reference_line_start_y = 3.0", f"reference_line_start_phi = {phi}",
        "reference_line_start_s = 0.04", "long_section_v_right = -1.0", "long_section_v_left = 1.0",
        "long_section_v_increment = 1.0", "$", "$KD_Definition", "#:LRFI",
        "D:long section at v = -1.000,m", "D:long section at v = 0.000,m", "D:long section at v = 1.000,m",
        "$", "$" * 80,
    ]  # fmt: skip
    rows = [f"{a:10.5f}{b:10.5f}{c:10.5f}" for a, b, c in HEIGHTS]
    file = folder / "road.crg"
    file.write_text(text or "\n".join([*head, *rows]) + "\n")
    return file


HEIGHTS = np.round(np.random.default_rng(5).uniform(-0.02, 0.02, (5, 3)), 5)


def test_straight_road(tmp_path: Path) -> None:
    """At the points of the file the heights are those of pyopencrg, and of the file with its slope."""
    crg = pytest.importorskip("pyopencrg")
    file = opencrg(tmp_path, 0.0)
    surface, road = sr.load_road(file), crg.read(str(file))
    assert surface.x == pytest.approx(10 + np.arange(5) / 2)
    assert surface.y == pytest.approx([2.0, 3.0, 4.0])
    assert surface.z == pytest.approx(HEIGHTS + 0.04 * np.arange(5)[:, None] / 2, abs=1e-12)
    x, y = np.meshgrid(surface.x, surface.y, indexing="ij")
    assert surface.height(x, y) == pytest.approx(road.xy_to_z(x, y), abs=1e-12)


def numbered(text: str) -> str:
    """The text of a road with numbers of long sections in place of positions, whose edges the header has alone."""
    for n, place in enumerate(("-1.000", "0.000", "1.000"), 1):
        text = text.replace(f"D:long section at v = {place}", f"D:long section {n}")
    return text


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ("v_left = 1.0", "v_left = 5.0"),
            "declares the left edge at 5 m, but the sections end at 1 m. Correct",
        ),
        (("v_increment = 1.0", "v_increment = 0.1"), "the left edge at 1 m, but the sections end at -0.8 m"),
    ],
)
def test_a_declared_width_that_contradicts_the_sections(
    tmp_path: Path, change: tuple[str, str], message: str
) -> None:
    pytest.importorskip("pyopencrg")
    text = numbered(opencrg(tmp_path, 0.0).read_text())
    assert sr.load_road(opencrg(tmp_path, 0.0, text)).y == pytest.approx([2.0, 3.0, 4.0])
    with pytest.raises(sr.ModelError, match=re.escape(message)):
        sr.load_road(opencrg(tmp_path, 0.0, text.replace(*change)))


def test_turned_road(tmp_path: Path) -> None:
    """A road at an angle is resampled on a grid in x and y."""
    crg = pytest.importorskip("pyopencrg")
    file = opencrg(tmp_path, 0.5)
    with pytest.raises(
        sr.ModelError, match=r"not parallel to the x axis, .* Give spacing in m, such as spacing=1"
    ):
        sr.load_road(file)
    with pytest.raises(
        sr.ModelError, match=r"resampled every 0.5 m, its heights have errors up to .* Give a smaller"
    ):
        sr.load_road(file, spacing=0.5)
    surface, road = sr.load_road(file, spacing=0.01), crg.read(str(file))
    x, y = road.grid_xy()
    assert x[0] == pytest.approx([10 + np.sin(0.5), 10, 10 - np.sin(0.5)])
    assert surface.height(x, y) == pytest.approx(HEIGHTS + 0.04 * np.arange(5)[:, None] / 2, abs=1e-3)


def test_curved_road(tmp_path: Path) -> None:
    """A quarter of a circle of 20 m with waves, against their formula, and pyopencrg between the points."""
    crg = pytest.importorskip("pyopencrg")
    step, v = 0.1, np.linspace(-1.5, 1.5, 31)
    u = np.arange(315) * step
    z = 0.02 * np.sin(u[:, None]) * np.cos(v)
    turning = crg.CrgRoad(z, u_inc=step, v=v, heading=np.arange(314) * step / 20)
    turning.save(str(tmp_path / "circle.crg"), fmt="LDFI")
    surface = sr.load_road(tmp_path / "circle.crg", spacing=0.1)
    at, beside = np.random.default_rng(2).uniform([1, -1.4], [30, 1.4], (300, 2)).T
    x, y = crg.read(str(tmp_path / "circle.crg")).uv_to_xy(at, beside)
    assert surface.height(x, y) == pytest.approx(0.02 * np.sin(at) * np.cos(beside), abs=2e-4)


def test_missing_heights_and_wrong_files(tmp_path: Path) -> None:
    crg = pytest.importorskip("pyopencrg")
    z = np.zeros((5, 3))
    z[2, 1] = np.nan
    crg.CrgRoad(z, u_inc=0.5, v=[-1, 0, 1]).save(str(tmp_path / "hole.crg"), fmt="LDFI")
    with (
        pytest.warns(crg.CrgCheckWarning, match="NaN values"),
        pytest.raises(sr.ModelError, match=r"1 of its 15 heights are missing. Fill them, by fill_holes"),
    ):
        sr.load_road(tmp_path / "hole.crg")
    with pytest.raises(sr.ModelError, match=r"pyopencrg cannot read the file: .*. Correct it"):
        sr.load_road(opencrg(tmp_path, 0.0, "no road"))


def test_without_pyopencrg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyopencrg", None)
    with pytest.raises(sr.ModelError, match=r"not installed. Install it with: pip install 'sarrus\[crg\]'"):
        sr.load_road(opencrg(tmp_path, 0.0))
