"""The worked examples of machines with motors and controllers agree with reduced equations and closed forms."""

import runpy
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.examples.problems import FOLDER

import sarrus as sr


def of(script: str) -> dict[str, Any]:
    """The names that a script defines."""
    return runpy.run_path(str(FOLDER / f"{script}.py"))


def reduced_servo(gains: Any, until: float) -> Any:
    """The angle of the crank from above, its rate, current, integral, filtered error and cost over time, by SciPy."""
    R, L, aim, imaginary = 0.1, 0.3, -0.07, 1e-30
    crank, rod = (0.5 / 12 * (3 / 40**2 + 1) * length**2 for length in (R, L))  # of round rods

    def slider(angle: Any) -> Any:
        return np.sqrt(L**2 - (R * np.cos(angle)) ** 2) - R * np.sin(angle)

    def inertia(angle: Any) -> Any:
        sine, cosine = np.sin(angle), np.cos(angle)
        tilt = R * sine / np.sqrt(L**2 - (R * cosine) ** 2)
        x = R * cosine * (tilt - 1)
        middle = ((x - R * cosine) / 2) ** 2 + (R * sine / 2) ** 2
        return crank + 0.5 * R**2 / 4 + 0.5 * middle + rod * tilt**2 + 2.0 * x**2

    def rates(t: float, y: Any) -> list[float]:
        angle, speed, current, integral, filtered, _ = y
        away = slider(angle) - slider(0.0)
        s = min(t / 0.1, 1.0)
        error = away - aim * s * s * (3 - 2 * s)
        slope = (error - filtered) / 5e-3
        voltage = gains @ [error, integral, slope]
        M, M_angle = inertia(angle), inertia(angle + 1j * imaginary).imag / imaginary
        torque = 0.5 * current + 9.81 * R * (0.5 + 0.5) / 2 * np.sin(angle) - M_angle * speed**2 / 2
        rate = (voltage - 0.8 * current - 0.5 * speed) / 1e-3
        return [speed, torque / M, rate, error, slope, t * (1e3 * (away - aim)) ** 2]

    options: Any = {"method": "LSODA", "rtol": 1e-10, "atol": 1e-12}
    first = solve_ivp(rates, (0, 0.1), np.zeros(6), t_eval=np.linspace(0, 0.1, 5001), **options)
    return first.y, solve_ivp(rates, (0.1, until), first.y[:, -1], **options).y[:, -1]


@pytest.mark.slow
def test_slider_crank_servo(tmp_path: Path) -> None:
    """In the equation of the angle, cost and current are the same, and no other gains are better: ∇J = -μ ∇P."""
    script = of("slider_crank_servo")
    best = script["main"](tmp_path)
    assert best.success
    assert (tmp_path / "slider_crank_servo.png").stat().st_size > 5000

    def cost_and_current(gains: Any) -> Any:
        first, end = reduced_servo(gains, script["UNTIL"])
        return np.array([end[5], first[2].max()])

    assert cost_and_current(best.x) == pytest.approx([best.value, script["MOST"]], rel=1e-5)
    changes = 1e-3 * np.diag(best.x)
    slopes = np.array([cost_and_current(best.x + d) - cost_and_current(best.x - d) for d in changes]).T
    multiplier = -(slopes[0] @ slopes[1]) / (slopes[1] @ slopes[1])
    assert multiplier > 0
    assert np.linalg.norm(slopes[0] + multiplier * slopes[1]) < 0.01 * np.linalg.norm(slopes[0])


@pytest.mark.filterwarnings("ignore:.*sets in, ends or reverses within single steps")  # tyres lift off
def test_active_suspension(tmp_path: Path) -> None:
    """The poles of the state space that is closed by hand are those of the vehicle with controlled actuators."""
    script = of("active_suspension")
    poles, gain, runs = script["main"](tmp_path)
    (chosen,) = np.flatnonzero(script["GAINS"] == gain)
    system = script["skyhook"](gain)
    known = sr.modes(system, sr.equilibrium(system)).eigenvalues
    for pole in poles[chosen][abs(poles[chosen]) > 1e-3]:
        assert min(abs(known - pole), default=1) < 1e-6 * abs(pole) or pole.imag < 0
    passive, active = (np.std(run[script["SEAT"]]) for run in runs.values())
    assert active < 0.5 * passive
    assert (tmp_path / "active_suspension.png").stat().st_size > 5000


def reduced_motor(b: Any, times: Any) -> Any:
    """Current and angle (2, nt) of the motor with its arm, by SciPy."""
    resistance, inductance, constant, friction, rotor = b
    arm = 0.6 * 0.3**2 * (1 / 3 + 3 / 40**2 / 12) + rotor

    def rates(t: float, y: Any) -> list[float]:
        current, angle, speed = y
        torque = 8 * constant * current - friction * speed - 0.6 * 9.81 * 0.15 * np.sin(angle)
        voltage = 12 * np.sin(6 * t + 8 * t**2)
        rate = (voltage - resistance * current - 8 * constant * speed) / inductance
        return [rate, speed, torque / arm]

    found = solve_ivp(rates, (0, times[-1]), np.zeros(3), t_eval=times, rtol=1e-10, atol=1e-12)
    return found.y[:2]


def test_motor_constants(tmp_path: Path) -> None:
    """The intervals contain the true constants, and are those of the Jacobian of the reduced equations."""
    script = of("motor_constants")
    found = script["main"](tmp_path)
    true = np.array([*script["TRUE"].values()]) * [1, 1, 1, 1, script["GEAR"] ** 2]
    deviations = np.sqrt(np.diag(found.covariance))
    assert np.all(abs(found.x - true) < 3 * deviations)
    sigmas = np.array([*script["SENSORS"].values()])[:, None]
    columns = []
    for change in 1e-4 * np.diag(found.x):
        above, below = (reduced_motor(found.x + sign * change, script["TIMES"]) for sign in (1, -1))
        columns.append(((above - below) / sigmas).ravel() / (2 * change.sum()))
    jacobian = np.array(columns).T
    assert found.covariance == pytest.approx(np.linalg.inv(jacobian.T @ jacobian), rel=1e-3)
    assert (tmp_path / "motor_constants.png").stat().st_size > 5000


def reduced_lift(until: float) -> Any:
    """Height and pressures (3,) at the end by virtual work in the angle of the bars, by SciPy."""
    L, attached, m, bar, bottom = 2.0, 1.2, 500.0, 40.0, 2.0 * np.sin(np.radians(15))
    a, b, area, rod, dead, leakage = 0.8, attached, 7.85e-3, 4e-3, 1e-4, 5e-12
    across = 2 * bar * L**2 * (1 / 4 + (1 + 3 / 40**2) / 12)

    def flow(opening: float, drop: float) -> float:
        return opening * 5e-4 * drop / np.sqrt(35e5 * np.sqrt(drop**2 + 1e8))

    def rates(t: float, y: Any) -> list[float]:
        angle, speed, p_a, p_b = y
        sine, cosine = np.sin(angle), np.cos(angle)
        length = np.hypot(a * cosine, b * sine)
        lever = (b**2 - a**2) * sine * cosine / length
        s = np.clip((t - 0.5) / 4, 0, 1)
        u = np.clip(10 * (bottom + 0.8 * s * s * (3 - 2 * s) - L * sine), -1, 1)
        ahead, back = (np.hypot(u, 1e-3) + u) / 2, (np.hypot(u, 1e-3) - u) / 2
        q_a = flow(ahead, 160e5 - p_a) - flow(back, p_a) - leakage * (p_a - p_b) - area * lever * speed
        q_b = flow(back, 160e5 - p_b) - flow(ahead, p_b) + leakage * (p_a - p_b) + rod * lever * speed
        x = length - 0.8
        force = (area * p_a - rod * p_b) * lever - 9.81 * (m + bar) * L * cosine
        inertia = across + m * (L * cosine) ** 2
        rate = (force + m * L**2 * sine * cosine * speed**2) / inertia
        return [speed, rate, 1.4e9 * q_a / (dead + area * x), 1.4e9 * q_b / (dead + rod * (0.3 - x))]

    y, corners = (
        np.array([np.radians(15), 0, 64.5e5, 20e5]),
        [0, *(t for t in (0.5, 4.5) if t < until), until],
    )
    for span in pairwise(corners):
        y = solve_ivp(rates, span, y, method="LSODA", rtol=1e-8, atol=[1e-9, 1e-8, 1, 1]).y[:, -1]
    return np.array([L * np.sin(y[0]), *y[2:]])


def test_scissor_lift(tmp_path: Path) -> None:
    """Height and pressures are those of the lift in one coordinate, while it moves and in the end."""
    script = of("scissor_lift")
    run = script["main"](tmp_path)
    assert run.success
    assert sr.mobility(run.system).degrees_of_freedom == 1
    for t in (2.0, script["UNTIL"]):
        names = ("platform.z", "cylinder.pressure_a", "cylinder.pressure_b")
        found = [np.interp(t, run.t, run[name]) for name in names]
        assert found == pytest.approx(reduced_lift(t), rel=2e-4)
    assert (tmp_path / "scissor_lift.png").stat().st_size > 5000
