"""Comparison of every operator of a system with an independent computation, for any model and any user's elements.

The compiled operators are compared with the elements' own formulas in plain NumPy: derivatives with the complex-step
derivative of the operator that they differentiate (exact to round-off), the others as they stand. The quadratic
velocity force is also held against Lagrange's equations: S = ½ (M v)_qᵀ v - (M v)_q v.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..activity import activity, for_seconds
from ..algebra import Array
from ..console import printable
from ..elements import OPERATORS, Operator
from ..elements.evaluation import BODY_OPERANDS, dense, element_from
from ..elements.operators import DERIVATIVES, Axis
from .structure.population import GROUND, Population, local, owners

STEP = 1e-200  # of the complex step: far below round-off, so that its square vanishes
TOLERANCE = 1e-9  # relative to the largest term of the block
ROUND_OFF = 1e-6  # of the largest term of the operator: rows whose terms cancel carry the round-off of others
SHARE = 1e-4  # of the row's largest term: blocks beside much larger ones carry their round-off
# Below it, values times the complex step lose digits or vanish, as those of max(0, x)^1.5 where x is negative
LEAST = np.finfo(float).tiny / STEP / TOLERANCE
NEARBY = 0.03  # how far from the state the size of its terms is taken, since they may cancel there


@dataclass(frozen=True)
class Finding:
    """The largest error of one operator, and where it is."""

    operator: Operator
    independent: str
    entries: int
    error: float
    where: str

    @property
    def ok(self) -> bool:
        return self.error <= TOLERANCE


@dataclass(frozen=True)
class Report:
    """The results for all operators. Prints as a table; true if all agree."""

    system: str
    findings: tuple[Finding, ...]

    @property
    def ok(self) -> bool:
        return all(finding.ok for finding in self.findings)

    def __bool__(self) -> bool:
        return self.ok

    @property
    def verdict(self) -> str:
        """The results in one line."""
        wrong = sum(not f.ok for f in self.findings)
        found = f"{wrong} of them WRONG" if wrong else "all agree"
        return f"{self.system}: {len(self.findings)} operators checked, {found} (tolerance {TOLERANCE:g})"

    def __str__(self) -> str:
        lines = [f"{'operator':<20}{'equation':<22}{'independent':<28}{'entries':>8}{'error':>10}"]
        for f in self.findings:
            mark = "" if f.ok else f"  WRONG at {f.where}"
            name, formula = f.operator.name, f.operator.formula.split(" = ")[0]
            lines.append(f"{name:<20}{formula:<22}{f.independent:<28}{f.entries:>8}{f.error:>10.1e}{mark}")
        return printable("\n".join([*lines, self.verdict]))


def check_derivatives(system: Any, q: Any = None, *, seed: int = 0, progress: Any = None) -> Report:
    """Compare all operators of a system with independent ones.

    Parameters
    ----------
    system : System
    q : (nq,) where to compare; by default near the model's coordinates, off unit Euler parameters
    seed : of the random velocities, directions and multipliers
    progress : called with the name of each operator before it is checked

    Returns
    -------
    Report
    """
    state = random_state(system, q, seed)
    with activity(None if progress else for_seconds("checking derivatives")):
        return Report(system.name, tuple(_findings(system, state, progress)))


def _findings(system: Any, state: dict[str, Any], progress: Any) -> Iterator[Finding]:
    """Compare each operator that the system has."""
    for operator in OPERATORS.values():
        if not any(p.count and operator in p.kind.family for p in system.populations):
            continue
        if progress:
            progress(operator.name)
        found = getattr(system, operator.name)(**{key: state[key] for key in ("q", *operator.operands)})
        found = found.reshape(-1, 1) if operator.is_vector else found.toarray()
        route, formula = _route(operator)
        yield _compare(system, operator, route, found, formula, state)


def random_state(system: Any, q: Any, seed: int) -> dict[str, Any]:
    """Random operands, and coordinates near the model's (or the given ones)."""
    random = np.random.default_rng(seed)
    state: dict[str, Any] = {name: random.normal(size=system.nq) for name in ("xi", "eta", "v", "a")}
    state["lam"], state["t"] = random.normal(size=system.m), 0.25
    state["q"] = system.q0 + 0.05 * random.normal(size=system.nq) if q is None else np.asarray(q, dtype=float)
    return state


PLAIN = "kernel in plain NumPy"
Formula = Callable[[Any, dict[str, Any], Array, Array], Array]


def _route(operator: Operator) -> tuple[str, Formula]:
    if operator.name == "S":
        return "Lagrange, from M", _lagrange
    if operator.name not in DERIVATIVES:
        return PLAIN, lambda *args: _value(operator, *args)
    rule = DERIVATIVES[operator.name]
    along = f" {rule.along}" if rule.along else ""
    return f"complex step of {rule.of}{along}", lambda *args: _complex_step(operator, *args)


def _value(operator: Operator, kind: Any, operands: dict[str, Any], numbers: Array, b: Array) -> Array:
    return dense(element_from(kind, numbers, b, operands["t"]), operator, operands).astype(complex)


def _complex_step(operator: Operator, kind: Any, operands: dict[str, Any], numbers: Array, b: Array) -> Array:
    rule = kind.rules[operator.name]
    vary = np.atleast_1d(numbers if rule.by == "b" else operands[rule.by])
    columns = []
    for n in range(len(vary)):
        moved = vary.astype(complex)
        moved[n] += 1j * STEP
        there = operands if rule.by == "b" else {**operands, rule.by: moved[0] if rule.by == "t" else moved}
        value = _value(OPERATORS[rule.of], kind, there, moved if rule.by == "b" else numbers, b)
        columns.append((value @ operands[rule.along] if rule.along else value).imag / STEP)
    return np.array(columns).T


def _lagrange(kind: Any, operands: dict[str, Any], numbers: Array, b: Array) -> Array:
    v = operands["v"]
    Mv_q = _complex_step(OPERATORS["M_a_q"], kind, {**operands, "a": v}, numbers, b)
    S: Array = 0.5 * Mv_q.T @ v - Mv_q @ v
    return S


def _members(system: Any, operator: Operator) -> Iterator[tuple[Population, int]]:
    for p in system.populations:
        if operator in p.kind.family:
            for k in range(p.count):
                yield p, k


def _compare(
    system: Any, operator: Operator, route: str, found: Array, formula: Formula, state: dict[str, Any]
) -> Finding:
    want, scale = np.zeros(found.shape), np.zeros(found.shape)
    nearby = {**state, "q": state["q"] + NEARBY * state["eta"]}
    for p, k in _members(system, operator):
        size = p.kind.size()
        numbers = system.b[p.at + k * size : p.at + (k + 1) * size]
        value = np.real(formula(p.kind, _operands(p, k, state), numbers, system.b))
        terms = (
            value if route != PLAIN else np.real(formula(p.kind, _operands(p, k, nearby), numbers, system.b))
        )
        rows, columns = _places(operator, p, k)
        value = value.reshape(len(rows), len(columns))[rows >= 0][:, columns >= 0]
        at = np.ix_(rows[rows >= 0], columns[columns >= 0])
        np.add.at(want, at, value)
        np.add.at(
            scale, at, abs(value) + abs(terms.reshape(len(rows), len(columns))[rows >= 0][:, columns >= 0])
        )
    return _finding(system, operator, route, found, want, scale)


def _finding(system: Any, operator: Operator, route: str, found: Array, want: Array, scale: Array) -> Finding:
    error = np.where(np.isfinite(found), abs(found - want) / _size(system, operator, scale), np.inf)
    if not error.size:
        return Finding(operator, route, 0, 0.0, "")
    row, column = np.unravel_index(np.argmax(error), error.shape)
    where = system.axis_names(operator.axes[0])[row]
    if not operator.is_vector:
        where += f", {system.axis_names(operator.axes[1])[column]}"
    return Finding(operator, route, int(np.count_nonzero(scale)), float(error[row, column]), where)


def _size(system: Any, operator: Operator, scale: Array) -> Array:
    """The scale of an error: the largest term of its block, at least a small part of that of its row and of all."""
    row = scale.max(axis=1, keepdims=True, initial=0.0)
    block = scale
    if not operator.is_vector and scale.size:
        for axis, kind in enumerate(operator.axes):
            starts = [*range(scale.shape[axis])] if kind is Axis.ROWS else system.atoms(kind)
            widths = np.diff([*starts, scale.shape[axis]])
            block = np.repeat(np.maximum.reduceat(block, starts, axis=axis), widths, axis=axis)
    least = max(ROUND_OFF * scale.max(initial=0.0), LEAST)
    size: Array = np.maximum(np.maximum(block, SHARE * row), least)
    return size


def _operands(p: Population, k: int, state: dict[str, Any]) -> dict[str, Any]:
    """The operands of element k."""

    rest = np.zeros_like(GROUND)
    there = {key: local(p, k, state[key], GROUND if key == "q" else rest) for key in BODY_OPERANDS}
    first = p.rows[k] if p.kind.rows else 0
    return {**there, "lam": state["lam"][first : first + p.kind.rows], "t": state["t"]}


def _places(operator: Operator, p: Population, k: int) -> tuple[Array, Array]:
    """Rows and columns of element k's contribution; negative for the ground."""

    def along(axis: Axis) -> Array:
        if axis is Axis.ROWS:
            return np.arange(p.rows[k], p.rows[k] + p.kind.rows)
        if axis is Axis.PARAMETERS:
            return p.at + k * p.kind.size() + np.arange(p.kind.size())
        return np.concatenate(
            [np.arange(f, f + width) if f >= 0 else np.full(width, -1) for f, width in owners(p, k)]
        )

    return along(operator.axes[0]), along(operator.axes[1]) if not operator.is_vector else np.zeros(
        1, dtype=int
    )
