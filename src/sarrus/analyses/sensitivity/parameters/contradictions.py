"""Parameters without a derivative: their change alone contradicts redundant constraints, or what an assembly holds."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from ....algebra import Array
from ....linalg.rank import rank_of, row_lengths
from ....model.announcement import announce
from ....model.errors import listed
from ....results import AssemblyRequest, Segments, StepsTaken
from ....results.motion.steps import segments_of
from ....system import System
from ...equations.length import scaled, units
from ...position.assembly_derivatives import NoDerivative
from ..chain.chain import Gradients
from .parameters import Parameters

# Smallest sum of contradictions, of equations scaled to unit gradients, for a change by one unit [m, rad]
CONTRADICTED = 1e-6
# Singular value of the equations in coordinates that are free in assembly, below which there are no derivatives:
# round-off of the assembled position, over its square, is their relative error
UNRESOLVED = 1e-7
SUMS = 3  # random sums of vanishing combinations that are looked at in one position


def undefined(system: System, steps: StepsTaken | Segments, parameters: Parameters) -> Array:
    """True for parameters whose change alone contradicts dependent equations at the start, halfway or at the end."""
    missing, stuck = _missing(system, steps, parameters)
    if np.any(stuck & ~missing):
        announce([_cannot_follow(system, parameters, stuck & ~missing)])
    return missing | stuck


def _missing(system: System, steps: StepsTaken | Segments, parameters: Parameters) -> tuple[Array, Array]:
    """Parameters that contradict dependent equations, and those that what is held in the assembly cannot follow."""
    segments = segments_of(steps)
    sums = [
        (contradictions(system, steps.b, segment.t[n], segment.q[n]), np.zeros((system.nq, SUMS)))
        for segment in segments
        if len(segment.left_out)
        for n in (0, len(segment) // 2, len(segment))
    ]
    asked = segments[0].start.asked
    missing, stuck = np.zeros((2, len(parameters.names)), dtype=bool)
    if sums:
        missing = contradicted(parameters, *(np.concatenate(x, axis=1) for x in zip(*sums, strict=True)))
    if asked is not None and np.any(asked.held_positions):
        stuck = contradicted(parameters, *_of_held(system, steps.b, segments[0].start.q, asked))
    return missing, stuck


def contradicted(parameters: Parameters, by_b: Array, by_q: Array) -> Array:
    """Whether each parameter changes sums with these gradients by the numbers and the guess."""
    by_v, by_c = np.zeros_like(by_q), np.zeros((parameters.c_size, by_q.shape[1]))
    found = abs(parameters.gradient(Gradients(by_b, by_q, by_v), by_c)).max(axis=1, initial=0.0)
    return np.asarray(found > CONTRADICTED)


def _cannot_follow(system: System, parameters: Parameters, stuck: Array) -> str:
    names = [name for name, own in zip(parameters.names, stuck, strict=True) if own]
    return (
        f"{system.name}: what is held in the assembly of the start cannot follow a change of {listed(names)}, "
        "as in a dead centre: these derivatives do not exist. Hold less, or start farther away."
    )


def refuse(system: System, steps: StepsTaken | Segments, parameters: Parameters) -> None:
    """Refuse parameters without a derivative.

    Raises
    ------
    NoDerivative
    """
    missing, stuck = _missing(system, steps, parameters)
    if np.any(stuck & ~missing):
        raise NoDerivative(_cannot_follow(system, parameters, stuck & ~missing))
    if np.any(missing):
        name = parameters.names[int(np.argmax(missing))]
        raise NoDerivative(
            f"{system.name}: a change of {name} alone contradicts equations that repeat others. Change together what "
            "keeps them consistent, by a formula."
        )


def contradictions(system: System, b: Array, t: float, q: Array) -> Array:
    """Random sums of nᵀΦ_b (len(b), SUMS)."""
    J = system.Phi_q(q, t, b=b)
    J = scaled(J, units(system, q, J))
    return _by_numbers(system, b, t, q, _sums(rank_of(J).null) / row_lengths(J)[:, None])


def _of_held(system: System, b: Array, q: Array, asked: AssemblyRequest) -> tuple[Array, Array]:
    """Sums of nᵀΦ_b, and by the coordinates held, for the n that vanish in those that were free to be assembled.

    Where a held crank is at a dead centre, the others cannot follow a change.
    """
    t, held = asked.t, np.flatnonzero(asked.held_positions)
    system = system.holonomic  # others do not restrict positions
    J = system.Phi_q(q, t, b=b)
    free = scaled(J, units(system, q, J))[:, np.flatnonzero(~asked.held_positions)]
    n = _sums(rank_of(csr_array(free), UNRESOLVED).null) / row_lengths(csr_array(free))[:, None]
    by_q = np.zeros((system.nq, SUMS))
    by_q[held] = J[:, held].T @ n
    return _by_numbers(system, b, t, q, n), by_q


def _sums(null: Array) -> Array:
    return np.asarray(null @ np.random.default_rng(0).normal(size=(null.shape[1], SUMS)))


def _by_numbers(system: System, b: Array, t: float, q: Array, n: Array) -> Array:
    by_b = np.zeros((len(b), SUMS))
    by_b[: system.nb] = system.Phi_b(q, t, b=b).T @ n
    return by_b
