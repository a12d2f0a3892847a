"""Gradients of models with states: direct and adjoint, and differences of whole runs."""

from collections.abc import Sequence

import numpy as np
from tests.states.motors import TIGHT, value

import sarrus as sr
from sarrus.model.written import with_numbers, written_numbers


def direct_and_adjoint(
    model: sr.Model, output: str, names: Sequence[str], until: float, rtol: float
) -> list[np.ndarray]:
    """Both gradients of the final value of an output."""
    run = sr.simulate(sr.System(model), until=until, store="steps", method=sr.Radau(rtol=rtol))
    found = (sr.sensitivity(run, sr.Final(output), wrt=names, method=how) for how in ("direct", "adjoint"))
    return [np.array([gradient[name] for name in names]) for gradient in found]


def differences(
    model: sr.Model, output: str, names: Sequence[str], until: float, change: float
) -> list[float]:
    """The same by central differences of runs, by a relative change of each number."""
    numbers, found = written_numbers(model), list[float]()
    for name in names:
        h = change * numbers[name]
        models = [with_numbers(model, {name: numbers[name] + s * h}) for s in (-1, 1)]
        low, high = (value(sr.simulate(sr.System(one), until=until, **TIGHT), output)[-1] for one in models)
        found.append((high - low) / (2 * h))
    return found
