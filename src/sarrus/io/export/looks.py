"""Shapes of bodies in exported files: which of them a format has, and meshes as paths from the file's folder."""

from __future__ import annotations

import os
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import compress
from operator import not_
from pathlib import Path

import numpy as np

from ...model.bodies.shape import Look
from ...model.errors import SarrusWarning
from .contents import Contents

BASIC = ("box", "sphere", "cylinder")


def with_shapes(
    contents: Contents, folder: Path, kinds: Collection[str], meshes: Collection[str]
) -> Contents:
    """Return the contents with the shapes that a format has; a warning names the kinds and meshes that it has not.

    Parameters
    ----------
    folder : of the exported file
    kinds : shapes other than meshes
    meshes : endings of meshes
    """
    looks = [part for look in contents.looks for part in ([look] if look.shape in kinds else _parts(look))]
    good = [_is_good(look, kinds, meshes) for look in looks]
    lost = sorted({one.file.name if one.file else one.shape for one in compress(looks, map(not_, good))})
    if lost:
        message = f"{contents.name}: shapes are not in the file, {', '.join(lost)}."
        warnings.warn(
            f"{message} Their files are missing, their size is zero, or the format does not have them.",
            SarrusWarning,
            stacklevel=5,
        )
    return replace(contents, looks=[_relative(look, folder) for look in compress(looks, good)])


def looks_by_body(contents: Contents) -> Mapping[str, Sequence[Look]]:
    """Return the shapes of each body."""
    looks: dict[str, list[Look]] = {}
    for look in contents.looks:
        looks.setdefault(look.body, []).append(look)
    return looks


def rgba(look: Look) -> tuple[float, ...] | None:
    """Return red, green, blue and opacity, None without a color."""
    if not look.color:
        return None
    red, green, blue = (int(look.color[n : n + 2], 16) / 255 for n in (1, 3, 5))
    return red, green, blue, 1.0


def sizes(look: Look) -> Iterator[tuple[str, Sequence[float]]]:
    """Yield the names of sizes in URDF and SDF, with their values."""
    names = {"box": ("size",), "ellipsoid": ("radii",), "mesh": ("scale",)}.get(look.shape)
    if names:
        yield names[0], look.size
    else:
        yield from zip(("radius", "length"), ((one,) for one in look.size), strict=False)


def _parts(look: Look) -> Iterator[Look]:
    """Yield the cylinder and the spheres of a capsule; other shapes as they are."""
    if look.shape != "capsule":
        yield look
        return
    radius, length = look.size
    yield look._replace(shape="cylinder")
    for z in (-length / 2, length / 2):
        end = look.pose._replace(r=look.pose.global_point(np.array([0.0, 0.0, z])))
        yield look._replace(shape="sphere", size=(radius,), pose=end)


def _is_good(look: Look, kinds: Collection[str], meshes: Collection[str]) -> bool:
    if look.shape != "mesh":
        return look.shape in kinds and min(look.size) > 0
    return bool(look.file and not look.wrong and look.file.is_file() and look.file.suffix.lower() in meshes)


def _relative(look: Look, folder: Path) -> Look:
    if look.file is None:
        return look
    return look._replace(file=Path(os.path.relpath(look.file.resolve(), folder.resolve())))
