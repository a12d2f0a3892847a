"""Velocities: the least change that satisfies Φ_q v = -Φ_t, with given rates of coordinates and joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array, vstack

from ...algebra import Array
from ...linalg.kkt import KKT
from ...linalg.rank import row_lengths
from ...model.checks.arguments import Number, in_si, real
from ...system import System
from ...system.operators.joints import JointCoordinates
from ..equations.length import scaled, units
from .coordinate_set import CoordinateSet, of_names

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


def _finite(name: str, value: Any, unit: str) -> float:
    """A given rate in SI units; nan and infinity are refused by its name.

    Raises
    ------
    TypeError, ValueError
    """
    argument = f"rates: {name}"
    found = in_si(argument, value, f"{unit}/s")
    FINITE(argument, found)
    return real(argument, found)


class Rates:
    """The rows C(q) and the values of rates given by name, C(q) v = values."""

    def __init__(self, system: System, rates: Mapping[str, float]) -> None:
        self._system, self._names, self._joints = system, tuple(rates), system.joint_coordinates
        self.values = np.zeros(0)
        if rates:
            units = self._coordinates.labels()[2]  # unknown names are refused
            self.values = np.array([_finite(*one) for one in zip(rates, rates.values(), units, strict=True)])

    @cached_property
    def _coordinates(self) -> CoordinateSet:
        return of_names(self._system, self._names, "a given rate")

    @property
    def _measured(self) -> JointCoordinates:
        return self._coordinates.measured

    @property
    def _of_measured(self) -> Array:
        row = self._coordinates.row[:, None]
        return np.where(row >= 0, row == np.arange(self._measured.m), 0.0)

    @property
    def selection(self) -> Array:
        """Return the matrix that selects the joint coordinate of each rate (number of rates, nc)."""
        selection = np.zeros((len(self.values), self._joints.m))
        for n, output in enumerate(self._coordinates.outputs):
            if output.place is None:
                selection[n, self._joints.index(output.name)] = 1.0
        return selection

    def rows_xi_c(self, q: Array, xi: Array) -> Array:
        """(C ξ)_c by the parameters of the joints' coordinates (number of rates, len(c))."""
        return np.asarray(self.selection @ self._joints.Phi_q_xi_b(q, xi).toarray())

    def curvature_c(self, q: Array, nu: Array) -> Array:
        """(Cᵀν)_c (nq, len(c))."""
        return np.asarray(self._joints.Phi_qT_lam_b(q, nu @ self.selection).toarray())

    def below(self, J: csr_array, q: Array) -> csr_array:
        """[J; C] (m + number of rates, nq)."""
        return csr_array(vstack([J, csr_array(self._coordinates.gradients(q))])) if len(self.values) else J

    def rows_xi_q(self, q: Array, xi: Array) -> csr_array:
        """(C ξ)_q (number of rates, nq)."""
        return csr_array(self._of_measured @ self._measured.Phi_q_xi_q(q, xi).toarray())

    def curvature(self, q: Array, nu: Array) -> csr_array:
        """(Cᵀν)_q (nq, nq), symmetric."""
        return self._measured.Phi_qT_lam_q(q, nu @ self._of_measured)


def given_velocities(system: System, v: Array) -> Array:
    """Whether the model gives velocities of bodies, or v is not the model's: (nq,)."""
    layout = system.layout
    differs = np.logical_or.reduceat(v != system.v0, layout.starts)
    return np.asarray(system.given_v0 | np.repeat(differs, layout.widths))


def assemble_velocity(
    system: System, q: Array, v: Array, weight: Array, free: Array, rates: Rates, t: float
) -> Velocity:
    """Solve W (v - v₀) + Φ_qᵀμ + Cᵀν = 0, Φ_q v = -Φ_t, C v = rates; held velocities keep their values.

    Returns
    -------
    Velocity
        `gap` (m + number of rates,) exceeds `allowed` where no such velocity exists.
    """
    F, Phi_q = np.flatnonzero(free), system.Phi_q(q, t)
    J = rates.below(Phi_q, q)
    right = np.concatenate([-system.Phi_t(q, t), rates.values])
    matrix = KKT(None, J if np.all(free) else csr_array(J[:, F]), weight[F])
    change, multipliers = matrix.solve(np.zeros(len(F)), right - J @ v)
    velocity = v.copy()
    velocity[F] += change
    unit = units(system, q, Phi_q)
    fastest = float((np.maximum(abs(velocity), abs(v)) / unit).max(initial=0.0))
    allowed = SPEED_TOLERANCE * (row_lengths(scaled(J, unit)) * max(fastest, SLOWEST) + abs(right))
    return Velocity(velocity, multipliers[: system.m], multipliers[system.m :], J @ velocity - right, allowed)
