"""Bode plots of frequency responses."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...outputs.units import quotient
from ...results import FrequencyResponse
from .style import panels


def plot_frequency_response(
    response: FrequencyResponse, output: str | None = None, input: str | None = None, ax: Any = None
) -> Any:
    """Draw magnitude and phase of a frequency response over the frequency.

    Parameters
    ----------
    response : FrequencyResponse
    output, input : names; by default all pairs, one line each
    ax : two Matplotlib axes, for magnitude and phase, or a figure; by default a new one

    Returns
    -------
    Axes, two

    Raises
    ------
    KeyError
        If there is no such output or input.
    """
    outputs = response.outputs if output is None else (output,)
    inputs = response.inputs if input is None else (input,)
    magnitude, phase = panels(ax, 2, height=2.6)
    units = dict(zip(response.outputs, response.output_units, strict=True))
    units |= zip(response.inputs, response.input_units, strict=True)
    pairs = [(one, other) for one in outputs for other in inputs]
    for one, other in pairs:
        values = response.of(one, other)
        magnitude.loglog(response.frequencies, abs(values), label=f"{one} by {other}")
        phase.semilogx(response.frequencies, np.degrees(np.unwrap(np.angle(values))))
    every = {quotient(units[one], units[other]) for one, other in pairs}
    magnitude.set_ylabel(f"magnitude [{every.pop()}]" if len(every) == 1 else "magnitude")
    phase.set_ylabel("phase [°]")
    phase.set_xlabel("frequency [Hz]")
    magnitude.legend()
    return magnitude, phase
