"""What a link looks like, on the body that carries it, with the files that its description names."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote

from ...model.motion import compose
from ...model.origin import Origin
from ...model.shape import Look
from .carried import Carried

if TYPE_CHECKING:
    from .description import Visual

SEARCH_PATHS = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")


def look_of(visual: Visual, links: Mapping[str, Carried], origin: Origin | None) -> Look:
    """Return a link's visual in the axes of the body that carries the link."""
    link = links[visual.link]
    folder = Path(origin.file).resolve().parent if origin else Path()
    file = _found(visual.file, folder) if visual.file else None
    color = "#" + "".join(f"{round(255 * min(max(c, 0.0), 1.0)):02x}" for c in visual.color[:3])
    pose = compose(link.place, visual.pose)
    return Look(link.body.name, visual.shape, visual.size, pose, file, color if len(color) == 7 else "")


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
    package, _, inside = rest.partition("/")
    for above in (folder, *folder.parents):
        yield above / rest
        if above.name == package:
            yield above / inside
    for variable in SEARCH_PATHS:
        for place in filter(None, os.environ.get(variable, "").split(os.pathsep)):
            yield from (Path(place) / rest, Path(place) / "share" / rest)
            if Path(place).name == package:
                yield Path(place) / inside
