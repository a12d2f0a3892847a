"""Uncertainty to first order: exact for linear responses, and what random samples converge to."""

import numpy as np
import pytest
from tests.studies import own

from sarrus.analyses import Radau
from sarrus.model import Model, SarrusError
from sarrus.studies import Distribution, LatinHypercube, Range, Simulation, Sobol, Statics, study, uncertainty

SPREADS = {
    "spring.k": Distribution("norm", {"loc": 10, "scale": 0.1}),
    "rod.mass": Distribution("norm", {"loc": 1, "scale": 0.02}),
    "spring.c": Range(0.9, 1.1),
}
RESPONSES = {
    "end": "slider.x",
    "top": "max(slider.velocity.x)",
    "mixed": "2*mean(slider.x) + final(crank.z)**2",
    "load": "rms(pin.force.z)",
    "work": "spring.k*integral(slider.velocity.x**2)",
    "at": "at(slider.x, 0.7) - initial(slider.x)",
}
RUN = Simulation(until=1.5, method=Radau(rtol=1e-7))


@pytest.mark.slow
def test_it_is_what_sampling_converges_to(model: Model) -> None:
    linear = uncertainty(model, SPREADS, RESPONSES, analysis=RUN)
    sampled = study(model, SPREADS, RESPONSES, analysis=RUN, sample=Sobol(64, 1), workers=1).statistics()
    for name, mean, std in zip(linear.responses, linear.values, linear.std, strict=True):
        assert mean == pytest.approx(sampled[name]["mean"], abs=0.1 * std)
        assert std == pytest.approx(sampled[name]["std"], rel=0.08)
    assert linear.shares.sum(axis=1) == pytest.approx(np.ones(6))
    assert "spring.k" in str(linear)


def test_a_linear_response_is_exact(model: Model) -> None:
    found = uncertainty(model, SPREADS, "3*spring.k + 0*slider.x - rod.mass", analysis=RUN)
    assert found.values == pytest.approx([29.0], rel=1e-12)
    assert found.std == pytest.approx([np.hypot(0.3, 0.02)], rel=1e-9)


def test_derivatives_are_those_of_the_runs(model: Model) -> None:
    """Histories so dense that a maximum is met well enough."""
    run = Simulation(until=1.5, steps=20_000, method=Radau(rtol=1e-9))
    exact = uncertainty(model, {"spring.k": Range(9.9, 10.1)}, RESPONSES, analysis=run)
    pair = study(model, {"spring.k": [9.99, 10.01]}, RESPONSES, analysis=run, workers=1)
    slopes = (pair.found[1] - pair.found[0]) / 0.02
    assert exact.matrix[:, 0] == pytest.approx(slopes, rel=1e-3)


@pytest.mark.parametrize(
    ("responses", "analysis", "told"),
    [
        ("max(slider.x)", Statics(), "is one state without a history"),
        ({"k": own.quick}, RUN, "response 'k' is a function"),
        ("max(slider.x - mean(slider.x))", RUN, "has a reduction in a reduction"),
        ("slider.w", RUN, "slider.w"),
    ],
)
def test_what_cannot_be_propagated(model: Model, responses: object, analysis: object, told: str) -> None:
    with pytest.raises((SarrusError, ValueError), match=told):
        uncertainty(model, SPREADS, responses, analysis=analysis)  # type: ignore[arg-type]


def test_moments_of_any_parameter(model: Model) -> None:
    kinds = {"spring.k": [9, 11], "spring.c": Range(0.5, 2, log=True)}
    found = uncertainty(model, kinds, "slider.x", analysis=RUN)
    wanted = LatinHypercube(4000).cases({"c": Range(0.5, 2, log=True)})[:, 0].std()
    assert found.deviations == pytest.approx([1.0, wanted], rel=1e-3)


def test_progress_and_a_time_limit_are_those_of_the_simulation(
    model: Model, capsys: pytest.CaptureFixture[str]
) -> None:
    uncertainty(model, SPREADS, RESPONSES, analysis=RUN, progress=True)
    assert "simulated" in capsys.readouterr().err
    with pytest.raises(SarrusError, match="time limit of"):
        uncertainty(model, SPREADS, RESPONSES, analysis=Simulation(until=1000.0), time_limit=0.01)
