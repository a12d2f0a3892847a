"""Oscillations that parameters start, and steps are too long for: derivatives of parts at rest.

With derivatives u' of the states u = (q, v), whose rates w = (v', a') are known at the start, the linearized motion is
w(t) = e^(A t) w(0). The Krylov space of A and w(0) contains the modes that the parameters excite. A mode λ = σ + iω
with the amplitude w_λ changes u' by e^(λ t) w_λ / λ, but the computed derivatives by R(iωh)/e^(iωh) as much in each
step, with the stability function R of the method. The error is at most

    e^(σ t) w_λ / λ min(1, Σ |R(iωh)/e^(iωh) - 1|),    with √2 instead of 1 if R keeps the amplitude.

Modes that are damped in the motion itself, or resolved by the steps, contribute nothing. They are those of the start.
A law over time that begins with the rate g of accelerations, as A sin(ωt), or changes it by g in a corner, excites
modes with the amplitude g_λ / λ².
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....linalg.factors import SingularSystem
from ...dynamics.inputs.features import features
from ..chain.chain import STATES, Chain, Nodes
from ..chain.start import Start
from .fast_motions import fast_changes

MODES = 40  # dimension of the Krylov space, at most
INVARIANT = 1e-10  # remainder of a new direction over its length from which on the space contains it
# Imaginary part of an eigenvalue over its size, at least: double real ones are split by round-off
OSCILLATING = 1e-3
# Relative error: of a mode that is out of phase, and of one that is damped away
MOST = {False: np.sqrt(2.0), True: 1.0}
AHEAD = 1e-4  # of a step: distance of two times that give how fast laws begin to act
DRAWN = 4  # random changes that are looked at together
# Of these: the square of their sum is about the sum of squares
SIGNS = np.random.default_rng(3).choice([-1.0, 1.0], DRAWN)
# Order and inverse factor of the relative error of a mode by a step, |R(iy)/e^(iy) - 1| = y^order / factor for small y
LOCAL = {False: (3, 12.0), True: (6, 7200.0)}
MARGIN = 3.0  # modes that are hidden behind slower ones have errors below 1e-4 of these
CORNERS = 8  # of laws over time, in which modes are looked at, at most
UNRESOLVED = 1e-4  # least relative error of a mode by which it counts


class UnresolvedModes(NamedTuple):
    """Oscillations that a change of the parameters excites at the start of a run, and that its steps do not resolve.

    Attributes
    ----------
    values : (r,) eigenvalues [1/s]
    states : (size, r) amplitudes of q, v, a and λ
    t : (n,) times of the nodes [s]
    errors : (n, r) relative errors at these times, without those by damping
    """

    values: Array
    states: Sequence[Array]
    t: Array
    errors: Array

    @classmethod
    def of(
        cls, chain: Chain, directions: Sequence[Array], t: Array, precise: bool, hidden: bool
    ) -> Iterator[list[UnresolvedModes]]:
        """Those by each of some changes of the parameters, see `Chain.along`, in a run with these nodes.

        Those that laws over time excite by all changes together are with the first one: where they begin, and of laws
        that are `hidden` in the motion in corners, too. A mechanism that is stuck, without accelerations by changes of
        the parameters, has none.
        """
        db, dq, dv, dc = directions
        q, v = chain.assembly.unchecked_along(db, dq=dq, dv=dv, dc=dc)
        try:
            a = chain.start.along(q, v, db)[0]
        except SingularSystem:
            return
        for n, w in enumerate(np.concatenate([v, a]).T):
            found = [cls.excited(chain.start, w, t, precise)]
            if n == 0 and chain.curves.moved_by(db):
                together = np.sum(db * SIGNS[: db.shape[1]], axis=1, keepdims=True)
                found += cls._by_laws(chain, together, t, precise, CORNERS if hidden else 0)
            yield found

    @classmethod
    def _by_laws(
        cls, chain: Chain, db: Array, t: Array, precise: bool, most: int
    ) -> Iterator[UnresolvedModes]:
        """Those by one change of laws over time, where these begin and in some corners; modes of the start."""
        none, ahead = np.zeros((chain.system.nq, 1)), AHEAD * float(np.median(np.diff(t)))

        def caused(*times: float) -> Iterator[Array]:
            """Accelerations by the change at these times."""
            for at in times:
                start = Start(chain.system, replace(chain.steps, t=at + 0.0 * chain.steps.t), chain.by_curves)
                yield start.along(none, none, db)[0][:, 0]

        corners = features(chain.system, float(t[0]), float(t[-1])).corners if most else t[:0]
        for at in (float(t[0]), *corners[(corners > t[0]) & (corners < t[-1])][:most].tolist()):
            value, later = caused(at + ahead, at + 2 * ahead)
            slope, on = (later - value) / ahead, t[max(np.searchsorted(t, at) - 1, 0) :]
            if at > t[0]:
                before, last = caused(at - 2 * ahead, at - ahead)
                value, slope = value - last, slope - (last - before) / ahead
                yield cls.excited(chain.start, np.append(none, value), on, precise)
            yield cls.excited(chain.start, np.append(none, slope), on, precise, 2)

    @classmethod
    def excited(
        cls,
        start: Start,
        w: Array,
        t: Array,
        precise: bool,
        order: int = 1,
        least: float = UNRESOLVED,
    ) -> UnresolvedModes:
        """Those by a change of numbers, or of a motion, whose states have this derivative of an order at the start."""
        none = np.zeros((start.width, 1))
        v, a = np.split(w[:, None], 2)
        fast = fast_changes(start, v, a, none, slowest(t, precise, least), rounds=2)
        space = _Krylov.of(start, w if fast else 0.0 * w, none)
        values, vectors = np.linalg.eig(space.matrix)
        parts = np.linalg.lstsq(vectors, space.size * np.eye(len(values), 1)[:, 0], rcond=None)[0]
        values = np.minimum(values.real, 0.0) + 1j * values.imag
        errors = relative_errors(np.outer(np.diff(t), values.imag), precise)
        left = errors * np.exp(np.outer(t - t[0], values.real))
        counts = (abs(values.imag) > OSCILLATING * abs(values)) & (left > UNRESOLVED).any(axis=0)
        shapes = (vectors * parts)[:, counts] / values[counts] ** order
        return cls(values[counts], [x @ shapes for x in space.states], t, errors[:, counts])

    def part(self, t: Array, given: Nodes) -> Array:
        """Errors of responses (r, k) by modes in a part of a run, whose nodes are at these times."""
        sums = zip(self.states, self._sums(t, given), strict=True)
        return np.asarray(sum(np.einsum("jr,rjk->rk", shapes, own) for shapes, own in sums))

    def sizes(self, vectors: Mapping[str, Sequence[Array]], t: Array, given: Nodes) -> Array:
        """The same in whatever direction some vectors point, whose components have these places (r, k)."""
        found = np.zeros((len(self.values), given.q.shape[-1]))
        for name, shapes, sums in zip(STATES, self.states, self._sums(t, given), strict=True):
            for own in vectors[name]:
                by = np.linalg.norm(sums[:, own], axis=1)
                found += np.linalg.norm(shapes[own], axis=0)[:, None] * by
        return found

    def _sums(self, t: Array, given: Nodes) -> Iterator[Array]:
        """Gradients by q, v, a and λ at all nodes, weighted by the errors of modes there (r, nq or m, k)."""
        errors = np.array([np.interp(t, self.t, own) for own in self.errors.T])
        since = np.maximum(t - self.t[0], 0.0)
        weights = errors.reshape(len(self.values), len(t)) * np.exp(np.outer(self.values, since))
        for name in STATES:
            own = getattr(given, name)
            rows = np.flatnonzero(own.any(axis=(1, 2)))
            yield np.tensordot(weights[:, rows], own[rows], axes=(1, 0))


def slowest(t: Array, precise: bool, least: float) -> float:
    """A part of the frequency of the slowest mode with this relative error at the end of a run [rad/s]."""
    (order, factor), h = LOCAL[precise], np.diff(t)
    return float((least * factor / len(h)) ** (1 / order) / (MARGIN * h.max()))


class _Krylov(NamedTuple):
    """A space that contains a vector w and its images by the matrix A of the linearized motion.

    Attributes
    ----------
    states : (size, r) q, v, a and λ of its basis
    matrix : (r, r) A in this basis
    size : length of w, along the first vector
    """

    states: Sequence[Array]
    matrix: Array
    size: float

    @classmethod
    def of(cls, start: Start, w: Array, none: Array) -> _Krylov:
        """By Arnoldi's method with (ω q, v) in units of the system, and ω by accelerations that displacements cause."""
        nq, unit = len(w) // 2, start.units
        x = w[nq:, None] if w[nq:].any() else w[:nq, None]
        caused, along = (float(np.linalg.norm(own / unit)) for own in (start.along(x, 0 * x, none)[0], x))
        scale = np.tile(1 / unit[:, 0], 2)
        scale[:nq] *= np.sqrt(caused / along) if caused > 0 and along > 0 else 1.0
        new, size = scale * w, float(np.linalg.norm(scale * w))
        basis, motion, H = np.zeros((2 * nq, MODES)), list[Array](), np.zeros((MODES, MODES))
        left, whole, r = size, size, 0
        while r < MODES and left > INVARIANT * whole:
            basis[:, r] = new / left
            q, v = np.split(basis[:, r, None] / scale[:, None], 2)
            a, lam = start.along(q, v, none)
            motion.append(np.concatenate([q, v, a, lam])[:, 0])
            new = scale * np.concatenate([v, a])[:, 0]
            r, whole = r + 1, float(np.linalg.norm(new))
            for _ in range(2):
                along_basis = basis[:, :r].T @ new
                H[:r, r - 1] += along_basis
                new = new - basis[:, :r] @ along_basis
            left = float(np.linalg.norm(new))
            if r < MODES:
                H[r, r - 1] = left
        found = np.array(motion).T if r else np.zeros((3 * nq, 0))
        return cls(np.split(found, nq * np.arange(1, 4)), H[:r, :r], size)


def relative_errors(angles: Array, precise: bool) -> Array:
    """Relative errors of modes at all nodes (n + 1, r), with these angles of the vibrations within the steps (n, r)."""
    each = abs(_stability(1j * angles, precise) * np.exp(-1j * angles) - 1.0)
    return np.asarray(np.minimum(np.cumsum(np.concatenate([0.0 * angles[:1], each]), axis=0), MOST[precise]))


def _stability(z: Array, precise: bool) -> Array:
    """The stability function of Radau IIA of order five, or of the trapezoidal rule for methods of order two."""
    if precise:
        return np.asarray((60 + z * (24 + 3 * z)) / (60 - z * (36 - z * (9 - z))))
    return np.asarray((1 + z / 2) / (1 - z / 2))
