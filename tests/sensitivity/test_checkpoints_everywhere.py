"""Gradients by checkpoints are those of stored steps: of every kind of response, over everything that ends steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints
from tests.sensitivity.test_switched_loads import switched
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.sensitivity import long_run

# See `test_checkpoints_events`; steps of Radau from a checkpoint differ within the tolerance of Newton's iteration
ROUND_OFF, OF_NEWTON = 1e-8, 1e-6
LONGEST = (
    5e-3  # [s] so that outputs are resolved by the steps: those between their nodes are others by checkpoints
)
METHODS: dict[str, Any] = {
    "HHT by long steps of one length": sr.HHT(step=2 * LONGEST),
    "HHT by steps of one length": sr.HHT(step=LONGEST),
    "HHT": sr.HHT(),
    "stabilized": sr.HHT(stabilized=True),
    "generalized-alpha by steps of one length": sr.GeneralizedAlpha(step=LONGEST),
    "generalized-alpha": sr.GeneralizedAlpha(),
    "Radau": sr.Radau(),
}
BRAKE = sr.Event("ball.x - 0.08", reset=lambda t, q, v: 0.5 * v, name="brake")


def on_stops(stiffness: float = 1e4) -> sr.System:
    """A mass that is thrown to and fro between two stops."""
    body = sr.Body("mass", 1.0, (1, 1, 1), velocity=(2.0, 0, 0))
    where = {"point": (0, 0, 0), "axis": (1, 0, 0)}
    guide = sr.Translational("guide", sr.ground, body, **where)
    stop = sr.DisplacementStop(
        "stop", sr.ground, body, stiffness=stiffness, lower=-0.05, upper=0.05, rounding=1e-3, **where
    )
    return sr.System(sr.Model("stops", [body], [guide], [stop]))


def on_floor(mu: float, height: float = -9.81e-5, stiffness: float = 1e5) -> sr.System:
    """A ball that slides over a floor, or falls on it."""
    body = sr.Body("ball", 1.0, (0.004,) * 3, position=(0, 0, 0.1 + height), velocity=(0.5, 0, 0))
    ground = sr.ground.frame((0, 0, 0), z=(0, 0, 1))
    floor = sr.SphereContact(
        "floor",
        body.point(0, 0, 0),
        ground,
        radius=0.1,
        mu=mu,
        stiffness=stiffness,
        damping=0.5,
        rounding=1e-3 if height > 0 else 1e-4,
    )
    return sr.System(sr.Model("floor", [body], forces=[floor], gravity=(0, 0, -9.81)))


class Subject(NamedTuple):
    """A model, the body whose motion is looked at, the direction of its motion, parameters, end [s], and an event."""

    system: Callable[[], sr.System]
    body: str
    axis: str
    wrt: list[str]
    until: float
    event: sr.Event | None = None


SUBJECTS = {
    "friction": Subject(lambda: on_floor(0.3), "ball", "x", ["floor.mu", "ball.mass"], 0.3),
    "friction and an event": Subject(lambda: on_floor(0.3), "ball", "x", ["floor.mu", "ball.mass"], 0.3, BRAKE),
    "an event": Subject(lambda: on_floor(0.0), "ball", "x", ["ball.velocity.x", "ball.mass"], 0.3, BRAKE),
    "contact": Subject(lambda: on_floor(0.0, 0.02, 2e3), "ball", "z", ["floor.stiffness", "ball.position.z"], 0.3),
    "stops": Subject(lambda: on_stops(2e3), "mass", "x", ["stop.stiffness", "mass.mass"], 0.2),
    "a switched load": Subject(switched, "b", "x", ["s.k", "b.mass"], 1.6),
    "nothing": Subject(slider_crank, "slider", "x", ["spring.k", "crank.mass"], 0.5),
}  # fmt: skip
QUICK = ("friction", "HHT by long steps of one length")


def responses(own: Subject) -> list[sr.Response]:
    """Every kind, of positions and velocities."""
    x = f"{own.body}.{own.axis}"
    v = f"{own.body}.velocity.{own.axis}"
    times = tuple(part * own.until for part in (0.31, 0.77))
    found = [
        sr.Final(x), sr.Final(v), sr.At(x, time=times[0]), sr.At(v, time=times[1]), sr.Integral(x),
        sr.Integral("energy.kinetic"), sr.Maximum(v), sr.Maximum(x),
        sr.Minimum(v), sr.Misfit(x, at=times, data=(0.0, 0.1)),
        sr.Integral(lambda o: o.parameter(own.wrt[0]) * o(v) ** 2, name="own"),
    ]  # fmt: skip
    if own.event is None:
        return found
    return [*found, sr.AtEvent("t", event="brake"), sr.AtEvent(v, event="brake", after=True)]


@pytest.mark.filterwarnings("ignore:.*derivatives may be inaccurate")
@pytest.mark.parametrize(
    ("subject", "method"),
    [
        pytest.param(subject, method, marks=() if (subject, method) == QUICK else pytest.mark.slow)
        for subject in SUBJECTS
        for method in METHODS
        if "long" not in method or "friction" in subject
    ],
)
def test_checkpoints_and_stored_steps(subject: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_run, "FIRST", 20)
    own, radau = SUBJECTS[subject], method == "Radau"
    system, wanted = own.system(), responses(own)
    given = {
        "until": own.until,
        "method": replace(METHODS[method], max_step=2 * LONGEST if "long" in method else LONGEST),
        "events": own.event or (),
    }
    stored = sr.sensitivity(sr.simulate(system, store="steps", **given), wanted, own.wrt)
    found = by_checkpoints(system, wanted, own.wrt, **given)
    sampled = np.array([isinstance(one, sr.Maximum | sr.Minimum) for one in wanted])  # by checkpoints
    assert found.values[sampled] == pytest.approx(stored.values[sampled], rel=2e-6 if radau else 2e-4)
    found, stored = (
        replace(x, values=x.values[~sampled], matrix=x.matrix[~sampled]) for x in (found, stored)
    )
    np.testing.assert_allclose(found.values, stored.values, rtol=1e-8 if radau else 1e-11, atol=1e-14)
    scale = np.maximum(abs(stored.matrix).max(axis=1, keepdims=True), 1e-4 * abs(stored.matrix).max())
    assert abs((found.matrix - stored.matrix) / scale).max() < (OF_NEWTON if radau else ROUND_OFF)


@pytest.mark.parametrize(("method", "near"), [(sr.Radau(), 1e-7), (sr.HHT(), 1e-4)])
def test_extremes_have_the_derivatives_of_stored_steps(method: object, near: float) -> None:
    """The polynomial through all samples about them; a parabola through three of them was off by 2e-4 with Radau."""
    wanted = [sr.Maximum("slider.velocity.x"), sr.Minimum("slider.velocity.x"), sr.Maximum("pin.force.z")]
    names, given = ["spring.k", "gravity.z", "crank.mass"], {"until": 1.5, "method": method}
    stored = sr.sensitivity(sr.simulate(slider_crank(), store="steps", **given), wanted, names)
    found = by_checkpoints(slider_crank(), wanted, names, **given)
    assert found.values == pytest.approx(stored.values, rel=near)
    assert found.matrix == pytest.approx(stored.matrix, abs=near * abs(stored.matrix).max())
