"""The linearization of the equations of motion in independent coordinates: one function that is compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from ..._jit.kernels.pointer import NONE, call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array
from ...system import System
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work
from ..dynamics.stepping.entries import entry_of
from ..position.coordinate_set import CoordinateSet
from . import linear_loop as loop
from .linear_loop import (
    FOUND,
    Constraints,
    Coordinates,
    Forces,
    Maps,
    accelerations,
    bend,
    clear,
    directions,
    evaluate,
    factor_regular,
    positions,
    rates,
    solve,
    solve_regular,
    velocities,
)
from .parameter_loop import (
    ByParameters,
    Combination,
    Displacer,
    add_motion_by_parameters,
    bend_by_parameters,
    displace,
)

KINEMATIC = "Phi_q", "Phi_qT_lam_q", "Phi_q_xi_q", "gamma_q", "gamma_v"


def sparse(system: Any, name: str) -> loop.CSR:
    """The pattern of an operator, and memory for its numbers."""
    pattern = system.pattern(name)
    first, columns = (x.astype(np.int64) for x in (pattern.indptr, pattern.indices))
    return loop.CSR(first, columns, np.zeros(pattern.size))


def constraints(of: Any) -> loop.Constraints:
    """The constraints of a system, or coordinates of joints, which have their structure."""
    second = sparse(of, "Phi_q_xi_q")
    kernels = (entry_of(of, *KINEMATIC), entry_of(of, "Phi_q_xi_q")) if of.m else (NONE, NONE)
    numbers = [*(sparse(of, name) for name in KINEMATIC), second]
    return loop.Constraints._make([*kernels, of.b, np.zeros(of.m), *numbers])


def forces(system: System) -> loop.Forces:
    """Forces and inertia of a system."""
    groups = ("Q_q", "Q_v"), ("M_a_q",), ("S_q",), ("S_v",)
    names = [name for group in groups for name in group]
    kernels = (entry_of(system, *group) for group in groups)
    return loop.Forces._make([*kernels, *(sparse(system, name) for name in names)])


def combined(of: Any, name: str, changes: csr_array) -> Combination:
    """The products of an operator's derivatives by b with changes of b (len(b), k)."""
    pattern = of.pattern(name)
    products = changes[pattern.indices].tocoo()
    entries = products.row.astype(np.int64)
    rows = np.searchsorted(pattern.indptr, entries, side="right") - 1
    kernel = entry_of(of, name) if len(entries) else NONE
    numbers, weights = np.zeros(pattern.size), products.data.astype(float)
    return Combination(
        kernel, numbers, entries, weights, rows.astype(np.int64), products.col.astype(np.int64)
    )


def by_parameters(system: System, changes: Array) -> ByParameters:
    """The equations of motion by combinations of parameters, of which each is a column of changes (len(b), k)."""
    names = "M_a_b", "Phi_qT_lam_b", "Q_b", "S_b", "Phi_q_xi_b", "gamma_b"
    every = csr_array(changes)
    return ByParameters._make(combined(system, name, every) for name in names)


def displacing(system: System, independent: CoordinateSet, changes: Array, c_changes: Array) -> Displacer:
    """Constraints and coordinates by combinations of their parameters, (len(b), k) and (len(measured.b), k)."""
    by_b, by_c = csr_array(changes), csr_array(c_changes)
    measured, size = independent.measured, changes.shape[1]
    coordinate = np.zeros(max(measured.m, 1), dtype=np.int64)  # of a row that is measured
    coordinate[independent.row[independent.row >= 0]] = np.flatnonzero(independent.row >= 0)
    parts = [combined(system, name, by_b) for name in ("Phi_b", "Phi_q_xi_b", "Phi_t_b")]
    for name in ("Phi_b", "Phi_q_xi_b", "Phi_q_xi_b", "gamma_b"):
        part = combined(measured, name, by_c)
        parts.append(part._replace(rows=coordinate[part.rows]))
    present = any(len(part.entries) for part in parts)
    shape = (system.nq + system.m, size) if present else (0, 0)
    arrays = [np.zeros(shape) for _ in range(3)]
    states = len(system.states) if present else 0
    return Displacer._make([present, *parts, *arrays, np.zeros((len(independent.row) + states, size))])


ROUNDS = 4  # of the equations of motion: the first, and refinements


@compiled
def linearized(
    entries: Entries, work: Work, matrix: Matrix, phi: Constraints, c: Constraints, forces: Forces, of: Coordinates,
    combinations: ByParameters, displacing: Displacer, maps: Maps, A: Array, a: Array, lam: Array, whole: bool,
    least: float, b: Array, t: float, q: Array, v: Array,
) -> tuple[float, int]:  # fmt: skip
    """Fill a, λ and A (nx, nx + k), the rates of x by x and k combinations of b, with all maps.

    That of a and λ if it is wanted (`whole`).

    Returns
    -------
    how far the pivots can be trusted: at most `least`, nothing else is done, -1 if a or λ are not finite or if vectors
    have other sizes; and FOUND or the dependent coordinate
    """
    if not len(q) == len(v) == len(a):
        return -1.0, FOUND
    trust = factor_regular(entries, b, t, q, matrix)
    if not trust > least:
        return trust, FOUND
    if not solve_regular(entries, b, t, q, v, a, lam, work, matrix, ROUNDS):
        return -1.0, FOUND
    for k in range(len(lam)):
        phi.lam[k] = lam[k]
    evaluate(phi, b, t, q, v, a)
    evaluate(c, c.b, t, q, v, a)
    call_kernels(forces.force, b, t, q, v, forces.Q_q.numbers, forces.Q_v.numbers)
    call_kernels(forces.inertia, b, q, a, forces.M_a_q.numbers)
    call_kernels(forces.by_q, b, q, v, forces.S_q.numbers)
    call_kernels(forces.by_v, b, q, v, forces.S_v.numbers)
    dependent = directions(of, c, matrix, maps)
    if dependent == FOUND:
        n, nx, end = len(of.row), len(A), A.shape[1]
        positions(of, maps)
        moving = velocities(of, phi, c, matrix, maps)
        displaced = displace(of, displacing, phi, c, matrix, b, t, q, v, maps, nx)
        by_q, by_v = (0, n), (0 if moving else n, nx)
        clear(maps.right)
        accelerations(phi, forces, maps, by_q, by_v)
        add_motion_by_parameters(combinations, b, t, q, v, a, lam, maps.right, nx)
        if displaced:
            accelerations(phi, forces, maps, (nx, end), (nx, end))
        rates(of, matrix, maps, A)
        bend(of, c, maps, A, by_q, by_v if moving else (n, n))
        if displaced:
            bend(of, c, maps, A, (nx, end), (nx, end))
            bend_by_parameters(of, displacing, c, t, q, v, a, A, nx)
        if whole:
            solve(matrix, maps.right, maps.work, maps.motion)
    return trust, dependent
