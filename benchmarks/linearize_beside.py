"""Derivatives of forward dynamics beside Pinocchio and MuJoCo: a Panda, and stacked hexapods with closed loops.

    python -m benchmarks.linearize_beside

Least processor time of a call from Python in several batches. Sarrus: A and B in independent coordinates. Pinocchio:
derivatives of ABA, and of constrained dynamics with the loops closed by points. MuJoCo: the matrices of a step by
differences. Needs the packages pin and mujoco. Accelerations of the programs are compared first.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from benchmarks.linearize import least

import sarrus as sr

PANDA = Path(__file__).parents[1] / "tests/io/data/panda.urdf"
BASE, TOP, HEIGHT, G = 0.5, 0.3, 0.6, 9.81  # [m] radii of the joints and distance of the platforms; [m/s²]
# Mass and inertia of half a leg, of a platform
LEG, PLATE = (0.4, (0.004, 0.004, 0.0002)), (5.0, (0.2, 0.2, 0.4))


def ends(leg: int, level: int) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper end of a leg."""
    low, high = np.radians((60 * leg + 10 * (-1) ** leg, 60 * leg - 25 * (-1) ** leg))
    return (
        np.array([BASE * np.cos(low), BASE * np.sin(low), level * HEIGHT]),
        np.array([TOP * np.cos(high), TOP * np.sin(high), (level + 1) * HEIGHT]),
    )


def axes(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """A rotation whose z axis is along a leg."""
    z = (high - low) / np.linalg.norm(high - low)
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def hexapods(levels: int) -> sr.System:
    """Platforms on six legs each, one on the other: universal, prismatic and spherical joints."""
    bodies, joints, below = list[Any](), list[Any](), sr.ground
    for level in range(levels):
        plate = sr.Body(f"plate{level}", PLATE[0], PLATE[1], position=(0, 0, (level + 1) * HEIGHT))
        for leg in range(6):
            low, high = ends(leg, level)
            R, name = axes(low, high), f"{level}_{leg}"
            lower, upper = (
                sr.Body(f"{part}{name}", *LEG, position=low + by * (high - low), orientation=R)
                for part, by in (("lower", 0.25), ("upper", 0.75))
            )
            hook = sr.Universal(f"hook{name}", below, lower, point=low, axis_i=R[:, 0], axis_j=R[:, 1])
            slide = sr.Prismatic(f"slide{name}", lower, upper, point=low, axis=R[:, 2])
            joints += [hook, slide, sr.Spherical(f"ball{name}", upper, plate, point=high)]
            bodies += [lower, upper]
        bodies.append(plate)
        below = plate
    return sr.System(sr.Model("hexapods", bodies, joints, gravity=(0, 0, -G)))


def hexapods_of_pinocchio(levels: int) -> tuple[Any, list[Any]]:
    """The same as a tree with the platforms free, and points that close the loops."""
    model, ends_of, plates = pin.Model(), list[Any](), [0]
    model.gravity.linear = np.array([0, 0, -G])
    for level in range(levels):  # joints in the order of depth first, as Pinocchio needs them
        tips = [(leg, *leg_of_pinocchio(model, plates[-1], level, leg)) for leg in range(6)]
        place = pin.SE3(np.eye(3), np.array([0, 0, (level + 1) * HEIGHT]))
        plates.append(model.addJoint(0, pin.JointModelFreeFlyer(), place, f"plate{level}"))
        own = pin.Inertia(PLATE[0], np.zeros(3), np.diag(PLATE[1]))
        model.appendBodyToJoint(plates[-1], own, pin.SE3.Identity())
        for leg, joint, tip in tips:
            there = ends(leg, level)[1] - [0, 0, (level + 1) * HEIGHT]
            ends_of.append((joint, tip, plates[-1], pin.SE3(np.eye(3), there)))
    kind = pin.ContactType.CONTACT_3D
    return model, [pin.RigidConstraintModel(kind, model, *one, pin.ReferenceFrame.LOCAL) for one in ends_of]


def leg_of_pinocchio(model: Any, below: int, level: int, leg: int) -> tuple[int, Any]:
    """Add a leg to a platform; its last joint, and the place of its tip there."""
    low, high = ends(leg, level)
    length, none = float(np.linalg.norm(high - low)), pin.SE3.Identity()
    at = pin.SE3(axes(low, high), low - [0, 0, level * HEIGHT])
    first = model.addJoint(below, pin.JointModelRX(), at, f"x{level}_{leg}")
    second = model.addJoint(first, pin.JointModelRY(), none, f"y{level}_{leg}")
    third = model.addJoint(second, pin.JointModelPZ(), none, f"slide{level}_{leg}")
    for joint, part in ((second, 0.25), (third, 0.75)):
        own = pin.Inertia(LEG[0], np.array([0, 0, part * length]), np.diag(LEG[1]))
        model.appendBodyToJoint(joint, own, none)
    return third, pin.SE3(np.eye(3), np.array([0, 0, length]))


def of_mujoco(system: sr.System) -> Callable[[], object]:
    """The differences of MuJoCo over a step, of the exported model."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "model.xml"
        sr.export(system.model, file)
        model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER  # RK4 is refused
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    size = 2 * model.nv + model.na
    A, B = np.zeros((size, size)), np.zeros((size, model.nu)) if model.nu else None
    return lambda: mujoco.mjd_transitionFD(model, data, 1e-6, False, A, B, None, None)


def of_sarrus(system: sr.System, names: list[str]) -> Callable[[], object]:
    """A and B in motion, in the coordinates named."""
    start = sr.assemble(system, rates=dict.fromkeys(names, 0.1))
    function, q, v = system.forward_dynamics.in_coordinates(names), start.q.copy(), start.v.copy()
    return lambda: function(q, v)


def report(
    title: str, ours: Callable[[], object], other: Callable[[], object], step: Callable[[], object]
) -> None:
    """One line of the table."""
    times = [least(one) for one in (ours, other, step)]
    print(
        f"{title}: Sarrus {times[0]:.0f} µs, Pinocchio {times[1]:.1f} µs, MuJoCo {times[2]:.0f} µs",
        flush=True,
    )


def panda() -> None:
    """A tree of nine joints."""
    system = sr.System(sr.load_urdf(PANDA, mimic="free", ignore=["dynamics"], meshes="ignore"))
    model = pin.buildModelFromUrdf(str(PANDA))
    data, names = model.createData(), list(system.joint_coordinates.names)
    q, v, tau = pin.neutral(model), 0.1 * np.ones(model.nv), np.zeros(model.nv)
    a = pin.aba(model, data, q, 0 * v, tau)
    same = sr.linearize(
        system, sr.assemble(system), coordinates=names, outputs=[f"{n}.acceleration" for n in names]
    )
    order = [model.names.tolist().index(name.partition(".")[0]) - 1 for name in names]
    assert np.allclose(same.y0, a[order], atol=1e-8)
    pin.computeABADerivatives(model, data, q, 0 * v, tau)
    assert np.allclose(same.A[len(names) :, : len(names)], data.ddq_dq[np.ix_(order, order)], atol=1e-6)
    ours = of_sarrus(system, names)
    report("Panda", ours, lambda: pin.computeABADerivatives(model, data, q, v, tau), of_mujoco(system))


def loops(levels: int) -> None:
    """Closed loops: six for each platform."""
    system, (model, closed) = hexapods(levels), hexapods_of_pinocchio(levels)
    data, every = model.createData(), [one.createData() for one in closed]
    q, v, tau = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    settings = pin.ProximalSettings(1e-12, 0.0, 1)
    pin.initConstraintDynamics(model, data, closed, every)
    names = [f"slide{level}_{leg}.displacement" for level in range(levels) for leg in range(6)]

    def other() -> None:
        pin.constraintDynamics(model, data, q, v, tau, closed, every, settings)
        pin.computeConstraintDynamicsDerivatives(model, data, closed, every, settings)

    other()
    places = [model.idx_vs[model.getJointId(name.partition(".")[0])] for name in names]
    outputs = [f"{name.partition('.')[0]}.displacement.acceleration" for name in names]
    same = sr.linearize(system, sr.assemble(system), coordinates=names, outputs=outputs)
    assert np.allclose(same.y0, data.ddq[places], atol=1e-6)
    title = f"{levels} hexapods, {6 * levels} degrees of freedom, {18 * levels} loop equations, {system.nq} coordinates"
    report(title, of_sarrus(system, names), other, of_mujoco(system))


def main() -> None:
    """The table of the documentation."""
    panda()
    for levels in (1, 2, 4, 8):
        loops(levels)


if __name__ == "__main__":
    main()
