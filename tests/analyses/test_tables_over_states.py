"""Features of tables over a place, a length or an angle are not passed over in a calm motion."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.dynamics.time_loop import recording, time_loop

METHODS = (sr.Radau(), sr.HHT(), sr.HHT(stabilized=True), sr.GeneralizedAlpha(), sr.ODE())
SPEED, RADIUS, K, M = 10.0, 0.3, 2e5, 20.0
pytestmark = pytest.mark.filterwarnings(
    "ignore:.*spline through the table"
)  # it overshoots between few points


def wheel(road: Any) -> sr.System:
    """A wheel that rolls at rest on its tyre, without a vibration, until the road changes."""
    height = RADIUS - M * 9.81 / K
    body = sr.Body("wheel", mass=M, inertia=(1, 1, 1), position=(0, 0, height), velocity=(SPEED, 0, 0))
    tyre = sr.RoadTyre("tyre", body.point(0, 0, 0), k=K, c=2e3, radius=RADIUS, road=road)
    return sr.System(sr.Model("wheel", [body], forces=[tyre], gravity=(0, 0, -9.81)))


def bell(width: float, height: float = 0.005, apart: float = 0.25) -> list[list[float]]:
    """A road with a bump, of many points."""
    x = np.concatenate([[0, 15], np.arange(30 - 5 * width, 30 + 5 * width, apart * width), [45, 60]])
    return np.array([x, height * np.exp(-(((x - 30) / width) ** 2))]).T.tolist()


def points(width: float) -> list[list[float]]:
    """A road of few points, the bump between two of them."""
    return [[0, 0], [29, 0], [30 - width, 0], [30, 0.005], [30 + width, 0], [31, 0], [60, 0]]


def heights(system: sr.System, **given: Any) -> np.ndarray:
    run = sr.simulate(system, until=3.3, t_eval=np.linspace(2.7, 3.3, 601), **given)
    assert run.success, run.message
    return np.asarray(run["wheel"].position[:, 2])


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", METHODS, ids=str)
@pytest.mark.parametrize("road", [bell(0.5), bell(0.05), points(0.5), points(0.05)], ids=len)
def test_a_bump_after_a_calm(road: Any, method: Any) -> None:
    tight = method if isinstance(method, sr.Radau) else replace(method, rtol=1e-8)
    system = wheel(road)
    wanted = heights(system, method=sr.Radau(max_step=1e-3))
    assert np.ptp(wanted) > 4e-3
    assert heights(system, method=tight) == pytest.approx(wanted, rel=0, abs=0.02 * np.ptp(wanted))


@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()], ids=str)
def test_steps_before_a_part_of_a_table_stay_stored(method: Any) -> None:
    """The integral of the way is that of the whole run at constant speed."""
    run = sr.simulate(wheel(bell(0.5)), until=3.3, t_eval=[3.3], method=method, store="steps")
    assert run.message == "reached the end"
    way = sr.sensitivity(run, sr.Integral("wheel.x"), ["tyre.k"])
    assert way.values[0] == pytest.approx(SPEED * 3.3**2 / 2, rel=1e-3)


def test_steps_over_a_random_road_pass_its_points() -> None:
    """They are as many as its heights need, fewer than its points."""
    road = np.column_stack(
        [x := np.arange(-5, 45, 0.01), 1e-7 * np.random.default_rng(1).standard_normal(len(x))]
    )
    run = sr.simulate(wheel(road.tolist()), until=3.3, t_eval=[3.3], store="steps")
    assert run.nsteps < SPEED * 3.3 / 0.01


def test_a_detent_of_a_hinge_and_a_catch_of_a_spring() -> None:
    """Stiffnesses over an angle and a length that vary within 0.04: in passing they change the speed."""
    x = np.concatenate([[0, 19], 20 + np.arange(-0.2, 0.2, 0.002), [21, 40]])
    law = np.array([x, np.exp(-(((x - 20) / 0.02) ** 2))]).T.tolist()
    work = 20 * 0.02 * np.sqrt(np.pi)  # of κ x over the bell
    disc = sr.Body("disc", mass=1, inertia=(1, 1, 1), angular_velocity=(0, 0, 5.0))
    pin = sr.Revolute("pin", sr.ground, disc, point=(0, 0, 0), axis=(0, 0, 1))
    detent = sr.RSDA("detent", sr.ground, disc, point=(0, 0, 0), axis=(0, 0, 1), k=law)
    turned = sr.simulate(sr.System(sr.Model("disc", [disc], [pin], [detent])), until=7.5)
    assert turned["disc"].angular_velocity_global[-1, 2] == pytest.approx(np.sqrt(25 - 2 * work), abs=1e-6)
    rod = sr.Body("rod", mass=1, inertia=(1, 1, 1), position=(1, 0, 0), velocity=(5.0, 0, 0))
    catch = sr.TSDA("catch", sr.ground.point(0, 0, 0), rod.point(0, 0, 0), k=law, c=0, length=0)
    pulled = sr.simulate(sr.System(sr.Model("rod", [rod], forces=[catch])), until=7.5)
    assert pulled["rod"].velocity[-1, 0] == pytest.approx(np.sqrt(25 - 2 * work), abs=1e-6)


def test_a_detent_that_is_reached_and_left_within_a_step() -> None:
    """A mass that is thrown from x = 2 to x = 1 and falls back, with a constant force: one step would do."""
    x = np.concatenate([[0, 0.5], 1 + np.arange(-0.03, 0.03, 0.001), [2, 3]])
    law = np.array([x, 10 * np.exp(-(((x - 1) / 0.005) ** 2))]).T.tolist()
    mass = sr.Body("mass", mass=1, inertia=(1, 1, 1), position=(2, 0, 0), velocity=(-2, 0, 0))
    guide = sr.Translational("guide", sr.ground, mass, point=(0, 0, 0), axis=(1, 0, 0))
    push = sr.Force("push", joint="guide", value=2.0)
    detent = sr.TSDA("detent", sr.ground.point(0, 0, 0), mass.point(0, 0, 0), k=law, c=0, length=0)
    system = sr.System(sr.Model("detent", [mass], [guide], [push, detent]))
    found, wanted = (
        sr.simulate(system, until=1.9, t_eval=[1.9], **more)["mass.x"][0]
        for more in ({}, {"method": sr.Radau(max_step=1e-3)})
    )
    assert abs(wanted - 1.81) > 0.1
    assert found == pytest.approx(wanted, abs=1e-6)


def test_a_periodic_table_of_many_periods() -> None:
    """A washboard after a plane: no step passes over a wave."""
    x = np.linspace(0, 0.2, 21)
    wave = sr.Curve.table(np.array([x, 1e-4 * np.cos(10 * np.pi * x)]).T.tolist(), periodic=True)
    found, wanted = (heights(wheel(wave), **given) for given in ({}, {"method": sr.Radau(max_step=1e-3)}))
    assert np.ptp(wanted) > 2e-5
    assert found == pytest.approx(wanted, rel=0, abs=1e-8)


def test_a_fine_table_of_a_smooth_law_needs_no_more_steps() -> None:
    x = np.linspace(-3, 3, 1001)
    mass = sr.Body("mass", mass=1, inertia=(1, 1, 1), position=(1, 0, 0))
    guide = sr.Translational("guide", sr.ground, mass, point=(0, 0, 0), axis=(1, 0, 0))
    runs = []
    for k in (np.array([x, 10 + x**2]).T.tolist(), "10 + x^2"):
        spring = sr.TSDA("spring", sr.ground.point(-2, 0, 0), mass.point(0, 0, 0), k=k, c=0, length=2)
        runs.append(sr.simulate(sr.System(sr.Model("fine", [mass], [guide], [spring])), until=5.0))
    assert runs[0].nsteps < 1.1 * runs[1].nsteps


def test_what_is_kept_and_resumed_has_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Saved where the bump has been passed and where it has not."""
    monkeypatch.setattr(recording, "PAUSE", 0.0)
    monkeypatch.setattr(recording, "PATIENT", 0.0)
    monkeypatch.setattr(time_loop, "CHUNK", 16)
    system, given = wheel(bell(0.2)), {"until": 6.0, "t_eval": np.linspace(0, 6, 61)}
    stretches = list[float]()
    plain = sr.simulate(system, progress=stretches.append, **given)
    for count in range(1, len(stretches), 4):
        calls = list[float]()

        def stop(t: float, calls: list[float] = calls, count: int = count) -> None:
            calls.append(t)
            if len(calls) > count:
                raise KeyboardInterrupt

        folder = tmp_path / f"run{count}"
        assert sr.simulate(system, save=folder, progress=stop, **given).status == "stopped"
        resumed = sr.resume(folder)
        assert np.array_equal(resumed.q, plain.q), count
        assert resumed.nsteps == plain.nsteps
