"""Operators, factors and what numbers give, several states at once, are those of one state after another."""

from __future__ import annotations

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus._jit.pointer import run
from sarrus._jit.vector import LANES
from sarrus.analyses.sensitivity import by_numbers
from sarrus.analyses.sensitivity.block_loop import Entries
from sarrus.analyses.sensitivity.blocks import room
from sarrus.analyses.sensitivity.kernels import GROUPS


@pytest.fixture(scope="module")
def crank() -> sr.System:
    return sr.System(sr.load(mechanisms.path("slider_crank")))


def states(system: sr.System) -> dict[str, np.ndarray]:
    """One state in each lane (lanes, size)."""
    rng = np.random.default_rng(3)
    sizes = {"lam": system.m, "nu": system.m}
    found = {
        n: rng.normal(size=(LANES, sizes.get(n, system.nq))) for n in ("v", "a", "xi", "eta", "lam", "nu")
    }
    near = system.q0 + 0.01 * rng.normal(size=(LANES, system.nq))
    return found | {"t": rng.uniform(size=(LANES, 1)), "q": near}


def side_by_side(x: np.ndarray) -> np.ndarray:
    """The states (lanes, size) in lanes."""
    return np.ascontiguousarray(x.T).reshape(-1)


@pytest.mark.parametrize("kind", Entries._fields)
def test_operators_of_all_lanes_are_those_of_single_states(crank: sr.System, kind: str) -> None:
    names, scalars, arrays = GROUPS[kind]
    group, at = crank.group(*names), states(crank)
    found = [room(len(out)) for out in group.allocate()]
    operands = [side_by_side(at[name]) for name in group.operands]
    run(0, scalars + arrays)(group.entry_in_lanes, crank.b, *operands, *found)
    for lane in range(LANES):
        wanted = group.allocate()
        single = [at[name][lane] if name != "t" else float(at["t"][lane, 0]) for name in group.operands]
        group.run(crank.b, *single, *wanted)
        for name, out, one in zip(names, found, wanted, strict=True):
            assert np.allclose(out.reshape(-1, LANES)[:, lane], one, rtol=1e-12, atol=1e-12), name


def test_what_numbers_give_is_the_product_with_the_operators_by_numbers(crank: sr.System) -> None:
    """μᵀR_b of a step, and R_b b', from the operators by b."""
    at, db = states(crank), np.random.default_rng(4).normal(size=len(crank.b))
    order = [side_by_side(at[name]) for name in ("t", *by_numbers.ADJOINT)]
    by_b, along, rows = room(crank.nb), room(crank.nq), room(crank.m)
    calls, moved = by_numbers.calls(), (True,) * crank.nb
    calls["GRADIENT"](by_numbers.gradient_entry(crank, "step"), crank.b, *order, by_b)
    changes = [side_by_side(at[name]) for name in ("t", *by_numbers.CHANGES[:-1])]
    calls["CHANGE"](by_numbers.change_entry(crank, "step", moved), crank.b, *changes, db, along, rows)
    for lane in range(LANES):
        one = {name: x[lane] for name, x in at.items()}
        t, q, v = float(one["t"][0]), one["q"], one["v"]
        R_b = (
            crank.Phi_qT_lam_b(q, one["lam"], t)
            + crank.M_a_b(q, one["a"])
            - crank.S_b(q, v)
            - crank.Q_b(q, v, t)
        )
        Phi_b = crank.Phi_b(q, t)
        wanted = R_b.T @ one["xi"] + Phi_b.T @ one["nu"]
        assert np.allclose(by_b.reshape(-1, LANES)[:, lane], wanted[: crank.nb], rtol=1e-11, atol=1e-11)
        assert np.allclose(along.reshape(-1, LANES)[:, lane], R_b @ db, rtol=1e-11, atol=1e-10)
        assert np.allclose(rows.reshape(-1, LANES)[:, lane], Phi_b @ db, rtol=1e-11, atol=1e-11)
