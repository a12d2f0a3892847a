"""Derivatives through sampled controllers: forward, backward, second ones, and differences of whole runs."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.states.motors import TIGHT, arm

import sarrus as sr
from sarrus.model import SarrusError
from sarrus.model.written import with_numbers, written_numbers

NAMES = ["kp.value", "lag.time", "arm.mass", "pin.point.x", "load.value.1"]
RESPONSES = [
    sr.Final("pin.angle"),
    sr.Final("integral"),
    sr.At("pin.rate", time=0.21),
    sr.Integral(lambda o: o("pin.angle") * o("u"), name="product"),
]
UNTIL = 0.32


def model() -> sr.Model:
    """The arm on a lagging actuator; a gain of the controller is an input, and the load jumps at a sample."""
    lag = sr.FirstOrderLag("lag", input="u", time=0.05)
    load = sr.Torque("load", "pin", value="2*step(t - 0.2) - 0.1*v")
    return arm(
        sr.Input("u", unit="N m"), sr.Input("w"), sr.Input("kp", 40.0), lag, load,
        sr.Torque("motor", "pin", value="lag + w"),
    )  # fmt: skip


def servo(t: float, o: Any) -> dict[str, Any]:
    """A discrete PI controller with a limit, of an arm whose speed is read by a curve."""
    error = 0.7 - o["pin.angle"]
    integral = o["integral"] + 0.05 * error
    return {
        "u": np.clip(o["kp"] * error - 6 * np.tanh(o["pin.rate"]) + 20 * integral, -60, 60),
        "integral": integral,
    }


def disturbance(t: float, o: Any) -> dict[str, Any]:
    """Of another period, which reads the first one's input."""
    return {"w": 0.2 * o["u"] * np.sin(9 * t) * o["arm.x"]}


CONTROLLERS = [
    sr.Controller(servo, period=0.05, memory={"integral": 0.01}),
    sr.Controller(disturbance, period=0.1),
]


def run(changes: Mapping[str, float] | None = None, **options: Any) -> sr.Trajectory:
    """A run with the controllers."""
    system = sr.System(with_numbers(model(), changes or {}))
    found = sr.simulate(system, until=UNTIL, controllers=CONTROLLERS, **options)
    assert found.success
    return found


@cache
def stored(method: Any = None) -> sr.Trajectory:
    """One with its steps."""
    return run(store="steps", method=replace(method, rtol=1e-6) if method else sr.Radau(rtol=1e-10))


def test_stored_steps_do_not_change_a_run() -> None:
    one, other = run(**TIGHT), stored()
    for name in ("pin.angle", "pin.rate", "lag", "integral"):
        assert one[name] == pytest.approx(other[name], abs=1e-8), name
    assert one["u"][0] == pytest.approx(other["u"][0], rel=1e-14)
    assert one["u"][0] == pytest.approx(40 * 0.7 + 20 * (0.01 + 0.05 * 0.7))


@pytest.mark.slow
@pytest.mark.parametrize("method", [None, sr.HHT()], ids=["Radau", "HHT"])
def test_direct_is_adjoint(method: Any) -> None:
    direct, adjoint = (
        sr.sensitivity(stored(method), RESPONSES, wrt=NAMES, method=how).matrix
        for how in ("direct", "adjoint")
    )
    scale = abs(direct).max(axis=1, keepdims=True)
    assert np.all(scale > 0)
    assert np.all(abs(direct - adjoint) < 1e-11 * scale)


def values(found: sr.Trajectory) -> np.ndarray[Any, Any]:
    """The first three responses."""
    return np.array([found["pin.angle"][-1], found["integral"][-1], found["pin.rate"][0]])


def test_gradients_are_differences_of_whole_runs() -> None:
    gradient = sr.sensitivity(stored(), RESPONSES[:3], wrt=NAMES)
    numbers = written_numbers(model())
    for name in NAMES:
        h = 1e-4 * max(abs(numbers[name]), 1.0) * (0.05 if name == "lag.time" else 1.0)
        low, high = (
            values(run({name: numbers[name] + s * h}, t_eval=[0.21, UNTIL], **TIGHT)) for s in (-1, 1)
        )
        assert gradient[name] == pytest.approx((high - low) / (2 * h), rel=1e-6, abs=1e-8), name


@pytest.mark.slow
def test_second_derivatives_are_differences_of_gradients() -> None:
    names, response, h = NAMES[:4], sr.Final("pin.angle"), 1e-5
    H, numbers = sr.hessian(stored(), response, wrt=names), written_numbers(model())
    assert H.matrix == pytest.approx(H.matrix.T, rel=1e-9, abs=1e-12)
    for name in ("kp.value", "lag.time", "pin.point.x"):
        low, high = (
            sr.sensitivity(
                run({name: numbers[name] + s * h}, store="steps", method=sr.Radau(rtol=1e-11)),
                response,
                wrt=names,
            )
            for s in (-1, 1)
        )
        wanted = [(high[one] - low[one]) / (2 * h) for one in names]
        assert [H[name, one] for one in names] == pytest.approx(wanted, rel=1e-4, abs=1e-4), name


def slower(t: float, q: Any, v: Any) -> Any:
    """Half of the velocities of the arm."""
    return np.concatenate([0.5 * v[:7], v[7:]])


@pytest.mark.slow
def test_events_between_samples() -> None:
    """New velocities, which the next sample reads."""
    found = run(store="steps", events=sr.Event("pin.angle - 0.1", direction=1, reset=slower, name="brake"))
    assert len(found.events) == 1
    direct, adjoint = (
        sr.sensitivity(found, RESPONSES[:2], wrt=NAMES, method=how).matrix for how in ("direct", "adjoint")
    )
    assert np.all(abs(direct - adjoint) < 1e-11 * abs(direct).max())


def test_a_run_with_controllers_meets_a_goal() -> None:
    found = sr.simulate(
        sr.System(model()),
        until=UNTIL,
        controllers=CONTROLLERS,
        limits=sr.Limits(errors={"pin.angle": 1e-9}),
        method=sr.Radau(rtol=1e-5),
    )
    assert found.success
    assert found["pin.angle"][-1] == pytest.approx(stored()["pin.angle"][-1], abs=2e-9)


class Integrating:
    """A controller with a memory of its own, which is as before if it is called twice at one time or begins anew."""

    def __init__(self, careful: bool) -> None:
        self.integral, self.last, self.careful = 0.0, -1.0, careful

    def __call__(self, t: float, o: Any) -> dict[str, Any]:
        """A PI controller."""
        if self.careful and t == 0.0:
            self.integral, self.last = 0.0, -1.0
        error = 0.7 - o["pin.angle"]
        if t > self.last or not self.careful:
            self.integral, self.last = self.integral + 0.05 * error, t
        return {"u": 40 * error + 20 * self.integral}


def drawn(t: float, o: Any) -> dict[str, Any]:
    """Another value at every call."""
    return {"u": np.random.default_rng().normal()}


def switching(t: float, o: Any) -> dict[str, Any]:
    """A function with a branch."""
    return {"u": 1.0 if o["pin.angle"] > 0 else -1.0}


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (Integrating(careful=False), "when it was called again. Derivatives need the memory of a controller by name"),
        (Integrating(careful=True), "has a memory of its own. Derivatives need the memory"),
        (drawn, "drawn: it returned .* when it was called again"),
        (switching, "switching: it cannot be differentiated: a formula must not branch"),
        (lambda t, o: {"u": np.sign(o["pin.angle"])}, "cannot be differentiated: numpy.sign jumps"),
    ],
)  # fmt: skip
def test_controllers_that_cannot_be_recorded_are_refused_with_stored_steps(
    function: Any, message: str
) -> None:
    system = sr.System(arm(sr.Input("u"), sr.Torque("motor", "pin", value="u")))
    with pytest.raises(SarrusError, match=message):
        sr.simulate(system, until=0.2, controllers=[sr.Controller(function, period=0.05)], store="steps")


@pytest.mark.one_in(8)
@pytest.mark.parametrize("torque", np.linspace(12.0, 31.0, 20))
def test_functions_without_memory_are_recorded_from_any_start(torque: float) -> None:
    """Whose outputs have the same bits when they are read again, also those that are read later."""

    def balance(t: float, o: Any) -> dict[str, Any]:
        late = o["arm.y"] if t > 0.23 else 0.0
        return {"u": -3.3 * np.sin(o["pin.angle"]) - 0.7 * o["pin.rate"] - 0.1 * o["arm.x"] - 0.3 * late}

    system = sr.System(arm(sr.Input("u"), sr.Torque("motor", "pin", value="u")))
    begin = sr.simulate(system, until=0.2, t_eval=[0.2], inputs={"u": torque}).final
    controllers = [sr.Controller(balance, period=0.02)]
    found = sr.simulate(system, begin, until=0.27, controllers=controllers, store="steps")
    first = {name: found[name][0] for name in ("pin.angle", "pin.rate", "arm.x")}
    assert found["u"][0] == pytest.approx(balance(0.2, first)["u"], abs=1e-9)
    assert np.isfinite(sr.sensitivity(found, sr.Final("pin.angle"), wrt=["arm.mass"])["arm.mass"])


class Restarting:
    """One that begins anew when the time goes back, and is as before if it is called twice at one time."""

    integral, last = 0.0, -1.0

    def __call__(self, t: float, o: Any) -> dict[str, Any]:
        """A PI controller."""
        if t < self.last:
            self.integral, self.last = 0.0, -1.0
        error = 0.7 - o["pin.angle"]
        if t > self.last:
            self.integral, self.last = self.integral + 0.05 * error, t
        return {"u": 40 * error + 20 * self.integral}


def test_a_memory_that_a_run_alone_has_is_found_by_derivatives() -> None:
    """Of a function that begins to remember after the start."""
    count = [0]

    def counting(t: float, o: Any) -> dict[str, Any]:
        count[0] += t > 0.0
        return {"u": 5.0 * o["pin.angle"] + max(count[0] - 1, 0)}

    system = sr.System(arm(sr.Input("u"), sr.Torque("motor", "pin", value="u")))
    found = sr.simulate(system, until=0.2, controllers=[sr.Controller(counting, period=0.05)], store="steps")
    with pytest.raises(SarrusError, match=r"counting: it returned .* at t = .* s in the run, but"):
        sr.sensitivity(found, sr.Final("pin.angle"), wrt=["arm.mass"])


@pytest.mark.parametrize("how", ["direct", "adjoint"])
def test_a_memory_that_begins_anew_is_found_by_derivatives(how: str) -> None:
    system = sr.System(arm(sr.Input("u"), sr.Torque("motor", "pin", value="u")))
    controllers = [sr.Controller(Restarting(), period=0.05)]
    found = sr.simulate(system, until=0.2, controllers=controllers, store="steps")
    with pytest.raises(SarrusError, match="Derivatives need the memory of a controller by name"):
        sr.sensitivity(found, sr.Final("pin.angle"), wrt=["arm.mass"], method=how)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("jump", [0.0, 0.5])
def test_loads_that_jump_at_a_sample_leave_the_order_of_the_method(jump: float) -> None:
    """Errors of HHT, of the motion and of its derivative, fall with the square of the step."""
    body = sr.Body("b", 1.0, (1.0, 1.0, 1.0))
    guide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(-2, 0, 0), body.point(0, 0, 0), k=4.0, length=2.0)
    forces = [spring, sr.Force("f", joint="g", value=f"10*step(t - {jump}) + u"), sr.Input("u", unit="N")]
    own = sr.System(sr.Model("pushed", [body], [guide], forces))
    held = [sr.Controller(lambda t, o: {"u": -0.5 * o["g.displacement"]}, period=0.1)]

    def found(**settings: Any) -> np.ndarray:
        run = sr.simulate(own, until=1.0, controllers=held, store="steps", **settings)
        gradient = sr.sensitivity(run, sr.Final("b.x"), ["s.k"])
        return np.array([gradient.values[0], gradient.matrix[0, 0]])

    true = found(method=sr.Radau(rtol=1e-12))
    coarse, fine = (abs(found(method=sr.HHT(step=h)) / true - 1) for h in (0.01, 0.005))
    assert np.all(coarse < 1e-3)
    np.testing.assert_allclose(coarse / fine, 4.0, rtol=0.05)
