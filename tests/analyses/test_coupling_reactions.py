"""Reactions of gears, racks and couplers on the second body of the joint that follows; closed forms."""

import numpy as np
import pytest
from tests.outputs.every_kind import system as every_kind

import sarrus as sr
from sarrus.euler import A, E

PRECISE = {"method": sr.Radau(rtol=1e-10, atol=1e-12), "store": "steps"}
X, Z = (1, 0, 0), (0, 0, 1)


def wheel(name: str, inertia: float, position: tuple[float, ...] = (0, 0, 0), mass: float = 1.0) -> sr.Body:
    return sr.Body(name, mass, (inertia, inertia, inertia), position=position)


def run_of(bodies: list[sr.Body], joints: list[object], torque: sr.Torque) -> sr.Trajectory:
    run = sr.simulate(sr.System(sr.Model("coupled", bodies, joints, [torque])), until=0.5, **PRECISE)
    assert run.success
    return run


def agrees(run: sr.Trajectory, joint: str, force: object, torque: object) -> None:
    """The reported reaction, and the responses of the same name."""
    found = run.reaction(joint)
    assert found.force[-1] == pytest.approx(force, abs=1e-7)
    assert found.torque[-1] == pytest.approx(torque, abs=1e-7)
    names = [f"{joint}.{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"]
    values = sr.sensitivity(run, [sr.Final(name) for name in names]).values
    assert values == pytest.approx(np.concatenate([found.force[-1], found.torque[-1]]), abs=1e-7)


@pytest.mark.slow
def test_a_gear_turns_the_wheel_of_its_second_joint() -> None:
    a, b = wheel("a", 1.0), wheel("b", 1.0, (0, 1, 0))
    joints = [
        sr.Revolute("A", sr.ground, a, point=(0, 0, 0), axis=X),
        sr.Revolute("B", sr.ground, b, point=(0, 1, 0), axis=X),
        sr.Gear("gear", "A", "B", ratio=-2),
    ]
    run = run_of([a, b], joints, sr.Torque("T", a, (10, 0, 0)))
    agrees(run, "gear", (0, 0, 0), (-4, 0, 0))  # (1 + 2²) α = 10, b turns with -2 α
    assert run.reaction("gear").joint_torque[-1] == pytest.approx((0, 0, -4), abs=1e-7)
    assert run.reaction("gear").point[-1] == pytest.approx((0, 1, 0), abs=1e-9)
    for bearing in ("A", "B"):
        agrees(run, bearing, (0, 0, 0), (0, 0, 0))  # an ideal coupling of angles: no tooth forces


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", ["rack", "coupler of the displacement", "coupler of the angle"])
def test_a_rack_is_pushed_and_a_pinion_turned(kind: str) -> None:
    pinion, rack = wheel("pinion", 1.0), wheel("rack", 1.0, (0, 0.5, 0), mass=2.0)
    couplings = {
        "rack": sr.RackAndPinion("mesh", "K", "P", radius=0.5),
        "coupler of the displacement": sr.Coupler("mesh", "P", "K", ratio=0.5),
        "coupler of the angle": sr.Coupler("mesh", "K", "P", ratio=2.0),
    }
    joints = [
        sr.Revolute("P", sr.ground, pinion, point=(0, 0, 0), axis=Z),
        sr.Translational("K", sr.ground, rack, point=(0, 0.5, 0), axis=X),
        couplings[kind],
    ]
    run = run_of([pinion, rack], joints, sr.Torque("T", pinion, (0, 0, 3.0)))
    if kind == "coupler of the angle":  # (1 + 2 · 0.5²) α = 3
        agrees(run, "mesh", (0, 0, 0), (0, 0, -1))
    else:
        agrees(run, "mesh", (2, 0, 0), (0, 0, 0))
    agrees(run, "P", (0, 0, 0), (0, 0, 0))


@pytest.mark.slow
def test_a_body_of_both_joints_feels_the_coupling_through_both() -> None:
    """A planet on a carrier, whose angle follows the planet's against it: the carrier is a body of both joints."""
    carrier, planet, ratio, torque = wheel("carrier", 2.0), wheel("planet", 0.3, (1, 0, 0)), 0.25, 1.5
    joints = [
        sr.Revolute("arm", sr.ground, carrier, point=(0, 0, 0), axis=Z),
        sr.Revolute("pin", carrier, planet, point=(1, 0, 0), axis=Z),
        sr.Gear("mesh", "pin", "arm", ratio=ratio),
    ]
    run = run_of([carrier, planet], joints, sr.Torque("T", planet, (0, 0, torque)))
    phi = (
        torque * (1 + ratio) / ((2.0 + 1.0) * ratio**2 + 0.3 * (1 + ratio) ** 2)
    )  # of the planet in the carrier
    on_planet = 0.3 * (1 + ratio) * phi - torque
    assert run["mesh.torque_on.planet.z"][-1] == pytest.approx(on_planet, abs=1e-7)
    through_arm = -on_planet / ratio
    assert through_arm == pytest.approx(3.0 * ratio * phi + on_planet)
    agrees(run, "mesh", (0, 0, 0), (0, 0, through_arm - on_planet))


@pytest.mark.slow
def test_where_the_second_body_is_the_ground_it_is_what_the_ground_feels() -> None:
    a, b = wheel("a", 1.0), wheel("b", 1.0, (0, 1, 0))
    joints = [
        sr.Revolute("A", sr.ground, a, point=(0, 0, 0), axis=X),
        sr.Revolute("B", b, sr.ground, point=(0, 1, 0), axis=X),
        sr.Gear("gear", "A", "B", ratio=2),
    ]
    run = run_of([a, b], joints, sr.Torque("T", a, (10, 0, 0)))
    agrees(run, "gear", (0, 0, 0), (4 + 2 * 4, 0, 0))  # against b, and against a


@pytest.mark.slow
def test_its_derivative_is_that_of_the_reported_value() -> None:
    def run(mass: float) -> sr.Trajectory:
        pinion, rack = wheel("pinion", 1.0), wheel("rack", 1.0, (0, 0.5, 0), mass=mass)
        joints = [
            sr.Revolute("P", sr.ground, pinion, point=(0, 0, 0), axis=Z),
            sr.Translational("K", sr.ground, rack, point=(0, 0.5, 0), axis=X),
            sr.Coupler("mesh", "K", "P", ratio=2.0),
        ]
        return run_of([pinion, rack], joints, sr.Torque("T", pinion, (0, 0, 3.0)))

    found = sr.sensitivity(run(2.0), "mesh.torque.z", ["rack.mass"])["rack.mass"]
    ends = [run(2.0 + d).reaction("mesh").torque[-1, 2] for d in (1e-3, -1e-3)]
    assert found == pytest.approx((ends[0] - ends[1]) / 2e-3, rel=1e-6)


def on_body(run: sr.Trajectory, part: str, body: str) -> np.ndarray:
    """Force, and torque about the origin of a body, of a joint, coupling or driver at the end."""
    m = run.system.marker(part)
    if m.coupled:
        return np.concatenate([run[f"{part}.force_on.{body}"][-1], run[f"{part}.torque_on.{body}"][-1]])
    found = np.zeros(6)
    for side, own, s in (("_i", m.body_i, m.s_i), ("", m.body_j, m.s_j)):
        if own == body:
            force, torque = (run[f"{part}.{word}{side}"][-1] for word in ("force", "torque"))
            arm = A(run.q[-1][run.system.coordinates_of(body)][3:]) @ s
            found += np.concatenate([force, torque + np.cross(arm, force)])
    return found


@pytest.mark.filterwarnings("ignore")
def test_reactions_of_all_parts_add_up_to_what_moves_each_body() -> None:
    """Of all joints, couplings and drivers: M a - Q - S of each body, as force and torque about its origin."""
    system = every_kind()
    run = sr.simulate(system, until=2e-3)
    assert run.success, run.message
    t, q, v, a = run.t[-1], run.q[-1], run.v[-1], run.a[-1]
    missing = system.M_a(q, a) - system.Q(q, v, t) - system.S(q, v)
    for body in system.bodies:
        at = system.coordinates_of(body)
        wanted = np.concatenate([missing[at][:3], 0.5 * E(q[at][3:]) @ missing[at][3:]])
        parts = [name for name in system.rows if body in bodies_of(system, name)]
        found = sum((on_body(run, part, body) for part in parts), np.zeros(6))
        assert found == pytest.approx(wanted, abs=1e-6 * max(abs(missing[at]).max(), 1.0)), (body, parts)


def bodies_of(system: sr.System, part: str) -> set[str]:
    """The bodies that the equations of a part depend on."""
    J = abs(system.Phi_q(system.q0).toarray()[system.rows[part]]).max(axis=0)
    return {body for body in system.bodies if J[system.coordinates_of(body)].any()}


def test_a_bead_on_a_rail() -> None:
    """The rail's force on the bead is its mass times the acceleration and the weight, across the rail."""
    bead = sr.Body("bead", 1.5, (0.01, 0.01, 0.01), (0.3, 0.4 * np.cos(0.6), 0))
    joints = [
        sr.Cartesian("guide", sr.ground, bead, point=(0, 0, 0), axis=Z),
        sr.FormulaCoupler(
            "rail", "guide.displacement_y", value="0.4*cos(2*guide.displacement_x + 0.6) - 0.4*cos(0.6)"
        ),
        sr.FormulaCoupler("flat", "guide.displacement_z", value="0*guide.displacement_x"),
    ]
    system = sr.System(sr.Model("rail", [bead], joints, gravity=(0, -9.81, 0)))
    run = sr.simulate(system, until=0.2, **PRECISE)
    x, a = run["bead.x"][-1], run["bead.acceleration"][-1]
    force = run["rail.force"][-1]
    assert force == pytest.approx(1.5 * (a + [0, 9.81, 0]), abs=1e-7)
    assert force[0] == pytest.approx(0.8 * np.sin(2 * x) * force[1], abs=1e-7)
    assert abs(force[0]) > 1.0
    assert run.reaction("rail").force[-1] == pytest.approx(force)
