"""Workspaces of three outputs as a page: the surface, seen through, coloured by what makes it, and the mechanism."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..algebra import Array
from ..model import SarrusError
from ..results.maps.workspace_volume import WorkspaceVolume
from .browser import Page
from .looks import Part
from .shapes import Mesh
from .shows import put, still
from .workspace_sheets import barrier_sheets

COLORS = ("#3b76b5", "#d9822b", "#4b9b5f", "#8a4fa3", "#c23b4e", "#2b9aa8", "#a1783a", "#6b7683")
INSIDE = "#e8590c"  # of barriers
SEEN_THROUGH = 0.3


def view_workspace(
    found: WorkspaceVolume,
    file: str | Path | None = None,
    *,
    opacity: float = SEEN_THROUGH,
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
    shown = still(found.model, q)
    parts = tuple(surface_parts(found, opacity))
    lowest = min(float((part.mesh.vertices @ shown.sketch.up).min()) for part in parts)
    size = max(shown.sketch.size, float(np.ptp(found.vertices, axis=0).max()))
    drawn = replace(
        shown.sketch,
        name=f"{found.name}: {found.volume:.5g} can be reached",
        parts=(*shown.sketch.parts, *parts),
        low=min(shown.sketch.low, lowest),
        size=size,
        given=True,
    )
    return put(shown._replace(sketch=drawn), file)


def surface_parts(found: WorkspaceVolume, opacity: float) -> list[Part]:
    """A mesh for each cause, and one for the barriers inside."""
    axes = ["xyz".find(name[-1]) for name in found.outputs]
    if sorted(axes) != [0, 1, 2] or not len(found.triangles):
        text = (
            f"the outputs {', '.join(found.outputs)} are no coordinates x, y and z, or nothing can be reached"
        )
        raise SarrusError(f"{found.name}: {text}; draw its slices with plot instead")
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
    """Of the vertices that are used, with the outputs as coordinates x, y and z."""
    used, faces = np.unique(triangles, return_inverse=True)
    placed = np.empty((len(used), 3))
    placed[:, axes] = vertices[used]
    faces = faces.reshape(-1, 3)
    return Mesh(placed, faces[:, ::-1] if np.linalg.det(np.eye(3)[axes]) < 0 else faces)
