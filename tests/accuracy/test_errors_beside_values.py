"""Searches, fits and studies report the estimated error of what they found."""

import numpy as np
import pytest

import sarrus as sr

UNTIL, MASS = 2.0, 1.5


def oscillator(k: float = 40.0) -> sr.System:
    """A mass on a spring along x, released from 1 m."""
    body = sr.Body("b", mass=MASS, inertia=(1, 1, 1), position=(1.0, 0, 0))
    slide = sr.Translational("slide", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=k, length=0.0)
    return sr.System(sr.Model("oscillator", [body], [slide], [spring]))


def position(k: float, t: float = UNTIL) -> float:
    """The closed form."""
    return float(np.cos(np.sqrt(k / MASS) * t))


COARSE = {"method": sr.HHT(alpha=0.0, rtol=1e-5)}


def test_the_error_of_an_optimum() -> None:
    """The least of (x - 0.3)² by the stiffness where a bound holds it: off by the error of the run."""
    goal = sr.Combined(lambda x: (x - 0.3) ** 2, [sr.Final("b.x")], name="distance")
    with pytest.warns(sr.SarrusWarning, match="outside of its bounds"):
        found = sr.optimize(
            oscillator(), goal, ["spring.k"], until=UNTIL, bounds={"spring.k": (41, 42)}, **COARSE
        )
    truth = abs(found.value - (position(found["spring.k"]) - 0.3) ** 2)
    assert truth > 1e-7
    assert found.error == pytest.approx(truth, rel=0.3)
    assert f"± {found.error:.0e}" in found.table()


def test_the_error_of_a_fit() -> None:
    times = np.linspace(0.2, UNTIL, 10)
    data = [position(43.0, t) + 0.01 * (-1) ** n for n, t in enumerate(times)]
    misfit = sr.Misfit("b.x", at=times, data=data, sigma=0.01)
    found = sr.fit(oscillator(), misfit, ["spring.k"], method=sr.HHT(alpha=0.0, rtol=1e-8))
    exact = [position(found["spring.k"], t) for t in times]
    truth = abs(found.value - 0.5 * np.sum(((np.array(exact) - data) / 0.01) ** 2))
    assert found.error == pytest.approx(truth, rel=0.5)


def test_no_error_without_stored_steps() -> None:
    given = {"until": 0.5, "bounds": {"spring.k": (39, 41)}, "memory": 1e8}
    found = sr.optimize(oscillator(), sr.Final("b.x"), ["spring.k"], **given)
    assert np.isnan(found.error)
    assert "±" not in found.table()


def test_errors_are_responses_of_studies() -> None:
    """Of a reduction, and of a formula of reductions; each that of the closed form."""
    wanted = {"end": "b.x", "its error": "error(b.x)", "of the square": "2*error(final(b.x)^2 + 1)"}
    run = sr.Simulation(until=UNTIL, **COARSE)
    table = sr.study(oscillator(), {"spring.k": [38.0, 40.0, 42.0]}, wanted, analysis=run)
    assert table.success.all(), table.messages
    for k, x, error, squared in zip(*(table[name] for name in ("spring.k", *wanted)), strict=True):
        assert error == pytest.approx(abs(x - position(k)), rel=0.3)
        assert squared == pytest.approx(4 * abs(x) * error, rel=1e-6)


def test_errors_of_what_is_no_simulation_are_refused() -> None:
    table = sr.study(oscillator(), {"spring.k": [38.0, 40.0]}, {"error": "error(b.x)"}, analysis=sr.Statics())
    assert not table.success.any()
    assert "errors are estimated of simulations. Leave error() out." in table.messages[0]
