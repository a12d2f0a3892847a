"""Reading of the text of a model file, with one message if it cannot be read."""

from __future__ import annotations

import re
from contextlib import suppress
from difflib import get_close_matches
from itertools import islice
from os.path import exists  # false, not an error, for names that no file can have
from pathlib import Path

from ...errors import ModelError
from ...show import MOST_SOUGHT, quote

LARGEST = 16 * 1024 * 1024  # bytes
MOST = 1_000_000  # entries
ENTRY = re.compile(r"^[ \t]*[^#\s]|,", re.MULTILINE)  # an entry needs a line of its own, or a comma
SUFFIXES = (".yaml", ".yml", ".json")
ROOT = re.compile(r"\s*+(?:(?><[?].*?[?]>|<!--.*?-->|<!DOCTYPE[^>]*>)\s*)*+<([\w:.-]+)", re.DOTALL)
UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # what begins a file
PACKED = {b"\x1f\x8b": "gzip", b"BZh": "bzip2", b"\xfd7zXZ": "xz", b"PK\x03\x04": "zip"}  # by what begins it
SHIPPED = Path(__file__).resolve().parents[3] / "mechanisms"


def read_text(path: Path) -> str:
    """Return the text of a model file.

    Raises
    ------
    ModelError
        If it is no file, too large, compressed, XML, or not UTF-8 text.
    """
    if exists(path / "zarr.json"):
        raise _refusal(path, "is the folder of a saved run, not a model. Open it with sarrus.load_run.")
    content = read_bytes(path)
    if path.suffix.lower() not in (*SUFFIXES, ""):
        message = f"must end in {', '.join(SUFFIXES)} as a model file, or be a URDF, SDF or MJCF. Rename it."
        raise _refusal(path, message)
    text = _decoded(path, content)
    if ROOT.match(text):
        raise _refusal(
            path, f'is XML, not a model file. Read a URDF, SDF or MJCF with sarrus.load("{path}").'
        )
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
        raise _refusal(path, f"does not exist. {_suggestion(path)}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise _refusal(
            path, f"cannot be read, {reason.lower()}. Check the path and its permissions."
        ) from None
    if len(content) > LARGEST:
        raise _refusal(path, f"is larger than {LARGEST // 2**20} MB. Build such a model in Python.")
    packed = next((kind for begin, kind in PACKED.items() if content.startswith(begin)), None)
    if packed:
        raise _refusal(path, f"is compressed by {packed}. Unpack it first.")
    return content


def root_tag(path: Path) -> str:
    """Return the tag of the first element of an XML file, whatever the ending of its name; empty for other files."""
    try:
        content = read_bytes(path)
    except ModelError:
        return ""
    encoding = "utf-16" if content.startswith(UTF_16) else "utf-8-sig"
    match = ROOT.match(content.decode(encoding, errors="replace"))
    return match[1] if match else ""


def _suggestion(path: Path) -> str:
    """Return the nearest name of a file in the folder, or of a shipped mechanism; else the advice to check the path."""
    shipped = sorted(file.stem for file in SHIPPED.rglob("*.yaml")) if str(path) == path.name else []
    with suppress(OSError):
        there = [file.name for file in islice(path.parent.iterdir(), MOST_SOUGHT)]
        if near := get_close_matches(path.name, there, n=1, cutoff=0.8):
            return f"Did you mean {quote(str(path.with_name(near[0])))}?"
    if near := get_close_matches(path.stem.lower().replace("-", "_"), shipped, n=1, cutoff=0.8):
        return f"Did you mean {quote(near[0])}, which is shipped?"
    return (
        f"Check the path, or choose from {', '.join(shipped)}."
        if shipped and not path.suffix
        else "Check the path."
    )


def _decoded(path: Path, content: bytes) -> str:
    if content.startswith(UTF_16):
        raise _refusal(path, "is UTF-16 text. Save it as UTF-8.")
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
