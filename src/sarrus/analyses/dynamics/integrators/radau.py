"""Radau IIA, three stages, order 5: for high accuracy; on the stabilized index-2 (GGL) equations

    W q' = W v - Φ_qᵀμ,    M v' = Q + S - Φ_qᵀλ,    Φ = 0,    Φ_q v + Φ_t = 0.

W measures displacements in a length of the system, see `kinematic_weights`.

Gear, Gupta and Leimkuhler (1985); Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8 and VII.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....results import Assembly
from ....system import System
from ..stepping.stepper import Settings
from ..time_loop.prescribed import Prescribed
from .radau_loop import Scheme
from .radau_run import RadauStepper


@dataclass(frozen=True)
class Radau(Prescribed):
    """The implicit Runge-Kutta method of order 5 by Radau, stiffly accurate and L-stable, with variable steps.

    All stages are solved together by Newton's method; one real and one complex matrix are factored for them.
    """

    def stepper(self, system: System, start: Assembly, settings: Settings) -> RadauStepper:
        """The method at work, see `Stepper`."""
        return RadauStepper(system, SCHEME, start, settings)


def _scheme() -> Scheme:
    """Collocation at the zeros of d²/dx² (x² (x - 1)³), and the transformation that splits its stages.

    A⁻¹ T = T Λ, Λ = [γ 0 0; 0 α -β; 0 β α]; the error estimate is the difference to a formula of order 3 that adds the
    slope at the start (IV.8.19).
    """
    c = np.array([(4 - np.sqrt(6)) / 10, (4 + np.sqrt(6)) / 10, 1.0])
    powers = np.arange(1, 4)
    A = (c[:, None] ** powers / powers) @ np.linalg.inv(c[:, None] ** (powers - 1))
    inverse = np.linalg.inv(A)
    values, vectors = np.linalg.eig(inverse)
    real, pair = np.argmin(abs(values.imag)), np.argmax(values.imag)
    x = vectors[:, pair]
    T = np.column_stack([vectors[:, real].real, x.real, -x.imag])
    error = np.array([-13 - 7 * np.sqrt(6), -13 + 7 * np.sqrt(6), -1]) / 3
    return Scheme(c, inverse, T, np.linalg.inv(T), float(values[real].real), complex(values[pair]), error)


SCHEME = _scheme()
