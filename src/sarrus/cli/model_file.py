"""The model that a verb works on: its file, and how a robot description is to be read."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..model import Model

WISHES = ("base", "mimic", "inertia", "loops")


def arguments(parser: argparse.ArgumentParser) -> None:
    """The file, and the options of an import."""
    parser.add_argument(
        "model",
        help="a .yaml or .json model file, a .urdf, an MJCF .xml, or slider_crank or hmmwv, which are shipped",
    )
    parser.add_argument("--base", choices=("fixed", "floating"), help="of a URDF: its root link (fixed)")
    parser.add_argument(
        "--mimic", choices=("couple", "free", "lock"), help="joints that follow another (couple)"
    )
    parser.add_argument("--inertia", choices=("check", "given"), help="of imported links (check)")
    parser.add_argument("--loops", help="file of joints and forces that an imported robot lacks")


def read(chosen: argparse.Namespace) -> Model:
    """Return the model; only what was asked for is handed to the reader."""
    from .. import mechanisms
    from ..io import load_any

    file = chosen.model
    if file in mechanisms.names() and not Path(file).exists():
        file = mechanisms.path(file)
    wishes = {name: getattr(chosen, name) for name in WISHES}
    return load_any(file, **{name: value for name, value in wishes.items() if value is not None})
