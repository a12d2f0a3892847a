"""Derivatives by amplitudes that are zero: the motion shows nothing of what they would do, and has long steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.model.written import with_numbers, written_numbers
from sarrus.system.curves.curve_derivatives import CurveDerivatives

MESSAGE = "as some steps suit the motion, but not its changes by parameters."
WARNED = pytest.mark.filterwarnings("ignore:.*derivatives have")
UNTIL, MASS = 2.3, 2.0


def sprung(load: Any, k: float, c: float, beside: bool = False) -> sr.System:
    """2 kg at rest on a spring under a load, perhaps beside a pendulum with a load across its plane."""
    body = sr.Body("m", MASS, (1, 1, 1))
    swinging = sr.Body("p", 2.0, (0.1,) * 3, position=(1, 5, 0))
    joints = [
        sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0)),
        sr.Revolute("pin", sr.ground, swinging, point=(0, 5, 0), axis=(0, 0, 1)),
    ]
    forces: list[Any] = [
        sr.PointForce("load", body.point(0, 0, 0), (1, 0, 0), factor=load),
        sr.TSDA("s", sr.ground.point(-5, 0, 0), body.point(0, 0, 0), k=k, c=c, length=5.0),
        sr.PointForce("across", swinging.point(0.1, 0.2, 0.3), (0, 0, 1), factor="0*sin(30*t)"),
    ]
    many = 2 if beside else 1
    bodies = [body, swinging][:many]
    return sr.System(sr.Model("m", bodies, joints[:many], forces[: many + 1], gravity=(0, -9.81, 0)))


def shaken(motion: Any, k: float, c: float) -> sr.System:
    """2 kg at rest on a spring, whose other end is moved."""
    base, body = sr.Body("base", 1.0, (1, 1, 1)), sr.Body("m", MASS, (1, 1, 1), position=(2, 0, 0))
    rails = [
        sr.Translational("rail", sr.ground, base, point=(0, 0, 0), axis=(1, 0, 0)),
        sr.Translational("g", sr.ground, body, point=(2, 0, 0), axis=(1, 0, 0)),
    ]
    drive = sr.DisplacementDriver("drive", joint="rail", motion=motion)
    spring = sr.TSDA("s", base.point(0, 0, 0), body.point(0, 0, 0), k=k, c=c, length=2.0)
    return sr.System(sr.Model("shaken", [base, body], rails, [spring], drivers=[drive]))


def answer(k: float, c: float, w: float, through_spring: bool = False) -> float:
    """The place at the end with the load sin(ω t), or with the end of the spring there: steady and free vibration."""
    spring = k + 1j * c * w
    steady = (spring if through_spring else 1.0) / (spring - MASS * w**2)
    r = np.roots([MASS, c, k]).astype(complex)
    free = np.linalg.solve([[1, 1], r], [-steady.imag, -(1j * w * steady).imag])
    return float((steady * np.exp(1j * w * UNTIL)).imag + (free @ np.exp(r * UNTIL)).real)


CASES = [
    (sr.HHT(), 100.0, 3.0, 3.0, True),
    (sr.GeneralizedAlpha(), 100.0, 0.1, 3.0, True),
    (sr.HHT(step=0.02), 100.0, 0.1, 3.0, True),
    (sr.HHT(step=0.005), 100.0, 0.1, 3.0, False),
    (sr.HHT(), 1.0, 0.1, 30.0, True),
    (sr.Radau(), 100.0, 0.1, 3.0, False),
    (sr.Radau(), 5e3, 0.1, 3.0, True),
]


@WARNED
@pytest.mark.one_in(2)
@pytest.mark.parametrize("moved", [False, True], ids=["load", "driver"])
@pytest.mark.parametrize(("by", "k", "c", "w", "wrong"), CASES)
def test_errors_by_an_amplitude_of_zero_are_known(
    by: Any, k: float, c: float, w: float, wrong: bool, moved: bool
) -> None:
    law = f"0*sin({w}*t)"
    system, name = (shaken(law, k, c), "drive.motion.1") if moved else (sprung(law, k, c), "load.factor.1")
    run = sr.simulate(system, until=UNTIL, method=by, store_steps=True)
    found = sr.sensitivity(run, "m.x", [name], error=True)
    error = abs(found.matrix[0, 0] - answer(k, c, w, moved)) / abs(found.matrix[0, 0])
    assert (error > 0.01) == wrong
    assert 0.3 < found.relative_errors[0] / error < 3
    assert any(MESSAGE in one for one in found.warnings) == wrong


@WARNED
def test_errors_by_a_law_that_begins_later_are_known() -> None:
    """By a ramp (t - 1.5) after 1.5 s, of a load: the vibration that it starts is that of a spring at rest."""
    run = sr.simulate(sprung("0*max(0, t - 1.5)", 5e3, 0.0), until=UNTIL, store_steps=True)
    found = sr.sensitivity(run, "m.x", ["load.factor.1"], error=True)
    w, since = np.sqrt(5e3 / MASS), UNTIL - 1.5
    error = abs(found.matrix[0, 0] - (since - np.sin(w * since) / w) / 5e3) / abs(found.matrix[0, 0])
    assert error > 0.015
    assert 0.3 < found.relative_errors[0] / error < 3
    assert any(MESSAGE in one for one in found.warnings)


@WARNED
@pytest.mark.parametrize(("by", "wrong"), [(sr.HHT(), True), (sr.HHT(step=0.005), False)])
def test_errors_by_a_table_of_zeros_are_known(by: Any, wrong: bool) -> None:
    """Of values side by side, compared with steps that are short enough."""
    system = sprung([[t, 0.0] for t in np.linspace(0, UNTIL, 6)], 100.0, 3.0)
    runs = [
        sr.simulate(system, until=UNTIL, method=one, max_step=h, store_steps=True)
        for one, h in ((by, np.inf), (sr.Radau(), 0.01))
    ]
    found, exact = (sr.sensitivity(run, "m.x", ["load.factor"], error=True) for run in runs)
    error = np.linalg.norm(found.matrix - exact.matrix) / np.linalg.norm(found.matrix)
    assert (error > 0.01) == wrong
    assert 0.3 < found.relative_errors[0] / error < 3
    assert bool(found.warnings) == wrong


@WARNED
def test_other_parameters_do_not_hide_them_and_every_route_knows() -> None:
    """Beside derivatives by which the whole is right, and none that is round-off."""
    system, given = sprung("0*sin(30*t)", 100.0, 3.0, True), {"until": UNTIL, "method": sr.HHT()}
    run = sr.simulate(system, **given, store_steps=True)
    names = ["load.factor.1", "s.length", "across.factor.1"]
    every = [
        sr.sensitivity(run, "m.x", names),
        sr.sensitivity(run, "m.x", names, method="direct"),
        sr.hessian(run, "m.x", names[:2]),
        sr.state_derivatives(run, names[:2]),
        sr.sensitivity_by_checkpoints(system, "m.x", names, **given),
    ]
    assert all(any(MESSAGE in one for one in own.warnings) for own in every)
    for across in (
        sr.sensitivity(run, "pin.angle", names),
        sr.sensitivity_by_checkpoints(system, "pin.angle", names, **given),
    ):
        assert abs(across.matrix).max() < 1e-15
        assert not any(MESSAGE in one for one in across.warnings)


LAWS = [
    "0*sin(20*t)", "(sin(2*t) + cos(3*t) + 4*sin(5*t))*0", "1*t^2 - 1*sin(1*t) + 0", "sin(3*t) + cos(3*t) - 3",
    "-1*t/1 + exp(-t*0)", "max(0, t - 0)*1 + 0*abs(t - 1)", "acos(1*cos(0*t))", "0*sin(0*t + 0) - (-0)*t",
]  # fmt: skip


@pytest.mark.parametrize("law", LAWS)
def test_moved_formulas_are_those_with_other_constants(law: str) -> None:
    """Also if they have more steps there."""
    system = sprung(law, 1.0, 0.0)
    own = {name: x for name, x in written_numbers(system.model).items() if name.startswith("load.factor")}
    parameters, state = Parameters(system, [*own]), (system.q0, system.v0)
    for sign in (1.0, -1.0):
        steps = sign * 1e-3 * (1.0 + np.arange(len(own)) % 3)
        model = with_numbers(
            system.model, {name: x + d for (name, x), d in zip(own.items(), steps, strict=True)}
        )
        b = CurveDerivatives(system).moved(system.b, parameters.along(steps[:, None])[0][:, 0])
        for t in (0.0, 0.7, 1.9):
            assert system.Q(*state, t, b=b) == pytest.approx(
                sr.System(model).Q(*state, t), rel=1e-12, nan_ok=True
            )


@pytest.mark.parametrize(("law", "wanted"), [
    ("0*sin(3*t)", [True, False]), ("2*max(0, sin(3*t)) + 0", [False] * 4), ("-0*t/5 + 1", [True, False, False]),
])  # fmt: skip
def test_zeros_that_are_no_factors_hide_nothing(law: str, wanted: list[bool]) -> None:
    """Thirty loads with a zero in max(0, ...) made a gradient eight times as expensive."""
    system = sprung(law, 1.0, 0.0)
    own = [name for name in written_numbers(system.model) if name.startswith("load.factor.")]
    assert Parameters(system, own).hidden.tolist() == wanted
