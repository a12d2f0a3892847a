"""The mechanisms that come with the package, as model files."""

from __future__ import annotations

from pathlib import Path

from ..model.errors import ModelError
from ..model.show import quote, suggest

_FOLDER = Path(__file__).parent


def names() -> tuple[str, ...]:
    """Return the names of the shipped mechanisms."""
    return tuple(sorted(file.stem for file in _FOLDER.glob("*.yaml")))


def path(name: str) -> Path:
    """Return the model file of a shipped mechanism.

    Raises
    ------
    ModelError
        If there is no mechanism of this name.
    """
    if name not in names():
        raise ModelError(f"there is no shipped mechanism {quote(name)}. {suggest(name, names())}")
    return _FOLDER / f"{name}.yaml"
