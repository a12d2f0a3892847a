"""Errors of several parts, collected so that the first can give their number."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Self, TypeAlias, TypeVar

from ..errors import ModelError
from ..show import quote

Path: TypeAlias = tuple[str | int, ...]
T = TypeVar("T")

PAIRS = {
    "body": "bodies",
    "point": "points",
    "frame": "frames",
    "joint": "joints",
}  # body_i, body_j -> bodies: [i, j]


@dataclass(frozen=True)
class Origin:
    """A file's name and the line of every entry in it, by path: ``("bodies", "rod", "mass")``.

    ``files`` names the file of each part, and of each value, that is from another one by an include. ``given`` are the
    places ``file:line`` of such values, by the paths of the entries whose formulas use them.
    """

    file: str
    lines: dict[Path, int]
    files: dict[Path, str] = field(default_factory=dict)
    given: dict[Path, str] = field(default_factory=dict)

    def where(self, path: Path) -> str:
        """Return ``file:line`` of an entry, or of the nearest entry that holds it; first that of a value in it."""
        line, file = self.line(path), _nearest(self.files, path, self.file)
        place = f"{file}:{line}" if line else file
        values = (where for entry, where in self.given.items() if _is_within(entry, path))
        value = next(values, "") if len(path) > 2 else ""
        return f"{value}, used in {place}" if value else place

    def line(self, path: Path) -> int:
        """Return the line of an entry, or of the nearest entry that holds it; 0 if there is none."""
        return _nearest(self.lines, path, 0)

    def of_field(self, part: Path, field: str) -> str:
        """Return ``file:line`` of a part's field, also where the file joins two fields in a pair."""
        name, _, side = field.partition(" ")[0].rpartition("_")
        pair: Path = (PAIRS.get(name, ""), "ij".find(side))
        paired = part + pair
        return self.where(paired if paired in self.lines else (*part, field))


def _nearest(values: dict[Path, T], path: Path, other: T) -> T:
    """The value of a path, or of the nearest one that holds it."""
    return next((values[path[:n]] for n in range(len(path), -1, -1) if path[:n] in values), other)


def _is_within(entry: Path, path: Path) -> bool:
    """Whether one of two paths holds the other."""
    return entry[: len(path)] == path[: len(entry)]


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
    "hardpoints": "hardpoint",
    "parameters": "parameter",
    "outputs": "output",
}


WORDS = tuple(f"{word} " for word in KINDS.values())


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
            placed = self._placed(error, path)
            if str(placed) not in map(str, self.errors):
                self.errors.append(placed)
            if len(self.errors) == MOST:
                self.raise_first()

    def _placed(self, error: ModelError, path: Path) -> ModelError:
        """The error about another part of the model that it names, as one whose formula is used, or about this one."""
        own = part_name(path)
        part = error.part if error.part.startswith(WORDS) else own
        where = self.origin.of_field(path, error.field) if self.origin and part == own else ""
        return ModelError(error.message, part=part, field=error.field, where=where)

    def raise_first(self) -> None:
        """Raise the first collected error, if any."""
        if self.errors:
            self.errors[0].more = len(self.errors) - 1
            raise self.errors[0]
