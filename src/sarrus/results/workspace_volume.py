"""What three outputs of a mechanism can reach: slices, volume and a surface of triangles."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ..algebra import Array


@dataclass(frozen=True)
class Slice:
    """What two outputs can reach while the third keeps a value.

    Attributes
    ----------
    height : value of the third output
    area, area_error : of what can be reached
    components : for each connected part its closed polylines (k, 2), the outer one first
    success : whether nothing was lost
    """

    height: float
    area: float
    area_error: float
    components: tuple[tuple[Array, ...], ...] = field(repr=False)
    success: bool


@dataclass(frozen=True)
class WorkspaceVolume:
    """What three outputs can reach.

    Attributes
    ----------
    name : of the system; `outputs` the three functions
    ranges : intervals of the third output
    slices : by rising height
    volume, volume_error : by integration over slices; the error is an estimate from half of them
    vertices, triangles : (nv, 3) and (nt, 3) of a surface through the slices' boundaries
    """

    name: str
    outputs: tuple[str, str, str]
    ranges: tuple[tuple[float, float], ...]
    slices: tuple[Slice, ...] = field(repr=False)
    volume: float
    volume_error: float
    vertices: Array = field(repr=False)
    triangles: Array = field(repr=False)
    status: Literal["mapped", "incomplete"]
    message: str

    @property
    def success(self) -> bool:
        """Whether nothing was lost."""
        return self.status == "mapped"

    def to_obj(self, path: Any) -> None:
        """Write the surface as a Wavefront file."""
        from pathlib import Path

        lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in self.vertices.tolist()]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in self.triangles.tolist()]
        Path(path).write_text("\n".join([f"# {self.name}", *lines, ""]), encoding="utf-8")

    def plot(self, ax: Any = None) -> Any:
        """Draw the surface; see `sarrus.views.plot_workspace_volume`."""
        from importlib import import_module

        return import_module("sarrus.views").plot_workspace_volume(self, ax)

    def enclosed(self) -> float:
        """The volume inside of the triangles, by the divergence theorem: nearly `volume`."""
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)

    def __str__(self) -> str:
        heights = " and ".join(f"{low:.6g} to {high:.6g}" for low, high in self.ranges)
        return (
            f"{self.name}: {', '.join(self.outputs)} can reach a volume of {self.volume:.7g} "
            f"(± {self.volume_error:.1g}), {self.outputs[2]} from {heights}, by {len(self.slices)} slices. "
            f"{self.message}."
        )
