"""Wrong options of searches, fits and studies: one message with the remedy, and nothing wrong without one."""

from functools import cache
from typing import Any

import numpy as np
import pytest

import sarrus as sr


@cache
def oscillator() -> sr.System:
    mass = sr.Body("mass", 2.0, (1, 1, 1), position=(0.5, 0, 0))
    rail = sr.Prismatic("rail", sr.ground, mass, point=(0.5, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), mass.point(0, 0, 0), k=100.0, c=2.0, length=0.3)
    return sr.System(sr.Model("oscillator", [mass], [rail], [spring]))


def optimize(**options: Any) -> Any:
    return sr.optimize(oscillator(), "mass.x", ["spring.k"], until=0.1, progress=False, **options)


def fit(**options: Any) -> Any:
    misfit = sr.Misfit("mass.x", at=(0.1,), data=(0.4,))
    return sr.fit(oscillator(), misfit, ["spring.k"], until=0.1, progress=False, **options)


def study(responses: Any = "mass.x", **options: Any) -> Any:
    options = {"analysis": sr.Simulation(until=0.1), "workers": 1, "progress": False} | options
    return sr.study(oscillator(), {"spring.k": [50.0, 100.0]}, responses, **options)


MISTAKES: dict[str, tuple[Any, type[Exception], str]] = {
    "constraint": (lambda: optimize(constraints=5), TypeError, "constraints: 5 is no constraint. Give Within"),
    "constraint as text": (lambda: optimize(constraints="mass.x<1"), TypeError, "'mass.x<1' is no constraint"),
    "limit": (lambda: sr.Within("mass.x", "<", 1), TypeError, "lower limit of a constraint must be a number"),  # type: ignore[arg-type]
    "limit nan": (lambda: sr.Within("mass.x", np.nan, 1), sr.ModelError, "must be a finite number, but is nan"),
    "no response": (lambda: sr.Within(), TypeError, "Within: response is missing"),  # type: ignore[call-arg]
    "events": (lambda: optimize(events="x"), TypeError, "events must be a sarrus.Event, a time"),
    "bound nan": (lambda: optimize(bounds={"spring.k": (np.nan, 1)}), sr.ModelError, "a bound of spring.k must be a"),
    "scale": (lambda: optimize(scale={"spring.k": np.inf}), sr.ModelError, "the scale of spring.k must be a positive"),
    "executor": (lambda: optimize(executor=5), TypeError, "executor must be an executor of concurrent.futures"),
    "noise": (lambda: fit(noise="x"), sr.ModelError, 'noise must be "given" or "estimated", but is "x"'),
    "no data": (lambda: sr.Misfit("mass.x", at=None, data=None), sr.ModelError, "its times must be finite numbers"),  # type: ignore[arg-type]
    "columns": (lambda: sr.Misfit("mass.x", at=(1, 2), data=np.ones((2, 1))), ValueError, r"its data \(2, 1\). Give"),  # type: ignore[arg-type]
    "field": (lambda: sr.Misfit("mass.x", sd=1), TypeError, 'Misfit has no argument "sd"'),  # type: ignore[call-arg]
    "twice": (lambda: study(["mass.x", "mass.x"]), sr.SarrusError, "two responses have the same name"),
    "executor of a study": (lambda: study(executor="x"), TypeError, "executor must be an executor"),
    "no end": (lambda: sr.Simulation(), TypeError, "Simulation: until is missing"),  # type: ignore[call-arg]
    "option": (lambda: sr.Simulation(until=1, methd=1), TypeError, 'no argument "methd". Did you mean "method"'),  # type: ignore[call-arg]
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_wrong_options_have_a_remedy(mistake: str) -> None:
    call, kind, message = MISTAKES[mistake]
    with pytest.raises(kind, match=message):
        call()


def test_tables_cannot_be_written() -> None:
    table = study()
    for array in (table.values, table.found, table["mass.x"]):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0.0
