"""Events, breakpoints, dense output and consistent states, against closed solutions."""

from collections.abc import Callable
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from tests.system.mechanisms import slider_crank

import sarrus as sr

G = 9.81
METHODS = [sr.HHT(), sr.ODE()]


def ball(height: float = 1.0, speed: float = 0.0) -> sr.System:
    body = sr.Body("ball", mass=2.0, inertia=(1, 1, 1), position=(0, 0, height), velocity=(0.5, 0, speed))
    return sr.System(sr.Model("ball", bodies=[body], gravity=(0, 0, -G)))


def pendulum() -> sr.System:
    """A rod on a pin, released at the horizontal."""
    rod = sr.Body("rod", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(1.0, 0, 0))
    pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 1, 0))
    return sr.System(sr.Model("pendulum", bodies=[rod], joints=[pin], gravity=(0, 0, -G)))


@pytest.mark.parametrize("method", METHODS, ids=lambda m: type(m).__name__)
def test_a_fall_ends_at_the_floor(method: object) -> None:
    floor = sr.Event("ball.z", direction=-1, terminal=True)
    run = sr.simulate(ball(), until=3.0, events=floor, method=replace(method, rtol=1e-9, atol=1e-11))
    assert run.success
    assert run.status == "event"
    assert run.events[0].t == pytest.approx(np.sqrt(2 / G), abs=1e-12)
    assert run.t[-1] == run.events[0].t
    assert run.events[0].name == "ball.z"


@pytest.mark.parametrize(
    ("method", "order"),
    [
        (lambda h: sr.HHT(step=h / 8), 1.9),
        (lambda h: sr.Radau(rtol=0.9, atol=1.0, first_step=h, max_step=h), 4.6),
    ],
    ids=["HHT", "Radau"],
)
def test_times_of_events_have_the_order_of_the_method(
    method: Callable[[float], object], order: float
) -> None:
    """They are located on the interpolation between the steps; the reference is SciPy's, of one equation."""

    def passed(_: float, y: np.ndarray) -> float:
        return float(y[0] - 0.7)

    exact = solve_ivp(
        lambda t, y: [y[1], G * np.cos(y[0]) / 1.1],
        (0, 1),
        [0, 0],
        "DOP853",
        rtol=1e-13,
        atol=1e-14,
        events=passed,
    ).t_events[0][0]
    runs = [
        sr.simulate(pendulum(), until=0.8, events=sr.Event("pin.angle - 0.7"), method=method(h))
        for h in (0.16, 0.02)
    ]
    coarse, fine = (abs(run.events[0].t - exact) for run in runs)
    assert np.log2(coarse / fine) / 3 > order


def test_directions_and_counts() -> None:
    crossings = []
    for direction in (-1, 0, 1):
        middle = sr.Event("ball.z - 1.2", direction=direction, name="middle")
        run = sr.simulate(ball(1.0, 3.0), until=0.6, events=[middle])
        crossings.append([event.t for event in run.events])
    times = [(3 + s * np.sqrt(9 - 2 * G * 0.2)) / G for s in (-1, 1)]
    assert crossings[1] == pytest.approx(times, abs=1e-12)
    assert crossings[0] == crossings[1][1:]
    assert crossings[2] == crossings[1][:1]
    second = sr.Event(lambda t, q, v: q[2] - 1.2, terminal=2)
    assert sr.simulate(ball(1.0, 3.0), until=0.6, events=second).events[-1].t == pytest.approx(
        times[1], abs=1e-12
    )


def test_a_ball_bounces() -> None:
    """Heights and times of impacts fall geometrically with the restitution."""
    e = 0.8
    floor = sr.Event("ball.z", direction=-1, reset=sr.Impact(e))
    run = sr.simulate(ball(), until=3.0, events=floor, t_eval=np.linspace(0, 3, 301), store="dense")
    assert run.success, run.message
    fall = np.sqrt(2 / G)
    times = fall + 2 * fall * np.cumsum([0, *(e ** np.arange(1, 20))])
    found = np.array([event.t for event in run.events])
    assert np.allclose(found, times[: len(found)], rtol=0, atol=1e-11)
    assert len(found) == np.searchsorted(times, 3.0)
    assert run.events[0].after[2] == pytest.approx(e * np.sqrt(2 * G), rel=1e-11)
    assert run.events[0].after[0] == pytest.approx(0.5)  # along the floor nothing changes
    assert run["ball"].position[:, 2].min() > -1e-9
    assert run.sol(found[0]).v[2] > 0 > run.sol(found[0] - 1e-9).v[2]


def test_an_impact_on_a_pendulum_keeps_the_energy_and_the_pin() -> None:
    """It hits a wall below the pin with restitution 1: the angle's rate is reversed, the pin takes its share."""
    wall = sr.Event("rod.x", direction=-1, reset=sr.Impact(1.0), name="wall")
    run = sr.simulate(pendulum(), until=2.0, events=wall, method=sr.Radau(rtol=1e-8, atol=1e-10))
    assert run.success, run.message
    hit = run.events[0]
    assert np.allclose(hit.after, -hit.v, atol=1e-9)
    system = run.system
    assert abs(system.Phi_q_xi(hit.q, hit.after)).max() < 1e-11
    assert system.kinetic_energy(hit.q, hit.after) == pytest.approx(
        system.kinetic_energy(hit.q, hit.v), rel=1e-11
    )
    assert run["rod"].position[:, 0].min() > -1e-9


def test_a_joint_angle_and_velocities_of_ones_own() -> None:
    stop = sr.Event("pin.angle - 0.7", direction=1, reset=lambda t, q, v: 0 * v)
    run = sr.simulate(pendulum(), until=0.8, events=stop)
    assert run.success, run.message
    assert run.system.joint("pin").angle(run.events[0].q) == pytest.approx(0.7, abs=1e-11)
    assert np.all(run.events[0].after == 0)


def test_velocities_overwritten_in_place_are_those_after() -> None:
    def halved(t, q, v):
        q[:] = 0.0
        v *= 0.5
        return v

    run = sr.simulate(ball(), until=0.5, events=sr.Event("ball.z - 0.5", reset=halved))
    hit = run.events[0]
    assert hit.v[2] == pytest.approx(-np.sqrt(G))
    assert hit.q[2] == pytest.approx(0.5)
    assert np.array_equal(hit.after, 0.5 * hit.v)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("method", METHODS)
def test_a_function_may_overwrite_the_state_that_it_is_given(method: object) -> None:
    def low(t, q, v):
        q[2] -= 0.5
        v[:] = 0.0
        return q[2]

    events = [sr.Event(function, terminal=True) for function in (low, lambda t, q, v: q[2] - 0.5)]
    found, plain = (sr.simulate(ball(), until=1.0, events=event, method=method) for event in events)
    assert found.events[0].t == plain.events[0].t
    assert np.array_equal(found.q, plain.q)
    assert np.array_equal(found.v, plain.v)


@pytest.mark.parametrize(
    "velocities", [lambda v: None, lambda v: v[:3], lambda v: v + np.inf, lambda v: ["a"] * len(v)]
)
def test_a_reset_that_returns_no_velocities_is_refused(velocities: object) -> None:
    hit = sr.Event("ball.z - 0.5", reset=lambda t, q, v: velocities(v), name="hit")
    sentence = "the reset of the event hit must return 7 finite velocities. Return a new array."
    with pytest.raises(ValueError, match=sentence):
        sr.simulate(ball(), until=0.5, events=hit)


def test_an_impact_along_an_angle_counts_its_turns() -> None:
    """A rotor has turned by more than half a turn when it is struck together with a mass."""
    rotor = sr.Body("rotor", mass=1.0, inertia=(1, 1, 1), angular_velocity=(0, 0, 2))
    mass = sr.Body("mass", mass=1.0, inertia=(1, 1, 1), velocity=(3, 0, 0))
    pin = sr.Revolute("pin", sr.ground, rotor, point=(0, 0, 0), axis=(0, 0, 1))
    system = sr.System(sr.Model("struck", bodies=[rotor, mass], joints=[pin]))
    hit = sr.Event("t - 2.5", reset=sr.Impact(1.0, along="0.5*pin.angle^2 + mass.x"))
    run = sr.simulate(system, until=2.6, events=hit, method=sr.ODE(rtol=1e-10, atol=1e-12))
    rate, speed = run.joint("pin").rate[-1], run["mass"].velocity[-1, 0]
    impulse = (rate - 2) / 5.0
    assert speed - 3 == pytest.approx(impulse, rel=1e-6)
    assert 5.0 * rate + speed == pytest.approx(-(5.0 * 2 + 3), rel=1e-6)


def test_a_ball_bounces_on_a_plate_that_moves() -> None:
    """The rate that is reversed is that of the distance from the plate, 0.1 sin 9t."""
    plate = sr.Event("ball.z - 0.1*sin(9*t)", direction=-1, reset=sr.Impact(0.8))
    run = sr.simulate(ball(), until=1.5, events=plate, method=sr.Radau(rtol=1e-10, atol=1e-12))

    def flown(x: float, t: float, z: float, speed: float) -> float:
        return z + (x - t) * (speed - G / 2 * (x - t))

    t, z, speed = 0.0, 1.0, 0.0
    for event in run.events:
        start = (t, z, speed)
        t = brentq(lambda x, s=start: flown(x, *s) - 0.1 * np.sin(9 * x), t + 0.1, t + 1)
        z, own = 0.1 * np.sin(9 * t), 0.9 * np.cos(9 * t)
        speed = own - 0.8 * (start[2] - G * (t - start[0]) - own)
        assert (event.t, event.after[2]) == pytest.approx((t, speed), abs=1e-9)
    assert len(run.events) >= 2


def test_impacts_that_accumulate_end_with_a_sentence() -> None:
    floor = sr.Event("ball.z", direction=-1, reset=sr.Impact(0.5))
    run = sr.simulate(ball(), until=3.0, events=floor)
    assert not run.success
    assert run.status == "switches crowd"
    assert run.message.startswith("ball.z: switches crowd at t = 1.3")
    assert "come to rest in finite time" in run.message
    assert run.t[-1] < 3 * np.sqrt(2 / G)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"direction": 2}, "must be -1, 0 or 1"),
        ({"function": 3.0}, "needs a formula or a function"),
        ({"function": lambda t, q, v: t, "reset": sr.Impact()}, "needs a direction. Give one, as in Impact"),
    ],
)
def test_wrong_events_are_refused(wrong: dict, sentence: str) -> None:
    with pytest.raises((ValueError, TypeError), match=sentence):
        sr.Event(**{"function": "ball.z", **wrong})


def test_an_unknown_output_is_named() -> None:
    with pytest.raises(KeyError, match=r"has no output 'bal\.z'"):
        sr.simulate(ball(), until=1.0, events=sr.Event("bal.z"))


@pytest.mark.parametrize("method", METHODS, ids=lambda m: type(m).__name__)
def test_the_motion_is_known_at_any_time(method: object) -> None:
    system = slider_crank()
    run = sr.simulate(
        system, until=2.0, t_eval=[0.0, 2.0], method=replace(method, rtol=1e-9, atol=1e-11), store="dense"
    )
    exact = sr.simulate(
        system, until=2.0, t_eval=np.linspace(0, 2, 37), method=sr.ODE(rtol=1e-12, atol=1e-13)
    )
    state = run.sol(exact.t[::-1])
    assert np.allclose(state.q, exact.q[::-1], atol=1e-5)
    assert np.allclose(state.v, exact.v[::-1], atol=1e-4)
    one = run.sol(1.234)
    assert abs(system.Phi(one.q)).max() < 1e-12
    assert abs(system.Phi_q_xi(one.q, one.v)).max() < 1e-12
    with pytest.raises(ValueError, match="known from t = 0 to 2"):
        run.sol(2.1)


@pytest.mark.parametrize("method", METHODS, ids=lambda m: type(m).__name__)
def test_states_given_out_satisfy_the_equations_of_motion(method: object) -> None:
    system = slider_crank()
    run = sr.simulate(system, until=1.0, t_eval=np.linspace(0, 1, 41), method=method)
    for q, v, a, lam in zip(run.q, run.v, run.a, run.lam, strict=True):
        left = system.M_a(q, a) + system.Phi_qT_lam(q, lam)
        assert np.allclose(left, system.Q(q, v) + system.S(q, v), rtol=0, atol=1e-9)
        assert np.allclose(system.Phi_q_xi(q, a), system.gamma(q, v), rtol=0, atol=1e-9)
    assert run.velocity_violation.max() < 1e-12
    assert run.kinetic_energy[-1] == pytest.approx(system.kinetic_energy(run.q[-1], run.v[-1]))
    assert run.potential_energy[-1] == pytest.approx(system.potential_energy(run.q[-1]))


def pushed() -> sr.System:
    """A mass that is pushed along x by 2 (t - 0.3) N; the law is a table from 0.25 s to 0.75 s."""
    mass = sr.Body("mass", mass=1.0, inertia=(1, 1, 1))
    law = [[x, 2 * (x - 0.3)] for x in (0.25, 0.3, 0.5, 0.75)]
    push = sr.PointForce("push", mass.point(0, 0, 0), force=(law, 0.0, 0.0))
    return sr.System(sr.Model("pushed", bodies=[mass], forces=[push]))


@pytest.mark.filterwarnings("ignore:push. its table ends at 0.25 and 0.75")
@pytest.mark.parametrize("method", METHODS, ids=lambda m: type(m).__name__)
def test_points_of_tables_and_breakpoints_are_hit(method: object) -> None:
    run = sr.simulate(ball(), until=1.0, events=[0.123, 0.77], method=method)
    for jump in (0.123, 0.77):  # a step ends 1e-14 before it, so that no stage is on its other side
        assert 0 < (jump - run.history[:, 0])[run.history[:, 0] <= jump].min() < 3e-14
    run = sr.simulate(pushed(), until=1.0, method=method)
    assert {0.25, 0.3, 0.5, 0.75} <= set(run.history[:, 0])
    with pytest.raises(ValueError, match="a breakpoint among events must be"):
        sr.simulate(ball(), until=1.0, events=[np.nan])


def test_tolerances_by_kind_and_by_coordinate() -> None:
    system = slider_crank()
    loose = {"position": 1e-4, "orientation": 1e-4}
    runs = [
        sr.simulate(system, until=1.0, method=sr.Radau(rtol=1e-4, atol=atol))
        for atol in (1e-4, loose, np.full(system.nq, 1e-4), {**loose, "velocity": 1e-5})
    ]
    assert runs[0].nsteps == runs[1].nsteps == runs[2].nsteps < runs[3].nsteps
    with pytest.raises(ValueError, match="by kind needs"):
        sr.simulate(system, until=1.0, method=sr.Radau(atol={"speed": 1e-3}))
    with pytest.raises(ValueError, match="21 numbers, one for each coordinate"):
        sr.simulate(system, until=1.0, method=sr.Radau(atol=[1e-3, 1e-4]))


def test_first_and_longest_steps() -> None:
    run = sr.simulate(ball(), until=1.0, method=sr.Radau(first_step=0.003, max_step=0.02))
    assert run.history[0, 1] == pytest.approx(0.003)
    assert run.history[:, 1].max() <= 0.02 * (1 + 1e-12)


def test_an_event_of_a_velocity_that_its_own_reset_changes_happens_once() -> None:
    """The function is away from zero after it, on the other side than its change with the place alone tells."""
    fast = sr.Event(lambda t, q, v: -v[2] - q[2], reset=lambda t, q, v: 0.5 * v, name="fast")
    run = sr.simulate(ball(), until=0.12, events=fast)
    assert run.success
    assert len(run.events) == 1
    assert run.events[0].t == pytest.approx(np.sqrt(1 + 2 / 9.81) - 1, abs=1e-9)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("direction", [0, -1])
@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau(), sr.ODE("DOP853"), sr.HHT(step=1e-3)])
def test_events_at_the_same_time_all_happen(method: object, direction: int) -> None:
    """Three balls fall side by side; round-off decides which of them is found at the floor first."""
    balls = [
        sr.Body(n, mass=1, inertia=(1, 1, 1), position=(x, 0, 1))
        for x, n in enumerate(("one", "two", "three"))
    ]
    floor = [sr.Event(f"{b.name}.z", direction=direction, reset=sr.Impact(0.8)) for b in balls]
    system = sr.System(sr.Model("balls", bodies=balls, gravity=(0, 0, -9.81)))
    run = sr.simulate(system, until=1.3, events=floor, method=method)
    first = np.sqrt(2 / 9.81)
    assert [event.t for event in run.events] == pytest.approx([first] * 3 + [2.6 * first] * 3)
    assert [len({event.name for event in run.events[k : k + 3]}) for k in (0, 3)] == [3, 3]
    assert all(run[b.name].position[:, 2].min() > -1e-9 for b in balls)


def test_an_impact_where_a_parallelogram_lies_flat_ends_with_a_status() -> None:
    """There is no choice of independent equations: multipliers stay, and the motion goes on or says why not."""

    def upright(name: str, x: float) -> sr.Body:
        turned = {"orientation": sr.AxisAngle((0, 0, 1), np.pi / 2), "angular_velocity": (0, 0, -2)}
        return sr.Body(
            name, mass=1, inertia=(0.1, 0.1, 0.1), position=(x, 0.5, 0), velocity=(1, 0, 0), **turned
        )

    one, other = upright("one", 0.0), upright("other", 2.0)
    coupler = sr.Body(
        "coupler",
        mass=1,
        inertia=(0.1, 0.1, 0.1),
        position=(1, 1, 0),
        velocity=(2, 0, 0),
        angular_velocity=(0, 0, 0),
    )
    pairs = [(sr.ground, one, 0, 0), (one, coupler, 0, 1), (coupler, other, 2, 1), (sr.ground, other, 2, 0)]
    pins = [
        sr.Revolute(f"pin_{n}", a, b, point=(x, y, 0), axis=(0, 0, 1)) for n, (a, b, x, y) in enumerate(pairs)
    ]
    system = sr.System(sr.Model("parallelogram", [one, coupler, other], pins))
    flat = sr.Event("one.y", reset=sr.Impact(0.5, along="pin_0.angle"), name="flat")
    run = sr.simulate(
        system, until=1.2, t_eval=[1.2], events=flat, method=sr.HHT(step=1e-3, rtol=1e-6, atol=1e-8)
    )
    assert run.events[0].name == "flat"
    assert run.success or "singular" in run.message


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("function", ["ball.z", "2*ball.z"])
def test_an_event_at_the_time_of_an_impact_does_not_depend_on_the_order(order: int, function: str) -> None:
    ball = sr.Body("ball", 1.0, (1, 1, 1), (0, 0, 1))
    system = sr.System(sr.Model("m", [ball], gravity=(0, 0, -9.81)))
    floor = sr.Event("ball.z", direction=-1, reset=sr.Impact(0.8), name="floor")
    third = sr.Event(function, direction=-1, terminal=3, name="third")
    run = sr.simulate(system, until=5.0, events=[floor, third][::order])
    assert run.status == "event"
    assert [event.name for event in run.events] == ["third", "floor"] * 2 + ["third"]
    fall = np.sqrt(2 / 9.81)
    assert run.events[-1].t == pytest.approx(fall * (1 + 2 * 0.8 + 2 * 0.64), rel=1e-9)


@pytest.mark.parametrize(
    "function",
    [
        lambda t, q, v: inf if q[2] < 0 else -inf,
        lambda t, q, v: -1.0 if q[2] < 0 else inf,
        lambda t, q, v: 1 / q[2] if q[2] else inf,
        lambda t, q, v: 1e308 if q[2] < 0 else -inf,
    ],
)
def test_values_that_are_infinite_have_signs(function: object) -> None:
    run = sr.simulate(ball(), until=1.0, events=sr.Event(function, name="floor", terminal=True))
    assert run.status == "event"
    assert run.events[0].t == pytest.approx(np.sqrt(2 / G), abs=1e-12)


@pytest.mark.parametrize("terminal", [False, True])
def test_a_zero_at_the_end_of_the_run_is_a_crossing(terminal: bool) -> None:
    for direction, count in ((0, 1), (1, 1), (-1, 0)):
        end = sr.Event("t - 1", direction=direction, terminal=terminal)
        run = sr.simulate(ball(), until=1.0, events=end)
        assert [event.t for event in run.events] == [1.0] * count
        assert run.status == ("event" if terminal and count else "finished")
    assert not sr.simulate(ball(), run.final, until=2.0, events=end).events, "the next run begins with it"


@pytest.mark.parametrize("store", [False, True])
def test_a_reset_at_the_end_of_the_run_ends_it(store: bool) -> None:
    stop = sr.Event("t - 1", reset=lambda t, q, v: 0 * v, name="stop")
    run = sr.simulate(ball(), until=1.0, events=stop, store="steps" if store else "samples")
    assert (run.status, run.message) == ("event", "ended by the event stop at t = 1 s")
    assert run.final.v[2] == run["ball.velocity.z"][-1] == pytest.approx(-G)
    assert run.events[0].after[2] == 0


def test_a_zero_at_a_breakpoint_is_a_crossing() -> None:
    for function in ("t - 0.5", "0.5 - t"):
        run = sr.simulate(ball(), until=1.0, events=[0.5, sr.Event(function)])
        assert [event.t for event in run.events] == [pytest.approx(0.5, abs=1e-12)]


def test_an_impact_along_a_relative_output_is_refused_with_what_it_takes() -> None:
    a, b = (sr.Body(n, 1.0, (0.1, 0.1, 0.1), position=(0, 0, z)) for n, z in (("a", 0), ("b", 1)))
    event = sr.Event("relative[b, a].z", reset=sr.Impact(0.5))
    with pytest.raises(
        sr.SarrusError, match=r"takes coordinates of bodies.*not 'relative\[b, a\]\.z'.*'b\.z - a\.z'"
    ):
        sr.simulate(sr.System(sr.Model("m", [a, b], [])), until=0.2, events=[event])


def test_two_events_with_one_name_are_refused() -> None:
    ball = sr.Body("ball", 1.0, (1, 1, 1), position=(0, 0, 1))
    events = [sr.Event("ball.z - 0.1", name="bounce"), sr.Event("ball.z - 0.2", name="bounce")]
    with pytest.raises(
        sr.ModelError, match=r'events: two are named "bounce". Give each of them its own name='
    ):
        sr.simulate(sr.System(sr.Model("ball", [ball])), until=0.1, events=events)
