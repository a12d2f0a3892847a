"""The worked examples of machines with motors and controllers agree with reduced equations and closed forms."""

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.examples.problems import FOLDER


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
