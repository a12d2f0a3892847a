"""Tyres on surfaces: the contact on planes, the road as a profile, derivatives, and the end of a road."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
import pytest
from tests.tyres.test_rolling_tyres import BRUSH

import sarrus as sr
from sarrus.model.written import written_numbers

AXIS = np.array([0.0, 1.0, 0.0])
SLOPES = [0, 10, 20, 30]


def plane(normal: Any) -> sr.Surface:
    x = np.linspace(-3, 4, 6)
    return sr.Surface(x, x, -(normal[0] * x[:, None] + normal[1] * x) / normal[2])


@pytest.mark.parametrize("slope", SLOPES)
@pytest.mark.parametrize("azimuth", [0.0, 35.0, 90.0, 200.0])
def test_contact_on_an_inclined_plane(slope: float, azimuth: float) -> None:
    """A wheel of radius 1 that is pressed in by 0.1: its force is normal, and acts at the contact, which is known.

    The setting is that of a test of Chrono (utest_VEH_tire_contact), here with inclinations in all directions.
    """
    tilt, turn = np.radians([slope, azimuth])
    n = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    down = (n @ AXIS) * AXIS - n
    contact = np.array([0.3, -0.4, -(0.3 * n[0] - 0.4 * n[1]) / n[2]])
    centre = contact - 0.9 * down / np.linalg.norm(down)
    wheel = sr.Body("wheel", mass=1.0, inertia=(1, 1, 1), position=tuple(centre))
    tyre = sr.BrushTyre("tyre", wheel.point(0, 0, 0), road=plane(n), **BRUSH | {"radius": 1.0})
    run = sr.simulate(sr.System(sr.Model("plane", [wheel], [], [tyre])), until=1e-9, t_eval=[0.0])
    load, force = run["tyre.load"][0], run["tyre.force"][0]
    assert run["tyre.compression"][0] == pytest.approx(0.1, abs=1e-13)
    assert run["tyre.inclination"][0] == pytest.approx(np.arcsin(n @ AXIS), abs=1e-13)
    assert load == pytest.approx(BRUSH["k"] * 0.1)
    assert force == pytest.approx(load * n, abs=1e-12 * load)
    assert run["tyre.torque"][0] == pytest.approx(np.cross(contact - centre, force), abs=1e-12 * load)


@pytest.mark.parametrize("x", [0.1, 0.4, 0.9, 1.3])
def test_contact_on_waves(x: float) -> None:
    """The distance of the centre from the tangent plane of the second pass is nearly that from the nearest point."""
    at = np.linspace(-1, 3, 81)
    road = sr.Surface(at, [-1, 1], np.tile(0.05 * np.sin(np.pi * at[:, None]), 2))
    height, normal = 0.05 * np.sin(np.pi * x), np.array([-0.05 * np.pi * np.cos(np.pi * x), 0, 1])
    centre = np.array([x, 0, height]) + 0.3 * normal / np.linalg.norm(normal)
    wheel = sr.Body("wheel", mass=1.0, inertia=(1, 1, 1), position=tuple(centre))
    tyre = sr.BrushTyre("tyre", wheel.point(0, 0, 0), road=road, **BRUSH)
    run = sr.simulate(sr.System(sr.Model("waves", [wheel], [], [tyre])), until=1e-9, t_eval=[0.0])
    assert run["tyre.compression"][0] == pytest.approx(0.01, abs=4e-6)
    assert run["tyre.force"][0] / run["tyre.load"][0] == pytest.approx(
        normal / np.linalg.norm(normal), abs=2e-3
    )


X = np.linspace(-2, 8, 41)
BUMP = 0.05 * np.exp(-(((X - 2.5) / 0.6) ** 2))


def car(road: Any, of: Any = sr.BrushTyre, height: float = 0.3, roll: float = 0.0, **given: Any) -> sr.System:
    """A body on four tyres whose spins are states, or on vertical ones, at 5 m/s."""
    body = sr.Body(
        "car",
        mass=300,
        inertia=(40, 60, 60),
        position=(0, 0.2, height),
        velocity=(5, 0, 0),
        angular_velocity=(roll, 0, 0),
    )
    numbers: dict[str, Any] = {"radius": 0.31, "k": 1e5, "c": 1000.0}
    if of is sr.BrushTyre:
        numbers |= {name: BRUSH[name] for name in ("c_kappa", "c_alpha", "mu", "half_length")}
        numbers |= {"spin_inertia": 1.0, "initial_spin": 5 / 0.305}
    places = {"fl": (1, 0.7), "fr": (1, -0.7), "rl": (-1, 0.7), "rr": (-1, -0.7)}
    tyres = [of(name, body.point(*at, 0), road=road, **numbers | given) for name, at in places.items()]
    return sr.System(sr.Model("car", [body], [], tyres, gravity=(0, 0, -9.81)))


@pytest.mark.parametrize("of", [sr.RoadTyre, sr.BrushTyre])
def test_a_surface_along_x_is_the_profile(of: Any) -> None:
    """Over a bump, and beyond the end of both, where the front wheels are at the end."""
    profile = np.column_stack([X, BUMP]).tolist()
    surface = sr.Surface(X, [-1, 0, 2], np.tile(BUMP[:, None], 3))
    runs = []
    for road in (profile, surface):
        with pytest.warns(sr.SarrusWarning, match="continued by its tangent"):
            runs.append(sr.simulate(car(road, of), until=1.8, t_eval=np.linspace(0, 1.8, 37)))
    one, other = (np.column_stack([run[f"car.{axis}"] for axis in "xyz"]) for run in runs)
    assert np.ptp(one[:, 2]) > 0.02
    assert one[-1, 0] > X[-1] + 0.5
    assert other == pytest.approx(one, abs=1e-9)
    messages = [sorted(run.warnings) for run in runs]
    assert [len(texts) for texts in messages] == [2, 2]
    assert "fl: its table ends at -2 and 8, but is used at " in messages[0][0]
    assert "fl: its road ends at x = -2 and 8, but is used at " in messages[1][0]
    assert messages[1][0].endswith("continued by its tangent. Extend its grid.")


def hill() -> sr.Surface:
    """A bump that is not symmetric to the car."""
    y = np.linspace(-2, 2, 17)
    return sr.Surface(X, y, BUMP[:, None] * np.exp(-(((y - 0.8) / 0.7) ** 2)))


def test_derivatives_on_a_surface() -> None:
    report = car(hill()).check_derivatives()
    assert report, report


@pytest.mark.parametrize("of", [sr.RoadTyre, pytest.param(sr.BrushTyre, marks=pytest.mark.slow)])
def test_gradient_of_a_run_over_a_bump(of: Any) -> None:
    """Against differences of fourth order of runs at tight tolerances, of which five digits are right."""
    model, outputs, step = car(hill(), of).model, ["car.z", "car.rotation_x", "fl.compression"], 1e-3
    options: dict[str, Any] = {"until": 0.7, "method": sr.Radau(rtol=1e-11, atol=1e-13)}
    run = sr.simulate(sr.System(model), store="steps", **options)
    for name in ("fl.k", "car.mass"):
        value, ends = written_numbers(model)[name], []
        for side in (1, -1, 2, -2):
            moved = sr.System(model.with_parameters({name: value * (1 + side * step)}))
            end = sr.simulate(moved, **options)
            ends.append(np.array([end[output][-1] for output in outputs]))
        expected = (8 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12 * step * value)
        found = sr.sensitivity(run, outputs, wrt=[name]).matrix[:, 0]
        assert found == pytest.approx(expected, rel=1e-5), name


@pytest.mark.filterwarnings("ignore:... its contact ends where the wheel leans")  # it lands on its roof
def test_a_car_that_leaves_a_road_at_its_side() -> None:
    """The road falls to the right: the car slides off, and the run goes on along the tangent, with a warning."""
    x, y = [-5, 0, 20, 40], np.linspace(-1, 1, 5)
    road = sr.Surface(x, y, np.tile(0.4 * y, (4, 1)))
    with pytest.warns(sr.SarrusWarning, match="continued by its tangent"):
        run = sr.simulate(car(road, mu=0.2), until=2.0, t_eval=np.linspace(0, 2, 21))
    assert run["car.y"][-1] < -1
    assert np.abs(run["car.z"]).max() < 3
    assert run["car.z"][-1] - 0.4 * run["car.y"][-1] == pytest.approx(0.3 * np.hypot(1, 0.4), abs=0.02)
    (message,) = [text for text in run.warnings if text.startswith("fr: its road")]
    assert message.startswith("fr: its road ends at y = -1 and 1, but is used at -1.0")
    assert "continued by its tangent. Extend its grid." in message


@pytest.mark.parametrize("road", [0.0, sr.Surface([-90, 90], [-90, 90], np.zeros((2, 2)))])
def test_a_car_that_rolls_over_has_one_warning_for_each_wheel(road: Any) -> None:
    """It falls from a height and turns: on two wheels there is no warning, on its side it falls through the road."""
    for rate, count in ((1.2, 0), (6.0, 4)):
        rolling = car(road, height=1.0, roll=rate)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            run = sr.simulate(rolling, until=0.6, t_eval=np.linspace(0, 0.6, 61))
        lean = np.degrees(run["car.rotation_x"])
        assert lean.max() > 15
        texts = [str(one.message) for one in caught]
        assert len(texts) == len(run.warnings) == count
        for text in texts:
            assert re.match(
                "[fr][lr]: its contact ends where the wheel leans by .deg. -70 and 70, but is", text
            )
            assert "passes through the road. Hold it by contacts of its body" in text
            t = float(text.split("t = ")[1].split()[0])
            assert np.interp(t, run.t, lean) == pytest.approx(70, abs=2)
