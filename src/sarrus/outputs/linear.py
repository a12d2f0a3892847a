"""Outputs of linearized systems: frequency responses, vibration modes and poles.

``mode1.shape.slider.x``. The first mode is mode 1; only the result of `modes` has them.

Poles of a linearization likewise: ``pole1.frequency``, ..., ``pole1.real`` and ``pole1.imaginary`` [1/s].
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from ..functions import atan2, sqrt
from ..model.show import quote
from ..model.states.input import refuse_unknown_input
from ..system import System
from .output import ENTRY, NAME, Level, Output, UnknownOutput, find_output, provides, short
from .units import quotient

RATE = re.compile(r"d\((?P<of_body>.+)\)/dt|(?P<measured>.+)\.rate")
MATRICES = {
    "A": ("state", "state"),
    "B": ("state", "input"),
    "C": ("output", "state"),
    "D": ("output", "input"),
}


@provides
def linear(system: System, part: str | None) -> Iterator[Output]:
    """What a linearization has; it is not in the list of all outputs, as a motion does not have it."""
    found = ENTRY.fullmatch(part or "")
    if found is None or part is None:
        return
    word, names = found["word"], [one.strip() for one in NAME.findall(found["names"])]
    response = word not in MATRICES
    if len(names) != 2 + response:
        example = f"{word}[output, input, frequency in Hz]" if response else f"{word}[row, column]"
        raise UnknownOutput(f"{system.name}: {part} has {len(names)} entries in brackets. Write {example}.")
    row, column = MATRICES.get(word, ("output", "input"))
    of, by = _known(system, row, names[0]), _known(system, column, names[1])
    unit = "rad" if word == "phase" else quotient(of.unit, by.unit, *["s"] * (row == "state"))
    record: Any = partial(_entry, word, of.name, by.name)
    if response:
        record = partial(RESPONSES[word], of.name, by.name, _frequency(system, part, names[2]))
    yield Output(part, unit, record, Level.HISTORY, only="linearization")


class NamedSignal(NamedTuple):
    """The name of a state, an input or an output as a linearization has it, and its unit."""

    name: str
    unit: str


def _known(system: System, kind: str, name: str) -> NamedSignal:
    if kind == "input":
        refuse_unknown_input(system.name, name, system.inputs)
        return NamedSignal(name, system.inputs[name].unit)
    try:
        found = find_output(system, name)
    except UnknownOutput:
        rate = RATE.fullmatch(name)
        if rate is None:
            raise
        found = find_output(system, rate["of_body"] or rate["measured"])
        return NamedSignal(
            f"d({found.name})/dt" if rate["of_body"] else f"{found.name}.rate", f"{found.unit}/s"
        )
    return NamedSignal(found.name, found.unit)


def _frequency(system: System, part: str, text: str) -> float:
    try:
        found = float(text.removesuffix("Hz"))
    except ValueError:
        found = float("nan")
    if not isfinite(found):
        raise UnknownOutput(
            f"{system.name}: {part} needs a frequency in Hz, got {quote(text)}. Give a number."
        )
    return found


def _entry(word: str, row: str, column: str, o: Any) -> Any:
    return o.input("linear", (word, row, column))


def _parts(output: str, given: str, frequency: float, o: Any) -> tuple[Any, Any]:
    return tuple(o.input("linear", (word, output, given, frequency)) for word in ("real", "imaginary"))


def _magnitude(output: str, given: str, frequency: float, o: Any) -> Any:
    real, imaginary = _parts(output, given, frequency, o)
    return sqrt(real * real + imaginary * imaginary) if real.value or imaginary.value else 0.0 * real


def _phase(output: str, given: str, frequency: float, o: Any) -> Any:
    real, imaginary = _parts(output, given, frequency, o)
    return atan2(imaginary, real)


RESPONSES = {
    "magnitude": _magnitude,
    "phase": _phase,
    "real": lambda *of: _parts(*of)[0],
    "imaginary": lambda *of: _parts(*of)[1],
}


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
    own: Parts = partial(_parts_of_eigenvalue, "pole" if pole else "mode", at)
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


def _parts_of_eigenvalue(kind: str, at: int, o: Any) -> tuple[Any, Any]:
    return o.input(kind, (at, "re")), o.input(kind, (at, "im"))


def _modal_frequency(parts: Parts, o: Any) -> Any:
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
    "frequency": _modal_frequency,
    "natural_frequency": _natural_frequency,
    "damping_ratio": _damping_ratio,
    "real": lambda parts, o: parts(o)[0],
    "imaginary": lambda parts, o: parts(o)[1],
}
