"""HTML of models and results in notebooks: a headline, a table, and a picture if Matplotlib is installed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import singledispatch
from html import escape
from importlib.util import find_spec
from io import StringIO
from typing import Any, NamedTuple

import numpy as np

from ..model import Model
from ..model.coordinates import by_body, slice_of
from ..model.show import MOST
from ..outputs.output import labelled
from ..results import Assembly, Gradient, Hessian, Mobility, Modes, Optimum, Trajectory, Workspace
from ..results.motion.energy_balance import EnergyBalance
from ..results.result import Result
from ..studies import StudyTable
from ..system import System
from .figures.gradients import influence_rows, plot_convergence, plot_gradient, variable_rows
from .figures.histories import plot
from .figures.mechanism import mechanism_figure
from .figures.modes import mode_rows, plot_modes
from .figures.study import plot_study
from .figures.style import ROUND_OFF, figure_of, tidied
from .figures.workspace import plot_workspace
from .figures.workspace_report import workspace_rows

PLACE = ("x [m]", "y [m]", "z [m]")
STYLE = "text-align:left;padding:2px 10px"


class Table(NamedTuple):
    """Cells as text; of more rows than `MOST` the first ones are shown."""

    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def notebook_html(value: Any) -> str:
    """The parts of a page for a model, a system or a result."""
    summary = value.summary() if isinstance(value, Result) else value.headline()
    table, warnings = table_of(value), getattr(value, "warnings", ())
    text = value.headline() if table else summary
    parts = [f'<div style="white-space:pre-wrap"><b>{escape(text)}</b></div>']
    parts += [f"<div>warning: {escape(message)}</div>" for message in warnings]
    parts += [_html(table)] if table else []
    return "".join([*parts, _picture(value)])


def _html(table: Table) -> str:
    rows = "".join(_row("td", row) for row in table.rows[:MOST])
    left = len(table.rows) - MOST
    more = f"<div>and {left} more</div>" if left > 0 else ""
    return f"<table>{_row('th', table.header)}{rows}</table>{more}"


def _row(kind: str, cells: Iterable[str]) -> str:
    return f"<tr>{''.join(f'<{kind} style={STYLE!r}>{escape(str(cell))}</{kind}>' for cell in cells)}</tr>"


@singledispatch
def table_of(value: Any) -> Table | None:
    """Return many numbers as a table."""
    return None


@table_of.register
def _(model: Model) -> Table:
    named = [(str(getattr(part, "name", part)), part) for part in _parts(model)]
    rows = [(name, type(one).__name__, _weight(one) or _connected(one)) for name, one in named]
    return Table(("part", "type", "of"), rows)


def _parts(model: Model) -> list[Any]:
    """All parts; what is no sequence has none."""
    return [part for parts in model.sections().values() if isinstance(parts, list | tuple) for part in parts]


def _weight(body: Any) -> str:
    mass = getattr(body, "mass", "")
    return f"{mass:g} kg" if isinstance(mass, int | float) else str(mass)


def _connected(part: Any) -> str:
    """The bodies and joints that a part refers to, by name."""
    ends = [
        getattr(part, name, None)
        for name in ("body_i", "body_j", "point_i", "point_j", "body", "point", "joint")
    ]
    return ", ".join(dict.fromkeys(name for name in map(_name, ends) if name))


def _name(of: Any) -> str:
    owner = getattr(of, "body", of)
    return owner if isinstance(owner, str) else str(getattr(owner, "name", ""))


@table_of.register
def _(system: System) -> Table | None:
    return table_of(system.model)


@table_of.register
def _(result: Mobility) -> Table | None:
    rows = [
        (one.joint, ", ".join(one.repeats) or "what is fixed", ", ".join(one.directions))
        for one in result.repetitions
    ]
    return Table(("joint", "repeats", "restrains"), rows) if rows else None


@table_of.register
def _(result: Trajectory) -> Table:
    rows = _places(result.bodies, result.q[-1]) if len(result.t) else []
    events = [(one.name, f"at {one.t:.6g} s", "", "") for one in result.events]
    return Table(("body, at the end", *PLACE), [*rows, *events])


def _places(bodies: Sequence[str], q: Any) -> list[tuple[str, ...]]:
    """The positions of bodies."""
    places = by_body(np.asarray(q)[: slice_of(len(bodies)).start])[:, :3]
    places = np.where(abs(places) > ROUND_OFF * abs(places).max(initial=0.0), places, 0.0)
    return [(name, *(f"{x:.6g}" for x in place)) for name, place in zip(bodies, places, strict=False)]


@table_of.register
def _(result: Assembly) -> Table | None:
    return Table(("body", *PLACE), _places(result.bodies, result.q)) if result.bodies else None


@table_of.register
def _(result: Workspace) -> Table | None:
    labels = (labelled(*pair) for pair in zip(result.outputs, result.units, strict=True))
    return Table(("part or curves", "area or length", *labels), workspace_rows(result))


@table_of.register
def _(result: EnergyBalance) -> Table:
    rows = [(name, f"{values[0]:.6g}", f"{values[-1]:.6g}") for name, values in result.rows()]
    return Table(("energy", "at the start [J]", "at the end [J]"), rows)


@table_of.register
def _(result: Optimum) -> Table:
    rows = [row[:-1] for row in variable_rows(result)]
    return Table(("variable", "start", "found", "unit"), rows)


@table_of.register
def _(result: Gradient) -> Table:
    rows = [
        (row.name, f"{row.value} {row.unit}", f"{row.derivative} {row.by}", row.change)
        for row in influence_rows(result)
    ]
    unit = result.response_units[0]
    return Table(("parameter", "value", "derivative", labelled(f"by {result.increment} more", unit)), rows)


@table_of.register
def _(result: Hessian) -> Table:
    names, matrix = result.in_table_units()
    rows = [(name, *(f"{x:.6g}" for x in row)) for name, row in zip(names, matrix, strict=True)]
    return Table(("", *names), rows)


@table_of.register
def _(result: Modes) -> Table:
    return Table(("mode", "eigenvalue [1/s]", "frequency [Hz]", "damping", "moves most"), mode_rows(result))


@table_of.register
def _(result: StudyTable) -> Table:
    cells = zip(result.values, result.found, result.messages, strict=True)
    rows = [(*(f"{x:.6g}" for x in (*values, *found)), message) for values, found, message in cells]
    names = (labelled(name, result.units.get(name, "")) for name in (*result.parameters, *result.responses))
    return Table((*names, "message"), rows)


def _over(draw: Callable[..., Any]) -> Callable[[Any], Any]:
    """A drawing that takes axes, in a figure of its own, which notebooks do not show once more."""

    def drawn(result: Any) -> Any:
        figure = figure_of(7.0, 3.2)
        draw(result, ax=tidied(figure.subplots()))
        return figure

    return drawn


PICTURES: dict[type, Callable[[Any], Any]] = {
    Model: mechanism_figure,
    System: lambda system: mechanism_figure(system.model),
    Trajectory: _over(plot),
    Gradient: lambda found: np.ravel(plot_gradient(found, figure_of(7.0, 3.2)))[0].figure,
    Modes: lambda found: plot_modes(found, figure_of(11.0, 3.6))[0].figure,
    Workspace: lambda found: plot_workspace(found, tidied(figure_of(6.0, 5.5).subplots())).figure,
    Optimum: _over(plot_convergence),
    StudyTable: lambda table: plot_study(table, ax=figure_of(7.0, 3.2))[0].figure,
}


def _picture(value: Any) -> str:
    """A figure as SVG; nothing without Matplotlib, or where there is nothing to draw."""
    draw = next((draw for kind, draw in PICTURES.items() if isinstance(value, kind)), None)
    if draw is None or find_spec("matplotlib") is None:
        return ""
    try:
        figure = draw(value)
    except (ValueError, KeyError, IndexError):  # no cases, no times, no modes
        return ""
    text = StringIO()
    figure.savefig(text, format="svg", bbox_inches="tight")
    return "".join(text.getvalue().partition("<svg")[1:])
