"""What a name means where a number, a parameter of the file and a design variable share it."""

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.sensitivity.parameters.parameters import Parameters, UnknownParameter

# Derivatives by HHT and generalized-α are only named and shown here; their errors do not matter
pytestmark = []

SWING = """
name: swing
gravity: [0, -9.81, 0]
parameters: {arm: {mass: 0.8}}
bodies:
  arm: {mass: 2*arm.mass, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
  bob: {mass: arm.mass, inertia: [0.1, 0.1, 0.1], position: [1.0, 0.2, 0]}
joints:
  pin: {type: revolute, bodies: [ground, arm], point: [0, 0, 0], axis: [0, 0, 1]}
  hook: {type: revolute, bodies: [arm, bob], point: [1, 0, 0], axis: [0, 0, 1]}
forces:
  coil: {type: rsda, bodies: [ground, arm], point: [0, 0, 0], axis: [0, 0, 1], k: 5}
"""


def loaded(folder: Path, **given: float) -> sr.Trajectory:
    (folder / "swing.yaml").write_text(SWING)
    system = sr.System(sr.load(folder / "swing.yaml", parameters=given or None))
    return sr.simulate(system, until=0.3, method=sr.HHT(step=0.01), store="steps")


def test_a_parameter_is_meant_where_a_number_has_its_name(tmp_path: Path) -> None:
    """As in formulas and in studies: everything that follows from it changes."""
    wanted = [sr.Final("bob.y"), sr.Final(lambda o: o.parameter("arm.mass") * o("bob.x"))]
    found = sr.sensitivity(loaded(tmp_path), wanted, ["arm.mass"])
    values = [sr.sensitivity(loaded(tmp_path, **{"arm.mass": m}), wanted, []).values for m in (0.799, 0.801)]
    assert found.at == [0.8]
    assert found["arm.mass"] == pytest.approx((values[1] - values[0]) / 0.002, rel=1e-5)
    problem = sr.Problem(loaded(tmp_path).system, wanted, ["arm.mass"], until=0.3, method=sr.HHT(step=0.01))
    assert problem.values([0.801]) == pytest.approx(values[1], rel=1e-9)


def test_a_design_variable_is_meant_where_a_number_has_its_name(tmp_path: Path) -> None:
    """The number itself stays as it is."""
    run = loaded(tmp_path)
    design = {"design": {"coil.k": 1.0}, "formula": lambda d: {"bob.mass": 0.8 * d["coil.k"]}}
    found = sr.sensitivity(run, "bob.y", **design)
    assert found["coil.k"] == pytest.approx(0.8 * sr.sensitivity(run, "bob.y", ["bob.mass"])["bob.mass"])


BALL = """
name: ball
gravity: [0, 0, -9.81]
parameters: {floor: 0.05}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.1], velocity: [0, 0, -1]}
forces:
  floor: {type: sphere_contact, center: {body: ball, at: [0, 0, 0]}, stiffness: 500,
          plane: {body: ground, at: [0, 0, floor], z: [0, 0, 1]}}
"""


def test_a_parameter_places_a_plane(tmp_path: Path) -> None:
    (tmp_path / "ball.yaml").write_text(BALL)
    system = sr.System(sr.load(tmp_path / "ball.yaml"))
    run = sr.simulate(system, until=0.1, method=sr.HHT(step=0.005), store="steps")
    found = sr.sensitivity(run, "ball.z", ["floor"])["floor"]
    assert found == pytest.approx(
        sr.sensitivity(run, "ball.z", ["floor.plane.point.z"])["floor.plane.point.z"]
    )
    assert abs(found) > 0.1


def test_a_parameter_of_the_file_that_is_an_exponent_is_refused(tmp_path: Path) -> None:
    """Its derivative was zero in silence. As a parameter of the part, the exponent has a place."""
    file = tmp_path / "stop.yaml"
    text = """
        parameters: {n: 1.5}
        bodies: {m: {mass: 1, inertia: [1, 1, 1]}}
        forces: {stop: {type: point_force, point: {body: m, at: [0, 0, 0]}, force: ["-2*max(0, m.x)^n", 0, 0]MORE}}
    """
    file.write_text(text.replace("MORE", ""))
    with pytest.raises(
        UnknownParameter, match="n is an exponent in a formula of stop, where it is a constant"
    ):
        Parameters(sr.System(sr.load(file)), ["n"])
    file.write_text(text.replace("^n", "^p").replace("MORE", ", parameters: {p: n}"))
    system = sr.System(sr.load(file))
    (change,) = Parameters(system, ["n"]).along(np.eye(1))[0].T
    assert system.b[change == 1] == pytest.approx([1.5])
