"""Joints that follow another are coupled: by hand, on a real gripper, and against Pinocchio."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.algebra import Array

PANDA = Path(__file__).parent / "data" / "panda.urdf"
G, L, MASS, J = 9.81, 0.5, 2.0, 0.1
CLOSE = 1e-8  # simulated with a tolerance of 1e-10

LINK = (
    '<link name="{name}"><inertial><origin xyz="0 0 0.5"/><mass value="2"/>'
    '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
JOINT = (
    '<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="{at}"/><axis xyz="{axis}"/>{more}<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
)


def joint(name: str, kind: str, parent: str, child: str, axis: str, at: str = "0 0 0", more: str = "") -> str:
    return JOINT.format(name=name, kind=kind, parent=parent, child=child, at=at, axis=axis, more=more)


def written(folder: Path, *parts: str) -> Path:
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r"><link name="base"/>{"".join(parts)}</robot>')
    return path


def two_rods(folder: Path, more: str, kind: str = "revolute") -> Path:
    """Two links that stand on the base, the second following the first."""
    links = LINK.format(name="one"), LINK.format(name="two")
    first = joint("a", "revolute", "base", "one", "0 1 0")
    return written(folder, *links, first, joint("b", kind, "base", "two", "0 1 0", "1 0 0", more))


def motion(robot: sr.Robot, until: float = 0.5) -> sr.Trajectory:
    times = np.linspace(0, until, 6)
    run = sr.simulate(
        sr.System(robot), until=until, t_eval=times, method=sr.ODE("DOP853", rtol=1e-10, atol=1e-12)
    )
    assert run.success, run.message
    return run


def test_a_turn_follows_a_turn(tmp_path: Path) -> None:
    """(I + m² I) θ̈ = torque(θ) + m torque(m θ + o), torque(θ) = mass g l sin θ of a link that stands upright."""
    path = two_rods(tmp_path, '<mimic joint="a" multiplier="-2" offset="0.3"/>')
    robot = sr.load_urdf(path, q0={"a": 0.4})
    assert sr.mobility(sr.System(robot)).degrees_of_freedom == 1
    run = motion(robot)
    one, two = run.joint("a").angle, run.joint("b").angle
    assert one[0] == pytest.approx(0.4)
    assert abs(two - (-2 * one + 0.3)).max() < CLOSE
    torque = MASS * G * L * (np.sin(0.4) - 2 * np.sin(-0.5))
    inertia = (1 + 4) * (J + MASS * L**2)
    found = run.system.joint("a")["angle"].acceleration(run.q[0], run.v[0], run.a[0])
    assert found == pytest.approx(torque / inertia, rel=1e-9)


def test_a_slide_follows_a_turn(tmp_path: Path) -> None:
    path = two_rods(tmp_path, '<mimic joint="a" multiplier="0.05"/>', "prismatic")
    run = motion(sr.load_urdf(path, q0={"a": 0.4}))
    assert abs(run["two"].position[:, 1] - 0.05 * run.joint("a").angle).max() < CLOSE
    assert run.joint("a").angle[-1] > 0.5


@pytest.mark.parametrize("sign", [1, -1])
def test_two_motions_of_one_body_make_a_screw(sign: int, tmp_path: Path) -> None:
    """A turn and, through a link without mass, a slide along or against the same axis, which follows it."""
    turn = joint("turn", "continuous", "base", "between", "0 0 1")
    follows = '<mimic joint="turn" multiplier="0.1" offset="0.2"/>'
    slide = joint("slide", "prismatic", "between", "nut", f"0 0 {sign}", more=follows)
    robot = sr.load_urdf(written(tmp_path, '<link name="between"/>', LINK.format(name="nut"), turn, slide))
    assert sr.mobility(sr.System(robot)).degrees_of_freedom == 1
    run = motion(robot)
    angle, height = run.joint("slide").angle, run["nut"].position[:, 2]
    assert abs(height - sign * (0.1 * angle + 0.2)).max() < CLOSE
    assert run.a[0, 2] == pytest.approx(-G * MASS / (MASS + J / 0.1**2))


def test_what_follows_a_joint_that_stands_stands_too(tmp_path: Path) -> None:
    path = two_rods(tmp_path, '<mimic joint="a" multiplier="2"/>')
    with pytest.raises(sr.ModelError, match="nothing in it moves"):
        sr.load_urdf(path, lock=["a"])
    still = sr.load_urdf(two_rods(tmp_path, '<mimic joint="a" multiplier="0" offset="0.3"/>'))
    assert [body.name for body in still.bodies] == ["one"]
    assert still.link("two").place.p == pytest.approx([np.cos(0.15), 0, np.sin(0.15), 0])


def test_a_joint_follows_one_of_two_crossed_hinges(tmp_path: Path) -> None:
    """A massless frame between the hinges makes the first one a joint with an angle."""
    links = '<link name="between"/>', LINK.format(name="one"), LINK.format(name="two")
    hook = (
        joint("x", "continuous", "base", "between", "1 0 0"),
        joint("y", "continuous", "between", "one", "0 1 0"),
    )
    other = joint("b", "continuous", "base", "two", "0 1 0", more='<mimic joint="x"/>')
    run = motion(sr.load_urdf(written(tmp_path, *links, *hook, other), q0={"x": 0.3, "y": 0.2}))
    assert run.joint("x").angle[0] == pytest.approx(0.3)
    assert abs(run.joint("b").angle - run.joint("x").angle).max() < CLOSE


def test_fingers_of_a_real_gripper_move_together() -> None:
    robot = sr.load_urdf(PANDA, q0={"panda_joint4": -1.5, "panda_finger_joint1": 0.02})
    assert [part.name for part in robot.joints if isinstance(part, sr.Coupler)] == [
        "panda_finger_joint2_mimic"
    ]
    system = sr.System(robot)
    found = sr.mobility(system)
    assert (found.degrees_of_freedom, found.redundant) == (8, 0)
    start = sr.assemble(system)
    assert abs(start.q - system.q0).max() < 1e-13
    pushed = sr.assemble(system, rates={"panda_finger_joint1": 0.1})
    fingers = [system.joint(f"panda_finger_joint{n}")["displacement"] for n in (1, 2)]
    assert [finger.value(pushed.q) for finger in fingers] == pytest.approx([0.02, 0.02])
    assert [finger.rate(pushed.q, pushed.v) for finger in fingers] == pytest.approx([0.1, 0.1])


def folded(names: list[str], mimics: dict[str, tuple[str, float, float]]) -> tuple[list[str], Array]:
    """The joints that follow none, and the matrix that gives all rates from theirs."""
    free = [name for name in names if name not in mimics]
    table = np.zeros((len(names), len(free)))
    for row, name in enumerate(names):
        leader, multiplier, _ = mimics.get(name, (name, 1.0, 0.0))
        table[row, free.index(leader)] = multiplier
    return free, table


@pytest.mark.needs("pinocchio")
def test_accelerations_agree_with_pinocchio() -> None:
    """Gᵀ M G a = -Gᵀ h with Pinocchio's mass matrix M and weights h of the whole tree, from rest."""
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromUrdf(str(PANDA))
    data, names = model.createData(), [str(name) for name in model.names][1:]
    mimics = {"panda_finger_joint2": ("panda_finger_joint1", 1.0, 0.0)}
    free, table = folded(names, mimics)
    rng = np.random.default_rng(4)
    for _ in range(10):
        angles = table @ rng.uniform(-1, 1, len(free))
        run = _at_rest(dict(zip(names, angles)))
        upper = np.triu(pin.crba(model, data, angles))
        M = upper + np.triu(upper, 1).T
        h = pin.rnea(model, data, angles, np.zeros(model.nv), np.zeros(model.nv))
        wanted = table @ np.linalg.solve(table.T @ M @ table, -table.T @ h)
        kinds = ["displacement" if "finger" in name else "angle" for name in names]
        found = [
            run.system.joint(name)[kind].acceleration(run.q[0], run.v[0], run.a[0])
            for name, kind in zip(names, kinds)
        ]
        assert found == pytest.approx(wanted, rel=1e-8, abs=1e-8)


def _at_rest(q0: dict[str, float]) -> sr.Trajectory:
    return sr.simulate(
        sr.System(sr.load_urdf(PANDA, q0=q0)), until=1e-6, t_eval=[0.0], method=sr.ODE("DOP853")
    )
