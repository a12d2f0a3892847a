"""The results of a study on disk: one line for each case, written as they come, readable after a crash at any moment.

A folder holds ``study.json``, what was studied, and ``cases.jsonl``. Lines are only ever added. Each has a checksum of
itself and of all before it, so that lines that are changed, lost, moved or from another study are found; a last line
that a crash cut off is dropped, and its case is run again.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..model import SarrusError
from ..results.saving.checked_file import (
    DRAFT,
    FolderTakenError,
    NoSavedDataError,
    SavedDataError,
    checksum,
    damaged,
    read_file,
    replace_file,
    writing,
)
from ..results.saving.folder_lock import LOCK, FolderLock, held, is_lock, lock_folder
from .case import Outcome

STUDY, CASES = "study.json", "cases.jsonl"
STARTED = {LOCK, CASES, STUDY + DRAFT}  # the files of a study before its description is stored
FORMAT = 2
SAME = ("model", "parameters", "sample", "analysis", "responses", "cases")  # what makes a study the same one
CHECKSUM = ', "checksum": "'  # in a line, before the last entry
PAUSE = 1.0  # s between two times at which lines are flushed to the disk


class Ledger:
    """The folder of one study, open for more results of this process alone.

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
        If the folder holds another study or other files, if it is damaged, or if another process writes it.
    NotSavedError
        If it cannot be written.
    """

    def __init__(self, folder: Path, facts: Mapping[str, Any], files: Mapping[str, str]) -> None:
        self.folder, self.found, self._flushed = folder, dict[int, Outcome](), 0.0
        with writing(folder):
            self._lock = _locked(folder)
            with held(self._lock):
                self._open(facts, files)

    def _open(self, facts: Mapping[str, Any], files: Mapping[str, str]) -> None:
        place = self.folder / CASES
        if (self.folder / STUDY).exists():
            stored = read_study(self.folder)
            _refuse_other(self.folder, stored, facts)
        else:
            stored = json.loads(json.dumps(facts))
            place.touch()
            whole = {"format": FORMAT, "checksum": _checksum_of(stored), **stored}
            replace_file(
                self.folder / STUDY, (json.dumps(whole, indent=1, ensure_ascii=False) + "\n").encode()
            )
        _copy(files, self.folder / "model")
        self.found, self._last, end = _read(self.folder, stored)
        self._file = place.open("r+b")
        self._file.truncate(end)
        self._file.seek(end)

    def write(self, case: int, outcome: Outcome) -> None:
        """Add a line; it survives the end of this process at once, and that of the machine within moments.

        Raises
        ------
        NotSavedError
            If it cannot be written.
        """
        self.found[case] = outcome
        entry = {"case": case, **outcome._asdict()}
        entry["responses"] = [x if np.isfinite(x) else None for x in outcome.responses]
        text = json.dumps(entry, ensure_ascii=False)
        self._last = _chained(self._last, text)
        with writing(self.folder):
            self._file.write(f'{text[:-1]}{CHECKSUM}{self._last}"}}\n'.encode())
            self._file.flush()
            if time.monotonic() > self._flushed + PAUSE:
                self._flush()

    def _flush(self) -> None:
        os.fsync(self._file.fileno())
        self._flushed = time.monotonic()

    def close(self) -> None:
        """Hand everything to the disk, and let others write."""
        with suppress(OSError):  # what is not on the disk yet is found missing, and computed again
            self._file.flush()
            self._flush()
        with suppress(OSError):
            self._file.close()
        self._lock.release()


def read_study(folder: Path) -> dict[str, Any]:
    """Return the description of a study.

    Raises
    ------
    SarrusError
        If the folder holds no study, or one that is damaged or in another format.
    """
    place = folder / STUDY
    try:
        facts: dict[str, Any] = json.loads(read_file(place))
        written, version = facts.pop("checksum", None), facts.pop("format", None)
    except NoSavedDataError:
        message = f"{folder}: holds no study, for it has no readable {STUDY}. Check the path."
        raise NoSavedDataError(f"{message} Give the folder of a study.") from None
    except (ValueError, AttributeError, TypeError) as wrong:
        raise wrong if isinstance(wrong, SarrusError) else damaged(place) from None
    if version != FORMAT:
        message = f"{place}: is in format {version}, and this version of Sarrus reads format {FORMAT}."
        raise SavedDataError(
            f"{message} Open it with the version that wrote it, or study into another folder."
        )
    if written != _checksum_of(facts):
        raise damaged(place)
    return facts


def read_cases(folder: Path, facts: Mapping[str, Any]) -> list[tuple[int, Outcome]]:
    """The cases that are done; a case that was run again counts with its last line.

    Parameters
    ----------
    facts : what was studied, as stored

    Raises
    ------
    SarrusError
        If a line is damaged.
    """
    return sorted(_read(folder, facts)[0].items())


def _read(folder: Path, facts: Mapping[str, Any]) -> tuple[dict[int, Outcome], str, int]:
    """Outcomes by case, the checksum of the last line, and where it ends; what a crash cut off is left out."""
    place = folder / CASES
    outcomes, last, end = dict[int, Outcome](), _checksum_of(facts), 0
    for number, line in enumerate(read_file(place).split(b"\n")[:-1], start=1):
        end += len(line) + 1
        if not line.strip():
            continue
        text, _, written = line.decode(errors="replace").rpartition(CHECKSUM)
        last = _chained(last, text + "}")
        if written != f'{last}"}}':
            message = f"{place}:{number}: is damaged: its checksum is wrong. Restore the file from a copy, or delete"
            raise SavedDataError(f"{message} this line and all below it: their cases are run again.")
        case, outcome = _outcome(json.loads(text + "}"))
        outcomes[case] = outcome
    return outcomes, last, end


def _outcome(entry: Mapping[str, Any]) -> tuple[int, Outcome]:
    numbers = tuple(np.nan if x is None else float(x) for x in entry["responses"])
    warned = tuple(entry["warnings"])
    return int(entry["case"]), Outcome(entry["success"], entry["message"], numbers, entry["seconds"], warned)


def _chained(last: str, text: str) -> str:
    """The checksum of a line and of all before it."""
    return checksum((last + text).encode()).hex()


def _checksum_of(facts: Mapping[str, Any]) -> str:
    return checksum(json.dumps(facts, sort_keys=True).encode()).hex()


def _locked(folder: Path) -> FolderLock:
    """The right to write the folder of a study, which is made if it is not there."""
    if (folder / STUDY).exists():
        read_study(folder)
    elif folder.is_dir() and not _is_started(folder):
        message = f"{folder}: holds other files and no study, so it is not touched."
        raise FolderTakenError(f"{message} Choose another folder, or an empty one.")
    return lock_folder(folder)


def _is_started(folder: Path) -> bool:
    """Whether a folder is empty, or that of a study of which nothing is stored yet."""
    names = {place.name for place in folder.iterdir()}
    if not names <= STARTED or (LOCK in names and not is_lock(folder / LOCK)):
        return False
    return CASES not in names or not (folder / CASES).stat().st_size


def _refuse_other(folder: Path, stored: Mapping[str, Any], facts: Mapping[str, Any]) -> None:
    here = json.loads(json.dumps(facts))
    for name in SAME:
        if stored.get(name) != here[name]:
            raise SarrusError(
                f"{folder}: holds a study with another {name}. Choose another folder, or remove it."
            )


def _copy(files: Mapping[str, str], folder: Path) -> None:
    """Put the model's files beside the results, for people."""
    for name, text in files.items():
        copy = folder / name
        if not copy.exists():
            copy.parent.mkdir(parents=True, exist_ok=True)
            replace_file(copy, text.encode())
