"""Hessians over events: closed forms, symmetry, and differences of gradients of runs with the same steps."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.sensitivity import frozen_segments
from tests.sensitivity import test_event_kinds as kinds
from tests.sensitivity import test_events as events
from tests.sensitivity.test_references import FOLDER

import sarrus as sr
from sarrus.analyses.sensitivity.derivatives import differentiated
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.model.written import with_numbers

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly
METHODS = {"HHT": sr.HHT(), "Radau": sr.Radau()}
LIMIT = 2e-7  # round-off of differences
# By methods of order two: the time of the maximum of a velocity depends on accelerations, whose round-off over h² is
# left in gradients, and so in their differences: 7e-5 by a step of 1e-3, 2e-6 by one of 1e-2
OF_EXTREMES = 1e-4


def differenced(run, responses, names, method, moved, direction, size=4e-3):
    """Richardson's extrapolation of differences of gradients along a direction (r, p)."""
    at = Parameters(run.system, names, restitutions=run.restitutions).values

    def gradient(e: float) -> np.ndarray:
        system, event = moved(dict(zip(names, at + e * direction, strict=True)))
        steps = frozen_segments.again(system, run, method, event)
        e_own = {name: float(event.reset.restitution) for name in run.restitutions}
        parameters = Parameters(system, names, start=steps.start, restitutions=e_own)
        return differentiated(system, steps, responses, parameters).matrix

    slopes = [(gradient(e) - gradient(-e)) / (2 * e) for e in (size, size / 2)]
    return (4 * slopes[1] - slopes[0]) / 3


@pytest.mark.one_in(8)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", range(4))
def test_the_bouncing_ball(case: int, method: str) -> None:
    told = json.loads((FOLDER / "S10_bouncing_ball.json").read_text())["cases"][case]
    run = events.bounced(float(told["T"]), method=METHODS[method])
    chosen = [n for n, name in enumerate(events.BALL) if told["n_impacts"] or name != "e"]
    names = [list(events.BALL)[n] for n in chosen]
    sign = np.array([events.SIGN.get(name, 1.0) for name in names])
    wanted = np.array(told["hess"], dtype=float)[np.ix_(chosen, chosen)] * np.outer(sign, sign)
    found = sr.hessian(run, sr.Final("ball.z"), [events.BALL[name] for name in names])
    assert found.matrix == pytest.approx(wanted, abs=1e-10)
    assert found.asymmetry < 1e-13 or not wanted.any()


@pytest.mark.slow
@pytest.mark.parametrize("kind", kinds.EVENTS)
def test_every_kind_of_event(kind: str) -> None:
    run, responses, names = kinds.run(kind), kinds.responses(kind), kinds.names(kind)
    direction = np.random.default_rng(5).normal(size=len(names)) * np.linspace(0.2, 1, len(names))
    wanted = differenced(
        run, responses, names, sr.Radau(), lambda changes: kinds.moved(kind, changes), direction
    )
    for response, row in zip(responses, wanted, strict=True):
        found = sr.hessian(run, response, names)
        assert found.asymmetry < 3e-9, response.title  # stages are solved to 1e-11, rates are theirs over h
        assert found.matrix @ direction == pytest.approx(row, rel=0, abs=LIMIT * abs(row).max()), (
            response.title
        )


@pytest.mark.slow
@pytest.mark.parametrize("method", [sr.HHT(step=2.02e-3), sr.GeneralizedAlpha(0.7, step=5e-3)])
@pytest.mark.parametrize("kind", ["formula", "both functions"])
def test_methods_of_order_two(kind: str, method: object) -> None:
    """No maximum is near a node, where gradients jump: motions between nodes are no one polynomial."""
    run, responses, names = kinds.run(kind, method), kinds.responses(kind), kinds.names(kind)[:3]
    direction = np.array([0.3, 1.0, 0.2])
    wanted = differenced(run, responses, names, method, lambda changes: kinds.moved(kind, changes), direction)
    for response, row in zip(responses, wanted, strict=True):
        found = sr.hessian(run, response, names)
        limit = OF_EXTREMES if isinstance(response, sr.Maximum) else LIMIT
        assert found.asymmetry < 1e-5 * limit, response.title
        assert found.matrix @ direction == pytest.approx(row, rel=0, abs=limit * abs(row).max()), (
            response.title
        )


@pytest.mark.slow
def test_two_impacts_whose_direction_and_place_change_with_time() -> None:
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-7, atol=1e-9), "t_eval": [1.7]}
    run = sr.simulate(kinds.two_links(), until=1.7, events=kinds.STRUCK, **settings)
    assert len(run.events) == 2
    run = frozen_segments.solved(run, sr.Radau(), kinds.STRUCK)
    responses = [sr.Final("tip.x"), sr.Final("link.velocity.x"), sr.Integral(lambda o: o.t * o("tip.x"))]
    names = ["link.mass", "tip.position.x", "gravity.y", "pin.point.y"]
    direction = np.array([0.1, 0.05, 0.3, 0.02])

    def moved(changes):
        return kinds.two_links(**changes), kinds.STRUCK

    wanted = differenced(run, responses, names, sr.Radau(), moved, direction)
    for response, row in zip(responses, wanted, strict=True):
        found = sr.hessian(run, response, names)
        assert found.asymmetry < 1e-11, response.title
        assert found.matrix @ direction == pytest.approx(row, rel=0, abs=LIMIT * abs(row).max()), (
            response.title
        )


@pytest.mark.slow
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT(), sr.GeneralizedAlpha(0.8)])
def test_motions_and_forces_that_depend_on_time(method: object) -> None:
    settings = {"store": "steps", "method": replace(method, rtol=1e-7, atol=1e-9), "t_eval": [2.2]}
    run = sr.simulate(kinds.driven({}), until=2.2, events=kinds.ELBOW, **settings)
    run = frozen_segments.solved(run, method, kinds.ELBOW)
    names = [*kinds.DRIVEN, "stop.restitution"]
    direction = np.array([0.02, 0.1, 0.1, 0.05, 0.2, 0.02, 0.05])

    def moved(changes):
        e = changes.pop("stop.restitution")
        return kinds.driven(changes), sr.Event(
            kinds.ELBOW.function, direction=-1, reset=sr.Impact(e, along="elbow.angle"), name="stop"
        )

    wanted = differenced(run, kinds.TOLD, names, method, moved, direction, 1e-3)
    # Constraints of states between the nodes of methods of order two are left with defects of 3e-13: multipliers there
    limit = LIMIT if isinstance(method, sr.Radau) else 2e-6
    for response, row in zip(kinds.TOLD, wanted, strict=True):
        found = sr.hessian(run, response, names)
        assert found.asymmetry < 1e-9, response.title  # as with rates
        assert found.matrix @ direction == pytest.approx(row, rel=0, abs=limit * abs(row).max()), (
            response.title
        )


def stopped(changes: dict[str, float]) -> tuple[sr.System, sr.Event]:
    told = dict(changes)
    stop = sr.Impact(told.pop("stop.restitution"))
    return sr.System(with_numbers(events.pendulum().model, told)), sr.Event(
        "bob.x", direction=-1, reset=stop, name="stop"
    )


@pytest.mark.parametrize("method", [sr.HHT(step=0.02), sr.Radau()])
def test_what_a_hessian_leaves_at_a_stop_falls_with_the_cube(method: object) -> None:
    settings = {"store": "steps", "method": replace(method, rtol=1e-7, atol=1e-9), "t_eval": [1.5]}
    run = sr.simulate(events.pendulum(), until=1.5, events=events.STOP, **settings)
    run = frozen_segments.solved(run, method, events.STOP)
    names, response = ["gravity.y", "bob.angular_velocity.z", "stop.restitution"], sr.Final(events.angle)
    gradient, found = sr.sensitivity(run, response, names), sr.hessian(run, response, names).matrix
    direction, rest = np.array([0.5, 0.1, 0.2]), []
    for size in (4e-2, 2e-2, 1e-2):
        there = frozen_segments.at(
            run,
            [response],
            method,
            stopped(dict(zip(names, gradient.at + size * direction, strict=True))),
        )
        model = (
            gradient.values
            + size * gradient.matrix @ direction
            + 0.5 * size**2 * direction @ found @ direction
        )
        rest.append(abs(there - model)[0])
    slopes = np.log2(np.array(rest[:-1]) / np.array(rest[1:]))
    assert np.all(abs(slopes - 3) < 0.3), slopes


@pytest.mark.slow
def test_the_time_at_which_a_driver_needs_a_torque() -> None:
    """F(t, m, g) = 3 (0.1 + m / 4) - m g cos(1.5 t²) / 2 - 6 = 0, of a motor that lifts an arm."""
    arm = sr.Body("arm", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 1, 0))
    motor = sr.AngleDriver("motor", "pin", "1.5*t^2")
    crane = sr.System(sr.Model("crane", bodies=[arm], joints=[pin], drivers=[motor], gravity=(0, 0, -9.81)))
    event = sr.Event("motor.torque.y - 6", terminal=True, name="strong")
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-9, atol=1e-11)}
    run = sr.simulate(crane, until=2.0, events=event, **settings)
    found = sr.hessian(run, sr.AtEvent("t", event="strong"), ["arm.mass", "gravity.z"]).matrix
    t, m, g = run.events[0].t, 2.0, 9.81
    cosine, rate = np.cos(1.5 * t * t), 3 * t * np.sin(1.5 * t * t)
    by = np.array([0.75 - g * cosine / 2, -m * cosine / 2])
    by_t, by_tt = m * g * rate / 2, m * g / 2 * (3 * np.sin(1.5 * t * t) + 9 * t * t * cosine)
    mixed, cross = np.array([g * rate / 2, m * rate / 2]), np.array([[0, -cosine / 2], [-cosine / 2, 0]])
    slope = -by / by_t
    wanted = (
        -(cross + np.outer(mixed, slope) + np.outer(slope, mixed) + by_tt * np.outer(slope, slope)) / by_t
    )
    assert found == pytest.approx(wanted * np.array([[1, -1], [-1, 1]]), rel=1e-6)


@pytest.mark.slow
def test_an_impact_in_a_linkage_with_equations_that_others_imply() -> None:
    system = sr.System(sr.load(kinds.EXAMPLES / "bricard.yaml"))
    hit = sr.Event("rod_1.z + 0.062", direction=-1, reset=sr.Impact(0.5), name="hit")
    settings = {"store": "steps", "method": sr.Radau(rtol=1e-6, atol=1e-8), "t_eval": [0.6]}
    run = sr.simulate(system, until=0.6, events=hit, **settings)
    run = frozen_segments.solved(run, sr.Radau(), hit)
    names, direction = ["rod_1.mass", "gravity.z", "hit.restitution"], np.array([0.1, 0.5, 0.2])

    def moved(changes):
        e = changes.pop("hit.restitution")
        event = sr.Event(hit.function, direction=-1, reset=sr.Impact(e), name="hit")
        return sr.System(with_numbers(system.model, changes)), event

    responses = [sr.Final("rod_1.x"), sr.Integral("energy.kinetic"), sr.Final("rod_1.velocity.z")]
    wanted = differenced(run, responses, names, sr.Radau(), moved, direction)
    for response, row in zip(responses, wanted, strict=True):
        found = sr.hessian(run, response, names)
        assert found.matrix @ direction == pytest.approx(row, rel=0, abs=LIMIT * abs(row).max()), (
            response.title
        )
