"""Refuse retired words in the documentation, and in the sources.

    python -m tests.language [FOLDER ...]      # without a folder: all of CLEAN; exit code 1 if a retired word is found

A word is retired where the field has a standard term for what it meant; see docs/glossary.md. Words are searched for in
prose and in the parts of identifiers (`stored_events` contains `kept`).
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SUFFIXES = {".md", ".py"}
GENERATED = {"_build", "api"}

# retired word or phrase, as a regular expression of whole words: what to write instead
RETIRED = {
    "told|tell|tells|telling": "message, report, output, summary, or the quantity itself",
    "say|says|said|saying": "the message is, the user's model, contains, gives",
    "sentences?": "message",
    "stands": "is, is stored in, is defined in, appears in",
    "what (?:a person|people) (?:says?|writes?|wrote)": "the user's model, user input",
    "wishes|wish": "options, request",
    "troubles?": "failure, failure diagnosis",
    "happened": "event record",
    "begun": "initial state, initialization",
    "march": "time integration loop",
    "loft": "surface from slices",
    "mended|mend|repaired": "fixed",
    "rooms?": "buffer, workspace array",
    "travels?": "displacement",
    "turns": "revolutions, winding number; rotates",
    "kept|keep steps": "stored, cached; store_steps",
    "ways of assembly": "assembly modes",
    "singular positions?": "singular configurations",
    "dependent rows": "redundant constraints",
    "numbers of the model|numbers of a model|model s numbers|design numbers": "parameters",
    "as the tolerances ask": "to meet the tolerances",
}

# what must have no retired word
CLEAN = ("README.md", "CONTRIBUTING.md", "docs", "src")

# expressions that may contain a retired word: the only exceptions
ALLOWED = {
    "-march=native": "an option of gcc",
    "exudyn_told.py": "a file of the benchmarks",
    'state["told"]': "a key of the format of saved runs",
    ')["told"]': "a key of the format of saved runs",
    '"told": np.array': "a key of the format of saved runs",
    '"kept_': "a prefix of keys of the format of saved runs",
    '"Happened": ': "a withdrawn name",
    '"kept": ': "a withdrawn name",
    '"sentence": ': "a withdrawn name",
    "test_E11_the_angle_turns_with_the_relative_angular_velocity": "a test",
}

PATTERNS = {re.compile(rf"(?<![a-z])(?:{words})(?![a-z])"): instead for words, instead in RETIRED.items()}


def words_of(line: str) -> str:
    """A line in lower case, with identifiers split into their words, and letters and spaces only."""
    split = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", line)
    return re.sub(r"[^a-z]+", " ", split.lower())


def retired(content: str) -> Iterator[tuple[int, str, str]]:
    """Line number, word and replacement of every retired word of a text."""
    for number, line in enumerate(content.splitlines(), start=1):
        for expression in ALLOWED:
            line = line.replace(expression, "")
        text = words_of(line)
        for pattern, instead in PATTERNS.items():
            if hit := pattern.search(text):
                yield number, hit.group(), instead


def files(names: tuple[str, ...]) -> Iterator[Path]:
    """The files of the given folders and files."""
    for name in names:
        path = ROOT / name
        inside = sorted(path.rglob("*")) if path.is_dir() else [path]
        yield from (file for file in inside if file.suffix in SUFFIXES and not _left_out(file))


def _left_out(file: Path) -> bool:
    """Whether a file is generated."""
    return bool(GENERATED & set(file.parts))


def main(names: list[str]) -> int:
    count = 0
    for path in files(tuple(names) or CLEAN):
        for number, word, instead in retired(path.read_text(encoding="utf-8")):
            count += 1
            print(f'{path.relative_to(ROOT)}:{number}: "{word}" is retired. Write: {instead}.')
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
