"""Positions at which inputs or outputs are lost, drawn over the outputs or over the inputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ...model.show import quote, suggest
from ...outputs.output import labelled
from ...results.maps.input_singularities import InputSingularities, Lost, SingularCurve
from ..meshes.mesh import POINT
from .style import BLUE, GREY, plot_axes

RED = "#c23b4e"
STYLES: dict[Lost, dict[str, Any]] = {
    "inputs": {"color": RED, "linewidth": 1.4, "linestyle": (0, (4, 2))},
    "outputs": {"color": BLUE, "linewidth": 1.6},
}
DESCRIPTIONS: dict[Lost, str] = {"inputs": "lose control", "outputs": "lose a direction"}


def plot_input_singularities(
    result: InputSingularities, ax: Any = None, *, over: Lost = "outputs", axes: Sequence[str] | None = None
) -> Any:
    """Draw where inputs lose control (dashed) or outputs a direction, over the plane of two outputs or of two inputs.

    Over the outputs it may be drawn into the axes of a workspace; over the inputs, both kinds into the same axes.

    Parameters
    ----------
    result : InputSingularities
    ax : Matplotlib axes to draw into; by default a new figure's
    over : "outputs" or "inputs"
    axes : which two of the inputs; by default the first ones

    Returns
    -------
    Axes

    Raises
    ------
    SarrusError
        If there are not two such inputs.
    ImportError
        If Matplotlib is not installed.
    """
    columns = _columns(result, axes) if over == "inputs" else [0, 1]
    is_new, ax = ax is None, plot_axes(ax, 7.5, 7.0)
    if is_new:
        _name(ax, result, over, columns)
        if over == "inputs":
            _limit(ax, result, columns)
    names = result.inputs if result.lost == "inputs" else result.outputs
    label = f"{', '.join(names)} {DESCRIPTIONS[result.lost]}"
    for n, curve in enumerate(result.curves):
        line = _wrapped(result, curve, columns) if over == "inputs" else curve.line
        point = np.ptp(line[np.isfinite(line[:, 0])], axis=0).max() < POINT
        style = STYLES[result.lost] | ({"marker": "o"} if point else {})
        ax.plot(*line.T, **style, label=label if n == 0 else None)
    if result.curves:
        ax.legend(frameon=False, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=2)
    return ax


def _columns(result: InputSingularities, axes: Sequence[str] | None) -> list[int]:
    names = list(result.inputs[:2] if axes is None else axes)
    unknown = [name for name in names if name not in result.inputs]
    if unknown:
        raise SarrusError(f"there is no input {quote(unknown[0])}. {suggest(unknown[0], result.inputs)}")
    if len(names) != 2:
        raise SarrusError(
            f"a picture is over two inputs, not {len(names)}. Name two of {', '.join(result.inputs)}."
        )
    return [result.inputs.index(name) for name in names]


def _name(ax: Any, result: InputSingularities, over: Lost, columns: list[int]) -> None:
    names, units = (result.inputs, result.input_units) if over == "inputs" else (result.outputs, result.units)
    x, y = (labelled(names[column], units[column]) for column in columns)
    ax.set(xlabel=x, ylabel=y)
    if units[columns[0]] == units[columns[1]]:
        ax.set_aspect("equal", adjustable="datalim")
    ax.set_title(f"{result.name}: singular configurations", loc="left", fontsize=10)


def _limit(ax: Any, result: InputSingularities, columns: list[int]) -> None:
    """Grey lines where the inputs have limits."""
    for draw, column in zip((ax.axvline, ax.axhline), columns, strict=True):
        for value in result.input_limits[column]:
            if np.isfinite(value):
                draw(value, color=GREY, linewidth=1.0, linestyle=(0, (1, 2)))


def _wrapped(result: InputSingularities, curve: SingularCurve, columns: list[int]) -> Array:
    """A curve over the inputs, angles between -π and π, with a gap where it leaves at one side and comes back."""
    line = curve.input_line[:, columns].copy()
    for n, column in enumerate(columns):
        if result.input_units[column] == "rad":
            line[:, n] = (line[:, n] + np.pi) % (2 * np.pi) - np.pi
    jumps = np.flatnonzero((abs(np.diff(line, axis=0)) > np.pi).any(axis=1))
    return np.insert(line, jumps + 1, np.nan, axis=0)
