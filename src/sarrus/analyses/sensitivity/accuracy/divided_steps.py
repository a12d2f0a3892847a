"""Steps of a run divided into shorter ones along the same motion, for adjoints that change fast at the ends of steps.

Each part is half as long as the one before it: s = 0, 1/2, 3/4, …, 1 - 2⁻ᵐ, 1. Radau IIA, linearized about the reported
motion, carries the adjoint back over the parts, and within each of them it is linear, but for a filter.

In stiff directions, which rotate with the bodies, the defect d is of the size of the stiffness times an error of the
motion. The adjoint is small there, as it satisfies ȳ' = -Jᵀȳ; a linear one that is right at both ends is not, by the
square of the angle of a part. A step of the implicit Euler method back to a point s of the rule, with J at that point,

    ŷ(s) = (I - h Jᵀ)⁻¹ ȳ(s + 1) = ȳ(s) + h (I - h Jᵀ)⁻¹ (ȳ' + Jᵀȳ),

keeps the adjoint of slow directions to the order of the linear one, and in stiff directions makes it small. It is the
transposed filter of the estimated error in Hairer and Wanner, IV.8.19.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ....system import System
from ...dynamics.methods.collocation import RADAU, radau
from ...dynamics.methods.description import Description
from ...dynamics.methods.nonholonomic import method_for
from ...dynamics.methods.splitting import split_of
from ...dynamics.methods.tables import structure_of, tables_of
from ..sampling.settled import Settled, settled
from ..steps.record import SPLIT_TO_WEIGH_FROM, WEIGHING, Occurrences, Operations, Source
from ..steps.sweep import ORDERS, Order, Sweep
from ..steps.sweep_loop import NodeArrays
from .defect import POINTS, rule, slopes

EULER = radau(1)
# Pivots of steps of the implicit Euler method to points of a run's steps
EULER_ORDERS: WeakKeyDictionary[StepsTaken, dict[tuple[bool, ...], Order]] = WeakKeyDictionary()
KINDS = ("q", "v")


def whole_steps(
    system: System, steps: StepsTaken, which: Array, adjoints: Array, known: Settled | None
) -> Array:
    """The parts in errors (n, k) of undivided steps, by filtered adjoints (n, 2, 2 nq, k).

    States at the points of the rule may be `known`.
    """
    return DividedSteps.of(system, steps, which, 0, known).weighted_defects(adjoints)


def parts_in_errors(system: System, steps: StepsTaken, which: Array, after: Array, halvings: int) -> Array:
    """The parts in errors (k,) of steps with these numbers (k,), each by one adjoint after it (2 nq, k)."""
    own, row = np.unique(which, return_inverse=True)
    found = DividedSteps.of(system, steps, own, halvings)
    if steps.scheme is RADAU:  # pivots of its sweep serve here, too
        ORDERS[found] = ORDERS.setdefault(steps, {})
    shares = found.weighted_defects(found.adjoints(row, after))
    return np.asarray(shares.reshape(len(own), -1, len(row)).sum(axis=1)[row, np.arange(len(row))])


@dataclass(frozen=True, eq=False)
class DividedSteps:
    """Some steps of a run, all divided alike.

    Attributes
    ----------
    h, t : (parts,) lengths, (parts, points) times of stages and of Gauss's points [s]
    nodes : (2, parts, 2 nq) q and v at both ends of each part
    states : of kinds q, v, a and λ at these points
    of_stages, of_rule : places of both among the points
    b, places, memory, left_out : parameters, what elements store, and left-out equations, as of `StepsTaken`
    orders : those of pivots for steps of the implicit Euler method
    method : that carries adjoints
    """

    system: System
    h: Array
    t: Array
    nodes: Array
    states: dict[str, Array]
    of_stages: Array
    of_rule: Array
    b: Array
    places: Array
    memory: Array
    left_out: Array
    orders: dict[tuple[bool, ...], Order]
    method: Description = RADAU

    @classmethod
    def of(
        cls, system: System, steps: StepsTaken, which: Array, halvings: int, known: Settled | None = None
    ) -> DividedSteps:
        """Those of some steps, with as many parts as halvings and one more; states are those that the run reports.

        Undivided ones have no stages, as adjoints are not carried over them.
        """
        ends, lengths = 1 - 0.5 ** np.arange(halvings + 2.0), np.diff(steps.t)[which, None, None]
        ends[-1], last = 1.0, which + 1
        stages = [stage.time for stage in RADAU.step(1.0, 1.0).stages] if halvings else [1.0]
        points, place = np.unique([*stages, *rule(POINTS)[0]], return_inverse=True)
        h = lengths * np.diff(ends)[:, None]
        t = steps.t[which, None, None] + lengths * ends[:-1, None] + h * points
        t[:, -1, -1] = steps.t[last]
        inside = known or settled(system, steps, t.reshape(len(which), -1)[:, :-1].ravel(), shortest=False)
        states = dict[str, Array]()
        for name in ("q", "v", "a", "lam"):  # at the end of a step those of the run: forces may jump there
            own = getattr(inside, name).reshape(len(which), t[0].size - 1, -1)
            states[name] = np.concatenate([own, getattr(steps, name)[last, None]], axis=1).reshape(
                *t.shape, -1
            )
        first = np.concatenate([getattr(steps, name)[which] for name in KINDS], axis=1)
        after = np.concatenate([states[name][:, :, -1] for name in KINDS], axis=2)
        nodes = np.stack([np.concatenate([first[:, None], after[:, :-1]], axis=1), after])
        count = halvings + 1
        return cls(
            system, h.ravel(), t.reshape(-1, len(points)), nodes.reshape(2, h.size, -1),
            {name: x.reshape(h.size, *x.shape[2:]) for name, x in states.items()},
            place[: len(stages)], place[len(stages) :], steps.b, steps.places,
            np.repeat(steps.memory[which], count, axis=0),
            np.repeat(steps.left_out[last], count, axis=0) if len(steps.left_out) else steps.left_out,
            EULER_ORDERS.setdefault(steps, {}),
        )  # fmt: skip

    def __len__(self) -> int:
        """Number of parts."""
        return len(self.h)

    def weighted_defects(self, adjoints: Array) -> Array:
        """The parts in errors (parts, k), by adjoints before and after each (parts, 2, 2 nq, k), which are filtered."""
        s, w = rule(POINTS)
        q, v, a = (self.states[name][:, self.of_rule] for name in ("q", "v", "a"))
        first, last = self.nodes[:, :, None]
        through = np.concatenate([first, np.concatenate([q, v], axis=2), last], axis=1)
        d = np.einsum("sp,npj->nsj", slopes(POINTS), through)
        d -= self.h[:, None, None] * np.concatenate([v, a], axis=2)
        before, after = (adjoints[:, None, n] for n in (0, 1))
        beyond = before + (1 + s[:, None, None]) * (after - before)
        filtered = self.points._backward(beyond.reshape(-1, *beyond.shape[2:]), alone=True)
        return np.asarray(np.einsum("s,nsj,nsjk->nk", w, d, filtered.reshape(beyond.shape)))

    @property
    def points(self) -> DividedSteps:
        """A step of the implicit Euler method as long as its part to each point of the rule."""
        count, every = len(self.of_rule), np.zeros(1, np.int64)
        states = {name: x[:, self.of_rule].reshape(-1, 1, x.shape[2]) for name, x in self.states.items()}
        h, memory, left_out = (np.repeat(x, count, axis=0) for x in (self.h, self.memory, self.left_out))
        found = replace(
            self, h=h, t=self.t[:, self.of_rule].reshape(-1, 1), states=states, of_stages=every, of_rule=every,
            memory=memory, left_out=left_out, method=EULER,
        )  # fmt: skip
        ORDERS[found] = self.orders
        return found

    def adjoints(self, row: Array, after: Array) -> Array:
        """Adjoints before and after all parts (parts, 2, 2 nq, k), each from the end of one of the steps (k,)."""
        ends, given = (row + 1) * (len(self) // (row.max() + 1)) - 1, np.zeros((len(self), *after.shape))
        given[ends, :, np.arange(len(row))] = after.T
        return self._backward(given, alone=False)

    def _backward(self, given: Array, alone: bool) -> Array:
        """Adjoints before and after all parts (parts, 2, 2 nq, k) by gradients by states after them (parts, 2 nq, k).

        Of parts `alone`, which do not depend on each other, those before (parts, 2 nq, k).
        """
        (parts, _, k), nq = given.shape, self.system.nq
        of_kinds = (np.ascontiguousarray(given[:, own]) for own in (slice(nq), slice(nq, None)))
        nodes = NodeArrays(*of_kinds, *(np.zeros((parts, size, k)) for size in (nq, self.system.m)))
        sweep = Sweep(self.operations, k, by_parameters=False)
        state = sweep.state()
        found = np.zeros((parts, *state.shape) if alone else (parts, 2, 2 * nq, k))
        sweep.backward(state, nodes, initial=found if alone else None, adjoints=None if alone else found)
        return found[:, : 2 * nq] if alone else found

    @cached_property
    def operations(self) -> Operations:
        """The method over all parts."""
        method, every = method_for(self.system, self.method), np.arange(len(self))
        operation = method.operation(self.h, np.ones(len(self.h)))
        tables = tables_of(self.system, structure_of(operation))
        mu = Source(np.zeros((len(self), self.system.m)))
        values = {(s, name): self.states.get(name) for s, name in tables.recorded}
        sources = {
            key: mu if x is None else Source(np.ascontiguousarray(x[:, self.of_stages[key[0]]]))
            for key, x in values.items()
        }
        times = self.t[:, self.of_stages]
        absent = Occurrences(operation, tables, every[:0], every[:0], times[:0], {})
        steps = Occurrences(operation, tables, every, every, times, sources)
        found = Operations(self.system, self, [absent, steps, absent])
        found.left = found.plain = WEIGHING
        if tables.n >= SPLIT_TO_WEIGH_FROM * len(self.of_stages):
            found.split = split_of(method)
        return found
