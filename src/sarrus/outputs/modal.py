"""Vibration modes by name: ``mode1.frequency``, ``mode1.natural_frequency``, ``mode1.damping_ratio``,
``mode1.shape.slider.x``. The first mode is mode 1; only the result of `modes` has them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from ..functions import sqrt
from ..system import System
from .output import Level, Output, provides

MODE = re.compile(r"mode([1-9]\d*)")


@provides
def modal(system: System, part: str | None) -> Iterator[Output]:
    """What a mode has; it is not in the list of all outputs, as a motion does not have it."""
    found = MODE.fullmatch(part or "")
    if found is None:
        return
    at = int(found[1]) - 1
    words = {"frequency": "Hz", "natural_frequency": "Hz", "damping_ratio": "1"}
    for word, unit in words.items():
        yield Output(f"{part}.{word}", unit, partial(WORDS[word], at), Level.HISTORY, only="modes")
    for place, name in enumerate(system.coordinate_names[: system.moving]):
        name = name.replace(".r.", ".").replace(".p.", ".")
        yield Output(f"{part}.shape.{name}", "1", partial(_shape, at, place), Level.HISTORY, only="modes")


def _parts(at: int, o: Any) -> tuple[Any, Any]:
    return o.input("mode", (at, "re")), o.input("mode", (at, "im"))


def _frequency(at: int, o: Any) -> Any:
    return _parts(at, o)[1] / (2 * np.pi)


def _size(at: int, o: Any) -> Any:
    real, imaginary = _parts(at, o)
    return sqrt(real * real + imaginary * imaginary) if real.value or imaginary.value else 0.0 * real


def _natural_frequency(at: int, o: Any) -> Any:
    return _size(at, o) / (2 * np.pi)


def _damping_ratio(at: int, o: Any) -> Any:
    size = _size(at, o)
    return -1 * _parts(at, o)[0] / size if size.value else size


def _shape(at: int, place: int, o: Any) -> Any:
    return o.input("mode", (at, place))


WORDS: dict[str, Callable[[int, Any], Any]] = {
    "frequency": _frequency,
    "natural_frequency": _natural_frequency,
    "damping_ratio": _damping_ratio,
}
