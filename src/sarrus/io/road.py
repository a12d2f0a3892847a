"""Files of roads as grids of heights: tables in CSV, and OpenCRG by pyopencrg."""

from __future__ import annotations

import csv
import os
import re
from pathlib import Path
from typing import Any

import numpy as np

from ..algebra import Array
from ..model import ModelError, Surface
from ..model.errors import restated

ENDINGS = (".csv", ".crg")
HEADER = 1 << 20  # [bytes] of an OpenCRG file that are searched for its header


def load_road(
    path: str | os.PathLike[str], *, spacing: float | None = None, tolerance: float = 1e-3
) -> Surface:
    """Read a road from a table of heights, .csv, or from an OpenCRG file, .crg.

    The first row of a table has the coordinates y, behind one cell that is not read, and each further row x and the
    heights there, all in m. The columns are separated by commas or semicolons.

    An OpenCRG road whose reference line is parallel to the x axis is read as it is: the grid of the surface is that of
    the file, with its slope and its banking. Every other one is resampled on a grid in x and y around it. Beside and
    beyond the road, this grid has the heights of the nearest edge. Between its points, OpenCRG is bilinear, the surface
    a spline.

    Parameters
    ----------
    path : the file
    spacing : of a grid that is resampled [m], needed for a road that is not parallel to the x axis
    tolerance : of heights that are resampled, at the points of the file [m]

    Returns
    -------
    Surface

    Raises
    ------
    ModelError
        If the file cannot be read, contradicts itself, or has missing heights; if pyopencrg is not installed; if a road
        needs a spacing, or a smaller one for the tolerance, as one that crosses itself always does.
    """
    file = Path(path)
    if file.suffix.lower() not in ENDINGS:
        raise ModelError(f"{file} is no road file. Give one that ends with {' or '.join(ENDINGS)}.")
    if not file.is_file():
        raise ModelError(f"{file} does not exist. Give the path of a road file.")
    with restated(where=str(file)):
        return _table(file) if file.suffix.lower() == ".csv" else _opencrg(file, spacing, tolerance)


def _table(file: Path) -> Surface:
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ModelError("the file is not UTF-8 text. Save it as CSV in UTF-8.") from None
    delimiter = ";" if ";" in text else ","
    rows = [row for row in csv.reader(text.splitlines(), delimiter=delimiter) if any(map(str.strip, row))]
    if not rows:
        message = "the file is empty. Write y into the first row, and x and heights into each further one."
        raise ModelError(message)
    numbers = [_row(row, n, len(rows[0])) for n, row in enumerate(rows)]
    return Surface([row[0] for row in numbers[1:]], numbers[0][1:], [row[1:] for row in numbers[1:]])


def _row(row: list[str], n: int, width: int) -> list[float]:
    if len(row) != width:
        message = f"row {n + 1} has {len(row)} columns, but the first one {width}"
        raise ModelError(f"{message}. Give as many in each.")
    numbers = []
    for column, cell in enumerate(row):
        try:
            numbers.append(float(cell) if n or column else 0.0)
        except ValueError:
            message = f'column {column + 1} of row {n + 1} is no number: "{cell}"'
            raise ModelError(f"{message}. Give a height in m.") from None
    return numbers


def _opencrg(file: Path, spacing: float | None, tolerance: float) -> Surface:
    try:
        import pyopencrg
    except ImportError:
        message = "pyopencrg, which reads OpenCRG files, is not installed. Install it with: pip install 'sarrus[crg]'"
        raise ModelError(message) from None
    try:
        road: Any = pyopencrg.read(str(file))
    except (ValueError, OSError, pyopencrg.CrgCheckError) as error:
        message = f"pyopencrg cannot read the file: {str(error).strip().splitlines()[0].rstrip('.')}"
        raise ModelError(f"{message}. Correct it, or write it again.") from None
    _refuse_other_width(file, road)
    x, y = road.grid_xy()
    z = road.surface_z()
    missing = int(np.sum(~np.isfinite(z)))
    if missing:
        remedy = "Fill them, by fill_holes and fill_nan of pyopencrg.CrgRoad, and save the road"
        raise ModelError(f"{missing} of its {z.size} heights are missing. {remedy}.")
    if np.ptp(road.y) == 0 and road.x[-1] > road.x[0]:
        return Surface(road.x, road.y[0] + road.v, z)
    return _resampled(road, (x, y, z), spacing, tolerance)


def _refuse_other_width(file: Path, road: Any) -> None:
    """Refuse edges that the header declares farther than half a spacing from the outer long sections."""
    with file.open("rb") as stream:
        header = stream.read(HEADER).decode("latin-1")
    for side, place in (("right", road.v[0]), ("left", road.v[-1])):
        declared = re.search(rf"(?mi)^\s*long_section_v_{side}\s*=\s*([-+.\deE]+)", header)
        if declared and abs(float(declared[1]) - place) > np.diff(road.v).min() / 2:
            edge = f"the header declares the {side} edge at {float(declared[1]):g} m"
            message = f"{edge}, but the sections end at {place:g} m"
            raise ModelError(f"{message}. Correct the header or the sections.")


def _resampled(
    road: Any, known: tuple[Array, Array, Array], spacing: float | None, tolerance: float
) -> Surface:
    """The surface on a grid in x and y that encloses the road, checked at the points of the file."""
    x, y, z = known
    if spacing is None or not spacing > 0:
        message = "the road is not parallel to the x axis, so that its heights must be resampled"
        example = f"spacing={max(road.u_inc, np.diff(road.v).min()):g}"
        raise ModelError(f"{message}. Give spacing in m, such as {example}.")
    in_x, in_y = (np.arange(at.min() - spacing, at.max() + 2 * spacing, spacing) for at in (x, y))
    u, v = road.xy_to_uv(in_x[:, None], in_y[None, :])
    u, v = np.clip(u, road.u_start, road.u_end), np.clip(v, road.v_min, road.v_max)
    surface = Surface(in_x, in_y, road.uv_to_z(u, v))
    error = float(np.max(np.abs(surface.height(x, y) - z)))
    if error > tolerance:
        message = f"resampled every {spacing:g} m, its heights have errors up to {error:.2g} m"
        raise ModelError(f"{message}. Give a smaller spacing, or a tolerance greater than {tolerance:g} m.")
    return surface
