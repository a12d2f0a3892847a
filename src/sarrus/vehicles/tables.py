"""Characteristics of a suspension as text, as a CSV file, and as a table of pandas, in mm and degrees."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite, pi
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..algebra import Array
from ..outputs.output import labelled
from ..results.saving.exported_file import write_table
from .characteristics import CHARACTERISTICS, SLOPES, SweepName
from .corner import Side

if TYPE_CHECKING:
    from .result import Suspension

ROUND_OFF = 1e-9  # [mm], [deg] and their slopes: smaller values are zero, reciprocals of them are infinite
INSTALL = "pip install 'sarrus[tables]'"


class Scale(NamedTuple):
    """The unit in which a quantity is shown, and its size in SI units."""

    unit: str
    size: float


SHOWN = {
    "m": Scale("mm", 1e-3), "rad": Scale("deg", pi / 180), "1": Scale("", 1.0), "%": Scale("%", 1.0),
    "1/m": Scale("1/m", 1.0),
}  # fmt: skip


class Column(NamedTuple):
    """A curve with its label, in the unit in which it is shown."""

    label: str
    unit: str
    values: Array


def displacement(result: Suspension, sweep: SweepName) -> Column:
    """The displacement of a sweep: of the wheels in bump, the right wheel in roll, and the steering."""
    name = {"bump": "wheel travel", "roll": "right wheel travel"}.get(sweep, "steering")
    scale = SHOWN["m" if sweep in ("bump", "roll") else result.unit(sweep)]
    return Column(labelled(name, scale.unit), scale.unit, result.x(sweep) / scale.size)


def column(result: Suspension, name: str, sweep: SweepName, side: Side) -> Column:
    """A curve of one side."""
    scale = _scale(result, name, sweep)
    label = labelled(f"{side}.{name}", scale.unit)
    return Column(label, scale.unit, result.curve(name, sweep, side) / scale.size)


def _scale(result: Suspension, name: str, sweep: SweepName) -> Scale:
    """The unit in which a characteristic, or a slope with a name of its own, is shown."""
    if name not in SLOPES:
        return SHOWN[CHARACTERISTICS[name].unit]
    own, by = SHOWN[CHARACTERISTICS[SLOPES[name].characteristic].unit], SHOWN[result.unit(sweep)]
    return Scale(f"{own.unit}/{by.unit}", own.size / by.size)


def columns(result: Suspension, sweep: SweepName) -> Iterator[Column]:
    """All curves of a sweep, of both sides."""
    for name in result.names(sweep):
        for side in result.sides:
            yield column(result, name, sweep, side)


def write_csv(result: Suspension, path: str | Path, sweep: SweepName) -> None:
    """Write all curves of a sweep, with the displacement in the first column and units in the header."""
    every = [displacement(result, sweep), *columns(result, sweep)]
    rows = (np.column_stack([one.values for one in every]) + 0.0).tolist()  # no -0
    write_table(path, [one.label for one in every], rows)


def frame_of(result: Suspension, sweep: SweepName) -> Any:
    """A pandas DataFrame of all curves of a sweep, whose index is the displacement.

    Raises
    ------
    ImportError
        If pandas is not installed.
    """
    try:
        from pandas import DataFrame, Index
    except ImportError:
        raise ImportError(f"to_frame needs pandas. Install it with: {INSTALL}") from None
    x, every = displacement(result, sweep), [*columns(result, sweep)]
    frame = DataFrame({one.label: one.values for one in every}, index=Index(x.values, name=x.label))
    frame.attrs["units"] = {one.label: one.unit for one in every}
    return frame


def text_table(result: Suspension, sweep: SweepName, side: Side) -> str:
    """The finite characteristics of one side in the design position, and their slopes along a sweep."""
    x, by = displacement(result, sweep), SHOWN[result.unit(sweep)]
    ends = f"{x.values[0]:g} to {x.values[-1]:g} {x.unit}"
    lines = [f"{result.name}, {side} wheel: {sweep} from {ends}"]
    lines.append(f"  {'characteristic':<22}{'design position':>18}     {'slope':>12}")
    for name in result.names(sweep):
        scale = SHOWN[CHARACTERISTICS[name].unit]
        value = result.at(name, 0.0, sweep, side) / scale.size
        if not isfinite(value):
            continue
        line = f"  {name:<22}{_rounded(value):>18} {scale.unit:<4}"
        slope = result.at(name, 0.0, sweep, side, slope=True) * by.size / scale.size
        line += f"{_rounded(slope):>12} {scale.unit or 1}/{by.unit}"
        lines.append(line.rstrip())
    return "\n".join(lines)


def _rounded(value: float) -> str:
    """A number to six digits, zero if it is round-off of mm and degrees."""
    return f"{0.0 if abs(value) < ROUND_OFF else value:.6g}"
