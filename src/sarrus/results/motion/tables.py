"""A trajectory as a table of pandas, or as a Dataset of xarray: outputs over time, with their units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...outputs import Level, outputs_of
from ...outputs.motion import Series, several
from ...outputs.output import components
from ..saving.exported_file import header_cell

if TYPE_CHECKING:
    from .trajectory import Trajectory

LEFT_OUT = ("acceleration", "multiplier", "angular_acceleration")
ENDS = ("_i", "_body")  # of vectors at the first body, and in body axes
INSTALL = "pip install 'sarrus[tables]'"


def quoted(label: str) -> str:
    """A label as a cell of a CSV file: those of points contain commas."""
    cell = header_cell(label)
    return '"' + cell.replace('"', '""') + '"' if {",", '"'} & {*cell} else cell


def columns(run: Trajectory, names: Sequence[str]) -> list[Series]:
    """Outputs over time; by default the motion of bodies and joints, what joints and forces do, and energies."""
    if run.system is None:
        return [run.output(name) for name in names or run.coordinate_names]
    if not names:
        names = [
            one.name
            for one in outputs_of(run.system)
            if one.name != "t"
            and one.level < Level.HISTORY
            and not any(word in LEFT_OUT for word in one.name.split("."))
            and not one.name.rpartition(".")[0].endswith(ENDS)
        ]
    return several(run.system, run, [one for name in names for one in components(run.system, name)])


def to_frame(run: Trajectory, names: Sequence[str]) -> Any:
    """See `Trajectory.to_frame`."""
    try:
        from pandas import DataFrame, Index
    except ImportError:
        raise ImportError(f"to_frame needs pandas. Install it with: {INSTALL}") from None
    found = columns(run, names)
    frame = DataFrame({one.label: one.values for one in found}, index=Index(np.asarray(run.t), name="t [s]"))
    frame.attrs["units"] = {one.label: one.unit for one in found}
    return frame


def to_xarray(run: Trajectory, names: Sequence[str]) -> Any:
    """See `Trajectory.to_xarray`."""
    try:
        from xarray import Dataset
    except ImportError:
        raise ImportError(f"to_xarray needs xarray. Install it with: {INSTALL}") from None
    found = [one for one in columns(run, names) if one.name != "t"]  # which is the coordinate
    variables = {one.name: ("t", one.values, {"units": one.unit}) for one in found}
    return Dataset(
        variables, coords={"t": ("t", np.asarray(run.t), {"units": "s"})}, attrs={"model": run.name}
    )
