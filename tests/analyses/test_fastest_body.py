"""Runs that end because their steps are too many or too short name the body that changes fastest."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import pytest

import sarrus as sr
from sarrus.functions import absolute, sign, sin, step, tanh

X, Z, O = (1, 0, 0), (0, 0, 1), (0, 0, 0)


def block(name: str, mass: float = 1.0, x: float = 0.0, **more: Any) -> sr.Body:
    return sr.Body(name, mass, (0.01 * mass,) * 3, position=(x, 0, 0), **more)


def slide(*bodies: sr.Body) -> list[sr.Translational]:
    return [sr.Translational(f"{one.name}_slide", sr.ground, one, point=O, axis=X) for one in bodies]


def spring(name: str, one: Any, other: sr.Body, length: float, **law: Any) -> sr.TSDA:
    return sr.TSDA(name, one.point(*O), other.point(*O), length=length, **law)


def bolted() -> sr.Model:
    """A bolt without damping, 1 mm longer than it is at rest, beside a soft spring that carries five times the mass."""
    one, other = block("block", x=1.001), block("load", 5.0, 2.2)
    forces = [spring("bolt", sr.ground, one, 1.0, k=1e10), spring("soft", one, other, 1.0, k=100.0)]
    return sr.Model("bolted", [one, other], slide(one, other), forces)


def cogging() -> sr.Model:
    """A stiffness with a ripple of 60 µm."""
    one = block("block", x=1.0)
    forces = [spring("cog", sr.ground, one, 0.5, k=lambda x: 100 + 50 * sin(1e5 * x))]
    return sr.Model("cogging", [one], slide(one), forces)


def humming() -> sr.Model:
    one = block("block", x=1.0)
    forces = [
        sr.PointForce("hum", one.point(*O), X, factor="sin(1e5*t)"),
        spring("soft", sr.ground, one, 0.5, k=9.0),
    ]
    return sr.Model("humming", [one], slide(one), forces)


def squealing() -> sr.Model:
    """Damping that depends on every µm/s."""
    one = block("block", x=1.0, velocity=(0.1, 0, 0))
    forces = [spring("squeal", sr.ground, one, 1.0, k=10.0, c=lambda v: 1 + 0.5 * sin(1e5 * v))]
    return sr.Model("squealing", [one], slide(one), forces)


def whiskered() -> sr.Model:
    """A part of 1 µg on a torsional spring."""
    cart, whisker = block("cart"), sr.Body("whisker", 1e-9, (1e-14,) * 3, position=(0.1, 0, 0))
    hinge = {"point": (0.09, 0, 0), "axis": Z}
    blade = sr.RSDA("blade", cart, whisker, k=1e-3, angle=0.01, **hinge)
    joints = [*slide(cart), sr.Revolute("hinge", cart, whisker, **hinge)]
    return sr.Model("whiskered", [cart, whisker], joints, [blade], gravity=(0, -9.81, 0))


def spinning() -> sr.Model:
    rotor, cart = sr.Body("rotor", 1.0, (0.01,) * 3, angular_velocity=(0, 0, 1e5)), block("cart", 100.0, 1.0)
    forces = [spring("soft", sr.ground, cart, 0.5, k=9.0)]
    axle = sr.Revolute("axle", sr.ground, rotor, point=O, axis=Z)
    return sr.Model("spinning", [rotor, cart], [axle, *slide(cart)], forces)


def shaken() -> sr.Model:
    """A base that moves by 1 µm at 160 kHz."""
    one, load = block("base"), block("load", 1.0, 1.0)
    motor = sr.CoordinateDriver("motor", one, "x", lambda t: 1e-6 * sin(1e6 * t))
    forces = [spring("soft", one, load, 0.9, k=9.0)]
    return sr.Model("shaken", [one, load], slide(one, load), forces, drivers=[motor])


def calm() -> sr.Model:
    one = block("block", x=1.0)
    return sr.Model("calm", [one], slide(one), [spring("soft", sr.ground, one, 0.5, k=9.0)])


def ran(model: sr.Model, **given: Any) -> sr.Trajectory:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return sr.simulate(sr.System(model), until=10.0, **given)


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    ("model", "part"),
    [
        (bolted, "block"), (cogging, "block"), (humming, "block"), (squealing, "block"), (whiskered, "whisker"),
        (spinning, "rotor"),
    ],
)  # fmt: skip
def test_the_body_that_changes_fastest_is_named(model: Callable[[], sr.Model], part: str) -> None:
    run = ran(model(), max_steps=2000)
    assert run.status == "too many steps"
    assert run.message.endswith(f"or larger tolerances. The motion of {part} changes fastest there.")


@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()])
def test_a_part_that_a_driver_shakes_is_named(method: Any) -> None:
    assert "The motion of base changes fastest there." in ran(shaken(), max_steps=2000, method=method).message


def test_another_unit_of_time_or_length_names_the_same() -> None:
    """A bolt in nanometres and microseconds."""
    one, other = block("block", x=1.001e-9), block("load", 5.0, 2.2e-9)
    forces = [spring("bolt", sr.ground, one, 1e-9, k=1e22), spring("soft", one, other, 1e-9, k=1e14)]
    small = sr.Model("small", [one, other], slide(one, other), forces)
    assert "The motion of block changes fastest there." in ran(small, max_steps=2000).message


def test_a_law_with_a_pole_is_named() -> None:
    """The block falls into it: an attraction by 0.1/(x - 0.5)²."""
    one = block("block", x=1.0)
    forces = [spring("pole", sr.ground, one, 0.5, k=lambda x: 0.1 / (x - 0.5) ** 3)]
    run = ran(sr.Model("pole", [one], slide(one), forces))
    assert run.status == "step too small"
    assert "The motion of block changes fastest" in run.message


def test_steps_end_at_the_jump_of_a_law() -> None:
    """A force of 10 N towards x = 0.9: parabolas, each for a quarter of a period; 10 s are in the third quarter."""
    one = block("block", x=1.0)
    forces = [spring("bang", sr.ground, one, 0.5, k=lambda x: 10 * sign(x - 0.9) / (x - 0.5))]
    run = ran(sr.Model("bang-bang", [one], slide(one), forces))
    place = 10 / (2 * 0.1 / 10) ** 0.5 % 4 - 2
    assert 0 < place < 1
    assert run["block.x"][-1] == pytest.approx(0.9 - 0.1 * (1 - place**2), abs=1e-4)


def driven(motion: Any) -> sr.System:
    one = block("block")
    return sr.System(
        sr.Model("driven", [one], slide(one), drivers=[sr.CoordinateDriver("push", one, "x", motion)])
    )


def test_a_driver_that_jumps_is_a_warning() -> None:
    """A kink, a steep rise and one that takes a time are none."""
    with pytest.warns(sr.SarrusWarning, match=r"push: its motion jumps by 0\.1 at t = 1 s, .* step\(t"):
        sr.simulate(driven(lambda t: 0.05 * (1 + sign(t - 1.0))), until=2.0)
    for motion in (
        lambda t: 1 - absolute(t - 1.0),
        lambda t: step(t, 0.9, 0.0, 1.1, 0.1),
        lambda t: 0.05 * (1 + tanh((t - 1.0) / 1e-3)),
    ):
        assert not any("jumps" in one for one in sr.simulate(driven(motion), until=2.0).warnings)
