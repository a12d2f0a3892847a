"""Runs on disk: written while they go on, readable after any end, opened without reading them into memory.

A run is a folder in the Zarr format (version 3): every array by chunks, a file for each, with the names of its axes;
what it is about in its attributes. Whole chunks are written once and never touched again. What does not yet fill a
chunk lies with the state of the method in one more file, `checkpoint.npz`, that is replaced in one step: it says how
far all else is valid.
"""

from __future__ import annotations

import os
import pickle
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ..algebra import Array

FORMAT = 1
BYTES = 1_000_000  # of a chunk of the widest array, about
STEPS, MANY = 4096, 2**40  # rows of a chunk of the history; the rows that it may have
COLUMNS = {
    "q": "coordinate",
    "v": "coordinate",
    "a": "coordinate",
    "lam": "equation",
    "violation": "kind_of_violation",
    "energy": "kind_of_energy",
}
CHECKPOINT, RECIPE = "checkpoint.npz", "recipe.pickle"


def _zarr() -> Any:
    try:
        import zarr
    except ImportError:
        raise ImportError("saving runs needs zarr; install it with: pip install 'sarrus[save]'") from None
    return zarr


class Store:
    """The folder of one run, open for writing.

    Attributes
    ----------
    rows, steps : states and steps written
    """

    def __init__(self, path: Path, group: Any) -> None:
        self.path, self._group = path, group
        self._chunk = int(group["t"].chunks[0])
        self.rows, self.steps = 0, 0
        self._pending: list[list[Array]] = []
        self._history: list[Array] = []

    @classmethod
    def create(
        cls, path: str | os.PathLike[str], times: Array, system: Any, about: Mapping[str, Any], recipe: Any
    ) -> Store:
        """A new folder.

        Raises
        ------
        FileExistsError
            If something is there that is not a run.
        """
        folder, zarr = Path(path), _zarr()
        if folder.exists() and not (folder / "zarr.json").exists():
            raise FileExistsError(f"{folder} is there and is no saved run; choose another name for save")
        (folder / CHECKPOINT).unlink(missing_ok=True)
        group = zarr.open_group(folder, mode="w", attributes={**_versions(), **about})
        n, widths = (
            len(times),
            {"q": system.nq, "v": system.nq, "a": system.nq, "lam": system.m, "violation": 2, "energy": 2},
        )
        chunk = int(max(1, min(n, BYTES // (8 * max(system.nq, 1)))))
        _array(zarr, group, "t", (n,), (chunk,), ("time",))
        for name, width in widths.items():
            _array(zarr, group, name, (n, width), (chunk, max(width, 1)), ("time", COLUMNS[name]))
        _array(zarr, group, "history", (MANY, 5), (STEPS, 5), ("step", "kind_of_number"))
        store = cls(folder, group)
        try:
            (folder / RECIPE).write_bytes(pickle.dumps(recipe))
        except (pickle.PicklingError, AttributeError, TypeError) as trouble:
            group.attrs["no_recipe"] = str(trouble)
        return store

    @classmethod
    def reopen(cls, path: str | os.PathLike[str]) -> tuple[Store, dict[str, Any]]:
        """A folder whose run was cut short, and its last checkpoint."""
        store = cls(Path(path), _zarr().open_group(Path(path), mode="r+"))
        state = checkpoint(store.path)
        store.rows, store.steps = int(state["rows"]), int(state["steps"])
        pending = [state[f"pending_{name}"] for name in ("t", *COLUMNS)]
        store._pending = [pending] if len(pending[0]) else []
        history = state["pending_history"]
        store._history = [history] if len(history) else []
        return store, state

    def write(self, samples: Any, history: Array) -> None:
        """Take states and steps; whole chunks go to disk."""
        if len(samples.t):
            self._pending.append([samples.t, *(getattr(samples, name) for name in COLUMNS)])
        if len(history):
            self._history.append(history)
        self._flush(whole=True)

    def _flush(self, whole: bool) -> None:
        columns = self._joined()
        ready = len(columns[0]) // self._chunk * self._chunk if whole else len(columns[0])
        if ready:
            for name, column in zip(("t", *COLUMNS), columns, strict=True):
                self._group[name][self.rows : self.rows + ready] = column[:ready]
            self.rows += ready
            self._pending = [[column[ready:] for column in columns]]
        history = np.concatenate([np.zeros((0, 5)), *self._history])
        ready = len(history) // STEPS * STEPS if whole else len(history)
        if ready:
            self._group["history"][self.steps : self.steps + ready] = history[:ready]
            self.steps += ready
            self._history = [history[ready:]]

    def _joined(self) -> list[Array]:
        if not self._pending:
            return [np.zeros((0, *self._group[name].shape[1:])) for name in ("t", *COLUMNS)]
        joined = [np.concatenate(parts) for parts in zip(*self._pending, strict=True)]
        self._pending = [joined]
        return joined

    def mark(self, state: Mapping[str, Any]) -> None:
        """Replace the checkpoint: all that was taken so far is now safe."""
        pending = {f"pending_{n}": x for n, x in zip(("t", *COLUMNS), self._joined(), strict=True)}
        history = np.concatenate([np.zeros((0, 5)), *self._history])
        self._replace(
            {"rows": self.rows, "steps": self.steps, "pending_history": history, **pending, **state}
        )

    def retell(self, told: str) -> None:
        """Let the last checkpoint tell something else, a JSON text; all else of it stays."""
        self._replace({**checkpoint(self.path), "told": np.array(told)})

    def _replace(self, numbers: Mapping[str, Any]) -> None:
        draft = self.path / f"{CHECKPOINT}.draft"
        with draft.open("wb") as file:
            np.savez(file, **numbers)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(self.path / CHECKPOINT)

    def finish(self, state: Mapping[str, Any]) -> None:
        """Write what is left, and mark the end."""
        self._flush(whole=False)
        self.mark(state)


def checkpoint(path: Path) -> dict[str, Any]:
    """The last checkpoint of a run.

    Raises
    ------
    FileNotFoundError
        If there is none: the run was cut short before its first, or this is no run.
    """
    file = path / CHECKPOINT
    if not file.exists():
        raise FileNotFoundError(
            f"{path} holds no checkpoint of a run; it was stopped before its first, or is no run"
        )
    with np.load(file, allow_pickle=False) as found:
        return {name: found[name] for name in found.files}


def recipe_of(path: Path) -> Any:
    """Model, start and options of a run, as given. Opening it runs code of the file: trust where it comes from.

    Raises
    ------
    ValueError
        If it could not be stored.
    """
    file = path / RECIPE
    if not file.exists():
        reason = _zarr().open_group(path, mode="r").attrs.get("no_recipe", "the file is missing")
        raise ValueError(
            f"{path} does not hold its model and options ({reason}): functions must be defined in a module, "
            "not as lambda"
        )
    return pickle.loads(file.read_bytes())


def arrays_of(path: Path) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """Attributes, arrays that are read where they are asked for, and the last checkpoint."""
    state, group = checkpoint(path), _zarr().open_group(path, mode="r")
    names = ("t", *COLUMNS)
    arrays = {name: Lazy(group[name], int(state["rows"]), state[f"pending_{name}"]) for name in names}
    arrays["history"] = Lazy(group["history"], int(state["steps"]), state["pending_history"])
    return dict(group.attrs), arrays, state


class Lazy:
    """An array on disk and the rows behind it; what is indexed is read. ``np.asarray`` reads all.

    Attributes
    ----------
    shape : as an array's
    """

    def __init__(self, stored: Any, rows: int, rest: Array) -> None:
        self._stored, self._rows, self._rest = stored, rows, rest
        self.shape = (rows + len(rest), *rest.shape[1:])

    def __len__(self) -> int:
        return int(self.shape[0])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.asarray(self[:], dtype=dtype)

    def __getitem__(self, key: Any) -> Any:
        """Rows (and columns) as arrays."""
        row, *columns = key if isinstance(key, tuple) else (key,)
        if isinstance(row, slice):
            first, last, step = row.indices(len(self))
            if step < 1:
                return self[:][key]
            there = self._stored[first : min(last, self._rows)] if first < self._rows else self._rest[:0]
            behind = self._rest[max(first - self._rows, 0) : max(last - self._rows, 0)]
            found = np.concatenate([there, behind])
            return found[(slice(None, None, step), *columns)]
        if np.ndim(row) > 0:
            return self[:][key]
        at = int(row) + (len(self) if row < 0 else 0)
        one = self._stored[at] if at < self._rows else self._rest[at - self._rows]
        return np.asarray(one)[tuple(columns)] if columns else np.asarray(one)[()]


def _array(
    zarr: Any, group: Any, name: str, shape: tuple[int, ...], chunks: tuple[int, ...], axes: tuple[str, ...]
) -> None:
    group.create_array(name, shape=shape, chunks=chunks, dtype="f8", fill_value=np.nan, dimension_names=axes,
                       compressors=None)  # fmt: skip


def _versions() -> dict[str, Any]:
    names = ("sarrus", "numpy", "numba", "scipy")
    return {"format": FORMAT, "python": platform.python_version(), **{n: _version(n) for n in names}}


def _version(name: str) -> str:
    try:
        return version(name)
    except ImportError:
        return "unknown"
