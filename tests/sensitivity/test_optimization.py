"""Designs and fitted parameters: a published optimum, constraints, measurements with noise, what data cannot tell."""

import numpy as np
import pytest
from tests.sensitivity.designs import sundials_crank
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.model.written import with_numbers

LOOSE = {"rtol": 1e-5, "atol": 1e-7}


def penalized(o: object) -> object:
    k, c = o.parameter("spring.k"), o.parameter("spring.c")
    return o("energy.kinetic") + 0.05 * ((k - 1) ** 2 + (c - 1) ** 2)  # over 10 s


@pytest.mark.parametrize("solver", ["L-BFGS-B", "trust-constr"])
def test_the_optimum_of_the_published_slider_crank(solver: str) -> None:
    """Its minimum is k = 0.6826136, c = 1.3357019, 3.2227612; the method's error moves it a little."""
    found = sr.optimize(
        sundials_crank(), sr.Integral(penalized), ["spring.k", "spring.c"], until=10.0, solver=solver, **LOOSE
    )
    assert found.x == pytest.approx([0.6826136, 1.3357019], abs=5e-3)
    assert found.value == pytest.approx(3.2227612, abs=5e-3)
    assert found.value < found.value0
    assert len(found.history) == len(found.trace) < 30
    assert found.history[-1, 1] < 1e-2 * found.history[0, 1]
    assert found.model.forces[0].k == pytest.approx(found["spring.k"])
    assert "spring.k" in str(found)


def test_constraints_and_bounds_hold() -> None:
    limit = sr.Within(sr.Final("slider.velocity.x", name="last"), upper=-1.0)
    bounds = {"spring.k": (5.0, 40.0), "spring.c": (0.5, 5.0)}
    effort = sr.Integral(lambda o: o("slider.velocity.x") ** 2)
    found = sr.optimize(
        slider_crank(), effort, [*bounds], until=1.0, bounds=bounds, constraints=[limit], **LOOSE
    )
    assert found.constraints["last"] == pytest.approx(-1.0, abs=1e-5)
    assert found.value < found.value0 - 0.05
    for name, (low, high) in bounds.items():
        assert low - 1e-9 <= found[name] <= high + 1e-9


NAMES = ["spring.k", "spring.c", "rod.mass"]
TIMES = np.linspace(0.05, 1.5, 30)


def measured(noise: float) -> sr.Misfit:
    """The slider's path with the model's own numbers, and noise."""
    run = sr.simulate(slider_crank(), until=1.5, t_eval=TIMES, rtol=1e-7, atol=1e-9)
    data = run["slider"].position[:, 0] + noise * np.random.default_rng(0).normal(size=len(TIMES))
    return sr.Misfit("slider.x", at=tuple(TIMES), data=tuple(data), sigma=noise)


def guessed(**numbers: float) -> sr.System:
    wrong = {"spring.k": 14.0, "spring.c": 0.6, "rod.mass": 1.3} | numbers
    return sr.System(with_numbers(slider_crank().model, wrong))


def test_parameters_are_recovered_from_measurements_with_noise() -> None:
    found = sr.fit(guessed(), measured(1e-3), NAMES, **LOOSE)
    assert found.success
    assert 5 < found.value < 30  # half of the sum of 30 squares less 3
    assert not found.poor
    for name, true in zip(NAMES, (10.0, 1.0, 1.0), strict=True):
        low, high = found.interval(name)
        width = high - low
        assert low - width < true < high + width
        assert 0 < width < true
    assert "95 % interval" in str(found)


def test_what_the_data_cannot_tell_is_named() -> None:
    """Stiffness and actuator of a spring whose length hardly changes."""
    body = sr.Body("mass", mass=1.0, inertia=(1, 1, 1), position=(1.0, 0, 0), velocity=(1.0, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=2.0, length=0.5, force=0.3)
    system = sr.System(sr.Model("mass", bodies=[body], forces=[spring]))
    times = np.linspace(0.1, 1.0, 10)
    data = 1 + times - 0.6 * times**2
    misfit = sr.Misfit("mass.x", at=tuple(times), data=tuple(data), sigma=1e-3)
    found = sr.fit(system, misfit, ["spring.length", "spring.force"], **LOOSE)
    assert len(found.poor) == 1
    assert "spring.length" in found.poor[0]
    assert "hardly determined" in str(found)


def test_bounds_of_unknown_variables_are_refused() -> None:
    with pytest.raises(ValueError, match="no design variable"):
        sr.optimize(slider_crank(), "slider.x", ["spring.k"], until=0.1, bounds={"spring.c": (0, 1)})
