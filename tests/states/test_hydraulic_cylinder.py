"""Hydraulic cylinders, against SciPy on the reduced equations and against closed forms."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.states.gradients import differences, direct_and_adjoint
from tests.states.motors import TIGHT, value
from tests.states.test_maxwell import MASS, ends, slider

import sarrus as sr
from sarrus.model import ModelError
from sarrus.model.written import written_numbers

BAR = 1e5
GIVEN: dict[str, Any] = {
    "area": 2e-3,
    "rod_area": 1.2e-3,
    "stroke": 0.8,
    "dead": 1e-4,
    "supply": 100 * BAR,
    "rated_flow": 4e-4,
    "rated_drop": 35 * BAR,
    "bulk": 8e8,
    "tank": 2 * BAR,
    "leakage": 1e-12,
    "width": 1e4,
    "underlap": 0.02,
    "initial_a": 20 * BAR,
    "initial_b": 30 * BAR,
}
OPENING = "0.5*sin(6*t)"
OUTPUTS = ("slide.displacement", "cart.velocity.x", "jack.pressure_a", "jack.pressure_b")


def driven(opening: Any = OPENING, between: bool = False, spring: float = 2e3, **changes: Any) -> sr.Model:
    """A mass on a slide with a spring, moved by a cylinder."""
    place: dict[str, Any] = ends(slider()) if between else {"joint": "slide"}
    retracted = {"retracted": 0.6 if between else -0.4}
    jack = sr.HydraulicCylinder("jack", **place, input=opening, **(GIVEN | retracted | changes))
    return slider(jack, sr.Force("load", "slide", value=f"-800*v - {spring}*x"), speed=0.1)


def flows(u: float, a: float, b: float) -> tuple[float, float]:
    """Into the chambers."""

    def through(opening: float, drop: float) -> float:
        return opening * 4e-4 * drop / np.sqrt(35 * BAR) / (drop**2 + 1e8) ** 0.25

    ahead, back = (np.hypot(u, 0.02) + u) / 2, (np.hypot(u, 0.02) - u) / 2
    into_a = through(ahead, 100 * BAR - a) - through(back, a - 2 * BAR)
    return into_a, through(back, 100 * BAR - b) - through(ahead, b - 2 * BAR)


def by_hand(until: float) -> Any:
    """Displacement, speed and pressures, which are in bar within."""

    def rates(t: float, y: Any) -> list[float]:
        x, v, a, b = y[0], y[1], BAR * y[2], BAR * y[3]
        into_a, into_b = flows(0.5 * np.sin(6 * t), a, b)
        leak = 1e-12 * (a - b)
        da = 8e8 * (into_a - leak - 2e-3 * v) / (1e-4 + 2e-3 * (x + 0.4))
        db = 8e8 * (into_b + leak + 1.2e-3 * v) / (1e-4 + 1.2e-3 * (0.4 - x))
        return [v, (2e-3 * a - 1.2e-3 * b - 800 * v - 2000 * x) / MASS, da / BAR, db / BAR]

    y = solve_ivp(rates, (0, until), [0, 0.1, 20, 30], "Radau", rtol=1e-12, atol=1e-13).y[:, -1]
    return y * [1, 1, BAR, BAR]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("between", [False, True])
def test_a_cylinder_follows_its_reduced_equations(between: bool) -> None:
    run = sr.simulate(sr.System(driven(between=between)), until=0.6, **TIGHT)
    y = by_hand(0.6)
    found = [value(run, name)[-1] for name in OUTPUTS]
    assert found[:2] == pytest.approx(y[:2], abs=1e-8)
    assert found[2:] == pytest.approx(y[2:], rel=1e-8)
    assert value(run, "jack.value")[-1] == pytest.approx(2e-3 * y[2] - 1.2e-3 * y[3], rel=1e-8)
    into = flows(0.5 * np.sin(3.6), *y[2:])
    assert [value(run, f"jack.flow_{side}")[-1] for side in "ab"] == pytest.approx(into, rel=1e-8)


def test_the_flow_is_the_rated_one_and_linear_near_zero() -> None:
    """At the rated drop through one edge; within the width, in proportion to the drop."""
    for drop, factor in ((35 * BAR, 1.0), (10.0, np.sqrt(10.0 / (35 * BAR)) * np.sqrt(10.0 / 1e4))):
        start = {"initial_a": 100 * BAR - drop, "underlap": 1e-9, "tank": 0.0, "initial_b": 0.0}
        run = sr.simulate(sr.System(driven(1.0, **start)), until=1e-6)
        assert value(run, "jack.flow_a")[0] == pytest.approx(4e-4 * factor, rel=1e-5)


def test_at_rest_a_closed_valve_holds_the_pressures_of_its_underlap() -> None:
    """Edges alike: without leakage, both chambers are half way between the supply and the tank."""
    rest = sr.equilibrium(sr.System(driven(0.0, spring=2e4, leakage=0.0)))
    assert rest.success
    assert [rest[name] for name in OUTPUTS[2:]] == pytest.approx([51 * BAR] * 2, rel=1e-9)
    assert rest["slide.displacement"] == pytest.approx(51 * BAR * 0.8e-3 / 2e4, rel=1e-9)


def test_there_is_no_equilibrium_outside_of_the_cylinder() -> None:
    """The spring is so weak that the piston rests beyond its stroke, where the force is no number."""
    rest = sr.equilibrium(sr.System(driven(0.0, leakage=0.0)))
    assert not rest.success
    assert "no equilibrium found" in rest.message


def test_a_volume_that_ends_ends_the_run() -> None:
    run = sr.simulate(sr.System(driven(1.0, stroke=0.45, dead=1e-5, supply=400 * BAR)), until=5.0)
    assert run.status == "not finite"
    assert "jack" in run.message
    assert 0.05 < value(run, "slide.displacement").max() < 0.05 + 1e-5 / 1.2e-3


NAMES = [f"jack.{field}" for field in GIVEN]


@pytest.mark.slow
def test_gradients_are_differences_of_runs_and_direct_is_adjoint() -> None:
    place = driven(), "slide.displacement", NAMES, 0.2
    direct, adjoint = direct_and_adjoint(*place, rtol=1e-10)
    assert direct == pytest.approx(adjoint, rel=1e-7)
    numbers = np.array([written_numbers(place[0])[name] for name in NAMES])
    scales = 1e-6 * abs(direct * numbers).max() / numbers
    for name, one, wanted, scale in zip(NAMES, direct, differences(*place, 1e-3), scales, strict=True):
        assert one == pytest.approx(wanted, rel=1e-4, abs=scale), name


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"input": None}, "its input is missing"),
        ({"area": 0.0}, "area must be greater than 0"),
        ({"width": 0.0}, "width must be greater than 0"),
        ({"underlap": 0.0}, "underlap must be greater than 0"),
        ({"leakage": -1.0}, "leakage must not be negative"),
        ({"supply": -1.0}, "supply must be greater than 0"),
    ],
)
def test_wrong_cylinders_are_refused(changes: Any, message: str) -> None:
    jack = sr.HydraulicCylinder("jack", joint="slide", **(GIVEN | {"input": 0.0} | changes))
    with pytest.raises(ModelError, match=message):
        sr.System(slider(jack))


def test_a_model_file_has_units_of_pressure_and_flow(tmp_path: Path) -> None:
    """Bar, cm² and litres a minute; names of files are those of the fields."""
    model = driven(between=True)
    model.save(tmp_path / "jack.yaml")
    text = (tmp_path / "jack.yaml").read_text()
    for field, old, new in (
        ("supply", "10000000", "100 bar"),
        ("area", "0.002", "20 cm^2"),
        ("rated_flow", "0.0004", "24 l/min"),
    ):
        assert f"{field}: {old}" in text, text
        text = text.replace(f"{field}: {old}", f"{field}: {new}", 1)
    (tmp_path / "jack.yaml").write_text(text)
    read = written_numbers(sr.load(tmp_path / "jack.yaml"))
    assert [read[f"jack.{field}"] for field in GIVEN] == pytest.approx(list(GIVEN.values()), rel=1e-14)
