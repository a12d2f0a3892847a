"""Messages for runs that cannot continue: values that are not finite, dependent equations, and the remedy."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....algebra import Array
from ....elements import OPERATORS, Element
from ....elements.evaluation import dense, element_from
from ....elements.forces.gravity import EccentricGravity, Gravity
from ....linalg.rank import rank_of
from ....system import System
from ....system.structure.population import GROUND, local
from ...equations.nullspace import missing_inertia
from ...equations.states_at_rest import places
from ...redundancy.redundant_constraints import Independence, named_rows
from .stepper import RunFailure

NEARLY = 0.05  # of the smallest singular value of Φ_q at the start: below it the rows are called dependent
CLOSE = 0.3  # the same where a step failed for another reason, which is reported first
LOST = 1e-8  # the same: dependent to round-off
WEAK = 0.1  # over n² for n bodies: smallest singular value of Φ_q, rows at unit length, that is nearly zero (chains: 2)
STEEP = 1e20  # [N/m] of a law beyond all bounds, or a force without direction: roots are protected by 1e-30 m
TINY = 1e-300
AHEAD = (0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1e-2)  # of the whole time: where a force is tried


def has_laws(system: System) -> bool:
    """Whether there are forces other than weight: only these may be stiff or have corners."""
    weight = (Gravity, EccentricGravity)
    return any(p.count and p.is_force and p.kind not in weight for p in system.populations)


def not_finite(system: System, b: Array, t: float, q: Array, v: Array) -> list[str]:
    """The forces that are not finite at a state, by the names that a model gives them."""
    if np.all(np.isfinite(system.Q(q, v, t, b=b))):
        return []
    return _beyond(np.finfo(float).max, "Q", system, b, t, q, v)


def _beyond(limit: float, operator: str, system: System, b: Array, t: float, q: Array, v: Array) -> list[str]:
    """The forces, by name, whose result of an operator at a state has entries beyond a limit, or no numbers."""
    found, rest = list[str](), np.zeros_like(GROUND)
    for p in filter(lambda p: p.is_force, system.populations):
        for k, owner in enumerate(p.owners):
            at = p.at + k * p.kind.size()
            element = element_from(p.kind, b[at : at + p.kind.size()], b)
            operands = {"q": local(p, k, q, GROUND), "v": local(p, k, v, rest), "t": t}
            if not _largest(element, operator, operands) <= limit:
                found.append(owner)
    return found


def _rates_of_states(system: System, b: Array, t: float, q: Array, v: Array) -> Array:
    """Rates of first-order states, in the places of their accelerations; zero for bodies (nq,)."""
    found, own = np.zeros(system.nq), places(system)
    found[own] = (system.Q(q, v, t, b=b) / np.maximum(system.M(q, b=b).diagonal(), TINY))[own]
    return found


def _largest(element: Element, operator: str, operands: dict[str, Any]) -> float:
    """The largest entry of a result, evaluated in plain Python, where a root of a negative number is an error."""
    try:
        with np.errstate(all="ignore"):
            entries = np.asarray(dense(element, OPERATORS[operator], operands), dtype=float)
            return float(abs(entries).max(initial=0.0))
    except (ValueError, ZeroDivisionError, OverflowError):
        return np.inf


def redundant_rows(
    system: System, q: Array, t: float, first: Independence, nearly: float = NEARLY
) -> list[str]:
    """Equations that (nearly) depend on each other at a position, besides those that do at the start.

    `nearly` is the smallest singular value, in parts of that at the start, below which they do.
    Those of joints and drivers; normalizations, which take part where a body rotates, only if there are no others.
    """
    if not np.all(np.isfinite(q)):
        return []
    J, limit = first.scaled_Phi_q(q, t), nearly * min(first.smallest, 1.0)
    null = rank_of(J, limit).null
    if null.shape[1] <= first.known:
        return []
    size = abs(null).max(axis=1)
    if first.rows is not None and (others := rank_of(J[first.rows], limit).null).size:
        size[:] = 0.0  # without the equations that are redundant everywhere
        size[first.rows] = abs(others).max(axis=1)
    return [system.row_names[n] for n in named_rows(system, size)][:6]


def failure_of(
    system: System,
    b: Array,
    t: float,
    q: Array,
    v: Array,
    first: Independence,
    span: float,
    otherwise: RunFailure,
) -> RunFailure:
    """Why there are no further steps from a state: a force that is not finite, a singular configuration, or else.

    `first` is the choice of independent equations at the start, `span` the time that was still to go.
    """
    later = _rates_of_states(system, b, t, q, v)
    for share in AHEAD:
        names = not_finite(system, b, t + share * span, q + share * span * v, v + share * span * later)
        if names:
            return RunFailure(
                "not finite",
                f"the force {', '.join(names[:3])} is not a finite number at t = {t + share * span:.6g} s. Look for a "
                "root or logarithm of what may become negative there, or a division by zero.",
            )
    if jumping := _jumping_rows(system, b, t, q, v, first, span):
        return RunFailure(
            "inconsistent",
            f"the equation of {jumping[0]} jumps near t = {t:.6g} s, as a formula does at the branch cut of atan2. "
            "Write it without a jump, or end the run before.",
        )
    rows, lacking = redundant_rows(system, q, t, first), missing_inertia(system, q, t, b)
    if lacking and len(redundant_rows(system, q, t, first, LOST)) == 0:
        return RunFailure("missing inertia", f"accelerations are not determined at t = {t:.6g} s. {lacking}")
    if rows:
        return singular(t, rows)
    steep = _beyond(STEEP, "Q_q", system, b, t, q, v)
    if steep:
        return RunFailure(
            "step too small",
            f"steps become too small near t = {t:.6g} s: the stiffness of the force {', '.join(steep[:3])} grows "
            "beyond all bounds there. Bound its law, or keep apart the points between which it acts: where they "
            "coincide, its direction is not determined.",
        )
    weak = WEAK / len(system.bodies) ** 2
    if first.smallest < weak:
        return _weak_start(t, first.smallest, redundant_rows(system, q, t, first, 2.0))
    return _with_weak_rows(otherwise, redundant_rows(system, q, t, first, CLOSE))


def _jumping_rows(
    system: System, b: Array, t: float, q: Array, v: Array, first: Independence, span: float
) -> list[str]:
    """Parts whose equations jump shortly ahead: bisection of the time leaves half of their greatest change, or more."""
    least = LOST * first.row_lengths(q, t)
    for ahead in [share * span for share in AHEAD[1:] if system.m]:
        begin, end = 0.0, ahead
        low, high = system.Phi(q, t, b=b), system.Phi(q + end * v, t + end, b=b)
        row = int(np.argmax(abs(high - low) / np.maximum(least, TINY)))
        half = max(abs(high[row] - low[row]) / 2, least[row])
        for _ in range(np.finfo(float).nmant):  # to round-off: what still changes by half of the whole jumps
            middle = (begin + end) / 2
            value = system.Phi(q + middle * v, t + middle, b=b)
            if abs(value[row] - low[row]) > abs(high[row] - value[row]):
                end, high = middle, value
            else:
                begin, low = middle, value
        if abs(high[row] - low[row]) > half:
            return [system.row_names[row].split(": ")[0]]
    return []


def _with_weak_rows(error: RunFailure, rows: list[str]) -> RunFailure:
    """The same error, and the constraints that come close to being dependent."""
    if not rows:
        return error
    message = (
        f"{error.message.removesuffix('.')}. Constraints are not far from being dependent there, as in a singular "
        f"configuration, among {', '.join(rows)}."
    )
    return RunFailure(error.status, message)


def _weak_start(t: float, smallest: float, rows: list[str]) -> RunFailure:
    """The message of a run from a position whose constraints are almost dependent."""
    among = f", among {', '.join(rows)}" if rows else ""
    return RunFailure(
        "singular configuration",
        f"steps become too small near t = {t:.6g} s: the start is nearly singular. The smallest singular value of its "
        f"constraints is {smallest:.1e}{among}. Start farther away from this position, or leave out a constraint.",
    )


def singular(t: float, rows: list[str]) -> RunFailure:
    """The message of a singular configuration."""
    among = f" among {', '.join(rows)}" if rows else ""
    return RunFailure(
        "singular configuration",
        f"the constraints become dependent near t = {t:.6g} s{among}: the mechanism locks there, or can go on in "
        "several ways. Change the start or the dimensions, add a force that decides, or let `singularities` show where "
        "it happens.",
    )
