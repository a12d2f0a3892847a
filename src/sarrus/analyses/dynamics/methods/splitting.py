"""Splitting of a step whose stages are alike into one real and one complex system of the size of one stage.

With the operators of one state for all stages, the matrix of a step is a sum of D ⊗ X: coefficients (s, s) of the
method times an operator. Where one T takes all D to the form [γ 0 0; 0 α -β; 0 β α], W = T⁻¹ Z separates the equations
(Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ....algebra import Array
from .description import Description, Operation, Step
from .tables import OperatorTerm, Structure, Tables, Weight, structure_of

STAGES = 3  # one real and one complex system
SAMPLES = (1.0, 1.0), (0.37, 1.3)  # step sizes and ratios at which all D must have the form
ROUND_OFF = 1e-11
SIZES = 1, 2, 1  # of coordinates, constraints, holonomic ones: a system with all kinds of entries


class Split(NamedTuple):
    """Split of a step into a real and a complex system.

    Attributes
    ----------
    structure : of one stage, with the names of the first one's unknowns
    T, inverse : (3, 3)
    stage : whose state is that of the operators
    unknowns : of all stages, one after another
    shapes : of each part of the matrix: the place of the largest entry of D, and D over that entry, whatever h is
    """

    structure: Structure
    T: Array
    inverse: Array
    stage: int
    unknowns: tuple[str, ...]
    shapes: Mapping[Weight, tuple[int, Array]]

    def coefficients(self, step: Step, weight: Weight) -> list[list[Any]]:
        """D of a part of the matrix, (3, 3)."""
        if weight.equation is None or weight.coefficient is None:
            return [[float(i == j) for j in range(STAGES)] for i in range(STAGES)]
        (_, quantity), block = weight.coefficient
        own, equations = len(self.structure.unknowns), len(self.structure.equations)
        blocks = self.unknowns[self.unknowns.index(block) :: own]
        rows = []
        for i, stage in enumerate(step.stages):
            scale, affine = step.equations[weight.equation + i * equations].scale, getattr(stage, quantity)
            rows.append([weight.sign * scale * affine[name] if name in affine else 0.0 for name in blocks])
        return rows

    def weights(self, step: Step, weight: Weight) -> tuple[Any, Any, Any]:
        """γ, α and β of a part of the matrix: those of `shape` times the largest entry of D."""
        D, (place, of) = self.coefficients(step, weight), self.shapes[weight]
        found = self.inverse @ of @ self.T
        largest = D[place // STAGES][place % STAGES]
        gamma, alpha, beta = (
            float(number) * largest if abs(number) > ROUND_OFF else 0.0
            for number in (found[0, 0], found[1, 1], found[2, 1])
        )
        return gamma, alpha, beta

    def valid(self, step: Step) -> bool:
        """Whether all D have the form, and that of `shapes`."""
        for weight in _weights(self.structure):
            D, (place, of) = np.array(self.coefficients(step, weight), dtype=float), self.shapes[weight]
            found = self.inverse @ D @ self.T
            gamma, alpha, beta = found[0, 0], found[1, 1], found[2, 1]
            wanted = np.array([[gamma, 0.0, 0.0], [0.0, alpha, -beta], [0.0, beta, alpha]])
            if not abs(found - wanted).max() <= ROUND_OFF * abs(found).max():
                return False
            if not abs(D - D.flat[place] * of).max() <= ROUND_OFF * abs(D).max():
                return False
        return True


class StageTables(Tables):
    """Tables of one stage, without (Φ_qᵀμ)_q, because μ vanishes with the error of a step."""

    def _entering(self) -> Iterator[OperatorTerm]:
        return (found for found in super()._entering() if found.operator != "Phi_qT_mu_q")


_FOUND: WeakKeyDictionary[Description, Split | None] = WeakKeyDictionary()


def split_of(method: Description) -> Split | None:
    """Return the split of the steps of a method, or None."""
    if method not in _FOUND:
        _FOUND[method] = _split(method)
    return _FOUND[method]


def _split(method: Description) -> Split | None:
    step = method.step(*SAMPLES[0])
    structure = structure_of(Operation(method.state, method.unknowns, step))
    if len(step.stages) != STAGES or Tables(structure, *SIZES).alike_stages != STAGES:
        return None
    one, own = _one_stage(structure), np.eye(STAGES)
    found = Split(one, own, own, STAGES // 2, tuple(method.unknowns), {})
    known = {w: np.array(found.coefficients(step, w), dtype=float) for w in _weights(one)}
    places = {w: int(abs(D).argmax()) for w, D in known.items()}
    found = found._replace(shapes={w: (at, known[w] / known[w].flat[at]) for w, at in places.items()})
    for D in known.values():
        if abs(D - D[0, 0] * own).max() > ROUND_OFF * abs(D).max():
            T = _transformation(D)
            found = found if T is None else found._replace(T=T, inverse=np.linalg.inv(T))
            return found if all(found.valid(method.step(*at)) for at in SAMPLES) else None
    return None


def _transformation(D: Array) -> Array | None:
    """T, if D has one real and two complex eigenvalues."""
    values, vectors = np.linalg.eig(D)
    if np.count_nonzero(abs(values.imag) > ROUND_OFF * abs(values)) != STAGES - 1:
        return None
    x = vectors[:, np.argmax(values.imag)]
    return np.column_stack([vectors[:, np.argmin(abs(values.imag))].real, x.real, -x.imag])


def _one_stage(structure: Structure) -> Structure:
    """The structure of one of the stages; what its quantities have of any stage's unknowns is of its own."""
    own, equations = len(structure.unknowns) // STAGES, len(structure.equations) // STAGES
    names = [name for name, _ in structure.unknowns]
    first = {name: names[n % own] for n, name in enumerate(names)}
    quantities = dict[str, dict[str, None]]()
    for stage in structure.stages:
        for name, blocks in stage:
            found = quantities.setdefault(name, {})
            found |= dict.fromkeys(first[block] for block in blocks if block in first)
    stage = tuple((name, tuple(blocks)) for name, blocks in quantities.items())
    return Structure(structure.state, structure.unknowns[:own], (stage,), structure.equations[:equations], ())


def _weights(structure: Structure) -> Iterator[Weight]:
    """Return the weights of the parts of the matrix of one stage."""
    yield from StageTables(structure, *SIZES).weights
