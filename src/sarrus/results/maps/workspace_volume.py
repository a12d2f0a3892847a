"""The workspace of three outputs of a mechanism: slices, volume and a surface of triangles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...deferred import renderer
from ...model import Model
from ...outputs.units import product
from ..result import Result
from ..saving.exported_file import exports, write_table
from ..saving.netcdf import Column, flags, write_netcdf
from .workspace import MapResult, Status, beyond, inside


@dataclass(frozen=True)
class CriticalValue:
    """A value at which the output is stationary for all admissible motions, or that could be crossed.

    Attributes
    ----------
    value : of the output
    side : +1: motion keeps above it. -1: below. 0: it can be crossed.
    active : limits that are reached, e.g. "q1 lowest"
    singular : whether the mechanism itself loses a direction there
    q : (nq,)
    sure : false where further limits are reached by coincidence, so that `side` may be wrong
    """

    value: float
    side: int
    active: tuple[str, ...]
    singular: bool
    q: Array = field(repr=False)
    sure: bool = True

    @property
    def cause(self) -> str:
        """The cause of the limit as text."""
        return ", ".join((*(("singularity",) if self.singular else ()), *self.active))


@dataclass(frozen=True)
class WorkspaceRange(MapResult):
    """Result of `workspace_range`: the values that one output can reach.

    Attributes
    ----------
    name : of the system; `output` of the function, `unit` "m" or "rad"
    intervals : (lowest, highest) of each part, increasing
    critical : all critical values, increasing
    search : data for `sarrus.end_gradient`
    """

    name: str
    output: str
    unit: str
    intervals: tuple[tuple[float, float], ...]
    critical: tuple[CriticalValue, ...] = field(repr=False)
    status: Status
    message: str
    search: object = field(default=None, repr=False, compare=False)

    def headline(self) -> str:
        """The intervals, without causes and tests."""
        return self.summary().partition(". ")[0]

    def summary(self) -> str:
        """The result in words."""
        message = (
            " and ".join(f"{low:.9g} to {high:.9g} {self.unit}" for low, high in self.intervals) or "nowhere"
        )
        if not self.success:
            return f"{self.name}: the values that {self.output} can take are not known. {self.message}."
        ends = {end for pair in self.intervals for end in pair}
        causes = [f"{one.value:.9g} by {one.cause}" for one in self.critical if one.value in ends]
        different = "; ".join(dict.fromkeys(causes))  # many positions may have the same end
        return f"{self.name}: {self.output} can be from {message}. Ends: {different}. {self.message}."


@dataclass(frozen=True)
class ShapeDerivative(Result):
    """Derivatives of an area, a volume or an end of a range with respect to parameters.

    Attributes
    ----------
    of : the differentiated quantity, "area", "volume" or "link.x"
    value : its value
    by : derivatives by parameter name
    kinked : length (area) of the boundary on which several curves with different causes coincide; there the derivatives
        are those of one of them
    error : estimated errors of the derivatives, if an integration gives them
    """

    of: str
    value: float
    by: Mapping[str, float]
    kinked: float = 0.0
    error: Mapping[str, float] = field(default_factory=dict)

    def __getitem__(self, name: str) -> float:
        return self.by[name]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.by)

    def summary(self) -> str:
        """The result in words."""
        rates = [(name, rate, self.error.get(name, 0.0)) for name, rate in self.by.items()]
        lines = [
            f"  by {name:<32} {rate:+.9g}{f' (± {error:.1g})' * (error > 0)}" for name, rate, error in rates
        ]
        return "\n".join([f"{self.of} = {self.value:.9g}", *lines])


# Points of curves, each with its limits by number and their end, 0 the lowest, 1 the highest value
Starts: TypeAlias = tuple[tuple[frozenset[tuple[int, int]], Array], ...]


@dataclass(frozen=True)
class Loop:
    """A closed part of a slice's boundary.

    Attributes
    ----------
    part : number of the connected part that it bounds
    hole : whether it bounds a hole
    points : (k, 2), the last the same as the first, the region on their left
    corners : where runs of one cause begin
    causes : of these runs, such as "q1.angle lowest" or "singularity"; of the whole loop, if there is no corner
    """

    part: int
    hole: bool
    points: Array = field(repr=False)
    corners: tuple[int, ...]
    causes: tuple[str, ...]

    def cause_along(self) -> list[str]:
        """The cause at every point."""
        if not self.corners:
            return [self.causes[0]] * len(self.points)
        run = np.searchsorted(self.corners, np.arange(len(self.points)), side="right") - 1
        return [self.causes[k] for k in run.tolist()]


@dataclass(frozen=True)
class Slice:
    """Region that two outputs can reach at a constant value of the third.

    Attributes
    ----------
    height : value of the third output
    area, area_error : of what can be reached
    loops : its boundary
    barriers : (k, 2) lines inside that motion can meet from one side only
    success : whether nothing was lost
    starts : points of its curves, from which its neighbours begin
    rates, kinked : derivatives of the area by all numbers, if they were asked for; length of the boundary where they
        have two sides
    """

    height: float
    area: float
    area_error: float
    loops: tuple[Loop, ...] = field(repr=False)
    barriers: tuple[Array, ...] = field(repr=False)
    success: bool
    starts: Starts = field(default=(), repr=False, compare=False)
    rates: Array | None = field(default=None, repr=False, compare=False)
    kinked: float = field(default=0.0, repr=False)

    def holds(self, u: ArrayLike, tolerance: float = 0.0) -> bool:
        """Whether a point (2,) can be reached, or is so near to one that can be; polylines err by 3e-4 of the size."""
        p, lines = np.atleast_2d(np.asarray(u, dtype=float)), [loop.points for loop in self.loops]
        return bool(inside(lines, p)[0] or not beyond(lines, p, tolerance)[0])


@dataclass(frozen=True)
class VolumeRates:
    """Derivatives of a volume with respect to all parameters.

    Attributes
    ----------
    total, missed : derivatives of the integral of the slices by all numbers, and by how much half as many slices differ
    kinked : area of the boundary where derivatives have two sides
    jumps : heights of level parts of the boundary, with the area that the slices lose there
    slices, reach : the problem of the slices; the range of the third output, from which heights change
    """

    total: Array
    missed: Array
    kinked: float
    jumps: tuple[tuple[float, float], ...]
    slices: object
    reach: WorkspaceRange


@dataclass(frozen=True)
class WorkspaceVolume(MapResult):
    """Result of `workspace_volume`: the region that three outputs can reach.

    Attributes
    ----------
    name : of the system; `outputs` the three functions
    ranges : intervals of the third output
    slices : by increasing height
    critical : heights inside of the ranges at which the third output is stationary
    volume, volume_error : by integration over slices between critical heights, and by how much half as many slices miss
        it. If the analysis was interrupted, a coarse value by the slices so far;
        nan if the map is incomplete for another reason
    vertices, triangles : (nv, 3) and (nt, 3) of a closed surface through the slices' boundaries
    causes, cause_of : causes of the boundary, and the cause of each triangle (nt,)
    model : the mechanism, for pictures
    rates : derivatives of the volume, if requested; see `sarrus.volume_gradient`
    units : of the outputs
    """

    name: str
    outputs: tuple[str, str, str]
    ranges: tuple[tuple[float, float], ...]
    critical: tuple[float, ...]
    slices: tuple[Slice, ...] = field(repr=False)
    volume: float
    volume_error: float
    vertices: Array = field(repr=False)
    triangles: Array = field(repr=False)
    causes: tuple[str, ...] = field(repr=False)
    cause_of: Array = field(repr=False)
    status: Status
    message: str
    model: Model | None = field(default=None, repr=False, compare=False)
    rates: VolumeRates | None = field(default=None, repr=False, compare=False)
    units: tuple[str, str, str] = ("m", "m", "m")

    @property
    def unit(self) -> str:
        """The unit of the volume."""
        return product(*((unit, 1) for unit in self.units))

    @exports
    def to_obj(self, path: Any) -> None:
        """Write the surface as a Wavefront file."""
        from pathlib import Path

        lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in self.vertices.tolist()]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in self.triangles.tolist()]
        Path(path).write_text("\n".join([f"# {self.name}", *lines, ""]), encoding="utf-8")

    def to_csv(self, path: Any) -> None:
        """Write all slices as a table: part, whether it is a hole, cause, the three outputs."""
        rows = (
            (n, k, loop.part, int(loop.hole), cause, *u, one.height)
            for n, one in enumerate(self.slices)
            for k, loop in enumerate(one.loops)
            for u, cause in zip(loop.points.tolist(), loop.cause_along(), strict=True)
        )
        write_table(path, ["slice", "loop", "part", "hole", "cause", *self.outputs], rows)

    @exports
    def to_netcdf(self, path: Any) -> None:
        """Write the surface and the areas of the slices in the NetCDF format."""
        slices = self.slices
        columns = {
            "vertices": Column(("vertex", "axis"), self.vertices, {"long_name": ", ".join(self.outputs)}),
            "triangles": Column(("triangle", "corner"), self.triangles),
            "cause": flags(self.causes, [self.causes[n] for n in self.cause_of], "triangle"),
            "height": Column(("slice",), np.array([one.height for one in slices])),
            "area": Column(("slice",), np.array([one.area for one in slices])),
            "area_error": Column(("slice",), np.array([one.area_error for one in slices])),
        }
        facts = {"volume": self.volume, "volume_error": self.volume_error}
        write_netcdf(path, columns, {"title": self.name, "status": self.status, **facts})

    def plot(self, ax: Any = None) -> Any:
        """Draw the surface; see `sarrus.views.plot_workspace_volume`."""
        return renderer().plot_workspace_volume(self, ax)

    def view(self, file: Any = None, **options: Any) -> Any:
        """Show the surface with the mechanism in the browser; see `sarrus.views.view_workspace`."""
        return renderer().view_workspace(self, file, **options)

    def enclosed(self) -> float:
        """The volume inside of the triangles by the divergence theorem, approximately `volume`."""
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)

    def summary(self) -> str:
        """The result in words."""
        heights = " and ".join(f"{low:.6g} to {high:.6g}" for low, high in self.ranges) or "nowhere"
        if not self.success:
            message = f"{self.name}: the volume that {', '.join(self.outputs)} can reach is not known"
            if np.isfinite(self.volume):
                message += f" precisely, some {self.volume:.3g} {self.unit} (± {self.volume_error:.1g})"
            return f"{message}. {self.message}."
        return (
            f"{self.name}: {', '.join(self.outputs)} can reach a volume of {self.volume:.7g} {self.unit} "
            f"(± {self.volume_error:.1g}), {self.outputs[2]} from {heights} {self.units[2]}, "
            f"by {len(self.slices)} slices. {self.message}."
        )
