"""Vibration modes about an equilibrium or a steady motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np

from ..algebra import Array
from ..deferred import renderer
from ..euler import E
from ..model import ModelError
from ..model.checks.arguments import WholeNumber
from ..model.coordinates import coordinates_of
from ..system import System
from .result import Result


class NoModeError(ModelError, IndexError):
    """The index of a mode that does not exist."""


class BodyShape(NamedTuple):
    """Motion of a body in a mode: complex amplitudes in global axes, of its origin [m] and its rotation [rad]."""

    translation: Array
    rotation: Array


@dataclass(frozen=True)
class Modes(Result):
    """Vibration modes shape·exp(s t), one for each complex pair, with Im s > 0.

    Tables, figures and outputs number the modes from 1: ``mode1.frequency``. Arrays, and the argument `mode` of
    methods, have the index of Python: ``frequencies[0]`` and ``shape(0, "slider")`` are those of mode 1.

    Attributes
    ----------
    name : of the system
    bodies : names
    q : (nq,) the position of the linearization
    eigenvalues : s, one per mode (k,) complex [1/s], by increasing |Im s|, then decreasing Re s; exactly 0 for a free
        motion, if it is zero within its round-off error
    shapes : (nq, k) complex changes of the coordinates, the largest coordinate is 1
    matrix : (2 d, 2 d) of the first-order equations ẋ = matrix·x in independent coordinates
    M, D, K : (d, d) mass, damping and stiffness matrix there; about a motion, with all gyroscopic terms
    Z : (nq, d) change of the coordinates per independent one
    round_off : (k,) error of each eigenvalue: round-off of the equations of motion times its condition number [1/s]
    energy_shares : (owners, k) fraction of each body, or block of a part, in the kinetic energy of each mode
    steady : difference of the acceleration from that of a steady motion [m/s²], [1/s²]
    message : one message about stability
    t, v, lam : time [s], velocities (nq,) and multipliers (m,) of the linearization
    system : System, for outputs and derivatives
    """

    name: str
    bodies: tuple[str, ...]
    q: Array = field(repr=False)
    eigenvalues: Array = field(repr=False)
    shapes: Array = field(repr=False)
    matrix: Array = field(repr=False)
    M: Array = field(repr=False)
    D: Array = field(repr=False)
    K: Array = field(repr=False)
    Z: Array = field(repr=False)
    round_off: Array = field(repr=False)
    energy_shares: Array = field(repr=False)
    steady: float
    success: bool
    message: str
    stability: Literal["stable", "marginal", "unstable"]
    t: float = field(default=0.0, repr=False, kw_only=True)
    v: Array = field(default_factory=lambda: np.zeros(0), repr=False, kw_only=True)
    lam: Array = field(default_factory=lambda: np.zeros(0), repr=False, kw_only=True)
    system: System | None = field(default=None, repr=False, compare=False, kw_only=True)

    @property
    def owners(self) -> tuple[str, ...]:
        """Names of what moves: the bodies, and behind them the blocks of coordinates of parts."""
        return self.bodies if self.system is None else self.system.layout.moving.owners

    @property
    def frequencies(self) -> Array:
        """Damped frequencies |Im s| / 2π (k,) [Hz]."""
        return np.asarray(abs(self.eigenvalues.imag) / (2 * np.pi))

    @property
    def natural_frequencies(self) -> Array:
        """|s| / 2π (k,) [Hz]."""
        return np.asarray(abs(self.eigenvalues) / (2 * np.pi))

    @property
    def damping_ratios(self) -> Array:
        """-Re s / |s| (k,) [-]: 1 for a decay without vibration, 0 for a free motion."""
        size = abs(self.eigenvalues)
        return np.asarray(-self.eigenvalues.real / np.where(size > 0, size, 1.0))

    def shape(self, mode: int, body: str) -> BodyShape:
        """Return the motion of one body in one mode, which is given by its index: 0 is mode 1.

        Raises
        ------
        KeyError
            If there is no such body.
        NoModeError
            If there is no such mode.
        """
        self.refuse_unknown(mode)
        at = coordinates_of(body, self.bodies, self.name)
        part = self.shapes[at, mode]
        return BodyShape(part[:3], 2 * E(self.q[at][3:]) @ part[3:])

    def refuse_unknown(self, mode: int) -> None:
        """Refuse the index of a mode that does not exist.

        Raises
        ------
        TypeError
        NoModeError
        """
        WholeNumber()("mode", mode)
        count = len(self.eigenvalues)
        if mode >= count:
            choice = f"Choose 0 (mode 1){f' to {count - 1}' * (count > 1)}"
            allowed = choice if count else "The system has no degrees of freedom"
            raise NoModeError(f"{self.name}: There is no mode with the index {mode}. {allowed}.")

    def headline(self) -> str:
        """Its stability."""
        return self.message.rstrip(".")

    def summary(self) -> str:
        """The result in words."""
        return str(renderer().modes_table(self))

    def plot(self, ax: Any = None) -> Any:
        """Draw the eigenvalues in the complex plane; see `sarrus.views.plot_modes`."""
        return renderer().plot_modes(self, ax)

    def animate(self, system: Any, mode: int = 0, file: Any = None, *, amplitude: float | None = None) -> Any:
        """Play one swing of a mode, given by its index, in three dimensions; see `sarrus.views.animate_mode`."""
        return renderer().animate_mode(self, system, mode, file, amplitude=amplitude)
