"""First-order states in simulations: against SciPy, by every method, stiff ones, events, saving, messages."""

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.states.motors import RATE, TIGHT, arm, motor, reduced, value

import sarrus as sr
from sarrus.model import ModelError, describe

OUTPUTS = ("pin.angle", "pin.angle.rate", "current")


def states(run: sr.Trajectory) -> np.ndarray[Any, Any]:
    return np.array([value(run, name) for name in OUTPUTS])


@pytest.mark.one_in(2)
@pytest.mark.parametrize("L", [1e-2, 1e-4])
def test_a_motor_follows_its_reduced_equations_also_between_steps(L: float) -> None:
    times = np.linspace(0, 2, 81)
    run = sr.simulate(sr.System(motor(L=L)), until=2.0, t_eval=times, **TIGHT)
    assert run.success
    assert states(run) == pytest.approx(reduced(times, L), abs=1e-8)
    assert value(run, "current.rate") == pytest.approx(run.a[:, 7], rel=1e-9)


RATES = {
    "x for its own name": "(12*sin(3*t) - R*x - k*pin.rate)/L",
    "a function of outputs": lambda o: (12 * np.sin(3 * o.t) - o["current"] - 0.5 * o["pin.rate"]) / 1e-2,
}


@pytest.mark.one_in(2)
@pytest.mark.parametrize("rate", RATES.values(), ids=RATES)
def test_a_rate_in_other_words(rate: Any) -> None:
    run = sr.simulate(sr.System(motor(rate)), until=1.0, **TIGHT)
    assert states(run)[:, -1] == pytest.approx(reduced(1.0)[:, -1], abs=1e-8)


def test_a_rate_by_a_table_of_the_state_itself() -> None:
    """The table is -2 x, exactly."""
    lag = sr.StateVariable("lag", rate=[[-1, 2], [0, 0], [1, -2]], over="lag", initial=1.0)
    run = sr.simulate(sr.System(arm(lag)), until=1.0, **TIGHT)
    assert value(run, "lag")[-1] == pytest.approx(np.exp(-2), abs=1e-10)


METHODS = {
    "Radau": (sr.Radau(rtol=1e-11), 1e-8),
    "HHT": (sr.HHT(rtol=1e-9), 2e-5),
    "generalized-α": (sr.GeneralizedAlpha(rtol=1e-9), 2e-5),
    "HHT, stabilized": (sr.HHT(stabilized=True, rtol=1e-9), 2e-5),
    "ODE": (sr.ODE(rtol=1e-11), 1e-8),
}  # fmt: skip


@pytest.mark.one_in(8)
@pytest.mark.parametrize("method", METHODS)
def test_every_method_integrates_a_state(method: str) -> None:
    chosen, error = METHODS[method]
    run = sr.simulate(sr.System(motor()), until=1.0, method=chosen)
    assert run.success
    assert states(run)[:, -1] == pytest.approx(reduced(1.0)[:, -1], abs=error)


@pytest.mark.slow
def test_methods_of_order_two_stay_so_with_states() -> None:
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        run = sr.simulate(sr.System(motor()), until=1.0, method=sr.HHT(step=step))
        errors.append(abs(states(run)[:, -1] - reduced(1.0)[:, -1]).max())
    assert np.log2(errors[0] / errors[1]) > 1.8
    assert np.log2(errors[1] / errors[2]) > 1.8


@pytest.mark.parametrize(
    "method", [sr.Radau(), sr.HHT(), sr.GeneralizedAlpha()], ids=lambda m: type(m).__name__
)
@pytest.mark.parametrize("L", [1e-6, 1e-9])
def test_stiff_circuits_take_no_more_steps_than_the_mechanism(method: Any, L: float) -> None:
    """Time constants of a microsecond and a nanosecond, beside the motor without inductance."""
    numbers = {"k": 0.5, "R": 1.0}
    torque = sr.Torque("torque", "pin", value="k*(12*sin(3*t) - k*pin.rate)/R", parameters=numbers)
    alone = sr.simulate(sr.System(arm(torque)), until=2.0, method=method)
    run = sr.simulate(sr.System(motor(L=L)), until=2.0, method=method)
    assert run.success
    assert run.nsteps <= 1.2 * alone.nsteps
    assert value(run, "pin.angle")[-1] == pytest.approx(value(alone, "pin.angle")[-1], abs=1e-3)


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_unit_of_a_state_does_not_matter(unit: float) -> None:
    """A current in other units: the steps are the same."""
    given = {"unit": unit}
    rate = "unit*(12*sin(3*t) - R*current/unit - k*pin.rate)/L"
    torque = sr.Torque("torque", "pin", value="0.5*current/unit", parameters=given)
    numbers = {"R": 1.0, "k": 0.5, "L": 1e-2} | given
    state = sr.StateVariable("current", rate=rate, initial=0.1 * unit, nominal=unit, parameters=numbers)
    run, other = (sr.simulate(sr.System(one), until=1.0) for one in (arm(state, torque), motor()))
    assert abs(run.nsteps - other.nsteps) <= 2
    assert value(run, "current")[-1] == pytest.approx(unit * value(other, "current")[-1], rel=1e-6)


def test_many_states_are_in_several_blocks() -> None:
    """A chain of five lags, x_k' = x_(k-1) - x_k, whose answer to 1 is a gamma distribution."""
    from scipy.special import gammainc

    chain = [
        sr.StateVariable(f"s{n}", rate=f"{f's{n - 1}' if n else '1'} - s{n}", initial=0) for n in range(5)
    ]
    system = sr.System(arm(*chain))
    assert system.nq == 7 * 3
    assert list(system.states) == ["s0", "s1", "s2", "s3", "s4"]
    assert system.counts()["degrees_of_freedom"] == 1
    assert system.counts()["joint_equations"] == 5
    run = sr.simulate(system, until=2.0, **TIGHT)
    assert [value(run, f"s{n}")[-1] for n in range(5)] == pytest.approx(
        [gammainc(n + 1, 2.0) for n in range(5)], abs=1e-9
    )


def test_a_description_counts_no_equations_of_states() -> None:
    text = describe(motor())
    assert "degrees of freedom: 6 × 1 − 5 = 1, if no equation is redundant" in text


def test_energies_and_lengths_are_those_of_the_bodies() -> None:
    run = sr.simulate(sr.System(motor("1000*cos(t)", initial=1e6)), until=0.02, store="dense", **TIGHT)
    assert list(run.bodies) == ["arm"]
    speed = value(run, "pin.angle.rate")
    assert value(run, "energy.kinetic") == pytest.approx(0.35 * speed**2, rel=1e-9)
    assert run.kinetic_energy == pytest.approx(0.35 * speed**2, rel=1e-9)
    supplied = value(run, "energy.supplied")[-1]
    gained = value(run, "energy.total")[-1] - value(run, "energy.total")[0]
    assert supplied == pytest.approx(gained, rel=1e-6)


def test_an_event_on_a_state_ends_a_run() -> None:
    run = sr.simulate(sr.System(motor()), until=2.0, events=sr.Event("current - 2", terminal=True), **TIGHT)
    t = run.events[-1].t
    assert t < 2.0
    assert reduced(t)[2, -1] == pytest.approx(2.0, abs=1e-7)


def test_a_run_is_saved_and_continued(tmp_path: Path) -> None:
    system = sr.System(motor())
    whole = sr.simulate(system, until=1.0, t_eval=np.linspace(0, 1, 11), save=tmp_path / "run")
    again = sr.load_run(tmp_path / "run", system)
    assert np.array_equal(value(again, "current"), value(whole, "current"))
    second = sr.simulate(system, whole.state(0.5), until=1.0)
    assert value(second, "current")[-1] == pytest.approx(value(whole, "current")[-1], rel=1e-6)


def test_tables_have_states_by_their_names(tmp_path: Path) -> None:
    run = sr.simulate(sr.System(motor()), until=0.1, t_eval=np.linspace(0, 0.1, 5))
    run.to_csv(tmp_path / "run.csv")
    names, *_ = csv.reader((tmp_path / "run.csv").read_text(encoding="utf-8").splitlines())
    table = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    assert not any("states 1" in name for name in names)
    (column,) = (n for n, name in enumerate(names) if name.startswith("current ["))
    assert table[:, column] == pytest.approx(value(run, "current"), rel=1e-12)
    assert table[:, names.index("arm.velocity.y [m/s]")] == pytest.approx(run.v[:, 1], rel=1e-12)


@pytest.mark.parametrize("name", ["motor.yaml", "motor.json"])
def test_a_model_file_has_the_same_states(name: str, tmp_path: Path) -> None:
    model = motor()
    model.save(tmp_path / name)
    again = sr.load(tmp_path / name)
    runs = [sr.simulate(sr.System(one), until=0.5) for one in (model, again)]
    assert np.array_equal(runs[0].q, runs[1].q)
    assert "initial" in (tmp_path / name).read_text()


WRONG: dict[str, tuple[Any, str]] = {
    "no initial value": ({"initial": None}, "its initial value is missing. Give initial=0"),
    "no rate": ({"rate": None}, "its rate is missing"),
    "unknown name": ({"rate": "-currant"}, 'rate has the unknown name "currant". Did you mean "current"'),
    "acceleration": ({"rate": "arm.acceleration.x"}, "cannot depend on accelerations"),
    "initial value": ({"initial": "a lot"}, "initial must be a number"),
    "jump": ({"rate": "-sign(current)"}, "jumps with current and not"),
    "parameter": ({"rate": "-a*x", "parameters": {"t": 1.0}}, "which formulas cannot use"),
}


@pytest.mark.parametrize("given", WRONG.values(), ids=WRONG)
def test_a_wrong_state_is_refused_by_name(given: Any) -> None:
    changes, message = given
    state = sr.StateVariable("current", **{"rate": "-current", "initial": 0.0, **changes})
    with pytest.raises(ModelError, match='force "current"') as error:
        sr.System(arm(state))
    assert message in str(error.value)


@pytest.mark.parametrize("name", ["x", "v", "t", "pi"])
@pytest.mark.parametrize("kind", ["StateVariable", "FirstOrderLag"])
def test_names_that_formulas_use_for_something_else_are_refused(name: str, kind: str) -> None:
    """Of t and pi rates would be those of the time and of 3.14; x is the own value in other parts' formulas."""
    state = (
        sr.StateVariable(name, rate=f"-{name}", initial=1.0)
        if kind == "StateVariable"
        else sr.FirstOrderLag(name, input=1.0, time=0.1)
    )
    with pytest.raises(ModelError, match=f'force "{name}": formulas use "{name}" for something else'):
        sr.System(arm(state))


def test_a_unit_that_does_not_fit_is_refused() -> None:
    state = sr.StateVariable("depth", rate="2 kg", initial=0, unit="m")
    with pytest.raises(ModelError, match="rate expects m/s, but"):
        sr.System(arm(state))


def test_a_rate_that_becomes_not_a_number_ends_the_run_with_what_there_is() -> None:
    run = sr.simulate(
        sr.System(arm(sr.StateVariable("level", rate="-1/sqrt(level)", initial=1.0))), until=2.0
    )
    assert not run.success
    assert run.status == "not finite"
    assert "level" in run.message
    t = np.asarray(run.t)
    assert 0.5 < t[-1] <= 2 / 3
    assert value(run, "level")[-2] == pytest.approx((1 - 1.5 * t[-2]) ** (2 / 3), abs=1e-6)


def test_a_state_that_grows_without_bounds_is_named() -> None:
    run = sr.simulate(sr.System(arm(sr.StateVariable("level", rate="level^2", initial=1.0))), until=2.0)
    assert not run.success
    assert "The rate of the state level changes fastest there." in run.message


def test_a_system_without_states_is_as_before() -> None:
    system = sr.System(arm())
    assert system.nq == 7
    assert system.states == {}
    assert "states" not in system.counts()
    assert replace(motor()).forces[0].rate == RATE


def test_a_parameter_with_the_name_of_a_state_is_refused() -> None:
    """A formula could mean either."""
    current = sr.StateVariable("current", rate="-current", initial=1.0)
    for part in (
        sr.StateVariable("flux", rate="-current*flux", initial=1.0, parameters={"current": 3.0}),
        sr.Torque("torque", "pin", value="2*current", parameters={"current": 3.0}),
    ):
        with pytest.raises(ModelError, match='parameters has the name "current", which is that of a state'):
            sr.System(arm(current, part))


@pytest.mark.parametrize(
    ("motion", "what"),
    [("2*pin.rate", '"pin.rate"'), (lambda o: 2 * o["pin.rate"], "is a function of outputs")],
)
def test_motions_of_drivers_cannot_depend_on_outputs(motion: Any, what: str) -> None:
    model = replace(arm(), drivers=[sr.AngleDriver("drive", "pin", motion)])
    with pytest.raises(
        ModelError, match=rf'driver "drive": .*{what}.* depends on outputs other than states, use'
    ):
        sr.System(model)


def test_a_saved_run_has_its_states_without_its_system(tmp_path: Path) -> None:
    current = sr.StateVariable("current", rate="-current", initial=1.0, unit="A")
    system = sr.System(arm(current))
    sr.simulate(system, until=0.1, save=tmp_path / "while.sarrus")
    run = sr.simulate(system, until=0.1)
    run.save(tmp_path / "after.sarrus")
    for name in ("while", "after"):
        loaded = replace(sr.load_run(tmp_path / f"{name}.sarrus"), system=None, joints=None)
        assert loaded["current"] == pytest.approx(run["current"], rel=1e-14)
        assert loaded.output("current").unit == "A"
        rate = loaded.output("current", rate=True)
        assert rate.label == run.output("current", rate=True).label == "rate of current [A/s]"
        assert rate.values == pytest.approx(-run["current"], rel=1e-6)


@pytest.mark.parametrize(
    "make",
    [
        lambda size: sr.FirstOrderLag("part", input=1e-9, time=0.1, nominal=size),
        lambda size: sr.TransferFunction("part", numerator=[1], denominator=[1, 2], input=1e-9, nominal=size),
        lambda size: sr.StateSpaceBlock(
            "part", A=[[-1]], B=[[1]], C=[[1]], inputs=[1e-9], initial=[0.0], nominal=size
        ),
        lambda size: sr.PID("part", input=1e-9, ki=1.0, kd=1.0, filter=0.1, nominal=size),
        lambda size: sr.DCMotor("part", "pin", 1e-9, 1.0, 0.1, 1.0, nominal=size),
    ],
)
def test_every_state_has_a_nominal_size(make: Any) -> None:
    assert {one.nominal for one in sr.System(arm(make(1e-9))).states.values()} == {1e-9}
    with pytest.raises(ModelError, match="nominal must be greater than 0"):
        sr.System(arm(make(0.0)))
