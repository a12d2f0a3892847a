"""A workspace: which places outputs of a mechanism can be at, bounded and divided by curves, and how sure that is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...deferred import renderer
from ...model import SarrusError
from ...model.announcement import announce
from ..result import Result
from ..saving.exported_file import exports, write_table
from ..saving.netcdf import Attributes, Column, flags, write_netcdf

DENSE = 8  # points per piece of a polyline that is drawn
POWERS = np.arange(6)


def sampled(pieces: Array, count: int = DENSE) -> Array:
    """Points along a curve (pieces, 6, 2), so many for each piece, and the last (n, 2)."""
    tau = (np.arange(count) / count)[:, None] ** POWERS
    inner = np.einsum("tp,kpd->ktd", tau, pieces).reshape(-1, 2)
    return np.concatenate([inner, pieces[-1].sum(axis=0)[None]])


def finely(pieces: Array, off: float) -> Array:
    """Points along a curve between which chords are nowhere farther from it than `off`."""
    bends = np.linalg.norm(np.einsum("kpd,p->kd", abs(pieces), POWERS * (POWERS - 1.0)), axis=1)
    return sampled(pieces, max(DENSE, int(np.ceil(np.sqrt(bends.max() / (8 * off))))))


def polygon(line: Array, holes: Sequence[Array] = ()) -> Any:
    """Return the polygon inside of a closed line, without those inside of others."""
    import shapely  # not with `import sarrus`

    found = shapely.Polygon(line, holes)
    shapely.prepare(found)
    return found


def inside(lines: Sequence[Array], points: Array) -> Array:
    """Return which points (n, 2) are inside of an odd number of closed lines (n,)."""
    import shapely

    found = np.zeros(len(points), dtype=bool)
    for line in lines:
        found ^= shapely.contains_xy(polygon(line), points)
    return found


def beyond(lines: Sequence[Array], points: Array, distance: float) -> Array:
    """Return which points (n, 2) are farther than a distance from all lines (n,)."""
    import shapely

    every = shapely.MultiLineString(lines)
    shapely.prepare(every)
    return np.asarray(~shapely.dwithin(every, shapely.points(points), distance))


TRACED = 1e-7  # of the size: how far traced curves may be from true ones; five times what was seen

Status = Literal["mapped", "incomplete", "time limit", "stopped"]
CurveKind = Literal["outer", "void", "barrier", "crossable"]


class MapResult(Result):
    """Base of results of workspace analyses, which may be incomplete."""

    status: Status

    @property
    def success(self) -> bool:
        """Whether the result is complete."""
        return self.status == "mapped"


def places(points: ArrayLike) -> Array:
    """Points as an array (k, 2).

    Raises
    ------
    SarrusError
        If they are no pairs of finite numbers.
    """
    message, example = (
        "points: an array of pairs of finite numbers is needed, shape (k, 2)",
        "Pass [(x, y), ...]",
    )
    try:
        found = np.atleast_2d(np.asarray(points, dtype=float))
    except (TypeError, ValueError):
        raise SarrusError(f"{message}, not {points!r}. {example}.") from None
    if not found.size:
        return np.zeros((0, 2))
    if found.ndim != 2 or found.shape[1] != 2 or not np.isfinite(found).all():
        raise SarrusError(f"{message}, not {found.shape}. {example}.")
    return found


def place_of(point: ArrayLike) -> Array:
    """Return one point as an array (2,).

    Raises
    ------
    SarrusError
        If it is no pair of finite numbers.
    """
    found = places(point)
    if len(found) != 1:
        raise SarrusError(f"point: one pair of numbers is needed, not {len(found)}. Pass (x, y).")
    return np.asarray(found[0])


@dataclass(frozen=True)
class BoundaryCurve:
    """A part of a candidate curve on which nothing changes.

    Attributes
    ----------
    kind : "outer": the boundary of what can be reached. "void": that of a hole in it. "barrier": inside, where motion
        on this branch of assembly can arrive from one side only. "crossable": no impediment.
    u : (k, 2) outputs along it
    inward : (k, 2) unit normals to the side on which the outputs stay; of either side for crossable curves
    q : (j, nq) positions along it, `u_of_q` (j, 2) where they are
    active : limits that are reached, e.g. "q1 lowest"
    singular : whether, beyond these limits, the mechanism itself loses a direction (links stretched or folded)
    length : of the curve
    branch : number of the traced curve that it is a part of
    again : whether another curve of this kind, of another branch of assembly, lies at the same place
    """

    kind: CurveKind
    u: Array = field(repr=False)
    inward: Array = field(repr=False)
    q: Array = field(repr=False)
    u_of_q: Array = field(repr=False)
    active: tuple[str, ...]
    singular: bool
    length: float
    branch: int
    again: bool = False

    @property
    def cause(self) -> str:
        """The cause of the curve as text."""
        limits = ", ".join(self.active)
        if not self.singular:
            return limits
        return f"singularity with {limits}" if limits else "singularity"


@dataclass(frozen=True)
class Component:
    """A connected part of what can be reached.

    Attributes
    ----------
    area, perimeter : of the part
    loops : closed polylines (k, 2): the outer boundary, then holes
    curves : the same as polynomials of degree 5 (count, 6, 2): coefficients of the powers of a parameter 0 ... 1
    """

    area: float
    perimeter: float
    loops: tuple[Array, ...] = field(repr=False)
    curves: tuple[Array, ...] = field(repr=False, default=())


@dataclass(frozen=True)
class Verification:
    """Results of the independent tests of a workspace.

    Attributes
    ----------
    samples, outside : random admissible positions, and how many of them are outside by more than `tolerance`
    rays, known_rays : random rays that found an end, and how many of these ends lie on known curves
    crossings, known_crossings : how often random walks crossed a singular curve, and how many of these are known
    rounds, found_late : tests until nothing new was found, and curves that were traced because of them
    """

    samples: int
    outside: int
    rays: int
    known_rays: int
    crossings: int
    known_crossings: int
    rounds: int
    found_late: int
    tolerance: float

    @property
    def success(self) -> bool:
        """Whether no test failed in the last round."""
        unknown = self.rays + self.crossings - self.known_rays - self.known_crossings
        return not self.outside and not unknown

    @property
    def missed_share(self) -> float:
        """With 95 % confidence, less than this share of random positions is in a part that is missing."""
        return 1 - 0.05 ** (1 / self.samples) if self.samples else 1.0

    def __str__(self) -> str:
        message = [
            f"{self.outside} of {self.samples} random admissible positions are outside.",
            f"{self.known_rays} of {self.rays} rays ended on known curves.",
        ]
        if self.crossings:
            crossed = f"{self.known_crossings} of {self.crossings} crossings of singular curves"
            message.append(f"{crossed} were of known ones.")
        if self.found_late:
            many = ("curves", "they are") if self.found_late > 1 else ("curve", "it is")
            message.append(f"The tests found {self.found_late} missing {many[0]}; {many[1]} traced now.")
        message.append(
            f"With 95 % confidence, less than {100 * self.missed_share:.3g} % of the admissible positions are missing."
        )
        return " ".join(message)


@dataclass(frozen=True)
class Workspace(MapResult):
    """Result of `workspace`: the region that two outputs can reach.

    Attributes
    ----------
    name : of the system
    outputs : their names, `units` "m" or "rad"
    curves : all parts of boundary, barriers and crossable curves
    area, area_error, perimeter : of the reachable region; the error is an estimate; the perimeter of a map of a length
        and an angle is NaN
    components : connected parts, the largest first; no motion leads from one to another
    drawn : number of the part, counted from 0, in which the model's own position lies; None if it is not admissible
    status : "mapped"; "incomplete" if a curve was lost or a test failed; "time limit" or "stopped" (by the user).
        Unless it is "mapped", areas and lengths of the parts are NaN.
    message : one message
    verification : result of the tests of `workspace` and `verify`, or None
    map : the `WorkspaceMap`, from which it can be continued
    """

    name: str
    outputs: tuple[str, str]
    units: tuple[str, str]
    curves: tuple[BoundaryCurve, ...] = field(repr=False)
    area: float
    area_error: float
    perimeter: float
    components: tuple[Component, ...] = field(repr=False)
    drawn: int | None
    status: Status
    message: str
    verification: Verification | None = None
    map: object = field(default=None, repr=False, compare=False)

    @property
    def boundary(self) -> tuple[BoundaryCurve, ...]:
        """The curves of the outer boundary and of voids."""
        return tuple(curve for curve in self.curves if curve.kind in ("outer", "void") and not curve.again)

    def of_kind(self, kind: CurveKind) -> tuple[BoundaryCurve, ...]:
        """Return the curves of one kind."""
        return tuple(curve for curve in self.curves if curve.kind == kind)

    def contains(self, points: ArrayLike) -> Array:
        """Return which points (k, 2) can be reached, to the accuracy of the boundary (1e-7 of the size)."""
        if not self.success:
            message = "the map is not complete, so that places may be classified wrongly"
            announce([f"{self.name}: {message}. See its message."])
        loops = [loop for part in self.components for loop in part.loops]
        off = TRACED * max((float(np.ptp(loop, axis=0).max()) for loop in loops), default=0.0)
        lines = [finely(curve, 0.1 * off) for part in self.components for curve in part.curves]
        found = places(points)
        return np.asarray(inside(lines, found) | ~beyond(lines, found, off))

    def to_csv(self, path: Any) -> None:
        """Write all curves as a table: curve, kind, cause, both outputs, inward normal."""
        rows = (
            (n, curve.kind, curve.cause, *u.tolist(), *normal.tolist())
            for n, curve in enumerate(self.curves)
            for u, normal in zip(curve.u, curve.inward, strict=True)
        )
        write_table(path, ["curve", "kind", "cause", *self.outputs, "inward_1", "inward_2"], rows)

    @exports
    def to_netcdf(self, path: Any) -> None:
        """Write all curves in the NetCDF format: points, inward normals, and kind and cause of every curve."""
        curves = self.curves
        lengths = [len(curve.u) for curve in curves]
        u = np.concatenate([np.zeros((0, 2)), *(curve.u for curve in curves)])
        inward = np.concatenate([np.zeros((0, 2)), *(curve.inward for curve in curves)])
        causes = sorted({curve.cause for curve in curves})
        columns = {"curve": Column(("point",), np.repeat(np.arange(len(curves)), lengths))}
        for n in range(2):
            columns[f"output_{n + 1}"] = Column(
                ("point",), u[:, n], {"long_name": self.outputs[n], "units": self.units[n]}
            )
            columns[f"inward_{n + 1}"] = Column(("point",), inward[:, n])
        columns["kind"] = flags(get_args(CurveKind), [curve.kind for curve in curves], "curves")
        columns["cause"] = flags(causes, [curve.cause for curve in curves], "curves")
        facts: Attributes = {"area": self.area, "area_error": self.area_error}
        write_netcdf(path, columns, {"title": self.name, "status": self.status, **facts})

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draw the workspace; see `sarrus.views.plot_workspace`."""
        return renderer().plot_workspace(self, ax, **options)

    def summary(self) -> str:
        """The result in words."""
        return str(renderer().workspace_report(self))
