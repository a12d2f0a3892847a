"""Coordinates of joints as functions of the system's coordinates: values, rates, and exact derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from math import tau

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from ..._jit.kernels.pointer import KernelTable, call_kernels
from ..._jit.linking.link import compiled, link
from ...algebra import Array
from ...model.expansion.blueprint import Placement
from ...model.show import quote, suggest
from ..layout import Layout
from ..structure.population import populate
from ..structure.structure import structure_of
from .constraints import ConstraintOperators

GROUPS = ("Phi", "Phi_qT_lam"), ("Phi_q_xi", "Phi_t")  # that runs evaluate, too


class JointCoordinates(ConstraintOperators):
    """The angles [rad] and displacements [m] of all joints as one vector c(q), with the operators of a constraint.

    The rotations of bodies about global axes may be behind them.

    ``Phi(q)`` is c(q), ``Phi_q(q)`` its derivative (a row for each coordinate), ``Phi_q_xi(q, v)`` its rate, and so
    on to third derivatives. They are no part of the equations of motion.

    Attributes
    ----------
    names : ``pin.angle``, ``slide.displacement``, ``top.rotation_z``, in the order of the rows (nc,)
    angles : which of them are angles (nc,)
    of_joints : how many of them are of joints
    """

    def __init__(
        self, of_joints: Sequence[Placement], layout: Layout, rotations: Sequence[Placement] = ()
    ) -> None:
        self.layout, self.of_joints, placed = layout, len(of_joints), (*of_joints, *rotations)
        self.names = tuple(f"{one.owner}.{one.label}" for one in placed)
        self.angles = np.array(["Memory" in one.element.fields.values() for one in placed], dtype=bool)
        self.populations, self.b = populate(placed, layout.firsts)
        self.nq, self.m = layout.size, len(placed)
        numbers = max((p.end for p in self.populations), default=0)
        self.structure = structure_of(self.populations, layout.widths, self.m, numbers)

    def index(self, name: str) -> int:
        """The row of a coordinate, such as ``pin.angle``.

        Raises
        ------
        KeyError
            If there is no such coordinate.
        """
        if name not in self.names:
            raise KeyError(f"no joint coordinate {name!r}. Choose from {', '.join(self.names) or 'none'}")
        return self.names.index(name)

    def of_joint(self, joint: str) -> list[str]:
        """Names of a joint's coordinates, without the name of the joint.

        Raises
        ------
        KeyError
            If there is no such joint, or it has no coordinates.
        """
        if not isinstance(joint, str):
            raise TypeError(f"a joint is given by its name, got {type(joint).__name__}. Pass a text.")
        found = [name.partition(".")[2] for name in self.names if name.partition(".")[0] == joint]
        if not found:
            known = dict.fromkeys(name.partition(".")[0] for name in self.names)
            raise KeyError(f"no joint {quote(joint)} with an angle or displacement. {suggest(joint, known)}")
        return found

    def near(self, values: Array, near: Array) -> Array:
        """Values with the revolutions that bring the angles nearest to given ones."""
        return values + np.where(self.angles, tau * np.round((near - values) / tau), 0.0)

    def with_revolutions(self, values: Array, revolutions: Array) -> Array:
        """Values of `Phi` plus revolutions (nc,) or (nt, nc); as they are where more or fewer revolutions are known."""
        count = min(self.m, np.shape(revolutions)[-1])
        whole = np.zeros_like(values)
        whole[..., :count] = tau * revolutions[..., :count]
        return values + whole

    def revolutions(self, values: Array, q: ArrayLike) -> Array:
        """The revolutions (nc,) of coordinates at a state, which `with_revolutions` adds."""
        return np.where(self.angles, np.round((values - self.Phi(q)) / tau), 0.0)

    def along(self, t: Array, q: Array, v: Array, revolutions: Array | None = None) -> tuple[Array, Array]:
        """Values and rates (nt, nc) of a motion.

        Without known revolutions (nt, nc) they are counted from one time to the next, of joints with help of the rates.
        """
        values, rates = self._evaluated(t, q, v)
        if revolutions is None or len(revolutions) != len(t):
            mean = 0.5 * (rates[:-1] + rates[1:])
            mean[:, self.of_joints :] = 0.0  # infinite where the axis of a body is the axis of the rotation
            predicted = values[:-1] + np.diff(t)[:, None] * mean
            added = np.where(self.angles, np.round((predicted - values[1:]) / tau), 0.0)
            revolutions = np.concatenate([np.zeros((min(len(t), 1), self.m)), np.cumsum(added, axis=0)])
        return self.with_revolutions(values, np.asarray(revolutions)), rates

    def _evaluated(self, *motion: Array) -> tuple[Array, Array]:
        """Values without revolutions, and rates (nt, nc), of times, coordinates and velocities."""
        t, q, v = (np.require(x, float, ("C", "W")) for x in motion)
        values, rates = np.zeros((2, len(t), self.m))
        if self.m:
            residual, velocity = (self.group(*names).entry() for names in GROUPS)
            beside = np.zeros(self.m), np.zeros(self.nq), np.zeros(self.m)
            link(evaluate)(residual, velocity, self.b, t, q, v, values, rates, *beside)
        return values, rates


class JointCoordinate:
    """One angle or displacement of a joint as a function of the system's coordinates.

    Attributes
    ----------
    name : ``pin.angle``
    """

    def __init__(self, every: JointCoordinates, name: str) -> None:
        self.name = name
        self._every, self._row = every, every.index(name)

    def value(self, q: ArrayLike, near: float | None = None) -> float:
        """The displacement [m], or the angle [rad] nearest to `near` (default: to its initial value)."""
        values = self._every.Phi(q)
        if near is not None:
            values = self._every.near(values, np.full(self._every.m, near))
        return float(values[self._row])

    def rate(self, q: ArrayLike, v: ArrayLike) -> float:
        """Its rate of change at velocities v. [rad/s] or [m/s]"""
        return float(self._every.Phi_q_xi(q, v)[self._row])

    def acceleration(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> float:
        """Its second time derivative. [rad/s²] or [m/s²]"""
        return float((self._every.Phi_q_xi(q, a) - self._every.gamma(q, v))[self._row])

    def gradient(self, q: ArrayLike) -> csr_array:
        """Its exact derivative with respect to q, as a row (1, nq)."""
        return self._every.Phi_q(q)[[self._row]]

    def gradient_xi_q(self, q: ArrayLike, xi: ArrayLike) -> csr_array:
        """The derivative with respect to q of the gradient along a fixed direction ξ, as a row (1, nq)."""
        return self._every.Phi_q_xi_q(q, xi)[[self._row]]


class SystemJoint:
    """A joint of a system: its coordinates by name.

    ``joint["angle"]`` is a `JointCoordinate`; `angle` and `displacement` evaluate those that most joints have.

    Attributes
    ----------
    name : of the joint
    names : of its coordinates
    """

    def __init__(self, every: JointCoordinates, name: str) -> None:
        self.name, self.names = name, tuple(every.of_joint(name))
        self._every = every

    def __getitem__(self, name: str) -> JointCoordinate:
        """The coordinate of a name.

        Raises
        ------
        KeyError
            If the joint has no such coordinate.
        """
        return JointCoordinate(self._every, f"{self.name}.{name}")

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    def angle(self, q: ArrayLike, near: float | None = None) -> float:
        """Its angle, see `JointCoordinate.value`. [rad]"""
        return self["angle"].value(q, near)

    def displacement(self, q: ArrayLike) -> float:
        """Its displacement. [m]"""
        return self["displacement"].value(q)


@compiled(entry=True)
def evaluate(
    residual: KernelTable, velocity: KernelTable, b: Array, t: Array, q: Array, v: Array, values: Array,
    rates: Array, lam: Array, force: Array, Phi_t: Array,
) -> None:  # fmt: skip
    """Fill `values` and `rates` (nt, nc); the kernels give Φ beside Φ_qᵀλ, and Φ_q v beside Φ_t."""
    for n in range(len(t)):
        call_kernels(residual, b, t[n], q[n], lam, values[n], force)
        call_kernels(velocity, b, t[n], q[n], v[n], rates[n], Phi_t)
