"""Forces of drivers and joints against Newton and Euler, in global and in joint axes."""

from dataclasses import replace

import numpy as np
import pytest
from tests.analyses.driven import MASS, G, J, L, parallelogram, pendulum, turned
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly

RATE, GROWTH = 1.5, -0.8


@pytest.fixture(scope="module")
def swung() -> sr.Trajectory:
    system = pendulum(f"0.3 + {RATE}*t + {GROWTH / 2}*t**2")
    return sr.kinematics(system, np.linspace(0.0, 2.0, 21))


def angle(t: np.ndarray) -> np.ndarray:
    return 0.3 + RATE * t + GROWTH * t * t / 2


def test_torque_of_the_driver(swung: sr.Trajectory) -> None:
    motor = swung.reaction("motor_0")
    want = (J + MASS * L**2) * GROWTH + MASS * G * L * np.sin(angle(swung.t))
    assert np.allclose(motor.torque[:, 2], want, atol=1e-11)
    assert np.allclose(motor.force, 0.0, atol=1e-11)


def test_force_of_the_pin(swung: sr.Trajectory) -> None:
    """The pin carries the weight and the acceleration of the centre of mass, and no torque about its axis."""
    th, w = angle(swung.t), RATE + GROWTH * swung.t
    radial, tangential = np.array([np.sin(th), -np.cos(th)]), np.array([np.cos(th), np.sin(th)])
    a = L * (GROWTH * tangential - w * w * radial)
    pin = swung.reaction("pin")
    assert np.allclose(pin.force[:, :2], MASS * (a.T + [0, G]), atol=1e-11)
    assert np.allclose(pin.torque, 0.0, atol=1e-11)
    assert np.allclose(pin.point, 0.0, atol=1e-12)


def test_power_of_the_driver_is_the_change_of_energy() -> None:
    """T + V changes by what the motor gives and the damper takes: integrated over time by Gauss-Legendre."""
    system = turned(3.0, 0.5)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    t = np.concatenate([[0.0], 1 + nodes, [2.0]])
    run = sr.kinematics(system, t)
    motor, spring = run.reaction("motor"), run.reaction("guide")
    slider = run["slider"]
    power = motor.torque[:, 0] * (3.0 + 0.5 * t) - slider.velocity[:, 0] ** 2  # c = 1 N s/m
    energy = [
        system.kinetic_energy(q, v) + 9.81 * (q[2] + q[9] + q[16]) + 5 * (np.linalg.norm(q[14:17]) - 5) ** 2
        for q, v in zip(run.q, run.v, strict=True)
    ]
    assert weights @ power[1:-1] == pytest.approx(energy[-1] - energy[0], rel=1e-10)
    assert np.allclose(spring.joint_force[:, 2], 0.0, atol=1e-10)  # a slide bears nothing along its axis


def test_reactions_balance_every_body() -> None:
    """Forces and torques of all joints on the rod and its weight give it its acceleration."""
    run = sr.simulate(slider_crank(), until=1.0, t_eval=[0.3, 1.0], method=sr.ODE(rtol=1e-8, atol=1e-10))
    ball, cross, rod = run.reaction("ball"), run.reaction("cross"), run["rod"]
    force = ball.force - cross.force  # the rod is body j of the ball, body i of the cross
    assert np.allclose(run.a[:, 7:10], force + [0, 0, -9.81], atol=1e-9)
    torque = ball.torque - cross.torque
    torque += np.cross(ball.point - rod.position, ball.force)
    torque -= np.cross(cross.point - rod.position, cross.force)
    assert np.allclose(torque, spin_change(run, rod.name), atol=1e-9)


def spin_change(run: sr.Trajectory, body: str) -> np.ndarray:
    """dω/dt = 2 E p̈ in global axes; the rod's inertia is 1 about any axis, so this is its torque too."""
    at = 7 * run.bodies.index(body)
    p, a = run.q[:, at + 3 : at + 7], run.a[:, at + 3 : at + 7]
    e0, e = p[:, :1], p[:, 1:]
    return 2 * (-a[:, :1] * e + np.cross(e, a[:, 1:]) + e0 * a[:, 1:])


def test_a_joint_on_the_ground_as_second_body() -> None:
    pair = []
    for bodies in ("bob first", "ground first"):
        bob = sr.Body(
            "bob", mass=2.0, inertia=(1, 2, 3), position=(0.4, -0.2, 0.1), angular_velocity=(0, 0, 2)
        )
        two = (bob, sr.ground) if bodies == "bob first" else (sr.ground, bob)
        pin = sr.Revolute("pin", *two, point=(0, 0, 0), axis=(0, 0, 1))
        system = sr.System(sr.Model("pendulum", [bob], [pin], gravity=(0, -9.81, 0)))
        pair.append(
            sr.simulate(
                system,
                sr.assemble(system, v=system.v0),
                until=0.2,
                t_eval=[0.2],
                method=sr.ODE(rtol=1e-8, atol=1e-10),
            ).reaction("pin")
        )
    assert np.allclose(pair[0].force, -pair[1].force, atol=1e-9)
    assert np.allclose(pair[0].torque, -pair[1].torque, atol=1e-9)
    assert np.linalg.norm(pair[0].torque) > 0.1


def test_reactions_of_a_distance_and_a_vehicle_at_rest() -> None:
    """A tie rod pulls along itself; at rest the joints of each front knuckle bear wheel load less weight."""
    system, found = hmmwv(), sr.equilibrium(hmmwv())
    tie = system.reaction("tierod_front_right", found.q, found.lam)
    rack, knuckle = system.marker("tierod_front_right")[:2]
    assert (rack, knuckle) == ("steering_rack", "knuckle_front_right")
    arms = [
        system.reaction(name, found.q, found.lam) for name in ("sph_UCA_front_right", "sph_LCA_front_right")
    ]
    vertical = tie.force[2] + sum(arm.force[2] for arm in arms)
    assert vertical == pytest.approx(90.555 * 9.81 - 6533.331218, abs=1e-5)
    assert np.allclose([arm.torque for arm in arms], 0.0, atol=1e-8)
    assert np.allclose(tie.torque, 0.0, atol=1e-8)


def test_redundant_joints_share_as_little_as_possible() -> None:
    """A planar linkage hinged four times in space: nothing presses out of its plane."""
    run = sr.kinematics(parallelogram(), np.linspace(0.0, 1.0, 5))
    for joint in "ABCD":
        assert np.allclose(run.reaction(joint).force[:, 2], 0.0, atol=1e-10)
    assert sr.inverse_dynamics(run.system, run).success


def test_a_motion_that_needs_more_forces() -> None:
    run = sr.kinematics(turned(3.0, 0.5), [0.0, 0.5])
    free = sr.inverse_dynamics(slider_crank(), run)
    assert not free.success
    assert free.status == "not balanced"
    assert "is missing. Add a driver or a force" in free.message
    again = sr.inverse_dynamics(run.system, replace(run, lam=0 * run.lam))
    assert again.success
    assert np.allclose(again.lam, run.lam)
    with pytest.raises(ValueError, match="has other bodies than HMMWV"):
        sr.inverse_dynamics(hmmwv(), run)


def test_unknown_joints(swung: sr.Trajectory) -> None:
    with pytest.raises(KeyError, match='no joint "pim"'):
        swung.reaction("pim")
    with pytest.raises(ValueError, match="does not know its system"):
        replace(swung, system=None).reaction("pin")
