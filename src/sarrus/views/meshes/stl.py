"""STL: bare triangles, binary or as text."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..shapes import Mesh
from .bounds import content
from .colored import Colored

HEADER = 84  # bytes: text, and the number of triangles
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(file: Path) -> Iterator[Colored]:
    """Yield the triangles of an STL file; each keeps its own corners, and is seen flat."""
    data = content(file)
    count = int.from_bytes(data[80:HEADER], "little")
    if len(data) >= HEADER and len(data) == HEADER + RECORD.itemsize * count:
        corners = np.frombuffer(data, RECORD, count, HEADER)["corners"].reshape(-1, 3)
    else:
        corners = _from_text(data.decode("ascii", "strict"))
    yield Colored(Mesh(corners.astype(float), np.arange(len(corners)).reshape(-1, 3)))


def _from_text(text: str) -> np.ndarray:
    lines = (line.split() for line in text.splitlines())
    return np.array([[float(x) for x in words[1:4]] for words in lines if words[:1] == ["vertex"]]).reshape(
        -1, 3
    )
