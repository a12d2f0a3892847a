"""The entries of a study's or an optimization's file, read one by one; every error with file and line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..model import ModelError, SarrusError
from ..model.file.text.document import Document
from ..model.show import suggest


@dataclass(frozen=True)
class Entries:
    """The content of a file.

    Attributes
    ----------
    document : as it was read
    what : is described by it, "a study"
    kind : precedes the names of keys in errors, "study, "
    """

    document: Document
    what: str
    kind: str = ""

    def part(self, reader: Callable[[Any], Any], *path: str | int) -> Any:
        """What the reader makes of an entry; errors name the file and the line."""
        given: Any = self.document.data
        for step in path:
            given = given[step]
        try:
            return reader(given)
        except (SarrusError, ValueError) as wrong:
            where, part = self.document.origin.where(path), ".".join(map(str, path))
            raise ModelError(str(wrong), where=where, part=self.kind + part) from None

    def refused(self, message: str, *path: str | int) -> ModelError:
        """An error with the line of an entry, or the name of the file."""
        origin = self.document.origin
        return ModelError(message, where=origin.where(path) if path else origin.file)

    def check_keys(self, keys: Sequence[str], needed: Sequence[str]) -> None:
        """Refuse unknown and missing keys."""
        data: Any = self.document.data
        if not isinstance(data, dict):
            raise self.refused("the file is a mapping with the keys " + ", ".join(keys))
        for key in data:
            if key not in keys:
                raise self.refused(f"{self.what} has no key {key!r}; {suggest(str(key), keys)}", key)
        for key in needed:
            if key not in data:
                raise self.refused(f"the file lacks the key {key!r}; give it")

    def check_kind(self, key: str, kind: type, wanted: str) -> None:
        """Refuse an entry of another kind."""
        if key in self.document.data and not isinstance(self.document.data[key], kind):
            raise self.refused(f"{key} must be {wanted}", key)
