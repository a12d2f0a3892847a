"""Sampled controllers against SciPy on the reduced equations from sample to sample."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.states.motors import INERTIA, TIGHT, WEIGHT, arm

import sarrus as sr
from sarrus.model import SarrusError

PERIOD, UNTIL = 0.05, 0.52


def system() -> sr.System:
    """The arm with a torque that is set, and one that has a value."""
    lag = sr.FirstOrderLag("lag", input="u", time=0.05)
    motor = sr.Torque("motor", "pin", value="u + w")
    return sr.System(arm(sr.Input("u", unit="N m"), sr.Input("w", 1.0), lag, motor))


def law(angle: float, rate: float) -> float:
    """Position control."""
    return 40 * (0.7 - angle) - 6 * rate


def control(t: float, o: Any) -> dict[str, float]:
    """The same, of outputs."""
    return {"u": law(o["pin.angle"], o["pin.rate"])}


def by_scipy() -> tuple[np.ndarray[Any, Any], float]:
    """Angle, rate and lag at the end, and the last torque."""
    y, u, times = np.zeros(3), 0.0, [*np.arange(0, UNTIL, PERIOD), UNTIL]
    for k in range(len(times) - 1):
        u = law(y[0], y[1])

        def rates(t: float, y: Any, u: float = u) -> list[float]:
            return [y[1], (u + 1.0 - WEIGHT * np.cos(y[0])) / INERTIA, (u - y[2]) / 0.05]

        y = solve_ivp(rates, times[k : k + 2], y, rtol=1e-12, atol=1e-13).y[:, -1]
    return np.asarray(y), u


@pytest.mark.parametrize("start", [0.0, 0.3])
def test_a_sampled_controller_holds_its_input(start: float) -> None:
    """At any start time."""
    own = system()
    first = sr.assemble(own.with_inputs({"u": 0.0}), t=start)
    times = start + np.array([0.0, 0.02, 0.06, 0.5, UNTIL])
    controllers = [sr.Controller(control, period=PERIOD)]
    run = sr.simulate(own, first, until=start + UNTIL, t_eval=times, controllers=controllers, **TIGHT)
    y, u = by_scipy()
    assert run.success
    assert [run[name][-1] for name in ("pin.angle", "pin.rate", "lag")] == pytest.approx(y, rel=1e-7)
    assert run["u"][-1] == pytest.approx(u, rel=1e-7)
    assert run["u"][:2] == pytest.approx([28.0, 28.0])
    assert run.output("u").unit == "N m"
    assert run["motor.value"][-1] == pytest.approx(u + 1.0, rel=1e-7)


def test_two_controllers_with_their_own_periods() -> None:
    calls: dict[str, list[float]] = {"u": [], "w": []}

    def setter(name: str) -> Any:
        def set_one(t: float, o: Any) -> dict[str, float]:
            calls[name].append(t)
            return {name: t}

        return set_one

    controllers = [sr.Controller(setter("u"), period=0.02), sr.Controller(setter("w"), period=0.03)]
    run = sr.simulate(system(), until=0.1, controllers=controllers)
    assert calls["u"] == [0, 0.02, 0.04, 0.06, 0.08]
    assert calls["w"] == pytest.approx([0, 0.03, 0.06, 0.09], abs=1e-12)
    assert [run["u"][-1], run["w"][-1]] == pytest.approx([0.08, 0.09])


def test_a_sample_is_taken_once_beside_other_stops() -> None:
    """Beside breakpoints that are nearly its time, and beside samples of nearly its period."""

    def counter(name: str) -> Any:
        return lambda t, o: {name: o["n_" + name] + 1, "n_" + name: o["n_" + name] + 1}

    periods = {"u": 0.03, "w": 0.03 * (1 + 1e-9)}
    controllers = [
        sr.Controller(counter(name), period=period, memory={"n_" + name: 0.0})
        for name, period in periods.items()
    ]
    for distance in (2e-9, -2e-9, 3e-13, -3e-13, 0.0):
        near = [0.06 + distance, 0.09 + 2 * distance]
        run = sr.simulate(system(), until=0.1, controllers=controllers, events=near)
        assert [run[name][-1] for name in ("u", "w")] == pytest.approx([4, 4]), distance


def test_memory_is_read_as_it_was_returned() -> None:
    """Without round-off of the states in which it is stored; events change it."""
    read: list[float] = []

    def counting(t: float, o: Any) -> dict[str, float]:
        read.append(o["n"])
        return {"u": o["u"] + 0.1, "n": o["n"] + 1}

    def again(t: float, q: Any, v: Any) -> Any:
        v[run.system.states["n"].place] = 40.0
        return v

    controllers = [sr.Controller(counting, period=0.01, memory={"n": 0})]
    run = sr.simulate(system(), until=0.3, controllers=controllers)
    assert read == list(range(30))
    read.clear()
    sr.simulate(system(), until=0.1, controllers=controllers, events=sr.Event("t - 0.055", reset=again))
    assert read == [0, 1, 2, 3, 4, 5, 40, 41, 42, 43]


def test_a_controller_that_returns_nan_ends_the_run() -> None:
    def failing(t: float, o: Any) -> dict[str, float]:
        return {"u": 1.0 if t < 0.25 else np.nan}

    run = sr.simulate(system(), until=1.0, controllers=[sr.Controller(failing, period=0.1, name="servo")])
    assert not run.success
    assert run.status == "controller"
    assert "controller servo: it returned nan for u at t = 0.3 s. Return" in run.message
    assert run.final
    assert run.final.t == pytest.approx(0.3)
    assert np.all(np.isfinite(run.q))


def test_a_single_controller_needs_no_list() -> None:
    one = sr.Controller(control, period=PERIOD)
    first, second = (sr.simulate(system(), until=0.1, controllers=given) for given in (one, [one]))
    assert np.array_equal(first["pin.angle"], second["pin.angle"])
    goal = sr.Final("pin.angle")
    problems = [sr.Problem(system(), goal, ["w.value"], until=0.1, controllers=c) for c in (one, (one,))]
    assert problems[0].values(problems[0].x0) == problems[1].values(problems[1].x0)
    own = system().with_inputs({"u": 1.0})
    without, empty = (sr.simulate(own, until=0.1, controllers=none) for none in (None, []))  # type: ignore[arg-type]
    assert np.array_equal(without["pin.angle"], empty["pin.angle"])
    for wrong in (control, [control], 3):
        with pytest.raises(TypeError, match=r"controllers must be a sarrus.Controller, or a list of them"):
            sr.simulate(system(), until=0.1, controllers=wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("rate", [0.0, 1.0])
def test_states_of_the_user_are_no_inputs_even_if_they_are_constant(rate: float) -> None:
    state = sr.StateVariable("k", rate=rate, initial=1.0)
    own = sr.System(arm(state, sr.Input("u"), sr.Torque("motor", "pin", value="k + u")))
    with pytest.raises(SarrusError, match='arm has no input "k"'):
        sr.simulate(own, until=0.1, controllers=[sr.Controller(lambda t, o: {"k": 5.0}, period=0.02)])
    run = sr.simulate(own, until=0.1, controllers=[sr.Controller(lambda t, o: {"u": 5.0}, period=0.02)])
    assert run["k"][-1] == pytest.approx(1.0 + 0.1 * rate)
    with pytest.raises(SarrusError, match="the input u is not set"):
        sr.simulate(own, until=0.1, controllers=[sr.Controller(lambda t, o: {}, period=0.02)])


def test_a_controlled_system_is_simulated_again() -> None:
    """Its states that the first run made are inputs of controllers; an optimization simulates such a system."""
    controllers = [sr.Controller(control, period=PERIOD)]
    first = sr.simulate(system(), until=0.3, controllers=controllers, **TIGHT)
    again = sr.simulate(first.system, until=0.3, controllers=controllers, **TIGHT)
    assert again["pin.angle"][-1] == pytest.approx(first["pin.angle"][-1], rel=1e-8)


def test_wrong_controllers_are_refused() -> None:
    wrong: list[tuple[Any, str]] = [
        (lambda t, o: {"x1": 1.0}, 'no input "x1"'),
        (lambda t, o: 1.0, "controller <lambda>: it returned 1.0, no values by name"),
        (lambda t, o: {"u": "fast"}, "returned 'fast' for u. Return one number"),
        (lambda t, o: {"u": 2 + 1j}, "Return one number for each name"),
        (lambda t, o: {"u": [1.0, 2.0]}, "Return one number for each name"),
        (lambda t, o: {"w": 1.0}, "the input u is not set"),
        (lambda t, o: {"u": 1.0} if t < 0.01 else {"u": 1.0, "w": 2.0}, "it returned u before, but now u, w"),
        (lambda t, o: {"u": o["pin.force.x"]}, "accelerations or reactions"),
    ]
    for function, message in wrong:
        with pytest.raises(SarrusError, match=message):
            sr.simulate(system(), until=0.1, controllers=[sr.Controller(function, period=0.02)])
    both = [sr.Controller(control, period=0.02), sr.Controller(control, period=0.03)]
    with pytest.raises(SarrusError, match=r"two controllers return u. Let one of them return it"):
        sr.simulate(system(), until=0.1, controllers=both)
    silent = sr.Controller(control, period=0.02, memory={"integral": 0.0})
    with pytest.raises(SarrusError, match="returned no value of integral, which it remembers"):
        sr.simulate(system(), until=0.1, controllers=[silent])
    alike = sr.Controller(control, period=0.02, memory={"u": 0.0})
    with pytest.raises(SarrusError, match=r"controller control: its memory u is also an input. Rename it"):
        sr.simulate(system(), until=0.1, controllers=[alike])
    counts = [
        sr.Controller(lambda t, o, name=name: {name: 1.0, "n": 0.0}, period=0.02, memory={"n": 0.0})
        for name in ("u", "w")
    ]
    with pytest.raises(SarrusError, match=r"two controllers return n. Let one"):
        sr.simulate(system(), until=0.1, controllers=counts)
    with pytest.raises(TypeError, match="memory must be a mapping"):
        sr.Controller(control, period=0.02, memory=["integral"])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="runs with controllers are not saved"):
        sr.simulate(system(), until=0.1, controllers=both[:1], save="never")


def test_the_memory_of_another_controller_is_read() -> None:
    """Whatever their order; what it returned before this sample."""
    one = sr.Controller(lambda t, o: {"u": 0.0, "n": o["n"] + 1}, period=0.02, memory={"n": 5.0})
    other = sr.Controller(lambda t, o: {"w": o["n"]}, period=0.02)
    for controllers in ([one, other], [other, one]):
        run = sr.simulate(system(), until=0.05, t_eval=[0.01, 0.03, 0.05], controllers=controllers)
        assert run["w"] == pytest.approx([5.0, 6.0, 7.0])


def test_outputs_without_kernels_of_their_own_are_read() -> None:
    """Energies, which are sums over bodies."""
    seen: list[tuple[float, float]] = []

    def reading(t: float, o: Any) -> dict[str, float]:
        seen.append((o["energy.kinetic"], o["pin.rate"]))
        return {"u": 5.0}

    sr.simulate(system(), until=0.1, controllers=[sr.Controller(reading, period=0.02)])
    assert len(seen) == 5
    assert [one for one, _ in seen] == pytest.approx([0.5 * INERTIA * rate**2 for _, rate in seen])


def test_revolutions_are_counted_at_samples() -> None:
    """Of an arm that turns ever faster, and is sampled less than once in a revolution."""
    angles: list[float] = []

    def reading(t: float, o: Any) -> dict[str, float]:
        angles.append(o["pin.angle"])
        return {"u": 40.0}

    run = sr.simulate(system(), until=2.0, t_eval=[0.5, 1.5, 2.0], controllers=[sr.Controller(reading, 0.5)])
    assert angles[1::2] == pytest.approx(run["pin.angle"][:2], rel=1e-9)
    assert angles[-1] > 4 * np.pi


def test_outputs_are_read_by_calls_and_by_brackets() -> None:
    """In responses, forces and controllers."""

    def run(push: Any, servo: Any) -> sr.Trajectory:
        forces = sr.Torque("spring", "pin", value=push), sr.Torque("motor", "pin", value="u"), sr.Input("u")
        controllers = [sr.Controller(servo, period=0.05)]
        return sr.simulate(sr.System(arm(*forces)), until=0.1, controllers=controllers, store="steps")

    one = run(lambda o: -5 * o["pin.angle"], lambda t, o: {"u": 2 * o["pin.angle"] + o["pin.rate"]})
    other = run(lambda o: -5 * o("pin.angle"), lambda t, o: {"u": 2 * o("pin.angle") + o("pin.rate")})
    assert np.array_equal(one["pin.angle"], other["pin.angle"])
    found = sr.sensitivity(one, lambda o: o["pin.angle"] ** 2, ["arm.mass"])
    wanted = sr.sensitivity(other, lambda o: o("pin.angle") ** 2, ["arm.mass"])
    assert found.matrix == pytest.approx(wanted.matrix, rel=1e-12)
    with pytest.raises(TypeError, match="not iterable"):
        sr.sensitivity(one, sum, ["arm.mass"])
