"""Runs on disk: written during the simulation, readable after any end, opened without reading all data.

A run is a folder in the Zarr format (version 3): every array by chunks, a file for each, with the names of its axes;
what it is about in its attributes. Whole chunks are written once and never touched again. What does not yet fill a
chunk is stored with the state of the method and the checksums of all chunks in one more file, the checkpoint, which is
replaced in one step when the chunks are on the disk: it limits how far all else is valid.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any
from uuid import uuid4

import numpy as np

from ...algebra import Array
from . import stored_array
from .checked_file import (
    DRAFT,
    FolderTakenError,
    NoSavedDataError,
    SavedDataError,
    checksum,
    damaged,
    read_checked,
    read_file,
    replace_file,
    write_checked,
    writing,
)
from .data_bytes import loads
from .folder_lock import LOCK, FolderLock, held, is_lock, lock_folder
from .stored_array import METADATA, ArrayWriter, StoredArray
from .versions import versions

FORMAT = 9
BYTES = 1_000_000  # of a chunk of the widest array, about
STEPS, MANY = 4096, 2**40  # rows of a chunk of the history; the rows that it may have
COLUMNS = {
    "q": "coordinate",
    "v": "coordinate",
    "a": "coordinate",
    "lam": "equation",
    "violation": "kind_of_violation",
    "energy": "kind_of_energy",
    "memory": "place",
    "revolutions": "joint_coordinate",
}
COUNTS = ("nfev", "njev", "nlu", "nsteps", "nrejected")  # of a trajectory
OVER_TIME, HISTORY = ("t", *COLUMNS), "history"
CHECKPOINT, RECIPE = "checkpoint.npz", "recipe.data"
# of a run before its metadata
INITIAL_FILES = frozenset((LOCK, RECIPE, RECIPE + DRAFT, METADATA + DRAFT, *OVER_TIME, HISTORY))
UNFINISHED = ("cut short", "stopped", "time limit")
STORED_STEPS = "method.store.t"  # in checkpoints of runs that store their steps


class Store:
    """The folder of one run, open for writing by this process alone.

    Parameters
    ----------
    folder : Path
    lock : of the folder
    about : the run's attributes
    arrays : by name
    """

    def __init__(
        self, folder: Path, lock: FolderLock, about: Mapping[str, Any], arrays: Mapping[str, ArrayWriter]
    ) -> None:
        self.path, self._lock, self._about, self._arrays = folder, lock, about, arrays

    @classmethod
    def create(
        cls,
        path: str | os.PathLike[str],
        times: Array,
        system: Any,
        about: Mapping[str, Any],
        recipe: bytes,
        *,
        overwrite: bool = False,
    ) -> Store:
        """A new folder, or one whose run was stopped before its first checkpoint.

        Parameters
        ----------
        recipe : model and options, see `data_bytes`
        overwrite : whether a run that is there is replaced

        Raises
        ------
        FolderTakenError
            If something is there that is not a run, a run and not `overwrite`, or another process writes it.
        NotSavedError
            If it cannot be written.
        """
        folder = Path(path)
        with writing(folder), held(_locked(folder)) as lock:
            if overwrite:
                (folder / CHECKPOINT).unlink(missing_ok=True)
                (folder / RECIPE).unlink(missing_ok=True)
            else:
                _refuse_run(folder)
            _clear(folder)
            return cls._begin(folder, lock, times, system, about, recipe)

    @classmethod
    def _begin(
        cls,
        folder: Path,
        lock: FolderLock,
        times: Array,
        system: Any,
        about: Mapping[str, Any],
        recipe: bytes,
    ) -> Store:
        """Write the recipe, then all that is known before the first state."""
        widths = dict.fromkeys("qva", system.nq) | {"lam": system.m, "violation": 2, "energy": 2}
        widths |= {"memory": len(system.memory_places), "revolutions": system.counted_coordinates.m}
        write_checked(folder / RECIPE, recipe)
        chunk = int(max(1, min(len(times), BYTES // (8 * max(system.nq, 1)))))
        attributes = {"format": FORMAT, "run": uuid4().hex, **versions(), **about, "chunk": chunk}
        attributes["recipe"] = checksum(recipe).hex()
        group = {"zarr_format": 3, "node_type": "group", "attributes": attributes}
        replace_file(folder / METADATA, json.dumps(group, indent=1).encode())
        stored_array.create(folder / "t", len(times), (), chunk, ("time",))
        for name, width in widths.items():
            stored_array.create(folder / name, len(times), (width,), chunk, ("time", COLUMNS[name]))
        stored_array.create(folder / HISTORY, MANY, (5,), STEPS, ("step", "kind_of_number"))
        empty = {"t": np.zeros(0), HISTORY: np.zeros((0, 5))}
        empty |= {name: np.zeros((0, width)) for name, width in widths.items()}
        arrays = {name: ArrayWriter(folder / name, _rows(name, chunk), rest) for name, rest in empty.items()}
        return cls(folder, lock, attributes, arrays)

    @classmethod
    def reopen(cls, path: str | os.PathLike[str]) -> tuple[Store, dict[str, Any]]:
        """A folder whose run was cut short, and its last checkpoint; all that it holds is verified.

        Raises
        ------
        SavedDataError
            If it is damaged.
        FolderTakenError
            If another process writes it.
        NotSavedError
            If it cannot be written.
        """
        folder = Path(path)
        with writing(folder), held(_locked(folder)) as lock:
            about, stored, state = arrays_of(folder)
            for array in stored.values():
                array.check()
            arrays = {
                name: ArrayWriter.reopen(folder / name, _rows(name, about["chunk"]), state) for name in stored
            }
            return cls(folder, lock, about, arrays), state

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, wrong: BaseException | None, at: TracebackType | None
    ) -> None:
        self._lock.release()

    def write(self, samples: Any, history: Array) -> None:
        """Take states and steps; whole chunks go to disk.

        Raises
        ------
        NotSavedError
            If they cannot be written, as for all that follows.
        """
        with writing(self.path):
            for name in OVER_TIME:
                self._arrays[name].append(getattr(samples, name))
            self._arrays[HISTORY].append(history)

    def mark(self, state: Mapping[str, Any]) -> None:
        """Replace the checkpoint when all chunks are on the disk: what was taken so far is now safe."""
        found: dict[str, Any] = dict(state)
        with writing(self.path):
            for array in self._arrays.values():
                array.flush()
                found |= array.state()
            self._replace(found)

    def replace_record(self, record: str) -> bool:
        """Replace the record of the last checkpoint, a JSON text, and nothing else. False if there is none."""
        if awaits_checkpoint(self.path):
            return False
        with writing(self.path):
            self._replace({**checkpoint(self.path), "told": np.array(record)})
        return True

    def warn(self, messages: Iterable[str]) -> None:
        """Add warnings to those of the last checkpoint."""
        with writing(self.path):
            record = json.loads(str(checkpoint(self.path)["told"]))
        record["warnings"] = list(dict.fromkeys((*record.get("warnings", ()), *messages)))
        self.replace_record(json.dumps(record))

    def _replace(self, numbers: Mapping[str, Any]) -> None:
        content = io.BytesIO()
        np.savez(content, **{**numbers, "about": _checksum_of(self._about)})
        write_checked(self.path / CHECKPOINT, content.getvalue())

    def finish(self, state: Mapping[str, Any]) -> None:
        """Write what is left, and mark the end."""
        with writing(self.path):
            for array in self._arrays.values():
                array.finish()
        self.mark(state)


def _rows(name: str, chunk: int) -> int:
    return STEPS if name == HISTORY else chunk


def _locked(folder: Path) -> FolderLock:
    """The right to write the folder of a run, which is made if it is not there."""
    if folder.exists() and not _is_ours(folder):
        message = f"{folder}: is there and is no saved run, so it is not touched."
        raise FolderTakenError(f"{message} Choose another name for `save`.")
    return lock_folder(folder)


def _is_ours(folder: Path) -> bool:
    """Whether a folder is empty, or that of a run, also of one that has just started."""
    if not folder.is_dir():
        return False
    names = {place.name for place in folder.iterdir()}
    if not names:
        return True
    if METADATA in names:
        return {"format", "sarrus"} <= set(_attributes(folder))
    checks = {LOCK: is_lock, RECIPE: _is_checked}
    return (
        names <= INITIAL_FILES
        and bool(found := names & set(checks))
        and all(checks[n](folder / n) for n in found)
    )


def _is_checked(path: Path) -> bool:
    try:
        read_checked(path)
    except SavedDataError:
        return False
    return True


def _refuse_run(folder: Path) -> None:
    """Refuse a folder that holds states."""
    if awaits_checkpoint(folder):
        return
    try:
        status = json.loads(str(checkpoint(folder)["told"]))["status"]
        held = "a run that was cut short" if status in UNFINISHED else "a finished run"
        verb = "Continue it with sarrus.resume" if status in UNFINISHED else "Open it with sarrus.load_run"
        remedy = f"{verb}({str(folder)!r}), or pass overwrite=True to sr.Save or run.save to replace it."
    except SavedDataError:
        held, remedy = "a damaged run", "Pass overwrite=True to sr.Save or run.save to replace it."
    raise FolderTakenError(f"{folder}: holds {held}. {remedy}")


def _clear(folder: Path) -> None:
    """Remove what an earlier run wrote, but its recipe, and nothing else."""
    for name in (CHECKPOINT, METADATA):
        (folder / name).unlink(missing_ok=True)
    for place in _chunks(folder):
        place.unlink()


def _chunks(folder: Path) -> Iterator[Path]:
    for name in (*OVER_TIME, HISTORY):
        yield from stored_array.chunks(folder / name)


def _checksum_of(about: Mapping[str, Any]) -> Any:
    return np.array(checksum(json.dumps(about, sort_keys=True).encode()).hex())


def checkpoint(folder: Path) -> dict[str, Any]:
    """The last checkpoint of a run.

    Raises
    ------
    NoSavedDataError
        If there is none: the run was stopped before its first, or this is no run.
    SavedDataError
        If it is damaged.
    """
    with np.load(io.BytesIO(read_checked(folder / CHECKPOINT)), allow_pickle=False) as found:
        return {name: found[name] for name in found.files}


def awaits_checkpoint(folder: Path) -> bool:
    """Whether a run was stopped before its first checkpoint, so that it can only be started anew."""
    return not (folder / CHECKPOINT).exists() and not any(_chunks(folder))


def recipe_of(folder: Path) -> dict[str, Any]:
    """Model and options of a run.

    Raises
    ------
    NoSavedDataError
        If there is no run.
    SavedDataError
        If it is damaged, or another version of Sarrus wrote it.
    """
    path = folder / RECIPE
    about = about_of(folder) if os.path.exists(folder / METADATA) or not os.path.exists(path) else {}
    if about and about["sarrus"] != versions()["sarrus"]:
        message = f"{folder}: was written by Sarrus {about['sarrus']}, and this is {versions()['sarrus']}."
        raise SavedDataError(
            f"{message} Open it with load_run, or install Sarrus {about['sarrus']} to continue or repeat it."
        )
    content = read_checked(path)
    if about and checksum(content).hex() != about.get("recipe"):
        raise SavedDataError(f"{path}: belongs to another run. Restore it from a copy, or simulate anew.")
    found: dict[str, Any] = loads(path, content, {}, str)
    return found


def about_of(folder: Path) -> dict[str, Any]:
    """The attributes of a run; errors as `arrays_of`."""
    if not os.path.exists(folder / METADATA):  # false, not an error, for names that no file can have
        message = "holds no saved run" if os.path.exists(folder) else "there is no such folder"
        raise NoSavedDataError(f"{folder}: {message}. Give the folder that was passed as `save`.")
    about = _attributes(folder)
    if "sarrus" not in about:
        raise damaged(folder / METADATA)
    if about.get("format") != FORMAT:
        message = f"{folder}: was written by Sarrus {about['sarrus']} in format {about.get('format')}"
        message += f", and Sarrus {versions()['sarrus']} reads format {FORMAT}."
        raise SavedDataError(f"{message} Open it with Sarrus {about['sarrus']}, or simulate anew.")
    return about


def _attributes(folder: Path) -> dict[str, Any]:
    """The metadata; nothing where they are damaged."""
    try:
        about = json.loads(read_file(folder / METADATA))["attributes"]
    except (ValueError, KeyError, TypeError):
        return {}
    return about if isinstance(about, dict) else {}


def arrays_of(folder: Path) -> tuple[dict[str, Any], dict[str, StoredArray], dict[str, Any]]:
    """Attributes, arrays that are read and verified where they are indexed, and the last checkpoint.

    Raises
    ------
    NoSavedDataError
        If there is no run, or none that came to its first checkpoint.
    SavedDataError
        If it is damaged, or in another format.
    """
    if os.path.exists(folder / RECIPE) and awaits_checkpoint(folder):
        message = f"{folder}: holds a run that was stopped before its first checkpoint."
        raise NoSavedDataError(f"{message} Begin it again with sarrus.resume({str(folder)!r}).")
    about, state = about_of(folder), checkpoint(folder)
    if state["about"] != _checksum_of(about):
        raise damaged(folder / METADATA)
    shown = _with_end(state)
    arrays = {
        name: StoredArray(folder / name, _rows(name, about["chunk"]), shown) for name in (*OVER_TIME, HISTORY)
    }
    for array in arrays.values():
        array.check_presence()
    return about, arrays, state


def _with_end(state: Mapping[str, Any]) -> Mapping[str, Any]:
    """A checkpoint with the state reached as the last output, where it is behind the others."""
    if "final_violation" not in state:
        return state
    rows = ((f"{n}_rest", np.concatenate([state[f"{n}_rest"], state[f"final_{n}"][None]])) for n in OVER_TIME)
    return {**state, **dict(rows)}


def other_versions(about: Mapping[str, Any]) -> list[str]:
    """A warning where a run was started with other versions of what numbers depend on."""
    here = versions()
    names = [name for name in ("python", "numpy", "numba", "scipy") if about.get(name) != here[name]]
    was, now = (", ".join(f"{name} {of.get(name)}" for name in names) for of in (about, here))
    message = (
        f"{about['name']}: started with {was}, resumed with {now}. The last digits may differ from one run."
    )
    return [message] if names else []
