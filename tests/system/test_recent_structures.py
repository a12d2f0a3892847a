"""What systems share is found again by the next system of the same kind, without growing without end."""

import gc
import weakref
from collections.abc import Callable
from typing import Any

import pytest

import sarrus as sr
from sarrus.system.structure.structure import RECENT, _recent


def pendulum(count: int, mass: float = 1.0) -> sr.System:
    bodies = [sr.Body(f"b{n}", mass=mass, inertia=(1, 1, 1), position=(n + 1.0, 0, 0)) for n in range(count)]
    ends = [sr.ground, *bodies]
    joints = [
        sr.Revolute(f"j{n}", ends[n], ends[n + 1], point=(n, 0, 0), axis=(0, 1, 0)) for n in range(count)
    ]
    return sr.System(sr.Model("pendulum", bodies=bodies, joints=joints))


def test_the_structure_of_a_system_that_is_gone_is_found_again() -> None:
    first = pendulum(1)
    first.Phi_q(first.q0)
    structure, gone = first.structure, weakref.ref(first)
    known = id(structure)
    del first, structure
    gc.collect()
    assert gone() is None
    second = pendulum(1, mass=2.0)
    assert id(second.structure) == known
    assert "Phi_q" in second.structure.patterns


def test_only_the_last_structures_of_small_systems_are_kept() -> None:
    links = range(9, RECENT + 13)  # systems of other tests, which may not be collected yet, have fewer
    kept = [weakref.ref(pendulum(n).structure) for n in links]
    large = weakref.ref(pendulum(300).structure)
    gc.collect()
    assert len(_recent) == RECENT
    assert kept[0]() is None
    assert kept[-1]() is not None
    assert large() is None


ANALYSES: dict[str, Callable[[sr.System], Any]] = {
    "assemble": sr.assemble,
    "equilibrium": sr.equilibrium,
    "linearize": lambda system: sr.linearize(system, system.q0),
    "modes": lambda system: sr.modes(system, sr.equilibrium(system)),
    "simulate": lambda system: sr.simulate(system, until=0.1).q,
    "forward dynamics": lambda system: system.forward_dynamics.in_coordinates(["j0.angle"])(
        system.q0, system.v0
    ),
}


@pytest.mark.parametrize("name", ANALYSES)
def test_a_system_and_what_is_kept_with_it_are_freed(name: str) -> None:
    system = pendulum(1)
    ANALYSES[name](system)
    gone = weakref.ref(system)
    del system
    gc.collect()
    assert gone() is None
