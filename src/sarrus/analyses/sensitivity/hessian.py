"""Second derivatives of a response: products of its Hessian with directions, by the adjoint differentiated along them.

The states' change along the direction is swept forwards; the adjoint backwards; then its change backwards, with the
contracted second derivatives of every operation (`Lagrangian`) as sources.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property, partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...results import ErrorEstimate, Hessian, Product, StepsTaken, Trajectory
from ...system import System
from ...system.curves.time_derivatives import timed
from ..equations.states_at_rest import places
from ..position.assembly_derivatives import Adjoint, AssemblyDerivatives
from ..position.metric_derivatives import MetricChange
from ..progress import Progress
from .chain.chain import FIELDS, BackwardState, Nodes, SegmentChain, by_joints
from .combined import Composite, Part
from .events.first_order import EventDerivatives
from .events.second_order import EventAdjointChange, EventCurvature
from .gradients import by_parameters, errors_of, run_parameters, stored, within
from .lagrangians.changes import Change, change_at
from .lagrangians.curves import CurveLagrangian
from .parameters.contradictions import refuse
from .parameters.parameters import Design, Parameters
from .responses.evaluation import Evaluation
from .responses.undefined import refuse_undefined
from .run_chain import BackSweep, RunChain, RunTangents
from .steps.second_order import changes_along
from .steps.sweep import PerOperation, unknowns_of

Times: TypeAlias = Callable[[Array], Array]

CURVED = (
    "{}: its force begins or ends with an infinite curvature, as δ^1.5 does, so that second derivatives past this "
    "corner are wrong. Give a contact a rounding, or a formula an exponent of at least 2."
)


class AdjointVariables(NamedTuple):
    """The adjoint variables of all operations, and of the start."""

    operations: PerOperation
    start: tuple[Array, Array]


class AdjointChange(NamedTuple):
    """The changes of the Lagrangians of all operations, and of the start; those of the gradient by the numbers."""

    sources: PerOperation
    start: Change
    b: Array


class CurvedSteps:
    """The steps of one run, differentiated twice.

    Parameters
    ----------
    chain : of the run
    curves : second derivatives by parameters of curves that change, and by the time at which it begins
    """

    def __init__(self, chain: SegmentChain, curves: CurveLagrangian) -> None:
        self._chain, self._system, self._steps, self._curves = chain, chain.system, chain.steps, curves

    def back(
        self, nodes: Nodes, change: AdjointChange | None
    ) -> tuple[tuple[Array, Array, Array], AdjointVariables]:
        """Gradients by the first q and v and by the numbers, and what was solved for, with changes of the equations."""
        chain, sweep = self._chain, self._chain.sweep
        back, solved = BackwardState(chain.by_curves.width, 1), unknowns_of(sweep.record, sweep.columns)
        curves, sources = chain.curves if self._curves else None, change.sources if change else None
        back.over(sweep, curves, nodes, 0, solved=solved, sources=sources)
        if change:
            back.b -= change.b[:, None]
        found = back.through_start(chain.start, nodes, change.start if change else None)
        return found, AdjointVariables(solved, back.of_start)

    def turned(
        self, b_dot: Array, moved: Nodes, stages: PerOperation, adjoint: AdjointVariables
    ) -> AdjointChange:
        """The changes of the equations of all steps.

        With the changes of the numbers, of the nodes and of the stages, and the adjoint variables.
        """
        record, size = self._chain.record, len(self._system.b)
        t_dot = np.full(len(self._steps), b_dot[size:].sum())
        found = changes_along(record, b_dot[:size], stages, adjoint.operations, self._curves, t_dot)
        start, by_b = self._start(b_dot, moved, adjoint.start), np.zeros(len(b_dot))
        by_b[:size] = found.b + start.b
        by_b[size:] += start.t + found.t.sum()
        return AdjointChange(found.sources, start, by_b)

    def _start(self, b_dot: Array, moved: Nodes, adjoint: tuple[Array, Array]) -> Change:
        """The changes of the equations of motion at the start."""
        steps, (y, z), size = self._steps, (x[:, 0] for x in adjoint), len(self._system.b)
        dots = {f"{name}_dot": getattr(moved, name)[0, :, 0] for name in ("q", "v", "a")}
        return change_at(
            self._system, "motion", float(steps.t[0]), remembered(steps, 0), b_dot[:size], steps.lam[0], z,
            moved.lam[0, :, 0], self._curves, float(b_dot[size:].sum()), q=steps.q[0], v=steps.v[0], a=steps.a[0],
            xi=y, **dots,
        )  # fmt: skip


def remembered(steps: StepsTaken, n: int) -> Array:
    """The numbers of the elements, with what they remembered during a step."""
    b = steps.b.copy()
    b[steps.places] = steps.memory[n]
    return b


class RunChange(NamedTuple):
    """The change of a run along a direction: of the numbers and of the states; and what was solved for on the way.

    guess : of q₀ and v₀
    """

    b: Array
    c: Array
    guess: tuple[Array, Array]
    nodes: Nodes
    assembly: tuple[Array, Array, Array, Array]
    within: RunTangents


class Adjoined(NamedTuple):
    """The adjoint of a run: what was solved for in the steps, in the events and in the assembly; the gradient.

    whole : by the parameters of the elements, the guess, and the joints' parameters with the restitutions
    """

    steps: list[AdjointVariables]
    event_steps: list[Array]
    assembly: Adjoint
    whole: Array


class Changes(NamedTuple):
    """The changes of the equations of all steps, of the events and of the assembly."""

    steps: list[AdjointChange]
    event_steps: list[EventAdjointChange]
    rate: Change
    place: Change
    axes: Change
    metric: MetricChange


class CurvedBackSweep(BackSweep):
    """The adjoint of a run, with what was solved for on the way, the last first; or its change along a direction.

    Attributes
    ----------
    steps, event_steps : adjoint variables of segments and of events
    """

    def __init__(
        self, system: System, joints: int, curved: Sequence[CurvedSteps], events: Sequence[EventCurvature],
        changes: Changes | None,
    ) -> None:  # fmt: skip
        super().__init__(system, 1, joints)
        self._curved, self._events, self._changes = curved, events, changes
        self.steps, self.event_steps = list[AdjointVariables](), list[Array]()

    def _through(self, event: EventDerivatives, bars: Array) -> Array:
        p = len(self._events) - 1 - len(self.event_steps)
        change = self._changes.event_steps[p] if self._changes else None
        found, solved = self._events[p].back(bars[:, 0], change)
        self.event_steps.append(solved)
        return found[:, None]

    def _over_steps(self, chain: SegmentChain, nodes: Nodes, lead: StepsTaken | None) -> None:
        p = len(self._curved) - 1 - len(self.steps)
        change = self._changes.steps[p] if self._changes else None
        self._first, solved = self._curved[p].back(nodes, change)
        self.steps.append(solved)

    def _begin(self, chain: SegmentChain) -> None:
        self._to_start(*self._first)


class Curvature:
    """The Hessian of a response of a run, in products.

    Parameters
    ----------
    chain, evaluation, parameters : the run, its only response, and what is differentiated by
    """

    def __init__(self, chain: RunChain, evaluation: Evaluation, parameters: Parameters) -> None:
        self._chain, self._evaluation, self._parameters = chain, evaluation, parameters
        self._system, self._steps = chain.system, chain.steps
        self._chains, self._parts = chain.chains, chain.parts
        self._curves = [
            CurveLagrangian(chain.system, parameters.in_curves, one.moving) for one in self._chains
        ]
        self._curved = [CurvedSteps(*pair) for pair in zip(self._chains, self._curves, strict=True)]
        announce(CURVED.format(one.infinite_curvature) for one in chain.event_steps if one.infinite_curvature)
        curves = CurveLagrangian(chain.system, parameters.in_curves, timed(chain.system))
        self._event_steps = [EventCurvature(one, curves) for one in chain.event_steps]

    @property
    def _assembly(self) -> AssemblyDerivatives:
        return self._chains[0].assembly

    @cached_property
    def _first(self) -> Adjoined:
        """The adjoint, and what does not go through the states."""
        every, explicit = self._evaluation.gradients()
        nodes = Nodes(*(getattr(every, name)[..., :1] for name in FIELDS))
        return self._backward(nodes, explicit.b[:, 0], explicit.c[:, 0], None)

    def _backward(self, nodes: Nodes, b: Array, c: Array, changes: Changes | None) -> Adjoined:
        """Sweep backward through sections, events and the assembly, with the changes of their equations.

        Of gradients by the nodes, and those by the parameters that do not go through the nodes.
        """
        back = CurvedBackSweep(self._system, len(c), self._curved, self._event_steps, changes)
        self._chain.over(back, nodes.copy())
        b, c = b + back.b[:, 0], c + back.c[:, 0]
        of_assembly = self._of_assembly(changes) if changes else None
        assembly = self._assembly.adjoint(back.q[:, 0], back.v[:, 0], of_assembly)
        by_b, by_q, by_v, by_c = assembly[:4]
        if changes:
            metric, by_c = changes.metric, by_joints(by_c, -changes.axes.b)
            b = b - changes.rate.b - changes.place.b + metric.b
            by_q, by_v = by_q + metric.guess, by_v + metric.v
        whole = np.concatenate([b + by_b, by_q, by_v, by_joints(c, by_c)])
        return Adjoined(back.steps[::-1], back.event_steps[::-1], assembly, whole)

    def _of_assembly(self, changes: Changes) -> tuple[Array, Array, Array, Array]:
        """Return the changes of the right sides of the assembly, of q, λ, v and μ."""
        (rate, place, axes, metric), own = changes[2:], self._assembly.rates.selection
        q, mu = rate.q + place.q + axes.q + metric.q, np.concatenate([rate.lam, own @ axes.lam])
        return q, place.lam, rate.v + axes.v + metric.v, mu

    def _along(self, direction: Array) -> RunChange:
        b, q, v, c = self._parameters.along(direction[:, None])
        assembly, within = self._assembly.whole_along(b, dq=q, dv=v, dc=c), RunTangents([], [])
        nodes = self._chain.from_start(assembly[0], assembly[2], b, c, within)
        return RunChange(b, c, (q, v), nodes, assembly, within)

    def times(self, direction: Array) -> Array:
        """The Hessian times a direction of the parameters (p,)."""
        moved, first = self._along(np.asarray(direction, dtype=float)), self._first
        own = {name: np.array([x]) for name, x in zip(self._parameters.names, direction, strict=True)}
        nodes, explicit = self._evaluation.gradient_along(0, moved.nodes, moved.b, moved.c, own)
        second = self._backward(nodes, explicit.b[:, 0], explicit.c[:, 0], self._changes(moved, first))
        found = self._parameters.gradient_along(first.whole, second.whole, direction)
        own_part = [explicit.named[0].get(name, 0.0) for name in self._parameters.names]
        return np.asarray(found + np.array(own_part))

    def _changes(self, moved: RunChange, first: Adjoined) -> Changes:
        """The changes of all equations."""
        system, steps, adjoint, turned = self._system, self._chains[0].steps, first.assembly, []
        found = steps.start
        for p, curved in enumerate(self._curved):
            own = moved.nodes.part(self._parts[p])
            shift = moved.nodes.shift[p] if self._chains[p].by_curves.width > len(moved.b) else np.zeros(0)
            b_dot = np.append(moved.b[:, 0], shift)
            turned.append(curved.turned(b_dot, own, moved.within.steps[p], first.steps[p]))
        events = zip(self._event_steps, moved.within.event_steps, first.event_steps, strict=True)
        event_steps = [one.change(solved, adjoined) for one, solved, adjoined in events]
        b, b_dot, t = remembered(steps, 0), moved.b[:, 0], float(steps.t[0])
        q_dot, lam_dot, v_dot, mu_dot = (x[:, 0] for x in moved.assembly)
        rate = change_at(
            system, "rate", t, b, b_dot, found.mu, -adjoint.y2[: system.m], mu_dot[: system.m], self._curves[0],
            q=found.q, v=found.v, xi=adjoint.x2, q_dot=q_dot, v_dot=v_dot,
        )  # fmt: skip
        states = np.isin(np.arange(system.nq), places(system))  # which are unknowns of an equilibrium
        place = change_at(
            system, self._assembly.lagrangian, t, b, b_dot, found.lam, adjoint.y1, lam_dot, self._curves[0],
            q=found.q, q_dot=q_dot, xi=adjoint.x1, v=self._assembly.rest, v_dot=states * v_dot,
        )  # fmt: skip
        place = place._replace(q=place.q + states * place.v)
        guess_dot = [x[:, 0] for x in moved.guess]
        metric = self._assembly.metric.change_along(*adjoint.guess, b_dot, (q_dot, v_dot), guess_dot)
        return Changes(turned, event_steps, rate, place, self._axes_change(moved, first), metric)

    def _axes_change(self, moved: RunChange, first: Adjoined) -> Change:
        """The changes of the rows of given rates of joints."""
        joints: Any = self._system.joint_coordinates  # they have the structure of a system's constraints
        own, found, adjoint = self._assembly.rates.selection, self._chains[0].steps.start, first.assembly
        if not own.any():
            none = np.zeros(self._system.nq)
            return Change(none, none, none, np.zeros(joints.m), np.zeros(len(joints.b)))
        q_dot, _, v_dot, mu_dot = (x[:, 0] for x in moved.assembly)
        m = self._system.m
        return change_at(
            joints, "rate", 0.0, joints.b, moved.c[: len(joints.b), 0], found.nu @ own, -adjoint.y2[m:] @ own,
            mu_dot[m:] @ own, q=found.q, v=found.v, xi=adjoint.x2, q_dot=q_dot, v_dot=v_dot,
        )  # fmt: skip


@reports_warnings
@one_thread_if_small
def hessian_product(
    run: Trajectory,
    response: Part,
    direction: Mapping[str, float | Sequence[float]],
    wrt: Sequence[str] | None = None,
    *,
    design: Mapping[str, float] | None = None,
    formula: Design | None = None,
    time_limit: float | None = None,
) -> Product:
    """Compute the product of the Hessian of a response with a direction, in about two sweeps.

    Parameters
    ----------
    run, response, design, formula : as for `sensitivity`
    direction : changes by name, three for a vector; others are zero
    wrt : names of the parameters; by default those of the direction
    time_limit : limit in seconds, checked before the sweeps, which are compiled calls

    Returns
    -------
    ndarray (p,)
        in the order of `wrt`, with three entries for each vector, and with ``warnings``
    """
    with within(run.name, None, 2, "differentiated twice", " stages", time_limit) as report:
        times, parameters, _ = _curvature(
            run, Composite(response), [*direction] if wrt is None else wrt, design, formula
        )
        report(1)
        found = times(_direction(direction, parameters.names))
        report(2)
    return Product.of(found)


def _direction(given: Mapping[str, Any], names: Sequence[str]) -> Array:
    """Changes by name in the order of the numbers (p,)."""
    found = np.zeros(len(names))
    for name, value in given.items():
        places = [k for k, own in enumerate(names) if own == name or own.startswith(f"{name}.")]
        if not places:
            raise ValueError(
                f"direction: {name!r} is not among the parameters. Add it to wrt, or leave it out."
            )
        if np.size(value) != len(places) or not np.isfinite(value).all():
            raise ValueError(
                f"the direction of {name} must be {len(places)} finite numbers, but is {value}. Give them as a list."
            )
        found[places] = np.ravel(value)
    return found


@reports_warnings
@one_thread_if_small
def hessian(
    run: Trajectory,
    response: Part,
    wrt: Sequence[str],
    *,
    design: Mapping[str, float] | None = None,
    formula: Design | None = None,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    error: bool = False,
) -> Hessian:
    """Compute the second derivatives of a response with respect to parameters, exact for the computed steps.

    Parameters
    ----------
    run, response, design, formula : as for `sensitivity`
    wrt : names of the parameters; each costs the two sweeps of a `hessian_product`
    progress : True for a bar on standard error, or a function of the number of completed products
    time_limit : limit in seconds, checked after each product, whose sweeps are compiled calls
    error : whether the error of the value of the response is estimated, too (`Hessian.error`)

    Raises
    ------
    ValueError
        As `sensitivity`, and where `wrt` names nothing.
    """
    if not wrt:
        raise ValueError(
            "wrt names no number by which the response is differentiated twice. Name at least one."
        )
    with within(run.name, progress, len(wrt), "differentiated twice by", " parameters", time_limit) as report:
        outer = Composite(response)
        times, parameters, errors = _curvature(run, outer, wrt, design, formula, error)
        system = parameters.system
        report(0)
        rows = []
        for number, direction in enumerate(np.eye(len(parameters.names)), start=1):
            rows.append(times(direction))
            report(number)
        matrix = np.array(rows)
    bar = errors[0] if errors else None
    names, units = tuple(parameters.names), parameters.units
    unit = outer.units(system)[0]
    return Hessian(
        outer.titles[0], names, matrix, bar, response_unit=unit, units=units, table_units=parameters.table_units,
    )  # fmt: skip


def _products(outer: Composite, chain: RunChain, evaluation: Evaluation, parameters: Parameters) -> Times:
    """The Hessian of a response in products, of the values and the gradients of its parts."""
    wanted = outer.parts
    several = len(wanted) > 1
    own = [Evaluation(parameters.system, chain.steps, [one], parameters) for one in wanted if several]
    curvatures = [Curvature(chain, one, parameters) for one in own or [evaluation]]

    def of_part(place: int, direction: Array) -> Array:
        return curvatures[place].times(direction)

    def gradients() -> Array:
        nodes, explicit = evaluation.gradients()
        return by_parameters(chain.gradients(nodes), parameters, explicit)

    return partial(outer.curved, 0, evaluation.values, cache(gradients), of_part)


def _curvature(
    run: Trajectory, outer: Composite, wrt: Sequence[str], design: Any, formula: Any, error: bool = False
) -> tuple[Times, Parameters, Sequence[ErrorEstimate]]:
    system, steps = stored(run)
    parameters = run_parameters(run, system, steps.start, wrt, design, formula)
    refuse(system, steps, parameters)
    wanted = outer.parts
    evaluation = Evaluation(system, steps, wanted, parameters)
    refuse_undefined((one.title for one in wanted), evaluation.values)
    chain = RunChain(system, steps, parameters.of_run)
    errors = errors_of(outer, evaluation, chain) if error else ()
    return _products(outer, chain, evaluation, parameters), parameters, errors
