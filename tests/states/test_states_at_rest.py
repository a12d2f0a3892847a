"""First-order states in equilibria, linearization, modes, mobility, and analyses of positions."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.states.motors import INERTIA, WEIGHT, arm, motor, value

import sarrus as sr
from sarrus.analyses import NoDerivative
from sarrus.analyses.equilibria import statics
from sarrus.model.written import with_numbers, written_numbers

CONSTANT = "(5 - R*current - k*pin.rate)/L"
SERVO = "40*(0.3 - pin.angle) + 30*integral - 8*pin.rate"


def servo() -> sr.System:
    """Position control with an integral part, whose rate does not depend on itself."""
    integral = sr.StateVariable("integral", rate="0.3 - pin.angle", initial=0)
    return sr.System(arm(integral, sr.Torque("servo", "pin", value=SERVO)))


def test_a_motor_holds_an_arm_in_equilibrium_and_a_run_from_there_stays() -> None:
    system = sr.System(motor(CONSTANT, initial=0.0))
    rest = sr.equilibrium(system)
    assert rest.success
    assert rest.v[7] == pytest.approx(5.0, rel=1e-12)
    assert np.arctan2(rest.q[1], rest.q[0]) == pytest.approx(-np.arccos(2.5 / WEIGHT), abs=1e-10)
    assert rest.stability == "unknown"
    assert "only `modes`" in rest.message
    run = sr.simulate(system, rest, until=1.0)
    assert np.ptp(value(run, "current")) < 1e-9
    assert np.ptp(value(run, "pin.angle")) < 1e-9


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lambda: motor(CONSTANT, initial=0.0), ["arm.mass", "gravity.y", "current.parameters.R"]),
        (lambda: servo().model, ["arm.mass", "gravity.y"]),
    ],
)
def test_derivatives_of_runs_go_through_an_equilibrium_with_states(make: Any, names: list[str]) -> None:
    """The current at rest follows from the circuit, an integral from the torque that holds the arm; both change."""
    model = make()

    def end(values: dict[str, float]) -> float:
        system = sr.System(with_numbers(model, values))
        run = sr.simulate(
            system, {"equilibrium": True, "rates": {"pin": 0.5}}, until=0.2, method=sr.Radau(rtol=1e-11)
        )
        return float(run["pin.angle"][-1])

    system = sr.System(model)
    start = {"equilibrium": True, "rates": {"pin": 0.5}}
    run = sr.simulate(system, start, until=0.2, store="steps", method=sr.Radau(rtol=1e-11))
    found = [sr.sensitivity(run, "pin.angle", names, method=how) for how in ("direct", "adjoint")]  # type: ignore[arg-type]
    own = written_numbers(model)
    h = {one: 1e-4 * abs(own[one]) for one in names}
    exact = [(end({n: own[n] + h[n]}) - end({n: own[n] - h[n]})) / (2 * h[n]) for n in names]
    assert found[0].matrix == pytest.approx(found[1].matrix, rel=1e-9)
    assert found[1].matrix[0] == pytest.approx(exact, rel=1e-6)
    curved = sr.hessian(run, "pin.angle", ["arm.mass"])["arm.mass", "arm.mass"]
    sides = [
        sr.sensitivity(
            sr.simulate(sr.System(with_numbers(model, {"arm.mass": own["arm.mass"] + s * 1e-3})), start, until=0.2,
                        store="steps", method=sr.Radau(rtol=1e-11)), "pin.angle", ["arm.mass"],
        )["arm.mass"]
        for s in (-1, 1)
    ]  # fmt: skip
    assert curved == pytest.approx((sides[1] - sides[0]) / 2e-3, rel=1e-4)


def test_an_equilibrium_that_does_not_determine_a_state_has_no_derivatives() -> None:
    way = sr.StateVariable("way", rate="pin.rate", initial=0.3)
    system = sr.System(arm(way, sr.Torque("spring", "pin", value="-30*x")))
    with pytest.warns(sr.SarrusWarning, match="no equation determines way"):
        rest = sr.equilibrium(system)
    run = sr.simulate(system, rest, until=0.01, store="steps")
    with pytest.raises(NoDerivative, match="does not determine way"):
        sr.sensitivity(run, "pin.angle", ["arm.mass"])


def test_an_integrator_holds_the_position_that_it_controls() -> None:
    rest = sr.equilibrium(servo())
    assert rest.success
    assert np.arctan2(rest.q[1], rest.q[0]) == pytest.approx(0.3, abs=1e-12)
    assert rest.v[7] == pytest.approx(WEIGHT * np.cos(0.3) / 30, rel=1e-10)


def test_a_state_that_nothing_determines_is_named() -> None:
    way = sr.StateVariable("way", rate="pin.rate", initial=0.3)
    spring = sr.Torque("spring", "pin", value="-30*x")
    with pytest.warns(sr.SarrusWarning, match="no equation determines way in this equilibrium"):
        assert sr.equilibrium(sr.System(arm(way, spring))).success


@pytest.mark.filterwarnings("error")
def test_states_that_are_determined_are_not() -> None:
    lag = sr.FirstOrderLag("lag", input="pin.angle", time=1e-4, gain=1e6)
    for system in (servo(), sr.System(arm(lag, sr.Torque("spring", "pin", value="-30*x")))):
        assert sr.equilibrium(system).success


def matrix(angle: float) -> np.ndarray:
    """Of the motor's reduced equations, linearized by hand."""
    return np.array([[0, 1, 0], [WEIGHT * np.sin(angle) / INERTIA, 0, 0.5 / INERTIA], [0, -50, -100]])


def test_poles_are_those_of_the_reduced_equations() -> None:
    system = sr.System(motor(CONSTANT, initial=0.0))
    rest = sr.equilibrium(system)
    exact = np.linalg.eigvals(matrix(np.arctan2(rest.q[1], rest.q[0])))
    linear, modes = sr.linearize(system, rest), sr.modes(system, rest)
    assert linear.A.shape == (3, 3)
    assert np.sort_complex(np.linalg.eigvals(linear.A)) == pytest.approx(np.sort_complex(exact), rel=1e-9)
    assert modes.success
    assert modes.stability == "stable"
    assert np.sort(modes.eigenvalues.real) == pytest.approx(np.unique(exact.real), rel=1e-9)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("unit", [1e-9, 1e-6, 1e9])
def test_an_equilibrium_is_one_in_every_unit_of_a_state(unit: float) -> None:
    rate = f"(5*{unit} - current - 0.5*{unit}*pin.rate)/0.01"
    state = sr.StateVariable("current", rate=rate, initial=0, nominal=unit)
    system = sr.System(arm(state, sr.Torque("torque", "pin", value=f"0.5*current/{unit}")))
    rest = sr.equilibrium(system)
    found = sr.modes(system, rest)
    assert found.success, found.message
    exact = np.linalg.eigvals(matrix(np.arctan2(rest.q[1], rest.q[0])))
    assert np.sort(found.eigenvalues.real) == pytest.approx(np.unique(exact.real), rel=1e-9)


def test_poles_of_a_chain_of_states_alone_and_of_a_servo() -> None:
    """Lags of a second and of a tenth have poles -1 and -10, beside those of a damped arm that hangs."""
    lags = [
        sr.StateVariable("slow", rate="pin.angle - slow", initial=0),
        sr.StateVariable("fast", rate="10*(slow - fast)", initial=0),
    ]
    hanging = sr.System(arm(*lags, sr.Torque("damper", "pin", value="-0.1*v - 20*(x + 1.5707963267948966)")))
    found = sr.modes(hanging, sr.equilibrium(hanging)).eigenvalues
    assert np.sort(found.real)[:2] == pytest.approx([-10, -1], rel=1e-9)
    system = servo()
    A = [[0, 1, 0], [(WEIGHT * np.sin(0.3) - 40) / INERTIA, -8 / INERTIA, 30 / INERTIA], [-1, 0, 0]]
    found = sr.modes(system, sr.equilibrium(system)).eigenvalues
    exact = np.linalg.eigvals(np.array(A))
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(exact[exact.imag >= 0]), rel=1e-8)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("lags", [1, 2, 3])
@pytest.mark.parametrize("integrals", [0, 2])
def test_free_motions_beside_states(lags: int, integrals: int) -> None:
    """A free arm has a double zero, which is one mode; every integral of what is zero at rest has a zero of its own."""
    states = [
        *(sr.FirstOrderLag(f"lag{n}", input="pin.rate", time=1 / (n + 1)) for n in range(lags)),
        *(sr.StateVariable(f"sum{n}", rate="lag0", initial=0.0) for n in range(integrals)),
    ]
    system = sr.System(arm(*states, gravity=0.0))
    found = sr.modes(system, system.q0, system.v0)
    exact = [0.0] * (1 + integrals) + [-1.0 - n for n in range(lags)]
    assert found.eigenvalues == pytest.approx(exact, rel=1e-9)
    assert found.stability == "marginal"
    assert np.linalg.matrix_rank(found.shapes[:, : 1 + integrals]) == 1 + integrals
    plant = sr.linearize(system, system.q0, system.v0)
    assert [plant.pole(n + 1).value for n in range(len(exact))] == pytest.approx(exact, rel=1e-9)


def test_states_are_no_degrees_of_freedom_and_positions_are_analysed_without_them() -> None:
    system = servo()
    assert sr.mobility(system).degrees_of_freedom == 1
    assert abs(sr.mobility(system).motions[7:]).max() < 1e-14
    with pytest.raises(sr.SarrusError, match="integral are first-order states"):
        sr.kinematics(system, [0.0, 1.0])


def test_a_state_that_is_zero_in_equilibrium_is_found() -> None:
    """The filtered error of a servo with an integral part."""
    pid = sr.PID("pid", input="0.3 - pin.angle", kp=40.0, ki=30.0, kd=8.0, filter=0.01)
    system = sr.System(arm(pid, sr.Torque("servo", "pin", value="pid.output")))
    rest = sr.equilibrium(system)
    assert rest.success
    assert rest.v[7] == pytest.approx(WEIGHT * np.cos(0.3) / 30, rel=1e-9)
    assert abs(rest.v[8]) < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("limit", [24.0, 10.0, 9.0, 5.0])
def test_a_servo_with_limits_rests_at_its_aim_or_at_its_limit(limit: float) -> None:
    """The integral follows the position only where a limit acts, which ends and begins on the way to rest."""
    pid = sr.PID(
        "pid", input="0.3 - pin.angle", kp=30.0, ki=20.0, kd=4.0, filter=0.02, lower=-limit, upper=limit
    )
    rest = sr.equilibrium(sr.System(arm(pid, sr.Torque("servo", "pin", value="pid.output"))))
    assert rest.success
    needed = WEIGHT * np.cos(0.3)
    angle = 0.3 if limit > needed else -np.arccos(limit / WEIGHT)
    assert np.arctan2(rest.q[1], rest.q[0]) == pytest.approx(angle, abs=1e-10)
    assert rest["pid.output"] == pytest.approx(min(limit, needed), rel=1e-9)
    windup = 0.0 if limit > needed else 0.1 * 20 * (0.3 - angle)  # e + (limited - u)/(ki tracking) = 0
    assert 20 * rest.v[7] + 30 * (0.3 - angle) == pytest.approx(min(limit, needed) + windup, rel=1e-9)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("limits", "stiffness"),
    [({}, 0.0), ({"lower": -50, "upper": 50}, 0.0), ({"lower": -25, "upper": 25}, 0.0), ({}, 30.0)],
)
def test_a_servo_far_from_its_aim_rests_there(limits: dict[str, float], stiffness: float) -> None:
    """A mass on a vertical slide rises by 1 m, five times the largest step."""
    cart = sr.Body("cart", mass=2.0, inertia=(1, 1, 1))
    slide = sr.Translational("slide", sr.ground, cart, point=(0, 0, 0), axis=(0, 0, 1))
    pid = sr.PID("pid", input="1 - slide.displacement", kp=10, ki=5, **limits)
    push = sr.Force("push", "slide", value=f"pid.output - {stiffness}*x")
    rest = sr.equilibrium(
        sr.System(sr.Model("lift", [cart], [slide], forces=[pid, push], gravity=(0, 0, -9.81)))
    )
    assert rest.success
    assert rest["slide.displacement"] == pytest.approx(1.0, abs=1e-9)
    assert rest["pid.output"] == pytest.approx(2 * 9.81 + stiffness, rel=1e-9)


def test_repeated_searches_share_their_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that fails is repeated with other states that follow, but all repetitions have one limit."""
    steps, own = list[int](), statics._Search._searched

    def counted(search: statics._Search, q: np.ndarray, settled: np.ndarray, stable: bool, most: int) -> Any:
        found = replace(own(search, q, settled, stable, most), success=False)
        steps.append(found.iterations)
        return found

    monkeypatch.setattr(statics._Search, "_searched", counted)
    pid = sr.PID("pid", input="0.3 - pin.angle", kp=30.0, ki=20.0, kd=4.0, filter=0.02)
    system = sr.System(arm(pid, sr.Torque("servo", "pin", value="pid.output")))
    others = iter([(system.q0, np.zeros(0, dtype=np.int64))] * 50)
    monkeypatch.setattr(statics._Search, "_other", lambda *_: next(others))
    assert not sr.equilibrium(system, iterations=40).success
    assert len(steps) > 2
    assert sum(steps[1:]) <= 40


def test_the_table_of_modes_shows_states_where_no_body_moves() -> None:
    slow = sr.FirstOrderLag("slow", input="1", time=2.0)
    spring = sr.Torque("spring", "pin", value="-30*x - pin.rate")
    system = sr.System(arm(slow, spring))
    modes = sr.modes(system, sr.equilibrium(system))
    (line,) = (line for line in str(modes).splitlines() if "-0.5 " in line)
    assert line.split()[-1] == "slow"
