"""A response at a time is what the run reports there, by every method, with the derivatives of that value.

Values are compared with those of `Trajectory`; derivatives with central differences of them over whole simulations
with steps of one length, and with each other.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sarrus as sr
from sarrus.model.written import with_numbers

# Derivatives by HHT and generalized-α are compared with differences of the same steps, not with the exact motion
pytestmark = []

METHODS = {
    "hht": sr.HHT(step=0.01),
    "generalized-alpha": sr.GeneralizedAlpha(0.5, step=0.01),
    "radau": sr.Radau(),
}
UNTIL, BETWEEN = 0.4, 0.1637
TIMES = (BETWEEN, UNTIL)
BUMPS = [[0.0, 4.0], [0.7, 5.5], [1.5, 9.0], [2.5, 20.0]]


@cache
def system() -> sr.System:
    """A driven arm and a hanging one in space, with springs by numbers and by a table; all is moving."""
    axis = np.array([0.1, 0.2, 1.0])
    crank = sr.Body("crank", mass=1.3, inertia=(0.2, 0.3, 0.25), position=(0.4, 0.1, 0.0))
    arm = sr.Body("arm", mass=0.8, inertia=(0.05, 0.2, 0.22), position=(1.1, 0.3, 0.1))
    ball = sr.Body("ball", mass=0.5, inertia=(0.02, 0.02, 0.03), position=(1.5, -0.2, 0.3))
    joints = [
        sr.Revolute("pin", sr.ground, crank, point=(0, 0, 0), axis=axis),
        sr.Universal("elbow", crank, arm, point=(0.8, 0.2, 0.0), axis_i=(0, 1, 0), axis_j=(1, 0, 0)),
        sr.Spherical("socket", arm, ball, point=(1.4, 0.35, 0.1)),
    ]
    motor = sr.AngleDriver("motor", "pin", "0.3*t + 0.8*t^2")
    forces = [
        sr.TSDA("spring", ball.point(0, 0.1, 0), sr.ground.point(1.0, -1.0, 0.5), k=30.0, c=0.4, length=0.6),
        sr.TSDA("line", arm.point(0.1, 0, 0), sr.ground.point(0.2, 1.5, 0.1), k=BUMPS, c=0.1, length=0.7),
    ]
    return sr.System(
        sr.Model("arms", [crank, arm, ball], joints, drivers=[motor], forces=forces, gravity=(0, -9.81, 0.3))
    )


class Output(NamedTuple):
    """An output by name, and where a run reports it."""

    name: str
    of: Callable[[sr.Trajectory], np.ndarray]


def turning(of: sr.Trajectory) -> np.ndarray:
    """The angular velocity of the arm in global axes; a run has it in those of the body."""
    p = of.q[:, system().coordinates_of("arm")][:, 3:]
    pairs = zip(
        p.copy(), of["arm"].angular_velocity_body.copy(), strict=True
    )  # SciPy wants to be able to write
    return np.array([Rotation.from_quat(e, scalar_first=True).apply(w) for e, w in pairs])


def outputs() -> list[Output]:
    """Every kind of those that a run reports."""
    found = [
        Output("pin.angle", lambda r: r.joint("pin").angle),
        Output("pin.angle.rate", lambda r: r.joint("pin").rate),
        Output("energy.kinetic", lambda r: r.kinetic_energy),
        Output("energy.potential", lambda r: r.potential_energy),
    ]
    for n, axis in enumerate("xyz"):
        at = system().coordinates_of("ball").start + n
        found += [
            Output(f"ball.{axis}", lambda r, n=n: r["ball"].position[:, n]),
            Output(f"ball.velocity.{axis}", lambda r, n=n: r["ball"].velocity[:, n]),
            Output(f"ball.acceleration.{axis}", lambda r, at=at: r.a[:, at]),
            Output(f"arm.angular_velocity.{axis}", lambda r, n=n: turning(r)[:, n]),
            Output(f"elbow.force.{axis}", lambda r, n=n: r.reaction("elbow").force[:, n]),
            Output(f"pin.torque.{axis}", lambda r, n=n: r.reaction("pin").torque[:, n]),
            Output(f"socket.force.{axis}", lambda r, n=n: r.reaction("socket").force[:, n]),
        ]
    row = system().rows["motor"][0]
    return [*found, Output("motor.multiplier.1", lambda r: r.lam[:, row])]


OUTPUTS = outputs()
RESPONSES = [sr.At(one.name, time=t) for t in TIMES for one in OUTPUTS]
NUMBERS = {"ball.mass": 5e-3, "elbow.point.y": 2e-3, "spring.k": 0.5, "gravity.y": 0.1, "line.k.3.y": 0.05}


def simulated(system: sr.System, method: str) -> sr.Trajectory:
    settings = {"rtol": 1e-9, "atol": 1e-11} if method == "radau" else {"rtol": 1e-11, "atol": 1e-13}
    until = {"until": UNTIL, "t_eval": [0.0, *TIMES], "store": "steps"}
    return sr.simulate(system, method=replace(METHODS[method], **settings), **until)


@cache
def run(method: str) -> sr.Trajectory:
    return simulated(system(), method)


def reported(of: sr.Trajectory) -> np.ndarray:
    """What a run says of all responses."""
    return np.concatenate([[one.of(of)[k] for one in OUTPUTS] for k in (1, 2)])


@cache
def gradient(method: str, way: str) -> sr.Gradient:
    return sr.sensitivity(run(method), RESPONSES, list(NUMBERS), method=way)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("method", METHODS)
def test_a_response_is_what_the_run_reports(method: str) -> None:
    """States of responses are not corrected again after a defect below 1e-7, which leaves the square of it.

    Of the states of Radau between its steps, with |Φ| = 3e-13 instead of 2e-16, values differ by up to 1.6e-12.
    """
    found, wanted = gradient(method, "adjoint").values, reported(run(method))
    limit = 3e-12 if method == "radau" else 1e-12
    assert np.all(abs(found - wanted) < limit * np.maximum(abs(wanted), 1.0)), found - wanted


@pytest.mark.one_in(3)
@pytest.mark.parametrize("method", METHODS)
def test_both_ways_give_one_derivative(method: str) -> None:
    found, direct = (gradient(method, way).matrix for way in ("adjoint", "direct"))
    assert np.all(abs(found - direct) <= 1e-9 * abs(found).max(axis=1, keepdims=True) + 1e-15)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", NUMBERS)
def test_derivatives_are_those_of_reported_values(method: str, name: str) -> None:
    """Radau chooses its steps by itself: differences contain the error of the run."""
    at = dict(zip(*(getattr(gradient(method, "adjoint"), k) for k in ("names", "at")), strict=True))[name]

    def slope(e: float) -> np.ndarray:
        ends = [
            reported(simulated(sr.System(with_numbers(system().model, {name: at + d})), method))
            for d in (e, -e)
        ]
        return (ends[0] - ends[1]) / (2 * e)

    size = NUMBERS[name]
    wanted, found = (4 * slope(size / 2) - slope(size)) / 3, gradient(method, "adjoint")
    scale = np.maximum(abs(found.matrix).max(axis=1), 1e-6)  # some outputs are given by the driver
    assert np.all(abs(found[name] - wanted) < 1e-6 * scale), (found[name] - wanted) / scale
