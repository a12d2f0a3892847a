"""Manipulability and range of orientation over a workspace, by inverse kinematics on a grid."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any

import numpy as np

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model import SarrusError
from ...model.announcement import announce, reports_warnings
from ...results.maps.workspace import Workspace
from ...results.maps.workspace_field import Quantity, WorkspaceField
from ..progress import Progress
from .dexterity import dexterity_at
from .problem.arguments import functions, refuse_counts
from .problem.formulation import TURN, formulate
from .problem.random_positions import Samples
from .problem.rows import Problem
from .problem.settle import reach
from .problem.watch import CELLS as COUNTED
from .problem.watch import Stop, stopped, watched
from .regions.flood import Flood, around
from .regions.mapping import map_of

CELLS = {2: 60, 3: 30}
STARTS = 200  # random positions from which assembly modes are filled
TRIES = 8  # known positions nearby, of a place that nothing led to


@reports_warnings
@one_thread_if_small
def workspace_field(
    found: Workspace,
    inputs: Iterable[Any] = (),
    *,
    turn: Any = None,
    cells: int | None = None,
    starts: int = STARTS,
    seed: int = 0,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    strict: bool = False,
) -> WorkspaceField:
    """Compute dexterity, number of solutions and range of orientation on a grid in a workspace.

    All solutions of the inverse kinematics are computed at the centres of the cells of a grid: from random positions,
    by Newton's method from the solutions of neighbouring cells, and along motions with constant outputs.

    Parameters
    ----------
    found : Workspace
        With two degrees of freedom besides the fixed functions, or three for the range of orientation.
    inputs : functions of the position, as many as there are degrees of freedom; without them, manipulability and
        conditioning are left out
    turn : an angle whose range is computed, such as ``"platform.rotation_z"``, with three degrees of freedom
    cells : number of cells along the longer side of the boundary; by default 60, or 30 with three degrees of freedom
    starts : number of random positions
    seed : of the random positions
    progress : True for a bar on the terminal, or a function that is called with the number of cells filled so far
    time_limit : seconds of the clock after which it ends with the cells filled so far, and a warning
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    WorkspaceField
        `solutions` where they are single; `manipulability`, sqrt(det J Jᵀ), and `conditioning`, the inverse of J's
        condition number, of the best and of the worst solution at each place; `turn`, the length [rad] of all values
        that the angle can have there.

    Raises
    ------
    SarrusError
        If a name is unknown, numbers of inputs and degrees of freedom do not fit, or nothing can be reached.
    """
    refuse_counts(starts=starts, seed=seed, **({} if cells is None else {"cells": cells}))
    map_ = map_of(found)
    _, output, limits, fixed = map_.asked
    driven, rotating = list(functions(inputs)), [] if turn is None else [turn]
    problem = formulate(
        map_.problem.system,
        output,
        limits=limits,
        fixed=fixed,
        inputs=[*driven, *rotating],
        singular="inputs",
    )
    _refuse_counts(problem, len(driven), bool(rotating))
    _refuse_nothing(found)
    x, y, inside = _grid(found, CELLS[problem.freedoms] if cells is None else cells)
    if not inside.any():
        raise SarrusError(f"{found.name}: no cell's centre lies inside. Give more cells.")
    units = problem.units[problem.outputs]
    places = np.stack(np.meshgrid(x, y), axis=-1)[inside] / units
    flood = Flood(problem, places, list(around(inside)))
    drawn = islice(Samples(problem, seed), starts)
    with watched(progress, len(places), done="filled", unit=COUNTED, time_limit=time_limit):
        stop = stopped(lambda: _fill(flood, drawn, map_.met))
    values = {
        name: np.full(inside.shape, np.nan) for name in _quantities(problem, bool(driven), bool(rotating))
    }
    for name, column in _columns(flood, problem.normal[: len(driven)], problem.normal[len(driven) :]):
        values[name][inside] = column
    names = [problem.table[k].name for k in problem.normal]
    rotation = names[-1] if rotating else ""
    counts = [len(some) for some in flood.at]
    field = WorkspaceField(
        found,
        tuple(names[: len(driven)]),
        rotation,
        x,
        y,
        values,
        sum(counts),
        counts.count(0),
        stop.status if stop else "incomplete" if 0 in counts else "mapped",
    )
    announce([] if field.success else [_shortcoming(field, stop)])
    return field


def _shortcoming(field: WorkspaceField, stop: Stop | None) -> str:
    if stop:
        return (
            f"{field.name}: {stop.reason}, and solutions are missing. Allow more time, or give fewer cells."
        )
    message = f"{field.name}: no position was found at {field.missed} places inside the boundary"
    return f"{message}. Give more starts."


def _refuse_counts(problem: Problem, inputs: int, rotating: bool) -> None:
    name, freedoms = problem.system.name, problem.freedoms
    if freedoms not in (2, 3):
        raise SarrusError(
            f"{name}: {freedoms} degrees of freedom are too many. Fix functions until two or three are left."
        )
    held = len(problem.fixed) - len(problem.locked)
    if inputs not in (0, freedoms, freedoms + held):
        given = "1 input is" if inputs == 1 else f"{inputs} inputs are"
        message = f"{name}: {freedoms} degrees of freedom, but {given} given"
        raise SarrusError(f"{message}. Give as many inputs.")
    if rotating and freedoms == 2:
        raise SarrusError(f"{name}: no rotation is free while two outputs are constant. Leave `turn` out.")
    if rotating and problem.table[problem.normal[-1]].kind != "angle":
        raise SarrusError(
            f"{problem.table[problem.normal[-1]].name}: is no angle. Pass the name of an angle as `turn`."
        )
    if not inputs and not rotating and freedoms == 3:
        raise SarrusError(
            f"{name}: there are infinitely many solutions at every place. Name its inputs, or the rotation (turn)."
        )


def _refuse_nothing(found: Workspace) -> None:
    if not any(part.loops for part in found.components):
        raise SarrusError(f"{found.name}: nothing can be reached, so there is no field. See its message.")


def _grid(found: Workspace, cells: int) -> tuple[Array, Array, Array]:
    """Centres of cells around the boundary, and which of them lie inside."""
    corners = np.concatenate([loop for part in found.components for loop in part.loops])
    low, high = corners.min(axis=0), corners.max(axis=0)
    alike = found.units[0] == found.units[1]
    size = (high - low).max() / cells if alike else (high - low) / cells
    counts = np.maximum(np.ceil((high - low) / size - 1e-9), 1).astype(int)
    first = 0.5 * (low + high) - 0.5 * (counts - 1) * size
    x, y = (a + np.arange(n) * h for a, n, h in zip(first, counts, np.broadcast_to(size, 2), strict=True))
    points = np.stack(np.meshgrid(x, y), axis=-1)
    return x, y, found.contains(points.reshape(-1, 2)).reshape(points.shape[:2])


def _fill(flood: Flood, drawn: Iterable[Array], met: Iterable[Array]) -> None:
    """All positions that random ones lead to; a place that nothing led to is tried from those nearest to it."""
    problem, places = flood.problem, flood.places
    outputs = problem.m + problem.outputs
    for q in (*met, *drawn):
        away = np.linalg.norm(places - problem.values(q)[outputs], axis=1)
        flood.take(int(np.argmin(away)), q)
    flood.spread()
    random = np.random.default_rng(0)
    for k in [k for k, some in enumerate(flood.at) if not some]:
        near = np.argsort(np.linalg.norm(places - places[k], axis=1))[: 4 * TRIES]
        known = [q for other in near for q in flood.at[other]]
        there = reach(problem, places[k], np.array(known), TRIES, random) if known else None
        if there is not None:
            flood.take(k, there)
            flood.spread()


def _quantities(problem: Problem, driven: bool, rotating: bool) -> list[Quantity]:
    by_inputs: list[Quantity] = [
        "manipulability",
        "worst_manipulability",
        "conditioning",
        "worst_conditioning",
    ]
    found: list[Quantity] = ["solutions"] if problem.freedoms == 2 else []
    return [*found, *(by_inputs if driven else []), *(["turn"] if rotating else [])]  # type: ignore[list-item]


def _columns(flood: Flood, driven: Array, rotating: Array) -> Iterator[tuple[Quantity, Array]]:
    """Quantities at all places."""
    problem = flood.problem
    if problem.freedoms == 2:
        yield "solutions", np.array([len(some) or np.nan for some in flood.at])
    if len(driven):
        measures = [[dexterity_at(problem, q, driven) for q in some] for some in flood.at]
        for name in ("manipulability", "conditioning"):
            numbers = [[getattr(one, name) for one in some] or [np.nan] for some in measures]
            best: Quantity = "manipulability" if name == "manipulability" else "conditioning"
            worst: Quantity = "worst_manipulability" if name == "manipulability" else "worst_conditioning"
            yield best, np.array([max(some) for some in numbers])
            yield worst, np.array([min(some) for some in numbers])
    if len(rotating):
        yield "turn", np.array([_range(problem, rotating[0], strides) for strides in flood.strides])


def _range(problem: Problem, turn: int, strides: list[tuple[Array, Array]]) -> float:
    """The length of all values of an angle along strides."""
    ends = np.array([[problem.values(q)[problem.m + turn] for q in pair] for pair in strides])
    if not len(ends):
        return float("nan")
    change = (ends[:, 1] - ends[:, 0] + np.pi) % TURN - np.pi
    first = np.where(change < 0, ends[:, 1], ends[:, 0]) % TURN
    parts = np.column_stack([first, first + abs(change)])
    over = parts[:, 1] > TURN
    wrapped = np.column_stack([np.zeros(over.sum()), parts[over, 1] - TURN])
    return _covered(np.concatenate([np.minimum(parts, TURN), wrapped]))


def _covered(parts: Array) -> float:
    """The length of the union of intervals (k, 2)."""
    total, end = 0.0, -np.inf
    for low, high in parts[np.argsort(parts[:, 0])].tolist():
        total += max(0.0, high - max(low, end))
        end = max(end, high)
    return total
