"""Numbers whose change alone contradicts equations that others imply have no derivative, and it is said so."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints
from tests.sensitivity.frozen import again, values

import sarrus as sr
from sarrus.analyses.sensitivity.parameters.parameters import Parameters

EXAMPLES = Path(__file__).parents[2] / "examples"
RESPONSES = [sr.Final("rod_2.x"), sr.Integral("energy.kinetic")]


@cache
def bricard() -> sr.Trajectory:
    system = sr.System(sr.load(EXAMPLES / "bricard.yaml"))
    return sr.simulate(system, until=0.4, t_eval=[0.4], store="steps", method=sr.HHT(rtol=1e-6, atol=1e-8))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("method", ["adjoint", "direct"])
def test_axes_and_points_of_bricards_hinges(method: str) -> None:
    """A hinge may slide along its axis; to shift it across, or to tilt it, locks the linkage."""
    found = sr.sensitivity(bricard(), RESPONSES, ["hinge_1", "rod_2.mass"], method=method)
    across = ("hinge_1.point.x", "hinge_1.point.z", "hinge_1.axis.x", "hinge_1.axis.z")
    assert found.undefined == across
    assert np.isfinite(found["rod_2.mass"]).all()
    assert np.isfinite(found["hinge_1.point.y"]).all()
    assert found.ranked()[0] == "rod_2.mass"
    assert "4 have no derivative" in found.table()


def test_together_they_have_one() -> None:
    """A linkage that is twice as large: the gradient by its size is that of differenced simulations."""
    run, numbers = bricard(), Parameters(bricard().system, None, start=bricard().steps.start)
    given = dict(zip(numbers.names, numbers.values, strict=True))
    lengths = {name: value for name, value in given.items() if ".point." in name or ".position." in name}

    def larger(size: float) -> dict[str, float]:
        return {name: size * value for name, value in lengths.items()}

    found = sr.sensitivity(run, RESPONSES, design={"size": 1.0}, formula=lambda p: larger(p["size"]))
    assert not found.undefined
    ends = [values(*again(run.system, run.steps, sr.HHT(), larger(1 + e)), RESPONSES) for e in (1e-4, -1e-4)]
    assert np.allclose(found["size"], (ends[0] - ends[1]) / 2e-4, rtol=1e-6)


def test_nobody_searches_along_them() -> None:
    what = RESPONSES[0], ["hinge_1.point.x"]
    problem = sr.Problem(bricard().system, *what, until=0.1)
    assert problem.gradient(problem.x0).undefined == ("hinge_1.point.x",)
    for search in (
        lambda: sr.optimize(problem.system, *what, until=0.1),
        lambda: problem.vjp(problem.x0, [1.0]),
    ):
        with pytest.raises(sr.NoDerivative, match=r"hinge_1.point.x alone contradicts"):
            search()


def test_second_derivatives_and_those_of_states_are_refused() -> None:
    for ask in (
        lambda: sr.hessian(bricard(), RESPONSES[0], ["hinge_1.axis.z"]),
        lambda: sr.state_derivatives(bricard(), ["hinge_1.axis.z"]),
    ):
        with pytest.raises(sr.NoDerivative, match=r"hinge_1.axis.z alone contradicts"):
            ask()


def test_a_root_at_zero() -> None:
    """A mass sqrt(d) has no derivative by d = 0; a search says so instead of trying in vain."""
    ball = sr.Body("ball", mass=1.0, inertia=(1.0, 1.0, 1.0))
    push = sr.PointForce("push", ball.point(0, 0, 0), force=(0, 0, 2.0))
    system = sr.System(sr.Model("pushed", bodies=[ball], forces=[push]))
    given = {"design": {"d": 0.0}, "formula": lambda p: {"ball.mass": 1.0 + np.sqrt(p["d"])}}
    problem = sr.Problem(system, "ball.z", until=0.1, **given)
    assert problem.gradient(problem.x0).undefined == ("d",)
    for ask in (
        lambda: sr.optimize(system, "ball.z", until=0.1, **given),
        lambda: problem.vjp(problem.x0, [1.0]),
    ):
        with pytest.raises(sr.NoDerivative, match="no derivative by d at this design"):
            ask()


def pendulum() -> sr.System:
    arm = sr.Body("arm", mass=2.0, inertia=(0.1, 0.15, 0.2), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.System(sr.Model("pendulum", [arm], [pin], gravity=(0, -9.81, 0)))


@pytest.mark.parametrize(
    "of", [lambda o: np.sqrt(o("arm.z") ** 2), lambda o: np.sqrt(o("arm.x") - o("arm.x"))]
)
def test_responses_with_infinite_derivatives_are_named(of: Callable[[Any], Any]) -> None:
    system, bad = pendulum(), sr.Final(of, name="root")
    none = sr.Final(lambda o: np.sqrt(o("arm.x") - o("arm.x")), name="root")
    run = sr.simulate(system, until=0.1, store="steps")
    for ask in (
        lambda: sr.sensitivity(run, ["arm.x", bad], ["arm.mass"]),
        lambda: sr.sensitivity(run, ["arm.x", bad], ["arm.mass"], method="direct"),
        lambda: sr.sensitivity(sr.equilibrium(system), none, ["arm.mass"]),
        lambda: sr.sensitivity(sr.equilibrium(system), none, ["arm.mass"], method="direct"),
        lambda: by_checkpoints(system, bad, ["arm.mass"], until=0.1),
        lambda: sr.hessian(run, bad, ["arm.mass"]),
        lambda: sr.optimize(system, bad, ["arm.mass"], until=0.1),
        lambda: sr.optimize(system, none, ["arm.mass"], analysis=sr.Statics()),
    ):
        with pytest.raises((ValueError, sr.SarrusError), match=r"root.*derivative is infinite"):
            ask()


def test_infinite_slopes_at_times_without_weight_do_no_harm() -> None:
    """The speed begins as a root at 0; its maximum is that of the end."""
    run = sr.simulate(pendulum(), until=0.1, store="steps")
    speed = sr.Maximum(lambda o: np.sqrt(o("arm.velocity.x") ** 2 + o("arm.velocity.y") ** 2))
    square = sr.Final(lambda o: o("arm.velocity.x") ** 2 + o("arm.velocity.y") ** 2)
    found, of_square = (sr.sensitivity(run, one, ["arm.inertia.zz"]) for one in (speed, square))
    wanted = of_square["arm.inertia.zz"] / (2 * found.values)
    assert np.allclose(found["arm.inertia.zz"], wanted, rtol=1e-6)


def test_a_residual_of_zero_at_a_root_of_zero_has_no_derivative(falling: sr.System) -> None:
    """(root - 0)² / 2 of a root of z is z / 2 above 0, and nothing below: its weight is zero only there."""
    run = sr.simulate(falling, until=0.1, store="steps")
    bad = sr.Misfit(lambda o: np.sqrt(-o("s.z")), name="root", at=[0.0, 0.1], data=[0.0, 1.0])
    place = ["s.position.z"]
    for ask in (
        lambda: sr.sensitivity(run, bad, place),
        lambda: sr.sensitivity(run, bad, place, method="direct"),
        lambda: by_checkpoints(falling, bad, place, until=0.1),
        lambda: sr.hessian(run, bad, place),
        lambda: sr.optimize(falling, bad, place, until=0.1),
        lambda: sr.fit(falling, bad, place, until=0.1),
        lambda: sr.fit(falling, bad, ["F"], until=0.1),
    ):
        with pytest.raises(
            (ValueError, sr.SarrusError), match=r"root.*derivative is infinite.*leave out the meas"
        ):
            ask()
    later = sr.Misfit(bad.of, at=[0.05, 0.1], data=[0.0, 1.0])
    assert np.isfinite(sr.sensitivity(run, later, place)["s.position.z"]).all()


def speed(outputs: Any) -> Any:
    return np.sqrt(outputs("s.velocity.x") ** 2 + outputs("s.velocity.z") ** 2)


FIRST = sr.Misfit(speed, name="speed", at=[0.0, 0.05, 0.1], data=[0.0, 0.1, 0.4])
BOTH = ["s.mass", "F"]


def test_a_measured_speed_of_zero_at_rest_is_refused(falling: sr.System) -> None:
    """The message says to leave it out, also where the square of the speed is smooth."""
    run = sr.simulate(falling, until=0.1, store="steps")
    for ask in (
        lambda: sr.sensitivity(run, FIRST, BOTH),
        lambda: sr.sensitivity(run, FIRST, BOTH, method="direct"),
        lambda: sr.hessian(run, FIRST, BOTH),
        lambda: sr.fit(falling, FIRST, ["F"], until=0.1),
    ):
        with pytest.raises(
            (ValueError, sr.SarrusError), match=r"speed.*derivative is infinite.*leave out the meas"
        ):
            ask()


@pytest.mark.parametrize("method", ["adjoint", "direct"])
def test_a_residual_of_zero_in_a_driven_motion(method: str) -> None:
    model = pendulum().model
    driver = sr.AngleDriver("turn", "pin", [[0, 0], [0.5, 0.1], [1, 0.5], [1.5, 0.8]])
    run = sr.kinematics(sr.System(replace(model, drivers=[driver])), [0.0, 0.5, 1.0])
    names = [name for name in sr.sensitivity(run, sr.Final("pin.angle")).names if "turn" in name]
    misfit = sr.Misfit(lambda o: np.sqrt(o("pin.angle")), name="root", at=[0, 0.5], data=[0.0, 0.3])
    with pytest.raises(ValueError, match=r"root: its derivative is infinite"):
        sr.sensitivity(run, misfit, names, method=method)


FALLING = """
name: falling
parameters: {F: 2.0}
bodies:
  s: {mass: 4.0, inertia: [1, 1, 1], velocity: [0, 0, 0]}
forces:
  pull: {type: point_force, point: {body: s, at: [0, 0, 0]}, force: [0, 0, -3*F]}
"""


@pytest.fixture(scope="module")
def falling(tmp_path_factory: pytest.TempPathFactory) -> sr.System:
    file = tmp_path_factory.mktemp("falling") / "falling.yaml"
    file.write_text(FALLING)
    return sr.System(sr.load(file))


def test_nor_do_they_in_derivatives_by_parameters_that_the_output_names(falling: sr.System) -> None:
    """A body falls from rest by -z = 3 F t²/2m: the root of -2z/F begins at 0 and ends as t (3/m)^½."""
    root = sr.Maximum(lambda o: np.sqrt(-2 * o("s.z") / o.parameter("F")))
    problem = sr.Problem(falling, root, wrt=["F", "s.mass"], until=0.1)
    wanted = 0.1 * (3 / 4) ** 0.5
    assert problem.values(problem.x0)[0] == pytest.approx(wanted, rel=1e-6)
    found = problem.gradient(problem.x0)
    assert found["F"] == pytest.approx(0.0, abs=1e-7)
    assert found["s.mass"] == pytest.approx(-wanted / 8, rel=1e-6)


@pytest.mark.parametrize("response", [sr.Final, sr.Maximum])
def test_nor_do_they_in_second_derivatives(response: Any, falling: sr.System) -> None:
    """The root of -2z is r = t (3 F/m)^½, with the second derivatives -r/4F², -r/4Fm and 3r/4m²."""
    run = sr.simulate(falling, until=0.1, store="steps")
    found = sr.hessian(run, response(lambda o: (-2 * o("s.z")) ** 0.5), ["F", "s.mass"])
    r = 0.1 * (3 * 2 / 4) ** 0.5
    assert np.allclose(found.matrix, [[-r / 16, -r / 32], [-r / 32, 3 * r / 64]], rtol=1e-5)


def test_second_derivatives_that_are_infinite_where_there_is_weight_are_refused(falling: sr.System) -> None:
    """What begins at 0 has a 3/2-th power with a gradient by the start, but one that bends infinitely there."""
    run = sr.simulate(falling, until=0.1, store="steps")
    bent = sr.Integral(lambda o: (-o("s.z")) ** 1.5, name="bent")
    assert np.isfinite(sr.sensitivity(run, bent, ["s.position.z"])["s.position.z"]).all()
    with pytest.raises(ValueError, match=r"bent: its second derivative is infinite.*Use a smooth function"):
        sr.hessian(run, bent, ["s.position.z"])
