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

from ....algebra import Array
from ....results import Assembly
from ....system import System
from ...equations.length import extent, row_sizes, units
from ...position.assembly_derivatives import AssemblyDerivatives
from .parameters import Parameters

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
    q_dot, v_dot = assembly.unchecked_along(b, dq=q, dv=v, dc=c)
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
    speed, change = (np.linalg.norm(x / unit, axis=0) for x in (start.v[:, None], v_dot))
    if not asked.rates or not speed[0] > 0:
        return
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
