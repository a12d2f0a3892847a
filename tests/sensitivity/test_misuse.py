"""What is wrong with a question about derivatives is told in one sentence; nothing wrong is answered."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.model import SarrusError


@pytest.fixture(scope="module")
def run() -> sr.Trajectory:
    return sr.simulate(slider_crank(), until=0.05, store="steps")


RESPONSES: dict[str, tuple[Callable[[], object], str]] = {
    "a number": (lambda: sr.Final(3.0), "an output is a name"),
    "a class": (lambda: sr.Final(sr.Final), "an output is a name"),
    "no number of seconds": (lambda: sr.At("slider.x", time=np.nan), "time must be a finite number"),
    "two times": (lambda: sr.At("slider.x", time=[0.1, 0.2]), "time must be a number, got list"),
    "nothing measured": (lambda: sr.Misfit("slider.x"), "its times have the shape .0,. and its data .0,."),
    "fewer data": (
        lambda: sr.Misfit("slider.x", at=[0.1, 0.2], data=[1.0]),
        "the shape .2,. and its data .1,.",
    ),
    "a gap": (lambda: sr.Misfit("slider.x", at=[0.1], data=[np.nan]), "its data must be finite numbers"),
    "no sigma": (
        lambda: sr.Misfit("slider.x", at=[0.1], data=[1.0], sigma=0.0),
        "sigma must be greater than 0",
    ),
}


@pytest.mark.parametrize("kind", RESPONSES)
def test_a_response_that_cannot_be_is_refused_when_it_is_made(kind: str) -> None:
    made, sentence = RESPONSES[kind]
    with pytest.raises((ValueError, TypeError), match=sentence):
        made()


FUNCTIONS: dict[str, tuple[Callable[[sr.Outputs], object], str]] = {
    "nothing": (lambda o: None, "the function returns None"),
    "a vector": (lambda o: o.position("slider"), "the function returns 3 numbers"),
    "two numbers": (lambda o: [o("slider.x"), o("slider.y")], "the function returns 2 numbers"),
    "of plain numbers": (lambda o: math.sin(o("slider.x")), "place of math.sin"),
    "a text": (lambda o: "slider.x", "the function returns 'slider.x'"),
    "a root of less than nothing": (lambda o: np.sqrt(o("slider.x") - 100), "is nan: its output leaves"),
}


@pytest.mark.parametrize("kind", FUNCTIONS)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_an_output_that_is_no_number_is_refused(kind: str, run: sr.Trajectory) -> None:
    function, sentence = FUNCTIONS[kind]
    with pytest.raises((ValueError, TypeError), match=sentence):
        sr.sensitivity(run, sr.Integral(function), ["spring.k"])


@pytest.mark.parametrize("method", ["adjoint", "direct"])
def test_values_without_derivatives(method: str, run: sr.Trajectory) -> None:
    found = sr.sensitivity(run, ["slider.x", "slider.y"], [], method=method)
    assert found.matrix.shape == (2, 0)
    assert found.value == pytest.approx(run["slider"].position[-1, 0], rel=1e-6)


def test_a_constant_is_a_response_without_derivatives(run: sr.Trajectory) -> None:
    found = sr.sensitivity(run, sr.Integral(lambda o: 2), ["spring.k"])
    assert (found.value, found["spring.k"]) == (pytest.approx(0.1), 0.0)


def test_questions_that_are_none(run: sr.Trajectory) -> None:
    with pytest.raises(ValueError, match="no response is asked for"):
        sr.sensitivity(run, [], ["spring.k"])
    with pytest.raises(ValueError, match="no response is asked for"):
        sr.Problem(slider_crank(), [], ["spring.k"], until=0.05)
    with pytest.raises(ValueError, match="method must be 'adjoint' or 'direct', but is 'forward'"):
        sr.sensitivity(run, "slider.x", ["spring.k"], method="forward")
    with pytest.raises(ValueError, match="wrt names no number"):
        sr.hessian(run, "slider.x", [])
    with pytest.raises(ValueError, match="wrt names no number"):
        sr.state_derivatives(run, [])
    with pytest.raises(ValueError, match="wrt names no number"):
        sr.optimize(slider_crank(), "slider.x", [], until=0.05)
    with pytest.raises(ValueError, match=r"slider\.x at 3 s: times must be between 0 and 0\.05 s"):
        sr.sensitivity(run, sr.At("slider.x", time=3.0))
    with pytest.raises(TypeError, match="derivatives need a run, got a System"):
        sr.sensitivity(slider_crank(), "slider.x")


@pytest.mark.filterwarnings("ignore:invalid value")
def test_a_design_whose_objective_is_no_number_is_infeasible() -> None:
    """The solver meets a wall there; a first design of this kind is an error with the sentence."""
    root = sr.Integral(lambda o: np.sqrt(o("slider.x") - 100), name="root")
    with pytest.raises(SarrusError, match="root is nan"):
        sr.optimize(slider_crank(), root, ["spring.k"], until=0.05)
    late = sr.Combined(lambda x: (x - 100) ** 0.5, ["slider.x"], name="late root")
    with pytest.raises(SarrusError, match="late root is nan"):
        sr.Problem(slider_crank(), late, ["spring.k"], until=0.05).values([10.0])


DESIGNS: dict[str, tuple[dict[str, object], str]] = {
    "no design": ({"formula": lambda d: {"spring.k": 10.0}}, "formula: it is given without design"),
    "no number": (
        {"design": {"k": np.nan}, "formula": lambda d: {"spring.k": d["k"]}},
        "'k' must be a finite number",
    ),
    "a text": (
        {"design": {"k": "10"}, "formula": lambda d: {"spring.k": d["k"]}},
        "'k' must be a finite number",
    ),
    "nothing follows": ({"design": {"k": 1.0}, "formula": lambda d: None}, "parameters of the model by name"),
    "nothing is named": ({"design": {"k": 1.0}, "formula": lambda d: {}}, "parameters of the model by name"),
}


@pytest.mark.parametrize("kind", DESIGNS)
def test_designs_that_say_too_little_are_refused(kind: str, run: sr.Trajectory) -> None:
    given, sentence = DESIGNS[kind]
    with pytest.raises(SarrusError, match=sentence):
        sr.sensitivity(run, "slider.x", **given)


def test_design_variables_may_be_for_responses_alone() -> None:
    """Without a formula, and values without any derivative."""
    reach = sr.Final(lambda o: o("slider.x") * o.parameter("share"), name="reach")
    problem = sr.Problem(slider_crank(), reach, ["share"], until=0.05, design={"share": 0.5})
    place = sr.Problem(slider_crank(), "slider.x", [], until=0.05).values([])[0]
    assert problem.values([0.5])[0] == 0.5 * place
    assert problem.gradient(problem.x0)["share"] == pytest.approx(place)


def test_a_direction_may_name_a_vector(run: sr.Trajectory) -> None:
    whole = sr.hessian_product(run, "slider.x", {"pin.point": (0.0, 1.0, 2.0)}, ["spring.k", "pin.point"])
    apart = sr.hessian_product(
        run, "slider.x", {"pin.point.y": 1.0, "pin.point.z": 2.0}, ["spring.k", "pin.point"]
    )
    assert np.array_equal(whole, apart)
    for wrong in (1.0, (1.0, np.nan, 0.0)):
        with pytest.raises(ValueError, match=r"the direction of pin\.point must be 3 finite numbers"):
            sr.hessian_product(run, "slider.x", {"pin.point": wrong})


def test_outputs_at_several_times_are_told_apart(run: sr.Trajectory) -> None:
    found = sr.sensitivity(run, [sr.At("slider.x", time=t) for t in (0.01, 0.02)], ["spring.k"])
    assert found.responses == ("slider.x at 0.01 s", "slider.x at 0.02 s")


DERIVATIVES: dict[str, Callable[..., object]] = {
    "sensitivity": lambda run, **more: sr.sensitivity(run, "slider.x", ["spring.k"], **more),
    "state_derivatives": lambda run, **more: sr.state_derivatives(run, ["spring.k"], **more),
    "hessian": lambda run, **more: sr.hessian(run, "slider.x", ["spring.k", "spring.c"], **more),
    "hessian_product": lambda run, **more: sr.hessian_product(run, "slider.x", {"spring.k": 1.0}, **more),
}


@pytest.mark.parametrize("name", DERIVATIVES)
def test_derivatives_end_at_their_time_limit(name: str, run: sr.Trajectory) -> None:
    with pytest.raises(
        ValueError, match="the time limit of 1e-06 s has passed before the derivatives were there"
    ):
        DERIVATIVES[name](run, time_limit=1e-6)
    assert DERIVATIVES[name](run, time_limit=100.0) is not None


@pytest.mark.parametrize("name", ["sensitivity", "hessian"])
def test_derivatives_are_stopped_between_sweeps(name: str, run: sr.Trajectory) -> None:
    def interrupt(_: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="stopped by the user before the derivatives were there"):
        DERIVATIVES[name](run, progress=interrupt)


def test_a_number_and_what_it_follows_from_are_not_asked_for_at_once(tmp_path: Path) -> None:
    """The derivative by the parameter was 0, since the number counted as given."""
    file = tmp_path / "m.yaml"
    file.write_text(
        "name: m\nparameters: {g: 10}\nbodies: {b: {mass: 1, inertia: [1, 1, 1], position: [1.2, 0, 0]}}\n"
        "forces: {s: {type: tsda, points: [{body: ground, at: [0, 0, 0]}, {body: b, at: [0, 0, 0]}], k: 2*g,"
        " length: 1}}\n"
    )
    run = sr.simulate(sr.System(sr.load(file)), until=0.5, store="steps")
    one, other = (sr.sensitivity(run, sr.Final("b.x"), name) for name in ("g", "s.k"))
    assert one["g"] == pytest.approx(2 * other["s.k"], rel=1e-12)
    for names in (["g", "s.k"], ["s.k", "b.mass", "g"], ["g", "s"]):
        with pytest.raises(sr.SarrusError, match=r"s\.k: follows by a formula"):
            sr.sensitivity(run, sr.Final("b.x"), names)


def test_a_time_before_a_start_that_is_not_at_zero_is_refused() -> None:
    """Of a run with an event, whose pieces know where they begin."""
    arm = sr.Body("arm", mass=2, inertia=(1, 1, 1), position=(1, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 0, 1))
    system = sr.System(sr.Model("arm", [arm], [pin], gravity=(0, -9.81, 0)))
    kick = sr.Event("t - 5.05", reset=lambda t, q, v: 0.5 * v)
    run = sr.simulate(system, sr.assemble(system, t=5.0), until=5.1, events=kick, store="steps")
    with pytest.raises(ValueError, match=r"pin\.angle at 3 s: times must be between 5 and 5\.1 s"):
        sr.sensitivity(run, sr.At("pin.angle", time=3.0), ["arm.mass"])


TAKERS: dict[str, Callable[[sr.Trajectory, object], object]] = {
    "sensitivity": lambda run, wrt: sr.sensitivity(run, "slider.x", wrt),
    "state_derivatives": lambda run, wrt: sr.state_derivatives(run, wrt),
    "hessian": lambda run, wrt: sr.hessian(run, "slider.x", wrt),
    "optimize": lambda run, wrt: sr.optimize(run.system, "slider.x", wrt, until=0.1),
    "fit": lambda run, wrt: sr.fit(run.system, sr.Misfit("slider.x", at=[0.1], data=[1.0]), wrt),
    "forward dynamics": lambda run, wrt: sr.ForwardDynamics(run.system).derivatives(
        run.q[0], run.v[0], wrt=wrt
    ),
}


@pytest.mark.parametrize("kind", TAKERS)
def test_values_beside_the_names_of_parameters_are_refused(kind: str, run: sr.Trajectory) -> None:
    """They would have no effect."""
    with pytest.raises(TypeError, match=r"wrt must be names of parameters.*Give a list.*bounds="):
        TAKERS[kind](run, {"spring.k": (1, 2)})


@pytest.mark.parametrize("wrong", [[1], [("spring.k",)], [None, "spring.k"]])
def test_parameters_without_names_are_refused(wrong: Any, run: sr.Trajectory) -> None:
    with pytest.raises(TypeError, match=r"wrt must be names of parameters, got .*Give a list such as"):
        sr.sensitivity(run, "slider.x", wrong)


@pytest.mark.parametrize("what", ["bounds", "scale"])
@pytest.mark.parametrize("wrong", [1.0, 5, {0: (1, 2)}, "spring.k", np.float64(3)])
def test_limits_and_sizes_that_belong_to_no_variable_are_refused(
    what: str, wrong: Any, run: sr.Trajectory
) -> None:
    with pytest.raises(
        ValueError, match=rf"{what}: it is .*\. Give a .* for each variable, or a dict by name\."
    ):
        sr.optimize(run.system, "slider.x", ["spring.k"], until=0.1, **{what: wrong})
