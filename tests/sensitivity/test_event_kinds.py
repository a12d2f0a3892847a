"""Every kind of event that a simulation takes: forward, backward, and differences of runs with the same steps."""

import warnings
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.sensitivity.frozen_segments import at, differenced, solved
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.responses.responses import Response
from sarrus.model.written import with_numbers

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly

X = 7 * [body.name for body in sr.load(mechanisms.path("slider_crank")).bodies].index("slider")
EXAMPLES = Path(__file__).parents[2] / "examples"
NUMBERS = ["rod.mass", "spring.k", "pin.point.y", "ball.point.z", "crank.angular_velocity.x", "gravity.z"]
RESPONSES = [  # at times near to which no step ends, as it would pass them where parameters change
    sr.Final("slider.x"),
    sr.Final("pin.angle.rate"),
    sr.At("slider.velocity.x", time=0.29),
    sr.At("rod.acceleration.y", time=0.22),
    sr.Final("pin.force.z"),
    sr.Integral(lambda o: o.t * o("energy.kinetic"), name="integral"),
    sr.Maximum("slider.velocity.x"),
    sr.Maximum("pin.angle"),
]
WHEN = "pin.angle + slider.x - 4.4"


def slowed(t, q, v):
    """Other velocities, not on the constraints: they are projected."""
    after = -0.4 * v
    after[X] = -0.7 * v[X] + 0.1 * q[X] * np.cos(3 * t)
    return after


def passed(t, q, v):
    """The slider's place, and the speed of its coming."""
    return q[X] + 0.3 * v[X] ** 2 - 4.45 + 0.2 * np.sin(t)


EVENTS = {
    "formula": sr.Event(WHEN, direction=1, reset=sr.Impact(0.5, along="pin.angle"), name="hit"),
    "formula of time": sr.Event(
        "slider.x - 4.34 + 0.3*t", reset=sr.Impact(0.2, along="slider.x + 0.1*t*slider.x^2"), name="hit"
    ),
    "function": sr.Event(passed, reset=sr.Impact(0.5, along="pin.angle"), name="hit"),
    "velocities by a function": sr.Event(WHEN, direction=1, reset=slowed, name="hit"),
    "both functions": sr.Event(passed, reset=slowed, name="hit"),
    "function that ends": sr.Event(passed, terminal=True, name="hit"),
}


@cache
def run(kind: str, method: object = sr.Radau()) -> sr.Trajectory:
    settings = {"store": "steps", "method": replace(method, rtol=1e-7, atol=1e-9), "t_eval": [0.4]}
    found = sr.simulate(slider_crank(), until=0.4, events=EVENTS[kind], **settings)
    assert len(found.events) == 1
    return solved(found, method, EVENTS[kind])


def responses(kind: str) -> list[Response]:
    """For the run that ends early none behind its end, but the time of it."""
    early = [one for one in RESPONSES if getattr(one, "time", 0.0) < 0.25]
    return [*early, sr.Final("t")] if kind.endswith("ends") else RESPONSES


def names(kind: str) -> list[str]:
    return [*NUMBERS, "hit.restitution"] if isinstance(EVENTS[kind].reset, sr.Impact) else NUMBERS


@cache
def gradient(kind: str, method: str = "adjoint") -> sr.Gradient:
    return sr.sensitivity(run(kind), responses(kind), names(kind), method=method)


def moved(kind: str, changes: dict[str, float]) -> tuple[sr.System, sr.Event]:
    """Another model, or another restitution."""
    changes, event = dict(changes), EVENTS[kind]
    e = changes.pop("hit.restitution", None)
    if e is not None:
        reset = sr.Impact(e, along=event.reset.along)
        event = sr.Event(event.function, direction=event.direction, reset=reset, name="hit")
    return sr.System(with_numbers(slider_crank().model, changes)), event


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", EVENTS)
def test_forward_and_backward_agree(kind: str) -> None:
    found, direct = gradient(kind), gradient(kind, "direct")
    scale = abs(found.matrix).max(axis=1, keepdims=True)
    assert np.all(scale > 0)
    assert np.all(abs(direct.matrix - found.matrix) < 1e-11 * scale)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kind", EVENTS)
def test_gradients_are_those_of_differenced_simulations(kind: str) -> None:
    found = gradient(kind)
    scale = abs(found.matrix).max(axis=1)
    for name, value in zip(found.names, found.at, strict=True):
        wanted = differenced(
            run(kind), responses(kind), sr.Radau(), 1e-3, lambda e, n=name, x=value: moved(kind, {n: x + e})
        )
        assert np.all(abs(found[name] - wanted) < 2e-8 * scale), (name, (found[name] - wanted) / scale)


ROUND_OFF = {
    "velocity": 3e-6,
    "rate": 3e-6,
    "acceleration": 2e-5,
    "force": 2e-5,
    "maximum of pin.angle": 1e-7,  # at the event, in a step whose positions are only near the constraints
}  # over h², over a number's change


@pytest.mark.slow
@pytest.mark.parametrize("method", [sr.HHT(step=2.01e-3), sr.GeneralizedAlpha(0.7, step=5e-3)])
@pytest.mark.parametrize("kind", ["formula", "both functions"])
def test_so_are_those_of_methods_of_order_two(kind: str, method: object) -> None:
    """Also in the long steps of such a method, at whose events states are put onto the constraints."""
    told = [*responses(kind), sr.Maximum("pin.force.z"), sr.Integral("slider.acceleration.x")]
    chosen = ["spring.k", "ball.point.z", "crank.angular_velocity.x"]
    stopped = run(kind, method)
    found = sr.sensitivity(stopped, told, chosen)
    scale = abs(found.matrix).max(axis=1)
    limits = np.array([max([5e-9, *(x for k, x in ROUND_OFF.items() if k in one.title)]) for one in told])
    for name, value in zip(found.names, found.at, strict=True):
        wanted = [  # now and then one of them has a hundred times the round-off of the others
            differenced(stopped, told, method, size, lambda e, n=name, x=value: moved(kind, {n: x + e}))
            for size in (1e-3, 4e-3, 8e-3)  # an extreme at an event has other samples farther away
        ]
        errors = np.min(abs(found[name] - np.array(wanted)), axis=0)
        assert np.all(errors < limits * scale), (name, errors / scale)


def test_what_a_gradient_leaves_falls_with_the_square() -> None:
    """Taylor's remainder with all numbers changed at once, the restitution too."""
    kind, found = "formula", gradient("formula")
    change, rest = np.random.default_rng(3).normal(size=len(found.names)) * 0.1, []
    for size in (1e-2, 5e-3, 2.5e-3):
        there = moved(kind, dict(zip(found.names, found.at + size * change, strict=True)))
        rest.append(at(run(kind), RESPONSES, sr.Radau(), there) - found.values - size * found.matrix @ change)
    slopes = np.log2(abs(np.array(rest[:-1]) / np.array(rest[1:])))
    assert np.all(abs(slopes - 2) < 0.1), slopes


def test_all_numbers_of_the_model() -> None:
    found = [sr.sensitivity(run("both functions"), RESPONSES, method=way) for way in ("adjoint", "direct")]
    assert len(found[0].names) == len(Parameters(slider_crank()).names)
    scale = abs(found[0].matrix).max(axis=1, keepdims=True)
    assert np.all(abs(found[0].matrix - found[1].matrix) < 1e-10 * scale)


TIP = "tip.y + 0.2*t*tip.x^2 + 1.2"
STRUCK = sr.Event(TIP, direction=-1, reset=sr.Impact(0.6, along="tip.x + 0.4*t*tip.y"), name="struck")


def two_links(**changes: float) -> sr.System:
    """Two links that fall: with two freedoms the direction of an impulse counts, and two impacts follow each other."""
    link, tip = (
        sr.Body(name, mass=1, inertia=(0.1, 0.1, 0.1), position=(x, 0, 0))
        for name, x in (("link", 0.5), ("tip", 1.5))
    )
    axis = (0, 0, 1)
    pin = sr.Revolute("pin", sr.ground, link, point=(0, 0, 0), axis=axis)
    elbow = sr.Revolute("elbow", link, tip, point=(1, 0, 0), axis=axis)
    model = sr.Model("links", bodies=[link, tip], joints=[pin, elbow], gravity=(0, -9.81, 0))
    return sr.System(with_numbers(model, changes))


@pytest.mark.slow
def test_two_impacts_whose_direction_and_place_change_with_time() -> None:
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-7, atol=1e-9), "t_eval": [1.7]}
    fall = sr.simulate(two_links(), until=1.7, events=STRUCK, **settings)
    assert len(fall.events) == 2
    fall = solved(fall, sr.Radau(), STRUCK)
    told = [
        sr.Final("tip.x"),
        sr.Final("tip.y"),
        sr.Final("link.velocity.x"),
        sr.Integral(lambda o: o.t * o("tip.x")),
    ]
    names = ["link.mass", "tip.position.x", "gravity.y", "pin.point.y"]
    found, direct = (sr.sensitivity(fall, told, names, method=way) for way in ("adjoint", "direct"))
    scale = abs(found.matrix).max(axis=1)
    assert np.all(abs(found.matrix - direct.matrix).T < 1e-11 * scale)
    for name, x in zip(names, found.at, strict=True):
        wanted = differenced(
            fall, told, sr.Radau(), 1e-3, lambda e, n=name, x=x: (two_links(**{n: x + e}), STRUCK)
        )
        assert np.all(abs(found[name] - wanted) < 2e-8 * scale), (name, (found[name] - wanted) / scale)


FORCE = [[0, 1], [0.3, 2], [0.5, 1.5], [0.8, 2], [2.5, 0.5]]


def driven(changes: dict[str, float]) -> sr.System:
    """A motor turns the first of two links by a formula of time, at the second one pulls a table over time."""
    link, tip = (
        sr.Body(name, mass=m, inertia=(0.1, 0.2, 0.3), position=(x, 0, 0))
        for name, m, x in (("link", 1, 0.5), ("tip", 0.7, 1.5))
    )
    axis = (0, 0, 1)
    pin = sr.Revolute("pin", sr.ground, link, point=(0, 0, 0), axis=axis)
    elbow = sr.Revolute("elbow", link, tip, point=(1, 0, 0), axis=axis)
    motor = sr.AngleDriver("motor", "pin.angle", "0.4*t + 0.3*sin(3*t)**2")
    load = sr.PointForce("load", tip.point(0.2, 0, 0), force=(1, 2, 3), factor=FORCE)
    model = sr.Model(
        "driven", [link, tip], [pin, elbow], drivers=[motor], forces=[load], gravity=(0, -9.81, 0)
    )
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*spline through the table")  # it overshoots
        return sr.System(with_numbers(model, changes))


ELBOW = sr.Event("elbow.angle + 0.6", direction=-1, reset=sr.Impact(0.7, along="elbow.angle"), name="stop")
DRIVEN = ["motor.motion.1", "motor.motion.3", "load.factor.3.y", "tip.mass", "gravity.y", "elbow.point.x"]
TOLD = [
    sr.Final("tip.x"), sr.Final("elbow.angle.rate"), sr.At("tip.acceleration.y", time=0.7015),
    sr.Final("elbow.force.x"),
    sr.Integral("motor.multiplier.1"), sr.Integral(lambda o: o.t * o("tip.velocity.y") ** 2, name="weighted"),
]  # fmt: skip


@cache
def precise() -> np.ndarray:
    """The gradients of the driven links to more digits than the methods of order two have."""
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-9, atol=1e-11), "t_eval": [2.2]}
    return sr.sensitivity(sr.simulate(driven({}), until=2.2, events=ELBOW, **settings), TOLD, DRIVEN).matrix


@pytest.mark.slow
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT(), sr.GeneralizedAlpha(0.8)])
def test_motions_and_forces_that_depend_on_time(method: object) -> None:
    """After a stop that comes sooner they act elsewhere in the motion."""
    settings = {"store": "steps", "method": replace(method, rtol=1e-7, atol=1e-9), "t_eval": [2.2]}
    run = sr.simulate(driven({}), until=2.2, events=ELBOW, **settings)
    assert len(run.events) >= 2, run.events
    run = solved(run, method, ELBOW)
    found, direct = (sr.sensitivity(run, TOLD, DRIVEN, method=way) for way in ("adjoint", "direct"))
    scale = abs(found.matrix).max(axis=1)
    limit = 1e-11 if isinstance(method, sr.Radau) else 2e-9  # round-off of accelerations over short steps
    assert np.all(abs(found.matrix - direct.matrix).T < limit * scale)
    near = (
        np.full(6, 1e-4) if isinstance(method, sr.Radau) else np.array([1e-3, 1e-3, 2e-2, 5e-3, 1e-3, 1e-3])
    )
    assert np.all(abs(found.matrix - precise()).T < near * scale)
    known = 2e-9 if isinstance(method, sr.Radau) else np.array([1e-8, 1e-6, 1e-4, 1e-4, 1e-5, 1e-7])
    for name, x in zip(found.names, found.at, strict=True):
        wanted = differenced(run, TOLD, method, 3e-4, lambda e, n=name, x=x: (driven({n: x + e}), ELBOW))
        assert np.all(abs(found[name] - wanted) < known * scale), (name, (found[name] - wanted) / scale)


def test_an_impact_in_a_linkage_with_equations_that_others_imply() -> None:
    system = sr.System(sr.load(EXAMPLES / "bricard.yaml"))
    hit = sr.Event("rod_1.z + 0.062", direction=-1, reset=sr.Impact(0.5), name="hit")
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-6, atol=1e-8), "t_eval": [0.6]}
    run = solved(sr.simulate(system, until=0.6, events=hit, **settings), sr.Radau(), hit)
    assert len(run.events) == 1
    assert np.any(run.steps.segments[1].left_out)
    told, names = (
        [sr.Final("rod_1.x"), sr.Integral("energy.kinetic")],
        ["rod_1.mass", "gravity.z", "hit.restitution"],
    )
    found, direct = (sr.sensitivity(run, told, names, method=way).matrix for way in ("adjoint", "direct"))
    assert direct == pytest.approx(found, abs=1e-12)
    for n, name in enumerate(names[:2]):
        at = Parameters(system, [name]).values[0]
        wanted = differenced(
            run,
            told,
            sr.Radau(),
            1e-3,
            lambda e, x=at, n=name: (sr.System(with_numbers(system.model, {n: x + e})), hit),
        )
        assert found[:, n] == pytest.approx(wanted, abs=1e-8 * abs(found).max())


def test_an_event_counts_the_turns_of_an_angle() -> None:
    """A formula that is not linear in the angle has other slopes a turn later."""
    wound = sr.Event("pin.angle^2 + 20*slider.x - 98", direction=-1, terminal=True, name="wound")
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-7, atol=1e-9), "t_eval": [0.0]}
    found = sr.simulate(slider_crank(), until=3.0, events=wound, **settings)
    told, name = [sr.AtEvent("t", event="wound")], "ball.point.z"
    gradient = sr.sensitivity(found, told, [name])

    def ended(change: float) -> float:
        moved = sr.System(with_numbers(slider_crank().model, {name: gradient.at[0] + change}))
        return sr.simulate(moved, until=3.0, events=wound, **settings).events[0].t

    q = found.events[0].q
    assert found.system.joint("pin").angle(q) ** 2 + 20 * q[X] < 97
    assert gradient[name] == pytest.approx((ended(1e-3) - ended(-1e-3)) / 2e-3, rel=1e-3)


def halted_in_place(t, q, v):
    """The array that it is given is overwritten."""
    v *= -0.4
    return v


def halted_in_part(t, q, v):
    v[X] = 0.0
    return v


@pytest.mark.parametrize(
    ("own", "other"),
    [
        (halted_in_place, lambda t, q, v: -0.4 * v),
        (halted_in_part, lambda t, q, v: np.where(np.arange(len(v)) == X, 0.0 * v, v)),
    ],
)
def test_velocities_overwritten_in_place(own: object, other: object) -> None:
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-7, atol=1e-9), "t_eval": [0.4]}
    found = []
    for reset in (own, other):
        event = sr.Event(WHEN, direction=1, reset=reset, name="hit")
        there = sr.simulate(slider_crank(), until=0.4, events=event, **settings)
        found.append(sr.sensitivity(there, RESPONSES, NUMBERS).matrix)
    assert np.allclose(found[0], found[1], rtol=1e-12, atol=0)


def test_a_function_that_cannot_be_recorded_is_named() -> None:
    def looked_up(t, q, v):
        return passed({float: t}[type(t)], q, v)

    event = sr.Event(looked_up, terminal=True, name="hit")
    settings = {"store": "steps", "method": sr.Radau(), "t_eval": [0.0]}
    there = sr.simulate(slider_crank(), until=0.4, events=event, **settings)
    with pytest.raises(ValueError, match="cannot be differentiated through its Python function"):
        sr.sensitivity(there, sr.Final("t"), ["rod.mass"])
