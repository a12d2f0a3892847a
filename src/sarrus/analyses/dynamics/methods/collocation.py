"""Stiffly accurate collocation on the stabilized index-2 equations; Radau IIA of order 5, as described data.

    W q' = W v - Φ_qᵀμ,    M v' = Q + S - Φ_qᵀλ,    Φ = 0,    Φ_q v + Φ_t = 0

at every stage, with q' = Σⱼ (A⁻¹)ᵢⱼ (qⱼ - q₀) / h. Gear, Gupta and Leimkuhler (1985). The unknowns are q, h v, h²λ and
hμ of each stage; the last stage is the end of the step.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ....algebra import Array
from .description import CONSTRAINTS, COORDINATES, Affine, Description, Equation, Stage, Step

SIZES = {"Q": COORDINATES, "V": COORDINATES, "L": CONSTRAINTS, "N": CONSTRAINTS}


def collocation(A: Array, c: Array) -> Description:
    """The method of a Runge-Kutta matrix (s, s) and nodes (s,), the last of which is 1."""
    unknowns = {f"{name}{i}": size for i in range(len(c)) for name, size in SIZES.items()}
    return Description(unknowns, partial(_step, np.linalg.inv(A), c), {})


def radau(stages: int = 3) -> Description:
    """Radau IIA of order 2 s - 1."""
    nodes = np.poly1d([1.0, -1.0]) ** stages * np.poly1d([1.0, 0.0]) ** (stages - 1)
    c = np.sort(np.append(nodes.deriv(stages - 1).roots.real[nodes.deriv(stages - 1).roots < 1 - 1e-6], 1.0))
    powers = np.arange(1, stages + 1)
    A = (c[:, None] ** powers / powers) @ np.linalg.inv(c[:, None] ** (powers - 1))
    return collocation(A, c)


def _step(inverse: Array, c: Array, h: Any, ratio: Any) -> Step:
    size = range(len(c))
    stages, equations = [], []
    for i in size:
        slope: Affine = {f"Q{j}": inverse[i, j] / h for j in size} | {"q": -inverse[i].sum() / h}
        bend: Affine = {f"V{j}": inverse[i, j] / h**2 for j in size} | {"v": -inverse[i].sum() / h}
        rate = {**slope, f"V{i}": -1 / h}
        of_multipliers: dict[str, Affine] = {"lam": {f"L{i}": 1 / h**2}, "mu": {f"N{i}": 1 / h}}
        stages.append(Stage(c[i], {f"Q{i}": 1.0}, {f"V{i}": 1 / h}, bend, **of_multipliers, rate=rate))
        scales = {"kinematic": h, "motion": h**2, "position": 1.0, "velocity": h}
        equations += [Equation(kind, i, scale) for kind, scale in scales.items()]
    return Step(tuple(stages), tuple(equations), {"q": stages[-1].q, "v": stages[-1].v})
