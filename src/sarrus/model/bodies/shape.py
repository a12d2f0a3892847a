"""The shape of a body, if given, and the mesh files it may name: for pictures only, never used in an equation."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import ModelError
from ..geometry.orientation import Orientation, euler_parameters
from ..geometry.pose import GROUND_POSE, Pose
from ..geometry.rotation import matrix
from ..measure import Offset, Ratio
from ..quantity import positive, vector


@dataclass(frozen=True, eq=False)
class Shape:
    """The shape of a body in pictures, from a mesh file.

    Parameters
    ----------
    file
        Of a mesh: .stl, .obj, .ply, .gltf, .glb or .dae. In a model file the path is relative to the folder of that
        file.
    scale
        Factor from the unit of the mesh to metres: 0.001 for millimetres.
    position
        Of the mesh's origin, in body axes [m].
    orientation
        Of the mesh's axes in body axes: Euler parameters, matrix, `AxisAngle` or `EulerAngles`.
    color
        ``"#rrggbb"``; left out, that of the file, or the body's.
    """

    file: str
    scale: Ratio = 1.0
    position: Offset = (0.0, 0.0, 0.0)
    orientation: Orientation = (1.0, 0.0, 0.0, 0.0)
    color: str = ""

    def look(self, body: str, folder: Path) -> Look:
        """Return it as it is drawn; raise a ModelError if its numbers are wrong."""
        scale = positive(
            self.scale, "scale", "Give what the mesh's numbers are multiplied by to give metres."
        )
        p = euler_parameters(self.orientation)
        place = Pose(np.array(vector(self.position, "position")), p, matrix(p))
        return Look(body, "mesh", (scale, scale, scale), place, folder / self.file, _color(self.color))


class Look(NamedTuple):
    """Something that a body is drawn with, at a pose in body axes.

    ``shape`` is box, cylinder, sphere, capsule, ellipsoid or mesh; ``size`` its sides, its radius and length, or its
    radii [m], for a mesh the scale;
    ``color`` is ``"#rrggbb"`` or empty; ``wrong`` is the reason why its file is not read.
    """

    body: str
    shape: str
    size: Sequence[float]
    pose: Pose = GROUND_POSE
    file: Path | None = None
    color: str = ""
    wrong: str = ""


def _color(color: str) -> str:
    good = len(color) == 7 and color[0] == "#" and all(c in "0123456789abcdefABCDEF" for c in color[1:])
    if color and not good:
        raise ModelError(
            f'color must be like "#3b76b5", but is "{color}". Give red, green and blue.', field="color"
        )
    return color


VARIABLE = "SARRUS_MESH_PATH"  # folders with meshes and included files, beside those of the model
REMEDY = f"Move it there, or list its folder in the environment variable {VARIABLE}."


def listed(*variables: str) -> list[Path]:
    """The folders that environment variables list."""
    texts = [os.environ.get(variable, "") for variable in variables]
    return [Path(place) for text in texts for place in text.split(os.pathsep) if place]


def inside(file: Path, folders: Iterable[Path]) -> bool:
    """Whether a file is named in one of these folders, or below; links are not followed."""
    named = Path(os.path.abspath(file))
    return any(named.is_relative_to(os.path.abspath(folder)) for folder in folders)
