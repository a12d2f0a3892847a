"""Steps end at the corners of forces where this is wanted."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints

import sarrus as sr
from sarrus.functions import sign

NAMES = ["b.position.z"]


def ball() -> sr.System:
    """A ball that falls on the ground and comes up again within half a second."""
    body = sr.Body("b", mass=1.0, inertia=(0.004,) * 3, position=(0, 0, 0.4))
    law = {"stiffness": 2e4, "damping": 0.3, "exponent": 1.5, "rounding": 1e-4}
    floor = sr.SphereContact("floor", body.point(0, 0, 0), sr.ground.frame((0, 0, 0)), radius=0.1, **law)
    return sr.System(sr.Model("ball", [body], [], [floor], gravity=(0, 0, -9.81)))


def sprung(**laws: Any) -> sr.System:
    """A mass on a spring along z, whose length passes 2 m again and again."""
    body = sr.Body("b", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 2.3))
    slide = sr.Translational("slide", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    given = {"k": 40.0, "length": 2.0} | laws
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), **given)
    return sr.System(sr.Model("sprung", [body], [slide], [spring]))


def run(system: sr.System, until: float = 0.5, tolerance: float = 1e-6, **settings: Any) -> sr.Trajectory:
    how = {"method": sr.Radau(rtol=tolerance, atol=tolerance / 100), "store": "steps"}
    how |= settings
    return sr.simulate(system, until=until, **how)


def test_states_of_a_run_whose_steps_end_at_corners() -> None:
    bounced = run(ball())
    found = sr.state_derivatives(bounced, [*NAMES, "floor.stiffness"])
    assert np.sum(np.diff(found.t) == 0) == 4
    assert not found.warnings
    for row in (2, len(found.t) // 2, len(found.t) - 1):
        wanted = sr.sensitivity(bounced, sr.At("b.velocity.z", time=float(found.t[row])), found.names)
        assert found.output("b.velocity.z")[row] == pytest.approx(wanted.matrix[0], rel=1e-8)


@pytest.mark.parametrize("start", [1.25, 1.5, 1.75])
def test_a_force_that_jumps_where_a_step_is_divided(start: float) -> None:
    """x = start + t is 2 m to the last bit at a place at which functions are evaluated; dv/dx behind it is -2 f/m."""
    body = sr.Body("b", 1.0, (0.01,) * 3, position=(start, 0, 0), velocity=(1, 0, 0))
    guide = sr.Translational("guide", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    ends = sr.ground.point(0, 0, 0), body.point(0, 0, 0)
    force = sr.TSDA("force", *ends, length=0.0, k=lambda x: 1e-10 * (sign(x - 2) + 1) / x)
    system = sr.System(sr.Model("jump", [body], [guide], [force]))
    method = sr.Radau(first_step=1.0, max_step=1.0)
    found = sr.simulate(system, until=2.0, method=method, store="steps")
    slope = sr.sensitivity(found, sr.Final("b.velocity.x"), ["b.position.x"]).matrix
    assert slope == pytest.approx(np.array([[-2e-10]]), rel=1e-6, abs=0)


KINKED: dict[str, dict[str, Any]] = {
    "abs": {"k": lambda x: 40 + 60 * abs(x - 2.05)},
    "text": {"k": "40 + 60*max(x - 2.05, 0)"},
    "damping": {"c": lambda v: abs(v)},
    "narrow step": {"k": "step(x, 2.04, 40, 2.0401, 60)"},
}


STIFFNESS, HEIGHT, RADIUS, G = 1e4, 0.5, 0.1, 9.81


def elastic() -> sr.System:
    """A ball of 1 kg above a linear contact without damping, whose rounding changes the motion by 1e-7."""
    body = sr.Body("b", mass=1.0, inertia=(0.004,) * 3, position=(0, 0, HEIGHT))
    law = {"stiffness": STIFFNESS, "damping": 0.0, "exponent": 1.0, "rounding": 1e-6}
    floor = sr.SphereContact("floor", body.point(0, 0, 0), sr.ground.frame((0, 0, 0)), radius=RADIUS, **law)
    return sr.System(sr.Model("elastic", [body], [], [floor], gravity=(0, 0, -G)))


def closed_form(until: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Height after one bounce, gradient and Hessian by stiffness and height: differences of the exact motion."""
    mp = pytest.importorskip("mpmath")

    def z(k: Any, height: Any) -> Any:
        fall = mp.sqrt(2 * (height - mp.mpf(RADIUS)) / G)
        rate = mp.sqrt(k)
        contact = 2 * (mp.pi - mp.atan(rate * fall)) / rate
        rest = until - fall - contact
        return RADIUS + G * fall * rest - G * rest**2 / 2

    with mp.workdps(40):
        at = (mp.mpf(STIFFNESS), mp.mpf(HEIGHT))
        orders = [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
        by_k, by_z, kk, kz, zz = (float(mp.diff(z, at, order)) for order in orders)
        return float(z(*at)), np.array([by_k, by_z]), np.array([[kk, kz], [kz, zz]])


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    ("settings", "first", "second"),
    [
        ({}, 1e-5, 1e-3),
        ({"method": sr.Radau(rtol=1e-9, atol=1e-11)}, 1e-6, 1e-4),
        ({"method": sr.Radau(rtol=1e-6, atol=1e-8)}, 1e-4, 1e-4),
        ({"method": sr.Radau(rtol=1e-4, atol=1e-6)}, 1e-2, 1e-2),
        ({"method": sr.Radau(rtol=1e-3, atol=1e-5)}, 1e-2, 5e-2),
    ],
    ids=["default", "1e-9", "1e-6", "1e-4", "1e-3"],
)
def test_derivatives_through_a_bounce_are_those_of_the_closed_form(
    settings: dict[str, Any], first: float, second: float
) -> None:
    bounced = sr.simulate(elastic(), until=0.5, store="steps", **settings)
    value, gradient, hessian = closed_form(0.5)
    names = ["floor.stiffness", "b.position.z"]
    found = sr.sensitivity(bounced, sr.Final("b.z"), names)
    assert bounced.q[-1][2] == pytest.approx(value, abs=settings["method"].rtol if settings else 1e-6)
    np.testing.assert_allclose(found.matrix[0], gradient, rtol=first)
    curved = sr.hessian(bounced, sr.Final("b.z"), names)
    assert not found.warnings
    assert not curved.warnings
    np.testing.assert_allclose(curved.matrix, hessian, rtol=second)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("kind", ["displacement", "angle"])
@pytest.mark.parametrize(
    ("settings", "first"),
    [({}, 1e-4), ({"method": sr.Radau(rtol=1e-3)}, 1e-2), ({"method": sr.HHT()}, 1e-2)],
    ids=["default", "1e-3", "HHT"],
)
def test_derivatives_through_a_stop_are_those_of_the_closed_form(
    kind: str, settings: dict[str, Any], first: float
) -> None:
    """A unit mass or inertia comes back after half a period: x = 2 l - v (t - π / √k), with v and k of the start."""
    speed, limit, until = 2.0, 0.05, 0.07
    at = {"point": (0, 0, 0), "axis": (0, 0, 1)}
    stop = {**at, "stiffness": STIFFNESS, "lower": -1.0, "upper": limit, "rounding": 1e-6}
    if kind == "angle":
        body = sr.Body("b", 1.0, (1, 1, 1), angular_velocity=(0, 0, speed))
        parts = sr.Revolute("guide", sr.ground, body, **at), sr.AngleStop("stop", sr.ground, body, **stop)
        names, response = ["stop.stiffness", "b.angular_velocity.z"], "guide.angle"
    else:
        body = sr.Body("b", 1.0, (1, 1, 1), velocity=(0, 0, speed))
        guide = sr.Translational("guide", sr.ground, body, **at)
        parts = guide, sr.DisplacementStop("stop", sr.ground, body, **stop)
        names, response = ["stop.stiffness", "b.velocity.z"], "b.z"
    system = sr.System(sr.Model("stop", [body], [parts[0]], [parts[1]]))
    stopped = sr.simulate(system, until=until, store="steps", **settings)
    contact = np.pi / STIFFNESS**0.5
    by_k, by_v = -speed * contact / (2 * STIFFNESS), contact - until
    kk, kv = 3 * speed * contact / (4 * STIFFNESS**2), -contact / (2 * STIFFNESS)
    found = sr.sensitivity(stopped, sr.Final(response), names)
    np.testing.assert_allclose(found.matrix[0], [by_k, by_v], rtol=first)
    curved = sr.hessian(stopped, sr.Final(response), names).matrix * np.outer(*[(STIFFNESS, speed)] * 2)
    scaled = np.array([[kk, kv], [kv, 0.0]]) * np.outer(*[(STIFFNESS, speed)] * 2)
    np.testing.assert_allclose(curved, scaled, atol=first * abs(scaled).max())


# Of the height after 0.5 s of a ball on a damped Hertz contact, by logarithms of stiffness and height: differences of
# the values of runs at rtol 1e-13, extrapolated from three sizes
DAMPED = {
    "gradient": (0.00117372, 0.2029792),
    "hessian": ((-0.00483941, 0.04714419), (0.04714419, -0.65835843)),
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    ("settings", "first", "second"),
    [
        ({}, 3e-6, 1e-4),
        ({"method": sr.Radau(rtol=1e-8, atol=1e-10)}, 1e-5, 3e-4),
        ({"method": sr.Radau(rtol=1e-6, atol=1e-8)}, 1e-4, 1e-3),
        ({"method": sr.Radau(rtol=1e-6)}, 1e-4, 3e-3),
        ({"method": sr.Radau(rtol=1e-4)}, 1e-3, 1e-2),
    ],
    ids=["default", "1e-8", "1e-6 and 1e-8", "1e-6", "1e-4"],
)
@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_derivatives_through_a_hertz_contact(
    mu: float, settings: dict[str, Any], first: float, second: float
) -> None:
    """Errors over the largest entry. The force ends with δ^1.5: second derivatives have half of the digits."""
    body = sr.Body("b", mass=1.0, inertia=(0.004,) * 3, position=(0, 0, 0.4))
    law = {"stiffness": 2e4, "damping": 0.3, "exponent": 1.5, "rounding": 1e-4, "mu": mu}
    floor = sr.SphereContact("floor", body.point(0, 0, 0), sr.ground.frame((0, 0, 0)), radius=0.1, **law)
    system = sr.System(sr.Model("ball", [body], [], [floor], gravity=(0, 0, -9.81)))
    bounced, names = (
        sr.simulate(system, until=0.5, store="steps", **settings),
        ["floor.stiffness", "b.position.z"],
    )
    sizes = np.array([2e4, 0.4])
    gradient = sr.sensitivity(bounced, sr.Final("b.z"), names).matrix[0] * sizes
    hessian = sr.hessian(bounced, sr.Final("b.z"), names).matrix * np.outer(sizes, sizes)
    for found, wanted, limit in ((gradient, DAMPED["gradient"], first), (hessian, DAMPED["hessian"], second)):
        assert abs(found - np.array(wanted)).max() < limit * abs(np.array(wanted)).max()


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()], ids=str)
@pytest.mark.parametrize("memory", [3e6, 1e8])
def test_checkpoints_are_between_the_same_steps(method: Any, memory: float) -> None:
    """Steps that are taken again end at the same corners, also those of a swing with a kink."""
    system, names = sprung(**KINKED["abs"]), ["b.position.z", "b.mass"]
    given = {"until": 3.0, "method": method}
    wanted = sr.sensitivity(sr.simulate(system, store="steps", **given), sr.Final("b.z"), names)
    found = by_checkpoints(system, sr.Final("b.z"), names, memory=memory, **given)
    assert len(found.warnings) == len(wanted.warnings)
    np.testing.assert_allclose(found.matrix, wanted.matrix, rtol=1e-12)


def test_checkpoints_end_steps_at_features_again() -> None:
    """A bump of a road after a calm: steps that are taken again end before it, as they did the first time.

    Errors of the derivatives need them several times: with what was stored of the first times, there was no end.
    """
    road = "5e-3*exp(-((x - 30)/0.05)^2)"
    body = sr.Body(
        "wheel", mass=20, inertia=(1, 1, 1), position=(0, 0, 0.3 - 20 * G / 2e5), velocity=(10, 0, 0)
    )
    tyre = sr.RoadTyre("tyre", body.point(0, 0, 0), k=2e5, c=2e3, radius=0.3, road=road)
    system = sr.System(sr.Model("wheel", [body], forces=[tyre], gravity=(0, 0, -G)))
    run = sr.simulate(system, until=3.05, store="steps")
    wanted = sr.sensitivity(run, sr.Final("wheel.z"), ["tyre.k"]).matrix
    found = by_checkpoints(system, sr.Final("wheel.z"), ["tyre.k"], until=3.05, memory=1e6)
    np.testing.assert_allclose(found.matrix, wanted, rtol=1e-12)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", KINKED)
def test_steps_end_at_kinks_of_laws(kind: str) -> None:
    """Derivatives at ordinary tolerances are those at narrow ones, and no step passes the kink."""
    coarse, fine = (run(sprung(**KINKED[kind]), 0.8, tolerance) for tolerance in (1e-6, 1e-11))
    found, true = (sr.sensitivity(one, sr.Final("b.z"), NAMES) for one in (coarse, fine))
    assert not found.warnings
    np.testing.assert_allclose(found.matrix, true.matrix, rtol=3e-5)


def oscillation() -> tuple[np.ndarray, np.ndarray]:
    """Gradient and Hessian of x at 0.8 s by x0 and the mass, of m x'' = -40 (x - 2) - 60 (x - 2.05)₊ at rest at 2.3.

    It falls to 2.05, swings below 2 with the frequency of the soft spring, and rises from 2.05.
    """
    mp = pytest.importorskip("mpmath")

    def z(x0: Any, mass: Any) -> Any:
        stiff, soft = mp.sqrt(100 / mass), mp.sqrt(40 / mass)
        corner, middle = mp.mpf("2.05"), mp.mpf("2.03")
        fall = mp.acos((corner - middle) / (x0 - middle)) / stiff
        speed = stiff * mp.sqrt((x0 - middle) ** 2 - (corner - middle) ** 2)
        below = 2 * (mp.pi - mp.atan(speed / soft / (corner - 2))) / soft
        s = stiff * (mp.mpf("0.8") - fall - below)
        return middle + (corner - middle) * mp.cos(s) + speed / stiff * mp.sin(s)

    with mp.workdps(40):
        at = (mp.mpf("2.3"), mp.mpf(1))
        first, second = [(1, 0), (0, 1)], [(2, 0), (1, 1), (1, 1), (0, 2)]
        gradient, hessian = ([float(mp.diff(z, at, n)) for n in orders] for orders in (first, second))
    return np.array(gradient), np.array(hessian).reshape(2, 2)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-11])
def test_second_derivatives_are_those_of_a_piecewise_linear_oscillator(tolerance: float) -> None:
    system = sprung(k="(40*(x - 2) + 60*max(x - 2.05, 0)) / x", length=0.0)
    swung, names = run(system, 0.8, tolerance), ["b.position.z", "b.mass"]
    gradient, hessian = oscillation()
    close = max(10 * tolerance, 2e-6)
    found = sr.sensitivity(swung, sr.Final("b.z"), names).matrix[0]
    np.testing.assert_allclose(found, gradient, rtol=close, atol=close)
    curved = sr.hessian(swung, sr.Final("b.z"), names)
    assert not curved.warnings
    np.testing.assert_allclose(curved.matrix, hessian, rtol=0, atol=10 * close * abs(hessian).max())


# x'' = -k(x) (x - 2) from 2.3, at 0.8 s: Taylor series of order 30 and 40 digits that end at the corners, differenced
CURVATURES = {"abs": -0.134308699723, "text": 1.39307456681, "narrow step": -0.00776860382671}
# Over a step of 0.1 mm the curvature is the small rest of large terms: slightly other steps change it by up to 0.03
CLOSE = {"abs": 2e-3, "text": 2e-3, "narrow step": 5e-2}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 2e-11])
@pytest.mark.parametrize("kind", CURVATURES)
def test_second_derivatives_do_not_depend_on_how_short_the_step_before_a_corner_is(
    kind: str, tolerance: float
) -> None:
    """The third derivative of the motion in such a step is not taken from its coordinates, which is round-off.

    With the smallest tolerance, a corner is just at a quarter of a step.
    """
    swung = run(sprung(**KINKED[kind]), 0.8, tolerance)
    found = sr.hessian(swung, sr.Final("b.z"), NAMES).matrix
    np.testing.assert_allclose(found, [[CURVATURES[kind]]], rtol=CLOSE[kind])


def test_a_mass_that_comes_to_rest_on_a_contact_ends() -> None:
    """Ever smaller bounces: steps end at a bounded number of corners."""
    rested = run(ball(), 1.0, 1e-5)
    corners = len(getattr(rested.steps, "event_steps", ()))
    assert rested.success
    assert corners <= 200 + 0.2 * rested.nsteps


@pytest.mark.parametrize("place", [1.76, 1.8, 1.9])
def test_corners_end_steps_also_where_they_are_not_where_they_seem(place: float) -> None:
    """In long steps of a coarse run the estimated time of a corner is off by more than the last step before it."""
    body = sr.Body("b", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 2.3))
    guide = sr.Translational("guide", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    law = f"40 + 60*max({place} - x, 0)"
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=law, length=2.0)
    system = sr.System(sr.Model("sprung", [body], [guide], [spring]))
    swung = sr.simulate(system, until=0.8, method=sr.HHT(rtol=1e-4, atol=1e-6), store="steps")
    fine = sr.simulate(system, until=0.8, store="steps")
    found, exact = ([e.t for e in one.steps.event_steps] for one in (swung, fine))
    assert len(found) == len(exact) == 2
    np.testing.assert_allclose(found, exact, atol=1e-2)
