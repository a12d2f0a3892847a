"""The shipped mechanisms: counts of the paper, assembled poses, and the numbers they were typed from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from sarrus import mechanisms
from sarrus.model import ModelError, load
from sarrus.model.expansion.blueprint import Blueprint, blueprint

ROWS = {"Spherical": 3, "Dot1": 1, "Dot2": 1, "Distance": 1}


def plan_of(name: str) -> Blueprint:
    """Return the blueprint of a shipped mechanism."""
    return blueprint(load(mechanisms.path(name)))


def counts(plan: Blueprint) -> Counter[str]:
    """Return how many elements of each class there are."""
    return Counter(placed.element.__name__ for placed in plan.placed)


def equations(plan: Blueprint) -> int:
    """Return the number of joint equations."""
    return sum(ROWS.get(name, 0) * number for name, number in counts(plan).items())


def test_the_mechanisms_are_these() -> None:
    assert mechanisms.names() == ("car", "hmmwv", "hmmwv_driving", "slider_crank")
    assert mechanisms.suspensions() == (
        "double_wishbone", "macpherson", "multi_link", "solid_axle", "trailing_arm",
    )  # fmt: skip
    with pytest.raises(ModelError, match=r'no shipped mechanism "slider-crank". Did you mean "slider_crank"'):
        mechanisms.path("slider-crank")


def test_slider_crank_has_the_papers_counts() -> None:
    plan = plan_of("slider_crank")
    assert plan.bodies == ("crank", "rod", "slider")
    assert plan.q.size == 21
    assert equations(plan) == 17
    owners = Counter(placed.owner for placed in plan.placed if placed.element.__name__ in ROWS)
    assert owners == {"pin": 3, "ball": 1, "cross": 2, "guide": 5}


def test_hmmwv_has_the_papers_counts() -> None:
    plan = plan_of("hmmwv")
    assert len(plan.bodies) == 14
    assert plan.q.size == 98
    assert equations(plan) == 73
    kinds = counts(plan)
    assert {name: kinds[name] for name in ROWS} == {"Spherical": 16, "Distance": 4, "Dot1": 19, "Dot2": 2}
    assert (kinds["TSDA"], kinds["Tyre"]) == (8, 4)
    assert 98 - 73 - 14 == 11


@pytest.mark.parametrize("name", [*mechanisms.names(), *mechanisms.suspensions()])
def test_they_start_assembled_at_rest(name: str, largest_phi: Callable[[Blueprint], float]) -> None:
    plan = plan_of(name)
    assert largest_phi(plan) < 1e-14
    assert not plan.v.any()
    p = plan.q.reshape(-1, 7)[:, 3:]
    np.testing.assert_allclose(np.sum(p * p, axis=1), 1.0, atol=1e-15)


def test_slider_crank_has_the_lengths_it_is_known_by(places: Callable[[Blueprint], Any]) -> None:
    plan = plan_of("slider_crank")
    at = places(plan)
    ball = next(one for one in plan.placed if one.owner == "ball")
    pin = next(one for one in plan.placed if one.owner == "pin")
    B, C = at.point(1, ball.values[0]), at.r[3]
    assert np.linalg.norm(B - at.point(0, pin.values[0])) == pytest.approx(2.0, abs=1e-14)
    assert np.linalg.norm(C - B) == pytest.approx(5.0, abs=1e-14)
    np.testing.assert_allclose(C, (4.172214269048909, 0, 0), atol=1e-15)
    np.testing.assert_allclose(at.r[2], (B + C) / 2, atol=1e-15)
    assert plan.q[10:14] == pytest.approx(
        [0.001418573239, -0.957715727424, 0.004722673584, 0.287673894278], abs=1e-12
    )


def test_hmmwv_starts_in_equilibrium(places: Callable[[Blueprint], Any]) -> None:
    """Springs and tyres carry the loads of the reference equilibrium."""
    plan = plan_of("hmmwv")
    at = places(plan)
    tension = {}
    for one in plan.placed:
        if one.element.__name__ == "TSDA":
            s_i, s_j, k, _, length, _ = one.values
            l = np.linalg.norm(at.point(one.bodies[1], s_j) - at.point(one.bodies[0], s_i))
            tension[one.owner] = k * (l - length)
        if one.element.__name__ == "Tyre":
            s, k, _, radius, road = one.values
            tension[one.owner] = k * (radius - at.point(one.bodies[0], s)[2] + road)
    assert tension["spring_front_left"] == pytest.approx(-11867.672538, abs=1e-5)
    assert tension["spring_rear_right"] == pytest.approx(-10761.939331, abs=1e-5)
    assert tension["tyre_front_right"] == pytest.approx(6533.331218, abs=1e-5)
    assert tension["tyre_rear_left"] == pytest.approx(6106.481002, abs=1e-5)
    mass = sum(one.values[0] for one in plan.placed if one.element.__name__ == "RigidInertia")
    loads = sum(force for name, force in tension.items() if name.startswith("tyre"))
    assert mass == pytest.approx(2576.924, abs=1e-9)
    assert loads == pytest.approx(9.81 * mass, abs=1e-8)


def test_hmmwv_is_symmetric_and_its_tie_rods_have_the_lengths_of_the_hard_points() -> None:
    plan = plan_of("hmmwv")
    lengths = {one.owner: one.values[2] for one in plan.placed if one.element.__name__ == "Distance"}
    for side in ("left", "right"):
        assert lengths[f"tierod_front_{side}"] == pytest.approx(0.38653706063212107, abs=1e-15)
        assert lengths[f"tierod_rear_{side}"] == pytest.approx(0.41411646980384637, abs=1e-15)
    r = dict(zip(plan.bodies, plan.q.reshape(-1, 7)[:, :3]))
    for name, right in r.items():
        left = r[name.replace("right", "left")]
        np.testing.assert_allclose(abs(left), abs(right), atol=1e-14)
