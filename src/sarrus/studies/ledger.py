"""The results of a study on disk: one line for each case, written as they come, readable after a crash at any moment.

A folder holds ``study.json``, what was studied, and ``cases.jsonl``. Lines are only ever added; a last line that a
crash cut off is dropped.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..model import SarrusError
from .case import Outcome

STUDY, CASES = "study.json", "cases.jsonl"
SAME = ("model", "parameters", "sample", "analysis", "responses", "cases")  # what makes a study the same one


class Ledger:
    """The folder of one study, open for more results.

    Parameters
    ----------
    folder : made if it is not there
    facts : what is studied, in plain values
    files : files of the model, by name: copied beside the results

    Attributes
    ----------
    found : outcomes of the cases that are done, by case

    Raises
    ------
    SarrusError
        If the folder holds another study.
    """

    def __init__(self, folder: Path, facts: Mapping[str, Any], files: Mapping[str, str]) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except (FileExistsError, NotADirectoryError):
            raise SarrusError(f"{folder}: is a file, not a folder; choose another folder") from None
        self._begin(facts, files)
        self.found = dict(read_cases(folder))
        self._file = (folder / CASES).open("ab")

    def _begin(self, facts: Mapping[str, Any], files: Mapping[str, str]) -> None:
        place = self.folder / STUDY
        if place.exists():
            _refuse_other(self.folder, read_study(self.folder), facts)
            _drop_torn_line(self.folder / CASES)
            return
        for name, text in files.items():
            copy = self.folder / "model" / name
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_text(text, encoding="utf-8")
        _write_whole(place, json.dumps(facts, indent=1, ensure_ascii=False) + "\n")

    def write(self, case: int, outcome: Outcome) -> None:
        """Add a line; it survives the end of this process at once, and that of the machine within moments."""
        line = {"case": case, **outcome._asdict()}
        line["responses"] = [x if np.isfinite(x) else None for x in outcome.responses]
        self._file.write((json.dumps(line, ensure_ascii=False) + "\n").encode())
        self._file.flush()
        self.found[case] = outcome

    def close(self) -> None:
        """Hand everything to the disk."""
        os.fsync(self._file.fileno())
        self._file.close()


def read_study(folder: Path) -> dict[str, Any]:
    """What was studied.

    Raises
    ------
    SarrusError
        If the folder holds no study.
    """
    try:
        found: dict[str, Any] = json.loads((folder / STUDY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        raise SarrusError(f"{folder}: holds no study; there is no readable {STUDY} in it") from None
    return found


def read_cases(folder: Path) -> list[tuple[int, Outcome]]:
    """The cases that are done; a case that was run again counts with its last line."""
    place = folder / CASES
    lines = place.read_bytes().split(b"\n")[:-1] if place.exists() else []
    found = {}
    for line in lines:
        entry = json.loads(line)
        numbers = tuple(np.nan if x is None else float(x) for x in entry["responses"])
        warned = tuple(entry.get("warnings", ()))
        found[int(entry["case"])] = Outcome(
            entry["success"], entry["message"], numbers, entry["seconds"], warned
        )
    return sorted(found.items())


def _refuse_other(folder: Path, stored: Mapping[str, Any], facts: Mapping[str, Any]) -> None:
    here = json.loads(json.dumps(facts))
    for name in SAME:
        if stored.get(name) != here[name]:
            raise SarrusError(
                f"{folder}: holds a study with another {name}; choose another folder, or remove it"
            )


def _drop_torn_line(place: Path) -> None:
    """Cut off what a crash left of a line."""
    if not place.exists():
        return
    with place.open("rb+") as file:
        text = file.read()
        file.truncate(text.rfind(b"\n") + 1)


def _write_whole(place: Path, text: str) -> None:
    """Write a file so that it is there as a whole or not at all."""
    draft = place.with_suffix(".tmp")
    with draft.open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    draft.replace(place)
