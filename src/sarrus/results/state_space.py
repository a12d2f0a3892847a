"""Linear systems in state space: the result of `linearize`."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..algebra import Array
from ..linalg.eigenvalues import Eigenvalues
from ..model.checks.arguments import as_numbers
from ..model.errors import SarrusError
from ..model.show import suggest
from ..outputs.motion import series
from ..outputs.output import labelled
from ..system import System
from ..system.terms import terms_of
from .assembly import Assembly
from .equilibrium import Equilibrium
from .frequency_response import FrequencyResponse
from .result import Result

DECADE, PER_DECADE = 10.0, 200
UNIT_FREQUENCY = 1.0  # [Hz] in the middle of the frequencies of a system without poles but 0


class Pole(NamedTuple):
    """A pole s [1/s]; vectors with l A = s l and A r = s r (nx,); the distance of the nearest other pole [1/s].

    `round_off` is the error of s, to which it is compared with zero [1/s].
    """

    value: complex
    left: Array
    right: Array
    gap: float
    round_off: float


@dataclass(frozen=True, eq=False)
class StateSpace(Result):
    """The linear system ẋ = A x + B u, y = C x + D u of small changes about a state.

    Attributes
    ----------
    name : of the system
    A, B, C, D : (nx, nx), (nx, nu), (ny, nx), (ny, nu)
    states, inputs, outputs : names: the states are independent coordinates, their rates, first-order states
    state_units, input_units, output_units : their units
    x0, u0, y0 : values about which they change
    t, q, v, a, lam : the state of the linearization, with its accelerations and multipliers
    q_x, v_x : (nq, nx) changes of the coordinates and velocities by x
    unsteady : largest entry of a, and of the rates of first-order states: zero in an equilibrium
    system, start : for outputs and derivatives; `start` is the `Equilibrium` or `Assembly` of the state, or None
    """

    name: str
    A: Array = field(repr=False)
    B: Array = field(repr=False)
    C: Array = field(repr=False)
    D: Array = field(repr=False)
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    state_units: tuple[str, ...] = field(repr=False)
    input_units: tuple[str, ...] = field(repr=False)
    output_units: tuple[str, ...] = field(repr=False)
    x0: Array = field(repr=False)
    u0: Array = field(repr=False)
    y0: Array = field(repr=False)
    t: float = field(repr=False)
    q: Array = field(repr=False)
    v: Array = field(repr=False)
    a: Array = field(repr=False)
    lam: Array = field(repr=False)
    q_x: Array = field(repr=False)
    v_x: Array = field(repr=False)
    unsteady: float = field(repr=False)
    system: System | None = field(default=None, repr=False, compare=False, kw_only=True)
    start: Assembly | Equilibrium | None = field(default=None, repr=False, compare=False, kw_only=True)

    @property
    def success(self) -> bool:
        """True: `linearize` raises an error where it fails."""
        return True

    def __getitem__(self, name: str) -> float:
        """Return an entry or an output, ``plant["A[pin.angle.rate, pin.angle]"]``, ``plant["phase[pin.angle, u, 2]"]``.

        Raises
        ------
        UnknownOutput
            If there is no such output, which is a KeyError, too.
        """
        return float(series(self._own_system, self, name).values[0])

    @property
    def _own_system(self) -> System:
        if self.system is None:
            raise SarrusError(
                f"{self.name}: this linearization does not know its system. Use that of `linearize`."
            )
        return self.system

    def place(self, matrix: str, row: str, column: str) -> tuple[int, int]:
        """Return the row and column of a matrix, "A" to "D", by the names of states, inputs and outputs.

        Raises
        ------
        SarrusError
            If the linearization has no such state, input or output.
        """
        kinds = "states" if matrix in "AB" else "outputs", "states" if matrix in "AC" else "inputs"
        found = []
        for kind, name in zip(kinds, (row, column), strict=True):
            names: tuple[str, ...] = getattr(self, kind)
            if name not in names:
                raise SarrusError(
                    f"{self.name}: {name} is none of the {kind} of the linearization. {suggest(name, names)}"
                )
            found.append(names.index(name))
        return found[0], found[1]

    def summary(self) -> str:
        """The names of states, inputs and outputs."""
        lines = [f"{self.name}, linearized at t = {self.t:g} s: {len(self.states)} states"]
        for kind, names, units in (
            ("states", self.states, self.state_units),
            ("inputs", self.inputs, self.input_units),
            ("outputs", self.outputs, self.output_units),
        ):
            words = ", ".join(map(labelled, names, units)) or "none"
            lines.append(f"  {kind}: {words}")
        return "\n".join(lines)

    @property
    def poles(self) -> Array:
        """Eigenvalues of A (nx,) complex [1/s]."""
        return np.linalg.eigvals(self.A) if len(self.A) else np.zeros(0, dtype=complex)

    def pole(self, number: int) -> Pole:
        """Return a pole with its vectors by its number from 1, in the order of `modes`.

        The order is zeros, then others by rising |Im|, then falling Re. A pole is exactly 0 if it is zero within its
        round-off. The double zero of a free motion counts once, and of a pair of complex poles the one with a positive
        imaginary part.

        Raises
        ------
        SarrusError
            If there is none, or the linearization does not know its system.
        """
        found = self._eigenvalues
        if not 0 < number <= len(found.order):
            raise SarrusError(
                f"{self.name} has no pole{number}. Choose a number from 1 to {len(found.order)}."
            )
        at = found.order[number - 1]
        s, round_off = found.s[at], found.round_off[at]
        gap = abs(np.delete(found.s, at) - s).min(initial=np.inf)
        return Pole(complex(s), found.left[:, at].conj(), found.right[:, at], float(gap), float(round_off))

    @cached_property
    def _eigenvalues(self) -> Eigenvalues:
        """Eigenvalues of A, with the round-off of the terms that have cancelled in A."""
        system = self._own_system
        b = system.b
        terms = terms_of(system, self.t, self.q, self.v, self.a, self.lam, b)
        W = self.v_x[:, (len(self.states) - len(system.states)) // 2 :]
        M = W.T @ (system.M(self.q, b=b) @ W)
        return terms.eigenvalues(self.A, M, self.q_x, self.v_x, system.moving)

    def transfer(self, s: ArrayLike) -> Array:
        """Return the transfer matrices C (s I - A)⁻¹ B + D (..., ny, nu) at complex frequencies s (...) [1/s].

        Raises
        ------
        LinAlgError
            At a pole.
        """
        shift = np.asarray(s)[..., None, None] * np.eye(len(self.A)) - self.A
        return np.asarray(self.C @ np.linalg.solve(shift, self.B + 0j * shift[..., :1]) + self.D)

    def frequency_response(self, frequencies: ArrayLike | None = None) -> FrequencyResponse:
        """Return the response of the outputs to sinusoidal inputs.

        Parameters
        ----------
        frequencies : (nf,) rising [Hz]; by default from a tenth of the slowest to ten times the fastest pole

        Raises
        ------
        SarrusError
            If the system has no inputs or no outputs.
        """
        for names, word, remedy in (
            (self.inputs, "inputs", 'Add sr.Input("u", 0.0) to the forces of the model.'),
            (self.outputs, "outputs", 'Name them: linearize(..., outputs=["pin.angle"]).'),
        ):
            if not names:
                raise SarrusError(f"{self.name}: a frequency response needs {word}. {remedy}")
        given = self._usual() if frequencies is None else frequencies
        f = np.atleast_1d(as_numbers(given, lambda: "frequencies must be numbers in Hz."))
        values = self.transfer(2j * np.pi * f)
        signals = self.inputs, self.outputs, self.input_units, self.output_units
        return FrequencyResponse(self.name, f, values, *signals, warnings=self.warnings)

    def _usual(self) -> Array:
        """Frequencies that show all poles [Hz]."""
        sizes = abs(self._eigenvalues.s[self._eigenvalues.s != 0]) / (2 * np.pi)
        low, high = (sizes.min(), sizes.max()) if len(sizes) else (UNIT_FREQUENCY, UNIT_FREQUENCY)
        count = int(PER_DECADE * np.log10(DECADE**2 * high / low))
        return np.geomspace(low / DECADE, high * DECADE, count)

    def to_scipy(self) -> Any:
        """Return the system as a `scipy.signal.StateSpace`."""
        from scipy.signal import StateSpace as Continuous

        return Continuous(self.A, self.B, self.C, self.D)

    def to_control(self) -> Any:
        """Return the system as a `control.StateSpace` with these names; needs the extra `control`.

        Points in names become underscores, which python-control keeps for connected systems.

        Raises
        ------
        ImportError
            If python-control is not installed.
        """
        try:
            import control
        except ImportError:
            raise ImportError(
                "to_control needs python-control, which is not installed: pip install 'sarrus[control]'."
            ) from None
        names = {
            kind: [name.replace(".", "_") for name in getattr(self, kind)]
            for kind in ("states", "inputs", "outputs")
        }
        return control.ss(self.A, self.B, self.C, self.D, **names)
