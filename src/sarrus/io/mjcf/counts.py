"""Limits on the size of an MJCF file, checked before MuJoCo's compiler, which cannot be interrupted and may hang."""

from __future__ import annotations

from math import prod
from pathlib import Path
from xml.parsers import expat

from ...model.errors import ModelError
from ...model.file.text.source import read_bytes

MOST = 20_000  # elements, those those in <replicate> counted as often as they are repeated
MOST_CELLS = 25_000_000  # of a texture or a height field
DEEPEST = 16  # files within files
COUNTS = {"replicate": "count", "composite": "count", "flexcomp": "count"}
CELLS = {"texture": ("width", "height"), "hfield": ("nrow", "ncol")}
FILES = ("include", "model")  # elements that name another file


def check_counts(path: Path) -> None:
    """Raise a ModelError for a file that asks for more than MuJoCo can make in seconds."""
    _Counter(path, path.parent, 1, 0).read()


class _Counter:
    """Counts the elements of a file and of those that it includes, each times the repetitions around it."""

    def __init__(self, file: Path, folder: Path, times: int, depth: int) -> None:
        self.file, self.folder, self.depth = file, folder, depth
        self.count = 0
        self.times = [times]
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = lambda tag: self.times.pop()
        self.parser.StartDoctypeDeclHandler = self._doctype

    def read(self) -> int:
        """Return the count; MuJoCo reports what is not XML."""
        try:
            self.parser.Parse(read_bytes(self.file), True)
        except (expat.ExpatError, LookupError):
            return self.count
        return self.count

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.times.append(self.times[-1] * _product(attributes.get(COUNTS.get(tag, ""), "1")))
        self.count += self.times[-1]
        if tag in FILES and (self.folder / attributes.get("file", "")).is_file():
            self._other(self.folder / attributes["file"])
        if tag == "connect" and "anchor" in attributes and len(attributes["anchor"].split()) != 3:
            anchor = attributes["anchor"]
            message = f'`anchor` of <connect> must be three numbers, got "{anchor}". Give the point in body1.'
            raise ModelError(
                message, part="file", where=self._place()
            )  # MuJoCo reads on beyond its end, and may hang
        if self.count > MOST:
            raise self._refusal(f"asks for more than {MOST:,} elements, with those that <replicate> repeats")
        if tag in CELLS and _product(*(attributes.get(name, "1") for name in CELLS[tag])) > MOST_CELLS:
            raise self._refusal(f"asks for a {tag} of more than {MOST_CELLS:,} cells")

    def _other(self, file: Path) -> None:
        if self.depth == DEEPEST:
            raise self._refusal(f"includes more than {DEEPEST} levels of files")
        self.count += _Counter(file, self.folder, self.times[-1], self.depth + 1).read()

    def _doctype(self, *declared: object) -> None:
        raise self._refusal("declares a document type, which could define entities")

    def _refusal(self, message: str) -> ModelError:
        message = f"{message}. Take it out, or make the file smaller."
        return ModelError(message, part="file", where=self._place())

    def _place(self) -> str:
        return f"{self.file}:{self.parser.CurrentLineNumber}"


def _product(*texts: str) -> int:
    """The product of whole numbers; other words are left to MuJoCo."""
    return prod(int(word) for text in texts for word in text.split() if word.isdecimal() and len(word) < 19)
