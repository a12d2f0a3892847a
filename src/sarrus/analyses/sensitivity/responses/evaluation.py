"""Responses evaluated on a run: their values, and their gradients by its states and by the numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, TypeAlias

import numpy as np

from ....algebra import Array
from ....model.tape import Tracer
from ....outputs import Outputs
from ....outputs.recording import Angles, Key
from ....results import Segments, StepsTaken
from ....system import System
from ...position.assembly_derivatives import NoDerivative
from ..chain.chain import Nodes
from ..parameters.parameters import Parameters
from ..sampling.consistent import ConsistentSampling
from ..sampling.reported import Reporter
from ..sampling.sampling import READ, Sampling, angles_of
from ..sampling.segments import (
    Course,
    Instants,
    NoSample,
    at_event,
    course_of,
    fixed,
)
from ..steps.sweep import PerOperation
from .panels import ABOUT, PARTS, Layout, Panels, Steps, between_kinks
from .responses import AtEvent, ExtremeValue, Integral, Response, of_whole_run
from .undefined import (
    along_with_weight,
    change_of_gradient,
    change_with_weight,
    gradient_of,
)

MOTION = ("a", "lam")
# Of the slopes of an output on both sides of a kink: those of round-off differ by no more
TOUCHES = 1e-7


@dataclass(frozen=True)
class DirectTerms:
    """Gradients of responses that do not go through the states: by b, by the joints' numbers, by named parameters."""

    b: Array
    c: Array
    named: list[dict[str, float]]


Where: TypeAlias = "Instants | Panels"


def placed(course: Course, response: Response) -> Where:
    """Where a response is sampled: at its times, or in all steps."""
    try:
        if isinstance(response, AtEvent):
            return at_event(course, response.event, response.number, response.after)
        times = response.times(course.times)
        if times is not None:
            return fixed(course, times)
    except NoSample as wrong:
        raise NoSample(f"{response.title}: {wrong}") from None
    steps = Steps.of(course)
    panels = Panels.some(slice(0, len(steps.end)))
    return panels.where(steps) if response.pointwise else panels


Taken: TypeAlias = tuple[Response, Sampling, Outputs, Tracer]


def _arguments(where: Sampling, outputs: Outputs) -> list[Array]:
    """The arguments of absolute values at the times of an output (nt,)."""
    values = (np.asarray(outputs.tape.values[at], dtype=float) for at in outputs.tape.kinks)
    return [np.broadcast_to(x, where.t.shape) for x in values]


def _summits(g: Array) -> Array:
    """Which samples are not lower than both neighbours (nt,)."""
    rises = np.diff(g, prepend=-np.inf, append=-np.inf)
    return (rises[:-1] >= 0) & (rises[1:] <= 0)


class Evaluation:
    """Responses of one run.

    Parameters
    ----------
    system, steps : the run
    responses : evaluated in this order
    parameters : whose numbers responses may use
    angles : with their revolutions; by default counted along all nodes of the run
    where : each response is sampled; by default see `placed`

    Attributes
    ----------
    outermost : the sample of each extreme, not a number for other responses (r,)
    """

    def __init__(
        self,
        system: System,
        steps: StepsTaken | Segments,
        responses: Sequence[Response],
        parameters: Parameters,
        angles: Angles | None = None,
        where: Sequence[Where] | None = None,
    ) -> None:
        self._precise = (steps.segments[0] if isinstance(steps, Segments) else steps).precise
        self._system, self._steps, self._parameters = system, steps, parameters
        self._c_size, self._angles = parameters.c_size, angles or angles_of(system, steps)
        self._samplings, self._outputs = list[Sampling](), list[Outputs]()
        self._responses, self._found = list[Response](), list[Tracer]()
        self._panels = list[Panels | None]()
        self._reported, self.outermost = Reporter(system, steps), np.full(len(responses), np.nan)
        if where is None:
            responses = [of_whole_run(system, response) for response in responses]
            where = [placed(course_of(steps), response) for response in responses]
        for response, own in zip(responses, where, strict=True):
            self._add(response, own)
        responses = self._responses
        self.signals = [*map(self._signal, self._samplings, self._found)]
        self.values = np.array(
            [r.value(g, s.t) for r, g, s in zip(responses, self.signals, self._samplings, strict=True)]
        )

    def _add(self, response: Response, where: Where) -> None:
        """Evaluate one more response; an integral in parts of steps between its kinks, an extreme about its place."""
        panels: Panels | None = None
        if isinstance(where, Instants):
            taken = response, *self._evaluated(response, Sampling(self._steps, where))
        elif isinstance(response, ExtremeValue):
            taken = self._about(response, where)
        else:
            taken, panels = self._between_kinks(replace(response, reported=()), where, PARTS)
        self._append(*taken)
        self._panels.append(panels)

    def _append(self, response: Response, sampling: Sampling, outputs: Outputs, found: Tracer) -> None:
        self._responses.append(response)
        self._samplings.append(sampling)
        self._outputs.append(outputs)
        self._found.append(found)

    def _about(self, response: ExtremeValue, where: Panels) -> Taken:
        """An extreme in the panels on both sides of the outermost sample of some steps.

        Of reported states; those between the nodes of methods of order two are smooth in q and v.
        """
        raw, every = replace(response, reported=()), where.where(self._course)
        sampling, outputs, found = self._evaluated(raw, Sampling(self._steps, every))
        g = self._signal(sampling, found)
        if not {kind for kind, _ in outputs.inputs}.isdisjoint(MOTION):
            g = self._at_summits(raw, every, g)
        if not self._course.last[where.step[-1]]:  # the steps behind begin with the last sample
            g = g[:-1]
        sample = response.outermost(g)
        self.outermost[len(self._responses)] = g[sample]
        near = self._course.about(len(PARTS) * int(where.step[0]) + sample)
        kinds = READ if self._precise else MOTION
        own = replace(response, layout=Layout(size=len(ABOUT)), reported=kinds)
        return self._between_kinks(own, near, ABOUT)[0]

    @cached_property
    def _course(self) -> Steps:
        return Steps.of(course_of(self._steps))

    @staticmethod
    def _signal(where: Sampling, found: Tracer) -> Array:
        """An output at its times (nt,)."""
        return np.broadcast_to(np.asarray(found.value, dtype=float), where.t.shape)

    def _between_kinks(self, response: Response, panels: Panels, parts: Array) -> tuple[Taken, Panels]:
        """A response in panels that are split at its kinks."""
        where = Sampling(self._steps, panels.where(self._course, parts))
        where, outputs, found = self._evaluated(response, where)
        if not outputs.tape.kinks:
            return (response, where, outputs, found), panels
        values, arguments = _arguments(where, outputs), partial(self._arguments, response)
        panels = between_kinks(self._course, panels, values, parts, arguments)
        return self._in_panels(response, panels, parts), panels

    def _in_panels(self, response: Response, panels: Panels, parts: Array) -> Taken:
        """A response between its kinks, on each side of which absolute values have one sign."""
        steps = self._course
        middle = self._arguments(response, panels.where(steps, np.array([0.5])))
        sides = np.sign(np.reshape(middle, (-1, len(panels.step))))
        near = steps.segment[panels.step[1:]] == steps.segment[panels.step[:-1]]
        kinks = np.flatnonzero(near & np.any(sides[:, 1:] != sides[:, :-1], axis=0))
        layout = Layout((kinks + 1) * len(parts) - 1, len(parts))
        own = replace(response, layout=layout)
        where = Sampling(self._steps, panels.where(steps, parts))
        return own, *self._evaluated(own, where, list(np.repeat(sides, len(parts), axis=1)))

    def _at_summits(self, response: ExtremeValue, where: Instants, g: Array) -> Array:
        """An output (nt,) as it is reported at summits of all samples and of the nodes; the least between.

        In long steps that accelerations or reactions do not bound, those between the nodes may be far off.
        """
        own, every = response.sign * g, np.arange(len(g))
        parts = every, np.flatnonzero(np.isin(every % len(PARTS), (0, len(PARTS) - 1)))
        found = np.full(len(g), -response.sign * np.inf)
        rows = np.unique(np.concatenate([part[_summits(own[part])] for part in parts]))
        there = Sampling(self._steps, Instants(*(x[rows] for x in where)))
        at, _, output = self._evaluated(replace(response, reported=READ), there)
        exact = self._signal(at, output)
        found[rows] = np.where(np.isfinite(exact), exact, g[rows])  # in singular configurations there is none
        return found

    def rule_error(self, n: int) -> float:
        """Return the sampling error of an integral: of its value and that with twice as many samples."""
        panels, response = self._panels[n], self._responses[n]
        if panels is None:
            return 0.0
        own = replace(response, reported=READ)
        own, where, _, found = self._in_panels(own, panels.halves(), PARTS)
        finer = own.value(self._signal(where, found), where.t)
        return float(self.values[n] - finer)

    def _evaluated(
        self, response: Response, where: Sampling, sides: Sequence[Array] = ()
    ) -> tuple[Sampling, Outputs, Tracer]:
        """A response at the states that a run reports: where nodes are not such states, and it reads more of them."""
        outputs = self._outputs_at(where, sides)
        found = response.evaluate(outputs)
        if self._needs_consistent(response, where, {kind for kind, _ in outputs.inputs}):
            where = ConsistentSampling(self._system, self._steps, where)
            outputs = self._outputs_at(where, sides)
            found = response.evaluate(outputs)
        return where, outputs, found

    def _needs_consistent(self, response: Response, where: Sampling, read: set[str]) -> bool:
        """Nodes are on the constraints; those of Radau have consistent velocities and accelerations, too.

        Integrals have the order of the method without.
        """
        if not response.pointwise:
            return bool(read & set(response.reported))
        moving = not self._precise and bool(read & {"v", "a", "lam"})
        return moving or (bool(read & set(READ)) and bool(where.between_nodes.any()))

    def _outputs_at(self, sampling: Sampling, sides: Sequence[Array] = ()) -> Outputs:
        if self._reported.redundant and not isinstance(sampling, ConsistentSampling):
            sampling.reported = self._reported
        number, memory = self._parameters.number, sampling.memory
        return Outputs(self._system, sampling, self._steps.b, number, self._angles, memory, sides)

    def _arguments(self, response: Response, where: Instants) -> list[Array]:
        """Return the arguments of absolute values at given times."""
        return _arguments(*self._evaluated(response, Sampling(self._steps, where))[:2])

    def gradients(self) -> tuple[Nodes, DirectTerms]:
        """The gradients of all responses, one column each."""
        nodes = Nodes.zeros(self._steps, len(self._responses))
        parts = [self._gradient(n, nodes) for n in range(len(self._responses))]
        b, c = (np.concatenate([getattr(part, name) for part in parts], axis=1) for name in ("b", "c"))
        b = b + self._reported.transposed(nodes, self._reported.times(nodes.shift))
        return nodes, DirectTerms(b, c, [part.named[0] for part in parts])

    def _asks_for_multipliers(self, n: int) -> bool:
        return any(kind == "lam" for kind, _ in self._outputs[n].inputs)

    def _asks_for_method(self, n: int) -> bool:
        """Whether a response takes multipliers of a method's nodes."""
        return self._asks_for_multipliers(n) and not isinstance(self._samplings[n], ConsistentSampling)

    def _with_reported(self, dots: Nodes, b: Array) -> Nodes:
        """The changes of states, those of multipliers as far as responses need them as they are reported."""
        wanted = [s for n, s in enumerate(self._samplings) if self._asks_for_method(n)]
        if not (wanted and self._reported.redundant):
            return dots
        rows = np.unique(np.concatenate([one.nodes_of_multipliers for one in wanted]))
        return replace(dots, lam=self._reported.along(dots, b, self._reported.times(dots.shift), rows))

    def _gradient(self, n: int, nodes: Nodes) -> DirectTerms:
        response, sampling, g = self._responses[n], self._samplings[n], self.signals[n]
        outputs, found = self._outputs[n], self._bars(n, self._weights(n))
        if sampling.moves:
            by_t = np.broadcast_to(found[outputs.t.at], g.shape)
            sampling.spread_time(by_t + response.by_times(g, sampling.t), nodes, n)
        return self._collected(n, found, nodes, n)[1]

    def _weights(self, n: int) -> Array:
        """The weights of the output of response n at its times."""
        return np.asarray(self._responses[n].weights(self.signals[n], self._samplings[n].t))

    def _bars(self, n: int, weights: Array) -> list[Any]:
        """The gradient of response n by the entries of its tape."""
        response, sampling = self._responses[n], self._samplings[n]
        vanishing = partial(response.vanishing_weights, self.signals[n], sampling.t, weights)
        return gradient_of(
            response.title, self._outputs[n], self._found[n], weights, sampling.moves, vanishing
        )

    def signals_along(self, dots: Nodes, b: Array, c: Array, named: Mapping[str, Array]) -> list[Array]:
        """The change of every response's output at its times, (nt, k), with changes of states and numbers (…, k)."""
        dots = self._with_reported(dots, b)
        return [self._signal_along(n, dots, b, c, named) for n in range(len(self._responses))]

    def _signal_along(self, n: int, dots: Nodes, b: Array, c: Array, named: Mapping[str, Array]) -> Array:
        found = np.zeros((len(self._samplings[n].t), b.shape[1]))
        for k in range(b.shape[1]):
            found[:, k] = self._tape_along(n, dots, b, c, named, k)[self._found[n].at]
        if np.isfinite(found).all():
            return found
        weights = self._weights(n)
        return along_with_weight(found, weights == 0.0, partial(self._bars, n, weights))

    def _tape_along(
        self, n: int, dots: Nodes, b: Array, c: Array, named: Mapping[str, Array], k: int
    ) -> list[Any]:
        """The change of everything on a response's tape with column k of the changes."""
        outputs, changes = self._outputs[n], {}
        states = [key for key in outputs.inputs if key[0] not in ("b", "c")]
        moved = self._samplings[n].all_gathered(states, dots, b, c, k)
        for (kind, place), variable in outputs.inputs.items():
            numbers = {"b": b, "c": c}.get(kind)
            changes[variable.at] = moved[kind, place] if numbers is None else numbers[place, k]
        if self._samplings[n].moves:
            changes[outputs.t.at] = self._samplings[n].gathered_time(dots, k)
        changes |= {v.at: float(named[name][k]) for name, v in outputs.named.items() if name in named}
        with np.errstate(divide="ignore", invalid="ignore"):  # what is infinite has no weight, or is refused
            return outputs.tape.along(changes)

    def gradient_along(
        self, n: int, dots: Nodes, b: Array, c: Array, named: Mapping[str, Array]
    ) -> tuple[Nodes, DirectTerms]:
        """The change of the gradient of response n, with changes of states and numbers in one column.

        Raises
        ------
        NoDerivative
            For a response that depends on reactions of redundant constraints.
        """
        response, outputs = self._responses[n], self._outputs[n]
        sampling, g = self._samplings[n], self.signals[n]
        if self._reported.redundant and self._asks_for_multipliers(n):
            raise NoDerivative(
                f"{response.title}: reactions of redundant constraints have no second derivatives. Remove a redundant "
                "constraint, or take gradients."
            )
        found, along = self._found[n], self._tape_along(n, dots, b, c, named, 0)
        t, still = sampling.t, np.zeros(len(sampling.t))
        t_dot, weights = sampling.gathered_time(dots, 0) if sampling.moves else still, response.weights(g, t)
        moved = np.broadcast_to(np.asarray(along[found.at], dtype=float), g.shape)
        by_output = partial(response.weights_along, g, t, t_dot=still)
        g_dot = change_with_weight(response.title, weights, moved, by_output)
        turned = response.weights_along(g, t, g_dot, t_dot) + self._through_kinks(n, g_dot)
        bars, change = change_of_gradient(
            response.title, outputs, found, (weights, turned), along, sampling.moves
        )
        nodes, by_states = Nodes.zeros(self._steps, 1), self._by_states(n, bars)
        if sampling.moves:
            by_t = np.broadcast_to(change[outputs.t.at], g.shape)
            sampling.spread_time(by_t + response.by_times_along(g, t, g_dot, t_dot), nodes, 0)
        if not isinstance(sampling, ConsistentSampling):
            sampling.spread_along(by_states, dots, nodes)
            return self._collected(n, change, nodes, 0)
        sources, by_b = sampling.turned(by_states, sampling.along(dots, b[:, :1], 0), dots, nodes)
        nodes, explicit = self._collected(n, change, nodes, 0, sources)
        return nodes, replace(explicit, b=explicit.b - by_b[:, None])

    def _through_kinks(self, n: int, g_dot: Array) -> Array:
        """Return the change of the weights by the motion of kinks.

        An integral changes with the time τ of a kink by g⁻ - g⁺, which is zero there; and this by the change of g⁻ - g⁺
        times τ'. As it stays zero, τ' is its change over its rate of change with time.

        Raises
        ------
        ValueError
            Where the argument of an absolute value touches zero without crossing it: the kink has no derivative.
        """
        response, found = self._responses[n], np.zeros(len(g_dot))
        before = response.layout.joints
        if not (isinstance(response, Integral) and len(before)):
            return found
        rate = self._rate(n)
        crossing, moved = rate[before] - rate[before + 1], g_dot[before] - g_dot[before + 1]
        touches = abs(crossing) <= TOUCHES * (abs(rate[before]) + abs(rate[before + 1]))
        if np.any(touches & (abs(moved) > TOUCHES * (abs(g_dot[before]) + abs(g_dot[before + 1])))):
            raise ValueError(
                f"{response.title}: the argument of abs, max, min or clip touches zero without crossing it, so that "
                "the second derivatives do not exist. Use a smooth function, such as sqrt(x**2 + e**2)."
            )
        change = np.where(touches, 0.0, moved) / np.where(touches, 1.0, crossing)
        found[before] -= change
        found[before + 1] += change
        return found

    def _rate(self, n: int) -> Array:
        """The derivative of a response's output by the time, along the motion (nt,)."""
        outputs, sampling, moved = self._outputs[n], self._samplings[n], dict[int, Any]({})
        rates = {"q": sampling.v, "v": sampling.a}
        if any(kind in ("a", "lam") for kind, _ in outputs.inputs):
            if not isinstance(sampling, ConsistentSampling):
                sampling = ConsistentSampling(self._system, self._steps, sampling)
            found = sampling.rates()
            rates |= {"a": found.a[:, :, 0], "lam": found.lam[:, :, 0]}
        for (kind, place), variable in outputs.inputs.items():
            if kind in rates:
                moved[variable.at] = rates[kind][:, place]
        rate = outputs.tape.along(moved | {outputs.t.at: 1.0})[self._found[n].at]
        return np.broadcast_to(np.asarray(rate, dtype=float), self.signals[n].shape)

    def _by_states(self, n: int, bars: list[Any]) -> dict[Key, Array]:
        """Return the gradients by states from gradients by the inputs of a tape."""
        inputs, shape = self._outputs[n].inputs.items(), self._samplings[n].t.shape
        return {key: np.broadcast_to(bars[x.at], shape) for key, x in inputs if key[0] in READ}

    def _collected(
        self, n: int, bars: list[Any], nodes: Nodes, column: int, *sources: PerOperation
    ) -> tuple[Nodes, DirectTerms]:
        """Gradients by the inputs of a tape, sorted: those by states are added to a column of the nodes."""
        outputs, sampling = self._outputs[n], self._samplings[n]
        by_b = np.zeros((len(self._system.b), 1))
        by_c = np.zeros((self._c_size, 1))
        for (kind, place), variable in outputs.inputs.items():
            bar = bars[variable.at]
            if kind in ("b", "c"):
                (by_b if kind == "b" else by_c)[place, 0] += np.sum(bar)
        by_b += sampling.spread_all(self._by_states(n, bars), nodes, column, *sources)
        named = {name: float(np.sum(bars[variable.at])) for name, variable in outputs.named.items()}
        return nodes, DirectTerms(by_b, by_c, [named])
