"""The workspace of a system, in one call."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import Executor
from typing import Any

from ...linalg.threads import one_thread_if_small
from ...model.announcement import reports_warnings
from ...results.maps.workspace import Workspace
from ...system import System
from ..arguments import refuse_for_positions
from ..progress import Progress
from .problem.arguments import refuse_counts
from .problem.formulation import Limits
from .problem.watch import POINTS, watched
from .regions.mapping import REPEATS, WorkspaceMap
from .regions.verification import reported, tested
from .tracing.curve import LONGEST


@reports_warnings
@one_thread_if_small
def workspace(
    system: System,
    output: Iterable[Any],
    *,
    limits: Limits | None = None,
    fixed: Mapping[Any, float] | None = None,
    verify: bool = True,
    samples: int = 1000,
    rays: int = 30,
    seed: int = 0,
    repeats: int = REPEATS,
    longest: float = LONGEST,
    executor: Executor | None = None,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    strict: bool = False,
) -> Workspace:
    """Compute the workspace of two outputs: boundary, voids, barriers and crossable curves.

    Candidates for the boundary are positions at which the gradients of the outputs depend on those of the constraints
    and of the limits that are reached: Φ_qᵀ lam + ... + Uᵀ c = 0. They are traced as curves by pseudo-arclength
    continuation with exact derivatives up to the third, from random starts and from rays. Second-order terms on both
    sides of a curve determine its kind; see the guide to workspaces.

    Parameters
    ----------
    system : System
        Drivers are ignored; redundant equations are allowed.
    output : two functions of the position
        Names (``"slider.x"``, ``"pin.angle"``, ``"platform.rotation_z"``) or functions of the model
        (``tool.point(1, 0, 0)["x", "y"]``, `sarrus.Rotation`).
    limits : function -> (lowest, highest) [m] or [rad], None for no limit
        Joint coordinates by name, and also `sarrus.Length` of legs that are not modelled. ``"model"`` takes those of
        a robot description.
    fixed : function -> constant value, such as an orientation
    verify : whether the map is tested by random positions, rays and inverse kinematics
    samples, rays : number of positions and rays in these tests
    seed : of all random numbers
    repeats : number of consecutive starts without a new curve after which the map is complete
    longest : longest step along curves, without units; smaller values give more points
    executor : any executor of `concurrent.futures`, on which positions and rays of the tests are drawn
    progress : True for a line on the terminal, or a function that is called with the number of points traced so far
    time_limit : seconds of the clock after which it ends with the status "time limit" and what was found
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    Workspace
        Printed, it is a summary with the reliability of the result.

    Raises
    ------
    SarrusError
        If a name is unknown or the mechanism cannot be assembled within its limits.
    """
    refuse_for_positions(system, "workspace")
    refuse_counts(samples=samples, rays=rays)
    found = WorkspaceMap(
        system, output, limits=limits, fixed=fixed, seed=seed, repeats=repeats, longest=longest
    )
    with watched(progress, done="traced", unit=POINTS, time_limit=time_limit):
        found.tried()
        sound = found.stop is None and not found.explorer.endless
        tests = tested(found, samples, rays, executor) if verify and sound else None
    return reported(found, tests)
