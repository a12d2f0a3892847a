"""Lags, transfer functions, PID controllers and motors, against SciPy on the reduced equations."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import solve_ivp
from tests.states.gradients import differences, direct_and_adjoint
from tests.states.motors import INERTIA, TIGHT, WEIGHT, arm, value

import sarrus as sr
from sarrus.model import ModelError

PID = {"kp": 30.0, "ki": 20.0, "kd": 4.0, "filter": 0.02}
MOTOR = {"resistance": 1.0, "inductance": 1e-3, "constant": 0.05, "gear": 50.0, "efficiency": 0.9}
AIM = "0.3 - pin.angle"


def servo(**limits: float) -> sr.Model:
    """Position control of the arm."""
    controller = sr.PID("pid", input=AIM, unit="V", **PID, **limits)
    return arm(controller, sr.DCMotor("motor", "pin", "pid.output", **MOTOR))


def servo_by_hand(until: float, lower: float = -np.inf, upper: float = np.inf) -> tuple[Any, float]:
    """Angle, rate, integral, filtered error and current; and the controller's output."""

    def control(y: Any) -> tuple[float, float, float, float]:
        e = 0.3 - y[0]
        slope = (e - y[3]) / 0.02
        u = 30 * e + 20 * y[2] + 4 * slope
        limited = min(max(u, lower), upper)
        return e + (limited - u) / (20 * 0.1), slope, limited, 0.9 * 50 * 0.05 * y[4]

    def rates(t: float, y: Any) -> list[float]:
        integral, slope, u, torque = control(y)
        current = (u - y[4] - 0.05 * 50 * y[1]) / 1e-3
        return [y[1], (torque - WEIGHT * np.cos(y[0])) / INERTIA, integral, slope, current]

    y = solve_ivp(rates, (0, until), np.zeros(5), "Radau", rtol=1e-12, atol=1e-14, max_step=2e-3).y[:, -1]
    return y, control(y)[2]


SERVO = ("pin.angle", "pin.angle.rate", "pid.integral", "pid.filtered", "motor.current")


def test_position_control_with_a_motor_follows_its_reduced_equations() -> None:
    run = sr.simulate(sr.System(servo()), until=0.5, **TIGHT)
    y, u = servo_by_hand(0.5)
    assert [value(run, name)[-1] for name in SERVO] == pytest.approx(y, rel=1e-8)
    assert value(run, "pid.output")[-1] == pytest.approx(u, rel=1e-8)
    assert value(run, "motor.value")[-1] == pytest.approx(2.25 * y[4], rel=1e-8)


def test_limits_and_anti_windup() -> None:
    run = sr.simulate(sr.System(servo(lower=-5, upper=5)), until=0.5, **TIGHT)
    y, _ = servo_by_hand(0.5, -5, 5)
    assert [value(run, name)[-1] for name in SERVO] == pytest.approx(y, rel=1e-8)
    assert abs(value(run, "pid.output")).max() <= 5 + 1e-12


@pytest.mark.parametrize("coefficients", [([2, 3], [1, 4, 5, 6]), ([1, 0.5], [2, 3]), ([4], [1, 0])])
def test_a_transfer_function_is_that_of_scipy(coefficients: Any) -> None:
    system = signal.TransferFunction(*coefficients)
    part = sr.TransferFunction.of("filter", system, input="sin(5*t)")
    own = system.to_ss()
    A, B, C, D = own.A, own.B[:, 0], own.C[0], own.D[0, 0]
    solver = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    x = solve_ivp(lambda t, x: A @ x + B * np.sin(5 * t), (0, 2), np.zeros(len(A)), **solver).y[:, -1]
    run = sr.simulate(sr.System(arm(part)), until=2.0, **TIGHT)
    assert value(run, "filter.output")[-1] == pytest.approx(C @ x + D * np.sin(10), rel=1e-8)


@pytest.mark.parametrize(
    ("system", "message"),
    [
        (signal.TransferFunction([1], [1, 2], dt=0.1), "system has a sampling time"),
        (signal.TransferFunction([[1, 0], [0, 2]], [1, 2]), "system has several inputs or outputs"),
    ],
)
def test_systems_that_are_no_transfer_function_in_continuous_time_are_refused(
    system: Any, message: str
) -> None:
    with pytest.raises(ModelError, match=message):
        sr.TransferFunction.of("filter", system, input="sin(5*t)")


def test_a_lag_and_what_uses_it() -> None:
    lag = sr.FirstOrderLag("lag", input="sin(2*t)", time=0.5, gain=3.0, initial=1.0, unit="V")
    run = sr.simulate(sr.System(arm(lag)), until=1.0, **TIGHT)
    exact = 1.5 * (np.sin(2) - np.cos(2)) + 2.5 * np.exp(-2)
    assert value(run, "lag")[-1] == pytest.approx(exact, abs=1e-10)
    assert run.output("lag").unit == "V"


@pytest.mark.parametrize("name", ["servo.yaml", "servo.json"])
def test_controllers_are_saved_and_read(name: str, tmp_path: Path) -> None:
    part = sr.TransferFunction("filter", numerator=[2, 3], denominator=[1, 4, 5], input="pid.output")
    model = servo(lower=-5.0, upper=5.0)
    model = sr.Model("servo", model.bodies, model.joints, [*model.forces, part], gravity=model.gravity)
    model.save(tmp_path / name)
    runs = [sr.simulate(sr.System(one), until=0.1) for one in (model, sr.load(tmp_path / name))]
    assert np.array_equal(runs[0].v, runs[1].v)


@pytest.mark.slow
def test_gradients_of_a_servo_are_differences_of_runs_and_direct_is_adjoint() -> None:
    names = ["pid.kp", "pid.ki", "pid.kd", "pid.filter", "motor.inductance", "motor.gear"]
    place = servo(), "pin.angle", names, 0.2
    direct, adjoint = direct_and_adjoint(*place, rtol=1e-10)
    assert direct == pytest.approx(adjoint, rel=1e-9)
    for name, one, wanted in zip(names, direct, differences(*place, 1e-4), strict=True):
        assert one == pytest.approx(wanted, rel=1e-4), name


def test_an_algebraic_loop_is_named_around_the_circle() -> None:
    one = sr.TransferFunction("a", numerator=[1, 1], denominator=[1, 2], input="b.output")
    two = sr.TransferFunction("b", numerator=[2, 1], denominator=[1, 3], input="a.output")
    with pytest.raises(
        ModelError, match=r"algebraic loop: b.output → a.output → b.output. Put a state between"
    ):
        sr.System(arm(one, two))
    proper = sr.TransferFunction("a", numerator=[1], denominator=[1, 2], input="b.output")
    assert len(sr.System(arm(proper, two)).states) == 2


@pytest.mark.parametrize(
    ("part", "message"),
    [
        (sr.PID("c", input="1", kd=1.0), "filter is missing, which kd needs"),
        (sr.FirstOrderLag("c", input="1", time=0.0), "time must be greater than 0"),
        (sr.FirstOrderLag("c", time=1.0), "its input is missing"),
        (sr.TransferFunction("c", numerator=[1, 2, 3], denominator=[1, 1], input="1"), "numerator must have"),
        (sr.TransferFunction("c", numerator=[1], denominator=[0, 1], input="1"), "denominator must have"),
        (
            sr.TransferFunction("c", numerator=5, denominator=[1, 1], input="1"),
            "numerator must be a list of numbers",
        ),  # type: ignore[arg-type]
        (sr.TransferFunction("c", numerator=[1], denominator=None, input="1"), "denominator must be a list"),  # type: ignore[arg-type]
        (sr.DCMotor("c", "pin", "1", 1.0, 0.0, 1.0), "inductance must be greater than 0"),
        (sr.DCMotor("c", "pin", "1", 1.0, 1.0, 1.0, gear=0.0), "gear must not be 0"),
    ],
)
def test_wrong_controllers_are_refused(part: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        sr.System(arm(part))
