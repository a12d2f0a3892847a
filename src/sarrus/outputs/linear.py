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
from .output import ENTRY, NAME, Level, Output, UnknownOutput, calls, find_output, provides, short
from .recording import Key
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
    match = ENTRY.fullmatch(part or "")
    if match is None or part is None:
        return
    word, names = match["word"], [name.strip() for name in NAME.findall(match["names"])]
    response = word not in MATRICES
    if len(names) != 2 + response:
        example = f"{word}[output, input, frequency in Hz]" if response else f"{word}[row, column]"
        raise UnknownOutput(f"{system.name}: {part} has {len(names)} entries in brackets. Write {example}.")
    row, column = MATRICES.get(word, ("output", "input"))
    of, by = _known(system, row, names[0]), _known(system, column, names[1])
    unit = "rad" if word == "phase" else quotient(of.unit, by.unit, *["s"] * (row == "state"))
    record: Any = calls("input", "linear", (word, of.name, by.name))
    if response:
        frequency = _frequency(system, part, names[2])
        parts = (("linear", (name, of.name, by.name, frequency)) for name in ("real", "imaginary"))
        record = partial(_number, word, *parts)
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
        output = find_output(system, name)
    except UnknownOutput:
        rate = RATE.fullmatch(name)
        if rate is None:
            raise
        output = find_output(system, rate["of_body"] or rate["measured"])
        name = f"d({output.name})/dt" if rate["of_body"] else f"{output.name}.rate"
        return NamedSignal(name, f"{output.unit}/s")
    return NamedSignal(output.name, output.unit)


def _frequency(system: System, part: str, text: str) -> float:
    try:
        frequency = float(text.removesuffix("Hz"))
    except ValueError:
        frequency = float("nan")
    if not isfinite(frequency):
        raise UnknownOutput(
            f"{system.name}: {part} needs a frequency in Hz, got {quote(text)}. Give a number."
        )
    return frequency


def _magnitude(real: Any, imaginary: Any) -> Any:
    return sqrt(real * real + imaginary * imaginary) if real.value or imaginary.value else 0.0 * real


def _damping_ratio(real: Any, imaginary: Any) -> Any:
    size = _magnitude(real, imaginary)
    return -1 * real / size if size.value else size


# of the real and the imaginary part of a frequency response or an eigenvalue
NUMBERS: dict[str, Callable[[Any, Any], Any]] = {
    "magnitude": _magnitude,
    "phase": lambda real, imaginary: atan2(imaginary, real),
    "real": lambda real, imaginary: real,
    "imaginary": lambda real, imaginary: imaginary,
    "frequency": lambda real, imaginary: imaginary / (2 * np.pi),
    "natural_frequency": lambda real, imaginary: _magnitude(real, imaginary) / (2 * np.pi),
    "damping_ratio": _damping_ratio,
}


def _number(word: str, real: Key, imaginary: Key, o: Any) -> Any:
    return NUMBERS[word](o.input(*real), o.input(*imaginary))


MODE = re.compile(r"(mode|pole)([1-9]\d*)")


@provides
def modal(system: System, part: str | None) -> Iterator[Output]:
    """The outputs of a mode or pole; they are not in the list of all outputs, as a motion does not have them.

    A part of the model with such a name has its own outputs only.
    """
    match = MODE.fullmatch(part or "")
    if match is None or any(
        part == other.name for section in system.model.sections().values() for other in section
    ):
        return
    kind, at = match[1], int(match[2]) - 1
    pole, eigenvalue = kind == "pole", ((kind, (at, "re")), (kind, (at, "im")))
    units = {"frequency": "Hz", "natural_frequency": "Hz", "damping_ratio": "1"}
    for word, unit in (units | ({"real": "1/s", "imaginary": "1/s"} if pole else {})).items():
        record, only = partial(_number, word, *eigenvalue), "linearization" if pole else "modes"
        yield Output(f"{part}.{word}", unit, record, Level.HISTORY, only=only)
    for place, name in enumerate(() if pole else system.coordinate_names[: system.moving]):
        shape = calls("input", "mode", (at, place))
        yield Output(f"{part}.shape.{short(name)}", "1", shape, Level.HISTORY, only="modes")
