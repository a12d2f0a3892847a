"""Events in gradients: their times move, velocities jump; closed forms of a bouncing ball, of a pendulum at a stop."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints
from tests.sensitivity.frozen import values as valued
from tests.sensitivity.test_references import FOLDER
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.equations.motion import KKTMatrix
from sarrus.analyses.sensitivity.events import first_order
from sarrus.linalg.factors import SingularSystem
from sarrus.model.written import with_numbers

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly

BOUNCE = sr.Event("ball.z", direction=-1, reset=sr.Impact(0.8), name="bounce")
BALL = {"h": "ball.position.z", "e": "bounce.restitution", "g": "gravity.z", "v0": "ball.velocity.z"}
SIGN = {"g": -1.0}
STOP = sr.Event("bob.x", direction=-1, reset=sr.Impact(0.7), name="stop")
PENDULUM = {"L": 1.0, "g": 9.81, "theta0": np.pi / 2}
SWUNG = {  # closed forms with elliptic functions: time, angle, its derivatives by L, g, theta0 and restitution
    0.4: (0.801630126979649, (0.7388213375438, -0.075313082318, 0.9020698506506, 0.0)),
    1.0: (0.965556580771015, (-0.537768657230, 0.0548184156198, 0.3548244896225, 1.4293938777142)),
    2.0: (0.601583588497937, (-1.125292416448, 0.1147087070794, 0.0564825749292, 1.4629092524048)),
    3.0: (0.390325404081827, (-1.368671618103, 0.1395180038841, -0.036178561477, 1.2768917002986)),
}


def ball() -> sr.System:
    body = sr.Body("ball", mass=1, inertia=(1, 1, 1), position=(0, 0, 1), velocity=(0, 0, 0.5))
    return sr.System(sr.Model("ball", bodies=[body], gravity=(0, 0, -9.81)))


def hung(d):
    """A point mass on a massless rod, its angle counted from the downward vertical."""
    theta, half = d["theta0"], 0.5 * d["theta0"]
    return {
        "bob.position": [d["L"] * np.sin(theta), -d["L"] * np.cos(theta), 0.0],
        "bob.orientation": [np.cos(half), 0.0, 0.0, np.sin(half)],
        "gravity.y": -d["g"],
    }


def pendulum() -> sr.System:
    told = hung(PENDULUM)
    where = {"position": told["bob.position"], "orientation": told["bob.orientation"]}
    bob = sr.Body("bob", mass=1, inertia=(1e-9, 1e-9, 1e-9), angular_velocity=(0, 0, 0), **where)
    pin = sr.Revolute("pin", sr.ground, bob, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.System(sr.Model("pendulum", bodies=[bob], joints=[pin], gravity=(0, told["gravity.y"], 0)))


def angle(o):
    return np.arctan2(o("bob.x"), -1 * o("bob.y"))


EQUAL = {"method": sr.HHT(step=1e-3, rtol=1e-11)}  # of which Newton's method leaves next to nothing


def bounced(until: float, **settings: object) -> sr.Trajectory:
    return sr.simulate(ball(), until=until, events=BOUNCE, store="steps", **settings)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("simulated", [sr.HHT(), sr.Radau()])
@pytest.mark.parametrize("method", ["adjoint", "direct"])
@pytest.mark.parametrize("case", range(4))
def test_the_bouncing_ball(case: int, method: str, simulated: object) -> None:
    """In free flight the steps are exact, so that the gradient is that of the closed form to round-off."""
    told = json.loads((FOLDER / "S10_bouncing_ball.json").read_text())["cases"][case]
    run = bounced(float(told["T"]), method=simulated)
    assert len(run.events) == told["n_impacts"]
    names = [name for name in BALL if told["n_impacts"] or name != "e"]
    found = sr.sensitivity(run, sr.Final("ball.z"), [BALL[name] for name in names], method=method)
    assert found.values[0] == pytest.approx(float(told["y_T"]), abs=1e-13)
    wanted = [SIGN.get(name, 1.0) * float(told["grad"][name]) for name in names]
    assert found.matrix[0] == pytest.approx(wanted, abs=1e-12)


@pytest.mark.slow
def test_responses_over_the_whole_motion() -> None:
    """Integrals take the jumps in, misfits and values at single times the moved motion: differences of whole runs."""
    responses = [
        sr.Integral(lambda o: o("ball.velocity.z") ** 2 + o.t * o("ball.z"), name="integral"),
        sr.At("ball.velocity.z", time=0.8),
        sr.Misfit("ball.z", at=(0.2, 0.6, 1.1), data=(0.9, 0.1, 0.4), sigma=0.1),
        sr.Final("energy.kinetic"),
    ]

    def values(h: float) -> np.ndarray:
        system = sr.System(with_numbers(ball().model, {"ball.position.z": h}))
        run = sr.simulate(system, until=1.3, events=BOUNCE, store="steps", **EQUAL)
        return valued(run.system, run.steps, responses)

    run = bounced(1.3, **EQUAL)
    found = sr.sensitivity(run, responses, ["ball.position.z"])
    direct = sr.sensitivity(run, responses, ["ball.position.z"], method="direct")
    assert direct.matrix == pytest.approx(found.matrix, rel=1e-11)
    slopes = [(values(1 + e) - values(1 - e)) / (2 * e) for e in (2e-4, 1e-4)]
    assert found.matrix[:, 0] == pytest.approx((4 * slopes[1] - slopes[0]) / 3, rel=2e-5)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("method", [(sr.HHT(), 3e-4), (sr.Radau(), 1e-7)])
@pytest.mark.parametrize("until", SWUNG)
def test_the_pendulum_at_a_stop(until: float, method: tuple[object, float]) -> None:
    """The error falls with the tolerance, whatever the number of impacts."""
    simulated, limit = method
    value, wanted = SWUNG[until]
    names = [*PENDULUM, *(["stop.restitution"] if until > 0.5 else [])]
    errors = []
    for rtol in (1e-4, 1e-6, 1e-8):
        tight = replace(simulated, rtol=rtol, atol=rtol)
        settings = {"store": "steps", "method": tight, "t_eval": [until]}
        run = sr.simulate(pendulum(), until=until, events=STOP, **settings)
        found = sr.sensitivity(run, sr.Final(angle), names, design=PENDULUM, formula=hung)
        direct = sr.sensitivity(run, sr.Final(angle), names, design=PENDULUM, formula=hung, method="direct")
        assert direct.matrix == pytest.approx(found.matrix, rel=1e-9)
        errors.append(abs(found.matrix[0] - wanted[: len(names)]).max())
    assert found.values[0] == pytest.approx(value, abs=limit)
    assert errors[0] > 4 * errors[1] > 16 * errors[2], errors
    assert errors[2] < limit, errors


def test_the_time_of_an_event_that_ends_the_run() -> None:
    """A quarter of the period of a pendulum, 4 sqrt(L/g) K(sin²(θ₀/2)), from 90 degrees."""
    down = sr.Event("bob.x", direction=-1, terminal=True)
    run = sr.simulate(
        pendulum(), until=2.0, events=down, store="steps", method=sr.Radau(rtol=1e-8, atol=1e-10)
    )
    assert run.status == "event"
    quarter = sr.Final("t", name="quarter")
    found = sr.sensitivity(run, quarter, [*PENDULUM], design=PENDULUM, formula=hung)
    direct = sr.sensitivity(run, quarter, [*PENDULUM], design=PENDULUM, formula=hung, method="direct")
    assert direct.matrix == pytest.approx(found.matrix, rel=1e-11)
    assert 4 * found.values == pytest.approx([2.3678419475762374], rel=1e-5)
    wanted = [1.18392097378811, -0.1206851145553, 0.54098864119931]
    assert 4 * found.matrix[0] == pytest.approx(wanted, rel=2e-5)


NUMBERS = ["rod.mass", "spring.k", "pin.point.y", "ball.point.z", "crank.angular_velocity.x", "gravity.z"]
HIT = sr.Event("pin.angle + slider.x - 4.4", direction=1, reset=sr.Impact(0.5, along="pin.angle"), name="hit")


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", [*NUMBERS, "hit.restitution"])
def test_an_impact_in_a_spatial_mechanism(name: str) -> None:
    """An event of an angle and a position, and an impulse about a joint: forward, backward, and differenced runs."""
    responses = [sr.Final("slider.x"), sr.Integral("energy.kinetic"), sr.Final("pin.angle.rate")]
    equal = {"until": 0.4, "store": "steps"} | EQUAL
    run = sr.simulate(slider_crank(), events=HIT, **equal)
    assert len(run.events) == 1
    found, direct = (sr.sensitivity(run, responses, [name], method=way) for way in ("adjoint", "direct"))
    assert direct.matrix == pytest.approx(found.matrix, rel=1e-10)

    def values(change: float) -> np.ndarray:
        event, model, at = HIT, slider_crank().model, found.at[0] + change
        if name in NUMBERS:
            model = with_numbers(model, {name: at})
        else:
            event = sr.Event(HIT.function, direction=1, reset=sr.Impact(at, along="pin.angle"), name="hit")
        again = sr.simulate(sr.System(model), events=event, **equal)
        return valued(again.system, again.steps, responses)

    slope = (values(1e-3) - values(-1e-3)) / 2e-3
    assert found.matrix[:, 0] == pytest.approx(slope, rel=1e-5, abs=1e-5 * abs(slope).max())


@pytest.mark.slow
def test_extremes_of_a_motion_with_events() -> None:
    """Of velocities just after and just before an impact in closed form; between steps those of differenced runs."""
    turned = lambda o: o("ball.z") * (o.t - 0.6)  # noqa: E731 its largest value lies between two impacts
    responses = [
        sr.Maximum("ball.velocity.z"), sr.Minimum("ball.velocity.z"), sr.Minimum("ball.z"),
        sr.Maximum(turned, name="largest"),
    ]  # fmt: skip

    def run(h: float = 1.0, g: float = -9.81, e: float = 0.8) -> sr.Trajectory:
        system = sr.System(with_numbers(ball().model, {"ball.position.z": h, "gravity.z": g}))
        bounce = sr.Event("ball.z", direction=-1, reset=sr.Impact(e), name="bounce")
        return sr.simulate(system, until=1.3, events=bounce, store="steps", **EQUAL)

    names = ["ball.position.z", "gravity.z", "bounce.restitution"]
    found = sr.sensitivity(run(), responses, names)
    direct = sr.sensitivity(run(), responses, names, method="direct")
    assert direct.matrix == pytest.approx(found.matrix, abs=1e-12)
    speed = np.sqrt(0.5**2 + 2 * 9.81)
    assert found.matrix[0] == pytest.approx([0.8 * 9.81 / speed, -0.8 / speed, speed], rel=1e-12)
    assert found.matrix[1] == pytest.approx([-9.81 / speed, 1 / speed, 0.0], rel=1e-12)
    assert found.matrix[2] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    for n, (kind, at) in enumerate({"h": 1.0, "g": -9.81, "e": 0.8}.items()):
        ends = [[run(**{kind: at + d}) for d in (e, -e)] for e in (2e-4, 1e-4)]
        told = [[valued(one.system, one.steps, responses[3:]) for one in pair] for pair in ends]
        slopes = [(pair[0] - pair[1]) / (2 * e) for pair, e in zip(told, (2e-4, 1e-4), strict=True)]
        assert found.matrix[3:, n] == pytest.approx((4 * slopes[1] - slopes[0]) / 3, rel=1e-6)


def bounced_by_formula(
    until: float, h: complex, g: complex, e: complex, v: complex
) -> tuple[complex, complex]:
    """The integrals over time of half the square of the speed, and of the height, of a ball that falls from h."""
    t, square, area = 0.0, 0.0, 0.0
    while True:
        flight = (v + np.sqrt(v * v + 2 * g * h)) / g
        last = (t + flight).real > until
        d = until - t if last else flight
        square += 0.5 * (v * v * d - v * g * d * d + g * g * d**3 / 3)
        area += h * d + v * d * d / 2 - g * d**3 / 6
        if last:
            return square, area
        t, v, h = t + flight, -e * (v - g * flight), 0.0


def test_integrals_over_runs_with_radau_and_events_have_all_digits() -> None:
    """Within its long steps, also where an event ends one: Lobatto's rule is exact for squares of velocities."""
    run = bounced(2.0, method=sr.Radau())
    assert len(run.steps) < 20
    found = sr.sensitivity(run, [sr.Integral("energy.kinetic"), sr.Integral("ball.z")], list(BALL.values()))
    given = np.array([1.0, 9.81, 0.8, 0.5])  # h, g, e, v0
    order = {"h": 0, "e": 2, "g": 1, "v0": 3}
    assert found.values == pytest.approx(np.real(bounced_by_formula(2.0, *given)), rel=1e-12)
    for n, name in enumerate(BALL):
        step = 1e-30j * np.eye(4)[order[name]]
        wanted = SIGN.get(name, 1.0) * np.imag(bounced_by_formula(2.0, *(given + step))) / 1e-30
        assert found.matrix[:, n] == pytest.approx(wanted, rel=1e-11)


def test_the_integral_of_a_velocity_that_jumps() -> None:
    """It is the way that the ball has gone: both limits of every piece move, the sum of what they add is known."""
    run = bounced(2.0)
    names = ["ball.position.z", "gravity.z", "bounce.restitution", "ball.velocity.z"]
    found = sr.sensitivity(run, [sr.Integral("ball.velocity.z"), sr.Final("ball.z")], names)
    assert found.values[0] == pytest.approx(found.values[1] - 1.0, abs=1e-12)
    assert found.matrix[0] == pytest.approx(found.matrix[1] - np.array([1, 0, 0, 0]), abs=1e-12)


@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()])
def test_values_just_before_and_just_after_an_event(method: object) -> None:
    """The height there is the same, its derivatives are not: the velocities with which it is met differ."""
    run = bounced(1.3, method=method)
    hit = run.events[0].t
    responses = [sr.At("ball.z", time=hit - 1e-7), sr.At("ball.z", time=hit + 1e-7)]
    found = sr.sensitivity(run, responses, ["ball.position.z"]).matrix[:, 0]
    speed = np.sqrt(0.5**2 + 2 * 9.81)
    after = 0.8 * speed * (-1 / speed)  # the ball leaves the floor later by 1/speed for each meter of height
    assert found == pytest.approx([1.0, after], abs=1e-5)


@pytest.mark.parametrize("events", [(), BOUNCE])
def test_methods_that_store_no_steps_are_refused(events: sr.Event) -> None:
    refused = r"method: ODE\(\) stores no steps\. "
    with pytest.raises(
        ValueError, match=rf"{refused}Choose HHT\(\), GeneralizedAlpha\(\), Radau\(\) or a description"
    ):
        sr.simulate(ball(), until=1.0, events=events, store="steps", method=sr.ODE())


@pytest.mark.parametrize("function", [lambda t, q, v: float(q[2]), lambda t, q, v: np.fmod(q[2], 3.0)])
def test_a_python_function_that_cannot_be_differentiated(function: object) -> None:
    run = sr.simulate(
        ball(), until=1.0, store="steps", events=sr.Event(function, terminal=True, name="floor")
    )
    assert run.status == "event"
    with pytest.raises(
        ValueError, match=r"the event floor at t = 0\.\d+ s cannot be differentiated through its"
    ):
        sr.sensitivity(run, sr.Final("t"), ["gravity.z"])


def test_an_event_that_only_grazes() -> None:
    """The ball rises by v²/2g: a gate a hair below is met, but a slightly slower ball would not meet it."""
    top = 1 + 0.5**2 / (2 * 9.81)
    gates = (
        sr.Event(f"ball.z - {top - gap!r}", direction=1, terminal=True, name="gate") for gap in (1e-12, 1e-4)
    )
    grazed, met = (sr.simulate(ball(), until=1.0, store="steps", events=[0.5 / 9.81, gate]) for gate in gates)
    assert grazed.status == met.status == "event"
    with pytest.raises(ValueError, match=r"the event gate at t = 0\.05\d* s only grazes"):
        sr.sensitivity(grazed, sr.Final("t"), ["ball.velocity.z"])
    root = np.sqrt(0.5**2 - 2 * 9.81 * (0.5**2 / (2 * 9.81) - 1e-4))
    found = sr.sensitivity(met, sr.Final("t"), ["ball.velocity.z"]).matrix[0, 0]
    assert found == pytest.approx((1 - 0.5 / root) / 9.81, rel=1e-6)


@pytest.mark.parametrize("python", [False, True])
def test_a_curved_function_that_only_grazes(python: bool) -> None:
    """The ball passes a bowl evenly, and touches it with its lowest point only; the bowl's curvature tells."""
    body = sr.Body("ball", mass=1, inertia=(1, 1, 1), position=(-0.5, 0, 1), velocity=(1, 0, 0))
    even = sr.System(sr.Model("even", bodies=[body]))

    def touched(gap: float, python: bool) -> sr.Trajectory:
        formula = f"ball.z + ball.x^2 - {1 + gap!r}"
        function = (lambda t, q, v: q[2] + q[0] ** 2 - (1 + gap)) if python else formula
        bowl = sr.Event(function, direction=-1, terminal=True, name="bowl")
        return sr.simulate(even, until=1.0, store="steps", events=[0.5, bowl])

    grazed, met = (touched(gap, python) for gap in (1e-14, 1e-4))
    assert grazed.status == met.status == "event"
    with pytest.raises(ValueError, match=r"the event bowl at t = 0\.\d+ s only grazes"):
        sr.sensitivity(grazed, sr.Final("t"), ["ball.position.z"])
    found = sr.sensitivity(met, sr.Final("t"), ["ball.position.z"]).matrix[0, 0]
    assert found == pytest.approx(1 / (2 * 0.01), rel=1e-6)


@pytest.mark.parametrize("simulated", [sr.HHT(), sr.Radau()])
def test_states_over_time_are_those_of_the_closed_form(simulated: object) -> None:
    """At fixed times, on both sides of each impact."""
    run = bounced(1.5, method=simulated)
    found = sr.state_derivatives(run, ["ball.position.z", "bounce.restitution"])
    g, e, u = (
        9.81,
        run.restitutions["bounce.restitution"],
        np.sqrt(0.5**2 + 2 * 9.81),
    )  # the speed that it hits with
    before, after = np.flatnonzero(found.t == run.events[0].t)
    rows = before + 1
    assert found.q_b[:rows, 2] == pytest.approx(np.tile([1.0, 0.0], (rows, 1)), abs=1e-9)
    assert found.v_b[:rows, 2] == pytest.approx(np.zeros((rows, 2)), abs=1e-9)
    behind = slice(after, np.searchsorted(found.t, run.events[1].t))
    d, ones = found.t[behind] - (0.5 + u) / g, np.ones(behind.stop - after)
    # z = e u d - g d²/2 with d = t - t₁, du/dh = g/u, dt₁/dh = 1/u
    by_h = e * g * d / u - (e * u - g * d) / u
    assert found.q_b[behind, 2] == pytest.approx(np.column_stack([by_h, u * d]), abs=1e-9)
    assert found.v_b[behind, 2] == pytest.approx(
        np.column_stack([ones * (e + 1) * g / u, ones * u]), abs=1e-9
    )


@pytest.mark.parametrize("start", ["ball.z", "ball.velocity.z", "energy.kinetic"])
def test_outputs_over_time_are_those_of_responses(start: str) -> None:
    run = bounced(1.5)
    found = sr.state_derivatives(run, ["gravity.z", "bounce.restitution"])
    for row in (2, len(found.t) - 3, len(found.t) - 1):
        wanted = sr.sensitivity(run, sr.At(start, time=float(found.t[row])), found.names)
        assert found.output(start)[row] == pytest.approx(wanted.matrix[0], rel=1e-9)


def falling(*names: str) -> tuple[sr.System, list[sr.Event]]:
    """Balls that fall side by side, and the events that they meet the floor."""
    balls = [sr.Body(name, mass=1, inertia=(1, 1, 1), position=(2 * n, 0, 1)) for n, name in enumerate(names)]
    floor = [sr.Event(f"{name}.z", direction=-1, reset=sr.Impact(0.8), name=f"{name}_hits") for name in names]
    return sr.System(sr.Model("balls", bodies=balls, gravity=(0, 0, -9.81))), floor


@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()])
def test_two_events_at_the_same_time(method: object) -> None:
    """Two balls that hit the floor together have the derivatives of one: between their events lies no time at all."""
    settings = {"until": 1.0, "store": "steps", "method": method}
    (both, floor), (single, below) = (falling(*places) for places in (["one", "other"], ["one"]))
    pair = sr.simulate(both, events=floor, **settings)
    alone = sr.simulate(single, events=below, **settings)
    assert [event.t for event in pair.events] == pytest.approx([np.sqrt(2 / 9.81)] * 2)
    kinds = (
        [sr.Final, sr.Integral] if isinstance(method, sr.Radau) else [sr.Final]
    )  # trapezoids depend on nodes
    told = [[kind(f"{name}.z") for kind in kinds] for name in ("one", "other")]
    names = ["one.position.z", "one_hits.restitution", "gravity.z"]
    wanted = sr.sensitivity(alone, told[0], names).matrix
    for n, name in enumerate(("one", "other")):
        own = [number.replace("one", name) for number in names]
        for way in ("adjoint", "direct"):
            assert sr.sensitivity(pair, told[n], own, method=way).matrix == pytest.approx(
                wanted, abs=1e-12
            ), name


@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()])
def test_outputs_at_events(method: object) -> None:
    """The times of two impacts and the velocities before and after the second one, in closed form."""
    run = bounced(2.0, method=method)
    responses = [
        sr.AtEvent("t", event="bounce"), sr.AtEvent("t", event="bounce", number=2),
        sr.AtEvent("ball.velocity.z", event="bounce", number=2),
        sr.AtEvent("ball.velocity.z", event="bounce", number=2, after=True),
    ]  # fmt: skip
    found = sr.sensitivity(run, responses, ["ball.velocity.z", "bounce.restitution"])
    direct = sr.sensitivity(run, responses, ["ball.velocity.z", "bounce.restitution"], method="direct")
    g, e, v, u = 9.81, 0.8, 0.5, np.sqrt(0.5**2 + 2 * 9.81)
    values = [(v + u) / g, (v + u + 2 * e * u) / g, -e * u, e * e * u]
    by_v = [(1 + v / u) / g, (1 + v / u + 2 * e * v / u) / g, -e * v / u, e * e * v / u]
    by_e = [0.0, 2 * u / g, -u, 2 * e * u]
    assert found.values == pytest.approx(values, rel=1e-11)
    assert found.matrix == pytest.approx(np.array([by_v, by_e]).T, abs=1e-11)
    assert direct.matrix == pytest.approx(found.matrix, abs=1e-12)
    assert found.responses[2:] == ("ball.velocity.z at bounce 2", "ball.velocity.z after bounce 2")


@pytest.mark.parametrize(
    ("response", "told"),
    [
        (sr.AtEvent("ball.z", event="hit"), r"the run has 0 events 'hit' .*; it has bounce"),
        (
            sr.AtEvent("ball.z", event="bounce", number=9),
            "3 events 'bounce' that change velocities or end it, not 9",
        ),
        (sr.AtEvent("ball.z", event="end", after=True), "ends with the event 'end': nothing is after it"),
    ],
)
def test_events_that_are_not_there(response: sr.AtEvent, told: str) -> None:
    end = sr.Event("t - 1.9", terminal=True, name="end")
    run = sr.simulate(ball(), until=2.0, events=[BOUNCE, end], store="steps")
    with pytest.raises(ValueError, match=told):
        sr.sensitivity(run, response, ["gravity.z"])
    with pytest.raises(ValueError, match="the run has 0 events"):
        by_checkpoints(ball(), response, ["gravity.z"], until=0.1)


@pytest.mark.parametrize("name", ["slider_crank", "hmmwv"])
def test_the_matrix_of_an_event_is_solved_for_many_columns_at_once(name: str) -> None:
    system = sr.System(sr.load(sr.mechanisms.path(name)))
    kkt, rng = KKTMatrix(system), np.random.default_rng(1)
    kkt.factor_at(system.b, 0.0, system.q0)
    f, g = rng.normal(size=(system.nq, 5)), rng.normal(size=(system.m, 5))
    x, y = kkt.solve_pair(f, g)
    for n in range(5):
        for column, alone in zip((x[:, n], y[:, n]), kkt.solve_pair(f[:, n], g[:, n]), strict=True):
            assert column == pytest.approx(alone, rel=1e-9, abs=1e-12 * abs(alone).max())


@pytest.mark.parametrize("method", ["adjoint", "direct"])
def test_the_restitution_of_an_impact_that_never_happens_has_derivative_zero(method: str) -> None:
    run = bounced(0.3)
    assert not run.events
    found = sr.sensitivity(run, "ball.z", ["bounce.restitution", "gravity.z"], method=method)
    assert found["bounce.restitution"] == 0.0
    assert found["gravity.z"] == pytest.approx(0.045)
    repeated = by_checkpoints(ball(), "ball.z", ["bounce.restitution", "gravity.z"], until=0.3, events=BOUNCE)
    assert repeated.matrix == pytest.approx(found.matrix)
    assert sr.hessian(run, "ball.z", ["bounce.restitution"]).matrix[0, 0] == 0.0


def test_a_design_gives_the_restitution() -> None:
    """Two design variables, on which the height depends through the restitution, and through the start as well."""
    run, told = bounced(1.0), [sr.Final("ball.z"), sr.Integral("ball.z")]
    plain = sr.sensitivity(run, told, ["bounce.restitution", "ball.position.z"])
    design = {"softness": 0.2, "drop": 1.0}

    def numbers(d):
        return {"bounce.restitution": 1 - d["softness"] * d["drop"], "ball.position.z": d["drop"]}

    for method in ("adjoint", "direct"):
        found = sr.sensitivity(run, told, design=design, formula=numbers, method=method)
        by_e, by_h = plain["bounce.restitution"], plain["ball.position.z"]
        assert found["softness"] == pytest.approx(-by_e, rel=1e-12)
        assert found["drop"] == pytest.approx(by_h - 0.2 * by_e, rel=1e-12)
    with pytest.raises(sr.SarrusError, match=r"bounce\.restitution"):
        sr.sensitivity(run, told, design={"softness": 0.3, "drop": 1.0}, formula=numbers)


def test_an_optimization_changes_a_restitution_by_a_formula() -> None:
    """Values of the problem are those of simulations with the restitution of the design."""
    formula = {"formula": lambda d: {"bounce.restitution": 0.5 * d["e"] + 0.4}}
    problem = sr.Problem(ball(), sr.Final("ball.z"), until=1.0, design={"e": 0.8}, events=BOUNCE, **formula)
    for e in (0.8, 0.9):
        event = sr.Event("ball.z", direction=-1, reset=sr.Impact(0.5 * e + 0.4), name="bounce")
        run = sr.simulate(ball(), until=1.0, events=event, store="steps")
        assert problem.values([e]) == pytest.approx(run["ball"].position[-1, 2:], abs=1e-12)
        by_e = sr.sensitivity(run, "ball.z", ["bounce.restitution"])["bounce.restitution"]
        assert problem.gradient([e])["e"] == pytest.approx(0.5 * by_e, rel=1e-12)


def test_a_state_at_an_event_without_derivatives_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where a force stops within 1e-9 m."""
    run = sr.simulate(ball(), until=0.6, events=BOUNCE, store="steps")

    def singular(_: object) -> None:
        raise SingularSystem("the equations are dependent there")

    monkeypatch.setattr(first_order, "LUFactors", singular)
    with pytest.raises(
        SingularSystem, match=r"the state at bounce at t = .* s has no derivatives .* less steep"
    ):
        sr.sensitivity(run, "ball.z", ["gravity.z"])
