"""The mesh files that a model may name: those in its folder and below, and in folders that the user lists."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

VARIABLE = "SARRUS_MESH_PATH"  # folders with meshes, beside those of the model
REMEDY = f"move it there, or list its folder in the environment variable {VARIABLE}"


def listed(*variables: str) -> list[Path]:
    """The folders that environment variables list."""
    texts = [os.environ.get(variable, "") for variable in variables]
    return [Path(place) for text in texts for place in text.split(os.pathsep) if place]


def inside(file: Path, folders: Iterable[Path]) -> bool:
    """Whether a file is named in one of these folders, or below; links are not followed."""
    named = Path(os.path.abspath(file))
    return any(named.is_relative_to(os.path.abspath(folder)) for folder in folders)
