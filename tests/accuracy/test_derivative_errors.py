"""Derivatives of computed steps, whose lengths do not change with parameters, against those of the exact motion.

With the default method their relative errors are of the size that the error estimate of the value reports.
"""

from __future__ import annotations

from functools import partial
from itertools import permutations
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from tests.accuracy.test_growth import double_pendulum

import sarrus as sr
from sarrus.analyses.sensitivity.accuracy.state_errors import OF_DERIVATIVES, SUMS, SumErrors, sums
from sarrus.analyses.sensitivity.events.chains import chain_of
from sarrus.analyses.sensitivity.parameters.parameters import Parameters

AMPLITUDE, UNTIL = 0.1, 5.0


def oscillator() -> sr.System:
    body = sr.Body("b", 1.0, (1, 1, 1), position=(1 + AMPLITUDE, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=40.0, length=1.0)
    guide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    return sr.System(sr.Model("oscillator", [body], [guide], [spring]))


def exact(k: mp.mpf, m: mp.mpf) -> mp.mpf:
    """The place at the end."""
    return 1 + mp.mpf("0.1") * mp.cos(mp.sqrt(k / m) * 5)


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-7, 1e-9])
def test_derivatives_are_as_wrong_as_the_value_is_reported_to_be(rtol: float) -> None:
    run = sr.simulate(oscillator(), until=UNTIL, rtol=rtol, store_steps=True)
    names = ["s.k", "b.mass"]
    gradient, hessian = (
        sr.sensitivity(run, "b.x", names, error=True),
        sr.hessian(run, "b.x", names, error=True),
    )
    with mp.workdps(30):
        first = np.array([float(mp.diff(exact, (40, 1), n)) for n in ((1, 0), (0, 1))])
        orders = ((2, 0), (1, 1)), ((1, 1), (0, 2))
        second = np.array([[float(mp.diff(exact, (40, 1), n)) for n in row] for row in orders])
    reported = gradient.errors[0].error / AMPLITUDE
    assert hessian.error is not None
    assert hessian.error.error == pytest.approx(gradient.errors[0].error, rel=1e-6)
    for found, wanted in ((gradient.matrix[0], first), (hessian.matrix, second)):
        error = abs(found - wanted).max() / abs(wanted).max()
        assert error < 3 * reported
    assert abs(hessian.matrix - second).max() > 0.1 * reported * abs(second).max()


@pytest.mark.one_in(8)
@pytest.mark.filterwarnings("ignore:.*derivatives have")
@pytest.mark.parametrize(("rtol", "wrong"), [(1e-3, True), (1e-4, True), (1e-6, True), (1e-9, False)])
def test_derivatives_without_digits_warn(rtol: float, wrong: bool) -> None:
    """A double pendulum over 5 s by a method of order two, whose value is right to 5e-3 of its size at 1e-6."""
    exact = sr.simulate(double_pendulum(), until=5.0, rtol=1e-11, store_steps=True)
    run = sr.simulate(double_pendulum(), until=5.0, rtol=rtol, method=sr.HHT(), store_steps=True)
    names = ["a.mass", "b.mass"]
    directly = partial(sr.sensitivity, method="direct")
    for analysis in (sr.sensitivity, directly, sr.hessian):
        truth, found = analysis(exact, "b.x", names).matrix, analysis(run, "b.x", names, error=True)
        error = abs(found.matrix - truth).max() / abs(truth).max()
        assert (error > 0.1) == wrong
        assert any("derivatives have" in one for one in found.warnings) == wrong
        assert analysis(exact, "b.x", names, error=True).warnings == ()


DOUBLE = [
    (2.0, sr.Radau(), 1e-5), (8.0, sr.Radau(), 1e-9), (10.0, sr.Radau(), 1e-8), (2.0, sr.HHT(), 1e-6),
    (4.0, sr.HHT(), 1e-6), (6.0, sr.HHT(), 1e-8), (3.0, sr.GeneralizedAlpha(), 1e-5),
    (6.0, sr.HHT(stabilized=True), 1e-6),
]  # fmt: skip


@pytest.mark.one_in(4)
@pytest.mark.filterwarnings("ignore:.*(derivatives have|errors have grown)")
@pytest.mark.parametrize(("until", "method", "rtol"), DOUBLE)
def test_relative_errors_of_derivatives_do_not_grow_with_the_adjoint(
    until: float, method: object, rtol: float
) -> None:
    """The adjoint grows by factors from 3 to 1e6 in these runs, whose derivatives are off by 1e-6 to 0.5."""
    names = ["a.mass", "b.mass", "a.inertia.zz"]
    runs = (
        sr.simulate(double_pendulum(), until=until, store_steps=True, **settings)
        for settings in ({"rtol": 1e-12}, {"rtol": rtol, "method": method})
    )
    truth, found = (sr.sensitivity(run, "b.x", names, error=True) for run in runs)
    error = abs(found.matrix - truth.matrix).max() / abs(truth.matrix).max()
    assert error / 10 < found.relative_errors[0] < 30 * error


# b.x of a double pendulum, and its derivatives by the first mass: in 45 digits, by extrapolation with complex steps
INDEPENDENT = [
    (5.0, 0.38843715524690183, 5.5216254015038582, 2509.23832091),
    (10.0, -0.54544652052343406, 311962.12600132431, -543886054778.0),
]


@pytest.mark.parametrize(("until", "value", "first", "second"), INDEPENDENT)
def test_estimates_against_an_independent_program(
    until: float, value: float, first: float, second: float
) -> None:
    """Default settings: 0.5 % of the gradient after 10 s, 2.6 % of the second derivative, and no warning."""
    run = sr.simulate(double_pendulum(), until=until, store_steps=True)
    gradient = sr.sensitivity(run, "b.x", ["a.mass"], error=True)
    hessian = sr.hessian(run, "b.x", ["a.mass"], error=True)
    assert gradient.values[0] - value == pytest.approx(gradient.errors[0].estimate, rel=0.1)
    for found, truth, estimate in (
        (gradient.matrix, first, gradient.relative_errors[0]),
        (hessian.matrix, second, hessian.relative_error),
    ):
        error = abs(found[0, 0] / truth - 1)
        assert error / 10 < estimate < 10 * error
        assert error < 0.03
    if until == 10.0:  # the errors have one direction by then
        assert gradient.relative_errors[0] == pytest.approx(abs(gradient.matrix[0, 0] / first - 1), rel=0.1)
    assert gradient.warnings == hessian.warnings == ()


def on_stops(stiffness: float = 1e4) -> sr.System:
    """A mass that is thrown to and fro between two stops."""
    body = sr.Body("mass", 1.0, (1, 1, 1), velocity=(2.0, 0, 0))
    where = {"point": (0, 0, 0), "axis": (1, 0, 0)}
    guide = sr.Translational("guide", sr.ground, body, **where)
    stop = sr.DisplacementStop(
        "stop", sr.ground, body, stiffness=stiffness, lower=-0.05, upper=0.05, rounding=1e-3, **where
    )
    return sr.System(sr.Model("stops", [body], [guide], [stop]))


def test_sums_of_states_are_at_constant_times() -> None:
    """Their derivatives are those of states at given times, though nodes move with the corners before them."""
    times, sums_at = np.array([]), []
    for k in (1e4, 1e4 * (1 - 1e-5), 1e4 * (1 + 1e-5)):
        run = sr.simulate(on_stops(k), until=0.3, rtol=1e-11, store_steps=True)
        if not len(times):
            system, steps = run.system, run.steps
            chain = chain_of(system, steps, run.restitutions)
            weights = sums(chain)
            parameters = Parameters(system, ["stop.stiffness"], start=steps.start)
            states = chain.along(*parameters.along(np.eye(1)))
            found = weights.inner(states)[:, 0]
            assert len(steps.pieces) > 5
            rows = np.flatnonzero(abs(weights.q).any(axis=(1, 2)))
            times, by_q, by_v = steps.t[rows], weights.q[rows], weights.v[rows]
            continue
        there = sr.simulate(on_stops(k), until=times[-1], rtol=1e-11, t_eval=np.concatenate([[0.0], times]))
        sums_at.append(np.einsum("njk,nj->k", by_q, there.q[1:]) + np.einsum("njk,nj->k", by_v, there.v[1:]))
    difference = (sums_at[1] - sums_at[0]) / 0.2
    assert found == pytest.approx(difference, rel=2e-3)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*(derivatives have|errors have grown)")
@pytest.mark.parametrize(("rtol", "wrong"), [(1e-4, True), (1e-8, False)])
def test_derivatives_through_contacts_know_their_errors(rtol: float, wrong: bool) -> None:
    """Without being asked: errors add up over contacts, although the adjoint does not grow."""
    names = ["stop.stiffness", "mass.mass"]
    exact = sr.sensitivity(sr.simulate(on_stops(), until=1.0, store_steps=True), "mass.x", names)
    run = sr.simulate(on_stops(), until=1.0, method=sr.HHT(), rtol=rtol, store_steps=True)
    found = sr.sensitivity(run, "mass.x", names)
    error = abs(found.matrix - exact.matrix).max() / abs(exact.matrix).max()
    assert (error > 0.03) == wrong
    assert any("derivatives have" in one for one in found.warnings) == wrong


def thrown() -> sr.System:
    """A ball that is thrown and bounces."""
    ball = sr.Body("b", 1.0, (0.004,) * 3, position=(0, 0, 0.4), velocity=(0.5, 0, 0))
    place = {"radius": 0.1, "stiffness": 2e4, "damping": 0.3, "exponent": 1.5, "rounding": 1e-4}
    floor = sr.SphereContact("floor", ball.point(0, 0, 0), sr.ground.frame((0, 0, 0)), **place)
    return sr.System(sr.Model("ball", [ball], [], [floor], gravity=(0, 0, -9.81)))


BOUNCES = [
    (0.4, {}), (0.9, {}), (0.4, {"rtol": 1e-4}), (0.9, {"rtol": 1e-4}), (0.4, {"method": sr.HHT(), "rtol": 1e-5}),
    (0.5, {"method": sr.HHT(), "rtol": 1e-7}), (0.9, {"method": sr.HHT()}), (0.9, {"method": sr.GeneralizedAlpha()}),
]  # fmt: skip


@pytest.mark.one_in(8)
@pytest.mark.filterwarnings("ignore:.*derivatives have")
@pytest.mark.parametrize(("until", "settings"), BOUNCES)
def test_derivatives_through_short_contacts_know_their_errors(until: float, settings: Any) -> None:
    """These are up to 1000 times as large as those of the states."""
    outputs, names = ["b.z", "b.velocity.z"], ["floor.stiffness", "floor.damping", "b.mass"]
    runs = [
        sr.simulate(thrown(), until=until, store_steps=True, **own) for own in ({"rtol": 1e-12}, settings)
    ]
    for wrt in (names, names[:1]):
        truth, found = (sr.sensitivity(run, outputs, wrt, error=True) for run in runs)
        sizes, stored = np.array([2e4, 0.3, 1.0])[: len(wrt)], found.relative_errors
        off = np.linalg.norm((found.matrix - truth.matrix) * sizes, axis=1)
        true = off / np.linalg.norm(truth.matrix * sizes, axis=1)
        assert (true / 4 < np.array(stored)).all()
        assert (np.array(stored) < 4 * true).all()
        warned = [
            any(m.startswith(title) for m in found.warnings)
            for title in ("final of b.z", "final of b.velocity.z")
        ]
        assert warned == [one > 0.01 for one in stored]
        assert truth.warnings == ()


ORDERS = [*permutations(["floor.damping", "floor.stiffness", "b.mass"])]


@pytest.mark.filterwarnings("ignore:.*derivatives have")
@pytest.mark.parametrize("orders", [ORDERS[:1], pytest.param(ORDERS[1:], marks=pytest.mark.slow)])
def test_errors_through_contacts_are_seen_in_any_order_of_parameters(orders: list[tuple[str, ...]]) -> None:
    """Stiffness and mass may cancel each other in a random change: true errors of both outputs are 2.7 %."""
    run = sr.simulate(thrown(), until=0.4, store_steps=True, method=sr.HHT(), rtol=1e-5)
    for names in orders:
        found, unasked = (
            sr.sensitivity(run, ["b.z", "b.velocity.z"], list(names), error=error) for error in (True, False)
        )
        assert found.relative_errors == pytest.approx([0.027, 0.027], rel=0.1)
        assert len(unasked.warnings) == len(found.warnings) == 2


def test_contacts_cause_a_warning_without_an_estimate() -> None:
    run = sr.simulate(thrown(), until=0.9, method=sr.HHT(), store_steps=True)
    with pytest.warns(sr.SarrusWarning, match="derivatives have about"):
        sr.sensitivity(run, "b.z", ["floor.stiffness"])


@pytest.mark.filterwarnings("ignore:.*derivatives have")
def test_derivatives_of_long_regular_motions_know_their_errors() -> None:
    """A method of order two over 100 periods."""
    run = sr.simulate(oscillator(), until=100.0, method=sr.HHT(), store_steps=True)
    exact = sr.simulate(oscillator(), until=100.0, store_steps=True)
    found, truth = (sr.sensitivity(one, "b.x", ["s.k"]) for one in (run, exact))
    assert abs(found.matrix / truth.matrix - 1) > 0.03
    assert any("errors of the states add up" in one for one in found.warnings)
    assert truth.warnings == ()


def leaning_door(hinges: int) -> sr.System:
    """A door whose axis leans by 0.3 rad swings as a pendulum; a second hinge is redundant."""
    lean, width = 0.3, 0.8
    axis = np.array([np.sin(lean), 0, np.cos(lean)])
    down = np.array([np.cos(lean), 0, -np.sin(lean)])
    wing = np.cos(1.0) * down + np.sin(1.0) * np.cross(axis, down)
    leaf = sr.Body("leaf", 20.0, (1.0, 1.0, 1.0), position=tuple(width / 2 * wing))
    joints = [
        sr.Revolute(f"hinge{n}", sr.ground, leaf, point=tuple(h * axis), axis=tuple(axis))
        for n, h in enumerate((-0.5, 0.5)[:hinges])
    ]
    return sr.System(sr.Model("door", [leaf], joints, gravity=(0, 0, -9.81)))


@pytest.mark.one_in(4)
@pytest.mark.filterwarnings("ignore:.*derivatives have")
@pytest.mark.parametrize("hinges", [1, 2])
@pytest.mark.parametrize("method", ["adjoint", "direct"])
def test_derivatives_that_are_small_at_the_end_are_reported(hinges: int, method: str) -> None:
    """A door that is about to turn back: its angle hardly depends on its mass then, its rate as before."""
    system, names = leaning_door(hinges), ["leaf.mass"]
    run, fine = (
        sr.simulate(system, until=9.92, store_steps=True, **settings)
        for settings in ({"method": sr.HHT()}, {"rtol": 1e-10})
    )
    outputs = ["hinge0.angle", "hinge0.angle.rate"]
    found, truth = (sr.sensitivity(one, outputs, names, error=True, method=method) for one in (run, fine))
    off = abs(found.matrix / truth.matrix - 1)[:, 0]
    assert off[0] > 0.02 > 10 * off[1]
    assert off[0] / 5 < found.relative_errors[0] < 5 * off[0]
    for one in (found, sr.sensitivity(run, outputs, names, method=method)):
        (message,) = one.warnings
        assert message.startswith("final of hinge0.angle: its derivatives have")


def test_the_estimate_is_statistical() -> None:
    """As the guide says: below a third of the size of the errors in about 4 % of cases, above twice in about 1 %."""
    draws = np.random.default_rng(5)
    errors = draws.normal(size=200) / np.sqrt(200)
    signs = draws.choice([-1.0, 1.0], (5000, 200, SUMS))
    every = (SumErrors(errors @ own, np.zeros(SUMS)).of_derivatives()[0] for own in signs)
    found = np.array([*every]) / (OF_DERIVATIVES * np.linalg.norm(errors))
    assert 0.035 < np.mean(found < 1 / 3) < 0.055
    assert 0.004 < np.mean(found > 2) < 0.012


def test_the_estimate_of_a_run_is_repeated() -> None:
    run = sr.simulate(oscillator(), until=1.0, rtol=1e-5, store_steps=True)
    first, again = (sr.sensitivity(run, "b.x", ["s.k"], error=True).relative_errors for _ in range(2))
    assert first == again


@pytest.mark.one_in(4)
@pytest.mark.parametrize("rtol", [None, 1e-8, 1e-10, 1e-12])
def test_second_derivatives_through_a_stop_have_the_round_off_of_its_corners(rtol: float | None) -> None:
    """z = 0.2 - u (t - 0.2/u - π/ω): smaller tolerances make the steps at the stop shorter, and round-off larger."""
    k, speed = 3e3, 1.5
    body = sr.Body("b", 1.0, (1, 1, 1), velocity=(0, 0, speed))
    guide = sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    place = {"point": (0, 0, 0), "axis": (0, 0, 1), "lower": -1, "upper": 0.2, "rounding": 1e-6}
    stop = sr.DisplacementStop("c", sr.ground, body, stiffness=k, **place)
    settings = {} if rtol is None else {"rtol": rtol}
    system = sr.System(sr.Model("stop", [body], [guide], [stop]))
    run = sr.simulate(system, until=0.3, store_steps=True, **settings)
    found = sr.hessian(run, sr.Final("b.z"), ["c.stiffness"], error=True)
    true = abs(float(np.ravel(found.matrix)[0]) / (0.75 * speed * np.pi * k**-2.5) - 1)
    assert found.relative_error is not None
    assert 0.2 * true < found.relative_error < 30 * max(true, 1e-6)
