"""Corners of force laws that steps of a run pass at once: first touches, reversals of friction, kinks of laws.

The steps of a run do not change with its parameters. A step within which a force passes a corner has an error that
jumps as the corner moves through it: small in the states, to meet the tolerances, but not in their derivatives. A
rounded corner is passed well by steps that are not longer than its rounding.

Lengths whose ends meet and could pass beside each other: derivatives to what moves them aside do not exist.

The force of a length |d| reverses where its ends meet. If d can turn aside, the component f d/|d| there has a slope
f/|d| without an integral over the passage.

Corners of several forces at the same time, which do not stay together where parameters change.

A step ends at one of them. Where the others move away from it, second derivatives lack the squares of these times, with
the changes of slopes at the corners.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from scipy.linalg import null_space

from ..._jit.formulas.replay import needed
from ...algebra import Array
from ...elements.operators import OPERATORS
from ...results import Segments, StepsTaken
from ...results.motion.steps import EventStep, segments_of
from ...system import System
from ...system.curves.curve_derivatives import CurveDerivatives, formula_values, stored
from ...system.structure.population import Population
from ..dynamics.events.force_corners import Corner, ForceCorners
from ..dynamics.inputs.force_arguments import END, Length, force_functions, has_corners, law_signs
from ..dynamics.stepping.nodes import Nodes
from .events.first_order import EventDerivatives
from .events.functions import TapeValues
from .parameters.parameters import Parameters
from .run_chain import RunChain

LONG = 2.0  # roundings that a step may pass: derivatives have a few digits up to there, and none far beyond
REVERSAL = 4.0  # of the argument of tanh: from -2 to 2 it takes its whole way but for a few hundredths
CHUNK = 10_000  # nodes that are looked at together
ON_IT = 1e-7  # of the largest argument: a step that ends at a corner, but for round-off, does not pass it
REMEDY = (
    "its force sets in, ends or reverses within single steps, so that derivatives may be inaccurate. "
    "Use Radau() with rtol=1e-10 or less, "
    "or a larger rounding"
)


CLOSE = (
    "its ends pass so close to each other within single steps that derivatives may be inaccurate. Let them pass "
    "farther apart, or meet exactly in a run with corners=True, whose steps end there"
)
DIRECTIONS = 4  # of all possible velocities, at random: enough to see whether d has more than one
ALONG = 1e-8  # of the square of the largest change of d: others are round-off


def corners(system: System, steps: StepsTaken | Segments) -> list[str]:
    """Return one message for each part whose force passes a corner within one step, or reverses aside of its line."""
    segments = segments_of(steps)
    forces = [p for p in system.populations if p.count and OPERATORS["Q"] in p.kind.family]
    found = dict.fromkeys(
        message
        for p in forces
        if has_corners(p) or force_functions(p.variant).reversals
        for segment in segments
        for message in _messages(system, p, segment)
    )
    return [*found, *(free_aside(system, steps) if isinstance(steps, Segments) else ())]


def _messages(system: System, p: Population, steps: StepsTaken) -> Iterator[str]:
    """The messages of the parts of the model of a kind of force that turn a corner within one step."""
    for begin in range(0, len(steps), CHUNK):
        rows = slice(begin, begin + CHUNK + 1)
        memory = dict(zip(steps.places.tolist(), _memory(steps)[rows].T, strict=True))
        operands = {"q": steps.q[rows], "v": steps.v[rows], "t": steps.t[rows]}
        for k, passed in enumerate(_passed(system, p, steps.b, memory, operands)):
            if passed:
                yield f"{p.owners[k]}: {passed}."


def _memory(steps: StepsTaken) -> Array:
    """Return the state variables of elements at each node."""
    return np.concatenate([steps.memory, steps.memory[-1:]])


def _passed(
    system: System, p: Population, b: Array, memory: Mapping[int, Any], operands: Mapping[str, Array]
) -> list[str]:
    """The message for each element of a kind that passes a corner within one step; none for the others."""
    graph, entries, signs, reversals, curves, _ = force_functions(p.variant)
    wanted = [*entries, *force_functions(p.variant).arguments]
    values = CurveDerivatives(system).on_elements(
        p, graph, wanted, needed(graph, wanted), b, memory, operands
    )
    forces, values = values[: len(entries)], values[len(entries) :]
    h = np.diff(operands["t"])
    acts = np.any(forces != 0, axis=0)  # (elements, nt)
    at_work = acts[:, 1:] | acts[:, :-1]
    at_signs, values = values[: len(signs)], values[len(signs) :]
    at_reversals, values = values[: len(reversals)], values[len(reversals) :]
    at_curves, at_lengths = values[: len(curves)], values[len(curves) :]
    found = []
    for k in range(p.count):
        passed = _corner(at_signs[:, k])
        for x in at_reversals[:, k]:
            passed |= (x[1:] * x[:-1] < 0) & (abs(np.diff(x)) > REVERSAL)
        for (place, _), x in zip(curves, at_curves[:, k], strict=True):
            law = stored(p, k, place)
            if law_signs(law):
                passed |= _corner(formula_values(law, law_signs(law), x))
        close = np.zeros_like(passed)
        for length in at_lengths[:, k].reshape(-1, len(Length._fields), len(operands["t"])):
            before, after = Length(*length[:, :-1]), Length(*length[:, 1:])
            near = before.meets(h) | after.meets(h) | before.rotates(after, h)
            close |= (before.rate < 0) & (after.rate > 0) & near
        messages = [(close, CLOSE), (passed, REMEDY)]
        found.append(next((text for one, text in messages if np.any(one & at_work[k])), ""))
    return found


def _corner(x: Array) -> Array:
    """Whether steps pass a corner at once (steps,), of the arguments whose sign counts (arguments, nt).

    A rounded corner is a band: of u, and of u₊ - 1; steps are short enough that change u by less than two.
    """
    passed = np.zeros(x.shape[1] - 1, dtype=bool)
    bands, own = list[Array](), set[int]()
    for i, u in enumerate(x):
        top = np.maximum(u, 0) - 1
        partners = [
            j for j, other in enumerate(x) if j != i and np.allclose(other, top, rtol=1e-9, atol=1e-12)
        ]
        if partners:
            bands.append(u)
            own |= {i, *partners}
    for u in bands:
        low, high = np.minimum(u[1:], u[:-1]), np.maximum(u[1:], u[:-1])
        passed |= (low < 1) & (high > 0) & (high - low > LONG)
    for i, kink in enumerate(x):
        if i not in own and not any(np.array_equal(kink > 0, u > 1) for u in bands):
            small = ON_IT * abs(kink).max(initial=0.0)
            passed |= (kink[1:] * kink[:-1] < 0) & (np.minimum(abs(kink[1:]), abs(kink[:-1])) > small)
    return passed


def free_aside(system: System, steps: Segments) -> Iterator[str]:
    """Yield a message for each length whose ends met and could have passed beside each other."""
    passed: dict[tuple[str, int], tuple[EventStep, Corner]] = {}
    for event in steps.event_steps:
        corner = event.function
        if isinstance(corner, Corner) and corner.length:
            passed.setdefault((corner.owner, corner.element), (event, corner))
    for event, corner in passed.values():
        if _is_free(system, steps.b, event, corner):
            yield (
                f"{corner.owner}: its ends meet at t = {event.t:.6g} s, and could pass beside each other, so that "
                "derivatives to parameters that move them aside do not exist. Guide one end along a line, or leave "
                "these parameters out."
            )


def _is_free(system: System, b: Array, event: EventStep, corner: Corner) -> bool:
    """Whether d can change in more than one direction: the rank of the squares of its changes, s̈/2 where d is zero."""
    free = null_space(system.Phi_q(event.q, event.t, b=b).toarray())
    if free.shape[1] < 2:
        return False
    chosen = free @ np.random.default_rng(0).standard_normal((free.shape[1], DIRECTIONS))
    i, j = np.triu_indices(DIRECTIONS)
    v = (chosen[:, i] + chosen[:, j]).T
    p = system.populations[corner.population]
    graph, bend = force_functions(p.variant).graph, [force_functions(p.variant).lengths[corner.sign].bend]
    operands = {"q": np.tile(event.q, (len(v), 1)), "v": v, "t": np.full(len(v), event.t)}
    values = CurveDerivatives(system).on_elements(p, graph, bend, needed(graph, bend), b, {}, operands)
    sums = np.zeros((DIRECTIONS, DIRECTIONS))
    sums[i, j] = sums[j, i] = values[0, corner.element]
    own = np.diag(sums) / 4
    changes = np.linalg.eigvalsh((sums - own[:, None] - own) / 2)
    return bool(changes[-2] > ALONG * changes[-1])


APART = 1e-3  # of the times by which corners move
MOVES = 1e-9  # of the run, by relative changes of the parameters: less is round-off


def leaving_corners(chain: RunChain, parameters: Parameters) -> list[str]:
    """Return a message for each force whose corners leave those of another one where the parameters change."""
    corners, segments = ForceCorners(chain.system, lengths=False), segments_of(chain.steps)
    triples = enumerate(zip(chain.event_steps, segments, segments[1:], strict=False))
    pairs = [(p, other) for p, three in triples for other in _others(corners, *three)]
    if not pairs:
        return []
    times, found = _Times(chain, parameters), dict[str, None]()
    for p, other in pairs:
        derived = chain.event_steps[p]
        own = derived.event.function
        if isinstance(own, Corner) and times.differ(p, derived.recorded(own), derived.recorded(other)):
            found[" and ".join(sorted({own.owner, other.owner}))] = None
    return [
        f"{names}: two forces set in or end at the same time, but at different times where the parameters change, so "
        "that second derivatives are wrong. Move one of them a little."
        for names in found
    ]


def _others(
    corners: ForceCorners, derived: EventDerivatives, before: StepsTaken, after: StepsTaken
) -> Iterator[Corner]:
    """The corners between the end of a section of steps, which ends at one of them, and the start of the next one."""
    own = derived.event.function
    if not isinstance(own, Corner) or own.length:
        return
    names = ("t", "q", "v", "a", "lam")
    states = [np.concatenate([getattr(before, name)[-2:], getattr(after, name)[:2]]) for name in names]
    memory = np.repeat([before.memory[-1], after.memory[0]], 2, axis=0)
    values, acts = corners.all_at(Nodes._make([*states, memory]), before.b, END, False)
    passed = (values[:, 1] > 0) != (values[:, 2] > 0)
    yield from (corners.all[n] for n in np.flatnonzero(passed & acts.any(axis=1)))


class _Times:
    """Changes of the times of corners with the parameters."""

    def __init__(self, chain: RunChain, parameters: Parameters) -> None:
        changes = parameters.along(np.eye(len(parameters.names)))
        self._chain, self._nodes = chain, chain.along(*changes)
        self._of_b, _, _, self._of_c = changes
        self._sizes = np.where(parameters.values == 0, 1.0, abs(parameters.values))
        self._least = MOVES * float(chain.steps.t[-1] - chain.steps.t[0])

    def differ(self, p: int, one: TapeValues, other: TapeValues) -> bool:
        """Whether those of two corners at the end of a section of steps do."""
        (first, rate), (second, other_rate) = (self._of(p, psi) for psi in (one, other))
        if rate == 0 or other_rate == 0:  # as of max(0, x) at x = 0, beside the corner of x
            return False
        first, second = first / rate * self._sizes, second / other_rate * self._sizes
        least = np.maximum(self._least, APART * np.maximum(abs(first), abs(second)))
        return bool(np.any(abs(first - second) > least))

    def _of(self, p: int, psi: TapeValues) -> tuple[Array, float]:
        """The changes of a function of the state at the end of a section (k,), and its rate."""
        slopes, nodes, end = psi.slopes, self._nodes, self._chain.parts[p].stop - 1
        rates = self._chain.event_steps[p].rates
        change = slopes.q @ nodes.q[end] + slopes.v @ nodes.v[end] + slopes.b @ self._of_b
        change = change + slopes.c @ self._of_c[: slopes.c.shape[1]] + slopes.t * nodes.shift[p]
        rate = slopes.q @ rates[0] + slopes.v @ rates[1] + slopes.t[:, 0]
        return np.asarray(change[0]), float(rate[0])
