"""`mobility` against the rank at nearby configurations reached by assembly, in any units, every joint given twice."""

import numpy as np
import pytest
from tests.verdicts.random_mechanisms import KINDS, mechanism

import sarrus as sr

UNITS = [(1e-6, 1e-9), (1e4, 1e6), (1e-6, 1e6), (1e4, 1e-9)]


def rank_nearby(system: sr.System, q: np.ndarray, length: float, seed: int) -> int:
    """The largest rank at configurations a little away, by NumPy, in metres that are the system's length."""
    random, D = np.random.default_rng(seed), np.tile(np.repeat([length, 1.0], (3, 4)), len(q) // 7)
    ranks = []
    for _ in range(3):
        there = sr.assemble(system, q + 0.03 * D * random.normal(size=len(q)), metric=1 / D**2)
        assert there.success, there.message
        J = system.Phi_q(there.q).toarray() * D
        ranks.append(np.linalg.matrix_rank(J / np.linalg.norm(J, axis=1, keepdims=True), tol=1e-7))
    return max(ranks)


@pytest.mark.one_in(6)
@pytest.mark.filterwarnings("ignore:.*assembly changed")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("block", range(2))
def test_random_mechanisms(kind: str, block: int) -> None:
    for seed in range(25 * block, 25 * block + 25):
        copies = 1 + seed % 2
        system = mechanism(seed, kind, copies=copies).system()
        found = sr.mobility(system)
        rank = rank_nearby(system, sr.assemble(system).q, 1.0, seed)
        told = (kind, seed, str(found))
        assert found.degrees_of_freedom == found.finite == system.nq - rank, told
        assert found.kind == ("redundant" if found.redundant else "regular"), told
        assert (found.redundant > 0) == (copies > 1 or kind in ("planar", "spherical")), told
        length, mass = UNITS[seed % 4]
        other = sr.mobility(mechanism(seed, kind, copies=copies, length=length, mass=mass).system())
        assert (other.kind, other.finite, other.redundant) == (found.kind, found.finite, found.redundant), (
            told
        )
