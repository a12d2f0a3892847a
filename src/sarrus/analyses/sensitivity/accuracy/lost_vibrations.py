"""Vibrations that the start of a stretch excites, and that the steps of the run do not resolve: errors of responses.

A stiff method damps such a vibration within some steps, and with it the adjoint, which therefore does not show that it
is missing. With little damping, the true motion still contains it at the times of a response.

The third derivative of the states u = (q, v) separates the vibration from the motion that excites it: a mode λ with the
amplitude u_λ contributes λ³ u_λ to it, and the smooth motion little. The mode has the error u_λ e^(λ t) times the
relative error by the stability function of the method, see `UnresolvedModes`. As bodies turn, modes are compared with
gradients of responses body by body, by their lengths: the phase and the sign of the error remain unknown. Steps after
the stretch do not count: there may be another vibration, as after a contact. Where the stiffness of the start is gone,
as that of a field that a mass leaves, steps may be long: frequencies follow the stiffness along the run.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np

from ....algebra import Array
from ....linalg.factors import SingularSystem
from ....results import StepsTaken
from ....results.motion.steps import first_of, part_of
from ....system import System
from ..chain.chain import Chain, Nodes
from ..chain.start import Start
from ..events.chains import AnyChain
from ..sampling.settled import settled
from .fast_motions import fast_motions
from .unresolved_modes import DRAWN, UnresolvedModes, relative_errors, slowest

PART, BEGIN = 0.01, 20  # of the longest of so many first steps: distance of states for differences
LOOKED_AT = 40  # nodes of a stretch whose stiffness is compared with that of the start
TINY = 1e-6  # share of a frequency that counts as none
SEEN = 0.1  # relative error of a mode up to which the adjoint shows it, with its sign
# Weights of the first four states in the first and the second derivative at the first one, exact for cubics
RATE = np.array([-11.0, 18.0, -9.0, 2.0]) / 6
SECOND = np.array([2.0, -5.0, 4.0, -1.0])


def lost_vibrations(chain: AnyChain, given: Nodes) -> Array:
    """The size of errors of responses (k,) with these gradients by states."""
    chains = [chain] if isinstance(chain, Chain) else chain.chains
    starts = [0] if isinstance(chain, Chain) else [part.start for part in chain.parts]
    squares, t = np.zeros(given.q.shape[2]), chain.steps.t
    for own, first in zip(chains, starts, strict=True):
        modes = lost_modes(own, own.steps.t, some(own.steps))
        if modes is not None:
            squares += sizes(modes, own.system, t[first:], given.part(slice(first, None))) ** 2
    return np.asarray(np.sqrt(squares))


def lost_modes(chain: Chain, t: Array, later: Iterable[StepsTaken]) -> UnresolvedModes | None:
    """Those that the start excites, of a stretch with these nodes, with a chain of its first step, and later steps."""
    system, steps, precise = chain.system, chain.steps, chain.steps.precise
    if not (len(steps) and fast_motions(chain.start, slowest(t, precise, SEEN))):
        return None
    third = _free(system, chain.start, steps, _third(system, steps, PART * np.diff(t)[:BEGIN].max()))
    modes = UnresolvedModes.excited(chain.start, third, t, precise, order=3, least=SEEN)
    if not len(modes.values):
        return None
    h = np.diff(t) * _frequencies(chain, third[chain.system.nq :], t, later)
    errors = relative_errors(np.outer(h, modes.values.imag), precise)
    errors = np.where(errors > SEEN, errors, 0.0)
    return modes._replace(errors=errors) if errors.any() else None


def sizes(modes: UnresolvedModes, system: System, t: Array, given: Nodes) -> Array:
    """The size of their errors of responses (k,) by a part of a run, whose nodes are at these times."""
    return np.asarray(np.linalg.norm(modes.sizes(_vectors(system), t, given), axis=0))


def some(steps: StepsTaken, count: int = LOOKED_AT) -> Iterator[StepsTaken]:
    """Some of these steps, each with the state at its begin."""
    chosen = np.linspace(0, len(steps) - 1, count).astype(int) if len(steps) else np.zeros(0, dtype=int)
    return (part_of(steps, int(n), 1) for n in np.unique(chosen))


def _frequencies(chain: Chain, x: Array, t: Array, later: Iterable[StepsTaken]) -> Array:
    """In each step between some nodes, frequencies over those at the start, at most one.

    By accelerations that displacements as large as x cause, in random directions as bodies turn.
    """
    system, random = chain.system, np.random.default_rng(4)
    changes = random.standard_normal((system.nq, DRAWN))
    for own in _vectors(system)["q"]:
        changes[own] *= np.linalg.norm(x[own]) / np.linalg.norm(changes[own], axis=0)
    none = np.zeros((chain.start.width, DRAWN))

    def caused(start: Start) -> float:
        return float(np.linalg.norm(start.along(changes, 0 * changes, none)[0]))

    first, shares, times = caused(chain.start), [0.0], [t[0]]
    for one in later if first > 0.0 else ():
        with suppress(SingularSystem):
            stiffness = caused(Start(system, one, chain.by_curves, by_numbers=False)) / first
            shares.append(np.log(min(max(np.sqrt(stiffness), TINY), 1.0)))
            times.append(one.t[0])
    return np.exp(np.interp(t[:-1], times, shares))


def _free(system: System, start: Start, steps: StepsTaken, x: Array) -> Array:
    """The part of x (2 nq,), of q and of v, that the constraints allow at the first node: the rest is prescribed."""
    columns = x.reshape(2, -1).T
    normal = start.adjoint(0.0 * columns, system.Phi_q(steps.q[0], float(steps.t[0]), b=steps.b) @ columns)[0]
    return np.asarray((columns - normal).T.ravel())


def _third(system: System, steps: StepsTaken, part: float) -> Array:
    """The third derivative of q and v (2 nq,) at the first node of some steps, by states at this distance.

    Steps may begin much shorter than the motion asks for: at their distances, differences would be round-off. It is
    that of the accelerations along a cubic with the same derivatives at this node, up to v''.
    """
    first, until = first_of(steps, 1), 3 * part
    t = np.linspace(steps.t[0], steps.t[0] + until, 4)
    a, rate = steps.a[:1], np.zeros(system.nq)
    for _ in range(2):
        v = first.v[0] + until * (a[0] + until / 2 * rate)
        q = first.q[0] + until * (first.v[0] + until / 2 * (a[0] + until / 3 * rate))
        q, v, own = (np.stack(x) for x in ((first.q[0], q), (first.v[0], v), (a[0], a[0] + until * rate)))
        cubic = replace(first, t=t[[0, -1]], h=np.diff(t[[0, -1]]), q=q, v=v, a=own)
        a = settled(system, cubic, t, shortest=False, like=steps).a
        rate = RATE @ a / (until / 3)
    return np.concatenate([rate, SECOND @ a / (until / 3) ** 2])


def _vectors(system: System) -> dict[str, list[Array]]:
    """Places of displacements and rotations of each body, and of the multipliers of each joint."""
    every = np.arange(system.nq).reshape(-1, 7)
    bodies = [part for own in every for part in (own[:3], own[3:])]
    return dict.fromkeys(("q", "v", "a"), bodies) | {"lam": [*system.rows.values()]}
