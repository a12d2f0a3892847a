"""An arm on a motor with an electrical circuit, and its reduced equations."""

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import sarrus as sr

INERTIA, WEIGHT = (
    0.7,
    2.0 * 9.81 * 0.5,
)  # of the arm about its pin, times gravity and the distance of its centre
NUMBERS = {"R": 1.0, "k": 0.5, "L": 1e-2}
RATE = "(12*sin(3*t) - R*current - k*pin.rate)/L"
TIGHT: dict[str, Any] = {"method": sr.Radau(rtol=1e-12)}


def arm(*forces: Any, gravity: float = 9.81) -> sr.Model:
    """A rod on a pin."""
    body = sr.Body("arm", mass=2.0, inertia=(0.1, 0.15, 0.2), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.Model("arm", [body], [pin], list(forces), gravity=(0, -gravity, 0))


def motor(rate: Any = RATE, initial: Any = 0.1, **numbers: float) -> sr.Model:
    """Its motor: a current, and the torque of it."""
    own = NUMBERS | numbers
    current = sr.StateVariable("current", rate=rate, initial=initial, unit="A", parameters=own)
    return arm(current, sr.Torque("torque", "pin", value="k*current", parameters={"k": own["k"]}))


def reduced(t: Any, L: float = 1e-2, initial: float = 0.1) -> np.ndarray[Any, Any]:
    """Angle, its rate and the current at some times."""

    def rates(t: float, y: Any) -> list[float]:
        angle, speed, current = y
        torque = 0.5 * current - WEIGHT * np.cos(angle)
        return [speed, torque / INERTIA, (12 * np.sin(3 * t) - current - 0.5 * speed) / L]

    times = np.atleast_1d(t)
    options: dict[str, Any] = {"rtol": 1e-12, "atol": 1e-13}
    return np.asarray(solve_ivp(rates, (0, times[-1]), [0, 0, initial], "Radau", t_eval=times, **options).y)


def value(run: sr.Trajectory, name: str) -> np.ndarray[Any, Any]:
    """An output at all times."""
    return np.asarray(run.output(name).values)
