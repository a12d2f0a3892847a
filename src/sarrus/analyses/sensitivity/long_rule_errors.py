"""Sampling errors of responses of a long run: their values minus those with twice as many samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from .long_gradient import LongGradient, Samples
from .long_run import LongRun
from .parameters.parameters import Parameters
from .responses.kinks import Layout, Steps, layout
from .responses.panels import LOBATTO, TRAPEZOIDAL
from .responses.resolution import every_step, unused
from .responses.responses import Response
from .responses.within_steps import Fine, at_nodes

# Error over the difference: of Lobatto's rule, and of the trapezoidal one
OF_VALUE = {True: 1.0, False: 4 / 3}


class Halves(NamedTuple):
    """Numbers of the responses over the whole run, their errors over the differences, times, and gradient."""

    which: list[int]
    factors: Array
    responses: list[Response]
    samples: list[Samples]
    gradient: LongGradient

    @classmethod
    def of(cls, run: LongRun, responses: Sequence[Response], parameters: Parameters) -> Halves:
        """Those with twice as many samples."""
        whole = [(r, one) for r, one in enumerate(responses) if not one.pointwise]
        fine = [isinstance(one, Fine) for _, one in whole]
        layouts = [_halves(run, own) for own in fine]
        pairs = zip((at_nodes(one) for _, one in whole), layouts, strict=True)
        finer = [replace(one, name=one.title, reported=True, panels=own.panels) for one, own in pairs]
        samples = [Samples(run, own.where) for own in layouts]
        gradient = LongGradient(run, finer, parameters, samples)
        return cls([r for r, _ in whole], np.array([OF_VALUE[own] for own in fine]), finer, samples, gradient)


def rule_errors(run: LongRun, responses: Sequence[Response], parameters: Parameters, values: Array) -> Array:
    """Those of all responses (k,), by one sweep forwards; see `Evaluation.rule_error`."""
    found, halves = np.zeros(len(responses)), Halves.of(run, responses, parameters)
    if halves.which:
        each = zip(halves.responses, halves.gradient.signals(), halves.samples, strict=True)
        finer = np.array([one.value(g, at.where.t) for one, g, at in each])
        found[halves.which] = halves.factors * (values[halves.which] - finer)
    return found


def _halves(run: LongRun, fine: bool) -> Layout:
    """The halves of all steps."""
    steps = Steps.of(run.course)
    return layout(steps, every_step(len(steps.end)).halves(), unused, LOBATTO if fine else TRAPEZOIDAL)
