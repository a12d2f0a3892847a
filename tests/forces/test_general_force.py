"""Forces by formulas and functions of outputs and the time, against the reduced equations in SciPy."""

import math
import pickle
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sarrus as sr
from sarrus import functions as f
from sarrus.elements import Element
from sarrus.model import ModelError
from sarrus.model.forces.formula_element import FormulaLoad

G, M, R, I = 9.81, 2.0, 0.5, 0.2  # of the arm: gravity, mass, distance of its centre, inertia about it
TABLE = [[-20.0, 9.0], [-5.0, 7.0], [0.0, 6.0], [3.0, 5.0], [8.0, 1.0], [20.0, -8.0]]
TOL: dict[str, Any] = {"method": sr.Radau(rtol=1e-11, atol=1e-12)}


def arm(*forces: Any, drag: Any = None) -> sr.Model:
    body = sr.Body("arm", mass=M, inertia=(0.1, 0.15, I), position=(R, 0, 0))
    pin = sr.Revolute("pin", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    own = [make(body) for make in forces]
    return sr.Model("arm", [body], [pin], own, gravity=(0, -G, 0))


def strut(**given: Any) -> Any:
    return lambda body: sr.Force("strut", sr.ground.point(0.3, 2, 0), body.point(R, 0, 0), **given)


def motor(**given: Any) -> Any:
    return lambda body: sr.Torque("motor", "pin", **given)


def reduced(torque: Any, until: float = 2.0) -> np.ndarray[Any, Any]:
    """θ and θ̇ at the end of (I + m R²) θ̈ = torque(θ, θ̇, t) − m g R cos θ."""
    inertia = I + M * R**2

    def rates(t: float, y: Any) -> Any:
        return [y[1], (torque(*y, t) - M * G * R * np.cos(y[0])) / inertia]

    return np.asarray(solve_ivp(rates, (0, until), [0.0, 0.0], "DOP853", rtol=1e-13, atol=1e-13).y[:, -1])


def reached(model: sr.Model, until: float = 2.0) -> np.ndarray[Any, Any]:
    run = sr.simulate(sr.System(model), until=until, **TOL)
    assert run.message == "reached the end"
    return np.array([run.output("pin.angle").values[-1], run.output("pin.angle.rate").values[-1]])


def line(angle: float, rate: float) -> tuple[float, float, float]:
    """Length from (0.3, 2) to the arm's tip at 2 R, its rate, and its derivative by the angle."""
    tip, tip_by = (
        2 * R * np.array([np.cos(angle), np.sin(angle)]),
        2 * R * np.array([-np.sin(angle), np.cos(angle)]),
    )
    d = tip - (0.3, 2.0)
    length = float(np.hypot(*d))
    by = float(d @ tip_by) / length
    return length, by * rate, by


MOTORS = {
    "text": {"value": "(T0 - k*pin.rate)*step(t, 0, 0, 0.5, 1)", "parameters": {"T0": 14.0, "k": 1.5}},
    "text in x and v": {"value": "(14 - 1.5*v)*step(t, 0, 0, 0.5, 1)"},
    "function of outputs": {"value": lambda o: (14 - 1.5 * o["pin.angle.rate"]) * f.step(o.t, 0, 0, 0.5, 1)},
    "function of x, v and t": {"value": lambda v, t: (14 - 1.5 * v) * f.step(t, 0, 0, 0.5, 1)},
    "scaled": {"value": "7 - 0.75*arm.angular_velocity.z", "factor": "2*step(t, 0, 0, 0.5, 1)"},
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("given", MOTORS.values(), ids=MOTORS)
def test_a_motor_that_loses_torque_with_speed(given: Any) -> None:
    def torque(angle: float, rate: float, t: float) -> float:
        s = min(t / 0.5, 1)
        return (14 - 1.5 * rate) * s * s * (3 - 2 * s)

    assert reached(arm(motor(**given))) == pytest.approx(reduced(torque), abs=1e-8)


def test_a_motor_by_a_table_over_speed() -> None:
    curve = sr.Curve.table(TABLE)
    found = reached(arm(motor(value=TABLE, over="pin.rate")))
    assert found == pytest.approx(reduced(lambda angle, rate, t: curve(rate)), abs=1e-8)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "value",
    [
        "-(k*(length - 1.2) + c*rate*abs(rate))*(1 + 0.5*sin(3*t))",
        lambda o: -(8 * (o.x - 1.2) + o.v * abs(o.v)) * (1 + 0.5 * f.sin(3 * o.t))],
    ids=["text", "function"],
)  # fmt: skip
def test_a_force_of_length_rate_and_time_between_points(value: Any) -> None:
    def torque(angle: float, rate: float, t: float) -> float:
        length, speed, by = line(angle, rate)
        return -by * (8 * (length - 1.2) + speed * abs(speed)) * (1 + 0.5 * math.sin(3 * t))

    def tipped(body: Any) -> Any:
        parameters = {"k": 8.0, "c": 1.0}
        return sr.Force(
            "strut", sr.ground.point(0.3, 2, 0), body.point(R, 0, 0), value=value, parameters=parameters
        )

    assert reached(arm(tipped)) == pytest.approx(reduced(torque), abs=1e-8)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("axes", ["global", "body"])
def test_vectors_of_outputs_at_a_point_and_on_a_body(axes: Any) -> None:
    """Along the body's y axis the arm of the force is R, along the global one R cos θ."""

    def loads(body: Any) -> Any:
        return sr.PointForce(
            "drag",
            body.point(0, 0, 0),
            force=[0, "-c*arm.velocity.y", lambda o: o["pin"]],
            axes=axes,
            parameters={"c": 2.0},
        )

    def twist(body: Any) -> Any:
        return sr.Torque("twist", body, [0, 0, "-3*pin*step(t - 1)"], axes=axes)

    def torque(angle: float, rate: float, t: float) -> float:
        up: float = -2.0 * R * math.cos(angle) * rate
        return up * R * (math.cos(angle) if axes == "global" else 1) - 3 * angle * (t > 1)

    found = reached(arm(loads, twist))
    first = solve(torque, (0, 1), [0.0, 0.0])
    assert found == pytest.approx(solve(torque, (1 + 1e-15, 2), first), abs=1e-8)


def solve(torque: Any, span: tuple[float, float], start: Any) -> Any:
    inertia = I + M * R**2
    rates = lambda t, y: [y[1], (torque(*y, t) - M * G * R * np.cos(y[0])) / inertia]  # noqa: E731
    return solve_ivp(rates, span, start, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]


def whole() -> sr.Model:
    return arm(
        strut(value="-k*(length - 1.2)*(1 + 0.1*pin.angle**2) - c*v", parameters={"k": 8.0, "c": 1.0}),
        motor(value="(T0 - k*pin.rate)*step(t, 0, 0, 0.5, 1)", parameters={"T0": 14.0, "k": 1.5}),
        lambda body: sr.Torque("curve", "pin", value=TABLE, over="pin.rate + arm.y"),
        lambda body: sr.PointForce(
            "drag", body.point(0.1, 0, 0), ["-0.3*arm.velocity.x", "sin(t)*strut2.length", 0]
        ),
        lambda body: sr.TSDA("strut2", sr.ground.point(0, -1, 0), body.point(0, 0, 0), k=3.0, length=1.0),
    )


WRT = [
    "motor.parameters.T0",
    "motor.parameters.k",
    "strut.parameters.k",
    "strut.value.1",
    "curve.value.3.y",
    "drag.force.x.1",
]


class Drag:
    """A callable object."""

    def __call__(self, outputs: Any) -> Any:
        return -2 * outputs["arm.velocity.x"]


FUNCTIONS: dict[str, tuple[Any, float]] = {  # at the velocity 3 m/s and the time 1.5 s, with k = 5
    "any name for all outputs": (lambda out: -2 * out["arm.velocity.x"], -6),
    "one output by an attribute": (lambda out: 2 * out.t, 3),
    "an object": (Drag(), -6),
    "a formula": (sr.Formula(Drag()), -6),
    "a partial function of outputs": (partial(lambda o, c: -c * o["arm.velocity.x"], c=2), -6),
    "a partial function of a parameter": (partial(lambda c, k: c * k, 2), 10),
    "a parameter alone": (lambda k: 3 * k, 15),
    "a parameter and the time": (lambda k, t: k * t, 7.5),
    "the time by its name alone": (partial(lambda k, t: k * t, k=4), 6),
    "the time by any name": (lambda s: 3 * s, 4.5),
    "a number that a loop fixes": (lambda t, c=4: c * t, 6),
    "a function of NumPy": (np.sin, np.sin(1.5)),
    "a function of Sarrus": (f.sin, np.sin(1.5)),
    "any number of arguments": (lambda *a: a[0], 1.5),
}


@pytest.mark.parametrize("beside", [0.0, "0*arm.x"], ids=["alone", "beside a formula of outputs"])
@pytest.mark.parametrize(("function", "value"), FUNCTIONS.values(), ids=FUNCTIONS)
def test_functions_are_called_with_what_their_arguments_name(
    function: Any, value: float, beside: Any
) -> None:
    body = sr.Body("arm", mass=M, inertia=(0.1, 0.15, I))
    push = sr.PointForce("push", body.point(0, 0, 0), (function, beside, 0), parameters={"k": 5.0})
    system = sr.System(sr.Model("free", [body], forces=[push]))
    v = np.array([3.0, 0, 0, 0, 0, 0, 0])
    assert system.Q(system.q0, v, 1.5)[0] == pytest.approx(value, rel=1e-14)


def test_a_compiled_function_that_cannot_be_recorded_is_refused_by_name() -> None:
    with pytest.raises(ModelError, match='force "t": torque cannot be used as a formula'):
        sr.System(arm(lambda body: sr.Torque("t", body, (0, 0, max))))


def test_a_factor_may_be_a_table_over_time() -> None:
    table = [[0, 0], [1, 2], [2, 2]]
    model = arm(
        lambda body: sr.PointForce("f", body.point(0, 0, 0), ("-3*arm.velocity.x", 0, 0), factor=table)
    )
    scaled = sr.System(model)
    v = np.r_[1.0, np.zeros(6)]
    assert scaled.Q(scaled.q0, v, 1.5)[0] == pytest.approx(-3 * sr.Curve.table(table)(1.5), rel=1e-14)


def test_parameters_whose_names_are_equal_to_python_keep_their_values() -> None:
    """Python takes the micro sign and the Greek letter for one name."""
    names = {"\N{MICRO SIGN}": 1.0, "\N{GREEK SMALL LETTER MU}": 20.0}
    model = arm(motor(value=f"{' + 2*'.join(names)}", parameters=names))
    system = sr.System(model)
    assert system.Q(system.q0, system.v0, 0.0)[6] / 2 == pytest.approx(41)
    run = sr.simulate(system, until=0.1, store="steps")
    found = sr.sensitivity(run, sr.Final("pin.angle"), [f"motor.parameters.{name}" for name in names])
    assert found.matrix[0, 1] == pytest.approx(2 * found.matrix[0, 0], rel=1e-9)


def test_elements_may_be_created_while_another_thread_iterates_over_those_that_are_registered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Element, "registry", dict(Element.registry))
    iterated = iter(Element.registry.values())
    next(iterated)
    type(
        "Late", (FormulaLoad,), {"__annotations__": {}, "structure": None}, bodies=1, derivatives="automatic"
    )
    sr.System(arm(motor(value="v*v*v*t*1.25")))
    assert "Late" in Element.registry
    assert not {"Load", "Late"} & {one.__name__ for one in iterated}


@pytest.mark.slow
def test_all_derivatives_of_the_operators_are_exact() -> None:
    report = sr.System(whole()).check_derivatives()
    assert report, report


@pytest.mark.slow
def test_gradients_agree_with_each_other_and_with_differences() -> None:
    from sarrus.model.written import with_numbers, written_numbers

    model = whole()
    known = written_numbers(model)
    run = sr.simulate(sr.System(model), until=1.0, **TOL, store="steps")
    response = sr.Final("pin.angle")
    adjoint = sr.sensitivity(run, response, wrt=WRT)
    direct = sr.sensitivity(run, response, wrt=WRT, method="direct")
    assert direct.matrix == pytest.approx(adjoint.matrix, rel=1e-9, abs=1e-12)
    for n, name in enumerate(WRT):
        h = 1e-3

        def end(shift: float, name: str = name) -> float:
            changed = with_numbers(model, {name: known[name] + shift})
            return float(reached(changed, 1.0)[0])

        fourth = (8 * (end(h) - end(-h)) - end(2 * h) + end(-2 * h)) / (12 * h)
        assert adjoint.matrix[0, n] == pytest.approx(fourth, rel=1e-6, abs=1e-9), name


@pytest.mark.slow
def test_hessian_agrees_with_differences_of_gradients() -> None:
    from sarrus.model.written import with_numbers, written_numbers

    model, wrt, h = whole(), WRT[:4], 1e-3
    known, response = written_numbers(model), sr.Final("pin.angle")

    def gradient(name: str, shift: float) -> Any:
        changed = with_numbers(model, {name: known[name] + shift})
        run = sr.simulate(sr.System(changed), until=1.0, **TOL, store="steps")
        return sr.sensitivity(run, response, wrt=wrt).matrix[0]

    run = sr.simulate(sr.System(model), until=1.0, **TOL, store="steps")
    hessian = sr.hessian(run, response, wrt=wrt)
    for n, name in enumerate(wrt):
        differences = (gradient(name, h) - gradient(name, -h)) / (2 * h)
        assert np.asarray(hessian.matrix)[n] == pytest.approx(differences, rel=1e-4, abs=1e-7), name


FILE = """
name: arm
gravity: [0, -9.81, 0]
parameters: {T0: 14 N*m, slope: 1.5, lag: 500 ms}
bodies:
  arm: {mass: 2, inertia: [0.1, 0.15, 0.2], position: [0.5, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, arm], point: [0, 0, 0], axis: [0, 0, 1]}
forces:
  motor: {type: torque, joint: pin, value: "(T0 - slope*pin.rate)*step(t, 0, 0, lag, 1)"}
  strut:
    type: force
    points: [{body: ground, at: [0.3, 2, 0]}, {body: arm, at: [0.5, 0, 0]}]
    value: -k*(x - 1.2 m) - 0.2*v
    parameters: {k: 8 N/m}
  drag: {type: point_force, point: {body: arm, at: [0, 0, 0]}, force: ["-slope*arm.velocity.x", "sin(t)", 0]}
  curve: {type: torque, joint: pin, value: {table: [[-9, 2], [0, 1], [9, -2]]}, over: pin.rate}
"""


@pytest.mark.slow
def test_files_have_the_same_forces_and_their_parameters_have_derivatives(tmp_path: Path) -> None:
    (tmp_path / "arm.yaml").write_text(FILE)
    loaded = sr.load(tmp_path / "arm.yaml")
    same = arm(
        motor(value="(14 - 1.5*v)*step(t, 0, 0, 0.5, 1)"),
        strut(value=lambda x, v: -8 * (x - 1.2) - 0.2 * v),
        lambda body: sr.PointForce("drag", body.point(0, 0, 0), ["-1.5*arm.velocity.x", "sin(t)", 0]),
        lambda body: sr.Torque("curve", "pin", value=[[-9, 2], [0, 1], [9, -2]], over="v"),
    )
    assert reached(loaded, 1.0) == pytest.approx(reached(same, 1.0), rel=1e-10)
    run = sr.simulate(sr.System(loaded), until=1.0, **TOL, store="steps")
    found = sr.sensitivity(run, sr.Final("pin.angle"), wrt=["T0", "slope"])
    for n, (name, value, h) in enumerate((("T0", 14.0, 1e-3), ("slope", 1.5, 1e-3))):
        ends = [
            reached(sr.load(tmp_path / "arm.yaml", parameters={name: value + s}), 1.0)[0] for s in (h, -h)
        ]
        assert found.matrix[0, n] == pytest.approx((ends[0] - ends[1]) / (2 * h), rel=1e-6)


def test_saved_forces_are_read_back(tmp_path: Path) -> None:
    model = whole()
    model.save(tmp_path / "arm.yaml")
    text, again = (tmp_path / "arm.yaml").read_text(), sr.load(tmp_path / "arm.yaml")
    assert "(T0 - k*pin.rate)*step(t, 0, 0, 0.5, 1)" in text
    assert reached(again, 0.5) == pytest.approx(reached(model, 0.5), rel=1e-14)
    with pytest.raises(ModelError, match="value is a Python function of outputs"):
        arm(motor(value=lambda v: -2 * v)).save(tmp_path / "function.yaml")


def test_a_system_with_them_is_pickled() -> None:
    """As studies do, which hand systems to other processes."""
    system = sr.System(whole())
    again = pickle.loads(pickle.dumps(system))
    assert [p.kind for p in again.populations] == [p.kind for p in system.populations]
    assert np.array_equal(again.b, system.b)


def test_the_value_is_an_output() -> None:
    run = sr.simulate(sr.System(arm(motor(value="14 - 1.5*v"), strut(value="-3*rate"))), until=0.5)
    rate = run.output("pin.angle.rate").values
    assert run.output("motor.value").values == pytest.approx(14 - 1.5 * rate)
    assert run.output("strut.value").values == pytest.approx(-3 * run.output("strut.rate").values)
    assert run.output("strut.power").values == pytest.approx(-3 * run.output("strut.rate").values ** 2)


WRONG: list[tuple[Any, str]] = [
    (motor(value="5*pinn.rate"), r'motor.*value has the unknown name "pinn.rate". Did you mean "pin"'),
    (motor(value="5*pin.rat"), 'which pin does not have. Did you mean "pin.rate"'),
    (motor(value="5*T0"), 'unknown name "T0"'),
    (motor(value="5*arm.acceleration.x"), "cannot depend on accelerations"),
    (motor(value="-5*sign(pin.rate)"), r"jumps with pin.rate and not only with t. Use tanh\("),
    (motor(value="step(v)"), "jumps with v and not"),
    (motor(value="step(t - a)", parameters={"a": 1.0}), "jumps with a and not"),
    (motor(value="step(v, 1)"), "calls step with 2 arguments. Give it 5"),
    (motor(value=lambda x: 5 if x > 0 else 3), "must not branch"),
    (motor(value=lambda x, w: 5), "has the argument w. Name its arguments"),
    (motor(value=lambda x: np.random.default_rng().normal() * x), "another function each time"),
    (motor(value=TABLE), "Name an output in over"),
    (motor(value="3 kg"), "expects N m"),
    (motor(value="x", parameters={"x": 1.0}), "which formulas cannot use"),
    (motor(), "needs torque, three components, on a body"),
    (lambda body: sr.Torque("motor", body, value="3"), "needs torque, three components, on a body"),
    (lambda body: sr.Torque("motor", "pin", (1, 0, 0)), 'body must be a body, but is "pin"'),
    (motor(value="T0", parameters=[3.0]), "parameters must be a mapping"),
    (motor(value="T0", parameters={"T0": math.nan}), "parameters.T0 must be a finite number"),
    (lambda body: sr.Torque("t", body, (0, 0, 1), parameters={"a b": 1.0}), "which formulas cannot use"),
    (motor(value="3*v", over="pin.rate"), "over is for a table"),
    (lambda body: sr.Torque("motor", "pim", value="3"), 'no joint "pim". Did you mean "pin"'),
    (lambda body: sr.Force("push", joint="pin", value="3"), 'joint "pin" has no displacement'),
    (lambda body: sr.Force("push", body.point(0, 0, 0), value="3"), "Give point_i and point_j, or joint"),
    (strut(), "value is missing"),
    (lambda body: sr.PointForce("f", body.point(0, 0, 0), ["arm.vx", 0, 0]), 'which arm does not have'),
    (motor(value="pin.angle + pin.rate"), "combines rad and rad s"),
    (motor(value="2*v", factor="1 + pin.angle + pin.rate"), "factor holds a formula in which"),
    (motor(value="2*v", factor="pim.rate"), 'factor has the unknown name "pim.rate"'),
    (motor(value="2*v", factor="3 N * v"), "factor expects a plain number"),
    (motor(value=lambda s: 3 * s), '"motor": value has the argument s. Name its arguments angle, rate, t, v, x,'),
    (motor(value="1/0"), 'value holds "1/0", which divides by zero'),
    (motor(value="v*log(-1)"), "which has no real value there"),
    (motor(value=TABLE, over=3), "over must be an output or a formula as a text, but is 3"),
    (motor(value="motor.value"), "the force motor is itself given by outputs"),
    (lambda body: sr.Torque("t", body, ("3*", 0, 0)), "torque holds a formula in which"),
    (lambda body: sr.Torque("t", body, ("arm.velocity.x", 0, 0), axes="bdy"), 'axes must be "global" or "body"'),
    (lambda body: sr.PointForce("f", body.point(0, 0, 0), ("arm.x", 0, 0), axes="bdy"), 'axes must be "global"'),
]  # fmt: skip


@pytest.mark.parametrize(("make", "message"), WRONG, ids=[str(n) for n in range(len(WRONG))])
def test_mistakes_are_named(make: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        sr.System(arm(make))


def test_forces_are_shown_as_they_are_written() -> None:
    shown = repr(sr.Torque("motor", "pin", value="14 - 1.5*v"))
    assert shown == "Torque('motor', value='14 - 1.5*v', joint='pin')"
    assert isinstance(sr.Force("strut", joint="slide", value=1.0), sr.Force)
