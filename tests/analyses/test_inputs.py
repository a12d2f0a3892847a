"""Loads and motions that last shortly are not passed over, whatever the method, the tolerance and where they act."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus import model
from sarrus.analyses.dynamics.inputs.laws_of_time import features, parts_of
from sarrus.elements import Element, Force
from sarrus.elements.element import Scalar
from sarrus.functions import absolute, exp, positive, sign, sin, tanh
from sarrus.model.primitive import Primitive

METHODS = (sr.HHT(), sr.HHT(stabilized=True), sr.GeneralizedAlpha(), sr.Radau(), sr.ODE())
Function = Callable[[Any], Any]


def half_wave(begins: float, takes: float) -> Function:
    """sin², whose integral is half of its length."""

    def value(t: Any) -> Any:
        s = (t - begins) / takes
        return sin(np.pi * s) ** 2 * positive(s) * positive(1 - s)

    return value


def bell(middle: float, width: float) -> Function:
    """exp(-½ ((t - m)/w)²), whose integral is w sqrt(2π)."""
    return lambda t: exp(-0.5 * ((t - middle) / width) ** 2)


def mass(**given: Any) -> sr.Body:
    return sr.Body("mass", 1.0, (1.0, 1.0, 1.0), **given)


def pushed(load: Any, until: float, method: Any = None) -> float:
    """The speed of a free mass of 1 kg at the end: the load's impulse."""
    body = mass()
    push = sr.PointForce("push", body.point(0, 0, 0), (1, 0, 0), factor=load)
    run = sr.simulate(
        sr.System(sr.Model("m", [body], forces=[push])), until=until, t_eval=[until], method=method
    )
    assert run.success, run.message
    return float(run["mass"].velocity[-1, 0])


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", METHODS, ids=str)
@pytest.mark.parametrize("takes", [0.02, 0.001])
def test_a_pulse_with_corners(method: Any, takes: float) -> None:
    assert pushed(half_wave(3.0, takes), 10.0, method) == pytest.approx(takes / 2, rel=0.02)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", METHODS, ids=str)
@pytest.mark.parametrize("width", [0.01, 1e-4, 1e-6])
def test_a_smooth_pulse(method: Any, width: float) -> None:
    """A load of 1/w, so that the tolerance sees the change of speed."""
    height = 1 / width
    found = pushed(lambda t: height * exp(-0.5 * ((t - 7.3) / width) ** 2), 10.0, method)
    assert found == pytest.approx(np.sqrt(2 * np.pi), rel=0.02)


def test_formulas_in_texts() -> None:
    assert pushed("100*exp(-((t - 3)/0.001)^2)", 6.0) == pytest.approx(0.1 * np.sqrt(np.pi), rel=0.02)


class Kick(Force, bodies=1, derivatives="automatic"):
    """A user's force that computes its pulse itself."""

    height: Scalar  # [N]
    begins: Scalar  # [s]

    def Q(self, x: Any, v: Any, t: Any) -> Any:
        wave = half_wave(self.begins, 0.01)
        return np.array([self.height * wave(t), 0, 0], dtype=object), None


@dataclass(frozen=True, eq=False)
class Kicker(model.Force):
    """A pulse of 10 ms on a body."""

    point: model.Point
    height: float
    begins: float

    def primitives(self, poses: Any) -> Any:
        point = self.point.resolve(poses, "point")
        yield Primitive(Kick, (point.body,), (self.height, self.begins), "kick")


del Element.registry["Kick"], model.Force.kinds["kicker"]  # other tests see those of the package alone


def test_a_force_of_the_users_own() -> None:
    """Each element has its own numbers."""
    body = mass()
    center = body.point(0, 0, 0)
    kicks = [Kicker("one", center, 100.0, 2.0), Kicker("two", center, -30.0, 7.0)]
    run = sr.simulate(sr.System(sr.Model("m", [body], forces=kicks)), until=9.0, t_eval=[5.0, 9.0])
    assert run["mass"].velocity[:, 0] == pytest.approx([0.5, 0.35], rel=0.02)


@pytest.mark.parametrize("make", [half_wave, bell])
def test_a_foot_that_moves_shortly(make: Callable[[float, float], Function]) -> None:
    """A driver displaces the foot of a spring by 1 cm for some 20 ms: an impulse k ∫x of the mass."""
    move = make(2.0, 0.02)
    foot, body = sr.Body("foot", 1.0, (1.0,) * 3, position=(-1, 0, 0)), mass()
    guides = [
        sr.Translational(f"guide_{b.name}", sr.ground, b, point=(0, 0, 0), axis=(1, 0, 0))
        for b in (foot, body)
    ]
    spring = sr.TSDA("spring", foot.point(0, 0, 0), body.point(0, 0, 0), k=1.0, length=1.0)
    shaker = sr.DisplacementDriver("shaker", "guide_foot", motion=lambda t: 0.01 * move(t))
    system = sr.System(sr.Model("m", [foot, body], guides, [spring], drivers=[shaker]))
    run = sr.simulate(system, until=3.0, t_eval=[2.5])
    impulse = 0.01 * (0.01 if make is half_wave else 0.02 * np.sqrt(2 * np.pi))
    assert run["mass"].velocity[-1, 0] == pytest.approx(impulse * np.cos(0.5), rel=0.05)


def test_a_road_that_rises_shortly() -> None:
    """A tyre at rest over a bump of 2 cm and 50 ms: k ∫h upwards, 250 kg."""
    body = sr.Body("wheel", 250.0, (1.0,) * 3, position=(0, 0, 0.3 - 250 * 9.81 / 1e5))
    wave = half_wave(1.0, 0.05)
    tyre = sr.RoadTyre("tyre", body.point(0, 0, 0), 1e5, 0.0, 0.3, bump=lambda t: 0.02 * wave(t))
    system = sr.System(sr.Model("m", [body], forces=[tyre], gravity=(0, 0, -9.81)))
    run = sr.simulate(system, until=1.05, t_eval=[1.05])
    w, T = np.sqrt(400), 0.05  # z'' + w² z = w² h: Duhamel's integral
    s = np.linspace(0, T, 20001)
    speed = np.trapezoid(400 * 0.02 * np.sin(np.pi * s / T) ** 2 * np.cos(w * (T - s)), s)
    assert run["wheel"].velocity[-1, 2] == pytest.approx(speed, rel=0.01)


def times(function: Function, until: float) -> Any:
    body = mass()
    push = sr.PointForce("push", body.point(0, 0, 0), (1, 0, 0), factor=function)
    return features(sr.System(sr.Model("m", [body], forces=[push])), 0.0, until)


def test_corners_are_found_to_round_off() -> None:
    found = times(lambda t: positive(t - np.pi / 3) * (t - np.pi / 3) + positive(2.5 - t), 10.0)
    assert found.corners == pytest.approx([np.pi / 3, 2.5], abs=1e-15)
    square = times(lambda t: positive(sin(50 * t)), 10.0)
    assert square.corners[1:] == pytest.approx(np.arange(1, 160) * np.pi / 50, abs=1e-14)


def test_steps_are_not_bounded_without_need() -> None:
    for function in (lambda t: 6 * t, lambda t: t**3 - 2 * t, lambda t: 3.0 + 0 * t):
        found = times(function, 10.0)
        assert not len(found.corners)
        assert not len(found.ends)
        assert found.longest == np.inf


@pytest.mark.parametrize("until", [10.0, 1e5])
def test_a_law_that_oscillates_bounds_all_steps(until: float) -> None:
    """By a part of its period, also where it has more periods than samples."""
    found = times(lambda t: sin(2 * np.pi * 5.0 * t), until)
    assert not len(found.ends)
    assert 0.02 < found.longest < 0.1


def test_a_path_is_examined_once_for_all_gains_of_its_controller() -> None:
    """An optimization of the gains does not search for the corners of the path in every simulation."""
    slide = sr.Translational("slide", sr.ground, mass(), point=(0, 0, 0), axis=(1, 0, 0))
    examined = []
    for kp in (3.0, 4.0):
        pid = sr.PID("pid", input="step(t, 0.3, 0, 0.7, 1) - slide.displacement", kp=kp, ki=1.0)
        push = sr.Force("push", joint="slide", value="pid.output")
        found = features(sr.System(sr.Model("m", [slide.body_j], [slide], [pid, push])), 0.0, 1.234)
        assert found.corners == pytest.approx([0.3, 0.7], abs=1e-15)
        examined.append(parts_of.cache_info().misses)
    assert examined[0] == examined[1]


def test_a_steep_rise() -> None:
    found = times(lambda t: tanh((t - 4) / 1e-5), 10.0)
    assert abs(found.ends - 4).min() < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "exact"),
    [  # over each period of T = 2 ms: impulse and final displacement from rest
        (lambda s: positive(s), (1e-3, 1.5e-6)),
        (lambda s: 3 + sign(s), (6e-3, 7e-6)),
        (lambda s: absolute(s), (4e-3 / np.pi, 4e-6 / np.pi)),
    ],
)
def test_a_load_that_is_switched_500_times(law: Any, exact: tuple[float, float]) -> None:
    """No step contains a jump: all digits are right, in few steps, also where outputs are at the jumps themselves."""
    body, rate, (impulse, moved) = sr.Body("mass", 1.0, (1, 1, 1)), 1000 * np.pi, exact
    load = sr.PointForce("load", body.point(0, 0, 0), (1, 0, 0), factor=lambda t: law(sin(rate * t)))
    system = sr.System(sr.Model("switched", [body], [], [load]))
    n = np.arange(0, 251, 50)
    run = sr.simulate(system, until=0.5, t_eval=n * 2e-3)
    assert run.success, run.message
    assert run.nsteps < 5500
    assert run["mass"].velocity[:, 0] == pytest.approx(n * impulse, rel=2e-8, abs=1e-15)
    x = n * moved + n * (n - 1) / 2 * impulse * 2e-3
    assert run["mass"].position[:, 0] == pytest.approx(x, rel=2e-8, abs=1e-15)


def test_steps_end_before_a_jump_and_begin_behind_it() -> None:
    """A load that is on until exactly 0.3 s is that in the last stage of the step before, too."""
    body = sr.Body("mass", 1.0, (1, 1, 1))
    load = sr.PointForce("load", body.point(0, 0, 0), (1, 0, 0), factor=lambda t: positive(0.3 - t))
    run = sr.simulate(sr.System(sr.Model("switched", [body], [], [load])), until=1.0, t_eval=[0, 0.3, 1.0])
    assert run["mass"].velocity[:, 0] == pytest.approx([0, 0.3, 0.3], rel=1e-12)
    assert run.nsteps < 40
