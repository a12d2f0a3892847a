"""Errors of derivatives by the samples of responses over the whole run, such as integrals and extremes.

With twice as many samples derivatives are others, and the difference is their error, as for the value. That of a peak
between two samples is right to a higher order than its derivatives: these are taken at the vertex of a parabola, which
is not exactly where the peak is.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from .....algebra import Array
from .....results import Assembly
from ...parameters.parameters import Parameters
from .growth import WARNED, few
from .random_changes import comparable


def relative_sampling_errors(
    parameters: Parameters, found: Array, errors: Array, start: Assembly, until: float
) -> Array:
    """Relative errors of derivatives (k,) by their errors (k, p), of comparable changes of the parameters."""
    weights = comparable(parameters, found, start, until)
    error, sizes = (np.linalg.norm(own * weights, axis=1) for own in (errors, found))
    return np.asarray(np.divide(error, sizes, out=np.zeros_like(sizes), where=sizes > 0))


def warnings_of_samples(titles: Iterable[str], relative_errors: Array) -> Iterator[str]:
    """Return one message for each response whose derivatives have few digits."""
    for title, error in zip(titles, relative_errors, strict=True):
        if not error <= WARNED[1]:
            yield (
                f"{title}: its derivatives have {few(error)}, with a relative error of some {error:.0e}, as its "
                "samples are too far apart. Choose a smaller max_step, or smaller tolerances."
            )
