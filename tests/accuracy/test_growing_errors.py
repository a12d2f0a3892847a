"""Runs of chaotic and unstable motions say from when on their digits are lost; regular ones say nothing."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sarrus as sr
from sarrus.analyses.dynamics.integrators.radau import Radau
from sarrus.analyses.dynamics.stepping.stepper import Settings
from sarrus.analyses.dynamics.stepping.tolerance import Tolerances
from sarrus.analyses.dynamics.time_loop.error_growth import ErrorGrowth, lost_digits
from sarrus.functions import cos

MESSAGE = "errors have grown beyond"


def double_pendulum(mass: float = 1.0) -> sr.System:
    """Two bodies of 1 m, from the horizontal."""
    one = sr.Body("a", mass, (0.1,) * 3, position=(0.5, 0, 0))
    two = sr.Body("b", 1.0, (0.1,) * 3, position=(1.5, 0, 0))
    pins = [
        sr.Revolute("A", sr.ground, one, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Revolute("B", one, two, point=(1, 0, 0), axis=(0, 0, 1)),
    ]
    return sr.System(sr.Model("double pendulum", [one, two], pins, gravity=(0, -9.81, 0)))


def pendulum(start: float, rate: float = 0.0) -> tuple[sr.System, Any]:
    """A ball on a rod of 1 m, at an angle in degrees from its lowest position."""
    angle = np.radians(start)
    bob = sr.Body("bob", 1.0, (1e-3,) * 3, position=(np.sin(angle), 0, -np.cos(angle)))
    pin = sr.Revolute("pin", sr.ground, bob, point=(0, 0, 0), axis=(0, -1, 0))
    system = sr.System(sr.Model("pendulum", [bob], [pin], gravity=(0, 0, -9.81)))
    return system, sr.assemble(system, rates={"pin": rate})


def messages(run: sr.Trajectory) -> list[str]:
    return [one for one in run.warnings if MESSAGE in one]


def test_a_chaotic_run_says_from_when_on_it_is_wrong() -> None:
    """The time is that at which a run with far smaller tolerances is away by a thousandth."""
    system = double_pendulum()
    with pytest.warns(sr.SarrusWarning, match=MESSAGE):
        run = sr.simulate(system, until=30.0)
    (message,) = messages(run)
    told = float(message.split("from t = ")[1].split(" s")[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fine = sr.simulate(system, until=30.0, rtol=1e-12)
    error = abs(run.output("b.x").values - fine.output("b.x").values) / 3.0
    late = run.t[np.flatnonzero(error > 1e-3)[0]]
    assert told == pytest.approx(late, abs=3.0)
    assert told < 25.0
    assert not messages(sr.simulate(system, until=5.0))


def test_other_methods_say_so_too() -> None:
    with pytest.warns(sr.SarrusWarning, match=MESSAGE):
        sr.simulate(double_pendulum(), until=30.0, method=sr.HHT())


@pytest.mark.parametrize(("start", "wrong"), [(179.9, True), (90.0, False), (30.0, False)])
def test_a_pendulum_is_unstable_at_the_top_only(start: float, wrong: bool) -> None:
    system, begin = pendulum(start)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = sr.simulate(system, begin, until=10.0 if wrong else 100.0)
    assert bool(messages(run)) == wrong


def test_a_saved_run_has_the_same_warning(tmp_path: Path) -> None:
    system = double_pendulum()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        whole = sr.simulate(system, until=30.0)
        cut = sr.simulate(system, until=30.0, save=tmp_path / "run", time_limit=1e-3)
        resumed = sr.resume(tmp_path / "run")
    assert cut.status == "time limit"
    assert messages(whole) == messages(resumed) == messages(sr.load_run(tmp_path / "run")) != []


@pytest.mark.parametrize(("start", "rate"), [(120.0, 0.5), (30.0, 2.0)])
def test_the_perturbation_is_that_of_neighbouring_runs(start: float, rate: float) -> None:
    """By differences of runs with other velocities at the start; steps are so short that a second order suffices."""
    small, until = 1e-4, 3.0
    begins = [pendulum(start, rate + change) for change in (-small, 0.0, small)]
    runs = [sr.simulate(*begin, until=until, max_step=2e-3, dense_output=True) for begin in begins]
    system, begin = begins[1]
    tolerances = Tolerances.of(system, 1e-9, None)
    growth = ErrorGrowth(system, Radau().stepper(system, begin, Settings(tolerances)), tolerances)
    own = growth._own
    own.random[:] = 0.0
    change = [(getattr(runs[2], name)[0] - getattr(runs[0], name)[0]) / (2 * small) for name in ("q", "v")]
    own.q[:], own.v[:] = change
    growth.look(runs[1].sol._nodes)  # type: ignore[union-attr]
    truth = (runs[2].q[-1] - runs[0].q[-1]) / (2 * small)
    assert own.q == pytest.approx(truth, abs=0.03 * abs(truth).max())


def bouncing(*balls: sr.Body) -> sr.System:
    return sr.System(sr.Model("bouncing", bodies=balls, gravity=(0, 0, -9.81)))


def ball(name: str, mass: float, **start: Any) -> sr.Body:
    return sr.Body(name, mass=mass, inertia=(1e-3,) * 3, **start)


def warned_at(run: sr.Trajectory) -> float:
    (message,) = messages(run)
    return float(message.split("from t = ")[1].split(" s")[0])


def table(until: float) -> sr.Trajectory:
    """A ball on a table that shakes, which is struck at other phases as soon as it is off by a little."""
    shaken = sr.Event("ball.z - 0.05*sin(18*t)", direction=-1, reset=sr.Impact(0.9))
    begin = ball("ball", 1.0, position=(0, 0, 0.6))
    return sr.simulate(bouncing(begin), until=until, events=shaken, t_eval=np.linspace(0, until, 401))


def exact_table(times: np.ndarray) -> list[float]:
    """Places of the same ball with 60 digits."""
    with mpmath.workdps(60):
        m, found, left = mpmath, list[float](), [float(t) for t in times]
        t, z, v, g = m.mpf(0), m.mpf("0.6"), m.mpf(0), m.mpf("9.81")
        while left:
            flight = lambda x: z + v * (x - t) - g / 2 * (x - t) ** 2  # noqa: B023, E731
            gap = lambda x: flight(x) - m.mpf("0.05") * m.sin(18 * x)  # noqa: B023, E731
            low = t + m.mpf("1e-4")
            while gap(low + m.mpf("0.002")) > 0:
                low += m.mpf("0.002")
            hit = m.findroot(gap, (low, low + m.mpf("0.002")), solver="anderson", tol=m.mpf(10) ** -100)
            while left and left[0] <= hit:
                found.append(float(flight(m.mpf(left.pop(0)))))
            own = m.mpf("0.9") * m.cos(18 * hit)
            t, z, v = hit, flight(hit), own - m.mpf("0.9") * (v - g * (hit - t) - own)
        return found


@pytest.mark.slow
def test_impacts_that_tell_neighbours_apart_say_so() -> None:
    """Each flight is exact with any tolerance: only the rounding of times of impacts grows."""
    with pytest.warns(sr.SarrusWarning, match=MESSAGE):
        run = table(24.0)
    error = abs(run["ball"].position[:, 2] - exact_table(run.t)) / np.ptp(run["ball"].position[:, 2])
    late = run.t[np.flatnonzero(error > 1e-3)[0]]
    assert warned_at(run) == pytest.approx(late, abs=2.0)
    assert not messages(table(8.0))


def test_impacts_of_regular_motions_say_nothing() -> None:
    floor = sr.Event("ball.z", direction=-1, reset=sr.Impact(1.0))
    run = sr.simulate(bouncing(ball("ball", 1.0, position=(0, 0, 1))), until=60.0, events=floor)
    assert len(run.events) > 60
    assert not messages(run)


@pytest.mark.slow
@pytest.mark.parametrize(("lower", "wrong"), [(0.2, True), (1.0, False)])
def test_two_balls_above_each_other(lower: float, wrong: bool) -> None:
    """Elastic: chaotic with a light one below a heavy one; equal ones exchange speeds, as if they passed each other."""
    balls = [
        ball("low", lower, position=(0, 0, 0.5)),
        ball("high", 1.0, position=(0, 0, 1.3)),
    ]
    events = [
        sr.Event("low.z", direction=-1, reset=sr.Impact(1.0), name="floor"),
        sr.Event("high.z - low.z", direction=-1, reset=sr.Impact(1.0), name="between"),
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = sr.simulate(bouncing(*balls), until=28.0, events=events)
    assert bool(messages(run)) == wrong


def test_errors_that_fall_more_slowly_than_tolerances() -> None:
    """A bead on a rotating hoop, near its unstable equilibrium at every return: 1.6e-3 of its swing are lost."""
    hoop = sr.Body("hoop", 1.0, (1.0,) * 3)
    bead = sr.Body("bead", 1.0, (1e-15,) * 3, position=(np.sin(1e-3), 0, -np.cos(1e-3)))
    joints = [
        sr.Revolute("axis", sr.ground, hoop, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Revolute("pin", hoop, bead, point=(0, 0, 0), axis=(0, -1, 0)),
    ]
    motor = sr.AngleDriver("motor", "axis", "3.2*t")
    system = sr.System(sr.Model("hoop", [hoop, bead], joints, drivers=[motor], gravity=(0, 0, -9.81)))
    with pytest.warns(sr.SarrusWarning, match=r"errors have grown beyond 0.0005 .* from t = 5\d"):
        sr.simulate(system, until=60.0, t_eval=np.linspace(0, 60, 101))


def duffing(until: float, start: float, damping: float, amplitude: float, rate: float) -> tuple[Any, float]:
    """x'' + damping x' - x + x³ = amplitude cos(rate t): a run, and its error over the size of the motion."""
    body = sr.Body("mass", 1.0, (1e-3,) * 3, position=(start, 0, 0))
    guide = sr.Translational("guide", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    law, foot = (lambda length: (length - 10) ** 2 - 1), sr.ground.point(-10, 0, 0)
    forces = [
        sr.TSDA("spring", foot, body.point(0, 0, 0), k=law, length=10.0, c=damping),
        sr.PointForce("push", body.point(0, 0, 0), (1, 0, 0), factor=lambda t: amplitude * cos(rate * t)),
    ]
    t = np.arange(0.0, until + 0.125, 0.25)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = sr.simulate(sr.System(sr.Model("duffing", [body], [guide], forces)), until=until, t_eval=t)

    def rates(t: float, y: Any) -> list[float]:
        return [y[1], y[0] - y[0] ** 3 - damping * y[1] + amplitude * np.cos(rate * t)]

    exact = solve_ivp(rates, (0, t[-1]), [start, 0], "DOP853", t_eval=t, rtol=1e-13, atol=1e-15).y[0]
    return run, float(abs(run["mass"].position[:, 0] - exact).max() / np.ptp(exact))


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("until", "start", "damping", "amplitude", "rate", "wrong"),
    [
        (40.0, 0.5, 0.15, 0.3, 1.0, False),
        (112.0, 0.5, 0.15, 0.3, 1.0, True),  # the perturbation is a fifth of the error
        (
            95.75,
            0.9250148226527568,
            0.17236301198038184,
            0.29268245486156874,
            0.9328109959134723,
            True,
        ),  # a single perturbation is by chance one that decays
    ],
)
def test_duffing_oscillators(
    until: float, start: float, damping: float, amplitude: float, rate: float, wrong: bool
) -> None:
    run, error = duffing(until, start, damping, amplitude, rate)
    assert (error > 1e-3) == wrong
    assert bool(messages(run)) == wrong


def test_one_of_the_runs_that_are_compared_can_agree_by_chance() -> None:
    run = sr.simulate(*pendulum(30.0), until=1.0)

    def moved(difference: float) -> sr.Trajectory:
        return replace(run, q=run.q + difference * np.ptp(run.q[:, 0]) * np.eye(run.q.shape[1])[0])

    differences = {1e3: 0.5, 30.0: 1e-6, 10.0: 0.01}
    assert lost_digits(run, lambda factor: (moved(differences[factor]), 0.85))
    differences[10.0] = 1e-6
    assert not lost_digits(run, lambda factor: (moved(differences[factor]), 0.85))
    regular = {1e3: 0.06, 30.0: 3e-3}  # both show an error of 2e-4: no further run
    assert not lost_digits(run, lambda factor: (moved(regular[factor]), 0.85))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*which the outputs do not resolve")  # two outputs of two thousand swings
def test_errors_of_a_very_long_regular_motion_add_up() -> None:
    """Two thousand swings: no perturbation grows, but the phase is off by more than a thousandth in the end."""
    with pytest.warns(sr.SarrusWarning, match=MESSAGE):
        sr.simulate(*pendulum(90.0), until=4000.0)
