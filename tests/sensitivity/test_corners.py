"""Derivatives of runs whose steps pass a corner of a force at once are said to be inaccurate, and others are not."""

from __future__ import annotations

import warnings
from typing import Any

import pytest

import sarrus as sr

NAMES = ["b.position.z"]


def ball(rounding: float = 1e-4) -> sr.System:
    """A ball that falls on the ground and comes up again within half a second."""
    body = sr.Body("b", mass=1.0, inertia=(0.004,) * 3, position=(0, 0, 0.4))
    law = {"stiffness": 2e4, "damping": 0.3, "exponent": 1.5, "rounding": rounding}
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
    how = {"method": sr.Radau(), "rtol": tolerance, "atol": tolerance / 100, "store_steps": True} | settings
    return sr.simulate(system, until=until, **how)


@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()], ids=["Radau", "HHT"])
def test_a_first_touch_within_one_step(method: object) -> None:
    bounced = run(ball(), method=method)
    with pytest.warns(sr.SarrusWarning, match=r"floor: its force sets in, .*rtol=1e-10"):
        found = sr.sensitivity(bounced, sr.Final("b.z"), NAMES)
    assert len(found.warnings) == 1
    with pytest.raises(sr.StrictError, match="floor"):
        sr.sensitivity(bounced, sr.Final("b.z"), NAMES, strict=True)


def test_second_derivatives_states_and_checkpoints_say_it_too() -> None:
    bounced = run(ball())
    with pytest.warns(sr.SarrusWarning, match="floor"):
        assert sr.hessian(bounced, sr.Final("b.z"), NAMES).warnings
    with pytest.warns(sr.SarrusWarning, match="floor"):
        sr.state_derivatives(bounced, NAMES)
    settings = {"method": sr.Radau(), "rtol": 1e-6, "atol": 1e-8}
    with pytest.warns(sr.SarrusWarning, match="floor"):
        sr.sensitivity_by_checkpoints(ball(), sr.Final("b.z"), NAMES, until=0.5, **settings)


@pytest.mark.parametrize(("rounding", "tolerance", "until"), [(0.02, 1e-8, 0.5), (1e-4, 1e-6, 0.2)])
def test_a_resolved_touch_and_a_flight_are_not_warned_of(
    rounding: float, tolerance: float, until: float
) -> None:
    fallen = run(ball(rounding), until, tolerance)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not sr.sensitivity(fallen, sr.Final("b.z"), NAMES).warnings


KINKED: dict[str, dict[str, Any]] = {
    "abs": {"k": lambda x: 40 + 60 * abs(x - 2.05)},
    "text": {"k": "40 + 60*max(x - 2.05, 0)"},
    "damping": {"c": lambda v: abs(v)},
    "narrow step": {"k": "step(x, 2.04, 40, 2.0401, 60)"},
}
SMOOTH: dict[str, dict[str, Any]] = {
    "number": {},
    "cubic": {"k": "40 + 60*(x - 2)**2"},
    "wide step": {"k": "step(x, 1.5, 40, 2.5, 60)"},
    "table": {"k": [(1.0, 40), (1.9, 60), (2.2, 30), (3.0, 50)]},
    "kink elsewhere": {"k": lambda x: 40 + 60 * abs(x - 9)},
}


@pytest.mark.parametrize("kind", KINKED)
def test_kinks_of_laws(kind: str) -> None:
    swung = run(sprung(**KINKED[kind]), 2.0)
    with pytest.warns(sr.SarrusWarning, match="spring: its force"):
        sr.sensitivity(swung, sr.Final("b.z"), NAMES)


@pytest.mark.parametrize("kind", SMOOTH)
def test_smooth_laws(kind: str) -> None:
    swung = run(sprung(**SMOOTH[kind]), 2.0)
    assert not sr.sensitivity(swung, sr.Final("b.z"), NAMES).warnings


def test_a_reversal_of_friction() -> None:
    system = sprung()
    slide = {"body_i": sr.ground, "body_j": system.model.bodies[0], "point": (0, 0, 0), "axis": (0, 0, 1)}
    for creep, said in ((1e-3, True), (5.0, False)):
        rub = sr.DisplacementFriction("rub", load=1.0, mu=0.3, creep=creep, stribeck=10.0, **slide)
        model = sr.Model("rubbed", system.model.bodies, system.model.joints, [*system.model.forces, rub])
        swung = run(sr.System(model), 1.0, 1e-3)
        if said:
            with pytest.warns(sr.SarrusWarning, match="rub: its force sets in, ends or reverses"):
                sr.sensitivity(swung, sr.Final("b.z"), NAMES)
        else:
            assert not sr.sensitivity(swung, sr.Final("b.z"), NAMES).warnings
