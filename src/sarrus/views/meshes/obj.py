"""OBJ: vertices and polygons as text, with the colours of its material file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from .colored import Colored, beside, content, hexadecimal, welded

Corner = tuple[int, int]  # numbers of the vertex and of its normal


def read_obj(file: Path) -> Iterator[Colored]:
    """Yield the polygons of an OBJ file as triangles, one mesh for each material."""
    places: list[list[float]] = []
    normals = 0
    colors: dict[str, str] = {}
    pieces: dict[str, list[tuple[Corner, Corner, Corner]]] = {}
    material = ""
    for words in _lines(file):
        match words[:1]:
            case ["v"]:
                places.append([float(x) for x in words[1:4]])
            case ["vn"]:
                normals += 1
            case ["mtllib"]:
                colors |= _colors(beside(file, " ".join(words[1:])))
            case ["usemtl"]:
                material = " ".join(words[1:])
            case ["f"]:
                corners = [_corner(word, len(places), normals) for word in words[1:]]
                fan = [(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)]
                pieces.setdefault(material, []).extend(fan)
    points = np.array(places).reshape(-1, 3)
    for name, triangles in pieces.items():
        keys = np.array(triangles).reshape(-1, 3, 2)
        if len(keys):
            yield Colored(welded(points[keys[:, :, 0]], keys), colors.get(name, ""))


def _lines(file: Path) -> Iterator[list[str]]:
    text = content(file).decode("utf-8", errors="replace")
    return (line.split() for line in text.splitlines())


def _corner(word: str, places: int, normals: int) -> Corner:
    """``7``, ``7/2`` or ``7/2/3``; negative numbers count from the end."""
    vertex, _, rest = word.partition("/")
    normal = rest.partition("/")[2]
    return _place(int(vertex), places), _place(int(normal), normals) if normal else 0


def _place(number: int, count: int) -> int:
    place = number + count if number < 0 else number - 1
    if not 0 <= place < count:
        raise ValueError(f"a face has corner {number}, but there are {count}. Export the mesh again.")
    return place


def _colors(file: Path) -> dict[str, str]:
    """Diffuse colours by material; none if there is no such file."""
    colors: dict[str, str] = {}
    name = ""
    for words in _lines(file) if file.is_file() else ():
        if words[:1] == ["newmtl"]:
            name = " ".join(words[1:])
        elif words[:1] == ["Kd"]:
            colors[name] = hexadecimal(np.array([float(x) for x in words[1:4]]))
    return colors
