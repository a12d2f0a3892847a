"""Check whether a run starts near a singular assembly, and the number of digits of its derivatives there.

Near a dead centre of what is held the assembled position is like the root of its distance: it has derivatives, but
they describe small changes only, and round-off is divided by the distance. Along a direction let q' and q'' be the
derivatives of the assembled position. The motion |q'|²/|q''|, over which q' changes by as much as it is, has the size
of the mechanism elsewhere and vanishes in a singular assembly, whatever the direction and its length. Displacements
are compared with rotations by the length of the system, so that units do not matter. Velocities that follow from given
rates are like the inverse of the distance: there the motion is |v|²/|a|, with accelerations at constant rates.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array

from ....algebra import Array
from ....linalg.rank import rank_of, row_lengths
from ....model.announcement import announce
from ....model.errors import listed
from ....results import Assembly, AssemblyRequest, Segments, StepsTaken
from ....results.motion.steps import segments_of
from ....system import System
from ...equations.length import extent, lever, row_sizes, scaled, units
from ...position.assembly_derivatives import AssemblyDerivatives, NoDerivative
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
    J = scaled(J, lever(system, q, J))
    return _by_numbers(system, b, t, q, _sums(rank_of(J).null) / row_lengths(J)[:, None])


def _of_held(system: System, b: Array, q: Array, asked: AssemblyRequest) -> tuple[Array, Array]:
    """Sums of nᵀΦ_b, and by the coordinates held, for the n that vanish in those that were free to be assembled.

    Where a held crank is at a dead centre, the others cannot follow a change.
    """
    t, held = asked.t, np.flatnonzero(asked.held_positions)
    system = system.holonomic  # others do not restrict positions
    J = system.Phi_q(q, t, b=b)
    free = scaled(J, lever(system, q, J))[:, np.flatnonzero(~asked.held_positions)]
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


NEAR = 0.02  # motion over the size of the mechanism [m/m, rad/2], below which there is a warning
VISIBLE = 0.1  # relative change of parameters: derivatives that describe one of this size are of use
OPENED = 1e-3  # violation of the linearized constraints, relative: some of them were taken for dependent ones
DIRECTIONS = 3  # random relative changes of all parameters: a single one might miss the singularity
EPS = float(np.finfo(float).eps)


def singular_start(
    parameters: Parameters, start: Assembly, assembly: AssemblyDerivatives, missing: Array | None = None
) -> Iterator[str]:
    """Yield a warning where parameters, but for those without a derivative, change a start near a singular assembly."""
    system, asked, sizes = parameters.system, start.asked, _sizes(parameters)
    if asked is None or start.settled or not len(sizes):
        return
    sizes = sizes if missing is None else np.where(missing, 0.0, sizes)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(len(sizes), DIRECTIONS))
    b, q, v, c = parameters.along(sizes[:, None] * signs)
    moved = assembly.closes(b, q)
    unit = units(system.nq, extent(system, start.q))[:, None]
    q_dot = assembly.position_along(b, q)
    if np.any(asked.held_positions) and np.any(moved & (assembly.gaps(b, q, q_dot) > OPENED)):
        yield (
            f"{system.name}: the start is so close to a dead centre of the given coordinates that derivatives by what "
            "moves it have no correct digit. Start farther away from it, and check the moments of inertia."
        )
        return
    whole = np.linalg.norm(q_dot / unit, axis=0)
    curved = np.linalg.norm(assembly.bend(q_dot) / unit, axis=0)
    near = moved & (whole**2 < NEAR * curved) & (whole < VISIBLE * curved)
    if np.any(near):
        worst = np.min(whole[near] ** 2 / curved[near]), np.min(whole[near] / curved[near])
        remedy, off = "Start farther away from it", _round_off(system, start, asked.t)
        yield _message(system, "a dead centre of the given coordinates", *worst, remedy, off)
    if not asked.rates or not start.v.any():
        return
    v_dot = assembly.unchecked_along(b, dq=q, dv=v, dc=c)[1]
    speed, change = (np.linalg.norm(x / unit, axis=0) for x in (start.v[:, None], v_dot))
    motion = speed[0] ** 2 / max(float(np.linalg.norm(assembly.bend_of_motion() / unit[:, 0])), 1e-300)
    share = speed[0] / max(float(change.max()), 1e-300)
    if motion < NEAR and share < VISIBLE:
        where = f"a position in which {', '.join(asked.rates)} cannot be given"
        yield _message(system, where, motion, share, "Give another rate, or start farther away from it")


def _sizes(parameters: Parameters) -> Array:
    """Return the sizes of the parameters; for vectors that of the largest component."""
    stems = [
        name.rpartition(".")[0] if name[-2:] in (".x", ".y", ".z") else name for name in parameters.names
    ]
    largest: dict[str, float] = {}
    for stem, value in zip(stems, parameters.values, strict=True):
        largest[stem] = max(largest.get(stem, 0.0), abs(float(value)))
    return np.array([largest[stem] for stem in stems])


def _round_off(system: System, start: Assembly, t: float) -> float:
    """Return the error of the assembled position over the size of the mechanism, by what the constraints are off."""
    own, length = system.with_memory(start.memory), extent(system, start.q)
    off = own.Phi(start.q, t) / row_sizes(own.Phi_q(start.q, t), length)
    return max(float(abs(off).max(initial=0.0)), EPS)


def _message(system: System, where: str, motion: float, share: float, remedy: str, off: float = EPS) -> str:
    """`off` is the error of the assembled position over the size of the mechanism."""
    digits = max(int(-np.log10(off / min(motion, 1.0) ** 2)), 0) if motion > 0 else 0
    few = f"about {digits} digits" if digits else "no correct digit"
    return (
        f"{system.name}: the start is close to {where}: derivatives have {few}, and are valid only for "
        f"relative changes of parameters below {share:.0e}. {remedy}."
    )
