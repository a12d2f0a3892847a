"""Where the parts of a model stand in its file, so that errors can name the line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

Path: TypeAlias = tuple[str | int, ...]

_PAIRS = {"body": "bodies", "point": "points", "frame": "frames"}  # body_i, body_j -> bodies: [i, j]


@dataclass(frozen=True)
class Origin:
    """A file's name and the line of every entry in it, by path: ``("bodies", "rod", "mass")``."""

    file: str
    lines: Mapping[Path, int]

    def where(self, path: Path) -> str:
        """Return ``file:line`` of an entry, or of the nearest entry that holds it."""
        known = [path[:n] for n in range(len(path), -1, -1) if path[:n] in self.lines]
        return f"{self.file}:{self.lines[known[0]]}" if known else self.file

    def of_field(self, part: Path, field: str) -> str:
        """Return ``file:line`` of a part's field, also where the file joins two fields in a pair."""
        name, _, side = field.partition(" ")[0].rpartition("_")
        pair: Path = (_PAIRS.get(name, ""), "ij".find(side))
        paired = part + pair
        return self.where(paired if paired in self.lines else (*part, field))


def path_text(path: tuple[Any, ...]) -> str:
    """Return a path as a person reads it: ``points[1].at``."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")
