"""Long chains: what runs in linear time and memory for ten links does so for thousands."""

import numpy as np
import pytest

import sarrus as sr
from sarrus.linalg.rank import rank_of
from sarrus.linalg.sparse_solver import SparseLU


@pytest.fixture(scope="module")
def chain() -> sr.System:
    n = 4000
    rods = [
        sr.Body(f"rod_{k}", mass=1, inertia=(1 / 1200, 1 / 12, 1 / 12), position=(k + 0.5, 0, 0))
        for k in range(n)
    ]
    pairs = enumerate(zip([sr.ground, *rods], rods, strict=False))
    pins = [sr.Revolute(f"pin_{k}", i, j, point=(float(k), 0, 0), axis=(0, 0, 1)) for k, (i, j) in pairs]
    return sr.System(sr.Model("chain", rods, pins, gravity=(0, -9.81, 0)))


@pytest.mark.slow
def test_small_singular_values_of_a_long_chain_are_not_zero(chain: sr.System) -> None:
    rank = rank_of(chain.Phi_q(chain.q0))
    assert rank.rank == chain.m
    assert rank.smallest == pytest.approx(1.243 / len(chain.bodies) ** 2, rel=0.01)


@pytest.mark.slow
def test_a_long_chain_falls(chain: sr.System, monkeypatch: pytest.MonkeyPatch) -> None:
    fills: list[float] = []
    choose = SparseLU.repivot

    def counted(self: SparseLU, data: np.ndarray) -> None:
        choose(self, data)
        fills.append(len(self.rows) / len(data))

    monkeypatch.setattr(SparseLU, "repivot", counted)
    run = sr.simulate(chain, until=0.01, t_eval=[0.01], method=sr.GeneralizedAlpha(0.9, step=0.005))
    assert run.success, run.message
    assert fills
    assert max(fills) < 2.5
    tip = run.q[-1].reshape(-1, 7)[-1, 1]
    assert tip == pytest.approx(-0.5 * 9.81 * 0.01**2, rel=1e-3)  # rods far from the ground fall freely
