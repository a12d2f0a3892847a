"""Inputs by name against SciPy on the reduced equations, and gradients with respect to their values."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.states.gradients import differences, direct_and_adjoint
from tests.states.motors import INERTIA, TIGHT, WEIGHT, arm, value

import sarrus as sr
from sarrus.model import ModelError, SarrusError

TABLE = [[0.0, 0.0], [0.2, 5.0], [0.4, -3.0], [0.6, 8.0], [0.8, 2.0]]
LAWS: dict[str, Any] = {
    "number": 3.0,
    "formula": "a*sin(7*t)",
    "table": TABLE,
    "function": lambda t: 3 * t * t,
}
NAMES = [f"u.value.{n}.y" for n in range(1, 6)]


def driven(law: Any = None, value: Any = "u - c*pin.rate", **options: Any) -> sr.Model:
    """The arm with a torque that an input prescribes."""
    source = sr.Input("u", law, unit="N m", parameters={"a": 4.0}, **options)
    return arm(sr.Torque("motor", "pin", value=value, parameters={"c": 0.5}), source)


def by_scipy(law: Any, until: float) -> np.ndarray[Any, Any]:
    """Angle and rate of the arm."""

    def rates(t: float, y: Any) -> list[float]:
        return [y[1], (law(t) - 0.5 * y[1] - WEIGHT * np.cos(y[0])) / INERTIA]

    return np.asarray(solve_ivp(rates, (0, until), [0, 0], rtol=1e-12, atol=1e-13, max_step=0.01).y[:, -1])


@pytest.mark.parametrize("name", LAWS)
def test_a_force_follows_an_input(name: str) -> None:
    law = {"number": lambda t: 3.0, "formula": lambda t: 4 * np.sin(7 * t), "table": sr.Curve.table(TABLE)}
    run = sr.simulate(sr.System(driven(LAWS[name])), until=0.8, **TIGHT)
    exact = law.get(name, LAWS[name])
    assert [run["pin.angle"][-1], run["pin.rate"][-1]] == pytest.approx(by_scipy(exact, 0.8), rel=1e-8)
    assert run["u"] == pytest.approx([exact(t) for t in run.t], abs=1e-12)
    assert run.output("u").unit == "N m"


def test_states_forces_and_drivers_use_an_input() -> None:
    """A lag of the input, its copy as the tension of a spring, and the motion of a second arm."""
    lag = sr.FirstOrderLag("lag", input="2*u", time=0.1)
    model = arm(sr.Input("u", "4*t", unit="N"), sr.Input("angle_of_arm", "0.3*t^2", unit="rad"), lag)
    body = model.bodies[0]
    spring = sr.TSDA("spring", sr.ground.point(0, 1, 0), body.point(0.5, 0, 0), k=0, length=1, force="u")
    driver = sr.AngleDriver("turn", "pin", "angle_of_arm")
    system = sr.System(sr.Model("arm", [body], model.joints, [*model.forces, spring], drivers=[driver]))
    run = sr.simulate(system, until=0.5, **TIGHT)
    assert run["pin.angle"][-1] == pytest.approx(0.3 * 0.25, abs=1e-12)
    assert run["spring.tension"] == pytest.approx(4 * run.t, abs=1e-12)
    exact = 2 * (4 * run.t - 0.4 * (1 - np.exp(-run.t / 0.1)))
    assert run["lag"] == pytest.approx(exact, abs=1e-9)


def test_the_control_gradient_is_that_of_whole_runs() -> None:
    model = driven(TABLE)
    direct, adjoint = direct_and_adjoint(model, "pin.angle", NAMES[1:], 0.8, 1e-11)
    assert direct == pytest.approx(adjoint, rel=1e-9)
    assert adjoint == pytest.approx(differences(model, "pin.angle", NAMES[1:], 0.8, 1e-3), rel=1e-6)


@pytest.mark.slow
def test_a_response_may_contain_the_input_itself() -> None:
    """The energy of a control, ∫u² dt, depends on the table alone; its second derivatives are constant."""
    run = sr.simulate(sr.System(driven(TABLE)), until=0.8, store="steps")
    response = sr.Integral(lambda o: o("u") ** 2)
    found = sr.sensitivity(run, response, wrt=NAMES)
    t = np.linspace(0, 0.8, 2001)
    bases = [sr.Curve.table([[x, float(n == k)] for k, (x, _) in enumerate(TABLE)]) for n in range(5)]
    along = np.array([[one(x) for x in t] for one in bases])
    weights = np.full(len(t), 0.8 / 2000) * np.where(np.arange(len(t)) % 2, 4, 2) / 3
    weights[[0, -1]] /= 2
    matrix = 2 * (along * weights) @ along.T
    exact = matrix @ [y for _, y in TABLE]
    assert [found[name] for name in NAMES] == pytest.approx(exact, rel=1e-6)
    second = sr.hessian(run, response, wrt=NAMES)
    assert np.array(second.matrix) == pytest.approx(matrix, rel=1e-6, abs=1e-9)


def test_a_run_may_have_values_of_its_own() -> None:
    system = sr.System(driven())
    run = sr.simulate(system, until=0.5, inputs={"u": "2*t"}, **TIGHT)
    assert run["pin.angle"][-1] == pytest.approx(by_scipy(lambda t: 2 * t, 0.5)[0], rel=1e-8)
    given = system.with_inputs({"u": 3.0})
    assert given.b[given.inputs["u"].places] == pytest.approx([3.0, 3.0])


def test_a_file_has_inputs_and_values_of_a_run_replace_its_parameters(tmp_path: Path) -> None:
    text = """
name: arm
parameters: {T0: 3}
bodies: {arm: {mass: 2, inertia: [0.1, 0.15, 0.2], position: [0.5, 0, 0]}}
joints: {pin: {type: revolute, bodies: [ground, arm], point: [0, 0, 0], axis: [0, 0, 1]}}
forces:
  u: {type: input, value: 2*T0, unit: N m}
  motor: {type: torque, joint: pin, value: u - 0.5*pin.rate}
"""
    (tmp_path / "arm.yaml").write_text(text)
    model = sr.load(tmp_path / "arm.yaml")
    run = sr.simulate(sr.System(model), until=0.5, store="steps")
    by_input = sr.sensitivity(run, sr.Final("pin.angle"), wrt=["u.value"])["u.value"]
    assert sr.sensitivity(run, sr.Final("pin.angle"), wrt=["T0"])["T0"] == pytest.approx(2 * by_input)
    run = sr.simulate(sr.System(model), until=0.5, store="steps", inputs={"u": 6.0})
    assert sr.sensitivity(run, sr.Final("pin.angle"), wrt=["T0"])["T0"] == 0.0
    moved = text.replace("motor: {type: torque, joint: pin, value: u - 0.5*pin.rate}", "").replace(
        "2*T0, unit: N m", "T0*t"
    )
    (tmp_path / "moved.yaml").write_text(
        f"{moved}\ndrivers: {{turn: {{type: angle, joint: pin, motion: u}}}}"
    )
    driven_arm = sr.System(sr.load(tmp_path / "moved.yaml"))
    assert sr.simulate(driven_arm, until=0.5)["pin.angle"][-1] == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("analysis", "options"),
    [("simulate", {"until": 1.0}), ("equilibrium", {}), ("inverse_dynamics", {"run": None})],
)
def test_an_input_that_is_not_set_is_refused(analysis: str, options: Any) -> None:
    system = sr.System(driven())
    assert sr.assemble(system).success
    with pytest.raises(SarrusError, match="the input u is not set"):
        getattr(sr, analysis)(system, **options)


def test_a_driver_that_follows_an_input_that_is_not_set_is_refused() -> None:
    model = arm(sr.Input("u", unit="rad"))
    turn = sr.AngleDriver("turn", "pin", "u")
    system = sr.System(sr.Model("arm", model.bodies, model.joints, model.forces, drivers=[turn]))
    with pytest.raises(SarrusError, match="the input u is not set"):
        sr.kinematics(system, [0.0, 1.0])
    run = sr.kinematics(system.with_inputs({"u": "0.3*t"}), [0.0, 1.0])
    assert run["pin.angle"][-1] == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize(
    ("law", "value", "message"),
    [
        ("pin.angle", "u", 'value depends on "pin.angle"'),
        ("3 m", "u", "expects N m"),
        ("w", "u", "unknown name"),
        ([[0, 1], [0, 2]], "u", "rising"),
        (float("nan"), "u", "finite"),
    ],
)
def test_wrong_inputs_are_refused(law: Any, value: str, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        sr.System(driven(law, value))


def test_wrong_uses_of_inputs_are_refused() -> None:
    source, pin = sr.Input("u", 1.0, unit="m"), arm().joints
    for motion, message in (("u", "is in rad, but the input u in m"), ("2*u", "name alone")):
        driver = sr.AngleDriver("turn", "pin", motion)
        model = sr.Model("arm", arm().bodies, pin, [source], drivers=[driver])
        with pytest.raises(ModelError, match=message):
            sr.System(model)
    with pytest.raises(ModelError, match="Rename the input"):
        sr.System(arm(sr.Input("rate", 1.0)))
    with pytest.raises(ModelError, match='no input "v"'):
        sr.System(driven(1.0)).with_inputs({"v": 1.0})
    tyre = sr.RoadTyre("tyre", arm().bodies[0].point(0.5, 0, 0), k=1.0, c=0.0, radius=0.1, bump="u")
    with pytest.raises(ModelError, match="bump cannot follow the input u"):
        sr.System(arm(source, tyre))


def lifted(**given: Any) -> tuple[Any, ...]:
    """A spring between the arm and the ground."""
    ends = sr.ground.point(0, 1, 0), arm().bodies[0].point(0.5, 0, 0)
    return (sr.TSDA("part", *ends, **{"k": 0, "length": 1} | given),)


ARGUMENTS: dict[str, tuple[tuple[Any, ...], tuple[Any, ...], str]] = {
    "motion": ((), (sr.AngleDriver("part", "pin", lambda u: 2 * u),), 'motion is .* u, an input. Write "u" for the'),
    "force of a spring": (lifted(force=lambda u: 2 * u), (), 'force is .* u, an input. Write "u" for the input'),
    "input": ((sr.Input("part", lambda lag: 2 * lag),), (), "value is a function of lag, a state. Write lambda t: "),
    "input of itself": ((sr.Input("part", lambda part: part),), (), "value is .* part, an input. Write lambda t"),
    "input of an input": ((sr.Input("part", sr.Formula(lambda u: 2 * u)),), (), 'value is .* u, an input. Write "u"'),
    "torque": ((sr.Torque("part", "pin", value=lambda u: 2 * u),), (), r'value is .* Write lambda o: o\["u"\], or a'),
    "forces": (
        (sr.PointForce("part", arm().bodies[0].point(0.5, 0, 0), [0, 0, lambda u: u]),), (),
        r'force is .* Write lambda o: o\["u"\]'
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", ARGUMENTS)
def test_functions_of_one_variable_whose_argument_is_called_as_an_input_are_refused(case: str) -> None:
    """The argument would be the time, and not the input."""
    forces, drivers, message = ARGUMENTS[case]
    lag = sr.FirstOrderLag("lag", input="u", time=0.1)
    model = arm(sr.Input("u", 1.0), lag, *forces)
    with pytest.raises(ModelError, match=f'"part": {message}'):
        sr.System(sr.Model("arm", model.bodies, model.joints, model.forces, drivers=list(drivers)))


def test_a_function_of_a_length_alone_has_an_argument_of_any_name() -> None:
    """A stiffness or a damping is no function of inputs and states, so nobody means one by the name."""
    source, lag = sr.Input("u", 1.0), sr.FirstOrderLag("lag", input="u", time=0.1)
    spring = lifted(k=lambda u: 2 * u, c=lambda lag: 3 * lag)
    named, usual = (
        sr.System(arm(source, lag, *one)) for one in (spring, lifted(k=lambda x: 2 * x, c=lambda x: 3 * x))
    )
    q, v = usual.q0, np.linspace(0.1, 0.2, usual.nq)
    assert np.array_equal(named.Q(q, v, 0.0), usual.Q(q, v, 0.0))
    assert named.Q(q, v, 0.0).any()


def test_values_of_a_run_are_at_its_time() -> None:
    """A run from a state of another one goes on in the input's table."""
    system = sr.System(driven(TABLE))
    run = sr.simulate(system, until=0.8, **TIGHT)
    rest = sr.simulate(system, run.state(0.3), until=0.8, **TIGHT)
    assert value(rest, "pin.angle")[-1] == pytest.approx(run["pin.angle"][-1], rel=1e-8)
