"""YAML text to a document, straight from the parser's events.

The subset: one document of mappings, lists and scalars, with anchors, aliases and merge keys. Tags are refused, so no
Python object can be written; an alias is copied when it is met, and the copies are counted, so there is no cycle and no
bomb.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import yaml
from yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    StreamEndEvent,
)

from ...checks.findings import Origin, Path
from ...errors import ModelError
from ...show import quote, suggest
from .document import Document, refusal, refuse_deep, refuse_repeated, resolve

MERGE = "<<"
FAST: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # written in C: ten times as fast
TOO_DEEP = "nesting depth"
MOST_TWICE = 100_000  # characters of a text that is read again, for a better message
MOST = 500_000  # entries that aliases may copy


def read_yaml(text: str, file: str) -> Document:
    """Return the document of a YAML text.

    Raises
    ------
    ModelError
        If the text is not YAML, or not in the subset.
    """
    short = len(text) <= MOST_TWICE
    if short:
        with suppress(yaml.YAMLError):
            return _Reader(text, file, FAST).document()
    return _explained(text, file, yaml.SafeLoader if short else FAST)


def _explained(text: str, file: str, loader: Any) -> Document:
    """Read a text, with errors in our own words."""
    try:
        return _Reader(text, file, loader).document()
    except yaml.MarkedYAMLError as error:
        if (
            TOO_DEEP in str(error.problem) and loader is not yaml.SafeLoader
        ):  # newer versions of libyaml have a limit
            return _explained(text, file, yaml.SafeLoader)
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark else 1
        message = f"is not valid YAML, {error.problem or error.context}. {_remedy(text, line)}"
        raise refusal(message.replace("\n", " "), file, line) from None
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        message = "holds a control character that YAML does not allow. Remove it."
        raise refusal(message, file, line) from None


class _Reader:
    """Builds data from events and notes the line of each entry."""

    def __init__(self, text: str, file: str, loader: Any) -> None:
        self.file = file
        self.lines: dict[Path, int] = {}
        self.anchors = Anchors(file, self.lines)
        self.events: Iterator[Event] = yaml.parse(text, Loader=loader)

    def document(self) -> Document:
        next(self.events)
        if isinstance(next(self.events), StreamEndEvent):
            raise ModelError("is empty. Give at least a name and bodies.", where=self.file)
        data = self._value(next(self.events), ())
        next(self.events)
        self._refuse_second(next(self.events))
        return Document(data, Origin(self.file, self.lines))

    def _value(self, event: Event, path: Path) -> Any:
        line = _line(event)
        if isinstance(event, AliasEvent):
            return self.anchors.copy(str(event.anchor), path, line)
        self.lines.setdefault(path, line)
        refuse_deep(len(path), self.file, line, path)
        if type(event) is ScalarEvent and event.anchor is None and event.tag is None:
            return self._plain(event, path)
        self._refuse_tag(event, path)
        with self.anchors.named(getattr(event, "anchor", None), path) as anchored:
            anchored.data = self._plain(event, path)
        return anchored.data

    def _plain(self, event: Event, path: Path) -> Any:
        if isinstance(event, MappingStartEvent):
            return self._mapping(path)
        if isinstance(event, SequenceStartEvent):
            return self._sequence(path)
        assert isinstance(event, ScalarEvent)
        return resolve(event.value) if event.implicit[0] else event.value

    def _sequence(self, path: Path) -> list[Any]:
        values: list[Any] = []
        while not isinstance(event := next(self.events), SequenceEndEvent):
            values.append(self._value(event, (*path, len(values))))
        return values

    def _mapping(self, path: Path) -> dict[str, Any]:
        values: dict[str, Any] = {}
        merged: list[tuple[Any, Path]] = []
        while not isinstance(event := next(self.events), MappingEndEvent):
            key = self._key(event, path)
            refuse_repeated(key, self.lines.get((*path, key)), self.file, _line(event), path)
            self.lines[(*path, key)] = _line(event)
            value = self._value(next(self.events), (*path, key))
            if key == MERGE and isinstance(event, ScalarEvent) and event.implicit[0]:
                merged.append((value, (*path, key)))
            else:
                values[key] = value
        for value, place in merged:
            self.anchors.merge(value, place, values)
        return values

    def _key(self, event: Event, path: Path) -> str:
        if isinstance(event, AliasEvent):
            raise refusal("has an alias (*) as key. Write the key out.", self.file, _line(event), path)
        self._refuse_tag(event, path)
        if not isinstance(event, ScalarEvent):
            message = "has a key that is a list or a mapping. Use a plain word as key."
            raise refusal(message, self.file, _line(event), path)
        return str(event.value)

    def _refuse_tag(self, event: Event, path: Path) -> None:
        if getattr(event, "tag", None):
            message = "uses a tag (!), which a model file may not. Remove it."
            raise refusal(message, self.file, _line(event), path)

    def _refuse_second(self, event: Event) -> None:
        if isinstance(event, DocumentStartEvent):
            message = "a second document starts with ---. Keep one model in a file."
            raise refusal(message, self.file, _line(event))


def _remedy(text: str, line: int) -> str:
    near = text.splitlines()[max(line - 2, 0) : line]
    if any("${" in one for one in near):
        return "Inside brackets put ${…} in quotes or leave it away."
    return "Check indentation, brackets and quotes."


def _line(event: Event) -> int:
    mark = event.start_mark
    return mark.line + 1 if mark else 1


@dataclass
class AnchoredValue:
    """A value with its place; ``open`` while it is being read."""

    path: Path
    data: object = None
    open: bool = True


class Anchors:
    """The anchors of a file, and the lines of its entries, to which copies add theirs."""

    def __init__(self, file: str, lines: dict[Path, int]) -> None:
        self.file = file
        self.lines = lines
        self.known: dict[str, AnchoredValue] = {}
        self.copied = 0

    @contextmanager
    def named(self, name: str | None, path: Path) -> Iterator[AnchoredValue]:
        """Keep the value that is read inside, under the name of its anchor if it has one."""
        anchored = AnchoredValue(path)
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
