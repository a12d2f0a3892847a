"""Contracted second derivatives of the equations of motion along directions, some at once: compiled functions.

The Lagrangian L of a weighted sum contains the equations that determine a state, each times its adjoint variables. The
second derivative of the sum along changes y' = (q', v', a', λ', b') of the state is y'ᵀ (∂²L/∂y²) y'.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_array

from ..._jit.kernels.pointer import NONE, KernelTable, call_kernels
from ..._jit.kernels.vector import LANES
from ..._jit.linking.link import compiled
from ...algebra import Array
from ...linalg.lanes_loop import clear_lanes
from ...system import System
from ...system.curves.lanes import buffer
from ..equilibria.balance import input_changes
from ..equilibria.linear_loop import CSR
from ..position.coordinate_set import CoordinateSet
from ..sensitivity.lagrangians.changes import lagrangian
from .parameter_changes import ParameterChanges


class Columns(NamedTuple):
    """Combinations of parameters: where each begins, and their end; places in b, and weights."""

    first: Array
    places: Array
    weights: Array


class Pairs(NamedTuple):
    """Pairs of parameters by which b has second derivatives: rows and columns of H."""

    rows: Array
    columns: Array


class Equations(NamedTuple):
    """Kernels of the Lagrangians of equations, or of coordinates, and their operands and results in lanes.

    Attributes
    ----------
    motion, rate, place : see `lagrangian`
    b : parameters of coordinates
    nu_motion, nu_rate, nu_place : adjoint variables
    """

    motion: KernelTable
    rate: KernelTable
    place: KernelTable
    b: Array
    b_dot: Array
    lam: Array
    lam_dot: Array
    nu_motion: Array
    nu_rate: Array
    nu_place: Array
    by_lam: Array
    by_b: Array


class State(NamedTuple):
    """A state, the adjoint variables ξ of the equations of motion, changes, and gradients of L that change: in lanes.

    `still` is a direction of zeros.
    """

    t: Array
    q: Array
    v: Array
    a: Array
    xi: Array
    still: Array
    q_dot: Array
    v_dot: Array
    a_dot: Array
    by_q: Array
    by_v: Array
    by_a: Array


@compiled
def add_transposed(A: CSR, by: float, x: Array, first: int, to: Array) -> None:
    """Add a multiple of Aᵀ x to a vector; x begins at a place."""
    for row in range(len(A.first) - 1):
        weight = by * x[first + row]
        if weight != 0.0:
            for entry in range(A.first[row], A.first[row + 1]):
                to[A.columns[entry]] += weight * A.numbers[entry]


@compiled
def fill(x: Array, by: float, first: int, out: Array) -> None:
    """A multiple of entries of x from a place on in all lanes."""
    for k in range(len(out) // LANES):
        for lane in range(LANES):
            out[k * LANES + lane] = by * x[first + k]


@compiled
def fit(of: Equations, b: Array, weights: Array, every: int, H: Array, size: int) -> bool:
    """Whether parameters, weights and second derivatives have their sizes."""
    return len(b) == len(of.b_dot) and len(weights) == every and H.shape == (size, size)


@compiled
def put(x: Array, first: int, column: int, lane: int, out: Array) -> None:
    """Entries of a column of x from a row on in one lane."""
    for k in range(len(out) // LANES):
        out[k * LANES + lane] = x[first + k, column]


@compiled
def still_lane(lane: int, out: Array) -> None:
    """Zeros in one lane."""
    for k in range(len(out) // LANES):
        out[k * LANES + lane] = 0.0


@compiled
def at_state(x: State, of: Equations, t: float, q: Array, v: Array, a: Array, lam: Array) -> None:
    """The operands of a state."""
    for lane in range(LANES):
        x.t[lane] = t
    fill(q, 1.0, 0, x.q)
    fill(v, 1.0, 0, x.v)
    fill(a, 1.0, 0, x.a)
    fill(lam, 1.0, 0, of.lam)


@compiled
def clear_changes(x: State, of: Equations) -> None:
    """Zeros in place of the results."""
    clear_lanes(x.by_q)
    clear_lanes(x.by_v)
    clear_lanes(x.by_a)
    clear_lanes(of.by_lam)
    clear_lanes(of.by_b)


@compiled
def add_motion(x: State, of: Equations, b: Array, xi: Array) -> None:
    """The changes of the gradient of ξᵀ(M a + Φ_qᵀλ - Q - S) + νᵀ(Φ_q a - γ)."""
    call_kernels(of.motion, b, x.t, x.q, x.v, x.a, x.q_dot, x.v_dot, x.a_dot, xi, of.lam, of.nu_motion, of.lam_dot,
                 of.b_dot, x.by_q, x.by_v, x.by_a, of.by_lam, of.by_b)  # fmt: skip


@compiled
def add_kinematics(x: State, of: Equations, b: Array) -> None:
    """The changes of the gradient of νᵀΦ - νᵀ(Φ_q v + Φ_t), each with its own ν."""
    call_kernels(of.rate, b, x.t, x.q, x.v, x.a, x.q_dot, x.v_dot, x.a_dot, x.still, of.lam, of.nu_rate, of.lam_dot,
                 of.b_dot, x.by_q, x.by_v, x.by_a, of.by_lam, of.by_b)  # fmt: skip
    call_kernels(of.place, b, x.t, x.q, x.v, x.a, x.q_dot, x.v_dot, x.a_dot, x.still, of.lam, of.nu_place, of.lam_dot,
                 of.b_dot, x.by_q, x.by_v, x.by_a, of.by_lam, of.by_b)  # fmt: skip


@compiled
def set_parameters(by: Columns, k: int, factor: float, of: Equations) -> None:
    """The change of the parameters of a combination."""
    for n in range(by.first[k], by.first[k + 1]):
        of.b_dot[by.places[n]] = factor * by.weights[n]


@compiled
def add_parameters(by: Columns, of: Equations, lane: int, row: int, first: int, H: Array) -> None:
    """Add the changes of the gradient by combinations of parameters to a row of H, from a column on."""
    for k in range(len(by.first) - 1):
        for n in range(by.first[k], by.first[k + 1]):
            H[row, first + k] += by.weights[n] * of.by_b[by.places[n] * LANES + lane]


@compiled
def add_curved(of: Pairs, weights: Array, start: int, D: Array, first: int, H: Array) -> None:
    """Add weighted changes along the second derivatives of b, the last columns of D, to H.

    Weights and rows of D begin at places.
    """
    column = D.shape[1] - len(of.rows)
    for n in range(len(of.rows)):
        total = 0.0
        for k in range(min(len(weights) - start, len(D) - first)):
            total += weights[start + k] * D[first + k, column + n]
        H[of.rows[n], of.columns[n]] += total
        if of.rows[n] != of.columns[n]:
            H[of.columns[n], of.rows[n]] += total


@compiled
def add_product(g: Array, lane: int, D: Array, first: int, left: int, row: int, H: Array) -> None:
    """Add gᵀD to a row of H; g is in a lane, rows and columns of D begin at places."""
    for k in range(len(g) // LANES):
        weight = g[k * LANES + lane]
        if weight != 0.0:
            for column in range(H.shape[1]):
                H[row, column] += weight * D[first + k, left + column]


def columns_of(changes: Array) -> Columns:
    """The combinations of parameters that are the columns of changes (len(b), k)."""
    every = csc_array(changes)
    return Columns(every.indptr.astype(np.int64), every.indices.astype(np.int64), every.data)


class CurvedParameters(NamedTuple):
    """Inputs and parameters as combinations, and second derivatives of b and c behind them, as more combinations.

    Attributes
    ----------
    b, c : (len(b), nu + p + n), (len(measured.b), nu + p + n) changes of the elements' and the coordinates' parameters
    by_b, by_c : those of inputs and parameters, for compiled code
    curved : to which entries of H the others belong
    """

    b: Array
    c: Array
    by_b: Columns
    by_c: Columns
    curved: Pairs

    @classmethod
    def of(
        cls,
        system: System,
        inputs: Sequence[str],
        parameters: ParameterChanges,
        first: int,
        independent: CoordinateSet | None = None,
    ) -> CurvedParameters:
        """Those of inputs and parameters, which have rows of H from the first on.

        Raises
        ------
        SarrusError
            For parameters of tables and formulas, and coordinates that no joint has.
        """
        bent, pairs = parameters.second(system)
        of_c = []
        for changes in (parameters, bent):
            changes.refuse_curves(system, "Leave it out.")
            none = np.zeros((0, changes.b.shape[1]))
            of_c.append(none if independent is None else changes.of_coordinates(system, independent))
        b = np.hstack([input_changes(system, inputs), parameters.b, bent.b])
        c = np.hstack([np.zeros((len(of_c[0]), len(inputs))), *of_c])
        count = len(inputs) + len(parameters.names)
        by = columns_of(b[:, :count]), columns_of(c[:, :count])
        return cls(b, c, *by, Pairs(*(pairs + first + len(inputs))))


def equations_of(of: Any, kinds: tuple[str, ...] = ("motion", "rate", "place")) -> Equations:
    """The equations of a system, or coordinates of joints, which have their structure."""
    kernels = [lagrangian(of, kind) for kind in kinds] + [NONE] * (3 - len(kinds))
    rows = [buffer(of.m) for _ in range(6)]
    return Equations._make([*kernels, of.b.copy(), np.zeros(len(of.b)), *rows, buffer(len(of.b))])


def state_of(system: System) -> State:
    """Arrays for a state and its changes."""
    return State._make([np.zeros(LANES), *(buffer(system.nq) for _ in range(11))])
