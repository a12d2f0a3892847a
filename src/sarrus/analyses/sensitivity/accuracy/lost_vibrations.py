"""Vibrations that the start of a stretch excites, and that the steps of the run do not resolve: errors of responses.

A stiff method damps such a vibration within some steps, and with it the adjoint, which therefore does not show that it
is missing. With little damping, the true motion still contains it at the times of a response.

The third derivative of the states u = (q, v) separates the vibration from the motion that excites it: a mode λ with the
amplitude u_λ contributes λ³ u_λ to it, and the smooth motion little. The mode has the error u_λ e^(λ t) times the
relative error by the stability function of the method, see `UnresolvedModes`. As bodies turn, modes are compared with
gradients of responses body by body, by their lengths: the phase and the sign of the error remain unknown. Steps after
the stretch do not count: there may be another vibration, as after a contact.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ....results.motion.steps import first_of
from ....system import System
from ..chain.chain import Chain, Nodes
from ..events.chains import AnyChain
from ..sampling.settled import settled
from .unresolved_modes import UnresolvedModes

PART = 0.01  # of the first step: distance of states for differences
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
        modes = lost_modes(own, own.steps.t)
        if modes is not None:
            squares += sizes(modes, own.system, t[first:], given.part(slice(first, None))) ** 2
    return np.asarray(np.sqrt(squares))


def lost_modes(chain: Chain, t: Array) -> UnresolvedModes | None:
    """Those that the start excites, of a stretch with these nodes, and a chain of its first step at least."""
    if not len(chain.steps):
        return None
    third, precise = _third(chain.system, chain.steps), chain.steps.precise
    modes = UnresolvedModes.excited(chain.start, third, chain.curves.width, t, precise, order=3, least=SEEN)
    errors = np.where(modes.errors > SEEN, modes.errors, 0.0)
    return modes._replace(errors=errors) if errors.any() else None


def sizes(modes: UnresolvedModes, system: System, t: Array, given: Nodes) -> Array:
    """The size of their errors of responses (k,) by a part of a run, whose nodes are at these times."""
    return np.asarray(np.linalg.norm(modes.sizes(_vectors(system), t, given), axis=0))


def _third(system: System, steps: StepsTaken) -> Array:
    """The third derivative of q and v (2 nq,) at the first node of some steps.

    It is that of the accelerations along a cubic with the same derivatives at this node, up to v''.
    """
    first, until = first_of(steps, 1), 3 * PART * (steps.t[1] - steps.t[0])
    t = np.linspace(steps.t[0], steps.t[0] + until, 4)
    a, rate = steps.a[:1], np.zeros(system.nq)
    for _ in range(2):
        v = first.v[0] + until * (a[0] + until / 2 * rate)
        q = first.q[0] + until * (first.v[0] + until / 2 * (a[0] + until / 3 * rate))
        q, v, own = (np.stack(x) for x in ((first.q[0], q), (first.v[0], v), (a[0], a[0] + until * rate)))
        cubic = replace(first, t=t[[0, -1]], h=np.diff(t[[0, -1]]), q=q, v=v, a=own)
        a = settled(system, cubic, t, shortest=False).a
        rate = RATE @ a / (until / 3)
    return np.concatenate([rate, SECOND @ a / (until / 3) ** 2])


def _vectors(system: System) -> dict[str, list[Array]]:
    """Places of displacements and rotations of each body, and of the multipliers of each joint."""
    every = np.arange(system.nq).reshape(-1, 7)
    bodies = [part for own in every for part in (own[:3], own[3:])]
    return dict.fromkeys(("q", "v", "a"), bodies) | {"lam": [*system.rows.values()]}
