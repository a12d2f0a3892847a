"""The start of a model beside its design position: of points, angles, sides, files, and derivatives."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

TURN = 0.4
TEXT = """
name: pendulum
gravity: [0, 0, -9.81]
hardpoints: {pivot: [0, 0.5, 0], bob: [0, 0.5, -1]}
bodies:
  frame: {mass: 5, inertia: [1, 1, 1], initial_position: [0, 0, 0.1]}
joints: {guide: {type: translational, bodies: [ground, frame], point: [0, 0, 0], axis: [0, 0, 1]}}
left:
  bodies:
    rod:
      mass: 2
      inertia: {xx: 0.1, yy: 0.1, zz: 0.05, xy: 0.01}
      position: bob
      initial_position: [0.3894183423086505, 0.5, -0.8210609940028851]
      initial_orientation: {axis: [0, 1, 0], angle: -0.4}
  joints:
    pin: {type: revolute, bodies: [frame, rod], point: pivot, axis: [0, 1, 0]}
  forces:
    spring: {type: tsda, points: [frame.pivot, rod.bob], k: 100, length: 0.9}
"""


@pytest.fixture
def model(tmp_path: Path) -> sr.Model:
    file = tmp_path / "pendulum.yaml"
    file.write_text(TEXT)
    return sr.load(file)


def test_points_are_of_the_design_position_and_the_start_is_another(model: sr.Model) -> None:
    system = sr.System(model)
    q = dict(zip(system.bodies, system.q0.reshape(-1, 7), strict=True))
    s, c = np.sin(TURN), np.cos(TURN)
    for side, sign in (("left", 1), ("right", -1)):
        assert q[f"rod_{side}"][:3] == pytest.approx([s, sign * 0.5, 0.1 - c], abs=1e-15)
        turn = [np.cos(TURN / 2), 0, -np.sin(TURN / 2), 0]
        assert abs(q[f"rod_{side}"][3:] @ turn) == pytest.approx(1, abs=1e-15)
    assert abs(system.Phi(system.q0)).max() < 1e-15
    start = sr.assemble(system)
    angles = system.joint_coordinates.Phi(start.q)[1:]
    assert angles == pytest.approx([-TURN, -TURN], abs=1e-15)


def test_the_start_follows_a_hardpoint(model: sr.Model) -> None:
    """A pivot that moves down by dz: the pin closes nearest to the given start."""
    system, h = sr.System(model), 1e-5
    run = sr.simulate(system, until=0.3, store="steps", method=sr.Radau(rtol=1e-10, atol=1e-12))
    gradient = sr.sensitivity(run, sr.Final("rod_left.z"), ["pivot.z", "rod_left.initial_position.z"])

    def final(**given: float) -> float:
        other = sr.System(model.with_parameters({name.replace("__", "."): x for name, x in given.items()}))
        found = sr.simulate(other, until=0.3, method=sr.Radau(rtol=1e-12, atol=1e-14))
        return float(found["rod_left.z"][-1])

    for name, value in (
        ("pivot.z", 0.0),
        ("rod_left.initial_position.z", model.bodies[1].initial_position[2]),
    ):
        ends = [final(**{name: value + x}) for x in (h, -h)]
        assert gradient[name] == pytest.approx((ends[0] - ends[1]) / (2 * h), abs=1e-7)
    assert abs(gradient["rod_left.initial_position.z"]) > 1e-3


def test_a_saved_model_has_both_positions(model: sr.Model, tmp_path: Path) -> None:
    plans = []
    for name, one in (("a.yaml", model), ("b.yaml", replace(model, origin=None))):
        one.save(tmp_path / name)
        plans.append(sr.System(sr.load(tmp_path / name)))
    for plan in plans:
        assert np.array_equal(plan.q0, sr.System(model).q0)
        assert np.array_equal(plan.b, sr.System(model).b)


def test_an_orientation_that_is_none_is_refused() -> None:
    with pytest.raises(sr.ModelError, match='body "rod": at the start: orientation must be unit'):
        sr.Body("rod", 1.0, (1, 1, 1), initial_orientation=(1, 1, 0, 0))


def test_an_export_has_the_joints_of_the_design_position(tmp_path: Path) -> None:
    """In a URDF the start is the position where all coordinates are zero: origins are those of the start."""
    rod = sr.Body(
        "rod", 1.0, (1, 1, 1), position=(0, 0, -1), initial_position=(1, 0, 0),
        initial_orientation=sr.AxisAngle((0, 1, 0), -np.pi / 2),
    )  # fmt: skip
    pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 1, 0))
    sr.Model("pendulum", [rod], [pin]).save(tmp_path / "rod.urdf")
    again = sr.System(sr.load(tmp_path / "rod.urdf"))
    found = next(body for body in again.model.bodies if body.name == "rod")
    assert found.pose().global_point(np.array(found.mass_properties().center)) == pytest.approx((1, 0, 0))
