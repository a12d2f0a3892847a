"""A length whose ends pass through each other: its force reverses at once, where a step ends."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints

import sarrus as sr
from sarrus.analyses.dynamics.events.force_corners import ForceCorners
from sarrus.analyses.dynamics.stepping.nodes import Nodes
from sarrus.results import Segments

T, SPEED, FREE = 0.3, 5.0, 0.5


def guided(
    kind: str, k: float = 20.0, aside: float = 0.0, rail: bool = True, speed: float = SPEED
) -> sr.System:
    """A mass that moves along x through the anchor of its spring, or beside it."""
    at = (-0.4, aside, 0)
    body = sr.Body("b", mass=1.0, inertia=(0.1,) * 3, position=at, velocity=(speed, 0, 0))
    ends = sr.ground.point(0, 0, 0), body.point(0, 0, 0)
    law = {"value": "-k*(x - 0.5)", "parameters": {"k": k}}
    forces: dict[str, Any] = {
        "tsda": lambda: sr.TSDA("s", *ends, k=k, length=FREE),
        "curve": lambda: sr.TSDA("s", *ends, k=lambda x: k + 0 * x, length=FREE),
        "force": lambda: sr.Force("s", *ends, **law),
        "tendon": lambda: sr.Tendon("s", list(ends), **law),
    }
    slide = sr.Translational("g", sr.ground, body, point=at, axis=(1, 0, 0))
    return sr.System(sr.Model("m", [body], [slide] if rail else [], [forces[kind]()], gravity=(0, 0, 0)))


def closed_form(k: complex) -> complex:
    """x at T: a harmonic motion about -0.5 up to x = 0, then about 0.5."""
    w = np.sqrt(k)
    t: complex = 0.08
    for _ in range(50):
        x = -FREE + 0.1 * np.cos(w * t) + SPEED / w * np.sin(w * t)
        u = -0.1 * w * np.sin(w * t) + SPEED * np.cos(w * t)
        t -= x / u
    u = -0.1 * w * np.sin(w * t) + SPEED * np.cos(w * t)
    return complex(FREE - FREE * np.cos(w * (T - t)) + u / w * np.sin(w * (T - t)))


def slope(k: float) -> float:
    return closed_form(k + 1e-30j).imag / 1e-30


BEND = (slope(20 + 1e-2) - slope(20 - 1e-2)) / 2e-2
METHODS: dict[str, tuple[dict[str, Any], float]] = {
    "default": ({}, 1e-7),
    "fine": ({"rtol": 1e-10}, 1e-7),
    "Radau": ({"method": sr.Radau(), "rtol": 1e-4}, 1e-3),
    "HHT": ({"method": sr.HHT()}, 2e-3),
}


@pytest.mark.parametrize(
    "method", [pytest.param(name, marks=[] if name == "default" else pytest.mark.slow) for name in METHODS]
)
@pytest.mark.parametrize("kind", ["tsda", "curve", "force", "tendon"])
def test_derivatives_are_those_of_the_closed_form(kind: str, method: str) -> None:
    settings, error = METHODS[method]
    system = guided(kind)
    run = sr.simulate(system, until=T, store_steps=True, **settings)
    (name,) = [n for n in ("s.k", "s.parameters.k") if ("parameters" in n) == (kind in ("force", "tendon"))]
    if kind == "curve":
        name = "b.velocity.x"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = sr.sensitivity(run, sr.Final("b.x"), [name]).matrix[0, 0]
    if kind != "curve":
        assert found == pytest.approx(slope(20), rel=error)
        bend = float(np.ravel(sr.hessian(run, sr.Final("b.x"), [name]).matrix)[0])
        assert bend == pytest.approx(BEND, abs=0.01 * abs(slope(20)) / 20)
    else:
        other = sr.simulate(guided("tsda"), until=T, store_steps=True, **settings)
        assert found == pytest.approx(sr.sensitivity(other, sr.Final("b.x"), [name]).matrix[0, 0], rel=1e-6)


def test_second_derivatives_by_the_speed() -> None:
    """A step that ended too near to where the length vanishes gave them an error of 10 %."""
    names, response, h = ["s.k", "b.velocity.x"], sr.Final("b.x"), 1e-3
    settings: dict[str, Any] = {"until": T, "store_steps": True, "method": sr.Radau(), "rtol": 1e-8}
    found = sr.hessian(sr.simulate(guided("tsda"), **settings), response, names).matrix
    slopes = [
        sr.sensitivity(sr.simulate(guided("tsda", speed=SPEED + d), **settings), response, names).matrix[0]
        for d in (h, -h)
    ]
    np.testing.assert_allclose(found[1], (slopes[0] - slopes[1]) / (2 * h), rtol=2e-3)


def test_the_integral_of_the_length() -> None:
    """∫ |x| dt, whose derivative is that of the closed form's integral."""
    times = np.linspace(0, T, 4001)

    def integral(k: float) -> float:
        run = sr.simulate(guided("tsda", k), until=T, rtol=1e-12, t_eval=times)
        return float(np.trapezoid(abs(run["b"].position[:, 0]), times))

    run = sr.simulate(guided("tsda"), until=T, store_steps=True)
    found = sr.sensitivity(run, sr.Integral("s.length"), ["s.k"]).matrix[0, 0]
    assert found == pytest.approx((integral(21) - integral(19)) / 2, rel=5e-3)


def hung(force: float = 10.0, speed: float = 4.0) -> sr.System:
    """A mass below an anchor, in gravity, that a constant force draws to the anchor from both sides."""
    body = sr.Body("b", mass=1.0, inertia=(0.1,) * 3, position=(0, 0, -0.4), velocity=(0, 0, speed))
    rail = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    law: dict[str, Any] = {"value": "-F", "parameters": {"F": force}}
    drawn = sr.Force("s", sr.ground.point(0, 0, 0), body.point(0, 0, 0), **law)
    return sr.System(sr.Model("m", [body], [rail], [drawn], gravity=(0, 0, -2)))


def height(force: float, speed: float, end: float) -> float:
    """Its height: parabolas from one crossing to the next."""
    t, z, u, side = 0.0, -0.4, speed, -1
    while True:
        a = -2 - side * force
        passage = (-u - side * np.sqrt(u * u - 2 * a * z)) / a
        if t + passage > end:
            return z + u * (end - t) + a / 2 * (end - t) ** 2
        t, z, u, side = t + passage, 0.0, u + a * passage, -side


@pytest.mark.one_in(4)
@pytest.mark.parametrize("speed", [4.0, 5.0, 6.0])
@pytest.mark.parametrize("end", [2.0, 4.0])
def test_a_crossing_in_the_steps_that_pass_the_greatest_length(speed: float, end: float) -> None:
    """The rate of |d|² changes its sign at the greatest length, too, which hid the crossing behind it.

    Steps that were short before a crossing, at the end of those that are looked at together, were not taken again.
    """
    run, names = sr.simulate(hung(speed=speed), until=end, store_steps=True), ["s.parameters.F"]
    found = sr.sensitivity(run, sr.Final("b.z"), names).matrix[0, 0]
    slope = (height(10 + 1e-5, speed, end) - height(10 - 1e-5, speed, end)) / 2e-5
    assert run["b.z"][-1] == pytest.approx(height(10, speed, end), abs=1e-9)
    assert found == pytest.approx(slope, rel=1e-5)
    second, before, here, after = (
        sr.hessian(run, sr.Final("b.z"), names),
        *(height(10 + change, speed, end) for change in (-3e-3, 0.0, 3e-3)),
    )
    assert second.matrix[0, 0] == pytest.approx((after - 2 * here + before) / 9e-6, rel=1e-4)
    steps = run.steps
    assert isinstance(steps, Segments)
    assert all(segment.h[-1] > 1e-4 for segment in steps.segments)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("rtol", [None, 1e-12])
def test_states_and_estimates_over_many_crossings(rtol: float | None) -> None:
    """The force on the wrong side of a crossing changes the speed, by 1e-9 if ends meet at constant speed."""
    end, times = 8.0, np.linspace(0, 8, 401)
    settings: dict[str, Any] = {} if rtol is None else {"rtol": rtol}
    run = sr.simulate(hung(speed=5.0), until=end, store_steps=True, t_eval=times, **settings)
    heights = [height(10, 5.0, t) for t in times]
    np.testing.assert_allclose(run["b.z"], heights, atol=1e-12)
    assert abs(run["b.z"][-1] - heights[-1]) < 5 * run.error("b.z").error
    response, names, slopes = sr.Final("b.z"), ["s.parameters.F"], list[float]()
    for force in (10 - 1e-4, 10, 10 + 1e-4):
        slopes.append((height(force + 1e-5, 5.0, end) - height(force - 1e-5, 5.0, end)) / 2e-5)
    for method in ("direct", "adjoint"):
        found = sr.sensitivity(run, response, names, method=method).matrix[0, 0]
        assert found == pytest.approx(slopes[1], rel=1e-5)
    bend = float(np.ravel(sr.hessian(run, response, names).matrix)[0])
    assert bend == pytest.approx((slopes[2] - slopes[0]) / 2e-4, rel=1e-3)
    long = by_checkpoints(hung(speed=5.0), response, names, until=end, memory=1e6, **settings)
    assert long.values[0] == pytest.approx(run["b.z"][-1], abs=1e-12)
    assert long.matrix[0, 0] == pytest.approx(found, rel=1e-9)


@pytest.mark.parametrize("terminal", [False, True])
def test_an_event_where_the_ends_meet(terminal: bool) -> None:
    """It lies between the end of one step and the begin of the next one, and was missed."""
    meets = sr.Event("b.z", direction=1, terminal=terminal, name="meets")
    run = sr.simulate(hung(speed=5.0), until=0.5, store_steps=True, events=meets)
    (event,) = run.events
    exact = (np.sqrt(25 + 2 * 8 * 0.4) - 5) / 8
    assert event.t == pytest.approx(exact, abs=1e-11)
    if terminal:
        assert run.t[-1] <= event.t
        slope = sr.sensitivity(run, sr.AtEvent("t", event="meets"), ["s.parameters.F"]).matrix[0, 0]
        assert slope == pytest.approx(0.4 / np.sqrt(25 + 6.4) / 8 - exact / 8, rel=1e-5)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("free", [0.1, 0.3])
@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
def test_the_error_of_a_run_through_a_length_is_estimated(free: float, rtol: float) -> None:
    """A mass at rest that swings through the anchor of its spring 13 times: harmonic on each side."""
    body = sr.Body("b", mass=1.0, inertia=(0.1,) * 3, position=(-1, 0, 0))
    rail = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=20.0, length=free)
    system = sr.System(sr.Model("m", [body], [rail], [spring], gravity=(0, 0, 0)))
    run = sr.simulate(system, until=10.0, store_steps=True, rtol=rtol)
    quarter = np.arccos(-free / (1 - free))
    phase = np.sqrt(20) * 10.0 % (4 * quarter)
    side = -1 if phase <= 2 * quarter else 1
    phase -= 0 if side < 0 else 2 * quarter
    near = phase < quarter
    within = phase if near else 2 * quarter - phase
    truth = side * (1 if near else -1) * (free + (1 - free) * np.cos(within))
    wrong = abs(run["b.x"][-1] - truth)
    assert wrong < 5 * run.error("b.x").error


def test_the_end_of_a_tendon_on_a_circle_through_its_anchor() -> None:
    """A tendon over a cylinder that it leaves; the sense of its winding changes where the ends meet."""

    def swung(k: float = 20.0, **settings: Any) -> sr.Trajectory:
        body = sr.Body("a", mass=1.0, inertia=(0.1,) * 3, position=(0.5, 0, 0))
        pin = sr.Revolute("A", sr.ground, body, point=(0, 0, 0), axis=(0, 1, 0))
        ends = [sr.ground.point(-0.5, 0, 0.02), body.point(0, 0, 0.02)]
        wrap = sr.Wrap(sr.ground.point(0, 0, 0), 0.1, axis=(0, 1, 0), side=sr.ground.point(0, 0, 0.4))
        law = {"value": "-k*(x - 0.5)", "parameters": {"k": k}}
        tendon = sr.Tendon("t", ends, around=[wrap], **law)
        model = sr.Model("m", [body], [pin], [tendon], gravity=(0, 0, 0))
        return sr.simulate(sr.System(model), until=1.8, **settings)

    found = sr.sensitivity(swung(store_steps=True), sr.Final("A.angle"), ["t.parameters.k"]).matrix[0, 0]
    ends = [swung(k, rtol=1e-12)["A.angle"][-1] for k in (20.1, 19.9)]
    assert found == pytest.approx((ends[0] - ends[1]) / 0.2, rel=1e-3)


@pytest.mark.parametrize("speed", [SPEED, 6.0])
@pytest.mark.parametrize("aside", [1e-12, 1e-11])
def test_ends_that_meet_but_for_round_off(aside: float, speed: float) -> None:
    names, found = ["s.k", "s.length", "b.velocity.x", "b.position.x"], list[np.ndarray]()
    for distance in (aside, 0.0):
        run = sr.simulate(guided("tsda", aside=distance, speed=speed), until=T, store_steps=True)
        gradient = sr.sensitivity(run, sr.Final("b.x"), names)
        found.append(gradient.matrix[0])
        assert not gradient.warnings
    assert found[0] == pytest.approx(found[1], rel=1e-4)


@pytest.mark.slow
def test_crossings_that_accumulate_are_passed() -> None:
    """A constant force and damping: 1000 crossings, each with steps of its own, took 12 s."""
    body = sr.Body("b", mass=1.0, inertia=(0.1,) * 3, position=(-0.4, 0, 0), velocity=(5, 0, 0))
    rail = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    drawn = sr.Force("s", sr.ground.point(0, 0, 0), body.point(0, 0, 0), value="-10")
    damper = sr.Force("d", joint="g", value="-3*b.velocity.x")
    system = sr.System(sr.Model("m", [body], [rail], [drawn, damper], gravity=(0, 0, 0)))
    with pytest.warns(sr.SarrusWarning, match="s: switches of its force crowd at t = "):
        run = sr.simulate(system, until=5.5, store_steps=True)
    assert run.success
    assert len(run.steps.event_steps) == 201


@pytest.mark.parametrize("aside", [1e-4, 1e-2])
def test_ends_that_pass_beside_each_other_are_resolved(aside: float) -> None:
    run = sr.simulate(guided("tsda", aside=aside), until=T, store_steps=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = sr.sensitivity(run, sr.Final("b.x"), ["s.k"]).matrix[0, 0]
    ends = [
        sr.simulate(guided("tsda", k, aside), until=T, rtol=1e-12)["b"].position[-1, 0] for k in (20.1, 19.9)
    ]
    assert found == pytest.approx((ends[0] - ends[1]) / 0.2, rel=1e-4)


@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()])
def test_ends_that_are_far_from_each_other_are_not_looked_at_within_steps(
    method: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Steps are the same if all are looked at: of ends that meet, pass beside each other, or stay away."""
    far, looked = ForceCorners.are_far, list[bool]()

    def noted(self: ForceCorners, nodes: Nodes, b: np.ndarray) -> bool:
        looked.append(far(self, nodes, b))
        return looked[-1]

    given: dict[str, Any] = {"until": 2.0, "method": method, "store_steps": True}
    given |= {"rtol": 1e-11} if isinstance(method, sr.Radau) else {}  # more steps between the ends' meetings
    for aside, some in ((0.0, True), (1e-3, True), (3.0, False)):
        system = guided("tsda", aside=aside)
        monkeypatch.setattr(ForceCorners, "are_far", noted)
        run = sr.simulate(system, **given)
        monkeypatch.setattr(ForceCorners, "are_far", lambda *_: False)
        every = sr.simulate(system, **given)
        assert run.steps is not None
        assert every.steps is not None
        np.testing.assert_array_equal(run.steps.t, every.steps.t)
        assert any(looked)
        assert some != all(looked)
        looked.clear()
