"""Errors of several parts, collected so that the first can give their number."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Self, TypeAlias

from ..errors import ModelError
from ..show import quote

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


KINDS = {
    "bodies": "body",
    "joints": "joint",
    "drivers": "driver",
    "forces": "force",
    "points": "point",
    "parameters": "parameter",
    "outputs": "output",
}


def part_name(path: Path) -> str:
    """Return ``body "rod"`` for the path (bodies, rod), and ``model`` for anything else."""
    if len(path) >= 2 and path[0] in KINDS:
        return f"{KINDS[str(path[0])]} {quote(str(path[1]))}"
    return "model"


MOST = 100  # errors of one model that are looked for


class Findings:
    """A list of model errors with the places they belong to; at the end of a ``with`` block the first is raised."""

    def __init__(self, origin: Origin | None) -> None:
        self.origin = origin
        self.errors: list[ModelError] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if error is None:
            self.raise_first()

    @contextmanager
    def about(self, *path: str) -> Iterator[None]:
        """Keep a ModelError that is raised inside, as one about the part at ``path``."""
        try:
            yield
        except ModelError as error:
            self.errors.append(self._placed(error, path))
            if len(self.errors) == MOST:
                self.raise_first()

    def _placed(self, error: ModelError, path: Path) -> ModelError:
        where = self.origin.of_field(path, error.field) if self.origin else ""
        return ModelError(error.message, part=part_name(path), field=error.field, where=where)

    def raise_first(self) -> None:
        """Raise the first collected error, if any."""
        if self.errors:
            self.errors[0].more = len(self.errors) - 1
            raise self.errors[0]
