"""A link on the body that carries it: its points and frames, and its shape with the files that are named."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import unquote

import numpy as np

from ....model.bodies.shape import REMEDY, VARIABLE, Look, inside, listed
from ....model.checks.findings import Origin
from ....model.forces.paths.wrapping import Wrap
from ....model.geometry.motion import compose
from ....model.geometry.points import Frame, Point, Solid
from ....model.geometry.pose import GROUND_POSE, Pose
from ....model.quantity import Vector, vector
from ..description import Visual

Part = TypeVar("Part")
X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class LinkPlace(Solid):
    """A link at ``place``, in the axes of the body that carries it; often the body itself, or the ground."""

    body: Solid
    place: Pose = GROUND_POSE

    def pose(self) -> Pose:
        """Return the initial pose of the link."""
        return compose(self.body.pose(), self.place)

    def point(self, x: float, y: float, z: float) -> Point:
        """Return the point at (x, y, z) [m] in link axes, on the body."""
        return Point(self.body, self.place.global_point(np.array([x, y, z])))

    def global_point(self, x: float, y: float, z: float) -> Point:
        """Return the point that is at the global (x, y, z) [m] in the initial pose, on the body."""
        return self.body.global_point(x, y, z)

    def frame(self, point: Point | Vector, *, x: Vector | None = None, z: Vector | None = None) -> Frame:
        """Return a frame at ``point``, with directions in link axes; by default the link's own axes."""
        frame: Frame = on_body(super().frame(point, x=x, z=z))
        return frame


def on_body(value: Any) -> Any:
    """Return a point, frame or link as one of the body that carries it; anything else unchanged."""
    if isinstance(value, Point) and isinstance(value.body, LinkPlace):
        return _point_on_body(value, value.body)
    if isinstance(value, Frame) and isinstance(value.point.body, LinkPlace):
        return _frame_on_body(value, value.point.body)
    if isinstance(value, Wrap):
        return _wrap_on_body(value, value.center.body)
    if isinstance(value, tuple | list) and any(isinstance(one, Point | Wrap) for one in value):
        return [on_body(one) for one in value]
    return value.body if isinstance(value, LinkPlace) else value


def part_on_bodies(part: Part) -> Part:
    """Return a joint or force whose points, frames and bodies are those of the carrying bodies."""
    held: Any = part
    return replace(held, **{f.name: on_body(getattr(part, f.name)) for f in fields(held)})  # type: ignore[no-any-return]


def _point_on_body(point: Point, link: LinkPlace) -> Point:
    if point.axes == "global":
        return Point(link.body, point.coordinates, "global")
    return link.point(*vector(point.coordinates, "point"))


def _wrap_on_body(wrap: Wrap, link: Solid) -> Wrap:
    axis, side = wrap.axis, wrap.side
    if isinstance(link, LinkPlace):
        axis = _turned(axis, link)
        if side is not None and not isinstance(side, Point):
            side = link.point(*vector(side, "side")).coordinates
    return Wrap(on_body(wrap.center), wrap.radius, axis, on_body(side))


def _frame_on_body(frame: Frame, link: LinkPlace) -> Frame:
    if frame.point.axes == "global":
        return Frame(on_body(frame.point), x=frame.x, z=frame.z)
    x, z = (frame.x, frame.z) if _has_axes(frame) else (X, Z)
    return Frame(on_body(frame.point), x=_turned(x, link), z=_turned(z, link))


def _has_axes(frame: Frame) -> bool:
    return frame.x is not None or frame.z is not None


def _turned(direction: Vector | None, link: LinkPlace) -> Vector | None:
    return None if direction is None else link.place.A @ np.array(vector(direction, "frame"))


LAYOUT = ("urdf", "robots", "mjcf", "xacro")  # folders of descriptions that stand beside the folder of meshes
SEARCH_PATHS = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
PACKAGE = ("package", "model")  # schemes of files in a package, of ROS and of Gazebo


def look_of(
    visual: Visual, links: Mapping[str, LinkPlace], origin: Origin | None, search: Sequence[str]
) -> Look:
    """Return a link's visual in the axes of the body that carries the link; search has further folders of files."""
    link = links[visual.link]
    folder = Path(origin.file).resolve().parent if origin else Path()
    folders = [*map(Path, search), *listed(*SEARCH_PATHS)]
    file = _found(visual.file, folder, folders) if visual.file else None
    wrong = (
        ""
        if file is None or allowed(file, visual.file, folder, folders)
        else f"{file}: is outside of the model's folder. {REMEDY}"
    )
    color = "#" + "".join(f"{round(255 * min(max(c, 0.0), 1.0)):02x}" for c in visual.color[:3])
    pose = compose(link.place, visual.pose)
    return Look(
        link.body.name, visual.shape, visual.size, pose, file, color if len(color) == 7 else "", wrong
    )


def allowed(file: Path, name: str, folder: Path, search: list[Path]) -> bool:
    """Return whether a file is in the description's folder or package, the package that it names or a listed folder."""
    above = [folder, *folder.parents][:-1]  # without the root of all files
    package = next((one for one in above if (one / "package.xml").is_file()), None)
    home = package or (folder.parent if folder.name in LAYOUT and folder.parent in above else folder)
    scheme, _, rest = name.rpartition("://")
    top = rest.partition("/")[0]
    is_package = scheme in PACKAGE and top not in ("", ".", "..")
    named = [place for one in above for place in (one / top, one) if is_package and place.name == top]
    return inside(file, [home, *named, *search, *listed(VARIABLE)])


def _found(name: str, folder: Path, search: list[Path]) -> Path:
    """The file that ``meshes/a.stl``, ``package://robot/meshes/a.stl`` or ``file:///...`` means."""
    scheme, _, rest = name.rpartition("://")
    if scheme == "file":
        return Path(unquote(rest))
    places = _places(rest, folder, search) if scheme in PACKAGE else (one / rest for one in (folder, *search))
    return next((place for place in places if place.is_file()), folder / rest)


def _places(rest: str, folder: Path, search: list[Path]) -> Iterator[Path]:
    """Return the possible folders of a package: near the description, or in the path of ROS."""
    package, _, below = rest.partition("/")
    for above in (folder, *folder.parents):
        yield above / rest
        if above.name == package:
            yield above / below
    for place in search:
        yield from (place / rest, place / "share" / rest)
        if place.name == package:
            yield place / below
