"""The shape of a link, on the body that it belongs to, with the files that its description names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote

from ...model.bodies.shape import REMEDY, VARIABLE, Look, inside, listed
from ...model.checks.origin import Origin
from ...model.geometry.motion import compose
from .carried import Carried

if TYPE_CHECKING:
    from .description import Visual

LAYOUT = ("urdf", "robots", "mjcf", "xacro")  # folders of descriptions that stand beside the folder of meshes
SEARCH_PATHS = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")


def look_of(visual: Visual, links: Mapping[str, Carried], origin: Origin | None) -> Look:
    """Return a link's visual in the axes of the body that carries the link."""
    link = links[visual.link]
    folder = Path(origin.file).resolve().parent if origin else Path()
    file = _found(visual.file, folder) if visual.file else None
    wrong = (
        ""
        if file is None or _allowed(file, visual.file, folder)
        else f"{file}: is outside of the model's folder; {REMEDY}"
    )
    color = "#" + "".join(f"{round(255 * min(max(c, 0.0), 1.0)):02x}" for c in visual.color[:3])
    pose = compose(link.place, visual.pose)
    return Look(
        link.body.name, visual.shape, visual.size, pose, file, color if len(color) == 7 else "", wrong
    )


def _allowed(file: Path, name: str, folder: Path) -> bool:
    """Whether a file is in the description's folder or package, in the package that it names, or in a listed folder."""
    above = [folder, *folder.parents][:-1]  # without the root of all files
    package = next((one for one in above if (one / "package.xml").is_file()), None)
    home = package or (folder.parent if folder.name in LAYOUT and folder.parent in above else folder)
    scheme, _, rest = name.rpartition("://")
    named = [one / rest.partition("/")[0] for one in above] if scheme == "package" else []
    named += [one for one in above if named and one.name == rest.partition("/")[0]]
    return inside(file, [home, *named, *listed(VARIABLE, *SEARCH_PATHS)])


def _found(name: str, folder: Path) -> Path:
    """The file that ``meshes/a.stl``, ``package://robot/meshes/a.stl`` or ``file:///...`` means."""
    scheme, _, rest = name.rpartition("://")
    if scheme == "file":
        return Path(unquote(rest))
    if scheme != "package":
        return folder / rest
    return next((place for place in _places(rest, folder) if place.is_file()), folder / rest)


def _places(rest: str, folder: Path) -> Iterator[Path]:
    """Where a package may be: at, beside or below the folders above the description, or where ROS looks."""
    package, _, below = rest.partition("/")
    for above in (folder, *folder.parents):
        yield above / rest
        if above.name == package:
            yield above / below
    for place in listed(*SEARCH_PATHS):
        yield from (place / rest, place / "share" / rest)
        if place.name == package:
            yield place / below
