"""Responses that no design has are refused before the first simulation."""

from collections.abc import Callable
from typing import Any

import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.optimization import point


@pytest.fixture(scope="module")
def system() -> sr.System:
    return sr.System(sr.load(mechanisms.path("slider_crank")))


def optimized(system: sr.System, objective: Any, constraints: Any = ()) -> sr.Optimum:
    return sr.optimize(system, objective, ["spring.k"], until=0.1, constraints=constraints)


WRONG: dict[str, tuple[Callable[[sr.System], Any], str]] = {
    "objective": (lambda s: optimized(s, sr.Final("slidr.x")), 'Did you mean "slider.x"'),
    "combined": (lambda s: optimized(s, sr.Combined(lambda x: x**2, ["slidr.x"])), 'Did you mean "slider.x"'),
    "constraint": (
        lambda s: optimized(s, sr.Final("slider.x"), [sr.Within(sr.Final("slidr.x"), upper=5)]),
        'Did you mean "slider.x"',
    ),
    "late": (
        lambda s: optimized(s, sr.At("slider.x", time=0.2)),
        r"at 0.2 s: times must be between 0 and 0.1 s, .* but one is 0.2 s",
    ),
    "early": (
        lambda s: optimized(s, sr.At("slider.x", time=-0.2)),
        "times must be between 0 and 0.1 s, .* but one is -0.2 s",
    ),
    "misfit": (
        lambda s: sr.fit(s, sr.Misfit("slidr.x", at=[0.05], data=[4.0]), ["spring.k"]),
        'Did you mean "slider.x"',
    ),
    "late data": (
        lambda s: sr.fit(s, sr.Misfit("slider.x", at=[0.2], data=[4.0]), ["spring.k"], until=0.1),
        "times must be between 0 and 0.1 s",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_no_simulation_is_run(case: str, system: sr.System, monkeypatch: pytest.MonkeyPatch) -> None:
    def simulate(*given: Any, **more: Any) -> Any:
        raise AssertionError("simulated")

    monkeypatch.setattr(point, "simulate", simulate)
    call, words = WRONG[case]
    with pytest.raises(sr.SarrusError, match=words):
        call(system)
