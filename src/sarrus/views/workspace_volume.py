"""Workspaces of three outputs: the surface and some of its slices."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..algebra import Array
from ..model import SarrusError
from ..outputs.output import labelled
from ..results.maps.workspace_volume import Slice, WorkspaceVolume
from .browser import Page
from .figures.style import BLUE, ORANGE, new_figure
from .looks import Part
from .looks.part import LOOK
from .meshes.mesh import Mesh
from .shows import put, still

SHOWN = 9  # slices drawn as lines
BARRIER = "barrier inside"


def plot_workspace_volume(found: WorkspaceVolume, ax: Any = None) -> Any:
    """Draw the surface through the slices, and the barriers inside.

    Parameters
    ----------
    found : WorkspaceVolume
    ax : Matplotlib 3-D axes to draw into; by default a new figure's

    Returns
    -------
    Axes3D

    Raises
    ------
    ImportError
        If Matplotlib is not installed.
    """
    ax = new_figure(7.5, 6.5).add_subplot(projection="3d") if ax is None else ax
    if len(found.triangles):
        x, y, z = found.vertices.T
        style = {"color": BLUE, "alpha": 0.35, "linewidth": 0.0, "shade": True}
        ax.plot_trisurf(x, y, found.triangles, z, **style)
    for one in found.slices[:: max(1, len(found.slices) // SHOWN)]:
        for loop in one.loops:
            ax.plot(*loop.points.T, np.full(len(loop.points), one.height), color=BLUE, linewidth=0.8)
        for line in one.barriers:
            ax.plot(*line.T, np.full(len(line), one.height), color=ORANGE, linewidth=1.2, label=BARRIER)
    handles = dict(zip(*ax.get_legend_handles_labels()[::-1], strict=True))
    if handles:
        ax.legend(handles.values(), handles, frameon=False, fontsize=8, loc="upper right")
    labels = [labelled(*pair) for pair in zip(found.outputs, found.units, strict=True)]
    ax.set(**dict(zip(("xlabel", "ylabel", "zlabel"), labels, strict=True)))
    if len(set(found.units)) == 1:
        ax.set_aspect("equal")
    size = f"{found.volume:.5g} {found.unit} (± {found.volume_error:.1g})"
    ax.set_title(f"{found.name}: {size} can be reached", fontsize=10)
    return ax


# Of the size: lines of neighbouring slices that are farther from each other are of different sheets
FAR = 0.12


def barrier_sheets(slices: Sequence[Slice]) -> tuple[Array, Array]:
    """Vertices (nv, 3) and triangles (nt, 3) through the barriers of slices by rising height.

    Every line is widened half way to the nearest places of the lines above and below it; where there are none, it ends.
    Sheets are seen from both sides: each has a front and a back, with vertices of their own.
    """
    vertices, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=int)], 0
    for strip in _strips(slices):
        vertices.append(strip.reshape(-1, 3))
        triangles.append(_between(strip.shape[1]) + count)
        count += 2 * strip.shape[1]
    front, faces = np.concatenate(vertices), np.concatenate(triangles)
    return np.concatenate([front, front]), np.concatenate([faces, faces[:, ::-1] + count])


def _strips(slices: Sequence[Slice]) -> Iterator[Array]:
    """Pairs of lines (2, k, 3): a barrier, and where it goes half way to a neighbour."""
    for one, other in pairwise(slices):
        for this, that in ((one, other), (other, one)):
            if that.barriers:
                there = _lifted(np.concatenate(that.barriers), that.height)
                for line in this.barriers:
                    yield from _towards(_lifted(line, this.height), there, _size(slices))


def _towards(line: Array, there: Array, size: float) -> Iterator[Array]:
    """The parts of a line that have neighbours, with the middles between."""
    gaps = np.linalg.norm(line[:, None] - there[None], axis=2)
    nearest = gaps.argmin(axis=1)
    close = gaps[np.arange(len(line)), nearest] < FAR * size
    middle = 0.5 * (line + there[nearest])
    for part in np.split(np.arange(len(line)), np.flatnonzero(np.diff(close)) + 1):
        if close[part[0]] and len(part) > 1:
            yield np.stack([line[part], middle[part]])


def _lifted(line: Array, height: float) -> Array:
    return np.column_stack([line, np.full(len(line), height)])


def _size(slices: Sequence[Slice]) -> float:
    """Return the size of the widest slice, or of the range of heights."""
    widths = [float(np.ptp(loop.points, axis=0).max()) for one in slices for loop in one.loops]
    return max([slices[-1].height - slices[0].height, *widths])


def _between(count: int) -> Array:
    """Triangles between two lines of so many points."""
    k = np.arange(count - 1)
    low, high = np.column_stack([k, k + 1, k + count]), np.column_stack([k + 1, k + 1 + count, k + count])
    return np.concatenate([low, high])


COLORS = ("#3b76b5", "#d9822b", "#4b9b5f", "#8a4fa3", "#c23b4e", "#2b9aa8", "#a1783a", "#6b7683")
INSIDE = "#e8590c"  # of barriers


def view_workspace(
    found: WorkspaceVolume,
    file: str | Path | None = None,
    *,
    opacity: float = LOOK.glass,
    q: Array | None = None,
) -> Page | Path:
    """Show the surface of a workspace in three dimensions, with the mechanism in it.

    Every part of the surface has the colour of its cause, a limit or a singularity, which is text where the pointer is.
    Barriers inside, which motion can meet from one side only, are sheets that are not seen through.

    Parameters
    ----------
    found : WorkspaceVolume
        Its outputs are the coordinates of a point.
    file : ``.html`` for a page that works without a network, ``.glb`` for other programs, ``.png`` for a picture; left
        out, a notebook shows the page, and elsewhere it is opened in the browser
    opacity : of the surface, 0 ... 1
    q : (nq,) position of the mechanism; by default the model's own

    Raises
    ------
    SarrusError
        If the outputs are not three coordinates, or there is no surface.
    """
    assert found.model is not None
    shown = still(found.model, q)
    parts = tuple(surface_parts(found, opacity))
    lowest = min(float((part.mesh.vertices @ shown.sketch.up).min()) for part in parts)
    size = max(shown.sketch.size, float(np.ptp(found.vertices, axis=0).max()))
    drawn = replace(
        shown.sketch,
        name=f"{found.name}: {found.volume:.5g} {found.unit} can be reached",
        parts=(*shown.sketch.parts, *parts),
        low=min(shown.sketch.low, lowest),
        size=size,
        given=True,
    )
    return put(shown._replace(sketch=drawn), file)


def surface_parts(found: WorkspaceVolume, opacity: float) -> list[Part]:
    """A mesh for each cause, and one for the barriers inside."""
    axes = ["xyz".find(name[-1]) for name in found.outputs]
    if not len(found.triangles):
        raise SarrusError(f"{found.name}: there is no surface to draw. {found.message}")
    if sorted(axes) != [0, 1, 2]:
        text = f"the outputs {', '.join(found.outputs)} are no coordinates x, y and z"
        raise SarrusError(f"{found.name}: {text}. Draw its slices with plot instead.")
    parts = []
    for n, cause in enumerate(found.causes):
        mine = found.triangles[found.cause_of == n]
        if len(mine):
            color = COLORS[(n - 1) % len(COLORS)] if n else "#9aa3ad"
            mesh = _mesh(found.vertices, mine, axes)
            parts.append(Part(cause, "body", "ends the workspace", 0, mesh, color, opacity))
    vertices, triangles = barrier_sheets(found.slices)
    if len(triangles):
        text = "inside: motion can meet it from one side only"
        mesh = _mesh(vertices, triangles, axes)
        parts.append(Part("barrier", "body", text, 0, mesh, INSIDE))
    return parts


def _mesh(vertices: Array, triangles: Array, axes: list[int]) -> Mesh:
    """Return the mesh of the used vertices, with the outputs as coordinates x, y and z."""
    used, faces = np.unique(triangles, return_inverse=True)
    placed = np.empty((len(used), 3))
    placed[:, axes] = vertices[used]
    faces = faces.reshape(-1, 3)
    return Mesh(placed, faces[:, ::-1] if np.linalg.det(np.eye(3)[axes]) < 0 else faces)
