"""LuGre friction, against SciPy on the reduced equations and against closed forms."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.states.gradients import differences, direct_and_adjoint
from tests.states.motors import INERTIA, TIGHT, WEIGHT, arm, value
from tests.states.test_maxwell import MASS, slider

import sarrus as sr
from sarrus.model import ModelError

GIVEN: dict[str, Any] = {
    "load": 20.0,
    "mu": 0.2,
    "mu_static": 0.3,
    "stiffness": 4e3,
    "damping": 20.0,
    "stribeck": 0.05,
    "viscous": 0.6,
    "creep": 1e-3,
}
PULL = "8*sin(5*t)"


def friction(u: Any, z: Any) -> tuple[Any, Any]:
    """Rate of the deflection, and force."""
    g = 20 * (0.2 + 0.1 * np.exp(-((u / 0.05) ** 2)))
    slope = u - 4e3 * z * np.hypot(u, 1e-3) / g
    return slope, 4e3 * z + 20 * slope + 0.6 * u


def pulled(force: Any = PULL, speed: float = 0.0, **changes: Any) -> sr.Model:
    """A mass on a slide with friction, pulled back and forth through presliding and sliding."""
    parts = sr.LuGre("rub", joint="slide", **(GIVEN | changes)), sr.Force("pull", "slide", value=force)
    return slider(*parts, speed=speed)


def by_hand(rates: Any, until: float, start: Any) -> Any:
    """The last of the solution."""
    return solve_ivp(rates, (0, until), start, "Radau", rtol=1e-12, atol=1e-14).y[:, -1]


def test_stick_slip_on_a_slide_follows_its_reduced_equations() -> None:
    def rates(t: float, y: Any) -> list[float]:
        slope, force = friction(y[1], y[2])
        return [y[1], (8 * np.sin(5 * t) - force) / MASS, slope]

    run = sr.simulate(sr.System(pulled()), until=1.0, **TIGHT)
    y = by_hand(rates, 1.0, [0, 0, 0])
    found = [value(run, name)[-1] for name in ("slide.displacement", "cart.velocity.x", "rub.deflection")]
    assert found == pytest.approx(y, abs=1e-8)
    assert value(run, "rub.value")[-1] == pytest.approx(-friction(y[1], y[2])[1], rel=1e-8)
    assert abs(value(run, "cart.velocity.x")).max() > 0.1


def test_friction_of_a_pin_follows_its_reduced_equations() -> None:
    def rates(t: float, y: Any) -> list[float]:
        slope, force = friction(0.3 * y[1], y[2])
        return [y[1], (-WEIGHT * np.cos(y[0]) - 0.3 * force) / INERTIA, slope]

    run = sr.simulate(sr.System(arm(sr.LuGre("rub", joint="pin", radius=0.3, **GIVEN))), until=0.8, **TIGHT)
    found = [value(run, name)[-1] for name in ("pin.angle", "pin.angle.rate", "rub.deflection")]
    assert found == pytest.approx(by_hand(rates, 0.8, [0, 0, 0]), abs=1e-8)
    assert run.output("rub.value").unit == "N m"


def test_presliding_has_the_stiffness_of_the_bristles() -> None:
    """The frequency of a small motion is √(stiffness / m): without damping it returns after half a period."""
    changes = {"damping": 0.0, "viscous": 0.0, "creep": 1e-9}
    speed, half = 1e-5, np.pi / np.sqrt(4e3 / MASS)
    run = sr.simulate(sr.System(pulled(0.0, speed, **changes)), until=half, **TIGHT)
    assert value(run, "cart.velocity.x")[-1] == pytest.approx(-speed, rel=1e-3)
    assert abs(value(run, "slide.displacement")[-1]) < 1e-3 * speed * half


@pytest.mark.parametrize("speed", [0.02, 0.3])
def test_steady_sliding_is_on_the_stribeck_curve(speed: float) -> None:
    """The deflection relaxes over the distance g/stiffness; s/|u| is the rounding."""
    model = pulled(0.0, speed)
    drive = sr.DisplacementDriver("draw", "slide", f"{speed}*t")
    run = sr.simulate(
        sr.System(sr.Model("drawn", model.bodies, model.joints, model.forces, drivers=[drive])), until=2.0
    )
    curve = 20 * (0.2 + 0.1 * np.exp(-((speed / 0.05) ** 2))) * speed / np.hypot(speed, 1e-3)
    assert value(run, "rub.value")[-1] == pytest.approx(-curve - 0.6 * speed, rel=1e-6)


def test_what_sticks_creeps_as_slowly_as_stated() -> None:
    """Of a force F below g, at creep · F / √(g² - F²), whatever the other numbers are."""
    run = sr.simulate(
        sr.System(pulled(3.0, viscous=0.0, stribeck=1.0)), until=12.0, method=sr.Radau(rtol=1e-9)
    )
    assert value(run, "cart.velocity.x")[-1] == pytest.approx(1e-3 * 3 / np.sqrt(36 - 9), rel=1e-3)


NAMES = [f"rub.{field}" for field in GIVEN]


@pytest.mark.slow
def test_gradients_are_differences_of_runs_and_direct_is_adjoint() -> None:
    place = pulled(), "slide.displacement", NAMES, 0.6
    direct, adjoint = direct_and_adjoint(*place, rtol=1e-11)
    assert direct == pytest.approx(adjoint, rel=1e-8, abs=1e-14)
    for name, one, wanted in zip(NAMES, direct, differences(*place, 1e-4), strict=True):
        assert one == pytest.approx(wanted, rel=1e-4), name


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"joint": "pin"}, "radius is missing, which the angle of pin needs"),
        ({"joint": "pin", "radius": 0.1, "load": 0.0}, "load must be greater than 0"),
        ({"joint": "pin", "radius": 0.1, "creep": 0.0}, "creep must be greater than 0"),
        ({"joint": "pin", "radius": 0.1, "damping": -1.0}, "damping must not be negative"),
    ],
)
def test_wrong_friction_is_refused(changes: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        sr.System(arm(sr.LuGre("rub", **(GIVEN | changes))))


def test_a_radius_is_for_angles() -> None:
    with pytest.raises(ModelError, match="radius is for an angle"):
        sr.System(pulled(radius=0.1))
