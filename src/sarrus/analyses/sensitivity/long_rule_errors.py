"""Sampling errors of responses of a long run: their values minus those with twice as many samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...algebra import Array
from .long_gradient import LongGradient, Samples
from .long_run import LongRun
from .moved_run import MovedRun
from .parameters.parameters import Parameters
from .responses.kinks import Layout, Steps, layout
from .responses.panels import LOBATTO, TRAPEZOIDAL
from .responses.resolution import every_step, unused
from .responses.responses import Response
from .responses.within_steps import Fine, at_nodes

OF_VALUE = {
    True: 1.0,
    False: 4 / 3,
}  # error over the difference: of Lobatto's rule, and of the trapezoidal one


def rule_errors(
    run: LongRun | MovedRun, responses: Sequence[Response], parameters: Parameters, values: Array
) -> Array:
    """Those of all responses (k,), by one sweep forwards; see `Evaluation.rule_error`."""
    found, whole = np.zeros(len(responses)), [r for r, one in enumerate(responses) if not one.pointwise]
    if not whole:
        return found
    fine = [isinstance(responses[r], Fine) for r in whole]
    layouts = [_halves(run, own) for own in fine]
    pairs = zip((at_nodes(responses[r]) for r in whole), layouts, strict=True)
    halved = [replace(one, name=one.title, reported=True, panels=own.panels) for one, own in pairs]
    signals = LongGradient(
        run, halved, parameters, samples=[Samples(run, own.where) for own in layouts]
    ).signals()
    for r, own, one, at, g in zip(whole, fine, halved, layouts, signals, strict=True):
        found[r] = OF_VALUE[own] * (values[r] - one.value(g, at.where.t))
    return found


def _halves(run: LongRun | MovedRun, fine: bool) -> Layout:
    """The halves of all steps."""
    steps = Steps.of(run.course)
    return layout(steps, every_step(len(steps.end)).halves(), unused, LOBATTO if fine else TRAPEZOIDAL)
