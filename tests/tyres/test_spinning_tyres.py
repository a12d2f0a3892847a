"""Tyres whose spin is a state, against wheels that are bodies, and the laws of conservation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.tyres.test_rolling_tyres import BRUSH, TYRES, G

import sarrus as sr

J, ACROSS, WHEEL_MASS, CARRIER_MASS = 1.3, 0.8, 20.0, 380.0
CENTRE = np.array([0.05, 0.12, 0.295])  # of the wheel
CARRIER = np.array([0.0, 0.0, 0.35])
AXIS = np.array([0.02, 1.0, 0.03]) / np.linalg.norm([0.02, 1.0, 0.03])
OWN = np.diag([40.0, 35.0, 60.0])
SPEED, SPIN = np.array([18.0, 0.2, 0.0]), 58.0
OMEGA = np.array([0.05, 0.3, 0.2])
TIGHT = sr.Radau(rtol=1e-10, atol=1e-12)
LOADS = "60*step(t, 0.1, 0, 0.2, 1)"
UPRIGHT = "-8000*carrier.rotation_x - 800*carrier.angular_velocity.x"


def across(inertia: float) -> np.ndarray:
    """inertia (I - s sᵀ)."""
    return inertia * (np.eye(3) - np.outer(AXIS, AXIS))


def steiner(mass: float, d: np.ndarray) -> np.ndarray:
    return mass * ((d @ d) * np.eye(3) - np.outer(d, d))


MASS = CARRIER_MASS + WHEEL_MASS
BOTH = (CARRIER_MASS * CARRIER + WHEEL_MASS * CENTRE) / MASS
TENSOR = OWN + across(ACROSS) + steiner(CARRIER_MASS, CARRIER - BOTH) + steiner(WHEEL_MASS, CENTRE - BOTH)


def as_body(kind: str = "brush") -> sr.System:
    """A free carrier with the wheel as a body on a hinge, steered and braked."""
    carrier = sr.Body(
        "carrier",
        mass=CARRIER_MASS,
        inertia=OWN.tolist(),
        position=CARRIER,
        velocity=SPEED,
        angular_velocity=OMEGA,
    )
    wheel = sr.Body(
        "wheel",
        mass=WHEEL_MASS,
        inertia=(across(ACROSS) + J * np.outer(AXIS, AXIS)).tolist(),
        position=CENTRE,
        velocity=SPEED + np.cross(OMEGA, CENTRE - CARRIER),
        angular_velocity=OMEGA + (SPIN - OMEGA @ AXIS) * AXIS,
    )
    of, numbers = TYRES[kind]
    parts = [
        of("tyre", wheel.point(0, 0, 0), axis=AXIS, **numbers),
        sr.Brake("brake", "hub", "60*step(t, 0.3, 0, 0.4, 1)"),
        sr.Torque("steer", carrier, (UPRIGHT, 0, LOADS)),
    ]
    hub = sr.Revolute("hub", carrier, wheel, point=CENTRE, axis=AXIS)
    return sr.System(sr.Model("wheel as a body", [carrier, wheel], [hub], parts, gravity=(0, 0, -G)))


def as_state(kind: str = "brush", height: float = 0.0, spin_inertia: float = J, **given: Any) -> sr.System:
    """The same with the spin as a state: the carrier has the mass and the transverse inertia of the wheel."""
    lifted = np.array([0, 0, height])
    carrier = sr.Body(
        "carrier",
        mass=MASS,
        inertia=TENSOR.tolist(),
        position=BOTH + lifted,
        velocity=SPEED + np.cross(OMEGA, BOTH - CARRIER),
        angular_velocity=OMEGA,
    )
    of, numbers = TYRES[kind]
    point = carrier.point(*(CENTRE - BOTH))
    tyre = of("tyre", point, axis=AXIS, spin_inertia=spin_inertia, initial_spin=SPIN, **numbers)
    parts = [tyre]
    if not height:
        parts.append(sr.Brake("brake", "tyre", "60*step(t, 0.3, 0, 0.4, 1)"))
        parts.append(sr.Torque("steer", carrier, (UPRIGHT, 0, LOADS)))
    gravity = (0, 0, 0 if height else -G)
    return sr.System(sr.Model("spin as a state", [carrier], [], parts, gravity=gravity))


@pytest.mark.parametrize("kind", ["brush", pytest.param("magic formula 6.1", marks=pytest.mark.slow)])
def test_like_a_wheel_that_is_a_body(kind: str) -> None:
    """Driving, steering, braking, and gyroscopic torques on a free carrier."""
    body, state = (
        sr.simulate(one, until=1.0, t_eval=np.linspace(0, 1, 11), method=TIGHT)
        for one in (as_body(kind), as_state(kind))
    )
    offset = BOTH - CARRIER
    place = "carrier({}, {}, {})".format(*offset)
    for axis in "xyz":
        assert state[f"carrier.{axis}"] == pytest.approx(body[f"{place}.{axis}"], abs=1e-6)
        words = f"carrier.angular_velocity.{axis}"
        assert state[words] == pytest.approx(body[words], abs=1e-6)
    for word in ("load", "slip", "lateral_force", "longitudinal_force", "aligning_moment"):
        assert state[f"tyre.{word}"] == pytest.approx(body[f"tyre.{word}"], rel=1e-5, abs=1e-3)
    assert state["tyre.rate"] == pytest.approx(body["hub.rate"], abs=1e-6)
    assert state["brake.value"] == pytest.approx(body["brake.value"], abs=1e-6)
    assert abs(np.ptp(body["tyre.lateral_force"])) > 100
    assert body["hub.rate"][-1] < body["hub.rate"][0] - 1


def test_energy_and_angular_momentum_are_conserved_off_the_road() -> None:
    system = as_state(height=5.0)
    run = sr.simulate(system, until=3.0, t_eval=np.linspace(0, 3, 31), method=TIGHT)
    kinetic = run.total_energy + run["tyre.spin_energy"]
    assert kinetic == pytest.approx(np.full(31, kinetic[0]), rel=1e-8)  # 3e-7 N remain without load
    momenta = []
    for n in range(31):
        A = rotation(np.array([run[f"carrier.e{k}"][n] for k in range(4)]))
        omega = np.array([run[f"carrier.angular_velocity.{axis}"][n] for axis in "xyz"])
        momenta.append(A @ TENSOR @ A.T @ omega + J * run["tyre.spin"][n] * (A @ AXIS))
    assert np.ptp(momenta, axis=0) == pytest.approx(np.zeros(3), abs=1e-5)
    assert run["tyre.spin"] == pytest.approx(np.full(31, SPIN), rel=1e-6)
    assert np.ptp(run["carrier.angular_velocity.x"]) > 0.05  # it precesses
    assert not run.warnings


def rotation(p: np.ndarray) -> np.ndarray:
    e0, e = p[0], p[1:]
    skew = np.array([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
    return (2 * e0**2 - 1) * np.eye(3) + 2 * (np.outer(e, e) + e0 * skew)


def test_energies_of_a_run_with_a_brake_are_balanced() -> None:
    run = sr.simulate(as_state(), until=1.0, method=sr.Radau(rtol=1e-9, atol=1e-11), store="steps")
    balance = run.energy_balance()
    assert balance.total == pytest.approx(np.full(len(run.t), balance.total[0]), abs=0.05)
    assert -balance.supplied["brake"][-1] > 500
    assert not run.warnings


def test_derivatives() -> None:
    report = as_state().check_derivatives()
    assert report, report


def test_sensitivity_to_the_spin_inertia() -> None:
    def end(inertia: float) -> Any:
        return sr.simulate(as_state(spin_inertia=inertia), until=0.6, method=TIGHT, store="steps")

    run, h = end(J), 1e-4
    found = sr.sensitivity(run, "tyre.spin", wrt=["tyre.spin_inertia"])["tyre.spin_inertia"]
    wanted = (end(J + h)["tyre.spin"][-1] - end(J - h)["tyre.spin"][-1]) / (2 * h)
    assert found == pytest.approx(wanted, rel=1e-5)


def in_the_air(*parts: sr.model.Force) -> sr.System:
    """An axle that turns about y, with two wheels off the road."""
    axle = sr.Body("axle", mass=100.0, inertia=(20, 5.0, 20), position=(0, 0, 2.0))
    hinge = sr.Revolute("hinge", sr.ground, axle, point=(0, 0, 2.0), axis=(0, 1, 0))
    tyres = [
        sr.BrushTyre(name, axle.point(0, y, 0), spin_inertia=inertia, **BRUSH)
        for name, y, inertia in (("left", 0.7, 1.0), ("right", -0.7, 2.0))
    ]
    return sr.System(sr.Model("in the air", [axle], [hinge], [*tyres, *parts]))


def test_shafts_have_no_reaction_on_the_carrier() -> None:
    run = sr.simulate(in_the_air(sr.Differential("diff", "left", "right", 4.0, 30.0)), until=0.5)
    assert run["left.spin"][-1] == pytest.approx(60.0 / 1.0 * 0.5, rel=1e-7)
    assert run["right.spin"][-1] == pytest.approx(60.0 / 2.0 * 0.5, rel=1e-7)
    assert run["hinge.rate"][-1] == pytest.approx(0.0, abs=1e-9)
    assert run["diff.rate"][-1] == pytest.approx(4.0 * (30 + 15) / 2, rel=1e-7)
    assert [run[f"diff.{side}"][-1] for side in ("left", "right")] == pytest.approx([60.0, 60.0], rel=1e-12)


def test_motors_of_hubs_have_their_reaction_on_the_carrier() -> None:
    run = sr.simulate(in_the_air(sr.ElectricMotor("motor", "left", 1.0, 10.0, 1e6)), until=0.5, store="steps")
    assert run["left.spin"][-1] == pytest.approx(10.0 / 1.0 * 0.5, rel=1e-7)
    assert run["hinge.rate"][-1] == pytest.approx(-10.0 / 5.0 * 0.5, rel=1e-7)
    assert run["left.rate"][-1] == pytest.approx(5.0 + 1.0, rel=1e-7)
    balance = run.energy_balance()
    assert balance.supplied["motor"][-1] == pytest.approx(5.0**2 / 2 + 5.0 * 1.0**2 / 2, rel=1e-3)


@pytest.mark.parametrize("torque", [1e-4, 20.0])
def test_a_driven_wheel_in_the_air_does_not_wind_up(torque: float) -> None:
    """The deflection is at most that of sliding, and vanishes as the wheel stops."""
    parts = (sr.ElectricMotor("motor", "left", 1.0, torque, 1e6), sr.Brake("brake", "right", 1.0))
    run = sr.simulate(in_the_air(*parts), until=20.0, t_eval=np.linspace(0, 20, 41))
    assert run.success, run.message
    assert abs(run["left.deflection_x"]).max() < 2e-3
    assert abs(run["left.spin"][-1]) > 1e-3
    assert run["left.load"][-1] == 0.0


def test_a_model_file(tmp_path: Path) -> None:
    system = as_state()
    system.model.save(tmp_path / "wheel.yaml")
    again = sr.System(sr.load(tmp_path / "wheel.yaml"))
    first, second = (sr.simulate(one, until=0.1)["tyre.spin"][-1] for one in (system, again))
    assert first == pytest.approx(second, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"spin_inertia": 0.0}, "spin_inertia must be greater than 0"),
        ({"initial_spin": 3.0}, "initial_spin needs a spin that is a state"),
    ],
)
def test_wrong_spins(given: dict[str, float], message: str) -> None:
    body = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1), position=(0, 0, 0.3))
    with pytest.raises(sr.ModelError, match=message):
        sr.System(
            sr.Model("wrong", [body], [], [sr.BrushTyre("tyre", body.point(0, 0, 0), **BRUSH, **given)])
        )


def test_mirrored_sides() -> None:
    """A mirror image runs alike: the spin is positive forwards on both sides."""
    hub = sr.Body("hub", mass=300.0, inertia=(30, 30, 30), position=(0, 0.7, 0.295), velocity=(10, 0, 0))
    steer = np.array([-0.05, 1.0, 0.03])
    tyre = sr.BrushTyre("tyre", hub.point(0, 0.1, 0), axis=steer, spin_inertia=J, initial_spin=40.0, **BRUSH)
    parts = sr.both_sides(hub, tyre, sr.Brake("brake", "tyre", 50.0))
    bodies = [one for one in parts if isinstance(one, sr.Body)]
    forces = [one for one in parts if not isinstance(one, sr.Body)]
    run = sr.simulate(sr.System(sr.Model("sides", bodies, [], forces, gravity=(0, 0, -G))), until=0.2)
    assert run["tyre_left.spin"] == pytest.approx(run["tyre_right.spin"], rel=1e-9)
    assert run["tyre_left.lateral_force"] == pytest.approx(
        -run["tyre_right.lateral_force"], rel=1e-7, abs=1e-6
    )
    assert run["tyre_left.spin"][-1] < 39.0
    assert run["hub_left.y"] - 0.7 == pytest.approx(-0.7 - run["hub_right.y"], abs=1e-9)


def test_a_tyre_of_a_wheel_that_is_a_body_is_no_shaft() -> None:
    of = as_body().model
    brake = sr.Brake("late", "tyre", 100)
    with pytest.raises(sr.ModelError, match='joint is the tyre "tyre", whose spin is no state'):
        sr.System(of.adding(brake))
