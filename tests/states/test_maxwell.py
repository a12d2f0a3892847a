"""Maxwell elements, against closed forms and SciPy on the reduced equations."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.states.gradients import differences, direct_and_adjoint
from tests.states.motors import TIGHT, value

import sarrus as sr
from sarrus.model import ModelError

K, C, MASS = 200.0, 15.0, 2.0
NAMES = ["buffer.k", "buffer.c", "buffer.initial"]


def slider(*forces: Any, speed: float = 0.5) -> sr.Model:
    """A mass on a slide along x, a metre from a wall."""
    body = sr.Body("cart", mass=MASS, inertia=(0.1, 0.1, 0.1), position=(1, 0, 0), velocity=(speed, 0, 0))
    slide = sr.Translational("slide", sr.ground, body, point=(1, 0, 0), axis=(1, 0, 0))
    return sr.Model("slider", [body], [slide], list(forces))


def ends(model: sr.Model) -> dict[str, Any]:
    """Its wall, and its cart."""
    return {"point_i": sr.ground.point(0, 0, 0), "point_j": model.bodies[0].point(0, 0, 0)}


def buffered(**given: Any) -> sr.Model:
    """With a Maxwell element on the joint, or between points."""
    return slider(sr.Maxwell("buffer", **({"joint": "slide"} | given), k=K, c=C, initial=3.0))


def by_hand(t: float) -> Any:
    """Displacement, speed and tension."""

    def rates(t: float, y: Any) -> list[float]:
        return [y[1], -y[2] / MASS, K * (y[1] - y[2] / C)]

    return solve_ivp(rates, (0, t), [0, 0.5, 3.0], "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


@pytest.mark.parametrize("between", ["joint", "points"])
def test_a_mass_on_a_maxwell_element_follows_its_reduced_equations(between: str) -> None:
    given = {"joint": None, **ends(slider())} if between == "points" else {}
    run = sr.simulate(sr.System(buffered(**given)), until=0.7, **TIGHT)
    found = [value(run, name)[-1] for name in ("slide.displacement", "cart.velocity.x", "buffer.tension")]
    assert found == pytest.approx(by_hand(0.7), abs=1e-8)
    assert value(run, "buffer.value") == pytest.approx(-value(run, "buffer.tension"), rel=1e-14)


def test_the_tension_relaxes_with_the_time_c_over_k() -> None:
    """The ends are held: F = F₀ exp(-k t/c)."""
    model = buffered()
    drive = sr.DisplacementDriver("hold", "slide", 0.0)
    still = sr.Model("held", slider(speed=0.0).bodies, model.joints, model.forces, drivers=[drive])
    run = sr.simulate(sr.System(still), until=0.3, **TIGHT)
    assert value(run, "buffer.tension")[-1] == pytest.approx(3 * np.exp(-K * 0.3 / C), abs=1e-9)


def test_its_complex_stiffness() -> None:
    """Its complex stiffness is i ω c k / (k + i ω c); the transient from no tension decays with exp(-k t/c)."""
    for omega in (0.5 * K / C, 5 * K / C):
        model = slider(sr.Maxwell("buffer", "slide", k=K, c=C), speed=0.01 * omega)
        drive = sr.DisplacementDriver("shake", "slide", f"0.01*sin({omega!r}*t)")
        system = sr.System(sr.Model("shaken", model.bodies, model.joints, model.forces, drivers=[drive]))
        run = sr.simulate(system, until=0.5, **TIGHT)
        stiffness = 1j * omega * C * K / (K + 1j * omega * C)
        steady = (0.01 * stiffness * np.exp(1j * omega * 0.5)).imag
        start = (0.01 * stiffness).imag * np.exp(-K * 0.5 / C)
        assert value(run, "buffer.tension")[-1] == pytest.approx(steady - start, abs=1e-8)


def test_gradients_are_differences_of_runs_and_direct_is_adjoint() -> None:
    place = buffered(), "slide.displacement", NAMES, 0.4
    direct, adjoint = direct_and_adjoint(*place, rtol=1e-10)
    assert direct == pytest.approx(adjoint, rel=1e-9)
    for name, one, wanted in zip(NAMES, direct, differences(*place, 1e-3), strict=True):
        assert one == pytest.approx(wanted, rel=1e-5), name


def test_an_equilibrium_has_no_tension() -> None:
    rest = sr.equilibrium(
        sr.System(slider(sr.Maxwell("buffer", "slide", k=K, c=C), sr.Force("spring", "slide", value="1-9*x")))
    )
    assert rest.success
    assert abs(rest["buffer.tension"]) < 1e-9


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"joint": "slide", "k": 0.0, "c": 1.0}, "k must be greater than 0"),
        ({"joint": "slide", "k": 1.0, "c": 0.0}, "c must be greater than 0"),
        ({"k": 1.0, "c": 1.0}, "its place is missing"),
        ({"joint": "slid", "k": 1.0, "c": 1.0}, 'there is no joint "slid"'),
    ],
)
def test_wrong_elements_are_refused(given: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        sr.System(slider(sr.Maxwell("buffer", **given)))
