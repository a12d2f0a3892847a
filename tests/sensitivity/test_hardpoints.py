"""Derivatives by hardpoints, compared with a four-bar in closed form and with models that are built of numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.views.notebook import table_of

POINTS = {"A": (0, 0, 0), "B": (-20, 0, 120), "C": (250, 0, 210), "D": (300, 0, 10), "tip": (115, 0, 260)}
TURN = 0.3  # [rad] of the crank
USED = [f"{name}.{axis}" for name in POINTS for axis in "xz"]


def four_bar(p: Mapping[str, Any], *, driven: bool = False) -> sr.Model:
    """A planar four-bar in the plane y = 0 with a spring from the ground to its coupler."""
    inertia, y = (0.01, 0.02, 0.01), (0, 1, 0)
    crank = sr.Body("crank", 1.0, inertia, position=p["A"])
    coupler = sr.Body("coupler", 2.0, inertia, position=p["tip"])
    rocker = sr.Body("rocker", 1.5, inertia, position=p["D"])
    joints = [
        sr.Revolute("a", sr.ground, crank, point=p["A"], axis=y),
        sr.Revolute("b", crank, coupler, point=p["B"], axis=y),
        sr.Spherical("c", coupler, rocker, point=p["C"]),
        sr.Cylindrical("d", sr.ground, rocker, point=p["D"], axis=y),
    ]
    spring = sr.TSDA(
        "spring", sr.ground.global_point(*p["D"]), coupler.global_point(*p["tip"]), 900, length=0.2, c=5
    )
    drivers = [sr.AngleDriver("motor", "a", "t")] if driven else []
    return sr.Model("four-bar", [crank, coupler, rocker], joints, [spring], (0, 0, -9.81), drivers)


def numbers(points: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The points in metres, as arrays."""
    return {name: np.array(place) / 1000 for name, place in points.items()}


def moved(name: str, change: float) -> dict[str, np.ndarray]:
    """The points as arrays, with a change [m] of one coordinate."""
    found, (point, axis) = numbers(POINTS), name.split(".")
    found[point] = found[point].astype(type(change + 0.0))
    found[point]["xyz".index(axis)] += change
    return found


def differences(response: Callable[[dict[str, np.ndarray]], float], step: float) -> list[float]:
    """Central differences of a response by all coordinates in the plane."""
    return [(response(moved(name, step)) - response(moved(name, -step))) / (2 * step) for name in USED]


def tip_of(points: Mapping[str, Any], turn: float) -> Any:
    """Height of the coupler's point after a turn of the crank about y, in closed form; complex numbers z + i x."""
    a, b, c, d, tip = (complex_point(points[name]) for name in POINTS)
    rotated = a + (b - a) * np.exp(1j * turn)
    rod, arm, apart = length(c - b), length(d - c), length(d - rotated)
    cosine = (rod**2 + apart**2 - arm**2) / (2 * rod * apart)
    sine = np.sqrt(1 - cosine * cosine)
    side = (d - rotated) / apart
    directions = [side * (cosine + sign * 1j * sine) for sign in (1, -1)]
    start = (c - b) / rod
    direction = max(directions, key=lambda one: (one / start).real)
    return rotated + (tip - b) * direction / start


def complex_point(place: Any) -> complex:
    return complex(place[2], place[0])


def length(z: complex) -> float:
    return float(abs(z))


@pytest.fixture(scope="module")
def system() -> sr.System:
    return sr.System(four_bar(sr.Hardpoints(POINTS, unit="mm")))


def test_of_a_driven_position_in_closed_form() -> None:
    points = sr.Hardpoints(POINTS, unit="mm")
    run = sr.kinematics(sr.System(four_bar(points, driven=True)), [0.0, TURN / 2, TURN])
    found = sr.sensitivity(run, "coupler.z", USED)
    assert run["coupler.z"][-1] == pytest.approx(tip_of(numbers(POINTS), TURN).real, rel=1e-12)
    expected = differences(lambda p: float(tip_of(p, TURN).real), 1e-5)
    assert found.matrix[0] == pytest.approx(expected, rel=1e-8, abs=1e-9)


def test_of_an_equilibrium(system: sr.System) -> None:
    found = sr.sensitivity(sr.equilibrium(system), "coupler.z", "hardpoints")
    expected = differences(rest, 1e-5)
    assert [found[name] for name in USED] == pytest.approx(expected, rel=1e-7, abs=1e-8)


def rest(points: dict[str, np.ndarray]) -> float:
    """Height of the coupler's point at rest, of a model built of numbers."""
    return float(sr.equilibrium(sr.System(four_bar(points)))["coupler.z"])


def test_of_a_run(system: sr.System) -> None:
    run = sr.simulate(system, until=0.1, method=sr.Radau(rtol=1e-10, atol=1e-12), store="steps")
    found = sr.sensitivity(run, "coupler.z", USED)
    expected = differences(after, 2e-5)
    assert found.matrix[0] == pytest.approx(expected, rel=1e-6, abs=1e-7)


def after(points: dict[str, np.ndarray]) -> float:
    run = sr.simulate(sr.System(four_bar(points)), until=0.1, method=sr.Radau(rtol=1e-10, atol=1e-12))
    return float(run["coupler.z"][-1])


def test_tables_show_derivatives_per_unit_of_the_hardpoints(system: sr.System) -> None:
    found = sr.sensitivity(sr.equilibrium(system), "coupler.z", ["tip.z", "spring.k"])
    lines = {line.split()[0]: line.split() for line in str(found).splitlines()[2:]}
    assert lines["tip.z"][1:5] == ["260", "mm", f"{found['tip.z'] / 1000:+.7g}", "m/mm"]
    assert lines["spring.k"][1:5] == ["900", "N/m", f"{found['spring.k']:+.7g}", "m²/N"]


def test_second_derivatives_and_optima_are_shown_in_these_units(system: sr.System) -> None:
    run = sr.simulate(system, until=0.05, method=sr.Radau(), store="steps")
    found = sr.hessian(run, "coupler.z", ["tip.z", "spring.k"])
    names, matrix = found.in_table_units()
    assert names == ["tip.z [mm]", "spring.k [N/m]"]
    assert matrix == pytest.approx(found.matrix * [[1e-6, 1e-3], [1e-3, 1.0]], rel=1e-14)
    assert f"{1e-6 * found['tip.z', 'tip.z']:.6g}" in str(found)
    height = sr.equilibrium(system)["coupler.z"]
    raised = sr.Final(lambda o: (o("coupler.z") - height - 1e-3) ** 2, name="height")
    best = sr.optimize(system, raised, ["tip.z"], analysis=sr.equilibrium)
    name, start, end, unit = str(best).splitlines()[2].split()
    assert (name, start, unit) == ("tip.z", "260", "mm")
    assert float(end) == pytest.approx(1000 * best["tip.z"], rel=1e-5)
    assert table_of(best).rows == [(name, start, end, unit)]


P = sr.Hardpoints({"upper": (100, 700, 200), "lower": (300, 350, 100)}, unit="mm")
RATIO = P.upper.x / P.lower.x
BALL = sr.Body("ball", 2.0, (0.1, 0.2, 0.3), position=(0, 0.2, 0.1))
ENDS = sr.Point(sr.ground, (0, 0, 1)), sr.Point(BALL, (0, 0, 0))
HINGE = sr.Revolute("hinge", sr.ground, BALL, (0, 0, 0), (1, 0, 0))
TURNED = (sr.ground, BALL, (0, 0, 0), (1, 0, 0))
ARM = sr.PointForce("arm", sr.Point(BALL, (0, 0.1, 0)), (0, 0, 5), axes="body")
FIELDS: dict[str, list[Any]] = {
    "stiffness of a spring": [sr.TSDA("s", *ENDS, k=100 * RATIO, length=0.3)],
    "damping of a spring": [sr.TSDA("s", *ENDS, k=100, length=0.3, c=10 * RATIO)],
    "load of a spring": [sr.TSDA("s", *ENDS, k=100, length=0.3, force=10 * RATIO)],
    "length of a spring": [sr.TSDA("s", *ENDS, k=100, length=P.upper.x * RATIO)],
    "stiffness of a torsional spring": [HINGE, sr.RSDA("s", *TURNED, k=20 * RATIO, angle=0.3)],
    "damping of a torsional spring": [HINGE, sr.RSDA("s", *TURNED, k=1, c=2 * RATIO)],
    "load of a torsional spring": [HINGE, sr.RSDA("s", *TURNED, k=1, torque=10 * RATIO)],
    "motion of a driver": [HINGE, sr.AngleDriver("d", "hinge", RATIO - 1 / 3)],
    "drag": [sr.Drag("s", sr.Point(BALL, (0, 0, 0)), 3 * RATIO)],
    "input": [sr.Input("u", value=10 * RATIO), sr.PointForce("f", sr.Point(BALL, (0, 0, 0)), (0, 0, "u"))],
    "force": [sr.PointForce("f", sr.Point(BALL, (0, 0.1, 0)), (0, 0, 10 * RATIO))],
    "factor of a force": [sr.PointForce("f", sr.Point(BALL, (0, 0.1, 0)), (0, 0, 1), factor=10 * RATIO)],
    "torque": [sr.Torque("m", BALL, torque=(3 * RATIO, 0, 0)), ARM],
    "factor of a torque": [sr.Torque("m", BALL, torque=(1, 0, 0), factor=3 * RATIO), ARM],
    "value of a force": [sr.Force("f", *ENDS, value=10 * RATIO)],
    "parameter of a force": [
        sr.PointForce("f", sr.Point(BALL, (0, 0, 0)), (0, 0, "rise*t"), parameters={"rise": 10 * RATIO})
    ],
}


@pytest.mark.parametrize("parts", FIELDS.values(), ids=FIELDS)
def test_numbers_of_every_field_follow_hardpoints(parts: list[Any]) -> None:
    model = sr.Model("ball", [BALL], gravity=(0, 0, -9.81)).adding(*parts)
    assert_follows(model)


def test_gravity_follows_hardpoints() -> None:
    model = sr.Model("ball", [BALL], gravity=(0, 0, -9.81 * RATIO))  # type: ignore[arg-type]
    assert model.with_parameters({"lower.x": 0.1}).gravity[2] == pytest.approx(-9.81)
    assert_follows(model)


def assert_follows(model: sr.Model) -> None:
    """The derivatives by hardpoints are those of models with other hardpoints."""

    def run(model: sr.Model, store: Any = "samples") -> sr.Trajectory:
        return sr.simulate(sr.System(model), until=0.3, store=store, method=sr.Radau(rtol=1e-10, atol=1e-12))

    def height(name: str, change: float) -> float:
        changed = {name: model.parameters[name] + change}
        return float(run(model.with_parameters(changed))["ball.z"][-1])

    names, step = ["upper.x", "lower.x"], 2e-5
    expected = [(height(name, step) - height(name, -step)) / (2 * step) for name in names]
    found = sr.sensitivity(run(model, "steps"), "ball.z", names)
    assert np.abs(expected).min() > 1e-3
    assert found.matrix[0] == pytest.approx(expected, rel=1e-6)


def test_numbers_of_formulas_in_laws_have_derivatives() -> None:
    """The height of a mass m on a spring of stiffness k that is 2*50 N/m: z = -m g/k at rest."""
    mass = sr.Body("mass", 2.0, (1, 1, 1), position=(0, 0, 0.7))
    ends = sr.Point(sr.ground, (0, 0, 1)), sr.Point(mass, (0, 0, 0))
    guide = sr.Translational("guide", sr.ground, mass, (0, 0, 0), (0, 0, 1))
    spring = sr.TSDA("spring", *ends, k="2*50", length=0.3)
    rest = sr.equilibrium(sr.System(sr.Model("m", [mass], [guide], [spring], (0, 0, -9.81))))
    found = sr.sensitivity(rest, "mass.z", ["spring.k.1", "spring.k.2"])
    assert found.matrix[0] == pytest.approx([2 * 9.81 / 100 / 2, 2 * 9.81 / 100 / 50], rel=1e-9)
