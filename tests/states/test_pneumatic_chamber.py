"""Pneumatic chambers, against closed forms and SciPy on the reduced equations."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.states.gradients import differences, direct_and_adjoint
from tests.states.motors import TIGHT, value
from tests.states.test_maxwell import MASS, ends, slider

import sarrus as sr
from sarrus.model import ModelError, SarrusWarning
from sarrus.model.written import with_numbers

BAR = 1e5
GIVEN: dict[str, Any] = {
    "area": 1e-3,
    "dead": 1e-5,
    "exponent": 1.2,
    "temperature": 300.0,
    "gas_constant": 290.0,
    "ambient": 1.1 * BAR,
    "initial": 2.0 * BAR,
}
FLOW = "k*(6e5 - gas.pressure)*sin(20*t)"
OUTPUTS = ("slide.displacement", "cart.velocity.x", "gas.pressure")


def filled(flow: Any = FLOW, between: bool = False, **changes: Any) -> sr.Model:
    """A mass on a slide with a spring and a damper, moved by a chamber."""
    place: dict[str, Any] = ends(slider()) if between else {"joint": "slide"}
    own = {"retracted": 0.85 if between else -0.15, "parameters": {"k": 4e-9}}
    gas = sr.PneumaticChamber("gas", **place, input=flow, **(GIVEN | own | changes))
    return slider(gas, sr.Force("load", "slide", value="-20*v - 2000*x"), speed=0.1)


def by_hand(until: float) -> Any:
    """Displacement, speed and pressure, which is in bar within."""

    def rates(t: float, y: Any) -> list[float]:
        x, v, p = y[0], y[1], BAR * y[2]
        flow = 4e-9 * (6e5 - p) * np.sin(20 * t)
        rate = 1.2 * (290 * 300 * flow - p * 1e-3 * v) / (1e-5 + 1e-3 * (x + 0.15))
        return [v, ((p - 1.1 * BAR) * 1e-3 - 20 * v - 2000 * x) / MASS, rate / BAR]

    y = solve_ivp(rates, (0, until), [0, 0.1, 2], "Radau", rtol=1e-12, atol=1e-13).y[:, -1]
    return y * [1, 1, BAR]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("between", [False, True])
def test_a_chamber_follows_its_reduced_equations(between: bool) -> None:
    run = sr.simulate(sr.System(filled(between=between)), until=0.5, **TIGHT)
    y = by_hand(0.5)
    found = [value(run, name)[-1] for name in OUTPUTS]
    assert found[:2] == pytest.approx(y[:2], abs=1e-8)
    assert found[2] == pytest.approx(y[2], rel=1e-8)
    assert value(run, "gas.value")[-1] == pytest.approx((y[2] - 1.1 * BAR) * 1e-3, rel=1e-8)


@pytest.mark.parametrize("exponent", [1.0, 1.4])
def test_a_closed_chamber_is_a_gas_spring(exponent: float) -> None:
    """The product p · V^exponent is constant, and the energy of mass, spring and gas, if nothing damps."""
    model = filled(0.0, exponent=exponent)
    still = sr.Model("spring", model.bodies, model.joints, model.forces[:1])
    run = sr.simulate(sr.System(still), until=0.5, t_eval=np.linspace(0, 0.5, 26), **TIGHT)
    volume = 1e-5 + 1e-3 * (value(run, "slide.displacement") + 0.15)
    p, speed = value(run, "gas.pressure"), value(run, "cart.velocity.x")
    assert p * volume**exponent == pytest.approx(2 * BAR * volume[0] ** exponent, rel=1e-9)
    within = -2 * BAR * volume[0] * np.log(volume) if exponent == 1.0 else p * volume / (exponent - 1)
    energy = within + 1.1 * BAR * volume + MASS / 2 * speed**2
    assert np.ptp(volume) > 0.1 * volume[0]
    assert energy == pytest.approx(energy[0], rel=1e-9)


def test_at_rest_a_leak_determines_the_pressure() -> None:
    rest = sr.equilibrium(sr.System(filled("1e-9*(3e5 - gas.pressure)")))
    assert rest.success
    assert rest["gas.pressure"] == pytest.approx(3 * BAR, rel=1e-9)
    assert rest["slide.displacement"] == pytest.approx(1.9 * BAR * 1e-3 / 2000, rel=1e-9)


def test_an_equilibrium_of_a_closed_chamber_warns_that_nothing_determines_the_pressure() -> None:
    with pytest.warns(SarrusWarning, match="no equation determines gas.pressure"):
        rest = sr.equilibrium(sr.System(filled(0.0)))
    assert rest["gas.pressure"] == pytest.approx(2 * BAR, rel=1e-9)


def test_a_held_isothermal_chamber_obeys_the_law_of_ideal_gases() -> None:
    """The mass that flows in is p V / (R T)."""
    model = filled("1e-4*t", exponent=1.0)
    drive = sr.DisplacementDriver("hold", "slide", 0.0)
    held = sr.Model("held", slider(speed=0.0).bodies, model.joints, model.forces, drivers=[drive])
    run = sr.simulate(sr.System(held), until=0.5, **TIGHT)
    added = (value(run, "gas.pressure")[-1] - 2 * BAR) * (1e-5 + 1e-3 * 0.15) / (290 * 300)
    assert added == pytest.approx(1e-4 * 0.5**2 / 2, rel=1e-9)


def test_a_volume_that_ends_ends_the_run() -> None:
    model = filled(0.0, initial=10.0, dead=1e-6, retracted=-0.01, ambient=40 * BAR)
    run = sr.simulate(sr.System(model), until=1.0)
    assert run.status == "not finite"
    assert "gas" in run.message


NAMES = [*(f"gas.{field}" for field in GIVEN), "gas.parameters.k"]


@pytest.mark.slow
def test_gradients_are_differences_of_runs_and_direct_is_adjoint() -> None:
    place = filled(), "slide.displacement", NAMES, 0.2
    direct, adjoint = direct_and_adjoint(*place, rtol=1e-11)
    assert direct == pytest.approx(adjoint, rel=1e-8)
    for name, one, wanted in zip(NAMES, direct, differences(*place, 1e-3), strict=True):
        assert one == pytest.approx(wanted, rel=1e-4), name


@pytest.mark.slow
def test_second_derivatives_are_differences_of_gradients() -> None:
    names, response = ["gas.area", "gas.exponent"], sr.Final("slide.displacement")

    def run(exponent: float) -> sr.Trajectory:
        model = with_numbers(filled(), {"gas.exponent": exponent})
        return sr.simulate(sr.System(model), until=0.1, store="steps", method=sr.Radau(rtol=1e-11))

    H, h = sr.hessian(run(1.2), response, wrt=names), 1e-4
    ahead, back = (sr.sensitivity(run(1.2 + s * h), response, wrt=names) for s in (1, -1))
    for name in names:
        assert H[name, "gas.exponent"] == pytest.approx((ahead[name] - back[name]) / (2 * h), rel=1e-5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"input": None}, "its input is missing"),
        ({"area": 0.0}, "area must be greater than 0"),
        ({"initial": -1.0}, "initial must be greater than 0"),
        ({"temperature": 0.0}, "temperature must be greater than 0"),
        ({"dead": 0.0}, "dead must be greater than 0"),
    ],
)
def test_wrong_chambers_are_refused(changes: Any, message: str) -> None:
    gas = sr.PneumaticChamber("gas", joint="slide", **(GIVEN | {"input": 0.0} | changes))
    with pytest.raises(ModelError, match=message):
        sr.System(slider(gas))
