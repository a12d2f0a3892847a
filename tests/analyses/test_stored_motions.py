"""A run that stores its steps takes those of the plain run bit for bit, wherever no force switches."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr

EXAMPLES = Path(__file__).parents[2] / "examples"
METHODS = {"Radau": sr.Radau(), "HHT": sr.HHT()}
FILES = {
    "double_pendulum": 1.0,
    "andrews": 0.02,
    "governor": 0.5,
    "heavy_top": 0.2,
    "spatial_slider_crank": 0.5,
    "car_axis": 1.0,
    "bricard": 1.0,
}


def cart(*forces: Any) -> sr.System:
    """A pendulum on a cart that a force drives."""
    cart = sr.Body("cart", 1.0, (1, 1, 1))
    arm = sr.Body("arm", 0.3, (0.01, 0.01, 0.01), position=(0.3, 0, -0.4))
    rail = sr.Translational("rail", sr.ground, cart, point=(0, 0, 0), axis=(1, 0, 0))
    pin = sr.Revolute("pin", cart, arm, point=(0, 0, 0), axis=(0, 1, 0))
    stop = sr.DisplacementStop(
        "stop", sr.ground, cart, point=(0, 0, 0), axis=(1, 0, 0), stiffness=1e6, upper=50.0, rounding=1e-3
    )
    return sr.System(sr.Model("cart", [cart, arm], [rail, pin], [*forces, stop], gravity=(0, 0, -9.81)))


def compare(system: sr.System, until: float, method: Any, make: Callable[[], dict[str, Any]] = dict) -> None:
    plain, stored = (
        sr.simulate(system, until=until, method=method, store="steps" if store else "samples", **make())
        for store in (False, True)
    )
    assert plain.success
    assert stored.success
    assert np.array_equal(plain.history, stored.history)
    for name in ("q", "v", "a", "lam"):
        assert np.array_equal(getattr(plain, name), getattr(stored, name)), name
    assert [event.t for event in plain.events] == [event.t for event in stored.events]


@pytest.mark.filterwarnings("ignore:.*assembly changed")
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", FILES)
def test_storing_steps_changes_no_motion(name: str, method: str) -> None:
    compare(sr.System(sr.load(EXAMPLES / f"{name}.yaml")), FILES[name], METHODS[method])


@pytest.mark.parametrize("method", METHODS)
def test_nor_where_equations_repeat_others_and_steps_are_looked_at_for_a_stop(method: str) -> None:
    model = sr.load(EXAMPLES / "bricard.yaml")
    ends = sr.ground.point(-50, 0, 0), model.bodies[0].point(0, 0, 0)
    stop = sr.LengthStop("stop", *ends, upper=100.0, stiffness=1e5, rounding=1e-3)
    compare(sr.System(replace(model, forces=[*model.forces, stop])), 2.0, METHODS[method])


@pytest.mark.parametrize("method", METHODS)
def test_nor_with_events_and_kinks_of_tables(method: str) -> None:
    load = sr.Force(
        "push",
        joint="rail",
        value=sr.Curve.table([(t, 5 * np.sin(9 * t)) for t in np.arange(0, 2, 0.1)]),
        over="t",
    )

    def events() -> dict[str, Any]:
        bounce = sr.Event("cart.x - 0.05", reset=sr.Impact(0.5))
        return {"events": [bounce, sr.Event("arm.velocity.x"), 0.77]}

    compare(cart(load), 1.5, METHODS[method], events)


@pytest.mark.parametrize("method", METHODS)
def test_nor_with_jumps_of_laws(method: str) -> None:
    load = sr.Force("push", joint="rail", value="2 - 3*step(t - 0.4)")
    compare(cart(load), 1.0, METHODS[method], lambda: {"events": [0.6]})


@pytest.mark.parametrize("method", METHODS)
def test_nor_with_controllers(method: str) -> None:
    def controllers() -> dict[str, Any]:
        def law(_: float, o: Any) -> dict[str, float]:
            return {"u": 5.0 * o["arm.angular_velocity.y"] - 2.0 * o["cart.x"]}

        return {"controllers": sr.Controller(law, period=0.05)}

    system = cart(sr.Force("push", joint="rail", value="u"), sr.Input("u"))
    compare(system, 1.0, METHODS[method], controllers)
