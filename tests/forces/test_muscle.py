"""Muscles: curves and activation against closed forms and MuJoCo, work, derivatives, gradients of whole runs."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.forces.test_tendon import BODIES, ENDS, TENDONS, arm

import sarrus as sr
from sarrus._jit.formulas.expression import Graph
from sarrus.analyses.sensitivity.parameters.parameters import UnknownParameter
from sarrus.model.forces.muscle import force_length, force_velocity, passive_force
from sarrus.model.laws.jumps import jumps
from sarrus.model.states.actuators import activation_rate

ACTIVATION = sr.MuscleActivation("a", input="0.5 + 0.6*sin(9*t)", smoothing=0.3, initial=0.2)
GIVEN = {"peak_force": 60.0, "optimal_length": 0.4, "tendon_length": 0.25, "max_velocity": 8.0}


def muscle(activation: object = "a", **given: object) -> sr.Muscle:
    return sr.Muscle("m", ENDS, activation=activation, **GIVEN | given)


def test_points_of_the_curves() -> None:
    lengths = {0.4: 0, 0.5: 0, 0.75: 0.5, 1: 1, 1.3: 0.5, 1.6: 0, 2: 0}
    assert {L: pytest.approx(force_length(L, 0.5, 1.6)) for L in lengths} == lengths
    speeds = {-2: 0, -1: 0, -0.5: 0.25, 0: 1, 0.1: 1.15, 0.2: 1.2, 3: 1.2}
    assert {V: pytest.approx(force_velocity(V, 1.2)) for V in speeds} == speeds
    passive = {0.5: 0, 1: 0, 1.15: 0.1625, 1.3: 0.65, 1.6: 1.95}
    assert {L: pytest.approx(passive_force(L, 1.6, 1.3)) for L in passive} == passive


@pytest.mark.needs("mujoco")
def test_the_curves_and_the_activation_are_those_of_mujoco() -> None:
    mujoco = pytest.importorskip("mujoco")
    rng = np.random.default_rng(1)
    for _ in range(300):
        shortest, longest, speed, factor, eccentric = rng.uniform([0, 1.1, 0.5, 0.2, 1.1], [0.9, 2, 9, 3, 2])
        (first, last), peak = rng.uniform([0.1, 0.5], [0.4, 1]), rng.uniform(1, 9)
        given = np.array([0.75, 1.05, peak, 0, shortest, longest, speed, factor, eccentric])
        optimal = (last - first) / 0.3
        x, v = rng.uniform([0, -speed], [2, speed])
        L, V = 0.75 + (x - first) / optimal, v / (optimal * speed)
        ends = np.array([first, last])
        active = -mujoco.mju_muscleGain(x, v, ends, 1.0, given) / peak
        assert force_length(L, shortest, longest) * force_velocity(V, eccentric) == pytest.approx(
            active, abs=1e-12
        )
        passive = -mujoco.mju_muscleBias(x, ends, 1.0, given) / peak
        assert passive_force(L, longest, factor) == pytest.approx(passive, abs=1e-12)
        (u, a), rise, fall = rng.uniform(-0.5, 1.5, 2), 0.02, 0.05
        for width in (None, 0.3, 2.0):
            expected = mujoco.mju_muscleDynamics(u, a, np.array([rise, fall, width or 0]))
            assert activation_rate(u, a, rise, fall, width) == pytest.approx(expected, rel=1e-12)


def test_a_muscle_does_work_along_its_length() -> None:
    """Its power is that of the tension, with the length and rate of a tendon with the same path."""
    t_eval = np.linspace(0, 0.4, 4001)
    run = sr.simulate(
        arm(sr.Input("u", 0.8), muscle("u*(1 - t)")), until=0.4, t_eval=t_eval, method=sr.Radau(rtol=1e-9)
    )
    length, rate, tension = run["m.length"], run["m.rate"], run["m.tension"]
    np.testing.assert_allclose((length[2:] - length[:-2]) / 2e-4, rate[1:-1], atol=1e-4)
    np.testing.assert_allclose(run["m.power"], -tension * rate, atol=1e-9)
    active = np.vectorize(force_length)((length - 0.25) / 0.4, 0.5, 1.6) * np.vectorize(force_velocity)(
        rate / (0.4 * 8), 1.2
    )
    passive = np.vectorize(passive_force)((length - 0.25) / 0.4, 1.6, 1.3)
    np.testing.assert_allclose(tension, 60 * (0.8 * (1 - t_eval) * active + passive), rtol=1e-12)
    assert np.ptp(tension) > 10


def test_the_activation_follows_the_excitation() -> None:
    """With u = 1, ȧ = (1 - a)/(τ (1/2 + 3/2 a)), whose solution is t/τ = -2 ln(1 - a) - 3/2 a."""
    run = sr.simulate(
        arm(sr.MuscleActivation("a", input=1.0, activation_time=0.1)), until=0.3, method=sr.Radau(rtol=1e-9)
    )
    a = run["a"]
    np.testing.assert_allclose(-2 * np.log(1 - a) - 1.5 * a, run.t / 0.1, rtol=1e-6, atol=1e-6)
    assert a[-1] > 0.8


@pytest.mark.parametrize("u", [0.0, 0.4, 1.0])
def test_derivatives_of_a_held_activation(u: float) -> None:
    """At u = a, ȧ = (u - a)(1/2 + 3/2 a)/τ, the side that falls. A run that stays there to rounding has either side."""
    system = arm(sr.Input("u", u), sr.MuscleActivation("a", input="u", initial=u, deactivation_time=0.1))
    rate, at = (0.5 + 1.5 * u) / 0.1, system.states["a"][0]
    slopes = system.forward_dynamics.differentiated([])(system.q0, system.v0).every[at]
    assert sorted(slopes[slopes != 0]) == pytest.approx([-rate, rate])
    run = sr.simulate(system, until=0.05, store="steps")
    falls, rises = (1 - np.exp(-0.05 * one) for one in (rate, 1 / (0.01 * (0.5 + 1.5 * u))))
    found = float(sr.sensitivity(run, sr.Final("a"), wrt=["u"])["u"][0])
    assert falls - 1e-3 < found < rises + 1e-3


DRAGS = [sr.ViscousDrag(f"{one.name}_drag", one.point(0, 0, 0), c_turn=5.0) for one in BODIES]
HELD = {
    "muscle": sr.MuscleActivation("a", input="u"),
    "ramps": sr.StateVariable("a", rate="max(u - x, 0)/0.01 - max(x - u, 0)/0.04"),
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kind", HELD)
@pytest.mark.parametrize("u", [0.1, 0.4, 0.5, 1.0])
@pytest.mark.parametrize("initial", [0.0, 1.0])
@pytest.mark.parametrize("stored", [False, True])
def test_a_run_goes_on_when_the_activation_has_reached_its_excitation(
    kind: str, u: float, initial: float, stored: bool
) -> None:
    """There u - a is round-off, whose signs are no corners; damped, so that the rate of the muscle decays, too."""
    parts = sr.Input("u", u), replace(HELD[kind], initial=initial * u), muscle(), *DRAGS
    run = sr.simulate(arm(*parts), until=5.0, store="steps" if stored else "samples")
    assert run.t[-1] == 5.0
    assert run["a"][-1] == pytest.approx(u, rel=1e-6)
    if kind == "ramps" and not initial:
        np.testing.assert_allclose(run["a"], u * (1 - np.exp(-run.t / 0.01)), atol=1e-4)
    assert run.nsteps < 3000


def test_a_driver_follows_an_activation() -> None:
    """The switch of its rate is no jump."""
    assert not jumps(activation_rate(*Graph().inputs("x", 4)))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["two points", "joints", "around"])
def test_derivatives(name: str) -> None:
    path = TENDONS[name][0]
    given = {word: getattr(path, word) for word in ("points", "factors", "joints", "around")}
    assert arm(ACTIVATION, sr.Muscle("m", **given, activation="a", **GIVEN)).check_derivatives()


WRT = ["m.peak_force", "m.tendon_length", "m.eccentric_force", "a.deactivation_time", "a.smoothing"]


@pytest.mark.slow
@pytest.mark.parametrize("name", WRT)
def test_gradients_of_a_run(name: str) -> None:
    """Against differences of whole runs."""

    def run(change: float = 0.0) -> Any:
        parts = {one.name: one for one in (ACTIVATION, muscle(eccentric_force=1.3))}
        part, field = name.split(".")
        parts[part] = replace(parts[part], **{field: getattr(parts[part], field) * (1 + change)})
        return sr.simulate(arm(*parts.values()), until=0.4, method=sr.Radau(rtol=1e-10), store="steps")

    value = getattr({"m": muscle(eccentric_force=1.3), "a": ACTIVATION}[name[0]], name[2:])
    found = sr.sensitivity(run(), sr.Final("lower.z"), wrt=[name])[name]
    ends = [run(change)["lower.z"][-1] for change in (-1e-4, 1e-4)]
    assert abs(found) > 1e-6
    assert found == pytest.approx((ends[1] - ends[0]) / (2e-4 * value), rel=1e-4)


MISTAKES = {
    "max_length": (0.9, "max_length must be greater than 1, but is 0.9"),
    "min_length": (1.2, "min_length must be less than 1"),
    "eccentric_force": (1.0, "eccentric_force must be greater than 1"),
    "optimal_length": (0.0, "optimal_length"),
    "peak_force": (-1.0, "peak_force"),
    "activation": ("pin.angel", "pin.angel"),
}
ACTIVATIONS = {
    "negative": (-0.1, "activation must be between 0 and 1, but is -0.1"),
    "above one": ("3/2", "activation must be between 0 and 1, but is 1.5"),
    "table": ([[0, 0.1], [1, 0.9]], "activation cannot be a table. Give the table to an Input"),
}


@pytest.mark.parametrize("field", MISTAKES)
def test_mistakes(field: str) -> None:
    value, message = MISTAKES[field]
    with pytest.raises(sr.ModelError, match=message):
        arm(sr.Muscle("m", ENDS, **GIVEN | {"activation": 0.3} | {field: value}))


@pytest.mark.parametrize("name", ACTIVATIONS)
def test_activations_that_are_refused(name: str) -> None:
    value, message = ACTIVATIONS[name]
    with pytest.raises(sr.ModelError, match=message):
        arm(muscle(value))


def test_an_activation_by_the_length() -> None:
    """x and v are the length of the path and its rate; formulas may leave 0 to 1."""
    by_length = arm(muscle("3*x + 0.1*v"))
    run = sr.simulate(by_length, until=0.01)
    activation = 3 * run["m.length"] + 0.1 * run["m.rate"]
    others = arm(sr.Input("u", 0.0), muscle("u"))
    found = sr.simulate(others, until=0.01)["m.tension"][0], run["m.tension"][0]
    L, V = (run["m.length"][0] - 0.25) / 0.4, run["m.rate"][0] / (0.4 * 8)
    active = 60 * force_length(L, 0.5, 1.6) * force_velocity(V, 1.2)
    assert activation[0] > 1
    assert found[1] - found[0] == pytest.approx(activation[0] * active, rel=1e-9)


def test_mistakes_of_an_activation() -> None:
    with pytest.raises(sr.ModelError, match="activation_time"):
        arm(sr.MuscleActivation("a", input=1.0, activation_time=0.0))
    for initial in (-0.5, 1.01):
        with pytest.raises(sr.ModelError, match="initial must be between 0 and 1"):
            arm(sr.MuscleActivation("a", input=1.0, initial=initial))
    with pytest.raises(sr.ModelError, match="input cannot be a table"):
        arm(sr.MuscleActivation("a", input=[[0, 0.1], [1, 0.9]]))
    with pytest.raises(sr.ModelError, match="input is missing"):
        arm(sr.MuscleActivation("a"))


def test_a_switch_has_no_derivative_to_its_width() -> None:
    run = sr.simulate(arm(sr.MuscleActivation("a", input=1.0)), until=0.01, store="steps")
    with pytest.raises(UnknownParameter, match="smoothing"):
        sr.sensitivity(run, sr.Final("a"), wrt=["a.smoothing"])


def test_a_model_file_has_the_same_muscle(tmp_path: Path) -> None:
    system = arm(ACTIVATION, muscle())
    system.model.save(tmp_path / "arm.yaml")
    again = sr.System(sr.load(tmp_path / "arm.yaml"))
    q, v = system.q0, np.arange(system.nq) * 0.1
    np.testing.assert_array_equal(again.Q(q, v, 0.1), system.Q(q, v, 0.1))
