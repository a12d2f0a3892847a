"""Velocities: the least change that satisfies Φ_q v = -Φ_t, with given rates of coordinates and joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, vstack

from ...algebra import Array
from ...linalg.kkt import KKT
from ...linalg.rank import row_lengths
from ...model.checks.arguments import Number, real
from ...system import System
from ..equations.length import lever, scaled, units
from .joint_space import JointRate, Rate, rate

FINITE = Number()
SPEED_TOLERANCE = 1e-9  # of |Φ_q v + Φ_t|, relative to the equation's gradient and the largest velocity
FREE = 3e-10  # weight of a velocity that is not given, over that of one that is; documented in `assemble`
SLOWEST = 1e-290  # m/s and rad/s: products of slower speeds lose their digits


@dataclass(frozen=True)
class Velocity:
    """v (nq,) with its multipliers μ (m,) and ν, how far each equation is from being satisfied, and what may be."""

    v: Array
    mu: Array
    nu: Array
    gap: Array
    allowed: Array


def _finite(name: str, value: float) -> float:
    """A given rate; text, nan and infinity are refused by its name.

    Raises
    ------
    TypeError, ValueError
    """
    argument = f"rates: {name}"
    FINITE(argument, value)
    return real(argument, value)


class Rates:
    """The rows C(q) and the values of rates given by name, C(q) v = values."""

    def __init__(self, system: System, given: Mapping[str, float]) -> None:
        self.size, self._joints = system.nq, system.joint_coordinates
        self.rates: list[Rate] = [rate(system, name) for name in given]
        self.values = np.array([_finite(name, value) for name, value in given.items()])

    @property
    def selection(self) -> Array:
        """Return the matrix that selects the joint coordinate of each rate (number of rates, nc)."""
        found = np.zeros((len(self.rates), self._joints.m))
        for n, one in enumerate(self.rates):
            if isinstance(one, JointRate):
                found[n, self._joints.index(one.coordinate.name)] = 1.0
        return found

    def rows_xi_c(self, q: Array, xi: Array) -> Array:
        """(C ξ)_c by the parameters of the joints' coordinates (number of rates, len(c))."""
        return np.asarray(self.selection @ self._joints.Phi_q_xi_b(q, xi).toarray())

    def curvature_c(self, q: Array, nu: Array) -> Array:
        """(Cᵀν)_c (nq, len(c))."""
        return np.asarray(self._joints.Phi_qT_lam_b(q, nu @ self.selection).toarray())

    def rows(self, q: Array) -> csr_array:
        """C (number of rates, nq)."""
        return csr_array(np.array([r.row(q) for r in self.rates]).reshape(-1, self.size))

    def rows_xi_q(self, q: Array, xi: Array) -> csr_array:
        """(C ξ)_q (number of rates, nq)."""
        return csr_array(np.array([r.row_xi_q(q, xi) for r in self.rates]).reshape(-1, self.size))

    def curvature(self, q: Array, nu: Array) -> csr_array:
        """(Cᵀν)_q (nq, nq), symmetric."""
        total = np.zeros((self.size, self.size))
        for one, factor in zip(self.rates, nu, strict=True):
            total += factor * one.row_q(q)
        return csr_array(total)


def given_velocities(system: System, v: Array) -> Array:
    """Whether the model gives velocities of bodies, or v is not the model's: (nq,)."""
    changed = (v != system.v0).reshape(-1, 7)
    linear, angular = changed[:, :3].any(axis=1), changed[:, 3:].any(axis=1)
    return np.asarray(
        system.given_v0 | np.repeat(np.stack([linear, angular], axis=1), (3, 4), axis=1).ravel()
    )


def assemble_velocity(
    system: System, q: Array, v: Array, weight: Array, free: Array, rates: Rates, t: float
) -> Velocity:
    """Solve W (v - v₀) + Φ_qᵀμ + Cᵀν = 0, Φ_q v = -Φ_t, C v = rates; held velocities keep their values.

    Returns
    -------
    Velocity
        `gap` (m + number of rates,) exceeds `allowed` where no such velocity exists.
    """
    F, J = np.flatnonzero(free), csr_array(vstack([system.Phi_q(q, t), rates.rows(q)]))
    right = np.concatenate([-system.Phi_t(q, t), rates.values])
    matrix = KKT(weight[F], csr_array(J[:, F]))
    change, multipliers = matrix.solve(np.zeros(len(F)), right - J @ v)
    found = v.copy()
    found[F] += change
    length = lever(system, q, csr_array(J[: system.m]))
    fastest = float((np.maximum(abs(found), abs(v)) / units(system.nq, length)).max(initial=0.0))
    allowed = SPEED_TOLERANCE * (row_lengths(scaled(J, length)) * max(fastest, SLOWEST) + abs(right))
    return Velocity(found, multipliers[: system.m], multipliers[system.m :], J @ found - right, allowed)
