"""Errors of several parts, collected so that the first can give their number."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ..errors import ModelError
from ..show import quote
from .origin import Origin, Path

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
    """A list of model errors with the places they belong to."""

    def __init__(self, origin: Origin | None) -> None:
        self.origin = origin
        self.errors: list[ModelError] = []

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
