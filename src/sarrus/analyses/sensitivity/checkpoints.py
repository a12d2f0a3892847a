"""The gradient of a long run in little memory: states are stored now and then, the steps between them are taken again.

Twice the steps of the run, and memory for one interval of them besides the checkpoints; see `LongRun`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...algebra import Array
from ...defaults import ATOL
from ...linalg.threads import one_thread_if_small
from ...model.announcement import reports_warnings
from ...results import Assembly, ErrorEstimate, Gradient
from ...system import System
from ..dynamics import Event
from ..dynamics.events.events import restitutions_of
from ..dynamics.integrators.differentiable import Differentiable, differentiable
from ..dynamics.recipe import refuse_end, rtol_of
from ..dynamics.stepping.stepper import RunFailure, Settings
from ..dynamics.stepping.tolerance import Absolute, Given, Tolerances
from ..equilibria.settled_derivatives import derivatives_of
from ..position.initial_state import Start, start_of
from ..progress import Progress, TimeLimit, monitor
from .accuracy.estimate import effects_of, estimates
from .chain.chain import Nodes
from .combined import Composite
from .derivatives import Wanted
from .gradients import gradient_of
from .long_gradient import LongGradient
from .long_run import Interval, LongRun
from .parameters.parameters import Design, Parameters
from .responses.responses import Response
from .responses.undefined import refuse_undefined

# What a step takes at the most, as multiples of the state's size: itself, twice; gradients for each response
STEP, GRADIENT = 20, 10


@reports_warnings
@one_thread_if_small
def sensitivity_by_checkpoints(
    system: System,
    responses: Wanted,
    wrt: Sequence[str] | None = None,
    *,
    until: float,
    start: Start | None = None,
    method: Differentiable | None = None,
    rtol: Given | None = None,
    atol: Absolute = ATOL,
    max_step: float = np.inf,
    events: Event | Sequence[Event] = (),
    memory: float = 100e6,
    design: Mapping[str, float] | None = None,
    formula: Design | None = None,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    error: bool = False,
    strict: bool = False,
) -> Gradient:
    """Simulate and compute a gradient with limited memory, by checkpoints; see `simulate` and `sensitivity`.

    Parameters
    ----------
    system, until, start, method, rtol, atol, max_step, events : as for `simulate`
    responses, wrt, design, formula, error : as for `sensitivity`
    memory : for stored states, events, and the steps between two stored states [bytes]
    progress : True for a bar on standard error, or a function of the simulated time, forwards and backwards: it goes to
        twice `until`
    time_limit : seconds of the clock after which the analysis is given up
    strict : raise the first warning as a `StrictError`

    Raises
    ------
    ValueError
        For an end time that is none, where the memory is too small, and where the run does not reach its end or not
        within the time limit.
    """
    begin = start_of(system, start, "sensitivity_by_checkpoints")
    refuse_end(until, begin.t)
    watched = [events] if isinstance(events, Event) else list(events)
    if not begin.success:
        raise ValueError(f"derivatives need a start that is assembled, but {system.name}: {begin.message}")
    parameters = Parameters(
        system, wrt, design=design, formula=formula, start=begin, restitutions=restitutions_of(watched)
    )
    try:
        with monitor(progress, 2 * until, done="differentiated", time_limit=time_limit) as report:
            back = partial(_backwards, report, 2 * until)
            task = LongTask(begin, until, method, rtol, atol, max_step, watched, memory, report, back, error)
            outer = Composite(responses)
            return outer.gradient(task.gradient(system, outer.parts, parameters), system)
    except (RunFailure, TimeLimit) as error:
        message = error.message if isinstance(error, RunFailure) else error
        raise ValueError(
            f"derivatives need a run that reached its end, but {system.name}: {message}"
        ) from None


def _backwards(report: Progress, whole: float, t: float) -> None:
    """Progress of the sweep, which has come back to a time."""
    report(whole - t)


@dataclass(frozen=True, eq=False)
class LongTask:
    """Options of the simulation of a long run, with the memory; see `sensitivity_by_checkpoints`.

    Attributes
    ----------
    progress, back : called with the time reached forwards, and then backwards
    error : whether errors are estimated, too
    """

    start: Assembly
    until: float
    method: Differentiable | None
    rtol: Given | None
    atol: Absolute
    max_step: float
    events: Sequence[Event]
    memory: float
    progress: Callable[[float], None] | None = None
    back: Callable[[float], None] | None = None
    error: bool = False

    def gradient(self, system: System, responses: Sequence[Response], parameters: Parameters) -> Gradient:
        """Values and derivatives of responses.

        Raises
        ------
        RunFailure
            Where the end is not reached.
        """
        per_step = 8 * (system.nq + system.m) * (STEP + GRADIENT * len(responses))
        method = differentiable(self.method)
        tolerances = Tolerances.of(system, rtol_of(method, self.rtol), self.atol)
        settings = Settings(tolerances, self.max_step, store_steps=True)
        message = (self.start, method, settings, self.until, self.memory, per_step)
        run = LongRun(system, *message, self.events, self.progress)
        return _gradient(run, responses, parameters, self.back, self.error)


class _EffectsOnValues:
    """Sums of `Effects` over all intervals of a sweep; see `Watch`."""

    def __init__(self, system: System, count: int) -> None:
        self._system, self.sums = system, np.zeros((3, count))

    def take(self, n: int, interval: Interval, given: Nodes, adjoints: Sequence[Array]) -> None:
        self.sums += effects_of(self._system, interval.steps, adjoints).sums


def _gradient(
    run: LongRun, responses: Sequence[Response], parameters: Parameters, report: Callable[[float], None] | None,
    error: bool,
) -> Gradient:  # fmt: skip
    """Values and derivatives of all responses, and errors of values."""
    own, watch = LongGradient(run, responses, parameters), _EffectsOnValues(run.system, len(responses))
    found = own.swept(report, watch if error else None)
    refuse_undefined(own.titles, found.values)
    errors: tuple[ErrorEstimate, ...] = ()
    if error:
        errors = estimates(own.titles, found.values, watch.sums, own.rule_errors(found.values))
    assembly = derivatives_of(run.system, run.start)
    return gradient_of(responses, parameters, run.start, assembly, *found, errors)
