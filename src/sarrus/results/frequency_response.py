"""Frequency responses of linear systems."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..algebra import Array
from ..deferred import renderer
from ..model.show import quote, suggest
from .result import Result


@dataclass(frozen=True, eq=False)
class FrequencyResponse(Result):
    """Complex amplitudes of outputs for sinusoidal inputs of amplitude 1.

    Attributes
    ----------
    name : of the system
    frequencies : (nf,) [Hz]
    values : (nf, ny, nu) complex, in units of the outputs over units of the inputs
    inputs, outputs, input_units, output_units : names and units
    """

    name: str
    frequencies: Array = field(repr=False)
    values: Array = field(repr=False)
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    input_units: tuple[str, ...] = field(repr=False)
    output_units: tuple[str, ...] = field(repr=False)

    def summary(self) -> str:
        """Number and range of the frequencies, with the names."""
        low, high = self.frequencies[[0, -1]]
        names = f"{', '.join(self.outputs)} by {', '.join(self.inputs)}"
        return f"{self.name}: response of {names} at {len(self.frequencies)} frequencies, {low:.3g} to {high:.3g} Hz"

    def of(self, output: str, input: str) -> Array:
        """Return the amplitudes (nf,) of one output for one input.

        Raises
        ------
        KeyError
            If there is no such output or input.
        """
        places = []
        for name, names in ((output, self.outputs), (input, self.inputs)):
            if name not in names:
                raise KeyError(
                    f"the frequency response has no {quote(str(name))}. {suggest(str(name), names)}"
                )
            places.append(names.index(name))
        return np.asarray(self.values[:, places[0], places[1]])

    def plot(self, output: str | None = None, input: str | None = None, ax: Any = None) -> Any:
        """Draw magnitude and phase over the frequency; see `sarrus.views.plot_frequency_response`."""
        return renderer().plot_frequency_response(self, output, input, ax)
