"""Overconstrained linkages move: accelerations are unique, multipliers the shortest; contradictions are refused."""

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.analyses import linkages
from tests.analyses.least_reactions import least
from tests.analyses.linkages import Z, chain

import sarrus as sr
from sarrus.analyses.equations.motion import EquationsOfMotion
from sarrus.analyses.redundancy.redundant_constraints import Independence
from sarrus.euler import rotate

# Point (1, -1, 0) of Bricard's linkage at 0.5, 1, 2, 5 and 10 s; computed apart, by least squares.
BRICARD = {
    0.5: (0.77471781, -0.97981505, -0.19990616),
    1.0: (0.27448132, -0.88670794, -0.46233000),
    2.0: (-0.77813537, -0.98035268, -0.19725267),
    5.0: (0.999932742, -0.999999998, -0.0000672554),
    10.0: (0.999730987, -0.999999964, -0.000268976512),
}


def test_bricard_follows_the_reference() -> None:
    times = [0.0, *BRICARD]
    run = sr.simulate(linkages.bricard(), until=10.0, t_eval=times, method=sr.ODE(rtol=1e-10, atol=1e-12))
    assert run.success, run.message
    rod = run["rod_2"]
    ends = [r + rotate(p, np.array([0, -0.5, 0])) for r, p in zip(rod.position, rod.euler, strict=True)]
    assert np.allclose(ends[1:], list(BRICARD.values()), atol=2e-8)
    assert run.violation.max() < 1e-12


@pytest.mark.parametrize("make", [linkages.door, linkages.sarrus, linkages.bennett], ids=lambda m: m.__name__)
def test_overconstrained_linkages_move(make: object) -> None:
    system = make()  # type: ignore[operator]
    run = sr.simulate(system, until=2.0, t_eval=np.linspace(0, 2, 21), method=sr.ODE(rtol=1e-9, atol=1e-11))
    assert run.success, run.message
    assert abs(run.q - run.q[0]).max() > 0.1
    assert run.violation.max() < 1e-12
    energy = [total_energy(system, q, v) for q, v in zip(run.q, run.v, strict=True)]
    assert np.ptp(energy) < 1e-6
    for q, v, a, lam in zip(run.q, run.v, run.a, run.lam, strict=True):
        left = system.M_a(q, a) + system.Phi_qT_lam(q, lam)
        assert np.allclose(left, system.Q(q, v) + system.S(q, v), atol=1e-8)
        assert np.allclose(system.Phi_q_xi(q, a), system.gamma(q, v), atol=1e-8)
        shortest = least(system, q, system.Phi_qT_lam(q, lam))
        assert np.allclose(lam, shortest, atol=1e-7)


def total_energy(system: sr.System, q: np.ndarray, v: np.ndarray) -> float:
    gravity = np.array(system.model.gravity)
    potential = -sum(
        body.mass * gravity @ r for body, r in zip(system.model.bodies, q.reshape(-1, 7)[:, :3], strict=True)
    )
    return float(system.kinetic_energy(q, v) + potential)


def test_accelerations_do_not_depend_on_the_choice() -> None:
    system = linkages.bennett()
    with pytest.warns(sr.SarrusWarning, match="velocity"):
        start = sr.assemble(system, v=np.random.default_rng(1).normal(size=system.nq))
    chosen = Independence(system, start.q).rows
    assert chosen is not None
    want, _ = EquationsOfMotion(system, chosen).acceleration(0.0, start.q, start.v)
    others = 0
    for dropped in np.random.default_rng(2).permutation(20)[:10]:
        J = system.Phi_q(start.q).toarray()
        kept = chosen
        if dropped in chosen:  # exchange one row for one that was left out
            left_out = np.setdiff1d(np.arange(system.m), chosen)
            for row in left_out:
                other = np.sort(np.append(chosen[chosen != dropped], row))
                if np.linalg.svd(J[other], compute_uv=False)[-1] > 1e-3:
                    kept, others = other, others + 1
        a, _ = EquationsOfMotion(system, kept).acceleration(0.0, start.q, start.v)
        assert np.allclose(a, want, atol=1e-8)
    assert others > 3


def test_a_choice_is_renewed_where_it_becomes_poor() -> None:
    system = linkages.bricard()
    independence, motion = Independence(system, system.q0), linkages.bricard()
    run = sr.simulate(motion, until=2.5, t_eval=np.linspace(0, 2.5, 26), method=sr.ODE(rtol=1e-8, atol=1e-10))
    for q in run.q:
        independence.renew(0.0, q)
        kept = system.Phi_q(q)[independence.rows].toarray()
        assert np.linalg.svd(kept, compute_uv=False)[-1] > 1e-3


def test_contradictory_joints_are_refused() -> None:
    system = linkages.contradictory_door()
    run = sr.simulate(system, until=1.0, method=sr.ODE(rtol=1e-8, atol=1e-10))
    assert not run.success
    assert run.status == "inconsistent"
    assert "hinge_2 by 0.05 m" in run.message
    assert len(run.t) == 0


def test_a_velocity_that_leads_nowhere_is_refused() -> None:
    """Two rods in one line between fixed hinges may have a velocity, but no acceleration to go with it."""
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], dtype=float)
    system = chain("stretched", points, np.tile(Z, (3, 1)))
    moving = sr.assemble(system, rates={"hinge_1": 1.0})
    assert moving.success, moving.message
    run = sr.simulate(system, moving, until=1.0, method=sr.ODE(rtol=1e-8, atol=1e-10))
    assert not run.success
    assert run.status == "inconsistent"
    assert "contradict each other as soon as it moves" in run.message


def test_a_crooked_door_is_stuck() -> None:
    system = linkages.crooked_door()
    assert sr.mobility(system).degrees_of_freedom == 0
    with pytest.warns(sr.SarrusWarning, match="nothing can move"):
        run = sr.simulate(system, until=0.5, t_eval=[0.0, 0.5], method=sr.ODE(rtol=1e-8, atol=1e-10))
    assert run.success
    assert np.allclose(run.q[-1], system.q0, atol=1e-9)


@pytest.mark.parametrize(
    ("angle", "method"),
    [
        (1e-9, None), (1e-7, None),
        *(
            pytest.param(10.0**n, by, marks=pytest.mark.slow)
            for n in range(-12, -3) for by in (sr.Radau(), sr.HHT(), sr.HHT(stabilized=True), sr.GeneralizedAlpha())
        ),
    ],
)  # fmt: skip
def test_a_door_with_nearly_aligned_hinges_turns_or_says_so(angle: float, method: Any) -> None:
    """Beside a straight one, whose hinges are not named; a run that fails gives the cause, too."""
    crooked, straight = linkages.crooked_door(angle).model, linkages.door().model
    bodies = [replace(straight.bodies[0], name="other"), *crooked.bodies]
    hinges = [linkages.hinge(f"other_{n}", sr.ground, bodies[0], np.array([0, 0, n]), Z) for n in range(2)]
    both = sr.System(sr.Model("doors", bodies, [*hinges, *crooked.joints], gravity=straight.gravity))
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        run = sr.simulate(both, until=0.5, method=method)
        assert run["panel"].position.shape == (len(run.t), 3)
    messages = [str(one.message) for one in found] + [run.message] * (not run.success)
    if angle < 2e-8:
        assert run.success
        assert not messages
        assert run["panel"].position == pytest.approx(run["other"].position, abs=1e-6)
    assert bool(messages) == (angle > 2e-8)
    assert all("constraints of hinge_1, hinge_2 are nearly dependent at the start" in one for one in messages)


@pytest.mark.filterwarnings("ignore:.*a singular configuration is passed")
def test_running_into_a_branch_ends_with_a_sentence() -> None:
    run = sr.simulate(linkages.parallelogram(), until=3.0, method=sr.ODE(rtol=1e-9, atol=1e-11))
    assert run.success or "become dependent" in run.message


def test_a_dead_centre_names_the_equations_of_the_lock_and_not_those_that_are_redundant_everywhere() -> None:
    z, far = (0, 0, 1), np.sqrt(3.0)
    crank = sr.Body("crank", 1.0, (1, 1, 1), position=(0, 0.5, 0))
    rod = sr.Body("rod", 1.0, (1, 1, 1), position=(far / 2, 0.5, 0))
    slider = sr.Body("slider", 1.0, (1, 1, 1), position=(far, 0, 0))
    joints = [
        sr.Revolute("pin", sr.ground, crank, point=(0, 0, 0), axis=z),
        sr.Revolute("knee", crank, rod, point=(0, 1, 0), axis=z),
        sr.Revolute("wrist", rod, slider, point=(far, 0, 0), axis=z),
        sr.Prismatic("guide", sr.ground, slider, point=(far, 0, 0), axis=(1, 0, 0)),
    ]
    ram = sr.DisplacementDriver("ram", "guide", "2*t")
    system = sr.System(sr.Model("linkage", [crank, rod, slider], joints, drivers=[ram]))
    run, path = sr.simulate(system, until=1.0), sr.kinematics(system, until=1.0)
    assert run.status == "singular configuration"
    rows = run.message.partition("among ")[2].partition(": the mechanism locks there")[0]
    assert {*rows.split(", ")} == {"pin: point x", "knee: point x", "wrist: point x", "ram: displacement"}
    assert {part.partition(" (")[0] for part in path.message.partition("dependent: ")[2].split("), ")} == {
        "pin", "knee", "wrist", "ram"
    }  # fmt: skip
