"""Growth of the errors of a run: warnings of chaotic and unstable motions.

Two perturbations are carried along the motion, see `perturbation_loop`, and over impacts: one alone can be nearly one
of those that decay. Where one grows so much that what the tolerances allow could become visible, or the steps are very
many, the motion is computed again with larger tolerances: the difference shows the error. Free flights between impacts
are exact with any tolerance; then one is computed from a start that is rounded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.sparse_solver import SingularMatrix
from ....results import Trajectory
from ....system import System
from ...equations.block_matrix import LEFT_OUT, Numbers, Part, PlacedMatrix, entries_of
from ...equations.length import extent
from ..dense_output.sample_loop import Samples
from ..dense_output.sampler import Sampler
from ..events.events import Watch
from ..stepping.entries import entry_of
from ..stepping.nodes import Nodes
from ..stepping.stepper import Stepper
from ..stepping.tolerance import Tolerances
from . import perturbation_loop as loop
from .perturbation_loop import BLOCKS, weigh
from .perturbation_loop import LEAST_MOTION as LEAST

VISIBLE = 5e-4  # of the size of the motion: larger errors are reported; a thousandth is not passed in silence
LOCAL = 0.1  # of the relative tolerance: error of a step
GROWN = 6e4  # times the error of a step: so much do errors of regular motions of thousands of steps add up to
MARGIN = 1e3  # times the perturbation: by chance it can be nearly one of those that decay
LONG = 200_000  # steps of a run from which errors of regular motions can add up to visible ones
ROUND_OFF = 1e-15  # of the size of the motion
STRUCK_EXACTLY = 1e-13  # of the size of the motion: so exact are times of impacts, see `events.NEAR`
STRUCK = 1e-6  # of the size of the motion: a perturbation with which an impact is computed again
# Times the tolerances, of runs that are compared, one after the other, and the difference that settles the matter
COARSE, FINE = 1e3, (30.0, 10.0)
SETTLED = 0.03
ALIKE = 3.0  # factor between errors by two such runs, within which they are those of a regular motion
ROUNDED = 30.0  # times the error of impacts, of the start that is rounded
END = "end"
GROUPS = {  # operators that are computed together, as implicit methods do
    "jacobian": ("Phi_q", "Phi_qT_lam_q"),
    "inertia": ("M", "M_a_q", "S_q", "S_v"),
    "stiffness": ("Q_q", "Q_v"),
    "constraints": ("Phi_q",),
    "turning": ("gamma_v",),
}


class ErrorGrowth:
    """Perturbations of one run.

    Parameters
    ----------
    system : System
    stepper : the method at work
    tolerances : of the run

    Attributes
    ----------
    grown : whether errors may have become visible
    struck : whether an impact is among what the perturbations went over
    """

    def __init__(self, system: System, stepper: Stepper, tolerances: Tolerances) -> None:
        self._system, self._stepper, self._tolerances = system, stepper, tolerances
        nq, m = system.nq, system.m
        self._numbers = Numbers(system, (*BLOCKS, LEFT_OUT, "Phi_q", END, "gamma_v"), {END: "Phi_q"})
        parts = [Part(name, 0, 0) for name in BLOCKS]
        parts += [Part(LEFT_OUT, nq, nq), Part(END, nq, 0), Part("Phi_q", 0, nq, transposed=True)]
        self._matrix = PlacedMatrix(self._numbers, nq + m, parts)
        self._entries = loop.Entries(**{name: entry_of(system, *group) for name, group in GROUPS.items()})
        self._patterns = loop.Patterns(
            *(loop.Pattern(*entries_of(system, name)) for name in loop.Patterns._fields)
        )
        widths = (nq, nq, nq, m, nq, nq, nq, nq + m, nq + m, 2 * nq)
        self._work = loop.Work(*(np.zeros(width) for width in widths))
        random = np.random.default_rng(0).uniform(-1.0, 1.0, (2, 2 * nq))
        measured = (np.arange(nq) < system.moving).astype(float)
        shared = np.zeros(nq), np.zeros(4), np.array([0.0, 1.0]), measured
        self._own, self._twin = (
            loop.Perturbation(q, v, a, signs, *shared)
            for (q, v, a), signs in zip(np.zeros((2, 3, nq)), random, strict=True)
        )
        self._started, self.grown, self._length, self._b = False, False, 1.0, system.b.copy()
        self.struck = False

    def is_doubtful(self, nsteps: int) -> bool:
        """Whether errors may be visible after so many steps."""
        return self.grown or nsteps >= LONG

    def look(self, nodes: Nodes) -> None:
        """Take further nodes of the run."""
        if self.grown:
            return
        if not self._started:
            self._started, self._length = True, extent(self._system, nodes.q[0])
            self._own.base[:] = nodes.q[0]
            self._b[:] = self._stepper.b
        self._numbers.keep(self._stepper.independence.rows)
        n, tried, before = 0, -1, self.state()
        carry = link(loop.carry)
        while n + 1 < len(nodes.t) and not self.grown:
            if self._matrix.placed is None and (tried == n or not self._choose_pivots(nodes, n)):
                n, tried, self._own.known[0] = n + 1, -1, 0.0
                continue
            tried = n
            n, largest = carry(
                self._entries, self._b, self._system.memory_places, nodes, n, self._length, self._own, self._twin,
                self._arrays(), self._patterns, self._work, self._least(nodes.q[-1]),
            )  # fmt: skip
            if not np.isfinite(largest):  # in a singular configuration
                self.resume(before)
                self._own.known[:] = 0.0, 1.0
                return
            self.grown = largest >= self._least(nodes.q[-1])
            if n + 1 < len(nodes.t):
                tried, self._matrix.placed = (n if tried == n else -1), None

    def strike(self, watch: Watch, before: Samples, after: Samples, sampler: Sampler) -> None:
        """Over an impact, which the perturbed motion meets at another time, in another place, with another speed."""
        self.struck = True
        for own in (self._own, self._twin):
            self._strike(own, watch, before, after, sampler)

    def _strike(
        self, own: loop.Perturbation, watch: Watch, before: Samples, after: Samples, sampler: Sampler
    ) -> None:
        near, t = watch.near, float(before.t[0])
        q, v, a, v_after, a_after = before.q[0], before.v[0], before.a[0], after.v[0], after.a[0]
        lengths, speeds = (max(x, LEAST * self._length * turn) for x, turn in own.moved.reshape(2, 2))
        size = max(
            abs(own.q).max(initial=0.0) / (lengths or 1.0), abs(own.v).max(initial=0.0) / (speeds or 1.0)
        )
        if self.grown or not size or not speeds:
            return
        part, h = STRUCK / size, STRUCK * lengths / speeds

        def crossed(x: Array, y: Array) -> float:
            return float(watch.function(t, q + x, v + y) - watch.function(t, q - x, v - y)) / 2

        rate = (watch.function(t + h, q + h * v, v + h * a) - watch.function(t - h, q - h * v, v - h * a)) / (
            2 * h
        )
        later = -crossed(part * own.q, part * own.v) / rate if rate else 0.0
        velocities = [
            watch.after(
                t + s * later, q + s * (part * own.q + later * v), v + s * (part * own.v + later * a), sampler
            )
            for s in (-1, 1)
        ]
        watch.near = near
        own.q[:] += later / part * (v - v_after)
        own.v[:] = ((velocities[1] - velocities[0]) / 2 - later * a_after) / part
        own.known[0] = 0.0

    def _least(self, q: Array) -> float:
        """The growth from which errors may be visible."""
        visible = VISIBLE / max(LOCAL * relative(self._tolerances, q, self._own), ROUND_OFF)
        return max(visible / MARGIN, GROWN)

    def _choose_pivots(self, nodes: Nodes, n: int) -> bool:
        """A pivot order for the n-th node; false where its matrix is singular."""
        state = {
            "t": float(nodes.t[n]),
            "q": nodes.q[n],
            "v": nodes.v[n],
            "a": nodes.a[n],
            "lam": nodes.lam[n],
        }
        for name in ("jacobian", "inertia", "stiffness"):
            self._numbers.evaluate(GROUPS[name], self._b, state)
        self._numbers.views[END][:] = self._numbers.views["Phi_q"]
        weigh(self._matrix.weights, 0.0, 0.0)
        try:
            self._matrix.choose_pivots()
        except (SingularMatrix, ValueError):
            return False
        return True

    def _arrays(self) -> loop.Matrix:
        numbers = self._numbers
        rest = numbers.row_of, numbers.left_out, self._matrix.placed
        return loop.Matrix._make([numbers.values, *numbers.of(loop.Matrix._fields[1:-3]), *rest])

    def _named(self) -> Iterator[tuple[str, Array]]:
        for prefix, one in (("", self._own), ("twin_", self._twin)):
            yield from ((prefix + name, array) for name, array in one._asdict().items())

    def state(self) -> dict[str, Array]:
        """Return the data that a continued run needs."""
        found = {f"growth_{name}": array.copy() for name, array in self._named()}
        return found | {"growth_flags": np.array([self._started, self.grown, self.struck, self._length])}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        for name, array in self._named():
            array[:] = state[f"growth_{name}"]
        *flags, self._length = state["growth_flags"].tolist()
        self._started, self.grown, self.struck = map(bool, flags)


def relative(tolerances: Tolerances, q: Array, own: loop.Perturbation) -> float:
    """Tolerance of coordinates over the size of the motion."""
    if tolerances.follow:
        return float(tolerances.rtol_q.max())
    moved = own.moved[:2].max(initial=0.0)
    return float((tolerances.atol_q + tolerances.rtol_q * abs(q)).max() / moved) if moved > 0 else 0.0


def looser(tolerances: Tolerances, factor: float) -> Tolerances:
    """The tolerances of a run that is compared."""
    names = ("rtol_q", "atol_q", "rtol_v", "atol_v")
    factors = {name: factor * getattr(tolerances, name) for name in names}
    return replace(tolerances, **factors)


def lost_digits(
    run: Trajectory,
    other: Callable[[float], tuple[Trajectory, float]],
    rounded: Callable[[float], Trajectory] | None = None,
) -> list[str]:
    """A warning where runs with larger tolerances, or from a start that is rounded, show a visible error.

    Parameters
    ----------
    run : Trajectory
    other : the run with so many times the tolerances, and the power of them that its errors go with
    rounded : the run from a start whose numbers have errors of so much, of a run with impacts
    """
    if not len(run.t):
        return []
    late = _late(run, other)
    if rounded:
        late += _first(difference_of(run, rounded(ROUNDED * STRUCK_EXACTLY)) > VISIBLE * (ROUNDED - 1))
    if not late:
        return []
    return [
        f"{run.name}: errors have grown beyond {VISIBLE:g} of the size of the motion from t = {run.t[min(late)]:.4g} s "
        "on, as in unstable, chaotic and very long motions. Choose smaller tolerances, or a shorter run."
    ]


def _late(run: Trajectory, other: Callable[[float], tuple[Trajectory, float]]) -> list[int]:
    """The first time at which runs with larger tolerances show a visible error, if there is one."""
    coarse, power = other(COARSE)
    difference = difference_of(run, coarse)
    if difference.max(initial=0.0) < min(SETTLED, VISIBLE * (COARSE**power - 1)):
        return []
    of_run = difference.max() / (COARSE**power - 1)
    for factor in FINE:  # in chaos the first one can agree by chance, with far less than the coarse one
        fine, power = other(factor)
        difference = difference_of(run, fine)
        if late := _first(difference > VISIBLE * (factor**power - 1)):
            return late
        if difference.max(initial=0.0) > of_run / ALIKE * (factor**power - 1):
            return []
    return []


def _first(late: Array) -> list[int]:
    return [int(late.argmax())] if late.any() else []


def difference_of(run: Trajectory, other: Trajectory) -> Array:
    """The largest difference of coordinates at each time that both reach, over the size of the motion (n,)."""
    assert run.system is not None
    moving = run.system.moving
    q, p = np.asarray(run.q)[:, :moving], np.asarray(other.q)[:, :moving]
    count, rotation = min(len(q), len(p)), np.arange(q.shape[1]) % 7 >= 3
    moved, length = np.ptp(q, axis=0), extent(run.system, q[0])
    shift, turn = (float(moved[rotation == kind].max(initial=0.0)) for kind in (False, True))
    sizes = np.where(rotation, max(turn, LEAST * shift / length), max(shift, LEAST * length * turn))
    found = np.divide(abs(q[:count] - p[:count]), sizes, out=np.zeros_like(q[:count]), where=sizes > 0)
    return np.asarray(found.max(axis=1, initial=0.0))
