"""Formulation of a workspace problem: independent rows, limits, fixed functions, locked idle freedoms.

Idle freedoms: bodies that can spin without moving anything else, as rods between two ball joints; they are locked.

A spin about the body's axis a is locked by a direction b of the body, normal to a, that stays normal to a direction g
of the ground. That holds wherever a is not parallel to g, which is chosen as far from a as the mechanism allows.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from numbers import Real
from typing import Any, Literal

import numpy as np

from .... import elements
from ....algebra import Array
from ....euler import G
from ....linalg.rank import unit_rows
from ....linalg.svd import singular
from ....model import ModelError, SarrusError
from ....model.announcement import announce
from ....model.checks.arguments import in_si
from ....model.coordinates import WIDTH, slice_of
from ....model.expansion.blueprint import Placement, blueprint
from ....model.geometry.rotation import matrix
from ....system import System
from ...equations.nullspace import normalizations
from .arguments import Measure, functions, measures
from .random_positions import Samples
from .rows import PARALLEL, Problem
from .settle import constrained

TURN = 2 * np.pi
WITHOUT_EFFECT = (
    "{}: its limits, {:g} and {:g} rad, allow a full revolution and have no effect. Give degrees as '30 deg'"
)
DEPENDENT = 1e-7  # of a singular value, or of what is left of a unit gradient, that counts as zero
POSITIONS = 3  # random ones, at which the rank of the constraints is found

Limits = Mapping[Any, tuple[float | None, float | None]] | Literal["model"]


def formulate(
    system: System,
    output: Iterable[Any],
    *,
    limits: Limits | None = None,
    fixed: Mapping[Any, float] | None = None,
    inputs: Iterable[Any] = (),
    singular: str = "outputs",
) -> Problem:
    """The problem of a workspace; its constraints are those of the joints, drivers are let go.

    A function whose lowest and highest value are equal keeps it, as if it were fixed.

    Raises
    ------
    SarrusError
        If a name is unknown, a limit is empty, or the outputs cannot move.
    """
    ranges = _mapping("limits", _of_model(system) if limits == "model" else limits)
    kept = _mapping("fixed", fixed)
    groups = {"output": functions(output), "limits": ranges, "fixed": kept, "inputs": functions(inputs)}
    table, (outputs, limited, held, driven) = _table(system, groups)
    bounds = {k: _bounds(table[k], pair) for k, pair in zip(limited, ranges.values(), strict=True)}
    if limits != "model":
        without = [(table[k].name, *pair) for k, pair in bounds.items() if _repeats(table[k], pair)]
        announce([WITHOUT_EFFECT.format(*one) for one in without])
    targets = {
        k: in_si(f"fixed: {table[k].name}", x, table[k].unit)
        for k, x in zip(held, kept.values(), strict=True)
    }
    targets |= {k: low for k, (low, high) in bounds.items() if low == high and k not in targets}
    mistake = next(_mistakes(table, outputs, targets, bounds), None)
    if mistake:
        raise SarrusError(mistake)
    targets = {k: float(value) for k, value in targets.items()}
    free, places = _without_drivers(system), np.array(outputs)
    normal = places if singular == "outputs" else np.array(driven, dtype=int)
    rough = Problem(system, table, places, normal, _size(system), free, targets)
    positions = _random_positions(rough)
    idle = locks(rough, [q / rough.scale for q in positions])
    locked = range(len(table), len(table) + len(idle))
    return replace(
        rough,
        table=[*table, *idle],
        independent=_independent(system, positions, free),
        fixed={**targets, **dict.fromkeys(locked, 0.0)},
        limits={k: pair for k, pair in bounds.items() if k not in targets and _bites(table[k], pair)},
        locked=locked,
        positions=_random_positions(replace(rough, fixed={})) if targets else positions,
        typical=[q / rough.scale for q in positions],
    )


def _random_positions(problem: Problem) -> list[Array]:
    """Some random positions (nq,), at which ranks are found."""
    return [q * problem.scale for q in islice(Samples(problem, seed=7), POSITIONS)]


def _mapping(kind: str, given: Any) -> dict[Any, Any]:
    """Limits or fixed values by function."""
    if given is not None and not isinstance(given, Mapping):
        message = "(lowest, highest)" if kind == "limits" else "value"
        raise TypeError(f"{kind} must be a dict, got {given!r}. Pass {{'q1.angle': {message}}}.")
    return dict(given or {})


def _of_model(system: System) -> dict[str, tuple[float | None, float | None]]:
    """The limits that a robot description gives; none for other models."""
    found = getattr(system.model, "limits", {})
    return {name: (limit.lower, limit.upper) for name, limit in found.items() if limit.lower is not None}


def _table(system: System, groups: Mapping[str, Iterable[Any]]) -> tuple[list[Measure], list[list[int]]]:
    """All measures, each once, and the places of those of each group, in which each is named once."""
    table: list[Measure] = []
    places: list[list[int]] = []
    for kind, group in groups.items():
        places.append([])
        for one in measures(system, group):
            known = [other.measured for other in table]
            place = known.index(one.measured) if one.measured in known else len(table)
            if place in places[-1]:
                raise SarrusError(f"{kind}: {table[place].name} is given twice. Name it once.")
            if place == len(table):
                table.append(_named_apart(one, [other.name for other in table]))
            places[-1].append(place)
    return table, places


def _named_apart(one: Measure, names: list[str]) -> Measure:
    """A measure with a number behind its name if another one has the same: two legs between the same bodies."""
    numbered = (one.name, *(f"{one.name} ({n})" for n in range(2, len(names) + 2)))
    return one._replace(name=next(name for name in numbered if name not in names))


def _bounds(one: Measure, pair: Any) -> tuple[float, float]:
    """Limits of a function as numbers, infinite where there is none; texts have units, ``"30 deg"``.

    Raises
    ------
    SarrusError
        If they are no two numbers, or None, in their order.
    """
    message = f"limits: those of {one.name} must be a pair (lowest, highest) of numbers or None, got {pair!r}"
    try:
        ends = [in_si("One", end, one.unit) for end in ([] if isinstance(pair, str) else pair)]
        low, high = (
            inf if end is None else float(end) for end, inf in zip(ends, (-np.inf, np.inf), strict=True)
        )
    except ModelError as wrong:
        raise SarrusError(f"{message}. {wrong.message}") from None
    except (TypeError, ValueError):
        low = high = np.nan
    if np.isnan([low, high]).any() or low == np.inf or high == -np.inf:
        raise SarrusError(f"{message}. Pass e.g. (-1.0, 1.0) or ('-30 deg', '30 deg').")
    if one.kind == "square" and low <= 0:
        low = -np.inf
    if not low <= high:
        raise SarrusError(f"{one.name}: its limits are {low:g} and {high:g}. Give the lower one first.")
    if one.kind == "angle" and np.isfinite(low) != np.isfinite(high):
        raise SarrusError(
            f"{one.name}: one limit is missing. Give both: an angle repeats after a revolution."
        )
    return low, high


def _mistakes(
    table: list[Measure], outputs: list[int], targets: dict[int, Any], bounds: dict[int, tuple[float, float]]
) -> Iterator[str]:
    """What is wrong with outputs and with values that are kept."""
    if not 1 <= len(outputs) <= 3:
        yield f"output: a workspace has one to three outputs, got {len(outputs)}. Name one to three."
    for k in outputs:
        if table[k].kind == "square":
            yield f"output: the length {table[k].name} can only be limited or fixed. Choose a displacement."
        if k in targets:
            yield f"fixed: {table[k].name} is an output, which must be free. Take it out of fixed, or map another."
    for k, value in targets.items():
        name, (low, high) = table[k].name, bounds.get(k, (-np.inf, np.inf))
        if not isinstance(value, Real) or not np.isfinite(float(value)):
            yield f"fixed: {name} must keep a finite number, got {value!r}. Pass a value."
        elif not low <= float(value) <= high:
            message = f"{name}: is fixed at {value:g}, beyond its limits {low:g} and {high:g}"
            yield f"{message}. Fix it between them."


def _repeats(one: Measure, pair: tuple[float, float]) -> bool:
    """Whether an angle may make more than a whole turn, as if degrees were meant."""
    return one.kind == "angle" and TURN * (1 + 1e-9) < pair[1] - pair[0] < np.inf


def _bites(one: Measure, pair: tuple[float, float]) -> bool:
    """Whether a limit restrains anything: an angle that may make a whole turn is free."""
    if one.kind == "angle" and pair[1] - pair[0] >= TURN * (1 - 1e-12):
        return False
    return bool(np.isfinite(pair).any())


def _without_drivers(system: System) -> Array:
    driven = [system.rows[driver.name] for driver in system.model.drivers]
    return np.setdiff1d(np.arange(system.m), np.concatenate(driven) if driven else np.zeros(0, dtype=int))


def _size(system: System) -> float:
    """The size of a mechanism: how far bodies lie apart, and their joints from their origins. [m]"""
    r = system.q0[system.layout.positions]
    spread = float(np.linalg.norm(r - r.mean(axis=0), axis=1).max(initial=0.0))
    levers = [
        float(np.linalg.norm(value))
        for placed in blueprint(system.model).placed
        if placed.element.rows
        for name, value in zip(placed.element.fields, placed.values, strict=False)
        if name in ("s", "s_i", "s_j")
    ]
    return max([spread, *levers]) or 1.0


def _independent(system: System, positions: list[Array], free: Array) -> Array:
    """Rows of Φ that are independent at some random positions, chosen in the model's order.

    So it is the last joint of a loop, which closes it, whose equations are left out; the remaining ones are then
    independent wherever the mechanism itself is regular.
    """
    if not positions:
        message = "Check what is fixed, and whether the joints fit together"
        raise SarrusError(f"{system.name}: could not be assembled. {message}.")
    first = np.argsort(~normalizations(system)[free], kind="stable")
    jacobians = [unit_rows(system.Phi_q(q)).toarray()[free][first] for q in positions]
    rows = np.max([_new(J) for J in jacobians], axis=0) > DEPENDENT
    return np.asarray(np.sort(free[first[rows]]))


def _new(J: Array) -> Array:
    """Return the part of every unit row that is not in the span of the rows before it."""
    basis, found = np.zeros((0, J.shape[1])), np.zeros(len(J))
    for k, row in enumerate(J):
        rest = row - basis.T @ (basis @ row)
        rest -= basis.T @ (basis @ rest)
        found[k] = np.linalg.norm(rest)
        if found[k] > DEPENDENT:
            basis = np.concatenate([basis, rest[None] / found[k]])
    return found


def locks(problem: Problem, positions: Sequence[Array]) -> list[Measure]:
    """Functions that hold all idle spins when they are fixed at zero; positions are scaled."""
    return [one for body in range(len(problem.system.bodies)) for one in _of_body(problem, positions, body)]


def _of_body(problem: Problem, positions: Sequence[Array], body: int) -> Iterator[Measure]:
    own = slice_of(body)
    found = [_spin(problem.jacobian(q)[:, own], q[own][3:]) for q in positions]
    axes = [axis for axis in found if axis is not None]
    if not axes or len(axes) < len(found) or any(abs(axes[0] @ a) < 1 - PARALLEL for a in axes):
        return
    a = axes[0]
    seen = np.array([matrix(q[own][3:]) @ a for q in positions])
    g = np.linalg.eigh(seen.T @ seen)[1][:, 0]
    b = np.cross(a, matrix(problem.system.q0[own][3:]).T @ g)
    b /= np.linalg.norm(b)
    name = f"{problem.system.bodies[body]} does not spin"
    values = (tuple(g.tolist()), tuple(b.tolist()))
    yield Measure(name, Placement(elements.Dot1, (0, body + 1), values, name, "lock"), "form")


def _spin(J: Array, p: Array) -> Array | None:
    """The axis in the body about which it can turn alone, if there is just one."""
    _, sizes, right = singular(J)
    if np.count_nonzero(sizes > DEPENDENT * sizes[0]) != WIDTH - 1:
        return None
    omega = 2 * G(p) @ right[-1][3:]
    size = float(np.linalg.norm(omega))
    return np.asarray(omega / size) if size > DEPENDENT else None


def refuse_dependent(problem: Problem) -> None:
    """Refuse outputs whose gradients along the free motions are dependent at all of some random positions.

    Raises
    ------
    SarrusError
    """
    slopes = [_slopes(problem, q) for q in problem.typical]
    names = [problem.table[k].name for k in problem.outputs]
    for k, name in enumerate(names):
        if all(np.linalg.norm(U[k]) < DEPENDENT for U in slopes):
            message = f"output: {name} does not change in any motion of {problem.system.name}"
            raise SarrusError(f"{message}. Choose another output.")
    if all(np.count_nonzero(singular(U)[1] > DEPENDENT) < len(names) for U in slopes):
        message = f"output: {', '.join(names[:-1])} and {names[-1]} depend on each other"
        covered = "area" if len(names) == 2 else "volume"
        raise SarrusError(f"{message}, so that they cover no {covered}. Choose fewer or other outputs.")


def _slopes(problem: Problem, q: Array) -> Array:
    """Return the derivatives of the outputs along the free directions, for gradients of length 1."""
    J = problem.jacobian(q)
    rows, _ = constrained(problem)
    Z = singular(J[rows])[2][len(rows) :].T
    U = J[problem.m + problem.outputs]
    lengths = np.linalg.norm(U, axis=1, keepdims=True)
    return np.asarray(U @ Z / np.where(lengths > 0, lengths, 1.0))


def refuse_inputs(problem: Problem, inputs: int, *allowed: int) -> None:
    """Refuse so many inputs, unless that many are allowed, the degrees of freedom first.

    Raises
    ------
    SarrusError
    """
    if inputs not in allowed:
        given = "1 input is" if inputs == 1 else f"{inputs} inputs are"
        message = f"{problem.system.name}: {allowed[0]} degrees of freedom, but {given} given"
        raise SarrusError(f"{message}. Give as many inputs.")
