"""Singular configurations of inputs or outputs of a mechanism, in coordinates of the outputs and of the inputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model import SarrusError
from ...model.announcement import announce, reports_warnings
from ...results.maps.input_singularities import InputSingularities, Lost, SingularCurve
from ...results.maps.workspace import DENSE, Status
from ...system import System
from ..arguments import refuse_for_positions
from ..progress import Progress
from .problem.arguments import functions, measures
from .problem.formulation import Limits, formulate, refuse_inputs
from .problem.rows import Problem
from .problem.watch import POINTS, stopped, watched
from .regions.arc import Arc
from .regions.mapping import REPEATS, WorkspaceMap
from .tracing.explore import Branch
from .tracing.starts import changes

CROSSINGS = 100  # by random walks, in a row of known curves, until the curves count as complete


@reports_warnings
@one_thread_if_small
def input_singularities(
    system: System,
    output: Iterable[Any],
    inputs: Iterable[Any],
    *,
    lost: Lost = "inputs",
    limits: Limits | None = None,
    fixed: Mapping[Any, float] | None = None,
    seed: int = 0,
    repeats: int = REPEATS,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
) -> InputSingularities:
    """Trace singular configurations, in which inputs or outputs lose control of the motion.

    With ``lost="inputs"``, Φ_qᵀ lam + V_qᵀ ν = 0: the inputs cannot support a load, and assembly modes coincide (type
    2, or parallel, singularities). With ``lost="outputs"``, Φ_qᵀ lam + U_qᵀ c = 0: the outputs cannot move in some
    direction, and solutions of the inverse kinematics coincide (type 1, or serial, singularities). The curves are given
    in the outputs and in the inputs.

    Parameters
    ----------
    system, limits, seed, repeats : see `sarrus.workspace`; the curves end at limits
    output : two functions, the axes of the curves
    inputs : as many functions as there are degrees of freedom
    lost : which functions lose a direction, "inputs" or "outputs"
    fixed : values of functions that select a section, one for each degree of freedom beyond two
    progress : True for a line on the terminal, or a function that is called with the number of points traced so far
    time_limit : seconds of the clock after which it ends with the status "time limit" and what was found

    Raises
    ------
    SarrusError
        If the numbers of inputs or fixed functions do not fit the degrees of freedom.
    """
    refuse_for_positions(system, "input_singularities")
    if lost not in ("inputs", "outputs"):
        raise SarrusError(f"lost: must be 'inputs' or 'outputs', got {lost!r}. Pass one of them.")
    driven = functions(inputs)
    problem = formulate(system, output, limits=limits, fixed=fixed, inputs=driven, singular=lost)
    _refuse_counts(problem, len(driven))
    table = [one.title for one in problem.table]
    known = [one.measured for one in problem.table]
    places = [known.index(one.measured) for one in measures(system, driven)]
    map_, crossed = WorkspaceMap.of(problem, seed, repeats), [0]
    with watched(progress, done="traced", unit=POINTS, time_limit=time_limit):
        map_.stop = stopped(lambda: crossed.append(_follow_changes(map_.run(), seed)))
    status, message = _status(map_, crossed[-1])
    found = InputSingularities(
        system.name,
        tuple(table[k] for k in problem.outputs),
        tuple(table[k] for k in places),
        tuple(_curve(branch, places) for branch in map_.branches if _is_singular(branch)),
        status,
        f"{system.name}: {message}",
        lost,
        tuple(problem.table[k].unit for k in problem.outputs),
        tuple(problem.table[k].unit for k in places),
        tuple(problem.limits.get(k, (-np.inf, np.inf)) for k in places),
    )
    announce([] if found.success else [f"{found.message}."])
    return found


def _status(map_: WorkspaceMap, crossed: int) -> tuple[Status, str]:
    """The status of the curves, and why."""
    lost = [branch.failure for branch in map_.branches if branch.failure]
    if map_.stop:
        return map_.stop.status, f"{map_.stop.reason}. Curves may be missing"
    if map_.explorer.endless:
        return "incomplete", "curves cross each other without end. Fix other values, a little beside these"
    if lost:
        return "incomplete", f"{len(lost)} curves broke off, the first because {lost[0]}. Try another seed"
    walks = f"the last {crossed} crossings by random walks were of known curves"
    return "mapped", f"no curve broke off; {walks if crossed else 'random walks crossed none'}"


def _follow_changes(map_: WorkspaceMap, seed: int) -> int:
    """Trace what random walks cross; how many crossings in a row were of known curves in the end."""
    in_a_row = 0
    for start in changes(map_.problem, seed + 1):
        led = map_.explorer.start(*start)
        if led != "lost":
            in_a_row = 0 if led == "new" else in_a_row + 1
        map_.run()
        if in_a_row >= CROSSINGS:
            break
    return in_a_row


def _refuse_counts(problem: Problem, inputs: int) -> None:
    if len(problem.outputs) != 2:
        raise SarrusError(
            f"output: singular curves require two outputs, got {len(problem.outputs)}. Name two."
        )
    refuse_inputs(problem, inputs, problem.unfixed)
    if problem.freedoms != 2:
        message = f"{problem.system.name}: {problem.freedoms} degrees of freedom beside what is fixed"
        raise SarrusError(f"{message}. Fix functions until two are left, so that singularities are curves.")


def _is_singular(branch: Branch) -> bool:
    """Whether the mechanism itself loses a direction, and not only because a limit is reached."""
    return not branch.stratum.problem.of_outputs or branch.stratum.dimension > 1


def _curve(branch: Branch, driven: list[int]) -> SingularCurve:
    p, steps = branch.stratum.problem, branch.steps()
    closed = branch.start is branch.end and branch.start.kind == "seed"
    v = _along(branch, driven)
    return SingularCurve(
        np.array([point.u for point in branch.points]) * p.units[p.outputs],
        Arc(np.array([step.quintic() for step in steps])).polyline * p.units[p.outputs],
        v[::DENSE],
        v,
        np.array([point.x[: p.n] for point in branch.points]) * p.scale,
        closed,
    )


def _along(branch: Branch, driven: list[int]) -> Array:
    """The inputs along a branch, `DENSE` times for each step; angles go on from each other."""
    p, steps = branch.stratum.problem, branch.steps()
    inner = [step.x(n / DENSE) for step in steps for n in range(DENSE)]
    values = np.array([p.values(x[: p.n]) for x in (*inner, steps[-1].b.x)])
    columns = []
    for k in driven:
        shown = p.shown(k, values[:, p.m + k])
        columns.append(np.unwrap(shown) if p.table[k].kind == "angle" else shown)
    return np.stack(columns, axis=1)
