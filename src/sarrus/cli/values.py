"""Types of option values: checked while the command line is parsed, before anything is computed."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterable
from math import inf, nan
from pathlib import Path

MOST_STEPS = 1_000_000  # output intervals: all states are in memory
FIGURES = (".png", ".svg", ".pdf")
MODELS = (".yaml", ".yml", ".json")
EXPORTS = (".xml", ".sdf", ".urdf")  # formats that `sarrus.export` writes
SCENES = (".html", ".glb", ".png", ".gif", ".mp4")


def positive(text: str) -> float:
    """A number greater than 0, and finite."""
    return _number(text, "a positive finite number", 0.0)


def positive_in(unit: str) -> Callable[[str], float]:
    """Return the type of numbers greater than 0 in a unit, or with another one, as ``500 ms``."""

    def value(text: str) -> float:
        from ..model.errors import SarrusError
        from ..model.expression.quantity import quantity

        try:
            number = str(quantity(text, unit))
        except SarrusError:
            return positive(text)
        return positive(number)

    return value


duration = positive_in("s")


def finite(text: str) -> float:
    """A finite number."""
    return _number(text, "a finite number")


def _number(text: str, wanted: str, above: float = -inf) -> float:
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not above < value < inf:
        raise argparse.ArgumentTypeError(f"must be {wanted}, but is {text}")
    return value


def assignment(text: str, example: str = "NAME=VALUE") -> tuple[str, str | float]:
    """A name and its value, ``crank.mass=2``; a value that is no number stays a text, as of a formula."""
    name, _, value = (part.strip() for part in text.partition("="))
    if not (name and value):
        raise argparse.ArgumentTypeError(f"must be {example}, but is {text}")
    try:
        return name, float(value)
    except ValueError:
        return name, value


def start_entry(text: str) -> tuple[str, str | float]:
    """An entry of a start, ``rates.pin=5`` or ``equilibrium=true``."""
    return assignment(text, "a name and a value such as rates.pin=5")


def natural(text: str) -> int:
    """A whole number that is not negative."""
    return _whole(text, 0, None)


def intervals(text: str) -> int:
    """A number of output intervals that memory can hold."""
    return _whole(text, 1, MOST_STEPS)


def _whole(text: str, least: int, most: int | None) -> int:
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if value < least or (most is not None and value > most):
        limits = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise argparse.ArgumentTypeError(f"must be a whole number {limits}, but is {text}")
    return value


def figure_file(text: str) -> Path:
    """A file whose ending Matplotlib can write."""
    return _file(text, FIGURES)


def scene_file(text: str) -> Path:
    """A file that a mechanism or its motion can be written to."""
    return _file(text, SCENES)


def model_out(text: str) -> Path:
    """A model file to write, or a file for another program."""
    return _file(text, (*MODELS, *EXPORTS))


def tyre_file(text: str) -> Path:
    """A file of a tyre."""
    return _file(text, (".tir",))


def _file(text: str, endings: tuple[str, ...]) -> Path:
    path = Path(text)
    if path.suffix.lower() not in endings:
        raise argparse.ArgumentTypeError(
            f"must end in {' or '.join(filter(None, (', '.join(endings[:-1]), endings[-1])))}, but is {text}"
        )
    return path


def refuse_unwritable(files: Iterable[Path | None]) -> None:
    """Raise a SarrusError for the first file that could not be written."""
    from ..model.errors import SarrusError

    for file in files:
        if file is None:
            continue
        if file.is_dir():
            raise SarrusError(f"{file}: is a folder. Name a file in it.")
        if not file.parent.is_dir():
            raise SarrusError(f"{file}: there is no folder {file.parent}. Make it first.")
        if not os.access(file if file.exists() else file.parent, os.W_OK):
            raise SarrusError(f"{file}: cannot be written. Choose another place.")
