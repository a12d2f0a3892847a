"""Gradients of kinematics, inverse dynamics, equilibria and modes, against differences of whole analyses."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.analyses.driven import parallelogram, turned
from tests.states.motors import motor

import sarrus as sr
from sarrus.analyses import NoDerivative
from sarrus.model.written import with_numbers, written_numbers
from sarrus.studies import Distribution

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")
BASE = sr.load("slider_crank")
NAMES = ["spring.k", "rod.mass", "pin.point.z", "spring.length", "gravity.z"]
Analysis = Callable[[sr.System], Any]


def differences(model: sr.Model, names: Sequence[str], values: Callable[[sr.System], Any]) -> np.ndarray:
    """The derivatives (r, p) of what an analysis gives, by differences of fourth order of whole analyses."""
    own, found = written_numbers(model), []
    for name in names:
        h = 1e-4 * (abs(own[name]) or 1.0)
        f = [
            np.array(values(sr.System(with_numbers(model, {name: own[name] + n * h}))))
            for n in (-2, -1, 1, 2)
        ]
        found.append((f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h))
    return np.array(found).T


def agrees(
    system: sr.System, analysis: Analysis, responses: Sequence[Any], names: Sequence[str], values: Analysis
) -> sr.Gradient:
    """Direct, adjoint and differences are one gradient."""
    result = analysis(system)
    found = sr.sensitivity(result, responses, names)
    direct = sr.sensitivity(result, responses, names, method="direct")
    exact = differences(system.model, names, lambda other: values(analysis(other)))
    size = 1e-7 * np.maximum(abs(exact).max(axis=1), 1e-3)[:, None]
    assert found.values == pytest.approx(values(result), rel=1e-12, abs=1e-12)
    assert np.all(abs(found.matrix - exact) < size)
    assert np.all(abs(direct.matrix - found.matrix) < 1e-3 * size)
    return found


def test_a_driven_motion() -> None:
    system, times = turned(3.0, 0.5), np.linspace(0, 2, 21)
    first = sr.kinematics(system, times)
    outputs = ["slider.x", "slider.acceleration.x", "motor.torque.x", "spring.tension", "pin.force.z"]
    responses = [
        *outputs,
        sr.At("slider.velocity.x", time=0.7),
        sr.Integral("energy.kinetic"),
        sr.Maximum("slider.x"),
    ]

    def values(run: sr.Trajectory) -> list[float]:
        last = [run[name][-1] for name in outputs]
        near = np.polynomial.Polynomial.fit(run.t[5:8], run["slider.x"][5:8], 2)
        top = near(float(near.deriv().roots()[0]))
        energy = run.output("energy.kinetic").values
        return [*last, run["slider.velocity.x"][7], np.trapezoid(energy, run.t), top]

    names = ["pin.point.z", "rod.mass", "spring.k", "motor.motion.1", "gravity.z"]
    assert np.argmax(first["slider.x"]) == 6
    agrees(system, lambda s: sr.kinematics(s, times, first.q[0]), responses, names, values)


def test_the_rate_of_the_drive_in_closed_form() -> None:
    """x = √(25 - y² - z²), y = 1 - 2 sin θ, z = 1 + 2 cos θ, θ = 0.5 + ω t + t²/4: ∂x/∂ω = t ∂x/∂θ."""
    run = sr.kinematics(turned(3.0, 0.5), np.linspace(0, 2, 21))
    angle = 0.5 + 3.0 * 2 + 0.25 * 4
    by_angle = (2 * np.cos(angle) + 2 * np.sin(angle)) / run["slider.x"][-1]
    assert sr.sensitivity(run, "slider.x")["motor.motion.1"] == pytest.approx(2 * by_angle, rel=1e-10)


def test_multipliers_of_redundant_constraints_are_the_least_ones() -> None:
    system, times = parallelogram(), np.linspace(0, 1, 5)
    outputs = ["A.force.x", "coupler.velocity.y", "D.force.y"]
    names = ["coupler.mass", "rocker.mass", "motor.motion.1"]
    first = sr.kinematics(system, times)

    def values(run: sr.Trajectory) -> list[float]:
        return [run[name][-1] for name in outputs]

    agrees(system, lambda s: sr.kinematics(s, times, first.q[0]), outputs, names, values)


def test_torques_that_a_simulated_motion_requires() -> None:
    run = sr.simulate(sr.System(BASE), until=1.0, t_eval=np.linspace(0, 1, 6))
    driven = sr.System(replace(BASE, drivers=[sr.AngleDriver("motor", "pin", "0*t")]))
    responses = ["motor.torque.x", "pin.force.z", sr.Integral("motor.torque.x")]

    def values(found: sr.Trajectory) -> list[float]:
        torque = found["motor.torque.x"]
        return [torque[-1], found["pin.force.z"][-1], np.trapezoid(torque, found.t)]

    agrees(driven, lambda s: sr.inverse_dynamics(s, run), responses, [*NAMES, "spring.c"], values)
    free = sr.inverse_dynamics(sr.System(BASE), run)
    with pytest.raises(NoDerivative, match="leave a motion free at t = 1 s"):
        sr.sensitivity(free, "pin.force.z", NAMES)


def test_an_equilibrium_and_its_modes() -> None:
    rest, outputs = (
        sr.equilibrium(sr.System(BASE)),
        ["slider.x", "pin.force.z", "spring.tension", "energy.potential"],
    )
    modal = ["mode1.frequency", "mode1.natural_frequency", "mode1.damping_ratio", "mode1.shape.slider.x"]
    names = [
        name for name in NAMES if name != "pin.point.z"
    ]  # which exchanges two equal entries of the shape

    def values(found: sr.Equilibrium) -> list[float]:
        return [found[name] for name in outputs]

    def of_modes(found: sr.Modes) -> list[float]:
        place = BASE.bodies.index(next(body for body in BASE.bodies if body.name == "slider")) * 7
        return [
            found.frequencies[0], found.natural_frequencies[0], found.damping_ratios[0], found.shapes[place, 0].real,
            sr.equilibrium(found.system, found.q)["slider.x"],
        ]  # fmt: skip

    agrees(sr.System(BASE), lambda s: sr.equilibrium(s, rest.q), outputs, NAMES, values)
    with pytest.warns(sr.SarrusWarning, match=r"largest in crank\.r\.y and rod\.r\.y"):
        agrees(
            sr.System(BASE),
            lambda s: sr.modes(s, sr.equilibrium(s, rest.q)),
            [*modal, "slider.x"],
            names,
            of_modes,
        )


def oscillator(k: Any = 50.0) -> sr.System:
    """Two masses of 2 and 0.5 kg on a line with a spring between them."""
    bodies = [sr.Body("cart", 2.0, (1, 1, 1)), sr.Body("bob", 0.5, (0.1, 0.1, 0.1), position=(1, 0, 0))]
    rails = [
        sr.Prismatic(f"rail_{body.name}", sr.ground, body, point=body.position, axis=(1, 0, 0))
        for body in bodies
    ]
    spring = sr.TSDA("spring", bodies[0].point(0, 0, 0), bodies[1].point(0, 0, 0), k=k, c=1.0, length=1.0)
    return sr.System(sr.Model("free", bodies, rails, [spring]))


def test_free_motions_beside_the_vibrations_in_closed_form() -> None:
    """ω² = k/m with the reduced mass m; the state itself is not determined along the free motion."""
    system = oscillator()
    rest = sr.equilibrium(system)
    modes = sr.modes(system, rest)
    reduced = 1 / (1 / 2.0 + 1 / 0.5)
    frequency = np.sqrt(50 / reduced) / (2 * np.pi)
    for method in ("adjoint", "direct"):
        found = sr.sensitivity(modes, ["mode2.natural_frequency", "spring.length"], method=method)  # type: ignore[arg-type]
        first, second = found.responses
        assert found[first, "spring.k"] == pytest.approx(frequency / 100, rel=1e-12)
        assert found[first, "cart.mass"] == pytest.approx(-frequency * reduced / 2 / 2.0**2, rel=1e-12)
        assert found[second, "spring.length"] == pytest.approx(1.0, rel=1e-12)
    assert found.response_units == ("Hz", "m")
    with pytest.raises(NoDerivative, match="and the response depends on it"):
        sr.sensitivity(rest, "cart.x", ["spring.k"])
    with pytest.raises(NoDerivative, match="mode1 is a free motion"):
        sr.sensitivity(modes, "mode1.frequency", ["spring.k"])


def test_parameters_that_start_a_free_motion_have_no_derivative() -> None:
    model = oscillator().model
    pushed = sr.PointForce("push", model.bodies[0].point(0, 0, 0), (0.0, 0, 0))
    system = sr.System(replace(model, forces=[*model.forces, pushed]))
    rest = sr.equilibrium(system)
    assert sr.sensitivity(rest, "spring.length", ["spring.k", "push.force.x"]).undefined == ("push.force.x",)


def test_laws_of_springs() -> None:
    system = oscillator([[-1, 60], [-0.5, 45], [0, 40], [0.5, 50], [1, 70]])
    rest = sr.equilibrium(system)
    names = [name for name in written_numbers(system.model) if name.startswith("spring.k")]

    def values(found: sr.Modes) -> list[float]:
        return [float(found.natural_frequencies[1])]

    assert len(names) > 3
    agrees(
        system, lambda s: sr.modes(s, sr.equilibrium(s, rest.q)), ["mode2.natural_frequency"], names, values
    )


def test_modes_of_first_order_states() -> None:
    system = sr.System(motor("(5 - R*current - k*pin.rate)/L", initial=0.0))
    rest = sr.equilibrium(system)
    responses = [
        "mode2.natural_frequency",
        "mode2.damping_ratio",
        "mode1.shape.arm.y",
        "current",
        "pin.angle",
    ]
    names = [
        "current.parameters.R",
        "current.parameters.k",
        "current.parameters.L",
        "arm.mass",
        "current.rate.1",
    ]

    def values(found: sr.Modes) -> list[float]:
        at = sr.equilibrium(found.system, found.q)
        numbers = found.natural_frequencies[1], found.damping_ratios[1], found.shapes[1, 0].real
        return [*map(float, numbers), at["current"], at["pin.angle"]]

    agrees(system, lambda s: sr.modes(s, sr.equilibrium(s, rest.q)), responses, names, values)


def test_repeated_eigenvalues_are_refused_by_name() -> None:
    ground = sr.ground
    blocks = [sr.Body(name, 1.0, (1, 1, 1), position=(1, y, 0)) for y, name in enumerate("abc")]
    slides = [
        sr.Translational(f"slide_{one.name}", ground, one, point=(0, y, 0), axis=(1, 0, 0))
        for y, one in enumerate(blocks)
    ]
    springs = [
        sr.TSDA(f"spring_{one.name}", ground.point(0, y, 0), one.point(0, 0, 0), k=k, length=1.0)
        for y, (one, k) in enumerate(zip(blocks, (10, 10, 30), strict=True))
    ]
    system = sr.System(sr.Model("alike", blocks, slides, springs))
    modes = sr.modes(system, sr.equilibrium(system))
    with pytest.raises(NoDerivative, match="mode1 has the same eigenvalue as another mode"):
        sr.sensitivity(modes, "mode1.frequency", ["a.mass"])
    found = sr.sensitivity(modes, "mode3.frequency", ["c.mass"])
    assert found["c.mass"] == pytest.approx(-np.sqrt(30) / (4 * np.pi), rel=1e-12)


@pytest.mark.parametrize(
    ("response", "message"),
    [
        (sr.Maximum("slider.x"), "is one state without a history"),
        (sr.At("slider.x", time=2.0), "has no state at 2 s. Add this time"),
        (sr.AtEvent("slider.x", event="stop"), "has no events"),
        ("mode1.frequency", "this result has no modes"),
    ],
)
def test_responses_that_an_equilibrium_does_not_have(response: Any, message: str) -> None:
    rest = sr.equilibrium(sr.System(BASE))
    with pytest.raises((ValueError, sr.SarrusError), match=message):
        sr.sensitivity(rest, response, ["spring.k"])
    with pytest.raises(ValueError, match="only first derivatives of this analysis"):
        sr.hessian(rest, "slider.x", ["spring.k"])


def test_modes_are_numbered_from_one() -> None:
    system = sr.System(BASE)
    modes = sr.modes(system, sr.equilibrium(system))
    for name, message in {
        "mode0.frequency": r"no output 'mode0.frequency'. Modes are numbered from 1: mode1.frequency\.",
        "mode9.frequency": r"has no mode9. Choose mode1\.",
    }.items():
        with pytest.raises(sr.SarrusError, match=message):
            sr.sensitivity(modes, name, ["spring.k"])


def test_singular_configurations_have_no_derivatives() -> None:
    system = parallelogram()
    run = sr.kinematics(system, [0.0, 1.0, np.pi - 1.0, 3.0])
    assert run.singular == pytest.approx([np.pi - 1.0])
    sr.sensitivity(run, "coupler.x", ["motor.motion.1"])
    with pytest.raises(NoDerivative, match=r"the configuration at t = 2.14159 s is singular"):
        sr.sensitivity(run, sr.At("coupler.x", time=np.pi - 1.0), ["motor.motion.1"])


def test_natural_frequencies_are_placed_by_optimization() -> None:
    """The reduced mass is 0.4 kg: 2 Hz needs k = 0.4 (4π)²."""
    goal = sr.Combined(lambda f: (f - 2.0) ** 2, ["mode2.natural_frequency"])
    found = sr.optimize(
        oscillator(), goal, ["spring.k"], analysis=rest_and_modes, bounds={"spring.k": (1, 1000)}
    )
    assert found.success
    assert found.x[0] == pytest.approx(0.4 * (4 * np.pi) ** 2, rel=1e-4)


def rest_and_modes(system: sr.System) -> sr.Modes:
    """The modes about the equilibrium."""
    return sr.modes(system, sr.equilibrium(system))


def test_problems_of_other_analyses() -> None:
    problem = sr.Problem(
        sr.System(BASE), ["slider.x", "pin.force.z"], ["spring.k", "rod.mass"], analysis=sr.Statics()
    )
    found = problem.gradient(problem.x0)
    weights, change = np.array([2.0, -1.0]), np.array([0.3, 0.2])
    assert problem.vjp(problem.x0, weights) == pytest.approx(weights @ found.matrix)
    assert problem.jvp(problem.x0, change) == pytest.approx(found.matrix @ change)
    h = 1e-4
    near = [problem.values(problem.x0 + s * h * change) for s in (-1, 1)]
    assert found.matrix @ change == pytest.approx((near[1] - near[0]) / (2 * h), rel=1e-6)
    with pytest.raises(NoDerivative, match="second derivatives of this analysis are not known"):
        problem.hvp(problem.x0, change)
    with pytest.raises(sr.SarrusError, match=r"has no output 'slider\.w'"):
        sr.Problem(sr.System(BASE), "slider.w", ["spring.k"], analysis=sr.Statics())
    with pytest.raises(TypeError, match="give until=, the end of a simulation, or analysis="):
        sr.Problem(sr.System(BASE), "slider.x", ["spring.k"])
    with pytest.raises(
        TypeError, match="start, events, controllers, method and memory are those of a simulation"
    ):
        sr.Problem(sr.System(BASE), "slider.x", ["spring.k"], analysis=sr.Statics(), memory=1e6)
    with pytest.raises(TypeError, match="analysis: it must return the result"):
        sr.Problem(sr.System(BASE), "slider.x", ["spring.k"], analysis=sr.assemble).values(np.ones(1))


def test_the_rate_of_a_drive_is_fitted_to_positions() -> None:
    times = [0.25, 0.5, 1.0]
    run = sr.kinematics(turned(3.0, 0.5), [0.0, *times])
    misfit = sr.Misfit("slider.x", at=times, data=run["slider.x"][1:], sigma=1e-3)
    found = sr.fit(turned(2.9, 0.5), misfit, ["motor.motion.1"], analysis=sr.Kinematics(until=1.0, steps=10))
    assert found.x[0] == pytest.approx(3.0, rel=1e-8)


def normal(mean: float, deviation: float) -> Distribution:
    """A normal distribution."""
    return Distribution("norm", {"loc": mean, "scale": deviation})


@pytest.mark.parametrize(
    ("analysis", "responses"),
    [
        (sr.Statics(), {"x": "slider.x", "force": "2*pin.force.z"}),
        (sr.Vibration(), {"f": "mode1.frequency", "x": "slider.x"}),
        (lambda system: rest_and_modes(system), {"f": "mode1.natural_frequency"}),
    ],
)
def test_uncertainty_of_other_analyses(analysis: Any, responses: dict[str, str]) -> None:
    """Deviations to first order are those of differences."""
    spread = {"spring.k": normal(10, 0.1), "rod.mass": normal(1, 0.02)}
    found = sr.uncertainty(BASE, spread, responses, analysis=analysis)
    sides = sr.study(BASE, {"spring.k": [9.99, 10.01]}, responses, analysis=analysis, workers=1)
    slopes = (sides.found[1] - sides.found[0]) / 0.02
    assert found.matrix[:, 0] == pytest.approx(slopes, rel=1e-5)
    assert found.units[0] == ("m" if "force" in responses else "Hz")


def test_uncertainty_of_a_driven_motion() -> None:
    model = turned(3.0, 0.5).model
    analysis = sr.Kinematics(until=1.0, steps=20)
    responses = {"torque": "max(abs(motor.torque.x))", "x": "at(slider.x, 0.33)"}
    found = sr.uncertainty(model, {"pin.point.z": normal(1, 1e-3)}, responses, analysis=analysis)
    sides = sr.study(model, {"pin.point.z": [0.9999, 1.0001]}, responses, analysis=analysis, workers=1)
    assert found.matrix[1, 0] == pytest.approx((sides.found[1, 1] - sides.found[0, 1]) / 2e-4, rel=1e-5)
    assert found.values[1] == pytest.approx(sides.found[:, 1].mean(), abs=1e-7)
