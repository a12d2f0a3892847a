"""Stiffly accurate collocation on the stabilized index-2 equations; Radau IIA of order 5, as described data.

    W q' = W v - Φ_qᵀμ,    M v' = Q + S - Φ_qᵀλ,    Φ = 0,    Φ_q v + Φ_t = 0

at every stage, with q' = Σⱼ (A⁻¹)ᵢⱼ (qⱼ - q₀) / h. Gear, Gupta and Leimkuhler (1985). The unknowns are q, h v, h²λ and
hμ of each stage; the last stage is the end of the step.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ....algebra import Array
from .description import (
    CONSTRAINTS,
    COORDINATES,
    Affine,
    Description,
    Equation,
    FilteredEstimate,
    Stage,
    Step,
    StepLengths,
)

CONSTANT = 0.01  # of the estimated error of a first step
LENGTHS = StepLengths(
    safety=0.9, iterations=10, grow=8.0, below=1.0, above=1.2, predictive=True, unsolved=0.5, hold=16
)
SIZES = {"Q": COORDINATES, "V": COORDINATES, "L": CONSTRAINTS, "N": CONSTRAINTS}


def collocation(A: Array, c: Array) -> Description:
    """The method of a Runge-Kutta matrix (s, s) and nodes (s,), the last of which is 1."""
    unknowns = {f"{name}{i}": size for i in range(len(c)) for name, size in SIZES.items()}
    inverse = np.linalg.inv(A)
    step, continued = partial(_step, inverse, c), partial(_continued, c)
    return Description(unknowns, step, error=_estimate(inverse, c), lengths=LENGTHS, continued=continued)


def radau(stages: int = 3) -> Description:
    """Radau IIA of order 2 s - 1."""
    nodes = np.poly1d([1.0, -1.0]) ** stages * np.poly1d([1.0, 0.0]) ** (stages - 1)
    c = np.sort(np.append(nodes.deriv(stages - 1).roots.real[nodes.deriv(stages - 1).roots < 1 - 1e-6], 1.0))
    powers = np.arange(1, stages + 1)
    A = (c[:, None] ** powers / powers) @ np.linalg.inv(c[:, None] ** (powers - 1))
    return replace(collocation(A, c), name=f"Radau IIA of order {2 * stages - 1}")


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


def _lagrange(nodes: Array, j: int, x: Any) -> Any:
    """The polynomial that is 1 at a node and 0 at the others."""
    value: Any = 1.0
    for i, node in enumerate(nodes):
        if i != j:
            value = value * ((x - float(node)) / float(nodes[j] - node))
    return value


def _continued(c: Array, h: Any, ratio: Any) -> dict[str, Affine]:
    """The polynomials of the last step go on: of q and v through its start and its stages, of λ through its stages."""
    nodes, found = np.append(c, 0.0), dict[str, Affine]()
    for i, node in enumerate(c):
        x = 1.0 + ratio * float(node)
        of = [_lagrange(nodes, j, x) for j in range(len(nodes))]
        found[f"Q{i}"] = {**{f"Q{j}": of[j] for j in range(len(c))}, "q": of[-1]}
        found[f"V{i}"] = {**{f"V{j}": ratio * of[j] for j in range(len(c))}, "v": h * of[-1]}
        found[f"L{i}"] = {f"L{j}": ratio * ratio * _lagrange(c, j, x) for j in range(len(c))}
    return found


def _estimate(inverse: Array, c: Array) -> FilteredEstimate | None:
    """The difference to a formula of order s that adds the slope at the start, for three stages (IV.8.19)."""
    s = len(c)
    if s != 3:
        return None
    weights = np.linalg.solve(c ** np.arange(s)[:, None], -np.eye(s)[0]) @ inverse
    return FilteredEstimate(s, CONSTANT, partial(_slopes, weights), 2 * s - 1)


def _slopes(weights: Array, h: Any, ratio: Any) -> tuple[Affine, Affine]:
    """The two differences whose filtered values are the estimate."""
    s = len(weights)
    rate = {f"Q{j}": weights[j] / h for j in range(s)} | {"q": -weights.sum() / h, "v": 1.0}
    bend = {f"V{j}": weights[j] / h**2 for j in range(s)} | {"v": -weights.sum() / h, "a": 1.0}
    return rate, bend


RADAU = radau()
