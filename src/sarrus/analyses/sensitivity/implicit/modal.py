"""Derivatives of vibration modes about an equilibrium: (s² M + s D + K) X + Φ_qᵀμ = 0, Φ_q X = 0, one entry of X is 1.

The left sides are the change of the residual F of the equations of motion along (X, s X, s² X, μ), and so their
derivatives at constant s, X and μ, times adjoint variables, are contracted second derivatives of F.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ....algebra import Array
from ....model.announcement import announce
from ....outputs.recording import Key
from ....results import Equilibrium, Modes
from ...equations.states_at_rest import places
from ...equilibria.vibration import largest_entries
from ...position.assembly_derivatives import NoDerivative
from ..lagrangians.changes import change_at
from ..lagrangians.curves import CurveLagrangian
from .rest import RestingState
from .solved_states import Slopes, StateAnalysis

REPEATED = 1e-6  # relative difference of eigenvalues that count as one
TIED = 1e-9  # relative difference of entries of a shape that count as equal
REFINEMENTS = 3  # steps of Newton's method on the eigenpair
STATES = ("q", "v", "lam", "b")


class ModesAbout(StateAnalysis):
    """The modes about the state of an equilibrium."""

    result: Modes

    def __init__(self, state: RestingState, modes: Modes) -> None:
        if np.any(modes.v[: state.system.moving]):
            raise NoDerivative(
                f"{modes.name}: modes about a steady motion have no derivatives yet. Take modes about an equilibrium."
            )
        self.result, self._state = modes, state
        self._pairs = dict[int, Eigenpair]()

    def gradient(self, key: Key, bar: float) -> Slopes:
        at, word = key[1]
        if at not in self._pairs:
            self._refuse_repeated(at)
            self._pairs[at] = Eigenpair(self._state, self.result, at)
        return self._pairs[at].gradient(word, bar)

    def _refuse_repeated(self, at: int) -> None:
        """Refuse a mode without derivatives of its own.

        Raises
        ------
        NoDerivative
        """
        modes, values = self.result, self.result.eigenvalues
        s, name = values[at], f"{modes.name}: mode{at + 1}"
        if s == 0.0:
            raise NoDerivative(f"{name} is a free motion, whose eigenvalue stays zero. Take another mode.")
        gaps = abs(np.append(np.delete(values, at)[:, None] - [s, s.conjugate()], 2 * s.imag or np.inf))
        if gaps.min() <= REPEATED * abs(s) + 10 * modes.round_off[at]:
            message = (
                f"{name} has the same eigenvalue as another mode, {s:.6g} 1/s: alone it has no derivative"
            )
            raise NoDerivative(
                f"{message}. Change a parameter so that they differ, such as a stiffness by 0.1 %."
            )


class Eigenpair:
    """One mode with the matrix of its linearized equations.

    Parameters
    ----------
    state : the equilibrium
    modes : about it
    at : place of the mode, from 0
    """

    def __init__(self, state: RestingState, modes: Modes, at: int) -> None:
        self._state, self._system = state, state.derivatives.system
        self._name, self._s = modes.name, complex(modes.eigenvalues[at])
        self._own = places(self._system)
        self._X = modes.shapes[:, at].astype(complex)
        self._X[self._own] /= self._s  # integrals of the states
        self._top = int(largest_entries(modes.shapes[:, at : at + 1], self._system.moving)[0])
        self._rows = np.flatnonzero(~state.steps.left_out[0])
        self._mu = np.zeros(len(self._rows), dtype=complex)
        for _ in range(REFINEMENTS):
            self._refine()

    @cached_property
    def _matrices(self) -> tuple[Array, Array, Array, Array]:
        """M, D, K (nq, nq) and the independent rows of Φ_q."""
        system, steps = self._system, self._state.steps
        t, q, v, lam, b = float(steps.t[0]), steps.q[0], steps.v[0], steps.lam[0], system.b
        K = system.Phi_qT_lam_q(q, lam, t, b=b) - system.Q_q(q, v, t, b=b) - system.S_q(q, v, b=b)
        D = -(system.Q_v(q, v, t, b=b) + system.S_v(q, v, b=b))
        found = (system.M(q, b=b), D, K, system.Phi_q(q, t, b=b))
        M, D, K, J = (np.asarray(x.toarray()) for x in found)
        return M, D, K, J[self._rows]

    def _bordered(self) -> Array:
        """The derivatives of the equations by X, μ and s."""
        (M, D, K, J), s, X = self._matrices, self._s, self._X
        n, m = J.shape[1], J.shape[0]
        found = np.zeros((n + m + 1, n + m + 1), dtype=complex)
        found[:n, :n] = s * s * M + s * D + K
        found[:n, n : n + m], found[n : n + m, :n] = J.T, J
        found[:n, -1] = (2 * s * M + D) @ X
        found[-1, self._top], found[-1, -1] = self._normalization
        return found

    @property
    def _normalization(self) -> tuple[complex, complex]:
        """The derivatives of the largest entry, which is 1, by X and by s; of a state, it is s times its integral."""
        return (self._s, self._X[self._top]) if self._top in self._own else (1.0, 0.0)

    def _refine(self) -> None:
        (M, D, K, J), s, X = self._matrices, self._s, self._X
        largest = X[self._top] * (s if self._top in self._own else 1.0)
        residual = [(s * s * M + s * D + K) @ X + J.T @ self._mu, J @ X, [largest - 1]]
        change = np.linalg.solve(self._bordered(), -np.concatenate(residual))
        n = len(X)
        self._X, self._mu, self._s = X + change[:n], self._mu + change[n:-1], s + change[-1]

    def gradient(self, word: str | int, bar: float) -> Slopes:
        """The gradient of what has the derivative `bar` by one of the mode's quantities, see `modal_value`."""
        n, right = len(self._X), np.zeros(len(self._X) + len(self._mu) + 1, dtype=complex)
        if isinstance(word, int):
            self._warn_of_ties()
            right[word] = bar
        else:
            right[-1] = bar if word == "re" else -1j * bar
        found = np.linalg.solve(self._bordered().T, right)
        w, nu = found[:n], np.zeros(self._system.m, dtype=complex)
        nu[self._rows] = found[n:-1]
        parts = [self._contracted(w.real, nu.real, np.real), self._contracted(-w.imag, -nu.imag, np.imag)]
        return Slopes._make(-(one + other) for one, other in zip(*parts, strict=True))

    def _warn_of_ties(self) -> None:
        """Warn where two coordinates are the largest, one of which is 1 for all values of the parameters."""
        sizes = abs(self._X[: self._system.moving])
        names = [self._system.coordinate_names[n] for n in np.flatnonzero(sizes >= (1 - TIED) * sizes.max())]
        if self._top not in self._own and len(names) > 1:
            of = f"{self._name}: the shape of a mode is largest in {' and '.join(names)}"
            announce(
                [f"{of}. Its derivatives are those where {self._system.coordinate_names[self._top]} is 1."]
            )

    def _contracted(self, w: Array, nu: Array, part: Any) -> Slopes:
        """The gradient of (w, ν)ᵀ F' along a part of (X, s X, s² X, μ)."""
        system, steps, s, X = self._system, self._state.steps, self._s, self._X
        mu, none, curves = np.zeros(system.m), np.zeros(len(system.b)), CurveLagrangian(system, True, False)
        mu[self._rows] = part(self._mu)
        found = change_at(
            system, "step", float(steps.t[0]), system.b, none, steps.lam[0], nu, mu, curves,
            q=steps.q[0], v=steps.v[0], xi=w, q_dot=part(X), v_dot=part(s * X), a_dot=part(s * s * X),
        )  # fmt: skip
        none = np.zeros(len(system.joint_coordinates.b))
        return Slopes(found.q, found.v, 0 * found.a, found.lam, found.b, none)


def equilibrium_of(modes: Modes) -> Equilibrium:
    """The state of the modes as an equilibrium."""
    none, empty = np.zeros(0), np.zeros((len(modes.q), 0))
    return Equilibrium(
        modes.name, modes.q, modes.lam, True, modes.message, "unknown", none, empty, modes.steady, 0, modes.t, modes.v,
        system=modes.system,
    )  # fmt: skip
