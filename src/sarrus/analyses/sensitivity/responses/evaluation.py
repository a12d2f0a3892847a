"""Responses evaluated on a run: their values, and their gradients by its states and by the numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from ....algebra import Array
from ....model.announcement import announce
from ....model.tape import Traced
from ....outputs import Outputs
from ....outputs.recording import Angles, Key
from ....results import Pieces, StepsTaken
from ....system import System
from ...equations.length import extent
from ..chain.chain import Nodes
from ..parameters.parameters import Parameters
from ..sampling.consistent import READ, AdjointChange, ConsistentSampling
from ..sampling.pieces import Course, PieceSampling, Where, angles_of, at_event, course_of, fixed, within
from ..sampling.reported import Reported
from ..sampling.sampling import NotThere, Sampling
from .kinks import Layout, Steps, between_kinks, layout
from .panels import LOBATTO, TRAPEZOIDAL, Rule
from .resolution import (
    FAITHFUL,
    FEW_LOOKS,
    FEW_STEPS,
    Ends,
    about_extreme,
    errors_of_integral,
    every_step,
    looked_at,
    narrowed,
    of_steps,
    resolved,
    unused,
)
from .responses import AtEvent, ExtremeValue, Response, of_whole_run
from .state_sizes import state_sizes
from .undefined import (
    along_with_weight,
    change_of_gradient,
    change_with_weight,
    gradient_of,
    is_quadratic,
    rests,
)
from .within_steps import PARTS, Fine, fine

AT_KINK = 1e-10  # of the largest argument of a run: nearer to a kink than a run is exact
# Of the slopes of an output on both sides of a kink: those of round-off differ by no more
TOUCHES = 1e-7
ONE_SIDED = (
    "its function has a kink there (abs, max, min or clip), so that its derivative is that of one side only. Move the "
    "time, or use a smooth function"
)
NOISE = (
    "the argument of abs, max, min or clip is zero but for round-off, so that the derivative depends on the sign of "
    "round-off. Use a smooth function"
)
TOO_FAST = (
    "its output changes so fast, or so abruptly, that {count:,} samples do not show it, and its value is not sure. Use "
    "a smoother function, or a smaller max_step"
)
ROUND_OFF = 1e-12  # of what an output is computed from
UNSPLIT = (
    "its function has kinks within the run (abs, max, min or clip), and steps are not split there unless the states of "
    "the run are stored. Use simulate(..., store_steps=True) and sensitivity(), or a smooth function"
)


@dataclass(frozen=True)
class Explicit:
    """Gradients of responses that do not go through the states: by b, by the joints' numbers, by named parameters."""

    b: Array
    c: Array
    named: list[dict[str, float]]


def sampling(steps: StepsTaken | Pieces, response: Response) -> Sampling:
    """Return the samples of a response."""
    try:
        if isinstance(steps, Pieces) or isinstance(response, AtEvent):
            where = where_of(course_of(steps), response)
            assert isinstance(steps, Pieces)
            return PieceSampling(steps, where)
        return Sampling(steps, response.times(steps.t))
    except NotThere as wrong:
        raise NotThere(f"{response.title}: {wrong}") from None


def where_of(course: Course, response: Response) -> Where:
    """The times at which a response is sampled, and the stretches between events in which they lie."""
    if isinstance(response, AtEvent):
        return at_event(course, response.event, response.number, response.after)
    if isinstance(response, Fine):
        return within(course, PARTS)
    times = response.times(course.times)
    return within(course) if times is None else fixed(course, times)


class Evaluation:
    """Responses of one run.

    Parameters
    ----------
    system, steps : the run
    responses : evaluated in this order
    parameters : whose numbers responses may use
    angles : with their revolutions; by default counted along all nodes of the run
    samplings : where each response is sampled; by default at its own times
    """

    def __init__(
        self,
        system: System,
        steps: StepsTaken | Pieces,
        responses: Sequence[Response],
        parameters: Parameters,
        angles: Angles | None = None,
        samplings: Sequence[Sampling] | None = None,
    ) -> None:
        self._precise = (steps.pieces[0] if isinstance(steps, Pieces) else steps).precise
        self._system, self._steps, self._parameters = system, steps, parameters
        self._c_size, self._angles = parameters.c_size, angles or angles_of(system, steps)
        self._samplings, self._outputs = list[Sampling](), list[Outputs]()
        self._responses, self._found = list[Response](), list[Traced]()
        self._panels = list[tuple[Response, Ends] | None]()
        self._reported = Reported(system, steps)
        if samplings is None:
            responses = [of_whole_run(system, response) for response in responses]
        for n, response in enumerate(responses):
            self._add(response, samplings[n] if samplings else None)
        responses = self._responses
        self.signals = [
            np.broadcast_to(np.asarray(found.value, dtype=float), sampling.t.shape)
            for found, sampling in zip(self._found, self._samplings, strict=True)
        ]
        self.values = np.array(
            [r.value(g, s.t) for r, g, s in zip(responses, self.signals, self._samplings, strict=True)]
        )

    def _add(self, response: Response, given: Sampling | None) -> None:
        """Evaluate one more response, where it is sampled; in parts of steps, where it has kinks or changes fast."""
        own, ends = fine(response) if self._precise else response, None
        where, outputs, found = self._evaluated(own, given or sampling(self._steps, own))
        if not (given or response.pointwise) and self._is_interpolated_badly(response, outputs):
            response = replace(response, name=response.title, reported=True)
            own = replace(own, name=response.title, reported=True)
            where, outputs, found = self._evaluated(own, sampling(self._steps, own))
        if outputs.tape.kinks and given:
            self._warn_of_changes(response, outputs)
        elif outputs.tape.kinks and response.pointwise:
            self._warn_of_zeros(response, outputs)
        elif not given and (outputs.tape.kinks or type(response).coarse is not Response.coarse):
            ends, split = self._split(response, where, outputs, found)
            if isinstance(response, ExtremeValue):
                kinks, noise = bool(outputs.tape.kinks), self._noise(where, outputs, found)
                ends, own, split = self._about_extreme(response, ends, kinks, noise)
                own, where, outputs, found = self._in_panels(own, split)
            elif split:
                own, where, outputs, found = self._in_panels(response, split)
        self._panels.append((response, ends) if ends else None)
        self._responses.append(own)
        self._samplings.append(where)
        self._outputs.append(outputs)
        self._found.append(found)

    def _in_panels(self, response: Response, split: Layout) -> tuple[Response, Sampling, Outputs, Traced]:
        own = replace(response, name=response.title, panels=split.panels)
        return own, *self._evaluated(own, self._sampling_at(split.where), list(split.sides))

    def _split(
        self, response: Response, where: Sampling, outputs: Outputs, found: Traced
    ) -> tuple[Ends, Layout | None]:
        """Panels between the kinks of a response, as short as it changes; the samples, if steps are not enough."""
        steps, known = Steps.of(course_of(self._steps)), None
        ends, noisy = every_step(len(steps.end)), False
        if outputs.tape.kinks:
            every_one = [self._noise(where, outputs, Traced(outputs.tape, at)) for at in outputs.tape.kinks]
            ends, noisy = between_kinks(steps, partial(self._arguments, response), every_one)
        elif not isinstance(where, ConsistentSampling) and isinstance(fine(response), Fine):
            g, course = np.broadcast_to(np.asarray(found.value, float), where.t.shape), course_of(self._steps)
            known = of_steps(g, len(self._rule.parts), [len(t) - 1 for t in course.t])
        output, noise = partial(self._output, response, steps), self._noise(where, outputs, found)
        lengths, before = steps.end - steps.begin, len(ends.step)
        ends, enough = resolved(ends, lengths, self._rule, output, response.coarse, noise, known)
        if not enough:
            announce([f"{response.title}: {TOO_FAST.format(count=len(ends.step) * len(self._rule.parts))}"])
        if not outputs.tape.kinks:
            return ends, layout(steps, ends, unused, self._rule) if len(ends.step) > before else None
        split = layout(steps, ends, partial(self._arguments, response), self._rule, noisy)
        if split.noisy:
            announce([f"{response.title}: {NOISE}"])
        return ends, split

    def _about_extreme(
        self, response: ExtremeValue, ends: Ends, kinks: bool, noise: float
    ) -> tuple[Ends, ExtremeValue, Layout]:
        """Panels about an extreme, so short that their samples show it; of reported states, except at a kink."""
        steps, own = Steps.of(course_of(self._steps)), response
        arguments = partial(self._arguments, response) if kinks else unused
        ends = about_extreme(ends, steps.piece, own.sign, partial(self._output, own, steps))
        if not len(layout(steps, ends, arguments, LOBATTO).panels.joints):
            own = replace(response, name=response.title, reported=True)
        ends = narrowed(ends, steps.piece, own.sign, partial(self._output, own, steps), noise, self._precise)
        return ends, own, layout(steps, ends, arguments, LOBATTO)

    def _output(self, response: Response, steps: Steps, step: Array, part: Array) -> Array:
        """The output of a response at parts of steps, of interpolated states unless it takes those reported."""
        where = steps.where(step.ravel(), part.ravel())
        states = self._sampling_at(where)
        if response.reported:
            states = ConsistentSampling(self._system, self._steps, states)
        found = response.evaluate(self._outputs_at(states))
        return np.broadcast_to(np.asarray(found.value, dtype=float), where.t.shape).reshape(part.shape)

    def _is_interpolated_badly(self, response: Response, outputs: Outputs) -> bool:
        """Whether an output of accelerations or reactions differs between the nodes from that of the run.

        Motions that are prescribed have steps that are too long for what the drivers exert.
        """
        if not {kind for kind, _ in outputs.inputs} & {"a", "lam"}:
            return False
        steps = Steps.of(course_of(self._steps))
        longest = np.argsort(steps.begin - steps.end, kind="stable")[:FEW_STEPS]
        evenly = np.linspace(0, len(steps.end) - 1, FEW_STEPS).astype(int)  # for the size of the output
        chosen = np.unique([*longest, *evenly])
        count = max(3, FEW_LOOKS // len(chosen))
        there = every_step(len(steps.end)).chosen(chosen).at(np.arange(1, count + 1) / (count + 1))
        own, exact = (self._output(replace(response, reported=x), steps, *there) for x in (False, True))
        known = np.isfinite(exact)  # not in singular configurations
        deviations, sizes = abs(own - exact)[known], abs(exact)[known]
        return bool(deviations.max(initial=0.0) > FAITHFUL[len(self._rule.parts)] * sizes.max(initial=0.0))

    def coarseness(self, n: int, rule: Rule) -> tuple[float, float]:
        """Return the estimated and the allowed error of the integral of an output over steps by a rule."""
        errors, allowed = errors_of_integral(*self._looked_at(n, rule))
        return float(errors.sum()), allowed

    def misses_extreme(self, n: int, rule: Rule, response: Response, whole: Array) -> bool:
        """Whether steps with samples by a rule may contain more than the extreme of all samples of a run."""
        h, g, deviations = self._looked_at(n, rule)
        if not self._precise:  # which resolves outputs as by samples at the ends of steps
            g = np.stack([g.min(axis=1), g.max(axis=1)], axis=1)
        ends = np.resize([whole.min(), whole.max()], (1, g.shape[1]))
        g, h, deviations = np.append(g, ends, axis=0), np.append(h, 0.0), np.append(deviations, 0.0)
        return bool(response.coarse(h, g, deviations).any())

    def _looked_at(self, n: int, rule: Rule) -> tuple[Array, Array, Array]:
        """Lengths of steps, samples of an output by a rule, and deviations in the middle, see `Response.coarse`."""
        steps = Steps.of(course_of(self._steps))
        every, output = every_step(len(steps.end)), partial(self._output, self._responses[n], steps)
        noise = self._noise(self._samplings[n], self._outputs[n], self._found[n])
        return steps.end - steps.begin, *looked_at(every, rule, output, noise)

    def is_interpolated_badly(self, n: int) -> bool:
        """Whether an output differs between the nodes from that of the run."""
        return self._is_interpolated_badly(self._responses[n], self._outputs[n])

    def _noise(self, where: Sampling, outputs: Outputs, found: Traced) -> float:
        """Round-off of an output: of all numbers it is computed from, states being as large as any of their kind."""
        length = extent(self._system, self._steps.start.q)
        tape, sizes = outputs.tape, state_sizes(where.states, length, course_of(self._steps).t)
        with np.errstate(divide="ignore", invalid="ignore"):  # that of a root is infinite at 0
            slopes, largest = tape.gradient({found.at: 1.0}), list(tape.values)
        for (kind, place), x in outputs.inputs.items():
            if kind in sizes:
                largest[x.at] = sizes[kind][place]
        with np.errstate(invalid="ignore"):  # bounds of clip may be infinite
            parts = [np.max(abs(np.asarray(slope * x))) for slope, x in zip(slopes, largest, strict=True)]
        return ROUND_OFF * float(max(filter(np.isfinite, parts), default=0.0))

    def rule_error(self, n: int) -> float:
        """Return the sampling error of a response: its value minus that with more samples."""
        return (
            0.0 if self._panels[n] is None else self.of_rule * float(self.values[n] - self.halved.values[n])
        )

    @property
    def of_rule(self) -> float:
        """Sampling errors over the differences to twice as many samples."""
        return 1.0 if self._precise else 4 / 3

    @cached_property
    def halved(self) -> Evaluation:
        """The same with twice as many samples of responses over the whole run."""
        other = copy(self)
        for name in ("_responses", "_samplings", "_outputs", "_found", "signals"):
            setattr(other, name, [*getattr(self, name)])
        other.values = self.values.copy()
        for n, panels in enumerate(self._panels):
            if panels is not None:
                own, where, outputs, found = self._halves(n, *panels)
                g = np.broadcast_to(np.asarray(found.value, dtype=float), where.t.shape)
                other._responses[n], other._samplings[n], other._outputs[n] = own, where, outputs
                other._found[n], other.signals[n], other.values[n] = found, g, own.value(g, where.t)
        return other

    def _halves(self, n: int, response: Response, ends: Ends) -> tuple[Response, Sampling, Outputs, Traced]:
        response = replace(response, name=response.title, reported=True)
        steps, arguments = Steps.of(course_of(self._steps)), unused
        if len(self._outputs[n].tape.kinks):
            arguments = partial(self._arguments, response)
        rule = LOBATTO if isinstance(response, ExtremeValue) else self._rule
        return self._in_panels(response, layout(steps, ends.halves(), arguments, rule))

    @property
    def _rule(self) -> Rule:
        return LOBATTO if self._precise else TRAPEZOIDAL

    def _sampling_at(self, where: Where) -> Sampling:
        return (
            PieceSampling(self._steps, where)
            if isinstance(self._steps, Pieces)
            else Sampling(self._steps, where.t)
        )

    def _evaluated(
        self, response: Response, where: Sampling, sides: Sequence[Array] = ()
    ) -> tuple[Sampling, Outputs, Traced]:
        """A response at the states that a run reports: where nodes are not such states, and it reads more of them."""
        outputs = self._outputs_at(where, sides)
        found = response.evaluate(outputs)
        if self._needs_consistent(response, where, {kind for kind, _ in outputs.inputs}):
            where = ConsistentSampling(self._system, self._steps, where)
            outputs = self._outputs_at(where, sides)
            found = response.evaluate(outputs)
        return where, outputs, found

    def _needs_consistent(self, response: Response, where: Sampling, read: set[str]) -> bool:
        """Nodes are on the constraints; those of Radau have consistent velocities and accelerations, too."""
        if read & {"v", "a", "lam"} and (response.reported or not self._precise):
            return True
        if isinstance(response, ExtremeValue):
            return response.reported and bool(read & set(READ))
        return response.pointwise and bool(read & set(READ)) and bool(where.between_nodes.any())

    def _outputs_at(self, sampling: Sampling, sides: Sequence[Array] = ()) -> Outputs:
        if self._reported.redundant and not isinstance(sampling, ConsistentSampling):
            sampling.reported = self._reported
        number, memory = self._parameters.number, sampling.memory
        return Outputs(self._system, sampling.states, self._steps.b, number, self._angles, memory, sides)

    def _arguments(self, response: Response, where: Where) -> list[Array]:
        """Return the arguments of absolute values at given times."""
        outputs = self._evaluated(response, self._sampling_at(where))[1]
        return [np.asarray(outputs.tape.values[at]) for at in outputs.tape.kinks]

    def _warn_of_zeros(self, response: Response, outputs: Outputs) -> None:
        """Warn of derivatives at a kink."""
        whole = self._arguments(response, within(course_of(self._steps)))
        there = (np.asarray(outputs.tape.values[at]) for at in outputs.tape.kinks)
        if any(np.any(abs(x) <= AT_KINK * abs(every).max()) for x, every in zip(there, whole, strict=True)):
            announce([f"{response.title}: {ONE_SIDED}"])

    def _warn_of_changes(self, response: Response, outputs: Outputs) -> None:
        """Warn of kinks in the part of a run with the given samples."""
        if not response.pointwise and any(
            np.any(np.diff(np.sign(outputs.tape.values[at])) != 0) for at in outputs.tape.kinks
        ):
            announce([f"{response.title}: {UNSPLIT}"])

    def gradients(self) -> tuple[Nodes, Explicit]:
        """The gradients of all responses, one column each."""
        nodes = Nodes.zeros(self._steps, len(self._responses))
        parts = [self._gradient(n, nodes) for n in range(len(self._responses))]
        b, c = (np.concatenate([getattr(part, name) for part in parts], axis=1) for name in ("b", "c"))
        b = b + self._reported.pulled_back(nodes)
        return nodes, Explicit(b, c, [part.named[0] for part in parts])

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
        return self._reported.along(dots, b, rows)

    def _gradient(self, n: int, nodes: Nodes) -> Explicit:
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
        states = [key for key in outputs.inputs if key[0] in READ]
        moved = self._samplings[n].all_gathered(states, dots, b, k)
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
    ) -> tuple[Nodes, Explicit]:
        """The change of the gradient of response n, with changes of states and numbers in one column."""
        response, outputs, sampling, g = (
            self._responses[n],
            self._outputs[n],
            self._samplings[n],
            self.signals[n],
        )
        of_steps, reported = dots, self._reported.redundant and self._asks_for_method(n)
        dots = self._with_reported(dots, b)
        found, along = self._found[n], self._tape_along(n, dots, b, c, named, 0)
        t, still = sampling.t, np.zeros(len(sampling.t))
        t_dot, weights = sampling.gathered_time(dots, 0) if sampling.moves else still, response.weights(g, t)
        g_dot = change_with_weight(
            response.title,
            weights,
            np.broadcast_to(np.asarray(along[found.at], dtype=float), g.shape),
            partial(response.weights_along, g, t, t_dot=still),
            lambda lost: (
                rests(outputs, along, lost, sampling.moves) and is_quadratic(outputs, lost, sampling.moves)
            ),
        )
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
            nodes, explicit = self._collected(n, change, nodes, 0)
            if reported:
                first = self._collected(n, bars, Nodes.zeros(self._steps, 1), 0)[0]
                by_b = self._reported.pulled_back_along(first, nodes, of_steps, b)
                explicit = replace(explicit, b=explicit.b + by_b)
            return nodes, explicit
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
        response, g, t, found = (
            self._responses[n],
            self.signals[n],
            self._samplings[n].t,
            np.zeros(len(g_dot)),
        )
        panels = response.panels
        if panels is None or not len(panels.joints):
            return found
        before, factors = panels.joints, response.at_kinks(g, t)
        if not factors.any():
            return found
        rate = self._rate(n)
        crossing, moved = rate[before] - rate[before + 1], g_dot[before] - g_dot[before + 1]
        touches = abs(crossing) <= TOUCHES * (abs(rate[before]) + abs(rate[before + 1]))
        if np.any(touches & (abs(moved) > TOUCHES * (abs(g_dot[before]) + abs(g_dot[before + 1])))):
            raise ValueError(
                f"{response.title}: the argument of abs, max, min or clip touches zero without crossing it, so that "
                "the second derivatives do not exist. Use a smooth function, such as sqrt(x**2 + e**2)."
            )
        change = factors[before] * np.where(touches, 0.0, moved) / np.where(touches, 1.0, crossing)
        found[before] -= change
        found[before + 1] += change
        return found

    def _rate(self, n: int) -> Array:
        """The derivative of a response's output by the time, along the motion (nt,)."""
        outputs, sampling, moved = self._outputs[n], self._samplings[n], dict[int, Any]({})
        rates = {"q": sampling.states.v, "v": sampling.states.a}
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
        self, n: int, bars: list[Any], nodes: Nodes, column: int, *turned: AdjointChange
    ) -> tuple[Nodes, Explicit]:
        """Gradients by the inputs of a tape, sorted: those by states are added to a column of the nodes."""
        outputs, sampling = self._outputs[n], self._samplings[n]
        by_b = np.zeros((len(self._system.b), 1))
        by_c = np.zeros((self._c_size, 1))
        for (kind, place), variable in outputs.inputs.items():
            bar = bars[variable.at]
            if kind in ("b", "c"):
                (by_b if kind == "b" else by_c)[place, 0] += np.sum(bar)
        by_b += sampling.spread_all(self._by_states(n, bars), nodes, column, *turned)
        named = {name: float(np.sum(bars[variable.at])) for name, variable in outputs.named.items()}
        return nodes, Explicit(by_b, by_c, [named])
