"""Reactions of redundant joints depend neither on units, axes, sides and order of joints nor on the analysis."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from tests.analyses.least_reactions import least

import sarrus as sr

AXES = {
    "as they are": np.eye(3),
    "turned": sr.Body("turned", 1, (1, 1, 1), orientation=(0.8, 0.36, -0.48, 0.0)).pose().A,
    "mirrored": np.diag([1.0, -1.0, 1.0]),
}


class Written(NamedTuple):
    """How a mechanism is written: units in SI, axes, and which of its parts come first."""

    metre: float = 1.0
    kilogram: float = 1.0
    second: float = 1.0
    axes: np.ndarray = AXES["as they are"]
    swapped: bool = False
    reversed: bool = False


WAYS = {
    "millimetres": Written(metre=1e3),
    "other units": Written(metre=1e2, kilogram=1e3, second=60.0),
    **{name: Written(axes=axes) for name, axes in AXES.items() if name != "as they are"},
    "sides": Written(swapped=True),
    "order": Written(reversed=True, swapped=True, axes=AXES["turned"], metre=1e3),
}


def cupboard(way: Written) -> sr.System:
    """A door on two hinges, with a drawer in it on two rails, one of which slides apart, and a doubled ball joint."""
    L, Q = way.metre, way.axes
    sign = np.linalg.det(Q)

    def at(*x: float) -> tuple[float, ...]:
        return tuple(Q @ np.array(x) * L)

    def along(*x: float) -> tuple[float, ...]:
        return tuple(Q @ np.array(x))

    def inertia(*x: float) -> tuple[float, ...]:
        return tuple(np.array(x) * way.kilogram * L**2)

    turned = {"orientation": [*map(tuple, np.column_stack([Q[:, 0], Q[:, 1], sign * Q[:, 2]]))]}
    door = sr.Body("door", 20 * way.kilogram, inertia(2, 1, 1.5), position=at(0.4, 0, 1), **turned)
    drawer = sr.Body(
        "drawer", 3 * way.kilogram, inertia(0.1, 0.2, 0.15), position=at(0.5, 0.2, 0.8), **turned
    )
    ball = sr.Body("ball", 2 * way.kilogram, inertia(0.1, 0.1, 0.1), position=at(0.7, 0.5, 0.5), **turned)

    def joint(
        kind: type, name: str, i: object, j: object, point: tuple[float, ...], **more: object
    ) -> sr.Joint:
        i, j = (j, i) if way.swapped else (i, j)
        return kind(name, i, j, point=point, **more)

    joints = [
        joint(sr.Revolute, "low", sr.ground, door, at(0, 0, 0.3), axis=along(0, 0, 1)),
        joint(sr.Revolute, "high", sr.ground, door, at(0, 0, 1.7), axis=along(0, 0, 1)),
        joint(sr.Translational, "left", door, drawer, at(0.3, 0, 0.8), axis=along(0, 1, 0)),
        joint(sr.Translational, "right", door, drawer, at(0.6, 0.1, 0.9), axis=along(0, 1, 0)),
        joint(sr.Spherical, "once", drawer, ball, at(0.6, 0.4, 0.6)),
        joint(sr.Spherical, "twice", drawer, ball, at(0.6, 0.4, 0.6)),
    ]
    bodies = [door, drawer, ball]
    if way.reversed:
        bodies, joints = bodies[::-1], joints[::-1]
    gravity = tuple(np.array(at(0.7, -0.5, -9.81)) / way.second**2)
    return sr.System(sr.Model("cupboard", bodies, joints, gravity=gravity))


NAMES = {"door": ("low", "high"), "drawer": ("left", "right"), "ball": ("once", "twice")}


def on_bodies(of: object, way: Written, n: int | None) -> np.ndarray:
    """Force and moment about its point of each joint on its outer body, in SI units and the first axes."""
    force, found = way.kilogram * way.metre / way.second**2, []
    for joints in NAMES.values():
        for joint in joints:
            side = "_i" if way.swapped else ""
            F, M = (of[f"{joint}.{word}{side}"] for word in ("force", "torque"))
            F, M = (x if n is None else x[n] for x in (F, M))
            turn = np.linalg.det(way.axes) * way.axes.T
            found += [way.axes.T @ F / force, turn @ M / (force * way.metre)]
    return np.array(found)


def simulated(way: Written) -> np.ndarray:
    """At the start, and after drawer and door have moved by themselves."""
    run = sr.simulate(
        cupboard(way),
        until=0.2 * way.second,
        t_eval=[0, 0.2 * way.second],
        method=sr.Radau(rtol=1e-9, atol=1e-11),
    )
    assert run.success, run.message
    return np.array([on_bodies(run, way, n) for n in (0, -1)])


@pytest.mark.filterwarnings("ignore")
@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", WAYS)
def test_units_axes_sides_and_order(name: str) -> None:
    wanted, found = simulated(Written()), simulated(WAYS[name])
    assert found == pytest.approx(wanted, abs=2e-7 * abs(wanted).max())


@pytest.mark.filterwarnings("ignore")
def test_all_analyses_make_the_same_choice() -> None:
    """Of a cupboard at rest, whose door does not turn: free motions have no acceleration, or a motor holds it."""
    first = cupboard(Written())
    still = replace(first.model, gravity=(0.0, 0.0, -9.81))
    held = replace(
        still, drivers=[sr.AngleDriver("swing", "low", "0"), sr.DisplacementDriver("pull", "left", "0"),
                        *(sr.CoordinateDriver(f"turn_{e}", first.model.bodies[2], e, "0") for e in ("e1", "e2", "e3"))]
    )  # fmt: skip
    system = sr.System(held)
    motion = sr.kinematics(system, np.linspace(0.0, 1.0, 3))
    choices = [motion.lam[1], sr.inverse_dynamics(system, motion).lam[1], sr.equilibrium(system).lam]
    choices += [system.forward_dynamics(system.q0, system.v0).lam, sr.simulate(system, until=0.1).lam[-1]]
    wanted = least(system, system.q0, system.Q(system.q0, system.v0))
    for lam in choices:
        assert lam == pytest.approx(wanted, abs=1e-8 * abs(wanted).max())
    moving = sr.assemble(first, rates={"low": 2.0, "left": 0.5})
    plant = sr.linearize(first, moving)
    force = first.Q(plant.q, plant.v) + first.S(plant.q, plant.v) - first.M_a(plant.q, plant.a)
    for lam in (plant.lam, first.forward_dynamics(plant.q, plant.v).lam):
        assert lam == pytest.approx(least(first, plant.q, force), abs=1e-8 * abs(lam).max())
