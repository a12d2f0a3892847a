"""Energies and powers of elements along a motion, and their integrals.

The energy of an element is recorded from its formula, differentiated, and compiled for several states at once; that
of all of them is one operation on a tape. Left out are elements with curves or memory: these have numbers of their own
at every time, and are recorded on the tape themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from .._jit.formulas.differentiate import directional
from .._jit.formulas.expression import Expression, Graph
from .._jit.formulas.reverse import gradient
from .._jit.kernels import emit
from .._jit.kernels.emit import NUMBERS_DOT
from .._jit.kernels.pointer import KernelTable, call_kernels
from .._jit.kernels.vector import LANES
from .._jit.linking.link import compiled, link
from ..algebra import Array
from ..elements import Force
from ..elements.derived import potential
from ..elements.evaluation import element_from
from ..elements.operators import OPERATORS
from ..elements.recorder import Variant
from ..model.states.block import StateInertia
from ..model.tape import Tracer, whole
from ..system import System
from ..system.cached import once
from ..system.curves.lanes import Recipe, aligned, block, entry, local, used
from ..system.structure.population import Population
from .recording import Recording


@compiled(entry=True)
def energy_gradients(
    entry: KernelTable,
    b: Array,
    t: Array,
    q: Array,
    v: Array,
    value: Array,
    by_q: Array,
    by_v: Array,
    by_b: Array,
) -> None:
    """Values and gradients of all blocks; the operands are in lanes, a block in every row."""
    for n in range(len(t)):
        call_kernels(entry, b, t[n], q[n], v[n], value[n], by_q[n], by_v[n], by_b[n])


@compiled(entry=True)
def energy_gradients_along(
    entry: KernelTable, b: Array, t: Array, q: Array, v: Array, q_dot: Array, v_dot: Array, b_dot: Array, by_q: Array,
    by_v: Array, by_b: Array,
) -> None:  # fmt: skip
    """The changes of the gradients."""
    for n in range(len(t)):
        call_kernels(entry, b, t[n], q[n], v[n], q_dot[n], v_dot[n], b_dot, by_q[n], by_v[n], by_b[n])


Energy = Literal["kinetic", "potential"]
OPERANDS = ("q", "v")
DOTS = ("q_dot", "v_dot", NUMBERS_DOT)
OWN = ("Curve", "Memory")  # fields that have other numbers at every time


class RecordedEnergy(NamedTuple):
    """The energy of one element, recorded, and its inputs: coordinates and rates of its owners, and numbers."""

    graph: Graph
    value: Expression
    q: Array
    v: Array
    numbers: Array


def members(system: System, energy: Energy) -> list[Population]:
    """The elements that have an energy."""
    return [p for p in system.populations if p.count and _has(p, energy)]


def _has(p: Population, energy: Energy) -> bool:
    if energy == "kinetic":
        return OPERATORS["M_a"] in p.kind.family and not issubclass(p.kind, StateInertia)
    return callable(getattr(p.kind, "potential", None))


def plain(p: Population) -> bool:
    """Whether elements of a kind have the same numbers at all times."""
    return not any(field in OWN for field in p.kind.fields.values())


def recorded(variant: Variant, energy: Energy) -> RecordedEnergy:
    """½ vᵀ M v, or the sum of what `potential` returns."""
    graph, kind = Graph(), variant.kind
    q, v = (variant.inputs(graph, name) for name in OPERANDS)
    numbers = graph.inputs("numbers", kind.size())
    element: Any = element_from(kind, numbers, t=graph.input("t"))
    x, rate = local(variant, q, "q"), local(variant, v, "v")
    parts = [potential(element, x)] if energy == "potential" else _halves(rate, element.M_a(x, rate))
    (value,) = graph.expressions([sum(parts)])
    return RecordedEnergy(graph, value, q, v, numbers)


def _halves(rate: Any, momentum: Any) -> list[Any]:
    return [0.5 * (part @ own) for part, own in zip(rate, momentum, strict=True) if own is not None]


class MotionEnergy:
    """The energy of all plain elements of a system along a motion.

    Parameters
    ----------
    system, energy : which one
    b : (len(system.b),) numbers
    t, q, v : the motion (nt,), (nt, nq)

    Attributes
    ----------
    coordinates, numbers : those that it depends on, by place in q and in b
    value : (nt,) [J]
    slopes : by these coordinates, by their rates, and by these numbers (n, nt)
    """

    def __init__(self, system: System, energy: Energy, b: Array, t: Array, q: Array, v: Array) -> None:
        self._system, self._energy, self._b, self._count = system, energy, b, len(t)
        own = [p for p in members(system, energy) if plain(p)]
        self.coordinates = np.unique(
            np.concatenate([np.zeros(0, np.int64), *(p.coordinates.ravel() for p in own)])
        )
        self.numbers = np.concatenate([np.zeros(0, np.int64), *(np.arange(p.at, p.end) for p in own)])
        self._motion = [in_lanes(x) for x in (t[:, None], q, v)]
        value = self._zeros(1)
        results = [value, *self._results()]
        link(energy_gradients)(_slopes_entry(system, energy), b, *self._motion, *results)
        self.value, self.slopes = self._by_time(value, [0])[0], self._sorted(results[1:])

    def turned(self, q_dot: Array, v_dot: Array, b_dot: Array) -> Array:
        """The changes of the slopes for changes of all coordinates, rates (nt, nq) and numbers (len(b),)."""
        (t, q, v), results = self._motion, self._results()
        table, dots = _along_entry(self._system, self._energy), (in_lanes(q_dot), in_lanes(v_dot))
        link(energy_gradients_along)(table, self._b, t, q, v, *dots, b_dot, *results)
        return self._sorted(results)

    def _zeros(self, width: int) -> Array:
        return aligned(len(self._motion[0]), width * LANES)

    def _results(self) -> list[Array]:
        return [self._zeros(width) for width in (self._system.nq, self._system.nq, len(self.numbers))]

    def _sorted(self, results: Sequence[Array]) -> Array:
        places = (self.coordinates, self.coordinates, np.arange(len(self.numbers)))
        return np.concatenate([self._by_time(x, at) for x, at in zip(results, places, strict=True)])

    def _by_time(self, x: Array, places: Any) -> Array:
        """Some entries of what is in lanes (places, nt)."""
        found = used(len(places), len(x), LANES)
        found[:] = x.reshape(len(x), -1, LANES)[:, places].transpose(1, 0, 2)
        return found.reshape(-1, len(x) * LANES)[:, : self._count]


def in_lanes(x: Array) -> Array:
    """A row for every time (nt, n): a row for every block of times, in lanes; the last time fills up its block."""
    blocks = -(-len(x) // LANES)
    whole, found = used(blocks * LANES, x.shape[1]), used(blocks, x.shape[1], LANES)
    whole[: len(x)], whole[len(x) :] = x, x[-1:]
    found[:] = whole.reshape(blocks, LANES, -1).transpose(0, 2, 1)
    return found.reshape(blocks, -1)


@once
def _slopes_entry(system: System, energy: Energy) -> Any:
    """Operands t, q, v; the energy and its gradient by q, v and the numbers are added to the outputs."""
    own = [p for p in members(system, energy) if plain(p)]
    along = ("one", "coordinates", "coordinates", "numbers")
    recipes = [Recipe(p.variant, _slopes, energy, OPERANDS) for p in own]
    return entry(own, recipes, along, "energy", _firsts(own))


@once
def _along_entry(system: System, energy: Energy) -> Any:
    """Operands t, q, v and their changes; the change of the gradient is added to the outputs."""
    own = [p for p in members(system, energy) if plain(p)]
    along = ("coordinates", "coordinates", "numbers")
    recipes = [Recipe(p.variant, _gradients_along, energy, (*OPERANDS, *DOTS)) for p in own]
    return entry(own, recipes, along, "energy", _firsts(own))


def _firsts(own: Sequence[Population]) -> list[int]:
    """Return the first indices of the parameters of populations."""
    sizes = [p.end - p.at for p in own]
    return [sum(sizes[:n]) for n in range(len(sizes))]


def _slopes(variant: Variant, energy: Energy) -> emit.Recording:
    one = recorded(variant, energy)
    return _recording(variant, energy, one.graph, OPERANDS, [block([one.value])], _gradient(one))


def _gradients_along(variant: Variant, energy: Energy) -> emit.Recording:
    one = recorded(variant, energy)
    graph, taken = one.graph, [*one.q.flat, *one.v.flat, *one.numbers]
    dots = [variant.inputs(graph, name) for name in DOTS[:2]]
    moved = [*dots[0].flat, *dots[1].flat, *graph.inputs(NUMBERS_DOT, len(one.numbers))]
    slopes = graph.expressions(_gradient(one))
    change = directional(graph, slopes, list(zip(taken, moved, strict=True)))
    return _recording(variant, energy, graph, (*OPERANDS, *DOTS), [], change)


def _gradient(one: RecordedEnergy) -> list[Any]:
    return gradient(one.graph, one.value, [*one.q.flat, *one.v.flat, *one.numbers])


def _recording(
    variant: Variant, energy: Energy, graph: Graph, arrays: tuple[str, ...], first: list[list[Array]], by: list[Any]
) -> emit.Recording:  # fmt: skip
    """Return the recorded functions of some outputs by coordinates, rates and parameters."""
    size, cut = variant.kind.size(), sum(variant.widths)
    bodies = [variant.split(part) for part in (by[:cut], by[cut : 2 * cut])]
    found = emit.Recording(f"{variant.name}.{energy}", graph, variant.moving, size, arrays, ("t",))
    found.outputs += [emit.Output(blocks, True) for blocks in (*first, *bodies, block(by[2 * cut :]))]
    return found


class EnergyRecording(Recording):
    """A recording with energies."""

    def kinetic_energy(self) -> Any:
        """½ vᵀ M v. [J]"""
        return self._summed("kinetic")

    def potential_energy(self) -> Any:
        """Return the potential energy of gravity, springs, bushings, and users' elements with `potential`. [J]"""
        return self._summed("potential")

    def _summed(self, energy: Energy) -> Any:
        """The energy of all elements."""
        others = [p for p in members(self.system, energy) if not plain(p)]
        every = [(p, recorded(p.variant, energy), k) for p in others for k in range(p.count)]
        found = sum(self.replayed(p, k, one.graph, [one.value])[0] for p, one, k in every)
        along = MotionEnergy(self.system, energy, self._b, self.states.t, self.states.q, self.states.v)
        return self._on_tape(along) + found if len(along.coordinates) else found

    def _on_tape(self, along: MotionEnergy) -> Tracer:
        """An energy as one operation."""
        inputs = [self.input(kind, int(n)) for kind in ("q", "v") for n in along.coordinates]
        inputs += [self.input("b", int(n)) for n in along.numbers]
        width, count = len(along.coordinates), len(self.states.t)

        def turned(dots: Sequence[Any]) -> Array:
            q_dot, v_dot = np.zeros((2, count, self.system.nq))
            for n, place in enumerate(along.coordinates):
                q_dot[:, place], v_dot[:, place] = dots[n], dots[width + n]
            b_dot = np.zeros(len(self._b))
            b_dot[along.numbers] = dots[2 * width :]
            return along.turned(q_dot, v_dot, b_dot)

        return self.tape.add(
            whole(along.value, along.slopes, turned), tuple(x.at for x in inputs), along.value
        )


WORDS = ("supplied", "dissipated")


def drivers_of(system: System) -> list[str]:
    """Drivers, and joints whose equations contain the time."""
    timed = (owner for p in system.populations if p.kind.rows and p.kind.timed for owner in p.owners if owner)
    return [*dict.fromkeys([*(one.name for one in system.model.drivers), *timed])]


def forces_of(system: System) -> list[str]:
    """Parts with force elements, without the weights of bodies."""
    working = (p for p in system.populations if issubclass(p.kind, Force) and "power" in p.kind.outputs)
    owners = (owner for p in working for owner in p.owners)
    return [owner for owner in dict.fromkeys(owners) if owner not in system.bodies]
