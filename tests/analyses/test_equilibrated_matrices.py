"""Are matrices of operators equilibrated, and are their orders of pivots functions of the system alone?"""

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.equations.block_matrix import PRECISE, PlacedMatrix
from sarrus.analyses.equations.motion import KKTMatrix
from sarrus.results import State


def matrix_of(system: sr.System, q: np.ndarray) -> PlacedMatrix:
    matrix = KKTMatrix(system)
    for name in ("M", "Phi_q"):
        matrix.numbers.evaluate((name,), system.b, {"t": 0.0, "q": q})
    return matrix


@pytest.mark.parametrize("name", ["slider_crank", "hmmwv"])
def test_largest_entries_of_scaled_blocks_are_near_1(name: str) -> None:
    """By the scaled matrix itself; each equation has a gradient of that size, displacements in one length."""
    system = sr.System(sr.load(mechanisms.path(name)))
    matrix = matrix_of(system, system.q0)
    rows, columns = matrix._exponents()
    scaled = np.ldexp(abs(matrix.matrix().toarray()), rows[:, None] + columns)
    nq = system.nq
    for block in (scaled[:nq, :nq], scaled[nq:, :nq], scaled[:nq, nq:]):
        assert 0.5 <= block.max() < 1.0
    gradients = scaled[nq:, :nq].max(axis=1)
    assert np.all((0.25 <= gradients) & (gradients < 1.0))
    lengths = columns[:nq].reshape(-1, 7)
    assert np.ptp(lengths[:, :3]) == np.ptp(lengths[:, 3:]) == 0


def test_units_change_exponents_by_their_powers() -> None:
    """A pendulum a thousand times as long: displacements by 2¹⁰ more, to the power of two below."""
    found = []
    for size in (1.0, 1024.0):
        rod = sr.Body("rod", 1.0, (size**2, size**2, size**2), position=(size, 0, 0))
        pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1))
        system = sr.System(sr.Model("pendulum", [rod], [pin]))
        rows, columns = matrix_of(system, system.q0)._exponents()
        found.append(columns[0] - columns[3])
    assert found[1] - found[0] == 10


def test_the_first_order_fits_other_positions() -> None:
    system = sr.System(sr.load("slider_crank"))
    moved = sr.simulate(system, until=3.0).final
    first, there = matrix_of(system, system.q0), matrix_of(system, moved.q)
    for matrix in (first, there):
        matrix.factor(PRECISE)
        right = np.arange(matrix.n, dtype=float)
        np.testing.assert_allclose(matrix.matrix() @ matrix.solve(right), right, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(first.placed.row_place, there.placed.row_place)


def test_a_singular_first_position_has_no_order() -> None:
    """A four-bar whose bars are in line: other positions choose their own pivots."""
    bars = [sr.Body(name, 1.0, (0.1, 0.1, 0.1), position=(x, 0, 0)) for name, x in (("a", 0.5), ("b", 1.5))]
    pins = [
        sr.Revolute("p", sr.ground, bars[0], point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Spherical("s", bars[0], bars[1], point=(1, 0, 0)),
        sr.Distance("d", sr.ground.point(0, 0, 0), bars[1].point(0.5, 0, 0), length=2.0),
    ]
    system = sr.System(sr.Model("in line", bars, pins))
    q = system.q0.copy()
    assert np.linalg.matrix_rank(system.Phi_q(q).toarray()) < system.m
    matrix = matrix_of(system, q)
    assert matrix._lodged() is None


@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()], ids=["radau", "hht"])
def test_runs_do_not_depend_on_runs_before_them(method: sr.Radau | sr.HHT) -> None:
    def run(system: sr.System, start: State | None = None) -> sr.Trajectory:
        return sr.simulate(system, start, until=2.0, method=method)

    used, fresh = (sr.System(sr.load("slider_crank")) for _ in range(2))
    run(used, sr.simulate(used, until=0.7).final)
    for name in ("q", "v", "a", "lam"):
        np.testing.assert_array_equal(getattr(run(used), name), getattr(run(fresh), name))


def test_linearizations_do_not_depend_on_others_before_them() -> None:
    used, fresh = (sr.System(sr.load("slider_crank")) for _ in range(2))
    rest = sr.equilibrium(fresh)
    sr.linearize(used, sr.simulate(used, until=0.7).final)
    again, once = (sr.linearize(system, rest.q) for system in (used, fresh))
    assert again.states == once.states
    np.testing.assert_allclose(again.A, once.A, rtol=1e-12, atol=1e-12)
