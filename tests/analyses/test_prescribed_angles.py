"""Driven angles, gears behind them and springs about them have the revolutions of the motion, wherever a run begins."""

from __future__ import annotations

import numpy as np
import pytest

import sarrus as sr

RATE, RATIO, SECOND, K = 12.0, 2.5, -1.3, 3.0
TURNS = {"pa": RATE, "pb": RATIO * RATE, "pc": SECOND * RATIO * RATE}  # [rad/s]
TIMES = (0.0, 0.4, 0.5, 1.0, 1.7)


def train(drives: str = "pa", offset: float = 0.0) -> sr.System:
    """Three wheels in mesh; the middle one winds a spring, whose axis points the other way."""
    wheels = [sr.Body(name, 1, (1, 1, 1), position=(x, 0, 0)) for x, name in enumerate("abc")]
    pins = [
        sr.Revolute(f"p{one.name}", sr.ground, one, point=(x, 0, 0), axis=(0, 0, 1))
        for x, one in enumerate(wheels)
    ]
    gears = [sr.Gear("g1", "pa", "pb", RATIO), sr.Gear("g2", "pb", "pc", SECOND)]
    spring = sr.RSDA("spring", wheels[1], sr.ground, k=K, point=(1, 0, 0), axis=(0, 0, 1))
    motor = sr.AngleDriver("motor", drives, f"{offset} + {TURNS[drives]}*t")
    return sr.System(sr.Model("train", wheels, [*pins, *gears], [spring], drivers=[motor]))


def turned(q: np.ndarray) -> np.ndarray:
    """The orientation matrices' first columns: poses without the sign of Euler parameters."""
    e0, e3 = q.reshape(-1, 7)[:, 3], q.reshape(-1, 7)[:, 6]
    return np.array([e0**2 - e3**2, 2 * e0 * e3]).T


def wanted(t: float) -> np.ndarray:
    angles = np.array([*TURNS.values()]) * t
    return np.array([np.cos(angles), np.sin(angles)]).T


@pytest.mark.one_in(4)
@pytest.mark.parametrize("t", TIMES)
@pytest.mark.parametrize("drives", TURNS)
def test_an_assembly_at_a_time_has_its_revolutions(drives: str, t: float) -> None:
    system = train(drives)
    start = sr.assemble(system, t=t)
    assert turned(start.q) == pytest.approx(wanted(t), abs=1e-9)
    run = sr.simulate(system, start, until=t + 0.3)
    still = sr.kinematics(system, [t, t + 0.3], start)
    for found in (run, still):
        for name, rate in TURNS.items():
            angles = found.joint(name).angle
            assert (angles[0], angles[-1]) == pytest.approx((rate * t, rate * (t + 0.3)), abs=1e-6)
        energy = 0.5 * K * (TURNS["pb"] * t) ** 2
        assert found.potential_energy[0] == pytest.approx(energy, rel=1e-9, abs=1e-12)
    assert sr.equilibrium(system, start.q, t=t).q == pytest.approx(start.q, abs=1e-9)


def test_a_motion_that_begins_some_turns_away_has_them() -> None:
    """Three turns ahead of the initial pose."""
    ahead = 6 * np.pi + 0.1
    run = sr.simulate(train(offset=ahead), sr.assemble(train(offset=ahead), np.array(train().q0)), until=0.1)
    assert run.joint("pa").angle[0] == pytest.approx(ahead)
    assert run.joint("pc").angle[0] == pytest.approx(SECOND * RATIO * ahead)


def test_gears_without_a_motor_go_on_from_any_state() -> None:
    """Half a turn of the second wheel is lost where the first one's turns are."""
    system = sr.System(sr.Model("free", *(getattr(train().model, n) for n in ("bodies", "joints"))))
    run = sr.simulate(system, {"rates": {"pa": RATE}}, until=1.0, t_eval=np.linspace(0, 1, 11))
    for t in (0.4, 0.6, 1.0):
        state = run.state(float(run.t[np.argmin(abs(run.t - t))]))
        again = sr.simulate(system, state, until=state.t + 0.1)
        assert not again.warnings
        assert again.q[0] == pytest.approx(state.q, abs=1e-9)
        assert again.joint("pb").angle[-1] == pytest.approx(RATIO * RATE * (state.t + 0.1), rel=1e-4)


@pytest.mark.parametrize("t", [0.4, 1.7])
def test_the_derivative_by_a_ratio_counts_all_turns(t: float) -> None:
    system = train()
    start = sr.assemble(system, sr.assemble(system, t=t).q, t=t)
    found = sr.AssemblyDerivatives(system, start)
    place = system.parameter_names.index("g1[coupling].ratio")
    q_dot = found.q_b(np.eye(1, len(system.b), place)[0]).reshape(-1, 7)
    q = start.q.reshape(-1, 7)
    by_ratio = 2 * (q[:, 3] * q_dot[:, 6] - q[:, 6] * q_dot[:, 3])
    assert by_ratio == pytest.approx([0.0, RATE * t, SECOND * RATE * t], abs=1e-8)


def test_screws_and_racks_pass_turns_on() -> None:
    """A driven rack turns its pinion, which winds a spring; a driven nut its screw."""
    rack, pinion = sr.Body("rack", 1, (1, 1, 1)), sr.Body("pinion", 1, (1, 1, 1), position=(0, 1, 0))
    slide = sr.Translational("slide", sr.ground, rack, point=(0, 0, 0), axis=(1, 0, 0))
    pin = sr.Revolute("pin", sr.ground, pinion, point=(0, 1, 0), axis=(0, 0, 1))
    mesh = sr.RackAndPinion("mesh", "slide", "pin", 0.2)
    spring = sr.RSDA("spring", sr.ground, pinion, k=K, point=(0, 1, 0), axis=(0, 0, 1))
    drive = sr.DisplacementDriver("drive", "slide", "1.5*t")
    system = sr.System(sr.Model("rack", [rack, pinion], [slide, pin, mesh], [spring], drivers=[drive]))
    for t in TIMES:
        run = sr.simulate(system, sr.assemble(system, t=t), until=t + 0.2)
        assert abs(run.joint("pin").angle[0]) == pytest.approx(1.5 * t / 0.2, abs=1e-8)
        assert run.potential_energy[0] == pytest.approx(0.5 * K * (1.5 * t / 0.2) ** 2, rel=1e-9, abs=1e-12)
