"""Masses, poses, mass matrices and accelerations of an imported model beside those that MuJoCo computes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.sparse import bmat
from scipy.sparse.linalg import splu
from tests.io.poses import link_poses, pose_difference

import sarrus as sr
from sarrus.euler import E
from sarrus.io.mjcf.compiled import name_of

mujoco = pytest.importorskip("mujoco")

EXACT = 1e-10  # rounding of two programs
IGNORED = ("fluid", "limits", "contacts")
LARGE = 1000  # equations: more are solved by sparse factors
REFINED, ROUND = 2, 1e-13  # rounds of refinement, and the residual, relative to the terms
WIDTHS = {0: (7, 6), 1: (4, 3), 2: (1, 1), 3: (1, 1)}


def compare(path: Path, poses: int = 10) -> None:
    """Compare masses, poses of all bodies and mass matrices in random configurations."""
    robot = sr.load_mjcf(path, mimic="free", inertia="given", ignore=IGNORED)
    space, model = sr.JointSpace(sr.System(robot)), mujoco.MjModel.from_xml_path(str(path))
    rng, moving = np.random.default_rng(3), model.body_weldid != 0
    assert sum(body.mass for body in robot.bodies) == pytest.approx(model.body_mass[moving].sum(), rel=1e-14)
    for _ in range(poses):
        theta, qpos, order = random_configuration(space, model, rng)
        data = at(model, qpos)
        found = link_poses(robot, space, theta)
        for k in range(1, model.nbody):
            link = found[model.body(k).name or f"body{k}"]
            assert pose_difference(link, data.xpos[k], data.xmat[k].reshape(3, 3)) < EXACT
        M = mass_matrix(model, data)
        np.testing.assert_allclose(space.M(theta)[np.ix_(order, order)], M, rtol=0, atol=EXACT * abs(M).max())


def random_configuration(
    space: sr.JointSpace, model: Any, rng: np.random.Generator
) -> tuple[Any, Any, list[int]]:
    theta, qpos, order = space.zero(), model.qpos0.copy(), [0] * model.nv
    for k in range(model.njnt):
        width, freedoms = WIDTHS[int(model.jnt_type[k])]
        # half a revolution at most: beyond, only a motion says how often a spring of Sarrus is wound
        value, first = rng.normal(size=width).clip(-3, 3), model.jnt_qposadr[k]
        value[-4:] /= np.linalg.norm(value[-4:]) if width >= 4 else 1
        name = name_of(model, "joint", k)
        theta[space.coordinates_of[name]] = value
        qpos[first : first + width] = value + (model.qpos0[first] if width == 1 else 0)
        start = space.velocities_of[name].start
        order[model.jnt_dofadr[k] : model.jnt_dofadr[k] + freedoms] = range(start, start + freedoms)
    return theta, qpos, order


def at(model: Any, qpos: Any) -> Any:
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    return data


def mass_matrix(model: Any, data: Any) -> Any:
    """MuJoCo's, with the armature of its joints."""
    M = np.zeros((model.nv, model.nv))
    for k, column in enumerate(np.eye(model.nv)):
        mujoco.mj_mulM(model, data, M[k], column)
    return M


def compare_accelerations(
    path: Path,
    controls: Mapping[str, float] | None = None,
    ignore: Sequence[str] = IGNORED,
    *,
    states: int = 5,
    rtol: float = 1e-9,
) -> None:
    """Compare accelerations of all bodies in random states, without contact and limits, to 1e-9 of the largest."""
    controls = controls or {}
    system = sr.System(sr.load_mjcf(path, inertia="given", ignore=ignore, controls=controls))
    space, model = sr.JointSpace(system), mujoco.MjModel.from_xml_path(str(path))
    flags = mujoco.mjtDisableBit
    model.opt.disableflags |= int(flags.mjDSBL_CONTACT) | int(flags.mjDSBL_LIMIT)
    model.opt.tolerance = 0
    if "fluid" in ignore:
        model.opt.density = model.opt.viscosity = 0
    rng = np.random.default_rng(8)
    for _ in range(states):
        theta, qpos, order = random_configuration(space, model, rng)
        rates = rng.choice([-1, 1], space.freedoms) * rng.uniform(
            0.5, 2, space.freedoms
        )  # fast: nothing sticks
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = qpos, rates[order]
        for name, control in controls.items():
            data.ctrl[model.actuator(name).id] = control
        v = space.T(theta) @ rates
        for k in range(model.na):
            data.act[k] = rng.uniform(-1, 1)
            owner = next(n for n in range(model.nu) if model.actuator_actadr[n] == k)
            v[system.states[f"{model.actuator(owner).name}_activation"][0]] = data.act[k]
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        found = accelerations(system, space.q(theta), v)
        expected = {name: of_mujoco(model, data, name) for name in found}
        largest = max(abs(one).max() for one in expected.values())
        for name, acceleration in found.items():
            np.testing.assert_allclose(
                acceleration, expected[name], rtol=0, atol=rtol * largest, err_msg=name
            )


def numbers_of(model: Any) -> dict[str, int]:
    """The numbers of MuJoCo's bodies by name."""
    return {model.body(k).name or f"body{k}": k for k in range(model.nbody)}


def accelerations(system: sr.System, q: Any, v: Any) -> dict[str, Any]:
    """[r̈, ω̇] of every body but frames between joints, from Eqs. (1) and (4)."""
    J = system.Phi_q(q)
    matrix = bmat([[system.M(q), J.T], [J, None]], format="csc")
    right = np.concatenate([system.Q(q, v) + system.S(q, v), system.gamma(q, v)])
    a = solved(matrix, right)[: system.nq].reshape(-1, 7)
    p, solid = q.reshape(-1, 7)[:, 3:], {body.name for body in system.model.bodies if body.mass}
    return {
        name: np.array([*a[n, :3], *2 * E(p[n]) @ a[n, 3:]])
        for n, name in enumerate(system.bodies)
        if name in solid
    }


def solved(matrix: Any, right: Any) -> Any:
    """The solution of least squares; of large systems by sparse factors, refined, if they are not singular."""
    if len(right) > LARGE:
        with suppress(RuntimeError):  # the factor is exactly singular
            factors = splu(matrix)
            x = factors.solve(right)
            for _ in range(REFINED):
                x += factors.solve(right - matrix @ x)
            if abs(right - matrix @ x).max() <= ROUND * max(
                abs(right).max(), abs(matrix).max() * abs(x).max()
            ):
                return x
    return np.linalg.lstsq(matrix.toarray(), right, rcond=None)[0]


def of_mujoco(model: Any, data: Any, name: str, number: int | None = None) -> Any:
    """The same of MuJoCo, which has the negative of gravity in it, for a body by name; its `number` if it is known."""
    found, kind = np.zeros(6), mujoco.mjtObj.mjOBJ_XBODY
    body = numbers_of(model)[name] if number is None else number
    mujoco.mj_objectAcceleration(model, data, kind, body, found, 0)
    lift = (
        np.zeros(3)
        if model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
        else model.opt.gravity
    )
    return np.array([*(found[3:] + lift), *found[:3]])
