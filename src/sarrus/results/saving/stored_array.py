"""An array on disk: a folder of chunks in the Zarr format, each with a checksum that is stored elsewhere, by its place.

Chunks are written whole and once, uncompressed and little-endian, a file for each range of rows. Checksums and the
rows that do not fill a chunk are handed to whoever stores them, a checkpoint, which limits the valid part.
A chunk that is damaged, missing, older or from another place or run does not have the checksum of its place.
"""

from __future__ import annotations

import json
import operator
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from ...algebra import Array
from .checked_file import SIZE, SavedDataError, checksum, damaged, flush_to_disk, read_file

METADATA = "zarr.json"
NUMBER = np.dtype("<f8")


def create(folder: Path, rows: int, columns: tuple[int, ...], chunk: int, axes: tuple[str, ...]) -> None:
    """Make the folder of an array (rows, *columns) of which nothing is written yet.

    Its description is for other readers of Zarr, so that it is not waited for until it is on the disk.

    Parameters
    ----------
    chunk : rows of a chunk
    axes : name of each axis
    """
    folder.mkdir(exist_ok=True)
    about = {
        "zarr_format": 3,
        "node_type": "array",
        "shape": [rows, *columns],
        "data_type": "float64",
        "chunk_grid": {
            "name": "regular",
            "configuration": {"chunk_shape": [chunk, *(max(n, 1) for n in columns)]},
        },
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": "NaN",
        "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}],
        "dimension_names": list(axes),
        "attributes": {},
    }
    (folder / METADATA).write_text(json.dumps(about))


class StoredArray(NDArrayOperatorsMixin):
    """A stored array: chunks on disk and the rows after them, read as far as it is indexed; else it acts as an array.

    Parameters
    ----------
    folder : of the array
    chunk : rows of a chunk
    state : what `ArrayWriter.state` gave

    Attributes
    ----------
    shape : as an array's

    Raises
    ------
    SavedDataError
        Where what is indexed is damaged.
    """

    def __init__(self, folder: Path, chunk: int, state: Mapping[str, Array]) -> None:
        name = folder.name
        self._folder, self._chunk = folder, chunk
        self._rows, self._rest = int(state[f"{name}_rows"]), state[f"{name}_rest"]
        self._checksums = state[f"{name}_checksums"]
        self._last: tuple[int, Array] | None = None
        self.shape = (self._rows + len(self._rest), *self._rest.shape[1:])
        self.dtype, self.ndim = np.dtype(float), self._rest.ndim

    def __len__(self) -> int:
        return int(self.shape[0])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.asarray(self[:], dtype=dtype)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        arrays = (x[:] if isinstance(x, StoredArray) else x for x in inputs)
        return getattr(ufunc, method)(*arrays, **options)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name, name=name, obj=self)
        return getattr(self[:], name)

    def __getitem__(self, key: Any) -> Any:
        """Rows (and columns) as arrays."""
        row, *columns = key if isinstance(key, tuple) else (key,)
        if isinstance(row, slice):
            first, last, step = row.indices(len(self))
            if step < 1:
                return self[:][key]
            return self._between(first, last)[(slice(None, None, step), *columns)]
        try:
            at = operator.index(row)
        except TypeError:  # several rows, an ellipsis, a new axis; or what NumPy refuses, too
            return self[:][key]
        at += len(self) if at < 0 else 0
        if not 0 <= at < len(self):
            raise IndexError(f"there is no row {row}. There are {len(self)}")
        one = self._between(at, at + 1)[0]
        return np.asarray(one)[tuple(columns)] if columns else np.asarray(one)[()]

    def _between(self, first: int, last: int) -> Array:
        """Rows from one to before another."""
        stored, n = min(last, self._rows), self._chunk
        places = range(first // n, -(-stored // n)) if first < stored else range(0)
        parts = [self._read(k)[max(first - k * n, 0) : stored - k * n] for k in places]
        rest = self._rest[max(first - self._rows, 0) : max(last - self._rows, 0)]
        return np.concatenate([*parts, rest])

    def _read(self, place: int) -> Array:
        """A chunk that has the checksum of its place; the last one that was read is not read again."""
        last = self._last  # another thread may replace it
        if last is None or last[0] != place:
            path = self._path(place)
            data = read_file(path)
            if checksum(data) != self._checksums[place].tobytes():
                raise damaged(path)
            rows = np.frombuffer(data, NUMBER).reshape(self._chunk, *self._rest.shape[1:])
            self._last = last = place, rows.astype(float, copy=False)
        return last[1]

    def _path(self, place: int) -> Path:
        return chunk_path(self._folder, place, self.ndim)

    def check_presence(self) -> None:
        """Look whether the files of all chunks are there and have their length.

        Raises
        ------
        SavedDataError
        """
        size = NUMBER.itemsize * self._chunk * int(np.prod(self.shape[1:], dtype=int))
        for path in map(self._path, range(len(self._checksums))):
            try:
                found = path.stat().st_size
            except OSError:
                found = -1
            if found != size:
                message = "is missing" if found < 0 else f"has {found} bytes in place of {size}"
                raise SavedDataError(f"{path}: {message}. Restore it from a copy, or compute it anew.")

    def check(self) -> None:
        """Read all chunks; errors as of indexing."""
        for place in range(len(self._checksums)):
            self._read(place)
        self._last = None


class ArrayWriter:
    """An array that is being written.

    Parameters
    ----------
    folder : of the array
    chunk : rows of a chunk
    rest : (n, ...) rows that do not fill a chunk
    rows : how many rows are on disk
    checksums : (number of chunks, SIZE) theirs, as bytes
    """

    def __init__(self, folder: Path, chunk: int, rest: Array, rows: int = 0, checksums: Any = ()) -> None:
        self._folder, self._chunk, self.rows = folder, chunk, rows
        self._rest, self._count = [rest], len(rest)
        self._checksums = [bytes(one) for one in checksums]
        self._unflushed: list[Path] = []

    @classmethod
    def reopen(cls, folder: Path, chunk: int, state: Mapping[str, Array]) -> ArrayWriter:
        """Go on from a state."""
        name = folder.name
        rows, checksums = int(state[f"{name}_rows"]), state[f"{name}_checksums"]
        return cls(folder, chunk, state[f"{name}_rest"], rows, checksums)

    def append(self, rows: Array) -> None:
        """Take rows; whole chunks go to disk.

        Raises
        ------
        OSError
            If they cannot be written.
        """
        self._rest.append(rows)
        self._count += len(rows)
        if self._count >= self._chunk:
            self._write(self._count // self._chunk * self._chunk)

    def finish(self) -> None:
        """Write what does not fill a chunk, too; nothing can be appended after it."""
        self._write(self._count)

    def _write(self, count: int) -> None:
        """Write rows; an array without columns has no chunks."""
        rest = self._joined()
        if 0 in rest.shape[1:]:
            return
        for first in range(0, count, self._chunk):
            self._write_chunk(rest[first : min(first + self._chunk, count)])
        self._rest, self._count = [rest[count:].copy()], len(rest) - count
        self.rows += count

    def _write_chunk(self, rows: Array) -> None:
        whole = np.full((self._chunk, *rows.shape[1:]), np.nan, NUMBER)
        whole[: len(rows)] = rows
        data = whole.tobytes()
        path = chunk_path(self._folder, len(self._checksums), rows.ndim)
        with path.open("wb") as file:
            file.write(data)
        self._unflushed.append(path)
        self._checksums.append(checksum(data))

    def _joined(self) -> Array:
        if len(self._rest) > 1:
            self._rest = [np.concatenate(self._rest)]
        return self._rest[0]

    def flush(self) -> None:
        """Wait until all chunks are on the disk.

        Raises
        ------
        OSError
            If they cannot be written.
        """
        for path in self._unflushed:
            flush_to_disk(path)
        if self._unflushed:
            flush_to_disk(self._folder)
        self._unflushed.clear()

    def state(self) -> dict[str, Array]:
        """Checksums of the chunks, and the rows behind them."""
        name = self._folder.name
        checksums = np.frombuffer(b"".join(self._checksums), np.uint8).reshape(-1, SIZE)
        return {
            f"{name}_rows": np.array(self.rows),
            f"{name}_rest": self._joined(),
            f"{name}_checksums": checksums,
        }


def chunk_path(folder: Path, place: int, axes: int) -> Path:
    """The file of a chunk in an array with so many axes, all but the first of which are whole."""
    return folder / ".".join(["c", str(place), *["0"] * (axes - 1)])


def chunks(folder: Path) -> Iterator[Path]:
    """The files of a folder that are named as chunks."""
    for path in [*folder.glob("c.*")]:
        if re.fullmatch(r"c(\.\d+)+", path.name) and path.is_file():
            yield path
