"""Gradients of long runs with events by checkpoints: they are those of runs whose steps are all kept."""

from dataclasses import replace

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints
from tests.sensitivity.test_event_kinds import DRIVEN, ELBOW, EVENTS, TOLD, driven, names, passed, responses
from tests.sensitivity.test_events import BALL, BOUNCE, ball, falling
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.sensitivity import long_run
from sarrus.analyses.sensitivity.responses.responses import Response
from sarrus.functions import exp
from sarrus.results import Segments, StepsTaken

METHODS = [sr.HHT(), sr.GeneralizedAlpha(0.8), sr.Radau()]
# of velocities, accelerations and forces of the α methods over short steps: so much forward and backward sweeps differ
ROUND_OFF = 1e-8
SMOOTH = ("final of slider.x", "integral", "maximum of pin.angle", "final of tip.x")
AT_BOUNCES = [
    sr.AtEvent("t", event="bounce", number=2),
    sr.AtEvent("ball.velocity.z", event="bounce", number=2, after=True),
]
OVER_ALL = [
    sr.Final("ball.z"),
    sr.Integral("energy.kinetic"),
    sr.Maximum("ball.velocity.z"),
    sr.Maximum("ball.z"),
    sr.Misfit("ball.z", at=(0.6, 0.2, 1.1), data=(0.9, 0.1, 0.4)),
]


@pytest.fixture
def marked(monkeypatch: pytest.MonkeyPatch) -> list[long_run.LongRun]:
    """The long runs of a test."""
    found: list[long_run.LongRun] = []
    interval = long_run.LongRun.interval

    def noted(self: long_run.LongRun, n: int) -> long_run.Interval:
        found.append(self)
        return interval(self, n)

    monkeypatch.setattr(long_run.LongRun, "interval", noted)
    return found


def compared(
    system: sr.System,
    told: list[Response],
    wrt: list[str],
    limit: float = 1e-12,
    of_values: float = 1e-12,
    **settings: object,
) -> sr.Gradient:
    """By checkpoints and by all steps."""
    memory = {name: settings.pop(name) for name in ("memory",) if name in settings}
    run = sr.simulate(system, t_eval=[settings["until"]], store="steps", **settings)
    wanted = sr.sensitivity(run, told, wrt)
    found = by_checkpoints(system, told, wrt, **settings, **memory)
    assert (found.responses, found.names) == (wanted.responses, wanted.names)
    assert np.array_equal(found.at, wanted.at)
    assert np.allclose(found.values, wanted.values, rtol=of_values, atol=0)
    scale = np.maximum(abs(wanted.matrix).max(axis=1, keepdims=True), 1e-4)  # of zeros: round-off
    differences = abs(found.matrix - wanted.matrix) / scale
    assert np.all(differences <= limit), differences
    return found


@pytest.mark.one_in(32)
@pytest.mark.parametrize(("method", "first"), [*zip(METHODS, (5, 7, 5), strict=True)])
@pytest.mark.parametrize("kind", EVENTS)
def test_every_kind_of_event(
    kind: str, method: object, first: int, monkeypatch: pytest.MonkeyPatch, marked: list[long_run.LongRun]
) -> None:
    """Forces and accelerations among the responses, and intervals so short that they need the nodes before them."""
    monkeypatch.setattr(long_run, "FIRST", first)
    limit = 1e-12 if isinstance(method, sr.Radau) else ROUND_OFF
    settings = {"until": 0.4, "method": replace(method, rtol=1e-6, atol=1e-8)}
    compared(slider_crank(), responses(kind), names(kind), limit, events=EVENTS[kind], **settings)
    places = [point.place for point in marked[0]._points]
    assert any(place.step for place in places[1:])


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_motions_that_depend_on_time(method: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_run, "FIRST", 5)
    # a step of Radau from a checkpoint has new factors, with which its iteration ends elsewhere within its tolerance
    compared(driven({}), TOLD, DRIVEN, ROUND_OFF, 1e-10, until=2.2, events=ELBOW, method=method)


@pytest.mark.one_in(9)
@pytest.mark.parametrize("first", [12, 4, 400])
@pytest.mark.parametrize("method", METHODS)
def test_a_bouncing_ball(method: object, first: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Integrals, extremes and outputs at events, whose times move."""
    monkeypatch.setattr(long_run, "FIRST", first)
    settings = {"until": 2.0, "events": BOUNCE, "method": replace(method, max_step=0.02)}
    compared(ball(), [*OVER_ALL, *AT_BOUNCES], [*BALL.values()], **settings)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("until", "step"), [(1.3, 0.02), (2.0, 0.01)])
def test_a_checkpoint_just_after_an_event(
    until: float, step: float, monkeypatch: pytest.MonkeyPatch, marked: list[long_run.LongRun]
) -> None:
    monkeypatch.setattr(long_run, "FIRST", 12)
    settings = {"until": until, "events": BOUNCE, "method": sr.HHT(step=step)}
    compared(ball(), [*OVER_ALL, *AT_BOUNCES], [*BALL.values()], **settings)
    assert any(point.place.segment and not point.place.step for point in marked[0]._points)


def test_extremes_within_long_steps_have_samples_within_them() -> None:
    """A bump between two nodes, with its top half-way between them."""
    bump = sr.Maximum(lambda o: o("ball.z") * exp(-(((o("t") - 0.15) / 0.06) ** 2)), name="bump")
    found = by_checkpoints(ball(), bump, ["ball.position.z"], until=0.3, method=sr.HHT(step=0.1))
    assert found.values == pytest.approx(1 + 0.5 * 0.15 - 9.81 * 0.15**2 / 2, rel=0.1)
    assert found.matrix == pytest.approx(1.0, rel=0.1)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("method", [sr.HHT(), sr.GeneralizedAlpha()])
def test_integrals_over_long_steps_have_samples_within_them(
    method: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The ends of twenty steps of a ball that falls are too few for its kinetic energy, which Lobatto's rule has."""
    monkeypatch.setattr(long_run, "FIRST", 12)
    energy, given = sr.Integral("energy.kinetic"), {"until": 2.0, "events": BOUNCE}
    run = sr.simulate(ball(), method=sr.Radau(rtol=1e-11), store="steps", **given)
    exact = sr.sensitivity(run, [energy, sr.Final("ball.z")], [*BALL.values()])
    found = by_checkpoints(ball(), [energy, sr.Final("ball.z")], [*BALL.values()], method=method, **given)
    assert (found.responses, found.units, found.warnings) == (exact.responses, exact.units, ())
    np.testing.assert_allclose(found.values, exact.values, rtol=1e-8)
    np.testing.assert_allclose(found.matrix, exact.matrix, rtol=1e-7)


def slower(t, q, v):
    return 0.5 * v


@pytest.mark.one_in(2)
@pytest.mark.parametrize("method", [sr.HHT(step=0.125), sr.GeneralizedAlpha(step=0.125)])
def test_an_event_at_the_very_node_of_a_checkpoint(
    method: object, monkeypatch: pytest.MonkeyPatch, marked: list[long_run.LongRun]
) -> None:
    """It is found among the steps after the checkpoint, at their beginning."""
    monkeypatch.setattr(long_run, "FIRST", 5)
    event = sr.Event("t - 0.625", reset=slower, name="brake")
    told = [sr.Final("slider.x"), sr.Integral("slider.x"), sr.AtEvent("slider.x", event="brake")]
    compared(
        slider_crank(),
        told,
        ["spring.k", "gravity.z"],
        1e-9,
        until=1.5,
        events=event,
        method=replace(method, rtol=1e-10),
    )
    assert any(point.place == (0, 5) for point in marked[0]._points)
    assert len(marked[0].course.t[0]) == 6


@pytest.mark.parametrize("method", [sr.HHT(), sr.Radau()])
def test_two_events_at_once_and_one_that_changes_nothing(method: object) -> None:
    system, floor = falling("one", "other")
    events = [*floor, sr.Event("one.z - 0.3", name="low")]
    told = [sr.Final("one.z"), sr.Integral("other.velocity.z")]
    wrt = ["one.position.z", "other_hits.restitution", "gravity.z"]
    compared(system, told, wrt, until=1.0, events=events, method=method)


@pytest.mark.parametrize(
    ("method", "first"),
    [(sr.HHT(step=0.02), 10), (sr.Radau(), 3), pytest.param(sr.HHT(step=0.02), 3, marks=pytest.mark.slow)],
)
def test_an_event_that_ends_the_run(method: object, first: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_run, "FIRST", first)
    events = [BOUNCE, sr.Event("ball.z - 0.3", direction=-1, terminal=3, name="low")]
    told = [sr.Final("t"), sr.AtEvent("ball.z", event="low"), sr.Integral("ball.z")]
    found = compared(
        ball(), told, ["bounce.restitution", "gravity.z"], until=9.0, events=events, method=method
    )
    assert found.values[0] < 9.0


@pytest.mark.one_in(2)
@pytest.mark.parametrize("first", [24, 6])
def test_turns_of_angles_at_events(first: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """An event that needs the turns made before it, and a response that needs them after it."""
    monkeypatch.setattr(long_run, "FIRST", first)
    wound = sr.Event("pin.angle^2 + 20*slider.x - 98", direction=-1, reset=slower, name="wound")
    told = [sr.Final("pin.angle"), sr.AtEvent("pin.angle", event="wound"), sr.Integral("pin.angle")]
    settings = {"method": sr.Radau(rtol=1e-6, atol=1e-8)}
    found = compared(slider_crank(), told, ["ball.point.z", "spring.k"], until=3.0, events=wound, **settings)
    assert found.values[1] > np.pi


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("told", "passes"), [("pin.angle", 2), ("slider.x", 1), (sr.Integral("pin.angle"), 2)]
)
def test_how_often_the_run_is_taken_again(
    told: object, passes: int, monkeypatch: pytest.MonkeyPatch, marked: list[long_run.LongRun]
) -> None:
    """Once backwards; and once forwards where turns are counted, or the weights of a response depend on the motion."""
    monkeypatch.setattr(long_run, "FIRST", 6)
    by_checkpoints(slider_crank(), told, ["spring.k"], until=0.8, method=sr.HHT(rtol=1e-8, atol=1e-10))
    count = len(marked[0])
    assert count > 5
    assert passes * count - 1 <= len(marked) <= passes * count


@pytest.mark.slow
def test_many_impacts_in_little_memory(marked: list[long_run.LongRun]) -> None:
    """Intervals then hold many events, and checkpoints are dropped."""
    many = sr.Event("ball.z", direction=-1, reset=sr.Impact(0.99), name="bounce")
    settings = {"until": 40.0, "events": many, "method": sr.HHT()}
    compared(ball(), [sr.Final("ball.z")], ["gravity.z", "bounce.restitution"], 1e-10, memory=4e5, **settings)
    run = marked[0]
    assert len(run.course.event_steps) > 50
    assert 1 < len(run) < 30


@pytest.mark.slow
def test_many_steps_between_few_impacts(marked: list[long_run.LongRun]) -> None:
    settings = {"until": 1.3, "events": BOUNCE, "method": sr.HHT(step=5e-4)}
    compared(ball(), OVER_ALL, [*BALL.values()], 1e-12, memory=2e6, **settings)
    assert len(marked[0].course.event_steps) == 2
    assert len(marked[0]) > 4


@pytest.mark.parametrize(
    ("event", "response", "told"),
    [
        (sr.Event("ball.z", direction=-1, reset=sr.Impact(0.5), name="bounce"), "ball.z", "come to rest"),
        (BOUNCE, sr.At("ball.z", time=3.0), "times must be between 0 and 2 s"),
        (BOUNCE, sr.AtEvent("ball.z", event="hit"), r"the run has 0 events 'hit' .*; it has bounce"),
        (
            sr.Event(lambda t, q, v: float(q[2]), terminal=True, name="floor"),
            "t",
            "cannot be differentiated through",
        ),
    ],
)
def test_what_has_no_gradient(event: sr.Event, response: object, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        by_checkpoints(ball(), response, ["gravity.z"], until=2.0, events=event)


def test_too_little_memory_for_the_events() -> None:
    many = sr.Event("ball.z", direction=-1, reset=sr.Impact(0.99), name="bounce")
    with pytest.raises(ValueError, match=r"too few at t = .* give more than memory="):
        by_checkpoints(ball(), "ball.z", ["gravity.z"], until=40.0, events=many, memory=1.5e5)


def test_functions_of_events_are_called_in_the_first_run_only() -> None:
    called: list[float] = []

    def near(t, q, v):
        called.append(t)
        return passed(t, q, v)

    event = sr.Event(near, terminal=True, name="near")
    sr.simulate(slider_crank(), until=0.4, events=event, t_eval=[0.4], store="steps")
    once = len(called)
    by_checkpoints(slider_crank(), "t", ["spring.k"], until=0.4, events=event)
    recorded = 3  # at the event, and at both ends of its step
    assert len(called) == 3 * once + recorded  # without and with checkpoints


def test_steps_up_to_an_event_hold_no_room_for_others() -> None:
    """Of many short segments each would hold that of a whole call of the method."""
    run = sr.simulate(ball(), until=2.0, events=BOUNCE, store="steps")
    segments = run.steps.segments[:-1]
    assert len(segments) > 2
    for segment in segments:
        for array in (getattr(segment, name) for name in ("t", "h", "q", "v", "a", "lam", "memory")):
            assert array.base.base is None  # a view that cannot be written
            assert array.base.nbytes == array.nbytes


@pytest.mark.one_in(8)
@pytest.mark.parametrize(("events", "first"), [([], 7), ([EVENTS["formula"]], 5), ([EVENTS["formula"]], 60)])
@pytest.mark.parametrize("method", METHODS)
def test_steps_taken_again_are_those_of_the_run_bit_by_bit(
    method: object, events: list[sr.Event], first: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of intervals without events, with one at their end, and with some in the midst of them."""
    monkeypatch.setattr(long_run, "FIRST", first)
    system = slider_crank()
    run = sr.simulate(
        system,
        until=0.8,
        t_eval=[0.8],
        store="steps",
        method=replace(method, rtol=1e-6, atol=1e-8),
        events=events,
    )
    recipe = long_run.recipe_with_steps(
        system, sr.assemble(system), 0.8, method=replace(method, rtol=1e-6, atol=1e-8), events=events
    )
    long = long_run.LongRun(recipe, 1e8, 1)
    parts: list[list[StepsTaken]] = [[] for _ in long.course.t]
    for n in range(len(long)):
        again = long.interval(n).steps
        for k, segment in enumerate(again.segments if isinstance(again, Segments) else (again,)):
            parts[long.begin(n).segment + k].append(segment)
    assert len(long) < len(parts) if first > 7 else max(map(len, parts)) > 1
    segments = run.steps.segments if isinstance(run.steps, Segments) else (run.steps,)
    assert len(segments) == len(parts)
    for segment, found in zip(segments, parts, strict=True):
        for name in ("t", "q", "v", "a", "lam"):
            assert np.array_equal(
                np.concatenate([getattr(part, name)[1:] for part in found]), getattr(segment, name)[1:]
            )
