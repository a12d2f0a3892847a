"""Coordinates of joints: values, rates and exact derivatives; ranks of all joints in random poses."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.model.test_joints import ABOUT_AXIS, ROWS

import sarrus as sr
from sarrus.model import Joint


def bodies(seed: int) -> tuple[sr.Body, sr.Body]:
    random = np.random.default_rng(seed)
    turns = Rotation.random(2, rng=random).as_matrix()
    one, two = (
        sr.Body(name, 1.0, (1, 1, 1), position=random.normal(size=3), orientation=turn)
        for name, turn in zip(("one", "two"), turns, strict=True)
    )
    return one, two


def placed(kind: str, one: sr.Body, two: sr.Body, seed: int) -> Joint:
    """A joint at a random place, assembled where the two bodies are."""
    random = np.random.default_rng(100 + seed)
    point, axis, apart = random.normal(size=(3, 3))
    make: Any = Joint.kinds[kind]
    ends = one.global_point(*point), two.global_point(*(point + apart))
    across = np.cross(apart, axis)
    special: dict[str, Callable[[], Joint]] = {
        "distance": lambda: make("joint", *ends),
        "revolute_spherical": lambda: make("joint", *ends, axis=across),
        "revolute_revolute": lambda: make(
            "joint", *ends, axis_i=across, axis_j=np.cross(apart, [1.0, 0.3, 0.2])
        ),
        "universal": lambda: make("joint", one, two, point=point, axis_i=axis, axis_j=across),
        "constant_angle": lambda: make("joint", one, two, axis_i=axis, axis_j=apart),
        "parallel_axes": lambda: make("joint", one, two, axis=axis),
        "screw": lambda: make("joint", one, two, point=point, axis=axis, pitch=0.2),
        "parallel_link": lambda: make("joint", *ends, axis_i=across),
    }
    if kind in ABOUT_AXIS and kind != "screw":
        return make("joint", one, two, point=point, axis=axis)  # type: ignore[no-any-return]
    return special[kind]() if kind in special else make("joint", one, two, point=point)


def mobility(system: sr.System) -> tuple[int, int]:
    """Degrees of freedom as counted, and by the rank of the Jacobian."""
    Phi_q = system.Phi_q(system.q0).toarray()
    return system.nq - system.m, system.nq - int(np.linalg.matrix_rank(Phi_q, tol=1e-9))


@pytest.mark.parametrize("kind", ROWS)
@pytest.mark.parametrize("seed", range(4))
def test_count_and_mobility_in_random_poses(kind: str, seed: int) -> None:
    one, two = bodies(seed)
    if seed == 3:
        one = sr.ground  # type: ignore[assignment]
    moving = [body for body in (one, two) if isinstance(body, sr.Body)]
    system = sr.System(sr.Model("pair", moving, [placed(kind, one, two, seed)]))
    assert abs(system.Phi(system.q0)).max() < 1e-13
    free = 6 * len(moving) - ROWS[kind]
    assert mobility(system) == (free, free)
    assert len(system.rows["joint"]) == ROWS[kind]


def test_a_link_between_parallel_axes() -> None:
    one, two = bodies(7)
    ends = one.global_point(0, 0, 0), two.global_point(1, 2, 0)
    system = sr.System(sr.Model("m", [one, two], [sr.RevoluteRevolute("link", *ends, axis_i=(0, 0, 3))]))
    assert mobility(system) == (8, 8)
    assert system.row_names[0] == "link: f_i.h_j"


@cache
def arm(coupled: bool = False) -> sr.System:
    """A hinge, a sleeve, a slide and a universal joint; with gears, a rack and a coupler, or without."""
    a, b = bodies(3)
    c = sr.Body("c", 1.0, (1, 2, 3), position=(0.1, 0.2, 0.4))
    d = sr.Body("d", 1.0, (1, 2, 3), position=(0.1, 1.2, 0.4), orientation=sr.AxisAngle((1, 2, 3), 0.4))
    joints: list[Joint] = [
        sr.Revolute("pin", sr.ground, a, point=(0, 0, 0), axis=(0, 0.6, 0.8)),
        sr.Cylindrical("sleeve", a, b, point=(0, 1, 0), axis=(1, 0, 0)),
        sr.Translational("slide", sr.ground, c, point=(0, 0, 1), axis=(0, 1, 0)),
        sr.Universal("hook", c, d, point=(1, 1, 1), axis_i=(0, 0, 1), axis_j=(1, 0, 0)),
    ]
    if coupled:
        joints += [
            sr.Gear("gear", "pin", "sleeve", ratio=-2.0),
            sr.RackAndPinion("rack", "slide", "pin", radius=0.3),
            sr.Coupler("pull", "slide", "sleeve.displacement", ratio=1.5),
        ]
    return sr.System(sr.Model("arm", [a, b, c, d], joints))


def test_couplings_are_independent_equations() -> None:
    assert mobility(arm()) == (24 - 5 - 4 - 5 - 4,) * 2
    assert mobility(arm(coupled=True)) == (3, 3)
    assert abs(arm(coupled=True).Phi(arm().q0)).max() < 1e-13


def test_derivatives_of_coordinates() -> None:
    system = arm()
    random = np.random.default_rng(2)
    q, v, a = system.q0 + 0.1 * random.normal(size=system.nq), *random.normal(size=(2, system.nq))
    every, h = system.joint_coordinates, 1e-4
    for name in every.names:
        joint, _, own = name.partition(".")
        one = system.joint(joint)[own]

        def along(t: float, one: Any = one) -> float:
            return float(one.value(q + t * v + 0.5 * t * t * a, near=one.value(q)))

        slope = (8 * (along(h) - along(-h)) - along(2 * h) + along(-2 * h)) / (12 * h)
        bend = (along(h) - 2 * along(0) + along(-h)) / h**2
        assert one.rate(q, v) == pytest.approx(slope, abs=1e-8)
        assert (one.gradient(q) @ v)[0] == pytest.approx(one.rate(q, v), abs=1e-12)
        assert one.acceleration(q, v, a) == pytest.approx(bend, abs=1e-3)
        assert (one.gradient_xi_q(q, v) @ v)[0] == pytest.approx(
            one.acceleration(q, v, np.zeros(system.nq)), abs=1e-10
        )


def test_unknown_coordinates_are_refused() -> None:
    with pytest.raises(KeyError, match=r'no joint "pni" with an angle or displacement. Did you mean "pin"?'):
        arm().joint("pni")
    with pytest.raises(KeyError, match=r"no joint coordinate 'pin\.displacement'. Choose from pin\.angle"):
        arm().joint("pin").displacement(arm().q0)


def test_a_wheel_that_spins_counts_its_turns() -> None:
    wheel = sr.Body("wheel", 1.0, (1, 1, 2.0), angular_velocity=(0, 0, 40.0))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    run = sr.simulate(
        sr.System(sr.Model("wheel", [wheel], [pin])),
        until=2.0,
        t_eval=np.linspace(0, 2, 9),
        method=sr.ODE(rtol=1e-8, atol=1e-10),
    )
    motion = run.joint("pin")
    assert np.allclose(motion.angle, 40.0 * run.t, atol=1e-6)
    assert np.allclose(motion.rate, 40.0, atol=1e-6)
    with pytest.raises(AttributeError, match=r"joint 'pin': There is no displacement. Choose from angle"):
        _ = motion.displacement
    with pytest.raises(KeyError, match='no joint "pni"'):
        run.joint("pni")


def test_values_and_rates_along_a_motion() -> None:
    """All states in one compiled call, as one after another; revolutions are counted from each time to the next."""
    one, two = bodies(3)
    axis, point = (0.2, 0.3, 1.0), (0.1, 0.0, 0.0)
    joints = [
        sr.Cylindrical("sleeve", sr.ground, one, point=point, axis=axis),
        sr.Revolute("pin", one, two, point=point, axis=axis),
    ]
    model = sr.Model("pair", [one, two], joints, gravity=(0, 0, -9.81))
    system = sr.System(model)
    start = sr.assemble(system, rates={"sleeve.angle": 9.0, "pin.angle": -14.0})
    run = sr.simulate(system, start, until=2.0, t_eval=np.linspace(0, 2, 6))  # almost a revolution apart
    every, motion = system.joint_coordinates, (run.t, run.q, run.v)
    values, rates = every.along(*motion)
    assert abs(values[-1]).max() > 2 * 2 * np.pi
    for n, (q, v) in enumerate(zip(run.q, run.v, strict=True)):
        near = (
            values[n - 1] + 0.5 * (run.t[n] - run.t[n - 1]) * (rates[n - 1] + rates[n]) if n else every.Phi(q)
        )
        assert values[n] == pytest.approx(every.near(every.Phi(q), near), abs=1e-13)
        assert rates[n] == pytest.approx(every.Phi_q_xi(q, v), abs=1e-12)
    for x in motion:
        x.flags.writeable = False
    turns = np.round((values - [every.Phi(q) for q in run.q]) / (2 * np.pi))
    assert np.array_equal(every.along(*motion, turns)[0], values)
    assert [x.shape for x in every.along(run.t[:0], run.q[:0], run.v[:0])] == [(0, every.m)] * 2


def test_the_hinge_of_a_massless_link_counts_its_turns() -> None:
    """A ball on a link that turns in a plane: the link's angle grows with the ball's speed, over many turns."""
    ball = sr.Body("ball", 1.0, (1, 1, 1), position=(2, 0, 0), velocity=(0, 3, 0))
    ends = sr.ground.point(0, 0, 0), ball.point(0, 0, 0)
    system = sr.System(sr.Model("m", [ball], [sr.RevoluteSpherical("link", *ends, axis=(0, 0, 1))]))
    run = sr.simulate(system, until=12.0, method=sr.ODE(rtol=1e-9, atol=1e-11))
    link = run.joint("link")
    assert link.angle == pytest.approx(1.5 * run.t, abs=1e-6)
    assert link.rate == pytest.approx(1.5, abs=1e-8)


def test_both_hinges_of_a_link_are_read() -> None:
    """Two discs on a link between parallel axes: one turns with the link's end, the other stays where it is."""
    disc = sr.Body(
        "disc", 1.0, (1, 1, 1), position=(2, 0, 0), velocity=(0, 3, 0), angular_velocity=(0, 0, 1.5)
    )
    ends = sr.ground.point(0, 0, 0), disc.point(0, 0, 0)
    system = sr.System(sr.Model("m", [disc], [sr.RevoluteRevolute("link", *ends, axis_i=(0, 0, 1))]))
    run = sr.simulate(system, until=9.0, method=sr.ODE(rtol=1e-9, atol=1e-11))
    link = run.joint("link")
    assert link.values["angle_i"] == pytest.approx(1.5 * run.t, abs=1e-6)
    assert link.values["angle_j"] == pytest.approx(0, abs=1e-6)


def test_a_link_cannot_be_coupled() -> None:
    ball = sr.Body("ball", 1.0, (1, 1, 1), position=(2, 0, 0))
    wheel = sr.Body("wheel", 1.0, (1, 1, 1))
    ends = sr.ground.point(0, 0, 0), ball.point(0, 0, 0)
    link = sr.RevoluteSpherical("link", *ends, axis=(0, 0, 1))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    with pytest.raises(sr.ModelError, match='joint "link" has no coordinate'):
        sr.System(sr.Model("m", [ball, wheel], [link, pin, sr.Coupler("pull", "pin", "link", ratio=2.0)]))
