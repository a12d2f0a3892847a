"""Reading of the text of a model file, with one message if it cannot be read."""

from __future__ import annotations

import re
from itertools import islice
from os.path import exists  # false, not an error, for names that no file can have
from pathlib import Path

from ...errors import ModelError

LARGEST = 16 * 1024 * 1024  # bytes
MOST = 1_000_000  # entries
ENTRY = re.compile(r"^[ \t]*[^#\s]|,", re.MULTILINE)  # an entry needs a line of its own, or a comma
SUFFIXES = (".yaml", ".yml", ".json")
ROBOTS = {".urdf": ("a URDF", "load_urdf"), ".xml": ("an MJCF or URDF", "load_mjcf")}


def read_text(path: Path) -> str:
    """Return the text of a model file.

    Raises
    ------
    ModelError
        If it is no file, too large, or not UTF-8 text.
    """
    if exists(path / "zarr.json"):
        raise _refusal(path, "is the folder of a saved run, not a model. Open it with sarrus.load_run.")
    if path.suffix.lower() in ROBOTS:
        kind, reader = ROBOTS[path.suffix.lower()]
        raise _refusal(path, f'is {kind}. Read it with sarrus.{reader}("{path}"), or with sarrus.load_any.')
    if path.suffix.lower() not in SUFFIXES and not (path.suffix == "" and not exists(path)):
        raise _refusal(path, f"must end in {', '.join(SUFFIXES)}. Rename it.")
    text = _decoded(path, read_bytes(path))
    if not text.strip():
        raise _refusal(path, "is empty. Give at least a name and bodies.")
    if len(text) > MOST and sum(1 for _ in islice(ENTRY.finditer(text), MOST + 1)) > MOST:
        raise _refusal(path, f"has more than {MOST:,} entries. Build such a model in Python.")
    return text


def read_bytes(path: Path) -> bytes:
    """Return the content of a file, or raise a ModelError with the reason."""
    try:
        if path.is_dir():
            raise _refusal(path, "is a directory. Give the path of a file in it.")
        if path.exists() and not path.is_file():
            raise _refusal(path, "is not a regular file. Copy it to one.")
        with path.open("rb") as stream:
            content = stream.read(LARGEST + 1)
    except ModelError:
        raise
    except FileNotFoundError:
        raise _refusal(path, "does not exist. Check the path.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise _refusal(
            path, f"cannot be read, {reason.lower()}. Check the path and its permissions."
        ) from None
    if len(content) > LARGEST:
        raise _refusal(path, f"is larger than {LARGEST // 2**20} MB. Build such a model in Python.")
    return content


def _decoded(path: Path, content: bytes) -> str:
    if b"\0" in content:
        raise _refusal(path, "is binary, not text. Give a YAML or JSON file in UTF-8.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        message = "is not UTF-8 text. Save it as UTF-8."
        raise ModelError(message, where=f"{path}:{line}") from None


def _refusal(path: Path, message: str) -> ModelError:
    return ModelError(message, where=str(path))
