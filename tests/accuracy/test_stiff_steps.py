"""Estimated errors of stiff motions, whose adjoint is not linear within a step, against closed forms and tight runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.sensitivity.accuracy import defect, stiff_steps
from sarrus.analyses.sensitivity.accuracy.divided_steps import DividedSteps, whole_steps
from sarrus.functions import sin
from sarrus.results import Pieces

OMEGA = 3.0  # rad/s
LOOSE = {"rtol": 1e-4, "atol": 1e-6}


def dragged(damping: float) -> sr.System:
    """A mass of 1 kg in a viscous damper whose foot moves with sin(ωt) m/s."""
    body = sr.Body("mass", 1.0, (1e-3,) * 3)
    guide = sr.Translational("guide", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    at = body.point(0, 0, 0)
    damper = sr.TSDA("damper", sr.ground.point(-1, 0, 0), at, k=0.0, c=damping, length=1.0)
    pull = sr.PointForce("pull", at, (1, 0, 0), factor=lambda t: damping * sin(OMEGA * t))
    return sr.System(sr.Model("dragged", [body], [guide], [damper, pull]))


def position(c: float, t: float) -> float:
    """x of v' = c (sin ωt - v), from rest."""
    return (
        c
        * (c * (1 - np.cos(OMEGA * t)) / OMEGA - np.sin(OMEGA * t) + OMEGA * decayed(c, t) / c)
        / (c**2 + OMEGA**2)
    )


def velocity(c: float, t: float) -> float:
    forced = c * np.sin(OMEGA * t) - OMEGA * np.cos(OMEGA * t)
    return c * (forced + OMEGA * np.exp(-c * t)) / (c**2 + OMEGA**2)


def decayed(c: float, t: float) -> float:
    return 1 - np.exp(-c * t)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("settings", [{}, LOOSE], ids=["default", "loose"])
@pytest.mark.parametrize("c", [30.0, 300.0, 3e3, 3e4, 1e6])
def test_known_motion_of_a_stiff_damper(c: float, settings: Any) -> None:
    """Steps are up to 1e5 time constants long. By linear adjoints estimates were up to 4e8 times the true errors."""
    for until in (1.0, 2.3):
        run = sr.simulate(dragged(c), until=until, store_steps=True, **settings)
        v = velocity(c, until)
        known = {
            "mass.x": position(c, until),
            "mass.velocity.x": v,
            "mass.acceleration.x": c * (np.sin(OMEGA * until) - v),
        }
        for name, exact in known.items():
            found = run.error(name)
            true = found.value - exact
            assert 0.3 < found.estimate / true < 3, (name, until, found.estimate, true)


@pytest.mark.parametrize("c", [300.0, 3e4, 1e6])
def test_responses_within_stiff_steps(c: float) -> None:
    """More stiff steps than are divided at once, and responses that share them."""
    run, times = sr.simulate(dragged(c), until=2.3, store_steps=True), (0.5, 1.0, 1.5, 2.0)
    misfit = sr.Misfit("mass.velocity.x", at=times, data=(0.0, 0.1, 0.2, 0.3))
    v = np.array([velocity(c, t) for t in times])
    known = {
        sr.Integral("mass.velocity.x"): position(c, 2.3),
        sr.At("mass.velocity.x", time=0.77): velocity(c, 0.77),
        misfit: 0.5 * np.sum((v - misfit.data) ** 2),
    }
    for found, exact in zip(run.error([*known]), known.values(), strict=True):
        assert 0.3 < found.estimate / (found.value - exact) < 3, found


def test_stiff_steps_of_several_stretches() -> None:
    """At 1 s the velocity is halved, which is forgotten at once."""
    c = 3e3
    slower = sr.Event(lambda t, q, v: t - 1.0, reset=lambda t, q, v: 0.5 * v)
    run = sr.simulate(dragged(c), until=2.3, store_steps=True, events=slower)
    assert isinstance(run.steps, Pieces)
    for t in (0.77, 1.8, 2.3):
        found = run.error(sr.At("mass.velocity.x", time=t))
        assert 0.3 < found.estimate / (found.value - velocity(c, t)) < 3, (t, found)


@pytest.mark.parametrize("time", [1e-3, 1e-6])
def test_a_fast_sensor(time: float) -> None:
    """A state that follows sin(ωt) m with a time constant of 1 µs; by linear adjoints it was off by a factor of -90."""
    body = sr.Body("mass", 1.0, (1e-3,) * 3, velocity=(OMEGA, 0, 0))
    rail = sr.Translational("rail", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(-1, 0, 0), body.point(0, 0, 0), k=OMEGA**2, length=1.0)
    sensor = sr.FirstOrderLag("sensor", input="rail.displacement", time=time)
    run = sr.simulate(sr.System(sr.Model("m", [body], [rail], [spring, sensor])), until=2.3, store_steps=True)
    phase, lag = OMEGA * 2.3, OMEGA * time
    exact = (np.sin(phase) - lag * np.cos(phase)) / (1 + lag**2)
    found = run.error("sensor")
    assert 0.8 < found.estimate / (found.value - exact) < 1.25, found


def door() -> sr.System:
    """A door on two hinges, whose constraints are redundant, pushed against a stiff closer."""
    body = sr.Body("door", 20.0, (2.0, 3.0, 1.0), position=(0.5, 0, 0))
    places = {"low": (0, 0, 0), "high": (0, 0, 1)}
    hinges = [sr.Revolute(name, sr.ground, body, point=at, axis=(0, 0, 1)) for name, at in places.items()]
    closer = sr.RSDA("closer", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1), k=0.0, c=2e4)
    push = sr.PointForce("push", body.point(0.5, 0, 0), (0, 1, 0), factor=lambda t: 2e4 * sin(OMEGA * t))
    return sr.System(sr.Model("door", [body], hinges, [closer, push]))


def blade() -> sr.System:
    """A blade that cannot move sideways, pulled through a viscous fluid: a nonholonomic constraint."""
    body = sr.Body("blade", 1.0, (0.1,) * 3)
    center = body.point(0, 0, 0)
    joints = [
        sr.Planar("plane", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.KnifeEdge("edge", body.point(0.1, 0, 0), axis=(0, 1, 0)),
    ]
    loads = [
        sr.ViscousDrag("drag", center, c=3e3, c_turn=1.0),
        sr.PointForce("pull", center, (1, 1, 0), factor=lambda t: 3e3 * sin(OMEGA * t)),
    ]
    return sr.System(sr.Model("blade", [body], joints, loads))


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (door, ["low.angle", "low.angle.rate"]),
        (blade, ["blade.x", "blade.y", "blade.velocity.x", "blade.velocity.y"]),
    ],
    ids=["redundant", "nonholonomic"],
)
def test_constrained_motions(make: Any, names: list[str]) -> None:
    run, exact = (
        sr.simulate(make(), until=1.2, store_steps=True, **given) for given in (LOOSE, {"rtol": 1e-11})
    )
    for found, name in zip(run.error(names), names, strict=True):
        true = found.value - float(exact[name][-1])
        assert 0.3 < found.estimate / true < 3, (name, found.estimate, true)


@pytest.mark.parametrize("c", [30.0, 3e4])
def test_the_adjoint_within_a_divided_step_is_exponential(c: float) -> None:
    """Of two steps at once, each with an adjoint of its own behind it."""
    run, halvings = sr.simulate(dragged(c), until=1.0, store_steps=True), 12
    steps, nq = run.steps, run.system.nq
    which, sizes = np.array([len(steps) - 3, len(steps) - 1]), (1.0, 2.0)
    after = np.zeros((2 * nq, 2))
    after[nq] = sizes
    divided = DividedSteps.of(run.system, steps, which, halvings)
    adjoints = divided.adjoints(np.array([0, 1]), after).reshape(2, halvings + 1, 2, 2 * nq, 2)
    lengths = divided.h.reshape(2, -1)
    for k, size in enumerate(sizes):
        before_end = np.cumsum(lengths[k, ::-1])[::-1]
        expected = size * np.exp(-c * before_end)
        np.testing.assert_allclose(adjoints[k, :, 0, nq, k], expected, atol=0.04 * size)
        assert lengths[k].sum() == pytest.approx(steps.h[which[k]])


def test_few_steps_are_divided(monkeypatch: pytest.MonkeyPatch) -> None:
    """None of a motion that is not stiff; of one with many stretches the few that matter most."""
    counts, divided = list[int](), stiff_steps.parts_in_errors

    def counting(system: sr.System, steps: Any, which: Any, *others: Any) -> Any:
        counts.append(len(which))
        return divided(system, steps, which, *others)

    monkeypatch.setattr(stiff_steps, "parts_in_errors", counting)
    sr.simulate(dragged(1.0), until=2.3, store_steps=True).error("mass.velocity.x")
    assert not counts
    run, names = sr.simulate(dragged(3e3), until=2.3, store_steps=True), ["mass.x", "mass.velocity.x"]
    run.error(names)
    assert 0 < sum(counts) <= stiff_steps.DIVIDED * stiff_steps.ROUNDS * len(names)


def on_a_pendulum(k: float, c: float) -> sr.System:
    """A mass that slides on a pendulum of 1 kg, in a stiff spring-damper along it, whose direction turns."""
    rod = sr.Body(
        "rod", 1.0, (0.1,) * 3, position=(0.5, 0, 0), velocity=(0, 1.5, 0), angular_velocity=(0, 0, 3)
    )
    mass = sr.Body(
        "mass", 1.0, (0.01,) * 3, position=(1, 0, 0), velocity=(0, 3, 0), angular_velocity=(0, 0, 3)
    )
    joints = [
        sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Translational("rail", rod, mass, point=(1, 0, 0), axis=(1, 0, 0)),
    ]
    spring = sr.TSDA("spring", rod.point(-0.5, 0, 0), mass.point(0, 0, 0), k=k, c=c, length=1.0)
    return sr.System(sr.Model("pendulum", [rod, mass], joints, [spring], gravity=(0, -9.81, 0)))


@pytest.mark.parametrize(("k", "c"), [(1e7, 1e5), pytest.param(1e8, 1e6, marks=pytest.mark.slow)])
def test_stiff_directions_that_turn(k: float, c: float) -> None:
    """By linear adjoints estimates were up to 16,000 times the true errors."""
    system = on_a_pendulum(k, c)
    runs = (sr.simulate(system, until=1.0, store_steps=True, **given) for given in ({}, {"rtol": 1e-11}))
    responses = ["mass.velocity.x", "pin.angle.rate", sr.Peak("pin.force.x"), sr.Integral("energy.kinetic")]
    for found, exact in zip(*(run.error(responses) for run in runs), strict=True):
        true = found.value - exact.value
        assert 0.1 < found.error / abs(true) < 50, (found, true)  # some true errors are small by chance


def test_a_few_stiff_steps_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of short runs all steps are filtered at once, at states that are known: as some steps at a time."""
    run = sr.simulate(on_a_pendulum(1e7, 1e5), until=1.0, store_steps=True)
    together, read = run.error("pin.angle.rate"), list[bool]()
    assert run.nsteps < stiff_steps.FEW

    def recorded(*args: Any) -> Any:
        read.append(args[-1] is not None)
        return whole_steps(*args)

    monkeypatch.setattr(stiff_steps, "whole_steps", recorded)
    assert run.error("pin.angle.rate") == together
    for module in (stiff_steps, defect):
        monkeypatch.setattr(module, "FEW", 0)
    monkeypatch.setattr(defect, "_jumps", lambda *_: True)
    assert run.error("pin.angle.rate").error == pytest.approx(together.error, rel=1e-9)
    assert read == [True, False, False]


def test_stiff_damper_by_a_method_of_order_two() -> None:
    """By linear adjoints the estimate was 31 times the error."""
    system = on_a_pendulum(0.0, 1e6)
    given = [{"method": sr.HHT()}, {"rtol": 1e-9}]
    run, exact = (sr.simulate(system, until=1.0, store_steps=True, **one) for one in given)
    true = run["pin.angle"][-1] - exact["pin.angle"][-1]
    found = run.error("pin.angle")
    assert 0.3 < found.estimate / true < 3, (found, true)
