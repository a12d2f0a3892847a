"""A sanity check of runs: energy that no part supplies cannot appear, and what none dissipates not vanish.

Within a step the kinetic, potential and elastic energies change by the integral of what parts supply, less what they
dissipate. Bounds of it are the length of the step times the largest and the least of these powers near it. What the
energies change beyond the bounds, summed over steps, no part explains.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np

from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.replay import needed
from ....algebra import Array
from ....elements.element import Force
from ....elements.recorder import Variant
from ....results import Trajectory
from ....system import System
from ....system.cached import once
from ....system.curves.curve_derivatives import curves_of, values_of_elements
from ....system.curves.lanes import recorded_element
from ....system.structure.population import Population
from ...equations.length import extent
from ..dense_output.sampler import PORTION, Sampler
from ..stepping.nodes import Nodes
from ..stepping.stepper import RunPart
from ..stepping.tolerance import Tolerances
from .nearness import driven

GROWTH = 0.5  # of the greatest kinetic energy: methods within their tolerances stay far below it
ERRORS = 100.0  # times the tolerance: position errors that local ones add up to
SPARSE = 8  # steps between two energies that are compared first
PARTS = np.arange(1, 8) / 8  # of a step: where powers are looked at if those at its ends do not explain it


class Exchange(NamedTuple):
    """What a kind of force stores without a potential, and supplies less what it dissipates, as recorded."""

    graph: Graph
    wanted: list[Expression]
    order: list[int]

    @property
    def stores(self) -> bool:
        """Whether it stores energy that is in no potential: contacts, stops and tyres."""
        return bool(self.wanted[0].constant != 0)


@cache
def exchange(variant: Variant) -> Exchange:
    """The exchange of a kind of force."""
    graph = Graph()
    element, state = recorded_element(variant, graph, graph.inputs("numbers", variant.kind.size()))
    stored = 0 if hasattr(element, "potential") else element.stored_energy(*state)
    net = element.supplied_power(*state) - element.dissipated_power(*state)
    wanted = graph.expressions([stored, net])
    zero = all(one.constant == 0 for one in wanted)
    return Exchange(graph, wanted, [] if zero else needed(graph, wanted))


@once
def unexplained(system: System) -> tuple[bool, bool]:
    """Whether no force explains energy that appears, and that vanishes, as none supplies, or exchanges any."""
    passive = True
    for p, _ in _working(system):
        for k in range(p.count):
            graph, at = Graph(), p.at + k * p.kind.size()
            numbers = [graph.constant(x) for x in system.b[at : at + p.kind.size()].tolist()]
            element, state = recorded_element(p.variant, graph, np.array(numbers, dtype=object))
            powers = graph.expressions([element.supplied_power(*state), element.dissipated_power(*state)])
            supplied, dissipated = (one.constant != 0 for one in powers)
            if supplied or (
                dissipated and curves_of(p.kind)
            ):  # a damper by a user's law may supply energy, too
                return False, False
            passive = passive and not dissipated
    return True, passive


@once
def _working(system: System) -> tuple[tuple[Population, Exchange], ...]:
    """All forces but the weights of bodies, with their exchange."""
    forces = (p for p in system.populations if p.count and issubclass(p.kind, Force))
    working = (p for p in forces if not all(owner in system.bodies for owner in p.owners))
    return tuple((p, exchange(p.variant)) for p in working)


class Beyond(NamedTuple):
    """What energies grew and fell beyond the bounds in steps that end at these times (2, steps). [J]"""

    t: Array
    energy: Array


class EnergyCheck(RunPart):
    """The energies of one run, looked at from step to step.

    Powers are looked at where parts store energy that is in no potential: contacts, stops and tyres. Elsewhere energy
    may grow where a part supplies some, and fall where one dissipates some.

    Parameters
    ----------
    system : System
    sampler : of its energies
    states : makes a sampler of states, whose choices no output depends on

    Attributes
    ----------
    span : length of the run [s]
    """

    VARIABLES = "_sums", "_most", "_steps", "_times", "_greatest", "_fastest"

    def __init__(self, system: System, sampler: Sampler, states: Callable[[], Sampler]) -> None:
        self._system, self._sampler, self._new_sampler = system, sampler, states
        working = _working(system)
        self._forces = working if any(one.stores for _, one in working) else ()
        self._driven, self._waiting = driven(system), list[Nodes]()
        self.span, self._greatest = 1.0, 0.0  # of kinetic energies
        self._fastest = 0.0  # velocity over its coordinate
        # What grew and fell beyond the bounds, the most of it, the largest in one step, and when that ended
        self._sums, self._most, self._steps, self._times = np.zeros((4, 2))

    @cached_property
    def _states(self) -> Sampler:
        return self._new_sampler()

    def take(self, nodes: Nodes) -> None:
        """Take the ends of steps that follow each other without a jump of velocities."""
        if len(nodes.t) > 1 and (self._forces or not self._driven):  # else drives may explain all changes
            self._waiting.append(nodes)
        if sum(len(one.t) for one in self._waiting) > PORTION:
            self._look()

    def _look(self) -> None:
        """Look at the steps taken since the last time; at each of them only where much is not explained at some."""
        segments, self._waiting = self._waiting, []
        if not segments or not (self._driven or self._unexplained([_some(one) for one in segments])):
            return
        if beyond := self._unexplained(segments, closely=True):
            sums = _sums(np.column_stack([self._sums, beyond.energy]))
            self._sums, self._most = sums[:, -1], np.maximum(self._most, sums.max(axis=1))
            largest = beyond.energy.max(axis=1)
            larger = largest > self._steps
            self._steps[larger] = largest[larger]
            self._times[larger] = beyond.t[beyond.energy.argmax(axis=1)][larger]

    def _unexplained(self, segments: list[Nodes], closely: bool = False) -> Beyond | None:
        """What the energies change beyond the bounds, if it comes to `GROWTH` where it goes on like this.

        `closely` : also by the powers of forces; else of moved constraints only
        """
        nodes = Nodes._make(np.concatenate(column) for column in zip(*segments, strict=True))
        h = np.diff(nodes.t)
        h[np.cumsum([len(one.t) for one in segments])[:-1] - 1] = 0.0  # from one segment to the next
        kinetic, potential, power = self._sampler.energies(nodes).T
        self._greatest = max(self._greatest, float(kinetic.max()))
        beyond = np.zeros((2, len(h)))
        for energy, beyond in self._explained(nodes, h, kinetic + potential, power, closely):
            largest = np.max(abs(energy), initial=0.0, where=np.isfinite(energy))
            round_off = ERRORS * np.finfo(float).eps * largest
            if not _sums(beyond).max() > GROWTH * self._greatest * h.sum() / self.span + round_off:
                return None
        sizes = np.maximum(self._system.layout.scales(extent(self._system, nodes.q[0])), abs(nodes.q))
        self._fastest = max(self._fastest, float((abs(nodes.v) / sizes).max()))
        return Beyond(nodes.t[1:], beyond)

    def _explained(
        self, nodes: Nodes, h: Array, energy: Array, power: Array, closely: bool
    ) -> Iterator[tuple[Array, Array]]:
        """Energies, and their changes beyond the bounds of ever more powers; wanted as long as these are much."""
        beyond = _beyond(h, energy, _near(power))
        yield energy, beyond
        if not self._forces:
            yield energy, beyond * np.array(unexplained(self._system))[:, None]
        elif closely:
            stored, net = self._of_forces(nodes)
            energy, powers = energy + stored, _near(power + net)
            yield energy, _beyond(h, energy, powers)
            yield energy, _beyond(h, energy, np.hstack([powers, self._within(nodes, h)]))

    def _within(self, nodes: Nodes, h: Array) -> Array:
        """Powers within the steps (steps, parts)."""
        t = nodes.t[:-1, None] + h[:, None] * PARTS
        states = self._states.states(nodes, t.ravel(), shortest=False, monitored=False)
        inner = Nodes(states.t, states.q, states.v, states.a, states.lam, states.memory)
        return np.asarray(self._sampler.energies(inner)[:, 2] + self._of_forces(inner)[1]).reshape(t.shape)

    def _of_forces(self, states: Nodes) -> Array:
        """What forces store without a potential, and supply less what they dissipate (2, n)."""
        places, motion = self._system.memory_places.tolist(), {"t": states.t, "q": states.q, "v": states.v}
        memory = dict(zip(places, states.memory.T, strict=True))
        found = np.zeros((2, len(states.t)))
        for p, own in self._forces:
            if own.order:
                found += values_of_elements(p, *own, self._sampler.b, memory, motion).sum(axis=1)
        return found

    def state(self) -> dict[str, Array]:
        """See `RunPart`; all steps taken are looked at."""
        self._look()
        return super().state()

    def warnings(self, run: Trajectory, tolerances: Tolerances) -> list[str]:
        """A warning where energy appeared or vanished, by more than `GROWTH` of the greatest kinetic energy.

        Changes that position errors within the tolerances explain, as in very stiff springs, are not reported, nor
        those of runs so short that half of the digits of the positions do not change: their velocities are round-off.
        """
        self._look()
        if not run.success or self._fastest * self.span <= np.sqrt(np.finfo(float).eps):
            return []
        n = int(np.argmax(self._most))
        least, most = GROWTH * self._greatest, float(self._most[n])
        if not (most > least and most > _energy_of_errors(self._system, run, tolerances, self.span)):
            return []
        how, what = (("grew", "supply"), ("fell", "dissipate"))[n]
        return [
            f"{self._system.name}: the total energy {how} by {most:.3g} J more than its parts {what}, most near "
            f"t = {self._times[n]:.6g} s; the kinetic one is at most {self._greatest:.3g} J. The run is wrong: use "
            "smaller tolerances or shorter steps, or method=sr.Radau()."
        ]


def _some(segment: Nodes) -> Nodes:
    """The nodes between which energies are compared first."""
    return Nodes._make(np.concatenate([x[:-1:SPARSE], x[-1:]]) for x in segment)


def _beyond(h: Array, energy: Array, powers: Array) -> Array:
    """How much more the energy grew, and fell, in each step than by its largest and least power (2, steps)."""
    with np.errstate(invalid="ignore"):  # laws may have a pole between their zero and the motion
        change = np.diff(energy)
        beyond = np.array([change - h * powers.max(axis=1), h * powers.min(axis=1) - change])
    return np.where(np.isfinite(beyond) & (h > 0), beyond, 0.0)


def _near(power: Array) -> Array:
    """The powers at the ends of each step, and of those before and after it (steps, 4)."""
    every = np.concatenate([power[:1], power, power[-1:]])
    return np.asarray(every[np.arange(len(power) - 1)[:, None] + np.arange(4)])


def _sums(beyond: Array) -> Array:
    """The largest sum of steps in succession up to each (2, steps)."""
    sums = np.cumsum(beyond, axis=1)
    return np.asarray(sums - np.minimum(np.minimum.accumulate(sums, axis=1), 0.0))


def _energy_of_errors(system: System, run: Trajectory, tolerances: Tolerances, span: float) -> float:
    """|Q|ᵀe + ½ eᵀ|Q_q|e + ½ ėᵀM ė at the last state. [J]

    Errors e of positions are `ERRORS` times tolerances and round-off; they arise within the whole time, ė = e/T.
    """
    t, q, v, memory = (np.asarray(x)[-1] for x in (run.t, run.q, run.v, run.memory))
    system = system.with_memory(memory)
    error = ERRORS * (tolerances.of_motion(np.asarray(run.q)) + np.finfo(float).eps * abs(q))
    stiffness = abs(system.Q_q(q, v, t))
    moving = error / span
    energy = 0.5 * (error @ (stiffness @ error) + moving @ (abs(system.M(q)) @ moving))
    return float(abs(system.Q(q, v, t)) @ error + energy)
