"""The output of a verb: lines for people, or with ``--json`` one object for programs."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

DPI = 150  # of figures

log = logging.getLogger("sarrus.cli")


class Answer:
    """The standard output of one verb.

    ``show`` is for people, ``put`` for programs; a verb does both, and one of them is heard.
    """

    def __init__(self, verb: str, *, as_json: bool = False) -> None:
        self.as_json = as_json
        self._facts: dict[str, Any] = {"verb": verb}
        self._files: list[str] = []
        self.warnings: list[str] = []
        self.notes: list[str] = []

    def show(self, text: object = "") -> None:
        """Print a line at once, unless the answer is JSON; a result without its warnings, which `warn` has."""
        if not self.as_json:
            print(text.summary() if hasattr(text, "summary") else text, flush=True)

    def put(self, **facts: Any) -> None:
        """Keep facts for the JSON object: plain values, arrays, and mappings and lists of them, in SI units."""
        self._facts |= facts

    def warn(self, message: str) -> bool:
        """Keep a warning; false if it is already there."""
        new = message not in self.warnings
        self.warnings += [message] * new
        return new

    def noted(self, model: Any) -> Any:
        """Record what the import of a model has left out or changed, and return the model."""
        for note in getattr(model, "notes", ()):
            if note not in (*self.warnings, *self.notes):
                self.notes.append(note)
                log.info("note: %s", note)
        return model

    def wrote(self, file: str | Path) -> None:
        """Record that a file was written."""
        self._files.append(str(file))
        log.info("wrote %s", file)

    def draw(self, figure: Any, file: Path) -> None:
        """Write a figure, and record its file."""
        from ..results.saving.exported_file import exporting

        with exporting(file) as draft:
            figure.savefig(draft, dpi=DPI, bbox_inches="tight")
        self.wrote(file)

    def close(self, code: int) -> None:
        """Print the JSON object, with the exit code and the files written."""
        if self.as_json:
            ending = {
                "success": code == 0,
                "exit_code": code,
                "warnings": self.warnings,
                "notes": self.notes,
                "files": self._files,
            }
            print(json.dumps(plain(self._facts | ending), ensure_ascii=False))


def named(model: str, message: str) -> str:
    """A message with the name of its model in front, which many have already."""
    return message if message.startswith(model) else f"{model}: {message}"


def plain(value: Any) -> Any:
    """A value as JSON has it: arrays as lists, complex numbers as pairs, what is no finite number as null."""
    if isinstance(value, str | bool) or value is None:
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if hasattr(value, "tolist"):  # an array or scalar of NumPy
        return plain(value.tolist())
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(entry) for entry in value]
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, int | float):
        return value if isfinite(value) else None
    return str(value)
