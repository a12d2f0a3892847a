"""Do systems that differ in numbers alone share what is made of their structure, and nothing else?"""

from __future__ import annotations

import gc
import weakref

import numpy as np

import sarrus as sr
from sarrus import mechanisms
from sarrus.model.written import with_numbers
from sarrus.system.cached import MOST, once, once_alike
from sarrus.system.structure.structure import _recent


def crank(**numbers: float) -> sr.System:
    """A slider-crank with other numbers."""
    return sr.System(
        with_numbers(
            sr.load(mechanisms.path("slider_crank")), {n.replace("_", "."): x for n, x in numbers.items()}
        )
    )


def test_systems_of_one_model_share_their_structure_but_no_number() -> None:
    light, heavy = crank(rod_mass=1.0), crank(rod_mass=3.0)
    assert light.structure is heavy.structure
    assert light.group("M") is heavy.group("M")
    rod = heavy.coordinates_of("rod").start
    assert light.M(light.q0)[rod, rod] == 1.0
    assert heavy.M(heavy.q0)[rod, rod] == 3.0
    assert light.joint_coordinates.structure is heavy.joint_coordinates.structure


def test_a_gradient_is_the_same_whether_a_like_system_was_there_before_or_not() -> None:
    def gradient(system: sr.System) -> np.ndarray:
        run = sr.simulate(system, until=0.2, t_eval=[0.2], store="steps")
        return np.asarray(sr.sensitivity(run, sr.Final("slider.x")).matrix)

    alone = gradient(crank(pin_axis_x=2.0))  # a direction: how it turns goes with its length
    gc.collect()
    other = crank(pin_axis_x=1.0)
    assert not np.allclose(gradient(other), alone, rtol=1e-3, atol=1e-12)
    like = crank(pin_axis_x=2.0)
    assert like.structure is other.structure
    first = gradient(like)
    assert np.allclose(first, alone, rtol=1e-9, atol=1e-12)  # a sweep may begin with another order of pivots
    assert np.array_equal(gradient(like), first)


def test_another_way_to_connect_bodies_is_another_structure() -> None:
    ground = sr.ground
    bodies = [sr.Body(n, mass=1.0, inertia=(1, 1, 1), position=(k, 0, 0)) for k, n in enumerate("abc")]

    def chain(third: sr.Body) -> sr.System:
        pairs = [(ground, bodies[0]), (bodies[0], bodies[1]), (third, bodies[2])]
        joints = [sr.Spherical(f"joint{k}", i, j, point=(k, 0, 0)) for k, (i, j) in enumerate(pairs)]
        return sr.System(sr.Model("three", bodies=bodies, joints=joints))

    in_line, forked = chain(bodies[1]), chain(bodies[0])
    assert in_line.structure is not forked.structure
    assert in_line.Phi_q(in_line.q0).shape == forked.Phi_q(forked.q0).shape
    assert not np.array_equal(in_line.pattern("Phi_q").indices, forked.pattern("Phi_q").indices)


def test_a_structure_is_forgotten_with_the_last_system_that_has_it() -> None:
    bodies = [
        sr.Body(n, mass=1.0, inertia=(1, 1, 1), position=(k, 0, 0)) for k, n in enumerate("abcdefghijk")
    ]
    first, second = (sr.System(sr.Model(name, bodies=bodies)) for name in ("one", "other"))
    known = weakref.ref(first.structure)
    del first
    gc.collect()
    assert known() is second.structure
    del second
    _recent.clear()  # the last structures wait there for a next system
    gc.collect()
    assert known() is None


def test_what_is_made_once_is_made_of_each_system_or_of_each_structure_and_not_without_end() -> None:
    made: list[tuple[str, int]] = []

    @once
    def of_one(system: sr.System, n: int) -> int:
        made.append(("one", n))
        return n

    @once_alike
    def of_all(system: sr.System, n: int) -> int:
        made.append(("all", n))
        return n

    first, second = crank(), crank(rod_mass=3.0)
    for system in (first, second, first):
        of_one(system, 0)
        of_all(system, 0)
    assert made == [("one", 0), ("all", 0), ("one", 0)]
    for n in range(1, MOST + 1):
        of_all(first, n)
    of_all(second, MOST)
    assert len(made) == 3 + MOST
    of_all(first, 0)
    assert made[-1] == ("all", 0)
