"""Influences of numbers on responses, and the convergence of optimizations: tables and figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...outputs.output import labelled
from ...outputs.units import quotient, size_in_tables
from .style import BARS, BLUE, DECADE, GREY, INCHES, ORANGE, new_figure, panels, plot_axes

if TYPE_CHECKING:
    from ...results import Gradient, Optimum

HOLLOW = 1e-6  # [-] a constraint that is short by more is drawn as broken
WIDE = 1e3  # [-] of its value, found or at the start: a parameter with a larger deviation is not determined
TINY = 1e-12  # of the largest gradient: smaller ones are drawn there


def gradient_table(gradient: Gradient, response: int = 0, most: int = 20) -> str:
    """The numbers of the largest influence on a response: value, derivative, change by 1 % or 1 mm more."""
    (unit,) = _shown(gradient.response_units[response])
    lines = [f"{gradient.responses[response]} = {gradient.values[response]:.9g} {unit}".rstrip()]
    undefined, rows = gradient.undefined, influence_rows(gradient, response)
    width = max([len(name) for name in gradient.names] + [10])
    wide, wider = (max([len(getattr(row, name)) for row in rows[:most]] + [0]) for name in ("unit", "by"))
    by = f"by {gradient.increment} more"
    last = max(14, len(by) + 2)
    head = f"{'value':>14} {'':<{wide}}{'derivative':>16} {'':<{wider}}{by:>{last}}"
    lines.append(f"  {'parameter':<{width}}{head}")
    for row in rows[:most]:
        value = f"{row.value:>14} {row.unit:<{wide}}{row.derivative:>16} {row.by:<{wider}}"
        change = f"{row.change:>{last}} {unit}" if row.change else f"{'(value 0)':>{last}}"
        lines.append(f"  {row.name:<{width}}{value}{change}".rstrip())
    if len(rows) > most:
        lines.append(f"  and {len(rows) - most} more of less influence")
    if undefined:
        text = ", ".join(undefined[:6]) + (", ..." if len(undefined) > 6 else "")
        many = "has" if len(undefined) == 1 else "have"
        lines.append(f"  {len(undefined)} {many} no derivative, see Gradient.undefined: {text}")
    return "\n".join(lines)


class InfluenceRow(NamedTuple):
    """A number with its unit, a derivative by it with its unit, and the change by its increment: none where it is 0."""

    name: str
    value: str
    unit: str
    derivative: str
    by: str
    change: str


def influence_rows(gradient: Gradient, response: int = 0) -> list[InfluenceRow]:
    """All numbers with a derivative, the largest influence on a response first."""
    influences = gradient.influences(response)
    rows = []
    for name in gradient.ranked(response):
        k = gradient.names.index(name)
        unit, by, size = _unit_in_table(gradient, k, response)
        derivative, change = f"{gradient.matrix[response, k] * size:+.7g}", f"{influences[k]:+.4g}"
        change *= bool(gradient.increments[k])
        rows.append(InfluenceRow(name, f"{gradient.at[k] / size:.6g}", unit, derivative, by, change))
    return rows


def _unit_in_table(gradient: Gradient, k: int, response: int) -> tuple[str, str, float]:
    """The units in which a parameter and a derivative by it are shown, and the first one in SI units."""
    unit = gradient.table_units[k] or gradient.units[k]
    own, by = _shown(unit, quotient(gradient.response_units[response], unit))
    return own, by, size_in_tables(gradient.units[k], unit)


def _shown(*units: str) -> list[str]:
    """Units beside numbers: none for plain ones."""
    return ["" if name == "1" else name for name in units]


def plot_gradient(gradient: Gradient, ax: Any = None, response: int | None = None, most: int = 15) -> Any:
    """Draw the changes of responses for 1 % more of each number as bars, the largest on top; one panel for each.

    Hardpoints move by 1 mm.

    Parameters
    ----------
    gradient : Gradient
    ax : Matplotlib axes for each response, or a figure, whose height follows the bars; by default a new figure
    response : number of the only response to draw; by default all
    most : number of bars in a panel, at most

    Returns
    -------
    The axes; of several responses an array.

    Raises
    ------
    IndexError
        If there is no such response.
    ValueError
        If another number of axes is given.
    """
    chosen = range(len(gradient.responses)) if response is None else [response]
    largest = [gradient.largest(one, most) for one in chosen]
    ax = new_figure(INCHES.width, 1.0) if ax is None else ax
    if hasattr(ax, "set_size_inches"):
        ax.set_size_inches(
            INCHES.width, sum(INCHES.bar * max(len(names), BARS) + INCHES.labels for names, _ in largest)
        )
    axes = panels(ax, len(largest), sharex=False)
    for one, panel, (names, changes) in zip(chosen, axes, largest, strict=True):
        panel.set_axisbelow(True)
        panel.barh(
            names[::-1], changes[::-1], color=[BLUE if change >= 0 else ORANGE for change in changes[::-1]]
        )
        panel.axvline(0, color=GREY, linewidth=0.8)
        changed = labelled(f"change of {gradient.responses[one]}", gradient.response_units[one])
        panel.set_xlabel(f"{changed} for {gradient.increment} more")
    return axes[0] if len(axes) == 1 else np.array(axes)


class VariableRow(NamedTuple):
    """A design variable at the start and in the optimum, with its unit in tables and the size of this unit."""

    name: str
    start: str
    found: str
    unit: str
    size: float


def variable_rows(optimum: Optimum) -> list[VariableRow]:
    """All design variables."""
    none = ("",) * len(optimum.names)
    found = []
    for k, (unit, of_table) in enumerate(
        zip(optimum.units or none, optimum.table_units or none, strict=True)
    ):
        size, (shown,) = size_in_tables(unit, of_table), _shown(of_table or unit)
        start, x = (f"{values[k] / size:.6g}" for values in (optimum.x0, optimum.x))
        found.append(VariableRow(optimum.names[k], start, x, shown, size))
    return found


def optimum_table(optimum: Optimum) -> str:
    """Design variables before and after; with confidence intervals where parameters were fitted."""
    (unit,), rows = _shown(optimum.unit), variable_rows(optimum)
    units = [row.unit for row in rows]
    span = max(map(len, units))
    error = "" if np.isnan(optimum.error) else f" ± {optimum.error:.0e}"
    value = f"{optimum.value:.6g}{error} {unit}".rstrip()
    lines = [f"objective {optimum.value0:.6g} -> {value}: {optimum.message}"]
    width, fitted = max([len(name) for name in optimum.names] + [8]), bool(optimum.covariance.size)
    more = f"{'std. dev.':>12}{'95 % interval':>28}" if fitted else ""
    lines.append(f"  {'variable':<{width}}{'start':>14}{'found':>14} {'':<{span}}{more}".rstrip())
    for k, row in enumerate(rows):
        line, size = f"  {row.name:<{width}}{row.start:>14}{row.found:>14} {row.unit:<{span}}", row.size
        if fitted:
            low, high = optimum.interval(row.name)
            wide = optimum.deviations[k] > WIDE * max(abs(optimum.x[k]), abs(optimum.x0[k]) or 1.0)
            text = "not determined" if wide else f"{low / size:.6g} to {high / size:.6g}"
            line += f"{optimum.deviations[k] / size:>12.3g}{text:>28}"
        lines.append(line.rstrip())
    lines += [f"  constraint {name}: {value:.6g}" for name, value in optimum.constraints.items()]
    for start in optimum.start_reports:
        value = "no value" if np.isnan(start.value) else f"{start.value:.6g}"
        lines.append(f"  start {start.number}: {value}, {start.message}")
    return "\n".join([*lines, *(f"  hardly determined: {text}" for text in optimum.poor)])


def plot_convergence(optimum: Optimum, ax: Any = None) -> Any:
    """Draw the objective and the size of its gradient over the simulations; designs that break constraints are hollow.

    Returns
    -------
    Matplotlib axes
    """
    ax = plot_axes(ax)
    count, (values, sizes, short) = np.arange(1, len(optimum.history) + 1), optimum.history.T
    ax.plot(count, values, color=BLUE, linewidth=1.2)
    faces = [BLUE if gap <= HOLLOW else "white" for gap in short]
    ax.scatter(count, values, color=faces, edgecolors=BLUE, s=16, zorder=3)
    ax.xaxis.get_major_locator().set_params(integer=True)
    ax.set_xlabel("simulation")
    ax.set_ylabel(labelled("objective", *_shown(optimum.unit)), color=BLUE)
    if values.min() > 0 and values.max() > DECADE * values.min():
        ax.set_yscale("log")
    other, known = ax.twinx(), np.isfinite(sizes)
    least = TINY * float(sizes[known].max(initial=0.0)) or TINY
    other.semilogy(count[known], np.maximum(sizes[known], least), color=ORANGE, linewidth=1.2)
    other.set_ylabel("size of its gradient", color=ORANGE)
    other.spines["top"].set_visible(False)
    return ax
