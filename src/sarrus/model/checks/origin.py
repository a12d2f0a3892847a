"""The lines of a model's parts in its file, for errors."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, TypeAlias

Path: TypeAlias = tuple[str | int, ...]

_PAIRS = {
    "body": "bodies",
    "point": "points",
    "frame": "frames",
    "joint": "joints",
}  # body_i, body_j -> bodies: [i, j]


@dataclass(frozen=True)
class Origin:
    """A file's name and the line of every entry in it, by path: ``("bodies", "rod", "mass")``.

    ``files`` names the file of each part that was included from another one.
    """

    file: str
    lines: dict[Path, int]
    files: dict[Path, str] = field(default_factory=dict)

    def where(self, path: Path) -> str:
        """Return ``file:line`` of an entry, or of the nearest entry that holds it."""
        line = self.line(path)
        file = self.files.get(path[:2], self.file)
        return f"{file}:{line}" if line else file

    def line(self, path: Path) -> int:
        """Return the line of an entry, or of the nearest entry that holds it; 0 if there is none."""
        return next((self.lines[path[:n]] for n in range(len(path), -1, -1) if path[:n] in self.lines), 0)

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
