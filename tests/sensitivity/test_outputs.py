"""Every kind of output: its value is that of the run, its derivatives forward, backward, and of differenced runs."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.prescribed_steps import run_of
from tests.sensitivity.frozen import again, differenced, solved
from tests.sensitivity.frozen import values as valued
from tests.sensitivity.test_curves import ARM

import sarrus as sr

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*assembly changed", "ignore:spring. its table ends"
)  # states here are drawn roughly

STIFFNESS = [[0.2, 8], [0.8, 12], [1.5, 20], [3.0, 50]]
NAMES = ["arm.mass", "pin.point.y", "spring.k.2.y", "coil.k", "line.k", "tip.velocity.y", "gravity.y"]
POINT = (0.1, 0.2, -0.3)


@cache
def system() -> sr.System:
    """Two links that turn several times, with springs by numbers, by a table and by a formula."""
    arm, tip = (
        sr.Body("arm", mass=1, inertia=(1, 1, 1), position=(0.5, 0, 0), angular_velocity=(0, 0, 6)),
        sr.Body("tip", mass=0.7, inertia=(0.1, 0.2, 0.3), position=(1.5, 0, 0), velocity=(0, 7, 0)),
    )
    axis = (0, 0, 1)
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=axis)
    elbow = sr.Revolute("elbow", arm, tip, point=(1, 0, 0), axis=axis)
    end = sr.ground.point(0.2, 1.5, 0.1)
    forces = [
        sr.TSDA("spring", tip.point(0.1, 0, 0), end, k=STIFFNESS, c=0.3, length=0.7),
        sr.TSDA("line", tip.point(0.1, 0, 0), end, k=4.0, c=0.2, length=0.5, force=1.0),
        sr.RSDA("coil", sr.ground, arm, point=(0, 0, 0), axis=axis, k=0.1, c=0.02, angle=0.3),
        sr.RSDA(
            "motor", arm, tip, point=(1, 0, 0), axis=axis, k=lambda x: 0.3 + 0.1 * x * x, c=0.0, torque=0.5
        ),
    ]
    return sr.System(
        sr.Model("arm", bodies=[arm, tip], joints=[pin, elbow], forces=forces, gravity=(0, -9.81, 0))
    )


@cache
def run() -> sr.Trajectory:
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-6, atol=1e-8)}
    return sr.simulate(system(), until=2.0, t_eval=np.linspace(0, 2.0, 81), **settings)


@cache
def exact() -> sr.Trajectory:
    return solved(run(), sr.Radau())


def pull(name: str) -> float:
    """The tension at the end, from what the generalized force is without the spring."""
    without, end = system().b.copy(), (run().q[-1], run().v[-1], run().t[-1])
    own = [n for n, number in enumerate(system().parameter_names) if number.startswith(f"{name}[")]
    scales = [n for n in own if system().parameter_names[n].rpartition(".")[2] in ("k", "c", "force")]
    without[scales] = 0.0
    force = (system().Q(*end) - system().Q(*end, b=without))[system().coordinates_of("tip").start :][:3]
    line = np.array([0.2, 1.5, 0.1]) - run()["tip"].position[-1] - 0.1 * axis_of_tip()
    return float(force @ line / np.linalg.norm(line))


def axis_of_tip() -> np.ndarray:
    """The first axis of the tip at the end."""
    p = run().q[-1][system().coordinates_of("tip")][3:]
    return np.array(
        [1 - 2 * (p[2] ** 2 + p[3] ** 2), 2 * (p[1] * p[2] + p[0] * p[3]), 2 * (p[1] * p[3] - p[0] * p[2])]
    )


WANTED = {  # values at the end, from what else the results tell
    "tip.x": lambda r: r["tip"].position[-1, 0],
    "tip.velocity.y": lambda r: r["tip"].velocity[-1, 1],
    "tip.acceleration.x": lambda r: r.a[-1][system().coordinates_of("tip").start],
    "tip.angular_velocity.z": lambda r: r["tip"].angular_velocity_body[-1, 2],
    "pin.angle": lambda r: r.joint("pin").angle[-1],
    "pin.angle.rate": lambda r: r.joint("pin").rate[-1],
    "elbow.force.x": lambda r: r.reaction("elbow").force[-1, 0],
    "pin.torque.y": lambda r: r.reaction("pin").torque[-1, 1],
    "pin.multiplier.2": lambda r: r.lam[-1, system().rows["pin"][1]],
    "energy.kinetic": lambda r: r.kinetic_energy[-1],
    "energy.potential": lambda r: r.potential_energy[-1],
    "energy.total": lambda r: r.kinetic_energy[-1] + r.potential_energy[-1],
    "spring.length": lambda r: np.linalg.norm(
        r["tip"].position[-1] + 0.1 * axis_of_tip() - np.array([0.2, 1.5, 0.1])
    ),
    "spring.tension": lambda r: pull("spring"),
    "line.tension": lambda r: pull("line"),
    "coil.angle": lambda r: r.joint("pin").angle[-1],
    "coil.rate": lambda r: r.joint("pin").rate[-1],
    "coil.torque": lambda r: 0.1 * (r.joint("pin").angle[-1] - 0.3) + 0.02 * r.joint("pin").rate[-1],
    "motor.angle": lambda r: r.joint("elbow").angle[-1],
    "motor.torque": lambda r: (lambda x: (0.3 + 0.1 * x * x) * x + 0.5)(r.joint("elbow").angle[-1]),
}


def bent(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """What cannot be recorded: a function of plain arrays."""
    return np.interp(x, [-10, 10], [-5, 5]) * np.fmod(y, 1e6)


def with_her_own_derivative(o):
    """It is 0.5 x y."""
    return o.own(bent, lambda x, y: (0.5 * y, 0.5 * x), o("spring.length"), o("pin.angle"))


RESPONSES = [
    *(sr.Final(name) for name in WANTED),
    sr.Final(lambda o: o.position("tip", POINT)[0], name="place of a point"),
    sr.Final(lambda o: o.velocity("tip", POINT)[1], name="its velocity"),
    sr.Final(lambda o: o.acceleration("tip", POINT)[1], name="its acceleration"),
    sr.Integral(lambda o: o.parameter("spring.c") * o("spring.rate") ** 2, name="with a parameter"),
    sr.Integral("energy.total"),
    sr.At("motor.torque", time=0.77),
    sr.Maximum("spring.tension"),
    sr.Final(with_her_own_derivative),
    sr.Final(lambda o: 0.5 * o("spring.length") * o("pin.angle"), name="the same, recorded"),
]


@cache
def gradient(method: str) -> sr.Gradient:
    return sr.sensitivity(exact(), RESPONSES, NAMES, method=method)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", WANTED)
def test_the_value_is_that_of_the_run(name: str) -> None:
    assert abs(run().joint("pin").angle[-1]) > 2 * np.pi  # turns are counted
    found = sr.sensitivity(run(), RESPONSES[list(WANTED).index(name)], NAMES[:1]).values[0]
    # Nodes of Radau are on the constraints to 1e-9 m with this atol, reported states to round-off: by 3e-8 their
    # accelerations differ
    limit = 5e-8 if "acceleration" in name else 1e-8
    assert found == pytest.approx(WANTED[name](run()), rel=limit, abs=limit)


def test_forward_and_backward_agree() -> None:
    found, direct = gradient("adjoint").matrix, gradient("direct").matrix
    scale = abs(found).max(axis=1, keepdims=True)
    assert np.all(abs(found - direct) < 1e-11 * scale)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", NAMES)
def test_gradients_are_those_of_differenced_simulations(name: str) -> None:
    found = gradient("adjoint")
    scale = abs(found.matrix).max(axis=1)
    # By a point, 2e-4, 1e-4, 5e-5 and 2.5e-5 are 2.3e-6, 1.5e-7, 9e-9 and 6e-10 off: the error of differences
    step = 5e-5 if name == "pin.point.y" else 1e-4
    wanted = differenced(exact(), RESPONSES, name, step, sr.Radau())
    worst = abs(found[name] - wanted) / scale
    assert np.all(worst < 1e-7), dict(zip(found.responses, worst, strict=True))


def test_a_derivative_of_her_own_is_that_of_the_recorded_function() -> None:
    found = gradient("adjoint").matrix
    assert abs(found[-2]).max() > 0.1
    assert found[-2] == pytest.approx(found[-1], rel=1e-12)


@pytest.mark.slow
def test_second_derivatives_ask_for_those_of_her_own_function() -> None:
    fall = sr.simulate(system(), until=0.1, store="steps")
    with pytest.raises(ValueError, match="second derivatives need those of your own function"):
        sr.hessian(fall, sr.Final(with_her_own_derivative), ["arm.mass"])

    def complete(o):
        pair = o("spring.length"), o("pin.angle")
        return o.own(
            bent, lambda x, y: (0.5 * y, 0.5 * x), *pair, bends=lambda x, y: ((0.0, 0.5), (0.5, 0.0))
        )

    names = ["arm.mass", "coil.k"]
    own, same = (sr.hessian(fall, sr.Final(f), names).matrix for f in (complete, RESPONSES[-1].of))
    assert own == pytest.approx(same, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["spring.tension", "energy.total", "motor.torque"])
def test_second_derivatives_are_those_of_differenced_gradients(name: str) -> None:
    fall = solved(sr.simulate(system(), until=0.1, store="steps", method=sr.HHT()), sr.HHT())
    names = ["arm.angular_velocity.z", "tip.velocity.y"]

    def slope(e: float) -> np.ndarray:
        there = [again(fall.system, fall.steps, sr.HHT(), {names[0]: 6.0 + d}) for d in (e, -e)]
        pair = [replace(fall, system=other, steps=steps) for other, steps in there]
        ends = [sr.sensitivity(run, sr.Final(name), names).matrix[0] for run in pair]
        return (ends[0] - ends[1]) / (2 * e)

    found = sr.hessian(fall, sr.Final(name), names).matrix[0]
    assert found == pytest.approx((4 * slope(5e-3) - slope(1e-2)) / 3, rel=1e-6)


def test_numbers_of_a_formula_in_a_law(tmp_path: Path) -> None:
    """The tension depends on them by itself, too."""
    (tmp_path / "arm.yaml").write_text(ARM)
    system = sr.System(sr.load(tmp_path / "arm.yaml"))
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-6, atol=1e-8)}
    swing = solved(sr.simulate(system, until=0.5, t_eval=[0.5], **settings), sr.Radau())
    responses = [sr.Final("spring.tension"), sr.Integral("spring.tension")]
    found = {
        way: sr.sensitivity(swing, responses, "size", method=way)["size"] for way in ("adjoint", "direct")
    }
    assert found["direct"] == pytest.approx(found["adjoint"], rel=1e-10)
    assert found["adjoint"] == pytest.approx(
        differenced_file(swing, responses, tmp_path / "arm.yaml"), rel=1e-7
    )


def differenced_file(swing: sr.Trajectory, responses: list, path: Path) -> np.ndarray:
    """Differences of whole runs of the file with another parameter, with the same lengths of steps."""

    def at(size: float) -> np.ndarray:
        path.write_text(ARM.replace("size: 0.1", f"size: {size!r}"))
        system = sr.System(sr.load(path))
        steps = swing.steps
        settings = {"rtol": steps.rtol, "atol": steps.atol, "store_steps": True, "given": steps.h}
        again = run_of(sr.Radau(), system, sr.assemble(system), np.array([0.0, 0.5]), **settings)
        return valued(system, again.steps, responses)

    slopes = [(at(0.1 + e) - at(0.1 - e)) / (2 * e) for e in (4e-4, 2e-4)]
    return (4 * slopes[1] - slopes[0]) / 3


def test_a_body_may_be_called_energy() -> None:
    body = sr.Body("energy", mass=1.0, inertia=(1.0, 1.0, 1.0), velocity=(2.0, 0.0, 0.0))
    run = sr.simulate(sr.System(sr.Model("named", bodies=[body])), until=0.1, store="steps")
    found = sr.sensitivity(run, ["energy.x", "energy.kinetic"], ["energy.mass", "energy.velocity.x"])
    assert np.allclose(found.values, [0.2, 2.0])
    assert np.allclose(found.matrix, [[0.0, 0.1], [2.0, 2.0]])
