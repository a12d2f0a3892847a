"""What a motion is between the ends of two steps: polynomials of their degrees are kept, and gradients use the same."""

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.dynamics.dense_output.sampler import Sampler
from sarrus.analyses.dynamics.stepping.nodes import between
from sarrus.analyses.dynamics.stepping.stepper import independence_at
from sarrus.analyses.sensitivity.sampling.sampling import interpolation

RNG = np.random.default_rng(4)
H = 0.3


def inside(ends: list[np.ndarray], s: float, apart: bool) -> np.ndarray:
    found = np.zeros((3, len(ends[0])))
    between(*ends, s, H, apart, *found)
    return found


@pytest.mark.parametrize("s", [0.0, 0.2, 0.7, 1.0])
def test_a_motion_of_degree_five_is_kept(s: float) -> None:
    motion = np.polynomial.Polynomial(RNG.normal(size=6))
    orders = [motion, motion.deriv(), motion.deriv(2)]
    ends = [np.array([x(t)]) for t in (0.0, H) for x in orders]
    assert inside(ends, s, False)[:, 0] == pytest.approx([x(s * H) for x in orders], abs=1e-12)


@pytest.mark.parametrize("s", [0.0, 0.2, 0.7, 1.0])
def test_apart_a_velocity_need_not_be_the_slope_of_the_position(s: float) -> None:
    """Only at the ends: q is of degree three through them, v is any cubic with the same values there."""
    velocity = np.polynomial.Polynomial(RNG.normal(size=4))
    v0, v1 = velocity(0.0), velocity(H)
    d = RNG.normal()
    c = (v1 - v0) / (2 * H) - 1.5 * d * H
    position = np.polynomial.Polynomial([0.4, v0, c, d])
    orders = [position, velocity, velocity.deriv()]
    ends = [np.array([x(t)]) for t in (0.0, H) for x in orders]
    assert inside(ends, s, True)[:, 0] == pytest.approx([x(s * H) for x in orders], abs=1e-12)


@pytest.mark.parametrize("apart", [False, True])
def test_gradients_use_the_same_weights_and_their_slopes(apart: bool) -> None:
    ends, s, e = RNG.normal(size=(6, 2)), 0.37, 1e-4
    weights = interpolation(np.array([s]), np.array([H]), apart)
    kinds = (0, 1) if apart else (0, 1, 2)  # accelerations are interpolated through several nodes
    nodes = ends.reshape(2, 3, 2)
    value, slope, bend = (np.einsum("kel,eln->kn", part[0], nodes)[list(kinds)] for part in weights)
    ahead, middle, behind = (inside(list(ends), s + d, apart)[list(kinds)] for d in (e / H, 0.0, -e / H))
    assert value == pytest.approx(middle, abs=1e-12)
    assert slope == pytest.approx((ahead - behind) / (2 * e), rel=1e-4)
    assert bend == pytest.approx((ahead - 2 * middle + behind) / e**2, rel=1e-3, abs=1e-4 * abs(bend).max())


def test_pivots_of_another_state_are_chosen_anew() -> None:
    """A crank at half a turn after one at its start, where the pivot of its normalization is zero."""
    crank = sr.Body("crank", 1.0, (1, 1, 1))
    hinge = sr.Revolute("hinge", sr.ground, crank, point=(0, 0, 0), axis=(0, 0, 1))
    system = sr.System(sr.Model("crank", [crank], [hinge], gravity=(0, -9.81, 0)))
    start = sr.assemble(system)
    sampler = Sampler(system, independence_at(system, start), system.b)
    half = start.q.copy()
    half[3:7] = 0, 0, 0, 1
    for q in (start.q, half, start.q):
        state = sampler.state_at(0.0, q.copy(), start.v, np.zeros(0))
        assert np.isfinite(state.a).all()
        assert np.isfinite(state.lam).all()
