"""Vibration modes by name: ``mode1.frequency``, ``mode1.natural_frequency``, ``mode1.damping_ratio``,
``mode1.shape.slider.x``. The first mode is mode 1; only the result of `modes` has them.

Poles of a linearization likewise: ``pole1.frequency``, ..., ``pole1.real`` and ``pole1.imaginary`` [1/s].
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from ..functions import sqrt
from ..system import System
from .output import Level, Output, provides, short

MODE = re.compile(r"(mode|pole)([1-9]\d*)")

Parts = Callable[[Any], tuple[Any, Any]]  # real and imaginary part of an eigenvalue


@provides
def modal(system: System, part: str | None) -> Iterator[Output]:
    """The outputs of a mode or pole; they are not in the list of all outputs, as a motion does not have them.

    A part of the model with such a name has its own outputs only.
    """
    found = MODE.fullmatch(part or "")
    if found is None or any(part == one.name for parts in system.model.sections().values() for one in parts):
        return
    at, pole = int(found[2]) - 1, found[1] == "pole"
    own: Parts = partial(_parts, "pole" if pole else "mode", at)
    only = "linearization" if pole else "modes"
    words = {"frequency": "Hz", "natural_frequency": "Hz", "damping_ratio": "1"}
    for word, unit in (words | ({"real": "1/s", "imaginary": "1/s"} if pole else {})).items():
        yield Output(f"{part}.{word}", unit, partial(WORDS[word], own), Level.HISTORY, only=only)
    if pole:
        return
    for place, name in enumerate(system.coordinate_names[: system.moving]):
        yield Output(
            f"{part}.shape.{short(name)}", "1", partial(_shape, at, place), Level.HISTORY, only="modes"
        )


def _parts(kind: str, at: int, o: Any) -> tuple[Any, Any]:
    return o.input(kind, (at, "re")), o.input(kind, (at, "im"))


def _frequency(parts: Parts, o: Any) -> Any:
    return parts(o)[1] / (2 * np.pi)


def _size(parts: Parts, o: Any) -> Any:
    real, imaginary = parts(o)
    return sqrt(real * real + imaginary * imaginary) if real.value or imaginary.value else 0.0 * real


def _natural_frequency(parts: Parts, o: Any) -> Any:
    return _size(parts, o) / (2 * np.pi)


def _damping_ratio(parts: Parts, o: Any) -> Any:
    size = _size(parts, o)
    return -1 * parts(o)[0] / size if size.value else size


def _shape(at: int, place: int, o: Any) -> Any:
    return o.input("mode", (at, place))


WORDS: dict[str, Callable[[Parts, Any], Any]] = {
    "frequency": _frequency,
    "natural_frequency": _natural_frequency,
    "damping_ratio": _damping_ratio,
    "real": lambda parts, o: parts(o)[0],
    "imaginary": lambda parts, o: parts(o)[1],
}
