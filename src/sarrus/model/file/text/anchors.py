"""Anchors (&), aliases (*) and merge keys (<<) of YAML: copies of other parts of the file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from ...checks.origin import Path
from ...errors import ModelError
from ...show import quote, suggest
from .document import refusal, refuse_deep

MOST = 500_000  # entries that aliases may copy


@dataclass
class Anchored:
    """A value with its place; ``open`` while it is being read."""

    path: Path
    data: object = None
    open: bool = True


class Anchors:
    """The anchors of a file, and the lines of its entries, to which copies add theirs."""

    def __init__(self, file: str, lines: dict[Path, int]) -> None:
        self.file = file
        self.lines = lines
        self.known: dict[str, Anchored] = {}
        self.copied = 0

    @contextmanager
    def named(self, name: str | None, path: Path) -> Iterator[Anchored]:
        """Keep the value that is read inside, under the name of its anchor if it has one."""
        anchored = Anchored(path)
        if name is not None:
            self.known[name] = anchored
        yield anchored
        anchored.open = False

    def copy(self, name: str, path: Path, line: int) -> Any:
        """Return a copy of an anchored value as the entry at ``path``; what is in it keeps the original's lines."""
        if name not in self.known:
            message = f"uses the alias {quote('*' + name)}, but there is no anchor &{name} above it"
            remedy = suggest(name, self.known) if self.known else "Write the value out."
            raise refusal(f"{message}. {remedy}", self.file, line, path)
        anchored = self.known[name]
        if anchored.open:
            message = f"uses the alias {quote('*' + name)} inside of its own anchor. Write the value out."
            raise refusal(message, self.file, line, path)
        own = self.lines.get(path, line)
        data = self._copied(anchored.data, anchored.path, path, line)
        self.lines[path] = own
        return data

    def merge(self, value: Any, place: Path, values: dict[str, Any]) -> None:
        """Add the entries of a merge key to a mapping that does not have them."""
        for source, at in [(value, place)] if isinstance(value, dict) else _listed(value, place):
            if not isinstance(source, dict):
                message = "has a merge key (<<) that is no mapping. Give an alias of one, as in <<: *name."
                raise refusal(message, self.file, self.lines[place], place[:-1])
            for key in source.keys() - values.keys():
                values[key] = self._copied(source[key], (*at, key), (*place[:-1], key), self.lines[place])

    def _copied(self, data: Any, old: Path, new: Path, line: int) -> Any:
        self.copied += 1
        if self.copied > MOST:
            raise self._too_many(line, new)
        refuse_deep(len(new), self.file, line, new)
        self.lines[new] = self.lines.get(old, line)
        if isinstance(data, dict):
            return {key: self._copied(value, (*old, key), (*new, key), line) for key, value in data.items()}
        if isinstance(data, list):
            return [self._copied(value, (*old, n), (*new, n), line) for n, value in enumerate(data)]
        return data

    def _too_many(self, line: int, path: Path) -> ModelError:
        message = f"copies more than {MOST} entries by its aliases (*). Build such a model in Python."
        return refusal(message, self.file, line, path[:2])


def _listed(value: Any, place: Path) -> list[tuple[Any, Path]]:
    if not isinstance(value, list) or not value:
        return [(None, place)]
    return [(source, (*place, n)) for n, source in enumerate(value)]
