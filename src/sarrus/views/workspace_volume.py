"""Workspaces of three outputs: the surface and some of its slices."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..results.maps.workspace_volume import WorkspaceVolume
from .plots import BLUE, ORANGE, figure_of

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
    ax = figure_of(7.5, 6.5).add_subplot(projection="3d") if ax is None else ax
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
    names = zip((ax.set_xlabel, ax.set_ylabel, ax.set_zlabel), found.outputs, strict=True)
    for set_label, name in names:
        set_label(name)
    ax.set_aspect("equal")
    ax.set_title(f"{found.name}: {found.volume:.5g} (± {found.volume_error:.1g}) can be reached", fontsize=10)
    return ax
