"""Operators, factors and what numbers give, several states at once, are those of one state after another."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from scipy.sparse import vstack

import sarrus as sr
from sarrus import mechanisms
from sarrus._jit.kernels.pointer import call_kernels
from sarrus._jit.kernels.vector import LANES
from sarrus._jit.linking.link import link
from sarrus.analyses.dynamics.methods.equations import GROUPS
from sarrus.analyses.dynamics.methods.tables import DRIVERS
from sarrus.analyses.sensitivity.lagrangians import by_parameters as by_numbers
from sarrus.analyses.sensitivity.steps.block_loop import UNKNOWN
from sarrus.analyses.sensitivity.steps.changes import changes
from sarrus.analyses.sensitivity.steps.record import STEP, Record
from sarrus.analyses.sensitivity.steps.sweep_loop import CHANGE, solve_lane, solve_lane_transposed
from sarrus.linalg.columns_loop import COLUMNS
from sarrus.linalg.lanes_loop import factor_lanes
from sarrus.linalg.panel_loop import Factors, Pattern
from sarrus.linalg.row_order import by_rows, unsigned
from sarrus.system.curves import lanes
from sarrus.system.curves.lanes import aligned, buffer


@pytest.fixture(scope="module")
def crank() -> sr.System:
    return sr.System(sr.load(mechanisms.path("slider_crank")))


def states(system: sr.System) -> dict[str, np.ndarray]:
    """One state in each lane (lanes, size)."""
    rng = np.random.default_rng(3)
    sizes = {"lam": system.m, "nu": system.m}
    found = {n: rng.normal(size=(LANES, sizes.get(n, system.nq))) for n in ("v", "a", "xi", "lam", "nu")}
    near = system.q0 + 0.01 * rng.normal(size=(LANES, system.nq))
    return found | {"t": rng.uniform(size=(LANES, 1)), "q": near}


def side_by_side(x: np.ndarray) -> np.ndarray:
    """The states (lanes, size) in lanes."""
    return np.ascontiguousarray(x.T).reshape(-1)


@pytest.mark.parametrize("kind", DRIVERS)
def test_operators_of_all_lanes_are_those_of_single_states(crank: sr.System, kind: str) -> None:
    names = GROUPS[kind]
    group, at = crank.group(*names), states(crank)
    found = [buffer(len(out)) for out in group.allocate()]
    operands = [side_by_side(at[name]) for name in group.operands]
    call_kernels(group.entry_in_lanes, crank.b, *operands, *found)
    for lane in range(LANES):
        wanted = group.allocate()
        single = [at[name][lane] if name != "t" else float(at["t"][lane, 0]) for name in group.operands]
        group.run(crank.b, *single, *wanted)
        for name, out, one in zip(names, found, wanted, strict=True):
            assert np.allclose(out.reshape(-1, LANES)[:, lane], one, rtol=1e-12, atol=1e-12), name


def by_numbers_of_step(system: sr.System, one: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """R_b of the equations of motion and of the constraints at one state, from the operators by the numbers."""
    t, q, v = float(one["t"][0]), one["q"], one["v"]
    loads = system.S_b(q, v) + system.Q_b(q, v, t)
    return system.Phi_qT_lam_b(q, one["lam"], t) + system.M_a_b(q, one["a"]) - loads, system.Phi_b(q, t)


def test_what_numbers_give_is_the_product_with_the_operators_by_numbers(crank: sr.System) -> None:
    """μᵀR_b of a step."""
    at, by_b = states(crank), buffer(crank.nb)
    order = [side_by_side(at[name]) for name in ("t", *by_numbers.ADJOINT)]
    call_kernels(by_numbers.gradient_entry(crank, "step"), crank.b, *order, by_b)
    for lane in range(LANES):
        one = {name: x[lane] for name, x in at.items()}
        R_b, Phi_b = by_numbers_of_step(crank, one)
        wanted = R_b.T @ one["xi"] + Phi_b.T @ one["nu"]
        assert np.allclose(by_b.reshape(-1, LANES)[:, lane], wanted[: crank.nb], rtol=1e-11, atol=1e-11)


def factored(n: int) -> tuple[np.ndarray, list[Factors], np.ndarray]:
    """Full matrices, one in each lane, the first pivot of the last one does not suit; their factors and the growth."""
    matrices = np.random.default_rng(5).normal(size=(LANES, n, n)) + 4 * np.eye(n)
    matrices[-1, 0, 0] = 1e-7
    pattern, full = np.arange(0, n * n + 1, n), np.tile(np.arange(n), n)
    pointers, indices, diagonal, ends = unsigned((pattern, full, (n + 1) * np.arange(n), np.full(n, n)))
    factor = link(factor_lanes)
    size = -(-n * n // LANES) * LANES
    factors, data, growth = buffer(size), buffer(size), buffer(1)
    data[: n * n * LANES] = side_by_side(matrices.transpose(0, 2, 1).reshape(LANES, -1))
    order = unsigned([np.arange(n)])[0]
    places = Pattern(pointers, indices, pointers, indices, diagonal, ends, order, order)
    factor(places, data, factors, buffer(n), growth)
    found = []
    for lane in range(LANES):
        own, numbers = (x.reshape(-1, LANES)[:, lane].copy() for x in (factors, data))
        found.append(Factors(places, numbers, own))
    return matrices, found, growth


def test_a_solution_is_refined_where_factors_have_grown() -> None:
    """It is solved for with pivots that do not suit all the same."""
    n = 5
    (matrices, factors, growth), right = factored(n), np.random.default_rng(6).normal(size=(n, 1))
    squares = [(np.tril(without_pivoting(A), -1) ** 2).sum() for A in matrices]
    assert np.allclose(growth, 1 + np.array(squares), rtol=1e-9)
    solve, refined, found = (
        link(solve_lane_transposed),
        np.array([0.0, growth[0], 1e-12]),
        np.zeros((n, 1)),
    )
    for lane, A in enumerate(matrices):
        solve(factors[lane], refined, growth[lane], right, found, np.zeros((3, n, 1)))
        assert np.allclose(A.T @ found, right, rtol=0, atol=1e-14 * abs(A).max() * abs(found).max())
        assert (refined[CHANGE] > 0.0) == (lane == LANES - 1)  # the last relative change


def test_panels_are_refined_in_the_first_lane_and_where_factors_have_grown() -> None:
    """What is told is the largest change of any panel that was refined; the first one needs none."""
    (matrices, factors, growth), told = factored(5), []
    solve, refined = link(solve_lane), np.array([UNKNOWN, 0.0, 1e-12])
    right, found, work = (aligned(*shape, COLUMNS) for shape in ((5,), (5,), (3, 5)))
    for lane, A in enumerate(matrices):
        for own in (np.zeros(right.shape), np.random.default_rng(7).normal(size=right.shape)):
            right[:] = own
            rows = by_rows(factors[lane].pattern)
            solve(factors[lane], rows.upper, rows.whole, refined, growth[lane], lane > 0, right, found, work)
            assert np.allclose(A @ found, right, rtol=0, atol=1e-14 * abs(A).max() * abs(found).max())
            told.append(refined[CHANGE])
    assert told[0] == UNKNOWN  # zeros do not test the factors
    assert 0.0 < told[1] < 1e-12 < told[-1] < UNKNOWN
    assert set(told[1:-1]) == {told[1]}


def without_pivoting(A: np.ndarray) -> np.ndarray:
    """L below the diagonal, U above."""
    A = A.copy()
    for k in range(len(A)):
        A[k + 1 :, k] /= A[k, k]
        A[k + 1 :, k + 1 :] -= np.outer(A[k + 1 :, k], A[k, k + 1 :])
    return A


def test_what_changes_of_numbers_do_is_found_element_by_element(crank: sr.System) -> None:
    """R_b b' of a step, of columns that change nothing, one number, some and all, in panels of two columns."""
    at, random, width = states(crank), np.random.default_rng(4), 2
    dots = random.normal(size=(5, len(crank.b)))
    dots[0], dots[1, np.arange(len(crank.b)) != 30], dots[2, random.random(len(crank.b)) < 0.9] = 0, 0, 0
    run = sr.simulate(crank, until=1e-3, store="steps", method=sr.HHT())
    tables = Record(crank, run.steps).operations[STEP].tables
    moved = changes(crank, [None, tables, None], dots, width)
    order = [side_by_side(at[name]) for name in ("t", *by_numbers.CHANGES[:-1])]
    for column, element, _, first, last in moved.calls.values:
        every, out = moved.entry, moved.results[first * LANES : last * LANES]
        own = every._replace(
            addresses=every.addresses[element : element + 1], starts=every.starts[element : element + 2]
        )
        call_kernels(own, crank.b, *order, dots[column], out, out)
    assert 0 < len(moved.calls.values) < len(dots) * sum(p.count for p in crank.populations)
    for lane in range(LANES):
        R_b, Phi_b = by_numbers_of_step(crank, {name: x[lane] for name, x in at.items()})
        wanted = vstack([R_b, Phi_b]) @ dots.T
        for p in range(3):
            part = slice(*moved.places.starts[moved.panels + p : moved.panels + p + 2])
            panel, chosen = np.zeros((crank.nq + crank.m, width)), moved.chosen.values[part]
            np.add.at(
                panel.reshape(-1), moved.places.values[part], moved.results.reshape(-1, LANES)[chosen, lane]
            )
            own = wanted[:, width * p : width * (p + 1)]
            assert np.allclose(panel[:, : own.shape[1]], own, rtol=1e-11, atol=1e-10)


def test_room_is_given_again_when_nobody_holds_it() -> None:
    size = lanes.SMALL + 3
    first = lanes.used(7, size)
    place, first[:] = first.ctypes.data, 1.0
    row = first[2, 5:]  # holds it, too
    del first
    other = lanes.used(7, size)
    assert other.ctypes.data != place
    row[:] = 2.0
    del row
    again = lanes.aligned(7, size)
    assert again.ctypes.data == place
    assert not again.any()
    assert place % lanes.LINE == 0
    assert again.shape == (7, size)


def test_room_that_is_kept_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lanes, "_LENT", [])
    monkeypatch.setattr(lanes, "MOST", 5 * lanes.SMALL)
    held = [lanes.used(2 * lanes.SMALL) for _ in range(4)]
    assert len({x.ctypes.data for x in held}) == 4
    assert sum(map(len, lanes._LENT)) <= lanes.MOST
    lanes.used(lanes.LARGE), lanes.used(lanes.SMALL - lanes.LINE)
    assert sum(map(len, lanes._LENT)) <= lanes.MOST


@pytest.mark.slow
@pytest.mark.skipif("SARRUS_LANES" in os.environ, reason="it is this layout that is tested")
def test_layout_of_other_processors() -> None:
    """Four lanes, as without AVX-512, where there are eight here, and eight where there are four."""
    names = "operators_of_all_lanes or what_numbers_give or factors_have_grown"
    command = [sys.executable, "-m", "pytest", "-q", __file__, "-k", names, "-p", "no:cacheprovider"]
    settings = {"SARRUS_LANES": str({8: 4, 4: 8}[LANES])}
    done = subprocess.run(command, env=os.environ | settings, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
