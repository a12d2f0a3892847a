"""The cost of large systems: proportional to the number of bodies, joints, actuators and meshes.

Calls of Python functions are counted, which do not depend on the machine; the time of compiled code is compared.
"""

import cProfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.sparse import block_diag, csr_array

import sarrus as sr
from sarrus._jit.formulas import differentiate
from sarrus._jit.formulas.expression import Graph
from sarrus._jit.kernels.emit import Recording
from sarrus.elements import derived
from sarrus.elements.forces.stop import LengthStop
from sarrus.elements.recorder import Variant
from sarrus.io.mjcf.loads import contacts
from sarrus.linalg.kkt import KKT
from sarrus.system.structure import group
from sarrus.system.structure.group import WIDE

TWICE = 2.3  # times as many calls for twice as many parts, at most: some of them twice, and a part that is constant


def chain(count: int) -> sr.Model:
    """Bodies hanging on each other by revolute joints with crossed axes."""
    bodies = [
        sr.Body(f"b{k}", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0.1 * k + 0.05, 0, 0))
        for k in range(count)
    ]
    axes = ((0, 0, 1), (0, 1, 0))
    joints = [
        sr.Revolute(f"j{k}", bodies[k - 1] if k else sr.ground, body, point=(0.1 * k, 0, 0), axis=axes[k % 2])
        for k, body in enumerate(bodies)
    ]
    return sr.Model("chain", bodies, joints, gravity=(0, 0, -9.81))


def field(count: int) -> sr.Model:
    """Separate bodies, each on two springs."""
    bodies = [sr.Body(f"b{k}", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(k, 0, 0)) for k in range(count)]
    springs = [
        sr.TSDA(f"s{k}_{n}", sr.ground.point(k + n, 0, 1), body.point(k, 0, 0), k=100.0, length=1.0)
        for k, body in enumerate(bodies)
        for n in range(2)
    ]
    return sr.Model("field", bodies, forces=springs, gravity=(0, 0, -9.81))


def calls(work: Callable[[], Any], name: str = "") -> int:
    """The calls of functions that something takes: of all, or of those with a name."""
    profile = cProfile.Profile()
    profile.enable()
    work()
    profile.disable()
    return sum(
        entry.callcount
        for entry in profile.getstats()
        if not name or getattr(entry.code, "co_name", "") == name
    )


def grows(work: Callable[[int], Callable[[], Any]], count: int, name: str = "") -> float:
    """How many times as many calls the work on twice as many parts takes."""
    work(2)()  # imports, and what is made once
    return calls(work(2 * count), name) / calls(work(count), name)


@pytest.mark.parametrize("model", [chain, field])
def test_systems_and_assembly_take_calls_in_proportion_to_bodies(model: Callable[[int], sr.Model]) -> None:
    def work(count: int) -> Callable[[], Any]:
        made = model(count)
        return lambda: sr.assemble(sr.System(made))

    assert grows(work, 160) < 2.05  # some 3600 calls for each body: one for each pair of bodies is seen


@pytest.mark.slow
@pytest.mark.parametrize("model", [chain, field])
def test_simulation_takes_time_in_proportion_to_bodies(model: Callable[[int], sr.Model]) -> None:
    def seconds(count: int) -> float:
        system = sr.System(model(count))
        start = sr.assemble(system)
        taken = []
        for _ in range(4):
            before = time.process_time()
            run = sr.simulate(system, start, until=0.02, method=sr.Radau(max_step=0.002))
            taken.append((time.process_time() - before) / run.nsteps)
        return min(taken)

    assert seconds(200) / seconds(100) < 3


@pytest.mark.needs("mujoco")
def test_import_of_actuators_tendons_and_sensors_takes_calls_in_proportion(tmp_path: Path) -> None:
    """Names are not all looked up for each of them."""
    pytest.importorskip("mujoco")
    body = '<body name="a{0}"><joint name="j{0}" axis="0 1 0"/><geom size=".1"/><site name="s{0}"/></body>'
    motor, sensor = (
        '<motor joint="j{0}"/><general site="s{0}" gear="1 0 0 0 0 0"/>',
        '<framepos objtype="site" objname="s{0}"/>',
    )
    tendon = '<fixed name="t{0}"><joint joint="j{0}" coef="2"/></fixed>'

    def work(count: int) -> Callable[[], Any]:
        bodies, motors, sensors, tendons = (
            "".join(one.format(k) for k in range(count)) for one in (body, motor, sensor, tendon)
        )
        path = tmp_path / f"{count}.xml"
        path.write_text(
            f"<mujoco><worldbody>{bodies}</worldbody><tendon>{tendons}</tendon><actuator>{motors}</actuator>"
            f"<sensor>{sensors}</sensor></mujoco>"
        )
        return lambda: sr.load_mjcf(path)

    assert grows(work, 20, "name_of") < TWICE


@pytest.mark.needs("mujoco")
def test_the_corners_of_a_mesh_are_searched_once_for_all_shapes(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    vertices = "1 2 3 -1 2 3 0 -2 3 0 0 -1.5"
    bodies = '<body pos="0 0 9"><freejoint/><geom type="mesh" mesh="m"/></body>' * 5
    (tmp_path / "meshes.xml").write_text(
        f'<mujoco><asset><mesh name="m" vertex="{vertices}"/></asset>'
        f'<worldbody><geom type="plane" size="1 1 1"/>{bodies}</worldbody></mujoco>'
    )
    contacts._hull.cache_clear()
    robot = sr.load_mjcf(tmp_path / "meshes.xml")
    assert sum(isinstance(force, sr.SphereContact) for force in robot.forces) == 5 * 4
    assert contacts._hull.cache_info().misses == 1


@pytest.mark.needs("mujoco")
def test_velocities_of_joint_space_are_those_of_the_tangent_map(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    turn = '<joint name="{0}x" axis="1 0 0" pos="0 .1 0"/><joint name="{0}s" type="slide" axis="1 2 0"/>'
    shape = '<geom type="box" size=".1 .2 .3"/>'
    tree = (
        f'<body pos="0 0 1"><freejoint name="f"/>{shape}<body pos=".1 .2 .3" euler="9 30 0">{turn.format("a")}{shape}'
        f'<body pos=".2 0 0"><joint name="b" type="ball"/>{shape}</body></body>'
        f'<body euler="0 40 7">{turn.format("c")}{shape}</body></body>'
    )
    (tmp_path / "tree.xml").write_text(f"<mujoco><worldbody>{tree}</worldbody></mujoco>")
    space, rng = sr.JointSpace(sr.System(sr.load_mjcf(tmp_path / "tree.xml"))), np.random.default_rng(1)
    theta, rates = space.zero() + 0.3, rng.normal(size=space.freedoms)
    for name in ("f", "b"):
        p = theta[space.coordinates_of[name]][-4:]
        p /= np.linalg.norm(p)
    np.testing.assert_allclose(space.v(theta, rates), space.T(theta) @ rates, rtol=0, atol=1e-14)
    with pytest.raises(ValueError, match=r"rates must have shape"):
        space.v(theta, rates[:-1])


def test_a_jacobian_takes_one_sweep_for_each_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not one for each variable and row of blocks."""
    swept, sweep = [], differentiate._sweep

    def counted(*args: Any) -> Any:
        swept.append(args)
        return sweep(*args)

    monkeypatch.setattr(differentiate, "_sweep", counted)
    recipe = derived.recipe_of.__wrapped__(LengthStop, "Q_q")
    assert len(swept) == 14
    assert len(recipe.grid) == 4


@pytest.mark.parametrize(("moving", "hot"), [(2, True), (WIDE, True), (WIDE + 1, False)])
def test_matrices_of_many_bodies_are_not_vectorized(
    moving: int, hot: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []
    monkeypatch.setattr(group, "driver", lambda signature, *_, **__: made.append(signature))
    monkeypatch.setattr(group, "record", lambda *_: Recording("r", Graph(), moving, 0, (), ()))
    group.own_driver.__wrapped__(("Q_q", "Q_v"), Variant(LengthStop, tuple(range(moving))))
    assert made[0].hot == hot


@pytest.mark.parametrize("blocks", [3, 400])
@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-4, 1e-5])
def test_equations_that_are_nearly_dependent(size: float, blocks: int) -> None:
    """Jx = g holds, whether there are few equations or many, and one of three in each block is redundant."""
    block = np.array([[1.0, 0.0, 0.0], [1.0, size, 0.0], [2.0, size, 0.0]])
    J = csr_array(block_diag([block] * blocks))
    f, x = np.random.default_rng(0).normal(size=(2, J.shape[1]))
    found, lam = KKT(None, J, np.ones(len(x))).solve(f, J @ x)
    fixed = np.arange(len(x)) % 3 < 2
    assert found[fixed] == pytest.approx(x[fixed], abs=1e-9 + 1e-15 / size**2)
    assert found[~fixed] == pytest.approx(f[~fixed], abs=1e-12)
    assert J.T @ lam == pytest.approx(f - found, abs=1e-7)
